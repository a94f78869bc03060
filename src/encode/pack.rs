//! Assembly of packs from encoded bodies and walks.

use super::avatar::encode_avatar;
use super::codebook::CodeSections;
use super::entry_table::{narrow, table};
use super::motion_sections::{EncodableMotion, MotionSections, Stopped};
use super::target::EncodingTarget;
use super::{target, uncut};
use crate::error::{EncodeError, Error, RefusedWalk, Result};
use crate::people::{Subject, Track, Walk};
use edgegait_core::avatar::Avatar;
use edgegait_core::format::{
    CRC_AT, HEADER_BYTES, LENGTH_AT, MAGIC, SECTION_ENTRY_BYTES, SECTION_ORDER, SECTIONS_AT,
    SEX_BITS, SUBJECT_BYTES, UNDER_AGE_YEARS, VERSION, VERSION_AT, crc32,
};
use edgegait_core::pack::{Gait, Pack, Sex};
use edgegait_core::skeleton::Skeleton;
use rayon::prelude::*;
use std::collections::HashSet;

/// The ratio of a body's error to a walk's error, and the most error of a body. Our choice: 2 mm
/// for walks at 5 mm, where a pixel of a GEI is about 35 mm of the body; errors beyond 4 mm save
/// little.
const BODY_SHARE: f64 = 0.4;
const MOST_BODY_ERROR_MM: f64 = 4.0;

/// The number of times that [`encode_subjects`] reports progress for each walk: after analysis, and
/// after encoding.
pub const STEPS_OF_WALK: usize = 2;

/// Returns the greatest error, mm, of bodies in a pack whose walks are encoded within
/// `max_error_mm`.
#[must_use]
pub fn body_error_mm(max_error_mm: f64) -> f64 {
    (BODY_SHARE * max_error_mm).min(MOST_BODY_ERROR_MM)
}

/// Encodes people, their bodies and their walks as one pack: each walk within `max_error_mm` and
/// each body within [`body_error_mm`], where the format allows it. Runs on all cores, about
/// 0.05 s a walk on one core; `progress` is called [`STEPS_OF_WALK`] times a walk.
///
/// # Errors
/// For bodies and cycles that the format does not hold, for too many of them, and for people who
/// share a name; the error of `progress`, which ends the work.
pub fn encode_subjects(
    subjects: &[Subject],
    max_error_mm: f64,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<Vec<u8>> {
    check_walks(subjects)?;
    let encode = |subject| Bodies::encode(subject, body_error_mm(max_error_mm));
    let bodies: Vec<Result<Bodies>> = subjects.par_iter().map(encode).collect();
    let refused_bodies = subjects.iter().zip(&bodies).filter_map(|(subject, body)| {
        Some(RefusedWalk {
            subject: subject.name.clone(),
            walk: None,
            problem: body.as_ref().err()?.to_string(),
        })
    });
    let refused_bodies: Vec<RefusedWalk> = refused_bodies.collect();
    if !refused_bodies.is_empty() {
        return Err(Error::Refused(refused_bodies));
    }
    let bodies = bodies.into_iter().collect::<Result<Vec<_>>>()?;
    let (mut motions, mut whose) = (Vec::new(), Vec::new());
    for (subject, bodies) in subjects.iter().zip(&bodies) {
        let skeleton = bodies.skeleton()?;
        for walk in &subject.walks {
            whose.push((subject, walk));
            motions.push(match &walk.motion {
                Track::Loop(cycle) => {
                    let target = EncodingTarget::new(cycle, skeleton.clone());
                    let named = |error| Error::Refused(vec![refused(subject, walk, &error)]);
                    EncodableMotion::Loop(Box::new(target.map_err(named)?))
                }
                Track::Uncut(span) => EncodableMotion::Uncut(span, Box::new(skeleton.clone())),
            });
        }
    }
    let tracks = MotionSections::encode(&motions, max_error_mm, progress).map_err(|stopped| {
        let refused = |(number, error): (usize, Error)| {
            let (subject, walk) = whose[number];
            refused(subject, walk, &error)
        };
        match stopped {
            Stopped::Motions(list) => Error::Refused(list.into_iter().map(refused).collect()),
            Stopped::Else(error) => error,
        }
    })?;
    let mut clips = tracks.clips.into_iter();
    let mut builder = PackBuilder::default();
    for (subject, bodies) in subjects.iter().zip(bodies) {
        builder.add(
            subject,
            bodies,
            clips.by_ref().take(subject.walks.len()).collect(),
        )?;
    }
    builder.finish(tracks.sections)
}

/// Checks that a pack can hold each of the walks. It is cheap, and the first step of
/// [`encode_subjects`].
///
/// # Errors
/// If a walk cannot be held; the error lists all such walks.
pub fn check_walks(subjects: &[Subject]) -> Result<()> {
    let walks = subjects
        .iter()
        .flat_map(|subject| subject.walks.iter().map(move |walk| (subject, walk)));
    let refused: Vec<RefusedWalk> = walks
        .filter_map(|(subject, walk)| {
            let checked = match &walk.motion {
                Track::Loop(cycle) => target::check(cycle),
                Track::Uncut(span) => uncut::check(span),
            };
            let checked = checked.and_then(|()| whole_speed(walk).map(drop));
            checked.err().map(|error| refused(subject, walk, &error))
        })
        .collect();
    if refused.is_empty() {
        Ok(())
    } else {
        Err(Error::Refused(refused))
    }
}

/// Returns an error with the walk to which it belongs.
pub(super) fn refused(subject: &Subject, walk: &Walk, error: &Error) -> RefusedWalk {
    RefusedWalk {
        subject: subject.name.clone(),
        walk: Some((walk.name.clone(), walk.cycle)),
        problem: error.to_string(),
    }
}

/// Returns a walk's speed in the format's units.
fn whole_speed(walk: &Walk) -> Result<u16> {
    whole(walk.speed_mps * 1e3, "a speed of", "mm/s")
}

/// The range from which [`encode_within`] chooses the greatest error, mm: smaller errors are below
/// the resolution of motion capture, and larger ones change the walk.
const BUDGET_ERRORS_MM: (f64, f64) = (0.1, 100.0);
/// The number of encodings by [`encode_within`]: its search to 2.7 %, and the coarse end.
pub const BUDGET_TRIES: usize = 9;

/// Encodes people in at most `budget_bytes`, with the smallest error from 0.1 to 100 mm that fits,
/// to 2.7 %. Returns the pack's bytes and this error in mm. Encodes [`BUDGET_TRIES`] times.
///
/// # Errors
/// If the pack exceeds the budget even at 100 mm, and the errors of [`encode_subjects`].
pub fn encode_within(
    subjects: &[Subject],
    budget_bytes: usize,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<(Vec<u8>, f64)> {
    let (mut low, mut high) = BUDGET_ERRORS_MM;
    let mut best = encode_subjects(subjects, high, progress)?;
    if best.len() > budget_bytes {
        return Err(EncodeError::OverBudget {
            budget: budget_bytes,
            people: subjects.len(),
            walks: subjects.iter().map(|subject| subject.walks.len()).sum(),
            found: best.len(),
            error_mm: high,
        }
        .into());
    }
    for _ in 1..BUDGET_TRIES {
        let middle = (low * high).sqrt();
        let bytes = encode_subjects(subjects, middle, progress)?;
        if bytes.len() <= budget_bytes {
            (best, high) = (bytes, middle);
        } else {
            low = middle;
        }
    }
    Ok((best, high))
}

/// A person's encoded body, and the dressed bodies of single walks.
#[derive(Clone, Debug)]
pub(super) struct Bodies {
    own: Vec<u8>,
    /// The dressed bodies in the order of the walks.
    worn: Vec<Option<Vec<u8>>>,
}

impl Bodies {
    pub(super) fn encode(subject: &Subject, max_error_mm: f64) -> Result<Self> {
        let encode = |body| Ok(encode_avatar(body, max_error_mm)?.bytes);
        let worn = subject.walks.iter().map(|walk| walk.worn.as_ref());
        Ok(Self {
            own: encode(&subject.body)?,
            worn: worn
                .map(|body| body.map(encode).transpose())
                .collect::<Result<_>>()?,
        })
    }

    /// Returns the skeleton, which does not depend on clothes.
    pub(super) fn skeleton(&self) -> Result<Skeleton> {
        Ok(Avatar::parse(&self.own)?.skeleton())
    }
}

/// A collector of records, names and encoded parts.
#[derive(Clone, Debug, Default)]
pub(super) struct PackBuilder {
    names: String,
    subjects: Vec<u8>,
    subject_names: HashSet<String>,
    walks: Vec<u8>,
    avatars: Vec<Vec<u8>>,
    clips: Vec<Vec<u8>>,
}

impl PackBuilder {
    /// Adds a person with their encoded body and walks.
    ///
    /// # Errors
    /// For numbers that the format does not hold, and a person whose name is in use.
    pub(super) fn add(
        &mut self,
        subject: &Subject,
        bodies: Bodies,
        clips: Vec<Vec<u8>>,
    ) -> Result<()> {
        if !self.subject_names.insert(subject.name.clone()) {
            return Err(EncodeError::SameName(subject.name.clone()).into());
        }
        let number = narrow::<u16>(self.subjects.len() / SUBJECT_BYTES)?;
        let record = &mut self.subjects;
        push_name(&mut self.names, record, &subject.name)?;
        let sex = match subject.sex {
            None => 0,
            Some(Sex::Female) => 1,
            Some(Sex::Male) => 2,
        };
        record.push(sex | age(subject.age_years)? << SEX_BITS.count_ones());
        record.extend(whole(subject.stature_m * 1e3, "a stature of", "mm")?.to_le_bytes());
        record.extend(whole(subject.mass_kg * 10.0, "a mass of", "x 0.1 kg")?.to_le_bytes());
        record.extend(narrow::<u16>(self.avatars.len())?.to_le_bytes());
        self.avatars.push(bodies.own);
        for ((walk, clip), worn) in subject.walks.iter().zip(clips).zip(bodies.worn) {
            let record = &mut self.walks;
            push_name(&mut self.names, record, &walk.name)?;
            record.push(match walk.gait {
                Gait::Walk => 0,
                Gait::Run => 1,
            });
            record.extend(number.to_le_bytes());
            record.extend(walk.cycle.to_le_bytes());
            record.extend(whole_speed(walk)?.to_le_bytes());
            record.extend(narrow::<u16>(self.clips.len())?.to_le_bytes());
            self.clips.push(clip);
            let avatar = match worn {
                None => 0,
                Some(avatar) => {
                    self.avatars.push(avatar);
                    narrow::<u16>(self.avatars.len())?
                }
            };
            record.extend(avatar.to_le_bytes());
        }
        Ok(())
    }

    /// Returns the number of people that were added.
    pub(super) const fn people(&self) -> usize {
        self.subjects.len() / SUBJECT_BYTES
    }

    /// Returns the length of the pack with this code, in bytes.
    pub(super) fn len_bytes(&self, code: &CodeSections) -> usize {
        let records = self.names.len() + self.subjects.len() + self.walks.len();
        let table =
            |entries: &[Vec<u8>]| 4 + entries.iter().map(|entry| 4 + entry.len()).sum::<usize>();
        let header = HEADER_BYTES + SECTION_ORDER.len() * SECTION_ENTRY_BYTES;
        let code = code.codebook.len() + code.templates.len();
        header + records + table(&self.avatars) + code + table(&self.clips)
    }

    /// Returns the pack's bytes, after a check by the core's parser.
    pub(super) fn finish(self, code: CodeSections) -> Result<Vec<u8>> {
        let sections = [
            self.names.into_bytes(),
            self.subjects,
            self.walks,
            table(&self.avatars)?,
            code.codebook,
            code.templates,
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
        Pack::parse(&bytes).map_err(EncodeError::read_back("the pack"))?;
        Ok(bytes)
    }
}

/// Appends a name's offset and length to a record, and the name itself to the
/// names unless it is there already.
fn push_name(names: &mut String, record: &mut Vec<u8>, name: &str) -> Result<()> {
    let length = u8::try_from(name.len()).map_err(|_| EncodeError::NameTooLong(name.to_owned()))?;
    let at = names.find(name).unwrap_or_else(|| {
        names.push_str(name);
        names.len() - name.len()
    });
    record.extend(narrow::<u32>(at)?.to_le_bytes());
    record.push(length);
    Ok(())
}

/// Returns an age in the format's units, rounded down; 0 for none.
fn age(years: Option<f64>) -> Result<u8> {
    let Some(years) = years else {
        return Ok(0);
    };
    let (least, most) = (
        UNDER_AGE_YEARS + 1,
        UNDER_AGE_YEARS + (u8::MAX >> SEX_BITS.count_ones()),
    );
    let whole = (least..=most).find(|&whole| f64::from(whole) == years.floor());
    whole.map(|whole| whole - UNDER_AGE_YEARS).ok_or_else(|| {
        EncodeError::OutOfRange {
            what: "an age of",
            found: years,
            unit: "years",
            expected: "18 to 80, or none",
        }
        .into()
    })
}

/// Rounds a quantity to a whole number of its unit, which must fit a `u16`.
fn whole(value: f64, what: &'static str, unit: &'static str) -> Result<u16> {
    let rounded = value.round();
    if !(0.0..=65_535.0).contains(&rounded) {
        return Err(EncodeError::OutOfRange {
            what,
            found: value,
            unit,
            expected: "0 to 65535",
        }
        .into());
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked above"
    )]
    let value = rounded as u16;
    Ok(value)
}
