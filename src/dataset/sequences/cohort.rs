//! The built-in cohort as stored packs.
//!
//! Encoding takes most of the time of a short command and always makes the same bytes, so the
//! library contains the packs that commands use by default. A test encodes them again.

use crate::people::cohort::CohortOptions;

/// The speeds that commands use when no walk is named, km/h.
const USUAL_KMH: [f64; 1] = [5.0];

/// The pack of all walks of the built-in people, as `edgegait cohort` encodes it.
const ALL: &[u8] = include_bytes!("cohort.egp");
/// The pack of the walks at [`USUAL_KMH`] alone, whose encoding differs from that in [`ALL`].
const USUAL: &[u8] = include_bytes!("cohort-5kmh.egp");
/// The pack of [`CohortOptions::unseen`].
const UNSEEN: &[u8] = include_bytes!("unseen.egp");

// 26 people at 10 speeds, and their second session, fit into a board's memory next to its program.
const _: () = assert!(ALL.len() <= 64 * 1024);

/// Returns the stored pack for these options, encoded within [`crate::encode::MAX_ERROR_MM`], or
/// `None` if it is not stored.
#[must_use]
pub(crate) fn stored(options: &CohortOptions) -> Option<&'static [u8]> {
    let all = CohortOptions::built_in();
    let usual = CohortOptions {
        speeds_kmh: USUAL_KMH.to_vec(),
        ..CohortOptions::default()
    };
    [
        (all, ALL),
        (usual, USUAL),
        (CohortOptions::unseen(), UNSEEN),
    ]
    .into_iter()
    .find_map(|(known, bytes)| (*options == known).then_some(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::sequences::{BUILT_IN_WALK, built_in};
    use crate::encode::{MAX_ERROR_MM, encode_subjects};
    use crate::people::cohort::subjects;
    use std::path::Path;

    fn of_speeds(speeds_kmh: Vec<f64>) -> CohortOptions {
        CohortOptions {
            speeds_kmh,
            ..CohortOptions::default()
        }
    }

    /// Rewrite the packs with `UPDATE_GOLDEN=1 cargo test --lib stored_packs`.
    #[test]
    fn stored_packs_are_what_encoding_makes() {
        for (file, options, stored) in [
            ("cohort.egp", CohortOptions::built_in(), ALL),
            ("cohort-5kmh.egp", of_speeds(USUAL_KMH.to_vec()), USUAL),
            ("unseen.egp", CohortOptions::unseen(), UNSEEN),
        ] {
            let people = subjects(&options).expect("speeds within the norms");
            let made = encode_subjects(&people, MAX_ERROR_MM, &|| Ok(())).expect("a pack");
            if std::env::var_os("UPDATE_GOLDEN").is_some() {
                let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/dataset/sequences");
                std::fs::write(folder.join(file), &made).expect("the pack");
            } else {
                assert!(made == stored, "{file} differs");
            }
        }
    }

    #[test]
    fn what_commands_use_by_default_is_stored_and_nothing_else() {
        let usual = built_in(&[BUILT_IN_WALK.to_owned()]);
        assert_eq!(stored(&usual), Some(USUAL));
        assert_eq!(stored(&CohortOptions::built_in()), Some(ALL));
        assert_eq!(stored(&CohortOptions::unseen()), Some(UNSEEN));
        let others = [
            of_speeds(vec![5.0, 6.0]),
            of_speeds(vec![4.0]),
            CohortOptions::default(),
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
