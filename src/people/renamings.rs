//! Known names for joints and markers that no table knows: a CSV file with a row for each.

use super::markers::is_known_marker;
use super::measured::{line, problem};
use super::retarget::joint_roles::{normalised, shared_prefix};
use crate::error::{Error, FilePlace, Result};
use crate::import::{FileContents, person_of};
use csv::{Position, ReaderBuilder, Trim};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The names of joints that a row may give, with `Left` or `Right` except for the head:
/// MotionBuilder's, which [`JointRoles`](super::retarget::joint_roles::JointRoles) prefers.
const JOINTS: [&str; 8] = [
    "UpLeg", "Leg", "Foot", "ToeBase", "Shoulder", "Arm", "ForeArm", "Hand",
];

/// Known names by the names in motion files.
#[derive(Clone, Debug)]
pub struct Renamings {
    path: PathBuf,
    known: BTreeMap<String, String>,
}

impl Renamings {
    /// Reads a file with the header `name,known` and a row for each joint or marker: its name as
    /// spelled in motion files, and the known name of its kind, such as `LeftUpLeg` or `LASI`.
    ///
    /// # Errors
    /// For another header, no rows, a name with two rows, and known names that are not known. Names
    /// the line.
    pub fn read(path: &Path) -> Result<Self> {
        let text = crate::files::read(path)?;
        let refuse = |position: Option<&Position>, problem| {
            Error::at(path, FilePlace::Line(line(&text, position)), problem)
        };
        let unreadable = |error: csv::Error| refuse(error.position(), problem(&error));
        let mut reader = ReaderBuilder::new()
            .trim(Trim::All)
            .from_reader(text.as_slice());
        let header = reader.headers().map_err(unreadable)?;
        if header != ["name", "known"].as_slice() {
            let found = header.iter().collect::<Vec<_>>().join(",");
            let problem = format!("expected the header name,known, found {found:?}");
            return Err(refuse(header.position(), problem));
        }
        let mut all = BTreeMap::new();
        for record in reader.records() {
            let record = record.map_err(unreadable)?;
            let [name, known] = [0, 1].map(|column| record[column].to_owned());
            if !is_known_joint(&known) && !is_known_marker(&known) {
                let problem = format!(
                    "expected Head, or Left or Right and one of {}, or a known marker such as LASI, found {known:?}",
                    JOINTS.join(", ")
                );
                return Err(refuse(record.position(), problem));
            }
            if all.insert(name.clone(), known).is_some() {
                let problem = format!("{name:?} is in an earlier line: expected one row for each");
                return Err(refuse(record.position(), problem));
            }
        }
        if all.is_empty() {
            return Err(Error::input(path, "no rows: expected at least one"));
        }
        let path = path.to_path_buf();
        Ok(Self { path, known: all })
    }

    /// Gives the joints or markers of a file their known names. Rows about other names become a
    /// warning.
    ///
    /// # Errors
    /// A sentence without the motion file's name: no row is about this file, or another joint has
    /// the known name of a renamed one.
    pub(super) fn apply(&self, source: &mut FileContents) -> std::result::Result<(), String> {
        let (mut names, prefix, warnings): (Vec<&mut String>, _, _) = match source {
            FileContents::Motion(motion) => {
                let joints = &mut motion.joints;
                let before: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
                // Renamed joints keep what all share, so that it still is what all share.
                let prefix = before[0][..shared_prefix(&before)].to_owned();
                let names = joints.iter_mut().map(|joint| &mut joint.name);
                (names.collect(), prefix, &mut motion.warnings)
            }
            FileContents::Markers(markers) => {
                let names = markers.names.iter_mut();
                (names.collect(), String::new(), &mut markers.warnings)
            }
        };
        let path = self.path.display();
        let mut absent: BTreeSet<&str> = self.known.keys().map(String::as_str).collect();
        let mut renamed = Vec::new();
        for (index, name) in names.iter_mut().enumerate() {
            if let Some(known) = self.known.get(*name) {
                absent.remove(name.as_str());
                let person = person_of(name).map_or(String::new(), |person| format!("{person}:"));
                **name = format!("{prefix}{person}{known}");
                renamed.push((index, known));
            }
        }
        let absent = absent.into_iter().collect::<Vec<_>>().join(", ");
        if renamed.is_empty() {
            return Err(format!("has none of the names in {path}: {absent}"));
        }
        if !absent.is_empty() {
            warnings.push(format!("nothing here is called {absent} ({path})"));
        }
        let plain = |name: &str| {
            (
                person_of(name).map(str::to_owned),
                normalised(&name[prefix.len()..]),
            )
        };
        let plain: Vec<_> = names.iter().map(|name| plain(name)).collect();
        for (index, known) in renamed {
            if plain.iter().filter(|other| **other == plain[index]).count() > 1 {
                return Err(format!("two are called {known} with the names of {path}"));
            }
        }
        Ok(())
    }
}

fn is_known_joint(name: &str) -> bool {
    let sides = ["Left", "Right"];
    let bare = sides.iter().find_map(|side| name.strip_prefix(side));
    name == "Head" || bare.is_some_and(|bare| JOINTS.contains(&bare))
}
