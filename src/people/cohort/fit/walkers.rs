//! The recorded walkers: the clips that are used, and the features of their cycles.

use super::features::{Features, features};
use crate::people::recorded::{ReadOptions, Recording};
use std::path::{Path, PathBuf};

/// Clips that are left out of the fit and of the check: the data's authors reserve them for
/// evaluation.
const KEPT_UNSEEN: [&str; 3] = ["07_09", "08_09", "35_01"];

/// The subject of the final results, who is therefore left out of the fit.
const JUDGED_BY: &str = "s39";

/// Subjects that are not suitable: one walks over uneven ground, another kicks and turns between
/// single steps, and one moves too slowly for the cadence (half of the frames are missing).
const NO_WALKERS: [&str; 3] = ["s03", "s131", "pyCGM"];

/// Largest share by which a cycle's speed may differ from its take's median; others are left out.
const STEADY: f64 = 0.15;

/// One recorded take.
#[derive(Clone, Debug)]
pub(super) struct ManifestTake {
    pub dataset: String,
    pub subject: String,
    pub cycles: Vec<Features>,
}

/// A row of a manifest.
struct ManifestRow {
    dataset: String,
    subject: String,
    name: String,
    activity: String,
    path: PathBuf,
}

fn rows(folder: &Path) -> Vec<ManifestRow> {
    let path = folder.join("manifest.csv");
    let mut reader =
        csv::Reader::from_path(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let header = reader.headers().expect("a header").clone();
    let column = |name: &str| {
        header
            .iter()
            .position(|field| field == name)
            .expect("named")
    };
    let [dataset, subject, name, file, activity] =
        ["dataset", "subject", "trial", "file", "activity"].map(column);
    let rows = reader.records().map(|row| {
        let row = row.expect("a row");
        ManifestRow {
            dataset: row[dataset].into(),
            subject: row[subject].into(),
            name: row[name].into(),
            activity: row[activity].into(),
            path: folder.join(&row[file]),
        }
    });
    rows.collect()
}

/// Returns every usable take of a healthy adult; the data sets of CMU have the name `cmu`.
///
/// Leaves out GPL data (`shum_gait`, most of it patients, and `gaittoolbox`), whose statistics do
/// not go into this repository, and CMU's clips on another avatar's bones.
pub(super) fn clips(data: &Path) -> Vec<ManifestTake> {
    let mut clips = Vec::new();
    for row in rows(&data.join("mocap"))
        .into_iter()
        .chain(rows(&data.join("people/mocap_extra")))
    {
        let dataset = match row.dataset.as_str() {
            "shum_gait" | "gaittoolbox" | "cmu_bvh_retargeted" => continue,
            "cmu_amc" | "cmu_bvh" => "cmu",
            other => other,
        };
        if row.activity != "walk"
            || KEPT_UNSEEN.contains(&row.name.as_str())
            || NO_WALKERS.contains(&row.subject.as_str())
            || row.subject == JUDGED_BY
        {
            continue;
        }
        // The tables were fitted to unmended feet.
        let options = ReadOptions {
            mend: false,
            ..ReadOptions::default()
        };
        let recording = match Recording::read(&row.path, &options) {
            Ok(recording) => recording,
            Err(error) => {
                println!(
                    "left out: {} {} {}: {error}",
                    dataset, row.subject, row.name
                );
                continue;
            }
        };
        let cycles = recording.cut.iter().flat_map(|cut| &cut.cycles);
        let mut speeds: Vec<f64> = cycles.clone().map(|cut| cut.speed_mps).collect();
        speeds.sort_by(f64::total_cmp);
        let usual = speeds[speeds.len() / 2];
        let steady: Vec<Features> = cycles
            .filter(|cut| (cut.speed_mps / usual - 1.0).abs() < STEADY)
            .map(|cut| features(&cut.cycle, &recording.take.offsets))
            .collect();
        clips.push(ManifestTake {
            dataset: dataset.into(),
            subject: row.subject,
            cycles: steady,
        });
    }
    clips
}
