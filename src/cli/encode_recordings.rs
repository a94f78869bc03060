//! Encodes recordings as people in a pack, without the walks that cannot be encoded.

use super::keep_going::KeepGoing;
use crate::encode::within_error::EncodedPack;
use crate::error::{Error, Result};
use crate::people::Subject;
use crate::people::encodable::without;
use crate::people::recorded::{BodyOptions, Recording, subjects};

/// Encodes the people of these recordings by `encode`. With `--keep-going`, walks that cannot be encoded are
/// removed from the recordings, with a warning for each, and have no effect on the rest.
///
/// # Errors
/// The same as [`subjects`] and `encode`, and if no walk is left.
pub(super) fn encoded_people(
    recordings: &mut Vec<Recording>,
    body: &BodyOptions,
    encode: &dyn Fn(&[Subject]) -> Result<EncodedPack>,
    keep_going: KeepGoing,
    warnings: &mut Vec<String>,
) -> Result<(Vec<Subject>, EncodedPack)> {
    // Each round has fewer walks.
    loop {
        let people = subjects(recordings, body);
        let is_implausible = people.is_err();
        let made = people.and_then(|people| {
            let encoded = encode(&people)?;
            Ok((people, encoded))
        });
        match made {
            Err(Error::Refused(refused)) => {
                let all = recordings.iter().map(Recording::walks).sum();
                let errors = without(recordings, &refused);
                if is_implausible && !keep_going.is_given() {
                    // Measurements are settings.
                    let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
                    return Err(Error::Usage(lines.join("\n")));
                }
                let all = if recordings.is_empty() {
                    errors.len()
                } else {
                    all
                };
                warnings.extend(keep_going.leave_out(errors, all, "walks", "encoded")?);
            }
            other => return other,
        }
    }
}
