//! Measured people: a CSV file with one row per subject.
//!
//! Tape and calipers give more of a body than its stature and mass. Dimensions that a row lacks
//! come from the regressions of [`anthropometry`](super::cohort::anthropometry).

use super::cohort::anthropometry::{DIMENSIONS, Dimensions, NAMES, PopulationNorms};
use crate::error::{Error, FilePlace, Result};
use csv::{ErrorKind, Position, ReaderBuilder, StringRecord};
use edgegait_core::pack::Sex;
use std::collections::BTreeMap;
use std::path::Path;

/// Dimensions that only place joints. They have no effect without a known stature, since the
/// recorded skeleton's lengths are then kept.
const BETWEEN_JOINTS: [&str; 10] = [
    "biacromial_breadth",
    "bicristal_breadth",
    "acromial_height",
    "cervicale_height",
    "suprasternale_height",
    "trochanterion_height",
    "knee_height",
    "iliocristale_height",
    "acromion_radiale_length",
    "radiale_stylion_length",
];

/// The measurements of one person.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredPerson {
    /// Stature, metres.
    pub stature_m: Option<f64>,
    /// Mass, kg.
    pub mass_kg: Option<f64>,
    /// Sex.
    pub sex: Option<Sex>,
    /// Dimensions in the order of [`NAMES`], metres.
    pub dimensions_m: [Option<f64>; DIMENSIONS],
}

/// The measured people of a file, by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredPeople(BTreeMap<String, MeasuredPerson>);

/// The quantity that a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quantity {
    Subject,
    Stature,
    Mass,
    Sex,
    Dimension(usize),
    /// Something else, which is ignored.
    Other,
}

/// The treatment of unknown columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Others {
    Refused,
    PassedOver,
}

/// A column, and the factor that converts its numbers to metres or kg.
struct CsvColumn {
    /// Name of the column in the file.
    name: String,
    quantity: Quantity,
    unit: f64,
}

impl MeasuredPerson {
    /// A person without any measurement.
    pub const NOTHING: Self = Self {
        stature_m: None,
        mass_kg: None,
        sex: None,
        dimensions_m: [None; DIMENSIONS],
    };
}

impl MeasuredPeople {
    /// Reads a file with the columns `subject` and any of `stature`, `mass_kg`, `sex` (female or
    /// F, male or M) and the dimensions of [`NAMES`]. Names of lengths end with `_mm` or `_m`.
    /// Empty fields count as not measured, and so do unusable values, with an error for each: not
    /// numbers, lengths more than six standard deviations from ANSUR II's mean, and masses with an
    /// implausible body mass index.
    ///
    /// # Errors
    /// For unknown or repeated columns, and subjects without a name or with two rows. Names the
    /// line and the column.
    pub fn read_usable(path: &Path) -> Result<(Self, Vec<Error>)> {
        Self::read_columns(path, Others::Refused)
    }

    /// Reads a table with further columns like [`read_usable`](Self::read_usable): unknown columns
    /// are ignored, and the subject's column may be called `id`.
    ///
    /// # Errors
    /// As [`read_usable`](Self::read_usable), except for unknown columns.
    pub fn read_among_others(path: &Path) -> Result<(Self, Vec<Error>)> {
        Self::read_columns(path, Others::PassedOver)
    }

    fn read_columns(path: &Path, others: Others) -> Result<(Self, Vec<Error>)> {
        let text = crate::files::read(path)?;
        let refuse = |position: Option<&Position>, problem| {
            Error::at(path, FilePlace::Line(line(&text, position)), problem)
        };
        let unreadable = |error: csv::Error| refuse(error.position(), problem(&error));
        let mut reader = ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_reader(text.as_slice());
        let headers = reader.headers().map_err(unreadable)?;
        let columns =
            columns(headers, others).map_err(|problem| refuse(headers.position(), problem))?;
        let mut unusable = Vec::new();
        let mut people = BTreeMap::new();
        let mut positions: BTreeMap<String, Option<Position>> = BTreeMap::new();
        for record in reader.records() {
            let record = record.map_err(unreadable)?;
            let at = record.position();
            let (subject, measured, problems) =
                row(&columns, &record).map_err(|problem| refuse(at, problem))?;
            unusable.extend(problems.into_iter().map(|problem| refuse(at, problem)));
            if let Some(first) = positions.insert(subject.clone(), at.cloned()) {
                let first = line(&text, first.as_ref());
                return Err(refuse(
                    at,
                    format!(
                        "subject {subject:?} is in line {first} already: expected one row for each"
                    ),
                ));
            }
            people.insert(subject, measured);
        }
        if people.is_empty() {
            return Err(Error::input(path, "no subjects: expected at least one row"));
        }
        Ok((Self(people), unusable))
    }

    /// Returns the measurements of a subject, if there is a row.
    #[must_use]
    pub fn person(&self, subject: &str) -> Option<&MeasuredPerson> {
        self.0.get(subject)
    }

    /// Returns the people without the measured dimensions that `is_left_out` selects by name.
    #[cfg(all(feature = "import", feature = "train", feature = "plots"))]
    #[must_use]
    pub(crate) fn without(&self, is_left_out: impl Fn(&str) -> bool) -> Self {
        let mut people = self.clone();
        for measured in people.0.values_mut() {
            for (name, value) in NAMES.iter().zip(&mut measured.dimensions_m) {
                if is_left_out(name) {
                    *value = None;
                }
            }
        }
        people
    }

    /// Returns warnings about rows without a walker among `subjects`, walkers without a row, and
    /// dimensions that have no effect. `has_stature` is whether walkers without a measured stature
    /// are given one.
    #[must_use]
    pub fn warnings(&self, subjects: &[&str], has_stature: bool) -> Vec<String> {
        let mut warnings = Vec::new();
        for subject in self.0.keys() {
            if !subjects.contains(&subject.as_str()) {
                warnings.push(format!(
                    "no walk of the measured subject {subject:?}: the row has no effect (subjects here: {})",
                    subjects.join(", ")
                ));
            }
        }
        for subject in subjects {
            let Some(measured) = self.person(subject) else {
                warnings.push(format!(
                    "subject {subject:?} was not measured: the body is estimated"
                ));
                continue;
            };
            let ignored: Vec<&str> = (NAMES.iter().zip(&measured.dimensions_m))
                .filter(|(name, value)| value.is_some() && BETWEEN_JOINTS.contains(name))
                .map(|(name, _)| *name)
                .collect();
            if measured.stature_m.is_none() && !has_stature && !ignored.is_empty() {
                warnings.push(format!(
                    "subject {subject:?} has no measured stature: the recorded skeleton's lengths are kept, not the measured {}",
                    ignored.join(", ")
                ));
            }
        }
        warnings
    }
}

/// Returns the columns that a header names.
fn columns(headers: &StringRecord, others: Others) -> std::result::Result<Vec<CsvColumn>, String> {
    let mut columns: Vec<CsvColumn> = Vec::new();
    for name in headers {
        let known = match (others, name) {
            (Others::PassedOver, "id") => CsvColumn::named("subject"),
            (Others::PassedOver, _) => Some(CsvColumn::named(name).unwrap_or(CsvColumn {
                name: name.into(),
                quantity: Quantity::Other,
                unit: 1.0,
            })),
            (Others::Refused, _) => CsvColumn::named(name),
        };
        let column = known.ok_or_else(|| {
            format!(
                "unknown column {name:?}: expected subject, sex, mass_kg, stature_m or stature_mm, or a dimension with the suffix _mm or _m: {} (separated by commas)",
                NAMES.join(", ")
            )
        })?;
        if columns
            .iter()
            .any(|known| known.quantity == column.quantity && known.quantity != Quantity::Other)
        {
            return Err(format!("a second column for {name:?}: expected each once"));
        }
        columns.push(column);
    }
    let is_subject = |column: &CsvColumn| column.quantity == Quantity::Subject;
    if !columns.iter().any(is_subject) {
        return Err(
            "no column \"subject\": expected one with the names of the imported subjects".into(),
        );
    }
    Ok(columns)
}

impl CsvColumn {
    fn named(name: &str) -> Option<Self> {
        let (quantity, unit) = match name {
            "subject" => (Quantity::Subject, 1.0),
            "sex" => (Quantity::Sex, 1.0),
            "mass_kg" => (Quantity::Mass, 1.0),
            _ => {
                let (length, unit) = match name.strip_suffix("_mm") {
                    Some(length) => (length, 1e-3),
                    None => (name.strip_suffix("_m")?, 1.0),
                };
                let quantity = match length {
                    "stature" => Quantity::Stature,
                    _ => Quantity::Dimension(NAMES.iter().position(|known| *known == length)?),
                };
                (quantity, unit)
            }
        };
        Some(Self {
            name: name.into(),
            quantity,
            unit,
        })
    }

    /// Returns a field in metres or kg if it lies within a range, which `of` explains.
    fn number(
        &self,
        text: &str,
        (least, most): (f64, f64),
        of: &str,
    ) -> std::result::Result<f64, String> {
        let Self { name, unit, .. } = self;
        let value = text
            .parse::<f64>()
            .map_err(|_| format!("{name}: expected a number, found {text:?}"))?;
        if (least..=most).contains(&(value * unit)) {
            return Ok(value * unit);
        }
        // Rounded inwards, so that what is stated is accepted.
        let (least, most) = ((least / unit * 1e3).ceil(), (most / unit * 1e3).floor());
        let (least, most) = (least * 1e-3, most * 1e-3);
        Err(format!(
            "{name} of {text}: expected {least:.3} to {most:.3} ({of})"
        ))
    }
}

/// Returns one person's measurements, and the problems of fields that are not used.
fn row(
    columns: &[CsvColumn],
    record: &StringRecord,
) -> std::result::Result<(String, MeasuredPerson, Vec<String>), String> {
    let mut subject = String::new();
    let mut measured = MeasuredPerson::NOTHING;
    let mut problems = Vec::new();
    let fields = || {
        columns
            .iter()
            .zip(record)
            .filter(|(_, text)| !text.is_empty())
    };
    for (column, text) in fields() {
        match column.quantity {
            Quantity::Subject => subject = text.into(),
            Quantity::Sex => match text {
                "female" | "F" => measured.sex = Some(Sex::Female),
                "male" | "M" => measured.sex = Some(Sex::Male),
                _ => problems.push(format!("sex: expected female or male, found {text:?}")),
            },
            _ => {}
        }
    }
    if subject.is_empty() {
        return Err("expected a subject, found an empty field".into());
    }
    // Plausible ranges depend on the sex.
    let dimensions = Dimensions::plausible(measured.sex);
    let stature = PopulationNorms::plausible_stature(measured.sex);
    for (column, text) in fields() {
        let mut number = |range, of| {
            let found = column.number(text, range, of);
            found.map_err(|problem| problems.push(problem)).ok()
        };
        const OF: &str = "six standard deviations about ANSUR II's mean";
        match column.quantity {
            Quantity::Subject | Quantity::Sex | Quantity::Other => {}
            Quantity::Stature => measured.stature_m = number(stature, OF),
            Quantity::Mass => {
                let index = |stature: f64, bmi: f64| bmi * stature * stature;
                let range = (index(stature.0, 12.0), index(stature.1, 60.0));
                measured.mass_kg = number(range, "body mass indices of 12 to 60");
            }
            Quantity::Dimension(index) => {
                measured.dimensions_m[index] = number(dimensions[index], OF);
            }
        }
    }
    if let (Some(stature_m), Some(mass_kg)) = (measured.stature_m, measured.mass_kg)
        && let Err(error) =
            Dimensions::expected(stature_m, mass_kg, measured.sex, &[0.0; DIMENSIONS])
    {
        // Drops the mass, since the stature also places joints.
        measured.mass_kg = None;
        problems.push(format!("mass_kg: {error}"));
    }
    Ok((subject, measured, problems))
}

/// Returns the line number of a record, which begins after the empty lines at its position.
pub(super) fn line(text: &[u8], position: Option<&Position>) -> usize {
    let byte = position.map_or(0, |position| {
        usize::try_from(position.byte()).unwrap_or(usize::MAX)
    });
    let (before, behind) = text.split_at(byte.min(text.len()));
    let empty = behind
        .iter()
        .take_while(|byte| matches!(byte, b'\r' | b'\n'));
    1 + (before.iter().chain(empty))
        .filter(|byte| **byte == b'\n')
        .count()
}

/// Returns why a record cannot be read.
pub(super) fn problem(error: &csv::Error) -> String {
    match error.kind() {
        ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => format!("expected {expected_len} fields, found {len}"),
        ErrorKind::Utf8 { .. } => "expected text in UTF-8, found other bytes".into(),
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests;
