//! Folders of numbered files: their natural order, and what is doubtful about it.

use crate::error::{Error, Result};
use std::cmp::Ordering;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

/// The least number of digits of a time in seconds since 1970, whose fraction follows a point.
const DIGITS_OF_SECONDS: usize = 10;

/// Lists what is in a folder in natural order: runs of digits in names count as numbers, so that
/// `9.png` comes before `10.png`, and `2_of_24.png` before `10_of_24.png`. Leaves out hidden files
/// and those that Windows adds.
///
/// # Errors
/// If the folder cannot be read.
pub(crate) fn numbered_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let io = |error| Error::io(folder, error);
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(io)? {
        let entry = entry.map_err(io)?;
        let name = entry.file_name();
        let is_hidden = name.as_encoded_bytes().starts_with(b".")
            || name == "Thumbs.db"
            || name == "desktop.ini";
        if !is_hidden {
            files.push(entry.path());
        }
    }
    files.sort_unstable_by(|a, b| {
        let (a, b) = (name(a), name(b));
        natural(a, b).then_with(|| a.cmp(b))
    });
    Ok(files)
}

/// Returns what is doubtful about the order of files that [`numbered_files`] lists, or about their
/// being evenly spaced in time: two with the same number, or gaps in the numbers.
pub(crate) fn doubts(files: &[PathBuf]) -> Option<String> {
    let shown = |at: usize| String::from_utf8_lossy(name(&files[at])).into_owned();
    let is_twin = |two: &[PathBuf]| natural(stem(&two[0]), stem(&two[1])).is_eq();
    if let Some(at) = files.windows(2).position(is_twin) {
        return Some(format!(
            "{} and {} have the same number (remove one, or rename them)",
            shown(at),
            shown(at + 1)
        ));
    }
    let numbers = frame_numbers(files)?;
    let steps = || numbers.windows(2).map(|two| two[1].abs_diff(two[0]));
    let mut sorted: Vec<u64> = steps().collect();
    sorted.sort_unstable();
    let usual = *sorted.get(sorted.len() / 2)?;
    // Numbers may be times, whose steps vary a little.
    let is_gap = |step: u64| step > usual.saturating_add(usual / 2);
    let first = steps().position(is_gap)?;
    let gaps = steps().filter(|&step| is_gap(step)).count();
    Some(format!(
        "the numbers of {} frames have gaps: {gaps}, the first between {} and {} (frames count as evenly spaced)",
        files.len(),
        shown(first),
        shown(first + 1)
    ))
}

/// Compares names by their runs of digits as numbers, and by bytes otherwise. Equal if they differ
/// only in leading zeros.
fn natural(a: &[u8], b: &[u8]) -> Ordering {
    let (mut left, mut right) = (a, b);
    let mut is_fraction = false;
    loop {
        match (left, right) {
            ([x, ..], [y, ..]) if x.is_ascii_digit() && y.is_ascii_digit() => {
                let (x, y) = (take_digits(&mut left), take_digits(&mut right));
                let (m, n) = (without_zeros(x), without_zeros(y));
                let order = if is_fraction {
                    x.cmp(y)
                } else {
                    m.len().cmp(&n.len()).then_with(|| m.cmp(n))
                };
                if order.is_ne() {
                    return order;
                }
                is_fraction = m.len() >= DIGITS_OF_SECONDS && left.first() == Some(&b'.');
            }
            ([x, x_rest @ ..], [y, y_rest @ ..]) => {
                if x != y {
                    return x.cmp(y);
                }
                is_fraction &= *x == b'.';
                (left, right) = (x_rest, y_rest);
            }
            _ => return left.len().cmp(&right.len()),
        }
    }
}

/// Takes the digits that a name begins with.
fn take_digits<'a>(name: &mut &'a [u8]) -> &'a [u8] {
    let end = name.iter().position(|byte| !byte.is_ascii_digit());
    let (digits, rest) = name.split_at(end.unwrap_or(name.len()));
    *name = rest;
    digits
}

fn without_zeros(digits: &[u8]) -> &[u8] {
    let zeros = digits.iter().take_while(|digit| **digit == b'0').count();
    &digits[zeros..]
}

/// Returns the only number that differs between names of the same form; none if there is no such
/// number.
fn frame_numbers(files: &[PathBuf]) -> Option<Vec<u64>> {
    let parted: Vec<(Vec<u8>, Vec<&[u8]>)> = files.iter().map(|file| parts(stem(file))).collect();
    let (form, first) = parted.first()?;
    let differs = |at: &usize| {
        let mut others = parted.iter();
        others.any(|(_, numbers)| numbers.get(*at) != first.get(*at))
    };
    let mut varying = (0..first.len()).filter(differs);
    let (Some(at), None) = (varying.next(), varying.next()) else {
        return None;
    };
    let number = |(own, numbers): &(Vec<u8>, Vec<&[u8]>)| {
        let digits = numbers.get(at).filter(|_| own == form)?;
        std::str::from_utf8(digits).ok()?.parse().ok()
    };
    parted.iter().map(number).collect()
}

/// Splits a name into its text, with a zero for each number, and the digits of its numbers.
fn parts(name: &[u8]) -> (Vec<u8>, Vec<&[u8]>) {
    let (mut text, mut numbers, mut rest) = (Vec::new(), Vec::new(), name);
    while let Some(&byte) = rest.first() {
        if byte.is_ascii_digit() {
            numbers.push(take_digits(&mut rest));
            text.push(b'0');
        } else {
            text.push(byte);
            rest = &rest[1..];
        }
    }
    (text, numbers)
}

fn name(file: &Path) -> &[u8] {
    file.file_name().map_or(&[], OsStr::as_encoded_bytes)
}

fn stem(file: &Path) -> &[u8] {
    file.file_stem().map_or(&[], OsStr::as_encoded_bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the names of files in their order, and the doubts about it.
    fn listed(names: &[&str]) -> (Vec<String>, Option<String>) {
        let folder = tempfile::tempdir().expect("a folder");
        for name in names {
            fs::write(folder.path().join(name), "").expect("written");
        }
        let files = numbered_files(folder.path()).expect("readable");
        let name = |path: &PathBuf| String::from_utf8_lossy(name(path)).into_owned();
        (files.iter().map(name).collect(), doubts(&files))
    }

    #[test]
    fn numbers_anywhere_in_names_are_compared_as_numbers() {
        for ordered in [
            &["1.png", "2.png", "9.png", "10.png", "11.png", "100.jpg"][..],
            &["1_of_24.png", "2_of_24.png", "10_of_24.png"],
            &[
                "frame-9-left.png",
                "frame-10-left.png",
                "frame-100-left.png",
            ],
            &["a9.png", "a10.png", "b1.png"],
            &["p2-8.png", "p2-9.png", "p2-10.png", "p10-1.png"],
            &["1.jpeg", "009.PNG", "010.png"],
            &["x.png", "x1.png", "xa.png"],
            // Beyond 64 bits.
            &[
                "99999999999999999998.png",
                "99999999999999999999.png",
                "100000000000000000000.png",
            ],
            // Times in seconds have fractions.
            &["1700000000.12.png", "1700000000.5.png", "1700000001.0.png"],
            &["s1.5.png", "s1.12.png"],
        ] {
            let mut shuffled = ordered.to_vec();
            shuffled.reverse();
            shuffled.extend([".hidden", "Thumbs.db"]);
            assert_eq!(listed(&shuffled).0, ordered);
        }
    }

    #[test]
    fn padded_numbers_keep_the_order_of_bytes() {
        let names: Vec<String> = (1..=120).map(|n| format!("001-nm-01-{n:03}.png")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        assert_eq!(
            listed(&names),
            (names.iter().map(ToString::to_string).collect(), None)
        );
    }

    #[test]
    fn the_same_number_twice_is_said() {
        for (names, said) in [
            (
                &["1.png", "01.png", "2.png"][..],
                "01.png and 1.png have the same number",
            ),
            (
                &["f_7.png", "f_8.png", "f_8.jpg"],
                "f_8.jpg and f_8.png have the same number",
            ),
            (
                &["3_of_9.png", "3_of_09.png"],
                "3_of_09.png and 3_of_9.png have the same number",
            ),
        ] {
            let found = listed(names).1.expect("doubts");
            assert!(found.starts_with(said), "{found}");
        }
    }

    #[test]
    fn gaps_in_the_numbers_are_counted() {
        let found = listed(&["1.png", "2.png", "3.png", "5.png", "6.png", "9.png"]).1;
        assert_eq!(
            found.as_deref(),
            Some(
                "the numbers of 6 frames have gaps: 2, the first between 3.png and 5.png (frames count as evenly spaced)"
            )
        );
        // Milliseconds at 30 frames a second, of which one is missing.
        let times = [
            "0033.png", "0067.png", "0100.png", "0133.png", "0200.png", "0233.png",
        ];
        let found = listed(&times).1.expect("a gap");
        assert!(
            found.contains("gaps: 1, the first between 0133.png and 0200.png"),
            "{found}"
        );
        for even in [
            &["0.png", "5.png", "10.png", "15.png"][..],
            &["0033.png", "0067.png", "0100.png", "0133.png"],
            &["7.png"],
            &["7.png", "9.png"],
            &["left.png", "right.png", "up.png"],
            // Two numbers vary: neither is known to be the frame's.
            &["1_1.png", "1_2.png", "2_1.png", "9_9.png"],
        ] {
            assert_eq!(listed(even).1, None, "{even:?}");
        }
    }
}
