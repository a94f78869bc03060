//! Reader of the parameter section of a C3D file: a chain of named values in groups.
//!
//! Each record points at the next. Pointers and sizes come from the file, so they must stay inside
//! the section.

use std::collections::HashMap;
use std::path::Path;

use super::machine::NumberFormat;
use crate::error::{Error, FilePlace, Result};

/// The groups that are kept. Subjects' names are in other groups and never decoded.
const GROUPS: [&str; 2] = ["POINT", "TRIAL"];

/// The maximum number of dimensions in a value (the C3D file format user guide, 2008, section
/// "Parameter format").
const MAX_DIMENSIONS: u8 = 7;

/// The section's bytes with their place in the file.
#[derive(Clone, Copy)]
pub(super) struct ParameterSection<'a> {
    pub(super) path: &'a Path,
    pub(super) bytes: &'a [u8],
    /// Position of the first byte in the file.
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
                "a parameter exceeds the parameter section, which ends at byte {end} (is the file damaged?)"
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

/// A parameter that is not decoded yet.
struct StoredParameter<'a> {
    group: i8,
    name: String,
    kind: i8,
    dimensions: &'a [u8],
    bytes: &'a [u8],
}

/// A decoded parameter.
enum ParameterValue {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
}

/// The parameters of the groups that are kept, by `GROUP:NAME`.
pub(super) struct C3dParameters {
    values: HashMap<String, ParameterValue>,
    /// Warnings about irregularities of the section.
    pub(super) warnings: Vec<String>,
}

impl C3dParameters {
    /// Follows the chain and decodes the parameters that are kept.
    ///
    /// # Errors
    /// For names that are not ASCII, unknown types, and values larger than their record or the
    /// section.
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
                // The data of a record end where the next record begins.
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

    /// Returns all numbers of a parameter; an empty slice if it does not exist.
    pub(super) fn numbers(&self, name: &str) -> &[f64] {
        match self.values.get(name) {
            Some(ParameterValue::Numbers(numbers)) => numbers,
            _ => &[],
        }
    }

    /// Returns the first number of a parameter.
    pub(super) fn number(&self, name: &str) -> Option<f64> {
        self.numbers(name).first().copied()
    }

    /// Returns the first number of a parameter as a count, whose words are unsigned but stored as
    /// signed.
    pub(super) fn count(&self, name: &str) -> Option<f64> {
        self.number(name).map(unsigned)
    }

    /// Returns all texts of a parameter, trimmed, and of its continuations (`LABELS2`, `LABELS3`).
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

/// Returns the unsigned value of a word that was stored as signed.
pub(super) fn unsigned(word: f64) -> f64 {
    if word < 0.0 { word + 65_536.0 } else { word }
}

/// Reads the parameter in `range`, which begins with its type.
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
