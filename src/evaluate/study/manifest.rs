//! The manifest of a study, which pairs takes of silhouettes with recordings.

use crate::error::{Error, FilePlace, Result};
use crate::files::named_below::is_below;
use csv::ReaderBuilder;
use std::path::Path;

/// A row of the manifest: a take from one view, and the recording that it shows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pairing {
    /// The line in the file.
    pub line: usize,
    /// The person's name in the tree.
    pub person: String,
    /// The take's name in the tree.
    pub take: String,
    /// The view's name in the tree.
    pub view: String,
    /// The azimuth and elevation, degrees, if stated.
    pub angles_deg: Option<(f32, f32)>,
    /// The frame rate of the silhouettes, frames/s.
    pub fps: f64,
    /// The gait cycles, in frames from 0; none if they must be detected.
    pub cycles: Option<Vec<(f64, f64)>>,
    /// The left contacts, in frames from 0.
    pub contacts: Vec<f64>,
    /// The path of the recording in a folder of recordings.
    pub source: String,
    /// The name of that folder, if stated.
    pub root: Option<String>,
    /// The frame of the recording, counted at `fps`, that is the first of the silhouettes.
    pub offset: f64,
    /// The distance from the camera to the walker, metres, if stated.
    pub distance_m: Option<f64>,
}

/// The default frame rate, frames/s: CASIA-B's.
const FPS: f64 = 25.0;

/// The columns that a manifest must have.
const REQUIRED: [&str; 4] = ["id", "take", "view", "source"];

/// Reads a manifest: a CSV file with `id`, `take`, `view` and `source`, and optionally `azimuth`
/// and `elevation` (degrees), `fps`, `phase_cycles` or `cycles` (`a-b;c-d`, frames from 0), `lhs`
/// (left contacts, `a;b`), `source_root`, `source_frames_30fps` (`a-b`: the frames of the recording
/// at 30 frames/s that the take shows) and `distance_m`. Other columns are ignored.
///
/// # Errors
/// If the file cannot be read or a value is invalid; the message names the line and the column.
pub(crate) fn read(path: &Path) -> Result<Vec<Pairing>> {
    let text = crate::files::read(path)?;
    let mut reader = ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(text.as_slice());
    let line_of =
        |position: Option<&csv::Position>| position.map_or(1, |position| position.line() as usize);
    let broken = |error: csv::Error| {
        let line = line_of(error.position());
        Error::at(path, FilePlace::Line(line), error.to_string())
    };
    let headers = reader.headers().map_err(broken)?.clone();
    let column = |name: &str| headers.iter().position(|header| header == name);
    if let Some(lacking) = REQUIRED.into_iter().find(|name| column(name).is_none()) {
        return Err(Error::at(
            path,
            FilePlace::Line(1),
            format!(
                "expected the columns {}, found no {lacking:?}",
                REQUIRED.join(", ")
            ),
        ));
    }
    let mut rows: Vec<Pairing> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(broken)?;
        let line = line_of(record.position());
        let field = |name| column(name).and_then(|at| record.get(at)).unwrap_or("");
        let row =
            row(line, field).map_err(|problem| Error::at(path, FilePlace::Line(line), problem))?;
        let is_same = |other: &&Pairing| {
            (&other.person, &other.take, &other.view) == (&row.person, &row.take, &row.view)
        };
        if let Some(first) = rows.iter().find(is_same) {
            let Pairing {
                person, take, view, ..
            } = &row;
            return Err(Error::at(
                path,
                FilePlace::Line(line),
                format!(
                    "{person}/{take}/{view} is in line {} already: expected one row for each",
                    first.line
                ),
            ));
        }
        rows.push(row);
    }
    if rows.is_empty() {
        return Err(Error::input(
            path,
            "expected a row for each take, found none",
        ));
    }
    Ok(rows)
}

fn row<'a>(
    line: usize,
    field: impl Fn(&'static str) -> &'a str,
) -> std::result::Result<Pairing, String> {
    let required = |name| match field(name) {
        "" => Err(format!("{name}: expected a value, found none")),
        text => Ok(text.to_owned()),
    };
    let number = |name| match field(name) {
        "" => Ok(None),
        text => number(text)
            .map(Some)
            .map_err(|problem| format!("{name}: {problem}")),
    };
    let view = required("view")?;
    let angles_deg = match (number("azimuth")?, number("elevation")?) {
        #[expect(clippy::cast_possible_truncation, reason = "degrees")]
        (Some(azimuth), elevation) => Some((azimuth as f32, elevation.unwrap_or(0.0) as f32)),
        (None, _) => None,
    };
    let fps = number("fps")?.unwrap_or(FPS);
    if fps <= 0.0 {
        return Err(format!("fps: expected more than 0, found {fps}"));
    }
    let distance_m = number("distance_m")?;
    if distance_m.is_some_and(|metres| !(0.1..=1e6).contains(&metres)) {
        return Err("distance_m: expected 0.1 to 1,000,000 metres".into());
    }
    let spans = ["phase_cycles", "cycles"]
        .into_iter()
        .find(|name| !field(name).is_empty());
    let cycles = spans
        .map(|name| {
            let spans = field(name).split(';').map(span);
            let spans: std::result::Result<Vec<_>, String> = spans.collect();
            spans.map_err(|problem| format!("{name}: {problem}"))
        })
        .transpose()?;
    let contacts = field("lhs").split(';').filter(|text| !text.is_empty());
    let contacts: std::result::Result<Vec<f64>, String> = contacts.map(self::number).collect();
    let offset = match field("source_frames_30fps") {
        "" | "all" => 0.0,
        text => {
            let first = text.split('-').next().unwrap_or(text);
            let frame = self::number(first)
                .map_err(|problem| format!("source_frames_30fps: {problem}, or \"all\""))?;
            frame * fps / 30.0
        }
    };
    let root = field("source_root");
    let source = required("source")?;
    if !is_below(&source) {
        return Err(format!(
            "source: expected a path in a folder of recordings, without .., found {source:?}"
        ));
    }
    Ok(Pairing {
        line,
        person: required("id")?,
        take: required("take")?,
        view,
        angles_deg,
        fps,
        cycles,
        contacts: contacts.map_err(|problem| format!("lhs: {problem}"))?,
        source,
        root: (!root.is_empty()).then(|| root.to_owned()),
        offset,
        distance_m,
    })
}

fn number(text: &str) -> std::result::Result<f64, String> {
    let found = text.parse().ok().filter(|value: &f64| value.is_finite());
    found.ok_or_else(|| format!("expected a number, found {text:?}"))
}

/// Parses `a-b`, a cycle of at least two frames.
fn span(text: &str) -> std::result::Result<(f64, f64), String> {
    let expected = || format!("expected frames as in 6.9-39.7, found {text:?}");
    let (from, to) = text.split_once('-').ok_or_else(expected)?;
    let (from, to) = (number(from)?, number(to)?);
    if from >= 0.0 && to >= from + 2.0 {
        Ok((from, to))
    } else {
        Err(expected())
    }
}

/// Lists at most ten names for a message.
pub(super) fn listed(names: &[String]) -> String {
    const SHOWN: usize = 10;
    let more = match names.len().saturating_sub(SHOWN) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    names[..names.len().min(SHOWN)].join(", ") + &more
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<Vec<Pairing>> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("m.csv");
        std::fs::write(&path, text).expect("a file");
        read(&path)
    }

    #[test]
    fn a_row_says_what_it_knows_and_other_columns_are_passed_over() {
        let text = "split,id,take,view,azimuth,fps,phase_cycles,cycles,lhs,source,source_root,source_frames_30fps\n\
                    open,101,nm-01,045e15,45,15,6.5-39;39-71,1-9,13.5;46,a/b.amc,mocap,10-end\n\
                    open,101,nm-02,cam1,,,,,,a/c.amc,,\n";
        let rows = read_text(text).expect("two rows");
        let expected = Pairing {
            line: 2,
            person: "101".into(),
            take: "nm-01".into(),
            view: "045e15".into(),
            angles_deg: Some((45.0, 0.0)),
            fps: 15.0,
            cycles: Some(vec![(6.5, 39.0), (39.0, 71.0)]),
            contacts: vec![13.5, 46.0],
            source: "a/b.amc".into(),
            root: Some("mocap".into()),
            offset: 5.0,
            distance_m: None,
        };
        assert_eq!(rows[0], expected);
        assert_eq!((rows[1].fps, rows[1].cycles.as_ref()), (FPS, None));
        assert!(rows[1].contacts.is_empty() && rows[1].angles_deg.is_none());
    }

    #[test]
    fn what_cannot_be_read_names_line_and_column() {
        for (text, words) in [
            (
                "id,take,view\n",
                "m.csv:1: expected the columns id, take, view, source, found no \"source\"",
            ),
            (
                "id,take,view,source\n",
                "expected a row for each take, found none",
            ),
            (
                "id,take,view,source\n1,,90,a\n",
                "m.csv:2: take: expected a value, found none",
            ),
            (
                "id,take,view,source,fps\n1,a,90,a,x\n",
                "m.csv:2: fps: expected a number, found \"x\"",
            ),
            (
                "id,take,view,source,fps\n1,a,90,a,0\n",
                "fps: expected more than 0, found 0",
            ),
            (
                "id,take,view,source,cycles\n1,a,90,a,5\n",
                "cycles: expected frames as in 6.9-39.7, found \"5\"",
            ),
            (
                "id,take,view,source,cycles\n1,a,90,a,5-6\n",
                "found \"5-6\"",
            ),
            (
                "id,take,view,source\n1,a,90,a\n1,a,90,b\n",
                "m.csv:3: 1/a/90 is in line 2 already",
            ),
            ("id,take,view,source\n1,a\n", "m.csv:2"),
            (
                "id,take,view,source\n1,a,90,../a.bvh\n",
                "m.csv:2: source: expected a path in a folder of recordings",
            ),
            (
                "id,take,view,source,distance_m\n1,a,90,a,0\n",
                "distance_m: expected 0.1",
            ),
        ] {
            let error = read_text(text).expect_err(text).to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
