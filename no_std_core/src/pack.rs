//! Packs: subjects, their bodies and their walks in one block of bytes.
//!
//! The bytes are borrowed, from flash or from a `Vec`. [`Pack::parse`] checks all
//! of them once, down to the last clip and hull; what it returns cannot fail.

use crate::avatar::Avatar;
use crate::budget::{MAX_ENTRIES, MAX_PACK_BYTES};
use crate::clip::Clip;
use crate::codebook::{CodeTable, Codebook};
use crate::entry_table::EntryTable;
use crate::format::{
    CRC_AT, FormatError, HEADER_BYTES, LENGTH_AT, MAGIC, SECTION_ENTRY_BYTES, SECTION_ORDER,
    SECTIONS_AT, SEX_BITS, SUBJECT_BYTES, UNDER_AGE_YEARS, VERSION, VERSION_AT, WALK_BYTES, crc32,
    u16_at, u32_at,
};
use core::ops::Range;

/// A parsed pack.
#[derive(Clone, Copy, Debug)]
pub struct Pack<'a> {
    names: &'a [u8],
    subjects: &'a [u8],
    walks: &'a [u8],
    avatars: EntryTable<'a>,
    codebook: Codebook<'a>,
    clips: EntryTable<'a>,
    section_bytes: [usize; SECTION_ORDER.len()],
    bytes: usize,
}

/// A person.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SubjectEntry<'a> {
    /// Name. The writer keeps names unique; the reader does not check it.
    pub name: &'a str,
    /// Sex, if stated.
    pub sex: Option<Sex>,
    /// Age, years, 18 to 80, if known.
    pub age_years: Option<u8>,
    /// Stature, mm; 0 if unknown.
    pub stature_mm: u16,
    /// Mass, 0.1 kg; 0 if unknown.
    pub mass_hg: u16,
    /// The number of the avatar that is the person's body.
    pub avatar: usize,
}

/// A person's sex, as distinguished by norms of body dimensions and gait.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Sex {
    /// Female.
    Female,
    /// Male.
    Male,
}

impl Sex {
    /// Returns the name in tables and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Female => "female",
            Self::Male => "male",
        }
    }
}

/// A walk of a person: a gait cycle or an uncut motion, recorded or synthetic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WalkEntry<'a> {
    /// Name of the take, for example `walk-5kmh` or `07_01`.
    pub name: &'a str,
    /// The number of the subject who walks.
    pub subject: usize,
    /// The number of the cycle in the take, from 0.
    pub cycle: u16,
    /// Whether the subject walks or runs.
    pub gait: Gait,
    /// Mean speed, mm/s.
    pub speed_mm_per_s: u16,
    /// The number of the clip that holds the motion.
    pub clip: usize,
    /// The number of the avatar that walks: the subject's own, or the one dressed for this walk.
    pub avatar: usize,
}

/// The kind of gait: walking or running.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Gait {
    /// At least one foot is on the floor at any time.
    Walk,
    /// There is a flight phase.
    Run,
}

impl Gait {
    /// Returns the name in tables and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Walk => "walk",
            Self::Run => "run",
        }
    }
}

impl<'a> Pack<'a> {
    /// Checks all of `bytes`.
    ///
    /// # Errors
    /// If the bytes are not a pack of this version. The error states the byte, and what was
    /// expected there.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, FormatError> {
        check_header(bytes)?;
        let (sections, starts) = sections(bytes)?;
        let [names, subjects, walks, avatars, code, templates, clips] = sections;
        let [
            _,
            subjects_at,
            walks_at,
            avatars_at,
            code_at,
            templates_at,
            clips_at,
        ] = starts;
        let codebook = Codebook::parse(code).map_err(|e| e.behind(code_at))?;
        let codes = CodeTable::from_codebook(&codebook);
        let codebook = codebook
            .with_checked(templates, &codes)
            .map_err(|e| e.behind(templates_at))?;
        let pack = Self {
            names,
            subjects,
            walks,
            avatars: EntryTable::parse(avatars).map_err(|e| e.behind(avatars_at))?,
            codebook,
            clips: EntryTable::parse(clips).map_err(|e| e.behind(clips_at))?,
            section_bytes: sections.map(<[u8]>::len),
            bytes: bytes.len(),
        };
        pack.check_subjects().map_err(|e| e.behind(subjects_at))?;
        pack.check_walks().map_err(|e| e.behind(walks_at))?;
        for (at, entry) in pack.avatars.entries() {
            Avatar::parse(entry).map_err(|e| e.behind(avatars_at + at))?;
        }
        for (at, entry) in pack.clips.entries() {
            Clip::check(entry, &pack.codebook, &codes).map_err(|e| e.behind(clips_at + at))?;
        }
        Ok(pack)
    }

    /// Opens bytes that [`Self::parse`] has accepted before. Neither the checksum nor the entries
    /// are read again, so that opening a pack of thousands of people takes microseconds.
    ///
    /// From other bytes the results are wrong, and its methods may panic.
    ///
    /// # Errors
    /// If the bytes do not have the sections of a pack.
    pub fn reopen(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let (sections, [_, _, _, avatars_at, code_at, templates_at, clips_at]) = sections(bytes)?;
        let [names, subjects, walks, avatars, code, templates, clips] = sections;
        let codebook = Codebook::parse(code).map_err(|e| e.behind(code_at))?;
        Ok(Self {
            names,
            subjects,
            walks,
            avatars: EntryTable::parse(avatars).map_err(|e| e.behind(avatars_at))?,
            codebook: codebook
                .over(templates)
                .map_err(|e| e.behind(templates_at))?,
            clips: EntryTable::parse(clips).map_err(|e| e.behind(clips_at))?,
            section_bytes: sections.map(<[u8]>::len),
            bytes: bytes.len(),
        })
    }

    fn check_subjects(&self) -> Result<(), FormatError> {
        if !self.subjects.len().is_multiple_of(SUBJECT_BYTES)
            || self.subjects.len() / SUBJECT_BYTES > MAX_ENTRIES
        {
            return Err(FormatError::new(0, "whole subject records, at most 65535"));
        }
        let names = core::str::from_utf8(self.names).ok();
        for (index, record) in self.subjects.chunks_exact(SUBJECT_BYTES).enumerate() {
            let at = index * SUBJECT_BYTES;
            if !self.has_name(record, names) {
                return Err(FormatError::new(at, "a UTF-8 name within section NAME"));
            }
            if record.get(5).is_none_or(|&person| person & SEX_BITS > 2) {
                return Err(FormatError::new(at + 5, "sex 0 (unknown), 1 or 2"));
            }
            if usize::from(u16_at(record, 10)) >= self.avatars.len() {
                return Err(FormatError::new(at + 10, "the number of an avatar"));
            }
        }
        Ok(())
    }

    fn check_walks(&self) -> Result<(), FormatError> {
        if !self.walks.len().is_multiple_of(WALK_BYTES)
            || self.walks.len() / WALK_BYTES > MAX_ENTRIES
        {
            return Err(FormatError::new(0, "whole walk records, at most 65535"));
        }
        let names = core::str::from_utf8(self.names).ok();
        for (index, record) in self.walks.chunks_exact(WALK_BYTES).enumerate() {
            let at = index * WALK_BYTES;
            if !self.has_name(record, names) {
                return Err(FormatError::new(at, "a UTF-8 name within section NAME"));
            }
            if record.get(5).is_none_or(|&gait| gait > 1) {
                return Err(FormatError::new(at + 5, "gait 0 (walk) or 1 (run)"));
            }
            if usize::from(u16_at(record, 6)) >= self.subjects.len() / SUBJECT_BYTES {
                return Err(FormatError::new(at + 6, "the number of a subject"));
            }
            if usize::from(u16_at(record, 12)) >= self.clips.len() {
                return Err(FormatError::new(at + 12, "the number of a clip"));
            }
            if usize::from(u16_at(record, 14)) > self.avatars.len() {
                return Err(FormatError::new(
                    at + 14,
                    "0, or the number of an avatar plus 1",
                ));
            }
        }
        Ok(())
    }

    /// Returns the name that the start of a record points to.
    fn name(&self, record: &[u8]) -> Option<&'a str> {
        core::str::from_utf8(self.names.get(name_range(record)?)?).ok()
    }

    /// Returns whether a record has a name. `names` are all names if these are text as a whole, so
    /// that the many records of one name need not read it again.
    fn has_name(&self, record: &[u8], names: Option<&str>) -> bool {
        let read = names.zip(name_range(record));
        read.is_some_and(|(names, range)| names.get(range).is_some()) || self.name(record).is_some()
    }

    /// Returns the length of the whole pack, bytes.
    #[must_use]
    pub const fn len_bytes(&self) -> usize {
        self.bytes
    }

    /// Returns the subjects, in file order.
    pub fn subjects(&self) -> impl ExactSizeIterator<Item = SubjectEntry<'a>> + use<'a> {
        let pack = *self;
        let records = self.subjects.chunks_exact(SUBJECT_BYTES);
        records.map(move |record| pack.subject_of(record))
    }

    /// Returns the subject with this number, in constant time.
    #[must_use]
    pub fn subject(&self, index: usize) -> Option<SubjectEntry<'a>> {
        let mut records = self.subjects.chunks_exact(SUBJECT_BYTES);
        records.nth(index).map(|record| self.subject_of(record))
    }

    fn subject_of(&self, record: &[u8]) -> SubjectEntry<'a> {
        let person = record.get(5).copied().unwrap_or(0);
        let age = person >> SEX_BITS.count_ones();
        SubjectEntry {
            name: self.name(record).unwrap_or_default(),
            sex: match person & SEX_BITS {
                1 => Some(Sex::Female),
                2 => Some(Sex::Male),
                _ => None,
            },
            age_years: (age > 0).then_some(age + UNDER_AGE_YEARS),
            stature_mm: u16_at(record, 6),
            mass_hg: u16_at(record, 8),
            avatar: usize::from(u16_at(record, 10)),
        }
    }

    /// Returns the walks, in file order.
    pub fn walks(&self) -> impl ExactSizeIterator<Item = WalkEntry<'a>> + use<'a> {
        let pack = *self;
        let records = self.walks.chunks_exact(WALK_BYTES);
        records.map(move |record| pack.walk_of(record))
    }

    /// Returns the walk with this number, in constant time.
    #[must_use]
    pub fn walk(&self, index: usize) -> Option<WalkEntry<'a>> {
        let mut records = self.walks.chunks_exact(WALK_BYTES);
        records.nth(index).map(|record| self.walk_of(record))
    }

    fn walk_of(&self, record: &[u8]) -> WalkEntry<'a> {
        let subject = usize::from(u16_at(record, 6));
        WalkEntry {
            name: self.name(record).unwrap_or_default(),
            subject,
            cycle: u16_at(record, 8),
            gait: if record.get(5) == Some(&1) {
                Gait::Run
            } else {
                Gait::Walk
            },
            speed_mm_per_s: u16_at(record, 10),
            clip: usize::from(u16_at(record, 12)),
            avatar: match usize::from(u16_at(record, 14)) {
                0 => usize::from(u16_at(self.subjects, SUBJECT_BYTES * subject + 10)),
                worn => worn - 1,
            },
        }
    }

    /// Returns the number of avatars.
    #[must_use]
    pub fn avatar_count(&self) -> usize {
        self.avatars.len()
    }

    /// Returns the avatar with this number, without further checks: [`Self::parse`] has checked it.
    #[must_use]
    pub fn avatar(&self, index: usize) -> Option<Avatar<'a>> {
        self.avatars
            .entry(index)
            .map(|(_, entry)| Avatar::over(entry))
    }

    /// Returns the number of clips.
    #[must_use]
    pub fn clip_count(&self) -> usize {
        self.clips.len()
    }

    /// Returns the clip with this number. [`Self::parse`] has checked it: only the channel table of
    /// an uncut clip is read again, and nothing of a loop.
    #[must_use]
    pub fn clip(&self, index: usize) -> Option<Clip<'a>> {
        // Cannot fail for an entry, which has been checked.
        Clip::over(self.clips.entry(index)?.1, &self.codebook).ok()
    }

    /// Returns the codebook that the clips share.
    #[must_use]
    pub const fn codebook(&self) -> &Codebook<'a> {
        &self.codebook
    }

    /// Returns the bytes of each section, in the order of [`SECTION_ORDER`].
    #[must_use]
    pub const fn section_bytes(&self) -> [usize; SECTION_ORDER.len()] {
        self.section_bytes
    }
}

/// Finds the sections, and where each starts.
// Inlined into its callers: a board has no room for another copy on its stack.
#[inline(always)]
fn sections(
    bytes: &[u8],
) -> Result<([&[u8]; SECTION_ORDER.len()], [usize; SECTION_ORDER.len()]), FormatError> {
    let mut sections = [&[] as &[u8]; SECTION_ORDER.len()];
    let mut starts = [0; SECTION_ORDER.len()];
    let mut end = HEADER_BYTES + SECTION_ORDER.len() * SECTION_ENTRY_BYTES;
    for (index, kind) in SECTION_ORDER.iter().enumerate() {
        let entry = HEADER_BYTES + index * SECTION_ENTRY_BYTES;
        if bytes.get(entry..entry + 4) != Some(kind) {
            return Err(FormatError::new(
                entry,
                "sections NAME, SUBJ, WALK, AVAT, CODE, TMPL, CLIP in this order",
            ));
        }
        if u32_at(bytes, entry + 4) as usize != end {
            return Err(FormatError::new(
                entry + 4,
                "a section that begins where the previous one ends",
            ));
        }
        let length = u32_at(bytes, entry + 8) as usize;
        let section = end.checked_add(length).and_then(|to| bytes.get(end..to));
        let Some(section) = section else {
            return Err(FormatError::new(entry + 8, "a section within the pack"));
        };
        sections[index] = section;
        starts[index] = end;
        end += length;
    }
    if end != bytes.len() {
        return Err(FormatError::new(end, "the end of the pack"));
    }
    Ok((sections, starts))
}

/// Checks magic, version, number of sections, length and checksum.
/// Returns where the name of a record lies among the names.
fn name_range(record: &[u8]) -> Option<Range<usize>> {
    let start = u32_at(record, 0) as usize;
    let end = start.checked_add(usize::from(*record.get(4)?))?;
    Some(start..end)
}

fn check_header(bytes: &[u8]) -> Result<(), FormatError> {
    let table = HEADER_BYTES + SECTION_ORDER.len() * SECTION_ENTRY_BYTES;
    if bytes.get(..4) != Some(&MAGIC) {
        return Err(FormatError::new(0, "\"EGPK\", the first bytes of a pack"));
    }
    if bytes.len() < table {
        return Err(FormatError::new(bytes.len(), "the rest of the header"));
    }
    if u16_at(bytes, VERSION_AT) != VERSION {
        return Err(FormatError::new(
            VERSION_AT,
            "version 1 (make the pack again, or use the EdgeGait that wrote it)",
        ));
    }
    if usize::from(u16_at(bytes, SECTIONS_AT)) != SECTION_ORDER.len() {
        return Err(FormatError::new(
            SECTIONS_AT,
            "7 sections (if an older EdgeGait wrote the pack, make it again)",
        ));
    }
    if bytes.len() > MAX_PACK_BYTES || u32_at(bytes, LENGTH_AT) as usize != bytes.len() {
        return Err(FormatError::new(
            LENGTH_AT,
            "the length of the file, at most 16 MiB (was it cut off?)",
        ));
    }
    if u32_at(bytes, CRC_AT) != crc32(bytes.get(HEADER_BYTES..).unwrap_or_default()) {
        return Err(FormatError::new(
            CRC_AT,
            "the CRC-32 of what follows (the file is damaged)",
        ));
    }
    Ok(())
}
