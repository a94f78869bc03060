//! The compared people: recorded people on bodies of their own dimensions, and synthetic people.

use crate::people::rows;
use edgegait::people::cohort::Person;
use edgegait::people::recorded::{BodyOptions, ReadOptions, Recording, SubjectName, subjects};
use edgegait::people::{Body, Subject, Track, cohort};
use edgegait::{
    CohortOptions, Condition, Job, MAX_ERROR_MM, Pack, Settings, Views, encode_subjects, sweep,
};
use edgegait_core::pack::Sex;
use edgegait_core::raster::Rasterizer;
use edgegait_core::skeleton::Joint;
use std::path::Path;

/// The seed of the synthetic people, which differs from that of the shipped models' people.
const MADE_SEED: u64 = 20;
/// The number of synthetic people.
pub const MADE_PEOPLE: usize = 60;
/// The speeds of synthetic people, km/h.
pub const MADE_SPEEDS_KMH: [f64; 3] = [3.0, 4.0, 5.0];
/// The speeds of recorded cycles, m/s: 2.7 to 5.8 km/h, similar to the synthetic people's.
const RECORDED_MPS: std::ops::RangeInclusive<f64> = 0.75..=1.6;

/// The viewpoints of all measurements: azimuth and elevation, degrees.
pub const VIEWS_DEG: [(f32, f32); 5] = [
    (0.0, 0.0),
    (45.0, 0.0),
    (90.0, 0.0),
    (135.0, 0.0),
    (90.0, 15.0),
];

/// Recorded people for final results, by dataset and subject: from CMU and TNSRE those that the
/// realistic people made from the same data do not use, from others every second person.
const FINAL: [&str; 20] = [
    "CMU/s39",
    "TNSRE/D7",
    "TNSRE/D8",
    "TNSRE/D9",
    "TNSRE/D10",
    "TNSRE/A2",
    "TNSRE/B3",
    "TNSRE/B4",
    "TNSRE/C3",
    "biomechzoo/HC030A",
    "biomechzoo/HC032A",
    "biomechzoo/HC036A",
    "biomechzoo/HC039A",
    "biomechzoo/HC044A",
    "auckland_c3dparser/MH",
    "auckland_c3dparser/RBWH",
    "btkdata/btk_pig1",
    "opensim/rajagopal",
    "bmclab/BMC",
    "bmclab/rajagopal_run",
];
/// Patients with several takes, who count only in comparisons within a person.
const PATIENTS: [&str; 9] = [
    "TNSRE/A1", "TNSRE/A2", "TNSRE/A4", "TNSRE/B1", "TNSRE/B3", "TNSRE/B4", "TNSRE/C1", "TNSRE/C2",
    "TNSRE/C3",
];
/// Takes and people that are reserved for other evaluations.
const ELSEWHERE: [&str; 3] = ["07_09", "08_09", "35_01"];

/// The part of the recorded people that is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// The people for choosing settings.
    Choices,
    /// The people for final results.
    Final,
}

impl Split {
    /// Returns the split that `EDGEGAIT_LIKENESS` names: `final`, or else the people for choices.
    pub fn asked() -> Self {
        match std::env::var("EDGEGAIT_LIKENESS").as_deref() {
            Ok("final") => Self::Final,
            Ok("choices") | Err(_) => Self::Choices,
            Ok(other) => panic!("EDGEGAIT_LIKENESS: expected choices or final, found {other:?}"),
        }
    }

    fn has(self, person: &str) -> bool {
        FINAL.contains(&person) == (self == Self::Final)
    }
}

/// Returns the healthy people of this split, and the patients with several takes. Each take is one
/// file, imported as by the command.
pub fn recorded(data: &Path, split: Split) -> Vec<Subject> {
    let mut recordings = Vec::new();
    for root in ["mocap", "people/mocap_extra"] {
        let root = data.join(root);
        for row in rows(&root.join("manifest.csv")) {
            let cell = |name: &str| row.get(name).map_or("", String::as_str);
            let set = match cell("dataset") {
                "cmu_amc" | "cmu_bvh" => "CMU",
                "shum_gait" => "TNSRE",
                other => other,
            };
            let name = format!("{set}/{}", cell("subject"));
            let is_healthy = set != "TNSRE" || cell("subject").starts_with('D');
            let is_used = cell("activity") == "walk"
                && set != "cmu_bvh_retargeted"
                && !cell("flags").contains("MISSING")
                && !ELSEWHERE.contains(&cell("trial"))
                && (is_healthy || PATIENTS.contains(&name.as_str()))
                && split.has(&name);
            if !is_used {
                continue;
            }
            // Keep the motion of the files, to which the synthetic people were fitted; the
            // conventions of laboratories are part of the differences.
            let options = ReadOptions {
                subject: SubjectName::Given(name),
                mend: false,
                ..ReadOptions::default()
            };
            let path = root.join(cell("file"));
            let recording = Recording::read(&path, &options).expect("a walk");
            if RECORDED_MPS.contains(&recording.speed_mps()) {
                recordings.push(recording);
            }
        }
    }
    subjects(&recordings, &BodyOptions::default()).expect("plausible bodies")
}

/// Returns the synthetic people.
pub fn made(people: usize) -> Vec<Subject> {
    let options = CohortOptions {
        seed: MADE_SEED,
        people,
        speeds_kmh: MADE_SPEEDS_KMH.to_vec(),
        ..CohortOptions::default()
    };
    cohort::subjects(&options).expect("speeds of the norms")
}

/// Returns synthetic people who walk at 5 km/h on two days.
pub fn made_on_two_days(people: usize) -> Vec<Subject> {
    let options = CohortOptions {
        seed: MADE_SEED,
        people,
        speeds_kmh: vec![5.0],
        later_kmh: vec![vec![5.0]],
        ..CohortOptions::default()
    };
    cohort::subjects(&options).expect("speeds of the norms")
}

/// Returns the same motions on the body of the average man, with paths of the hips as large as the
/// legs.
pub fn on_one_body(people: Vec<Subject>) -> Vec<Subject> {
    let body = Person::average(Sex::Male).body;
    let leg_m = |body: &Body| {
        let offset = |joint: Joint| body.offsets[joint.index()].length();
        offset(Joint::LeftShank) + offset(Joint::LeftFoot)
    };
    let moved = |mut person: Subject| {
        let by = leg_m(&body) / leg_m(&person.body);
        for walk in &mut person.walks {
            let Track::Loop(cycle) = &mut walk.motion else {
                panic!("{}: expected a cycle", walk.name);
            };
            cycle.drift_m *= by;
            cycle.root.iter_mut().for_each(|root| *root *= by);
            walk.worn = None;
        }
        person.body = body.clone();
        person
    };
    people.into_iter().map(moved).collect()
}

/// Returns the dataset of a person.
pub fn set_of(person: &Subject) -> &str {
    person.name.split_once('/').map_or("made", |(set, _)| set)
}

/// Returns whether a person is a patient.
pub fn is_patient(person: &Subject) -> bool {
    PATIENTS.contains(&person.name.as_str())
}

/// One cycle, seen from all viewpoints.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The index of the person.
    pub person: usize,
    /// The name of the take.
    pub take: String,
    /// The number of the stored cycle, and of its variation.
    pub cycle: (u16, u32),
    /// For each of [`VIEWS_DEG`] a GEI with pixels in 0..1.
    pub geis: Vec<Vec<f32>>,
}

/// Returns the GEIs of these people's cycles, with these variations of each and under this
/// condition.
pub fn samples(
    people: &[Subject],
    variations: &[u32],
    condition: Option<&Condition>,
) -> Vec<Sample> {
    let bytes = encode_subjects(people, MAX_ERROR_MM, &|| Ok(())).expect("a pack");
    let pack = Pack::parse(&bytes).expect("its own bytes");
    let settings = Settings {
        rasterizer: Rasterizer::Rows3x3.into(),
        ..Settings::default()
    };
    let list = |(azimuth, elevation)| {
        Views::grid("", [azimuth], [elevation])
            .expect("angles")
            .list[0]
    };
    let views: Vec<_> = VIEWS_DEG.into_iter().map(list).collect();
    let walks = pack.walks().len();
    let jobs: Vec<Job<'_>> = (0..walks)
        .flat_map(|walk| {
            variations.iter().map(move |&variation| Job {
                walk,
                variation,
                condition,
            })
        })
        .collect();
    let mut samples = Vec::new();
    let shares = |gei: &Vec<u8>| gei.iter().map(|&pixel| f32::from(pixel) / 255.0).collect();
    sweep(
        &pack,
        &jobs,
        &views,
        settings,
        |_, swept| Ok(swept.templates.iter().map(shares).collect()),
        |job, geis| {
            let walk = pack.walk(job.walk).expect("a walk of it");
            samples.push(Sample {
                person: walk.subject,
                take: walk.name.to_owned(),
                cycle: (walk.cycle, job.variation),
                geis,
            });
            Ok(())
        },
    )
    .expect("cycles are drawn");
    samples
}
