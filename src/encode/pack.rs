//! Putting a pack together.

use crate::error::{Error, Result};
use edgegait_core::format::{
    CRC_AT, HEADER_BYTES, LENGTH_AT, MAGIC, SECTION_ENTRY_BYTES, SECTION_ORDER, SECTIONS_AT,
    VERSION, VERSION_AT, crc32,
};
use edgegait_core::pack::{Gait, Pack, Sex};

/// A person to be stored.
#[derive(Clone, Debug)]
pub struct NewSubject {
    /// Name, unique in its pack, at most 255 bytes.
    pub name: String,
    /// Sex, where it is known.
    pub sex: Option<Sex>,
    /// Stature, metres; 0 where it is unknown.
    pub stature_m: f64,
    /// Mass, kg; 0 where it is unknown.
    pub mass_kg: f64,
    /// Number of the avatar.
    pub avatar: usize,
}

/// A gait cycle to be stored.
#[derive(Clone, Debug)]
pub struct NewWalk {
    /// Name of the take, at most 255 bytes.
    pub name: String,
    /// Number of the subject.
    pub subject: usize,
    /// Which cycle of the take.
    pub cycle: usize,
    /// Walking or running.
    pub gait: Gait,
    /// Mean speed, m/s.
    pub speed_mps: f64,
    /// Number of the clip.
    pub clip: usize,
}

/// Collects avatars, clips, subjects and walks, and writes them as one pack.
#[derive(Clone, Debug, Default)]
pub struct PackBuilder {
    names: Vec<u8>,
    subjects: Vec<NewSubject>,
    walks: Vec<NewWalk>,
    avatars: Vec<Vec<u8>>,
    clips: Vec<Vec<u8>>,
}

impl PackBuilder {
    /// Adds an avatar's bytes; its number.
    pub fn avatar(&mut self, bytes: Vec<u8>) -> usize {
        self.avatars.push(bytes);
        self.avatars.len() - 1
    }

    /// Adds a clip's bytes; its number.
    pub fn clip(&mut self, bytes: Vec<u8>) -> usize {
        self.clips.push(bytes);
        self.clips.len() - 1
    }

    /// Adds a person; their number.
    pub fn subject(&mut self, subject: NewSubject) -> usize {
        self.subjects.push(subject);
        self.subjects.len() - 1
    }

    /// Adds a walk.
    pub fn walk(&mut self, walk: NewWalk) {
        self.walks.push(walk);
    }

    /// The pack's bytes, parsed once to be sure.
    ///
    /// # Errors
    /// When something does not fit the format, or two subjects share a name.
    pub fn finish(mut self) -> Result<Vec<u8>> {
        let mut names: Vec<&str> = self.subjects.iter().map(|s| s.name.as_str()).collect();
        names.sort_unstable();
        if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(Error::Failed(format!(
                "two subjects are named {:?}: expected unique names",
                pair[0]
            )));
        }
        let subjects = self.subject_records()?;
        let walks = self.walk_records()?;
        let sections = [
            std::mem::take(&mut self.names),
            subjects,
            walks,
            table(&self.avatars)?,
            table(&self.clips)?,
        ];
        let mut bytes = vec![0; HEADER_BYTES];
        bytes[..4].copy_from_slice(&MAGIC);
        bytes[VERSION_AT..VERSION_AT + 2].copy_from_slice(&VERSION.to_le_bytes());
        bytes[SECTIONS_AT..SECTIONS_AT + 2]
            .copy_from_slice(&narrow::<u16>(sections.len())?.to_le_bytes());
        let mut at = HEADER_BYTES + SECTION_ORDER.len() * SECTION_ENTRY_BYTES;
        for (kind, section) in SECTION_ORDER.iter().zip(&sections) {
            bytes.extend(kind);
            bytes.extend(narrow::<u32>(at)?.to_le_bytes());
            bytes.extend(narrow::<u32>(section.len())?.to_le_bytes());
            at += section.len();
        }
        bytes.extend(sections.iter().flatten());
        let length = narrow::<u32>(bytes.len())?;
        bytes[LENGTH_AT..LENGTH_AT + 4].copy_from_slice(&length.to_le_bytes());
        let crc = crc32(&bytes[HEADER_BYTES..]);
        bytes[CRC_AT..CRC_AT + 4].copy_from_slice(&crc.to_le_bytes());
        Pack::parse(&bytes)
            .map_err(|error| Error::Failed(format!("the pack does not read back: {error}")))?;
        Ok(bytes)
    }

    fn subject_records(&mut self) -> Result<Vec<u8>> {
        let mut records = Vec::new();
        for subject in &self.subjects {
            push_name(&mut self.names, &mut records, &subject.name)?;
            records.push(match subject.sex {
                None => 0,
                Some(Sex::Female) => 1,
                Some(Sex::Male) => 2,
            });
            records.extend(tenths(subject.stature_m * 1e3, "stature")?.to_le_bytes());
            records.extend(tenths(subject.mass_kg * 10.0, "mass")?.to_le_bytes());
            records.extend(narrow::<u16>(subject.avatar)?.to_le_bytes());
        }
        Ok(records)
    }

    fn walk_records(&mut self) -> Result<Vec<u8>> {
        let mut records = Vec::new();
        for walk in &self.walks {
            push_name(&mut self.names, &mut records, &walk.name)?;
            records.push(match walk.gait {
                Gait::Walk => 0,
                Gait::Run => 1,
            });
            records.extend(narrow::<u16>(walk.subject)?.to_le_bytes());
            records.extend(narrow::<u16>(walk.cycle)?.to_le_bytes());
            records.extend(tenths(walk.speed_mps * 1e3, "speed")?.to_le_bytes());
            records.extend(narrow::<u16>(walk.clip)?.to_le_bytes());
            records.extend([0, 0]);
        }
        Ok(records)
    }
}

/// Appends a name's offset and length to a record, and the name itself to the
/// names unless it is there already.
fn push_name(names: &mut Vec<u8>, record: &mut Vec<u8>, name: &str) -> Result<()> {
    let length = u8::try_from(name.len())
        .map_err(|_| Error::Failed(format!("the name {name:?}: expected at most 255 bytes")))?;
    let known = names
        .windows(name.len().max(1))
        .position(|window| window == name.as_bytes());
    let at = known.unwrap_or_else(|| {
        names.extend(name.as_bytes());
        names.len() - name.len()
    });
    record.extend(narrow::<u32>(at)?.to_le_bytes());
    record.push(length);
    Ok(())
}

/// Entries behind a table of their ends.
fn table(entries: &[Vec<u8>]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    bytes.extend(narrow::<u32>(entries.len())?.to_le_bytes());
    let mut end = 0;
    for entry in entries {
        end += entry.len();
        bytes.extend(narrow::<u32>(end)?.to_le_bytes());
    }
    bytes.extend(entries.iter().flatten());
    Ok(bytes)
}

/// A number that must fit the format's field.
fn narrow<T: TryFrom<usize>>(value: usize) -> Result<T> {
    T::try_from(value)
        .map_err(|_| Error::Failed(format!("{value} entries or bytes: more than a pack holds")))
}

/// A quantity rounded to a whole number of its unit that must fit a `u16`.
fn tenths(value: f64, what: &str) -> Result<u16> {
    let rounded = value.round();
    if !(0.0..=65_535.0).contains(&rounded) {
        return Err(Error::Failed(format!(
            "a {what} of {value} units: expected 0 to 65535"
        )));
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked above"
    )]
    let value = rounded as u16;
    Ok(value)
}
