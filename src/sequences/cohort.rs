//! The built-in cohort, encoded once and for all.
//!
//! Encoding takes most of the time of a short command, and makes the same bytes each time: those
//! of what commands ask for by default are in the library. A test encodes them again.

use crate::people::cohort::CohortOptions;

/// Speeds of the people whom commands use when no walk is named, km/h.
const USUAL_KMH: [f64; 1] = [5.0];

/// All walks of the built-in people, as `edgegait cohort` encodes them.
const ALL: &[u8] = include_bytes!("cohort.egp");
/// Their walks at [`USUAL_KMH`] alone, which are encoded otherwise than together with others.
const USUAL: &[u8] = include_bytes!("cohort-5kmh.egp");

/// The people of these options within [`crate::encode::MAX_ERROR_MM`], as a pack; none of other
/// people or speeds than are stored.
#[must_use]
pub(crate) fn stored(options: &CohortOptions) -> Option<&'static [u8]> {
    let all = CohortOptions::default();
    let usual = CohortOptions {
        speeds_kmh: USUAL_KMH.to_vec(),
        ..all.clone()
    };
    [(all, ALL), (usual, USUAL)]
        .into_iter()
        .find_map(|(known, bytes)| (*options == known).then_some(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::{MAX_ERROR_MM, encode_subjects};
    use crate::people::cohort::subjects;
    use crate::sequences::{BUILT_IN_WALK, built_in};
    use std::path::Path;

    fn of_speeds(speeds_kmh: Vec<f64>) -> CohortOptions {
        CohortOptions {
            speeds_kmh,
            ..CohortOptions::default()
        }
    }

    /// `UPDATE_GOLDEN=1 cargo test --lib stored_packs` writes them anew.
    #[test]
    fn stored_packs_are_what_encoding_makes() {
        for (file, options, stored) in [
            ("cohort.egp", CohortOptions::default(), ALL),
            ("cohort-5kmh.egp", of_speeds(USUAL_KMH.to_vec()), USUAL),
        ] {
            let people = subjects(&options).expect("speeds within the norms");
            let made = encode_subjects(&people, MAX_ERROR_MM, &|| {}).expect("a pack");
            if std::env::var_os("UPDATE_GOLDEN").is_some() {
                let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/sequences");
                std::fs::write(folder.join(file), &made).expect("the pack");
            } else {
                assert!(made == stored, "{file} is another");
            }
        }
    }

    #[test]
    fn what_commands_use_by_default_is_stored_and_nothing_else() {
        let usual = built_in(&[BUILT_IN_WALK.to_owned()]);
        assert_eq!(stored(&usual), Some(USUAL));
        assert_eq!(stored(&CohortOptions::default()), Some(ALL));
        let others = [
            of_speeds(vec![5.0, 6.0]),
            of_speeds(vec![4.0]),
            CohortOptions {
                seed: 2,
                ..usual.clone()
            },
            CohortOptions {
                people: 25,
                ..usual
            },
        ];
        assert!(others.iter().all(|options| stored(options).is_none()));
    }
}
