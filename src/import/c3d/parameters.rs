//! The parameter section of a C3D file: a chain of named values in groups.
//!
//! Each record points at the next. Pointers and sizes come from the file and are
//! believed only where they stay inside of the section.

use std::collections::HashMap;
use std::path::Path;

use super::machine::NumberFormat;
use crate::error::{Error, FilePlace, Result};

/// The groups that are kept. Subjects' names, which other groups hold, are never decoded.
const GROUPS: [&str; 2] = ["POINT", "TRIAL"];

/// Most dimensions of a value (the C3D file format user guide, 2008, section "Parameter
/// format").
const MAX_DIMENSIONS: u8 = 7;

/// The section's bytes with their place in the file.
#[derive(Clone, Copy)]
pub(super) struct ParameterSection<'a> {
    pub(super) path: &'a Path,
    pub(super) bytes: &'a [u8],
    /// Of the first of the bytes.
    pub(super) start: usize,
    pub(super) machine: NumberFormat,
}

impl<'a> ParameterSection<'a> {
    fn error(&self, at: usize, problem: impl Into<String>) -> Error {
        Error::at(self.path, FilePlace::Byte(self.start + at), problem)
    }

    fn slice(&self, at: usize, count: usize) -> Result<&'a [u8]> {
        let end = at.checked_add(count);
        end.and_then(|end| self.bytes.get(at..end)).ok_or_else(|| {
            let end = self.start + self.bytes.len();
            let problem = format!(
                "a parameter runs out of the parameter section, which ends at byte {end} (is the file damaged?)"
            );
            self.error(at, problem)
        })
    }

    fn array<const N: usize>(&self, at: usize) -> Result<[u8; N]> {
        let mut array = [0; N];
        array.copy_from_slice(self.slice(at, N)?);
        Ok(array)
    }
}

/// A value, not decoded yet.
struct StoredParameter<'a> {
    group: i8,
    name: String,
    kind: i8,
    dimensions: &'a [u8],
    bytes: &'a [u8],
}

/// A decoded value.
enum ParameterValue {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
}

/// The values of the groups that are kept, by `GROUP:NAME`.
pub(super) struct C3dParameters {
    values: HashMap<String, ParameterValue>,
    /// What was odd about the section.
    pub(super) warnings: Vec<String>,
}

impl C3dParameters {
    /// Follows the chain and decodes what is kept.
    ///
    /// # Errors
    /// Names that are not ASCII, unknown types, values larger than their record or the section.
    pub(super) fn read(section: ParameterSection<'_>) -> Result<Self> {
        let mut groups: HashMap<i8, String> = HashMap::new();
        let mut stored: Vec<StoredParameter<'_>> = Vec::new();
        let mut warnings = Vec::new();
        // The four bytes before the first record are the section's own.
        let mut at = 4;
        while at < section.bytes.len() {
            let [length, id] = section.array(at)?;
            let (length, id) = (length.cast_signed().unsigned_abs(), id.cast_signed());
            if length == 0 || id == 0 {
                break;
            }
            let name = section.slice(at + 2, length.into())?;
            if !name.iter().all(|byte| matches!(byte, b' '..=b'~')) {
                return Err(section.error(
                    at,
                    "expected a parameter, found a name that is not ASCII (is the file damaged?)",
                ));
            }
            let name = String::from_utf8_lossy(name).trim().to_ascii_uppercase();
            let pointer = at + 2 + usize::from(length);
            let offset = usize::from(section.machine.word(section.array(pointer)?));
            let next = (offset > 0).then_some(pointer + offset);
            let leads_out = next.is_some_and(|next| next > section.bytes.len());
            if id < 0 {
                groups.insert(id, name);
            } else {
                // A record's data end where the next record begins.
                let end = next.filter(|_| !leads_out).unwrap_or(section.bytes.len());
                stored.push(read_value(&section, id, name, pointer + 2..end)?);
            }
            if leads_out {
                let place = section.start + pointer;
                warnings.push(format!(
                    "the parameter at byte {place} points out of the parameter section: taken as the last"
                ));
            }
            match next {
                Some(next) if !leads_out => at = next,
                _ => break,
            }
        }
        let values = stored
            .iter()
            .filter_map(|value| {
                let group = groups.get(&value.group.checked_neg()?)?;
                GROUPS.contains(&group.as_str()).then(|| {
                    (
                        format!("{group}:{}", value.name),
                        decode(value, section.machine),
                    )
                })
            })
            .collect();
        Ok(Self { values, warnings })
    }

    /// All numbers of a value; none if there is no such value.
    pub(super) fn numbers(&self, name: &str) -> &[f64] {
        match self.values.get(name) {
            Some(ParameterValue::Numbers(numbers)) => numbers,
            _ => &[],
        }
    }

    /// The first number of a value.
    pub(super) fn number(&self, name: &str) -> Option<f64> {
        self.numbers(name).first().copied()
    }

    /// The first number as a count: words are unsigned there, though stored as signed ones.
    pub(super) fn count(&self, name: &str) -> Option<f64> {
        self.number(name).map(unsigned)
    }

    /// All texts of a value, trimmed, and those of its continuations (`LABELS2`, `LABELS3`).
    pub(super) fn texts(&self, name: &str) -> Vec<&str> {
        let mut all = Vec::new();
        let mut key = name.to_owned();
        let mut part = 1;
        while let Some(ParameterValue::Texts(texts)) = self.values.get(&key) {
            all.extend(texts.iter().map(String::as_str));
            part += 1;
            key = format!("{name}{part}");
        }
        all
    }
}

/// What a word that was stored as a signed one counts.
pub(super) fn unsigned(word: f64) -> f64 {
    if word < 0.0 { word + 65_536.0 } else { word }
}

/// The value in `range`, which begins with the type.
fn read_value<'a>(
    section: &ParameterSection<'a>,
    group: i8,
    name: String,
    range: std::ops::Range<usize>,
) -> Result<StoredParameter<'a>> {
    let [kind, dimension_count] = section.array(range.start)?;
    let kind = kind.cast_signed();
    if !matches!(kind, -1 | 1 | 2 | 4) {
        let problem = format!("parameter {name}: expected type -1, 1, 2 or 4, found {kind}");
        return Err(section.error(range.start, problem));
    }
    if dimension_count > MAX_DIMENSIONS {
        let problem = format!(
            "parameter {name}: expected at most {MAX_DIMENSIONS} dimensions, found {dimension_count}"
        );
        return Err(section.error(range.start, problem));
    }
    let dimensions = section.slice(range.start + 2, dimension_count.into())?;
    // At most 255^7 * 4: no overflow.
    let size = dimensions
        .iter()
        .fold(u64::from(kind.unsigned_abs()), |size, &n| {
            size * u64::from(n)
        });
    let first = range.start + 2 + dimensions.len();
    let room = range.end.saturating_sub(first);
    if size > room as u64 {
        let problem = format!(
            "parameter {name}: its {size} bytes of data do not fit the {room} bytes up to the next parameter or the section's end (is the file damaged?)"
        );
        return Err(section.error(range.start, problem));
    }
    let size = usize::try_from(size).unwrap_or(room);
    Ok(StoredParameter {
        group,
        name,
        kind,
        dimensions,
        bytes: section.slice(first, size)?,
    })
}

fn decode(stored: &StoredParameter<'_>, machine: NumberFormat) -> ParameterValue {
    match stored.kind {
        -1 => {
            let width = stored.dimensions.first().copied().unwrap_or(1);
            let text = |bytes: &[u8]| {
                let text = String::from_utf8_lossy(bytes);
                text.trim_matches(|c: char| c == '\0' || c.is_whitespace())
                    .to_owned()
            };
            ParameterValue::Texts(
                stored
                    .bytes
                    .chunks_exact(usize::from(width).max(1))
                    .map(text)
                    .collect(),
            )
        }
        1 => ParameterValue::Numbers(stored.bytes.iter().map(|&byte| byte.into()).collect()),
        2 => {
            let (words, _) = stored.bytes.as_chunks();
            ParameterValue::Numbers(
                words
                    .iter()
                    .map(|&word| machine.integer(word).into())
                    .collect(),
            )
        }
        _ => {
            let (reals, _) = stored.bytes.as_chunks();
            ParameterValue::Numbers(reals.iter().map(|&real| machine.real(real)).collect())
        }
    }
}
