//! Sessions: recordings of a person on one day.
//!
//! A session is a part of a take's name: `s2-walk-5kmh` is of the second session. Takes without such
//! a prefix are of the first, so that names of recordings with one session stay as they are.

/// The most sessions of a synthetic person. Our choice.
pub const MOST_SESSIONS: usize = 9;

/// Returns the name of a take in a session, counted from 1.
#[must_use]
pub fn name_in_session(session: usize, take: &str) -> String {
    if session == 1 {
        return take.to_owned();
    }
    format!("s{session}-{take}")
}

/// Returns the session of a take, counted from 1.
#[must_use]
pub fn session_of(take: &str) -> usize {
    let number = take.strip_prefix('s').and_then(|rest| rest.split_once('-'));
    let number = number.filter(|(number, _)| number.bytes().all(|digit| digit.is_ascii_digit()));
    let number = number.and_then(|(number, _)| number.parse().ok());
    number.filter(|&number| number > 0).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_take_names_its_session() {
        for session in [1, 2, 12] {
            assert_eq!(session_of(&name_in_session(session, "walk-5kmh")), session);
        }
        for take in [
            "walk-5kmh",
            "s-1",
            "s0-a",
            "s2",
            "02-01",
            "s+2-a",
            "sx2-a",
            "",
        ] {
            assert_eq!(session_of(take), 1, "{take}");
        }
        assert_eq!(name_in_session(2, "walk-5kmh"), "s2-walk-5kmh");
    }
}
