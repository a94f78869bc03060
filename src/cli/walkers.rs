//! Recordings as people in a pack, less the walks that cannot be encoded.

use super::encoding::{Encoded, EncodingArgs};
use super::keep_going::KeepGoing;
use crate::error::{Error, Refused, Result};
use crate::scene::Subject;
use crate::scene::recorded::{BodyOptions, Recording, subjects};

/// The people of these recordings, encoded. Walks that cannot be are taken out of the recordings
/// if that was asked for, and what is left is encoded as if they had never been there; one warning
/// for each is added.
///
/// # Errors
/// As [`subjects`] and [`EncodingArgs::encode`], and if no walk is left.
pub fn encoded_people(
    recordings: &mut Vec<Recording>,
    body: &BodyOptions,
    (encoding, keep_going): (&EncodingArgs, KeepGoing),
    warnings: &mut Vec<String>,
) -> Result<(Vec<Subject>, Encoded)> {
    // Each round has fewer walks.
    loop {
        let made = subjects(recordings, body).and_then(|people| {
            let encoded = encoding.encode("encoding", &people)?;
            Ok((people, encoded))
        });
        match made {
            Err(Error::Refused(refused))
                if keep_going.is_given() || refused.iter().all(|one| one.walk.is_some()) =>
            {
                let all = recordings.iter().map(walks).sum();
                let errors = take_out(recordings, &refused);
                let all = if recordings.is_empty() {
                    errors.len()
                } else {
                    all
                };
                warnings.extend(keep_going.leave_out(errors, all, ("walks", "encoded"))?);
            }
            other => return other,
        }
    }
}

/// Walks of a recording: its cycles, or the take.
fn walks(recording: &Recording) -> usize {
    recording.cut.as_ref().map_or(1, |cut| cut.cycles.len())
}

/// Takes refused walks out of their recordings, and recordings without any out of the list: an
/// error for each walk, or for all of a person's recording, with its file.
fn take_out(recordings: &mut Vec<Recording>, refused: &[Refused]) -> Vec<Error> {
    let mut errors = Vec::new();
    recordings.retain_mut(|recording| {
        let Recording {
            path,
            subject,
            name,
            cut,
            ..
        } = recording;
        let path = path.as_path();
        let own = || refused.iter().filter(|one| one.subject == *subject);
        if let Some(person) = own().find(|one| one.walk.is_none()) {
            errors.push(Error::input(path, person.to_string()));
            return false;
        }
        let problem = |number: usize| {
            let is_it =
                |(walk, cycle): &(String, u16)| walk == name && usize::from(*cycle) == number;
            let found = own().find(|one| one.walk.as_ref().is_some_and(is_it));
            found.map(|one| one.problem.as_str())
        };
        let Some(cut) = cut else {
            let problem = problem(0);
            errors.extend(problem.map(|problem| Error::input(path, problem)));
            return problem.is_none();
        };
        let all = cut.cycles.len();
        let mut numbers = 0..all;
        cut.cycles.retain(|one| {
            let problem = numbers.next().and_then(problem);
            errors.extend(problem.map(|problem| {
                Error::input(
                    path,
                    format!("the cycle at {:.2} s: {problem}", one.start_s),
                )
            }));
            problem.is_none()
        });
        cut.found -= all - cut.cycles.len();
        !cut.cycles.is_empty()
    });
    errors
}
