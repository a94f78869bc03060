//! `index.csv`: the person, the walk and the viewpoint of each GEI.

use std::path::Path;

use csv::{ErrorKind, ReaderBuilder, StringRecord};
use serde::{Deserialize, Serialize};

use crate::draw::sweep::{Job, View, drawn};
use crate::error::{Error, FilePlace, Result, SweepError};
use edgegait_core::pack::Pack;

/// The columns of the index of a tree's gait cycles, in order.
pub(super) const RECORDED_COLUMNS: [&str; 13] = [
    "subject",
    "walk",
    "cycle",
    "variation",
    "speed_kmh",
    "azimuth_deg",
    "elevation_deg",
    "condition",
    "alternative",
    "frames",
    "seed",
    "first_frame",
    "last_frame",
];
/// The columns of `index.csv` otherwise.
pub(super) const COLUMNS: &[&str] = RECORDED_COLUMNS.split_at(11).0;

/// The columns of `walkers.csv`, in order.
pub(super) const WALKER_COLUMNS: [&str; 7] = [
    "subject",
    "walk",
    "sex",
    "age_years",
    "stature_m",
    "mass_kg",
    "clothes",
];

/// One row of `index.csv`: the person, walk and viewpoint that one GEI shows. A user's own table
/// needs only the person.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct IndexRow {
    /// The person's name.
    pub subject: String,
    /// The name of the walk.
    pub walk: String,
    /// The number of the recorded gait cycle in the walk, from 0.
    pub cycle: u32,
    /// The number of the seeded variation of that cycle; 0 is the cycle itself.
    pub variation: u32,
    /// Walking speed, km/h.
    pub speed_kmh: f64,
    /// Camera azimuth, degrees: 0 in front, 90 on the walker's left, 180 behind.
    pub azimuth_deg: f64,
    /// Camera elevation, degrees: 0 level, 90 straight above.
    pub elevation_deg: f64,
    /// The condition, such as `normal` or `bag`.
    pub condition: String,
    /// All active confounders of a condition that is sampled at random, such as `coat=0.5`; empty
    /// if the condition is fixed.
    pub alternative: String,
    /// The number of silhouettes that the GEI averages, at least 1.
    #[serde(default = "one")]
    pub frames: u32,
    /// The seed that made this GEI.
    pub seed: u64,
    /// The first frame of a gait cycle in its recording, counted from 0; none if it was drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_frame: Option<u32>,
    /// The last frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub last_frame: Option<u32>,
}

impl IndexRow {
    /// Returns the row of a job that is drawn with this seed and number of frames, with both
    /// angles 0; [`Self::seen_from`] sets them.
    ///
    /// # Errors
    /// If the pack has no such walk.
    pub fn of_job(pack: &Pack<'_>, job: Job<'_>, seed: u64, frames: u32) -> Result<Self> {
        let walk = pack.walk(job.walk);
        let subject = walk.and_then(|walk| pack.subject(walk.subject));
        let Some((walk, subject)) = walk.zip(subject) else {
            let (number, walks) = (job.walk, pack.walks().len());
            return Err(SweepError::NoWalk { number, walks }.into());
        };
        Ok(Self {
            subject: subject.name.into(),
            walk: walk.name.into(),
            cycle: u32::from(walk.cycle),
            variation: job.variation,
            speed_kmh: kmh(walk.speed_mm_per_s),
            azimuth_deg: 0.0,
            elevation_deg: 0.0,
            condition: job.condition_name().into(),
            alternative: drawn(pack, job, seed)?,
            frames,
            seed,
            ..Self::default()
        })
    }

    /// Returns a copy of the row with the angles of a viewpoint.
    #[must_use]
    pub fn seen_from(&self, view: &View) -> Self {
        let (azimuth_deg, elevation_deg) = view.angles_deg();
        Self {
            azimuth_deg,
            elevation_deg,
            ..self.clone()
        }
    }
}

/// Converts a speed from mm/s to km/h, rounded to 0.01.
#[must_use]
pub fn kmh(speed_mm_per_s: u16) -> f64 {
    (f64::from(speed_mm_per_s) * 0.36).round() / 100.0
}

/// One row of `walkers.csv`: the person in one walk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WalkerRow {
    /// The person's name, as in the index.
    pub subject: String,
    /// The name of the walk.
    pub walk: String,
    /// `female` or `male`.
    pub sex: String,
    /// Age, whole years.
    pub age_years: Option<u8>,
    /// Stature, metres.
    pub stature_m: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// The clothes in one word, such as `loose+shorts+long-hair`; empty for a plain body.
    pub clothes: String,
}

const fn one() -> u32 {
    1
}

/// Reads a user's own table: the person and any other columns of `index.csv`. Missing text is
/// empty, missing numbers are 0, and missing `frames` is 1. Rejects what [`read_index`] rejects,
/// except missing columns.
pub(super) fn read_plain_index(path: &Path, bytes: &[u8]) -> Result<Vec<IndexRow>> {
    read(path, bytes, |header| {
        let mut names = header.iter().enumerate();
        let other = names.find(|(at, name)| {
            !RECORDED_COLUMNS.contains(name)
                || header.iter().take(*at).any(|before| before == *name)
        });
        if let Some((_, other)) = other {
            return Some(format!(
                "expected the column subject and any others of {}, each at most once, found {other:?}",
                COLUMNS.join(",")
            ));
        }
        let has_subject = header.iter().any(|name| name == "subject");
        (!has_subject).then(|| "expected a column subject, found none".into())
    })
}

/// Reads `index.csv`. Rejects other columns, values out of range and files that
/// are not text, and names the line.
pub(super) fn read_index(path: &Path, bytes: &[u8]) -> Result<Vec<IndexRow>> {
    read(path, bytes, |header| {
        (*header != *COLUMNS && *header != *RECORDED_COLUMNS.as_slice()).then(|| {
            format!(
                "expected the columns {}, found {} (make the dataset again, or add the missing columns: 0 as variation, nothing as alternative)",
                COLUMNS.join(","),
                header.iter().collect::<Vec<_>>().join(",")
            )
        })
    })
}

/// Reads all rows of a table, unless its header has a problem.
fn read(
    path: &Path,
    bytes: &[u8],
    problem_of: impl Fn(&StringRecord) -> Option<String>,
) -> Result<Vec<IndexRow>> {
    let mut reader = ReaderBuilder::new().from_reader(bytes);
    let header = reader
        .headers()
        .map_err(|error| refusal(path, bytes, &StringRecord::new(), &error))?
        .clone();
    if let Some(problem) = problem_of(&header) {
        return Err(Error::at(path, FilePlace::Line(1), problem));
    }
    let refuse = |error| refusal(path, bytes, &header, &error);
    let mut rows = Vec::new();
    let mut record = StringRecord::new();
    while reader.read_record(&mut record).map_err(refuse)? {
        let row: IndexRow = record.deserialize(Some(&header)).map_err(refuse)?;
        if let Some(problem) = row.problem() {
            let line = line(bytes, record.position());
            return Err(Error::at(path, FilePlace::Line(line), problem));
        }
        rows.push(row);
    }
    Ok(rows)
}

impl IndexRow {
    /// Returns the reason why the row is invalid, or none if it is valid.
    pub(super) fn problem(&self) -> Option<String> {
        if self.subject.is_empty() {
            return Some("expected a subject, found an empty field".into());
        }
        if !(self.speed_kmh >= 0.0 && self.speed_kmh.is_finite()) {
            return Some(format!("expected speed_kmh >= 0, found {}", self.speed_kmh));
        }
        if !(-360.0..=360.0).contains(&self.azimuth_deg) {
            return Some(format!(
                "expected azimuth_deg from -360 to 360, found {}",
                self.azimuth_deg
            ));
        }
        if !(-90.0..=90.0).contains(&self.elevation_deg) {
            return Some(format!(
                "expected elevation_deg from -90 to 90, found {}",
                self.elevation_deg
            ));
        }
        (self.frames == 0).then(|| "expected frames >= 1, found 0".into())
    }
}

/// Returns the line on which a record begins. The reader's own count is one short where lines end
/// in CR LF, because its position is then between the two.
fn line(bytes: &[u8], position: Option<&csv::Position>) -> usize {
    let Some(at) = position.and_then(|position| usize::try_from(position.byte()).ok()) else {
        return 1;
    };
    let (before, after) = bytes.split_at(at.min(bytes.len()));
    let ends = before.iter().filter(|byte| **byte == b'\n').count();
    1 + ends + usize::from(after.first() == Some(&b'\n'))
}

fn refusal(path: &Path, bytes: &[u8], header: &StringRecord, error: &csv::Error) -> Error {
    let place = FilePlace::Line(line(bytes, error.position()));
    let problem = match error.kind() {
        ErrorKind::UnequalLengths { len, .. } => {
            format!("expected {} fields, found {len}", header.len())
        }
        ErrorKind::Utf8 { .. } => "expected text in UTF-8, found other bytes".into(),
        ErrorKind::Deserialize { err, .. } => {
            let column = err
                .field()
                .and_then(|field| header.get(usize::try_from(field).ok()?));
            match column {
                Some(column) => format!("{column}: {}", err.kind()),
                None => err.kind().to_string(),
            }
        }
        _ => error.to_string(),
    };
    Error::at(path, place, problem)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "subject,walk,cycle,variation,speed_kmh,azimuth_deg,elevation_deg,condition,alternative,frames,seed\n";

    fn refused(text: &str) -> String {
        read_index(Path::new("index.csv"), text.as_bytes())
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn a_row_is_read_whatever_its_text_holds() {
        let text = format!(
            "{HEAD}\"Ann, \"\"A\"\"\",walk-1,2,1000,4.5,90,5.0,\"rain\nfog\",coat=0.5,32,18446744073709551615\n"
        );
        let rows = read_index(Path::new("index.csv"), text.as_bytes()).unwrap();
        assert_eq!(
            rows,
            [IndexRow {
                subject: "Ann, \"A\"".into(),
                walk: "walk-1".into(),
                cycle: 2,
                variation: 1000,
                speed_kmh: 4.5,
                azimuth_deg: 90.0,
                elevation_deg: 5.0,
                condition: "rain\nfog".into(),
                alternative: "coat=0.5".into(),
                frames: 32,
                seed: u64::MAX,
                ..IndexRow::default()
            }]
        );
    }

    #[test]
    fn what_cannot_be_is_refused_with_its_line() {
        let good = "s,w,0,0,4.5,90,5,normal,,32,1\n";
        // Line ends of Python's csv module.
        let crlf =
            format!("{HEAD}{good}{good}s,w,0,0,fast,90,5,normal,,32,1\n").replace('\n', "\r\n");
        assert_eq!(
            refused(&crlf),
            "index.csv:4: speed_kmh: invalid float literal"
        );
        let crlf = crlf.replace("fast", "4.5").replacen("90,5", "90,95", 2);
        assert_eq!(
            refused(&crlf),
            "index.csv:2: expected elevation_deg from -90 to 90, found 95"
        );
        assert_eq!(
            refused(&format!("{HEAD}{good}s,w,0,0,fast,90,5,normal,,32,1\n")),
            "index.csv:3: speed_kmh: invalid float literal"
        );
        assert_eq!(
            refused(&format!("{HEAD}{good}{good}s,w,0,0,4.5,90\n")),
            "index.csv:4: expected 11 fields, found 6"
        );
        assert_eq!(
            refused(&format!("{HEAD}s,w,0,0,4.5,90,91,normal,,32,1\n")),
            "index.csv:2: expected elevation_deg from -90 to 90, found 91"
        );
        assert_eq!(
            refused(&format!("{HEAD}s,w,0,0,NaN,90,0,normal,,32,1\n")),
            "index.csv:2: expected speed_kmh >= 0, found NaN"
        );
        assert_eq!(
            refused(&format!("{HEAD}s,w,0,0,4,90,0,normal,,0,1\n")),
            "index.csv:2: expected frames >= 1, found 0"
        );
        assert_eq!(
            refused(&format!("{HEAD},w,0,0,4,90,0,normal,,32,1\n")),
            "index.csv:2: expected a subject, found an empty field"
        );
        assert!(
            refused("subject,view\n")
                .starts_with("index.csv:1: expected the columns subject,walk,cycle,")
        );
        let broken = [HEAD.as_bytes(), b"\xff,w,0,0,4,90,0,normal,,32,1\n"].concat();
        assert_eq!(
            read_index(Path::new("index.csv"), &broken)
                .unwrap_err()
                .to_string(),
            "index.csv:2: expected text in UTF-8, found other bytes"
        );
    }
}
