//! Reader of the track row column format (TRC): marker positions as a table in text.
//!
//! Motion Analysis' Cortex writes it, and the guide of `OpenSim` describes it ("Marker (.trc)
//! Files"). Cells are between tabs and may be blank or, at the end of a row, missing; rows without
//! tabs are split at spaces and have no blanks. The header's counts are often wrong, so the names
//! decide how many cells a row has, and the [time column](super::time_column) decides the rate.

use glam::DVec3;

use super::lines::{Lines, finite, shown};
use super::time_column::{StatedRates, TimeColumn};
use super::{MAX_POSITIONS, Markers, MotionFormat, RATE_HZ, metres};
use crate::error::{Error, FilePlace, Remedy, Result};

/// The value that some writers put for a coordinate that was not seen.
const NOT_SEEN: f64 = 9_999_999.0;

/// The values of the header that are used, as text; empty if there is none.
struct TrcHeader {
    rate: String,
    frames: String,
    markers: String,
    unit: Option<String>,
}

/// The rows of a file and their times.
struct TrcRows {
    rows: Vec<Vec<Option<DVec3>>>,
    column: TimeColumn,
    /// The line of the last row, if that row ends early.
    ends_early: Option<usize>,
}

/// Reads a whole file. A frame rate from the user prevails over the file's.
///
/// # Errors
/// For rows without three cells for each name, frames out of order, cells that are neither a finite
/// number nor missing, and times and headers that give no frame rate.
pub(super) fn read(mut lines: Lines, given_hz: Option<f64>) -> Result<Markers> {
    let header = read_header(&mut lines)?;
    let names = read_names(&mut lines)?;
    let mut warnings = Vec::new();
    let TrcRows {
        rows,
        column,
        ends_early,
    } = read_rows(&mut lines, names.len(), given_hz.is_some())?;
    if rows.is_empty() {
        return Err(lines.error("the file has no frames (is it truncated?)"));
    }
    if let Some(line) = ends_early
        && header
            .frames
            .parse()
            .is_ok_and(|stated: usize| stated > rows.len())
    {
        let problem = format!(
            "the last row ends early, after {} of `{}` frames (is the file truncated?)",
            rows.len(),
            shown(&header.frames)
        );
        return Err(Error::at(lines.path(), FilePlace::Line(line), problem));
    }
    for (what, stated, found) in [
        ("frames", &header.frames, rows.len()),
        ("markers", &header.markers, names.len()),
    ] {
        if stated.parse() != Ok(found) {
            warnings.push(format!(
                "`{}` {what} stated, {found} present: all are used",
                shown(stated)
            ));
        }
    }
    // A number is the value of a later key, after a blank cell between spaces.
    let unit = header.unit.filter(|unit| unit.parse::<f64>().is_err());
    let unit_m = match &unit {
        Some(unit) => metres(unit, &mut warnings),
        None => {
            warnings.push("the file states no unit of length".into());
            None
        }
    };
    let stated = StatedRates {
        header: &shown(&header.rate),
        header_hz: finite(&header.rate)
            .ok()
            .filter(|rate| RATE_HZ.contains(rate)),
        given_hz,
    };
    let most = MAX_POSITIONS / names.len();
    let even = column.even_rows(rows, stated, most, &mut warnings);
    let even = even.map_err(|problem| {
        Error::input(lines.path(), problem).with_remedy(Remedy::StateFrameRate)
    })?;
    Ok(Markers {
        format: MotionFormat::Trc,
        names,
        sample_rate_hz: even.rate_hz,
        frames: even.rows,
        unit_m,
        warnings,
    })
}

/// Reads the rows below the header. Times may be anything if a frame rate is given.
fn read_rows(lines: &mut Lines, markers: usize, is_rate_given: bool) -> Result<TrcRows> {
    let expected = 2 + 3 * markers;
    let mut all = TrcRows {
        rows: Vec::new(),
        column: TimeColumn {
            times: Vec::new(),
            numbers: Vec::new(),
            resolution: 1.0,
        },
        ends_early: None,
    };
    let mut resolution = 1.0_f64;
    while let Some(row) = lines.next_row()? {
        let mut cells = cells(&row);
        let surplus = cells.get(expected..).unwrap_or_default();
        let is_surplus = surplus.iter().any(|cell| !cell.is_empty());
        let lacks = expected.saturating_sub(cells.len());
        // Editors strip the tabs of markers that were not seen from the ends of lines.
        let is_stripped = cells.len() >= 2 && lacks.is_multiple_of(3) && row.contains('\t');
        if is_surplus || (lacks > 0 && !is_stripped) {
            return Err(lines.error(format!(
                "expected {expected} cells in the row (frame, time and 3 for each of {markers} names), found {}",
                cells.len()
            )));
        }
        all.ends_early = (lacks > 0).then(|| lines.number());
        cells.resize(expected, "");
        let number = finite(cells[0]).map_err(|problem| lines.error(problem))?;
        let time = match finite(cells[1]) {
            Ok(time) => time,
            Err(_) if is_rate_given => f64::NAN,
            Err(problem) => {
                return Err(lines.error(problem).with_remedy(Remedy::StateFrameRate));
            }
        };
        resolution = resolution.min(last_digit(cells[1]));
        let column = &mut all.column;
        column.numbers.push(number);
        column.times.push(time);
        if let Some(problem) = out_of_order(column, is_rate_given) {
            let remedy = Remedy::StateFrameRate;
            return Err(lines.error(problem).with_remedy(remedy));
        }
        all.rows.push(read_row(lines, &cells[2..])?);
        if all.rows.len() * markers > MAX_POSITIONS {
            return Err(lines.error(format!(
                "more than {MAX_POSITIONS} positions: cut the recording"
            )));
        }
    }
    all.column.resolution = resolution;
    Ok(all)
}

/// Returns what is wrong with the last row's place: it must be later than the one before, by a
/// constant step of frame numbers, or by the time of the frames between.
fn out_of_order(column: &TimeColumn, is_rate_given: bool) -> Option<String> {
    let (&[.., number_before, number], &[.., time_before, time]) =
        (column.numbers.as_slice(), column.times.as_slice())
    else {
        return None;
    };
    let usual = column.numbers[1] - column.numbers[0];
    let (step, step_s) = (number - number_before, time - time_before);
    let frame_s = (column.times[1] - column.times[0]) / usual;
    let is_in_time = (step_s - step * frame_s).abs() < 0.5 * frame_s;
    let is_next = step > 0.0 && (step == usual || is_in_time);
    let is_later = step_s > 0.0 || is_rate_given;
    (!is_next || !is_later).then(|| {
        let expected = number_before + if usual > 0.0 { usual } else { 1.0 };
        format!(
            "expected frame {expected} later than {time_before} s, found frame {number} at {time} s"
        )
    })
}

/// Returns the value of 1 in the last digit of a decimal number; 1 for others.
fn last_digit(cell: &str) -> f64 {
    match cell.split_once('.') {
        Some((_, decimals)) if decimals.bytes().all(|byte| byte.is_ascii_digit()) => {
            libm::exp10(-(decimals.len() as f64))
        }
        _ => 1.0,
    }
}

/// Reads the three lines before the names.
fn read_header(lines: &mut Lines) -> Result<TrcHeader> {
    match lines.next_line()? {
        Some(first) if first.starts_with("PathFileType") => {}
        Some(first) => {
            return Err(lines.error(format!("expected PathFileType, found `{}`", shown(&first))));
        }
        None => return Err(Error::input(lines.path(), "the file is empty")),
    }
    let keys = lines.next_row()?.unwrap_or_default();
    let Some(values) = lines.next_row()? else {
        return Err(lines.error("expected the header's values, found the end of the file"));
    };
    let [keys, values] = header_cells(&keys, &values);
    let value = |name: &str| {
        let at = keys.iter().position(|key| key.eq_ignore_ascii_case(name))?;
        values
            .get(at)
            .filter(|value| !value.is_empty())
            .map(|value| (*value).to_owned())
    };
    let needed = |name: &str| {
        value(name).ok_or_else(|| lines.error(format!("the header has no value of {name}")))
    };
    Ok(TrcHeader {
        rate: value("DataRate").unwrap_or_default(),
        frames: needed("NumFrames")?,
        markers: needed("NumMarkers")?,
        unit: value("Units"),
    })
}

/// Returns the header's keys and values. They are words, since some writers put several tabs
/// between them; if a value is blank, they are the cells between tabs.
fn header_cells<'a>(keys: &'a str, values: &'a str) -> [Vec<&'a str>; 2] {
    let words = [keys, values].map(|row| row.split_whitespace().collect::<Vec<_>>());
    if words[0].len() == words[1].len() {
        return words;
    }
    let cells = [keys, values].map(|row| {
        let cells = row.trim_end().split('\t');
        cells.map(str::trim).collect::<Vec<_>>()
    });
    let is_table = cells[0].len() == cells[1].len() && !cells[0].contains(&"");
    if is_table { cells } else { words }
}

/// Reads the line of names and the line of axes below it.
fn read_names(lines: &mut Lines) -> Result<Vec<String>> {
    let row = lines.next_row()?.unwrap_or_default();
    let all = cells(&row);
    let [frame, time, names @ ..] = all.as_slice() else {
        return Err(lines.error("expected the line of marker names"));
    };
    if !frame.eq_ignore_ascii_case("Frame#") || !time.eq_ignore_ascii_case("Time") {
        return Err(lines.error(format!(
            "expected Frame# and Time before the marker names, found `{}`",
            shown(&row)
        )));
    }
    let names: Vec<String> = names
        .iter()
        .filter(|name| !name.is_empty())
        .map(|name| (*name).to_owned())
        .collect();
    if names.is_empty() {
        return Err(lines.error("no markers: the line of names has none"));
    }
    match lines.next_line()? {
        Some(axes) if axes.starts_with(['X', 'x']) => Ok(names),
        _ => Err(lines.error("expected the line of axes (X1 Y1 Z1 ...)")),
    }
}

/// Splits a row into trimmed cells.
fn cells(row: &str) -> Vec<&str> {
    if row.contains('\t') {
        row.split('\t').map(str::trim).collect()
    } else {
        row.split_whitespace().collect()
    }
}

fn read_row(lines: &Lines, cells: &[&str]) -> Result<Vec<Option<DVec3>>> {
    let (points, _) = cells.as_chunks::<3>();
    points
        .iter()
        .map(|point| {
            let mut values = [None; 3];
            for (value, cell) in values.iter_mut().zip(point) {
                *value = coordinate(cell).map_err(|problem| lines.error(problem))?;
            }
            let [Some(x), Some(y), Some(z)] = values else {
                return Ok(None);
            };
            let position = DVec3::new(x, y, z);
            Ok((position != DVec3::ZERO).then_some(position))
        })
        .collect()
}

/// Parses a coordinate; none if it was not seen.
fn coordinate(cell: &str) -> std::result::Result<Option<f64>, String> {
    // NaN as several languages print it: nan, -NaN, 1.#QNAN, -1.#IND.
    let lower = cell.to_ascii_lowercase();
    if cell.is_empty() || lower.ends_with("nan") || lower.contains("#ind") {
        return Ok(None);
    }
    let value = finite(cell)?;
    Ok((value.abs() < NOT_SEEN).then_some(value))
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;
    use std::path::Path;

    use super::*;

    const TWO_MARKERS: &str = "PathFileType\t4\t(X/Y/Z)\tt.trc
DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate
100.00\t100.00\t3\t2\tmm\t100.00
Frame#\tTime\tLANK\t\t\tR.Heel\t\t
\t\tX1\tY1\tZ1\tX2\tY2\tZ2

1\t0.00\t1\t2\t3\t-4.5\t5E+01\t6
2\t0.01\t1\t2\t3\t4\t5\t6
3\t0.02\t1\t2\t3\t4\t5\t6
";

    fn parse(text: &str) -> Result<Markers> {
        let bytes = Cursor::new(text.to_owned().into_bytes());
        read(Lines::over(Path::new("t.trc"), Box::new(bytes)), None)
    }

    fn replaced(from: &str, to: &str) -> Result<Markers> {
        assert!(TWO_MARKERS.contains(from));
        parse(&TWO_MARKERS.replacen(from, to, 1))
    }

    #[test]
    fn names_rate_unit_and_positions_are_as_written() {
        let markers = parse(TWO_MARKERS).unwrap();
        assert_eq!(markers.names, ["LANK", "R.Heel"]);
        assert_eq!(markers.sample_rate_hz.to_bits(), 100f64.to_bits());
        assert_eq!(markers.unit_m, Some(0.001));
        assert_eq!(markers.frames.len(), 3);
        assert_eq!(
            markers.frames[0],
            [
                Some(DVec3::new(1.0, 2.0, 3.0)),
                Some(DVec3::new(-4.5, 50.0, 6.0))
            ]
        );
        assert!(markers.warnings.is_empty(), "{:?}", markers.warnings);
    }

    #[test]
    fn blank_nan_zero_and_9999999_are_missing() {
        for gap in [
            "\t\t\t",
            "\tNaN\tnan\tNAN",
            "\t1.#QNAN\t-1.#IND\t0",
            "\t0.000\t0\t-0.0",
            "\t9999999.000\t9999999\t9999999",
            "\t7\t\t8",
        ] {
            let markers = replaced("\t1\t2\t3\t4\t5\t6", &format!("{gap}\t4\t5\t6")).unwrap();
            let seen = Some(DVec3::new(4.0, 5.0, 6.0));
            assert_eq!(markers.frames[1], [None, seen], "{gap:?}");
        }
    }

    #[test]
    fn spelling_does_not_matter() {
        let plain = parse(TWO_MARKERS).unwrap();
        let (head, rows) = TWO_MARKERS.split_at(TWO_MARKERS.find("1\t0.00").unwrap());
        for text in [
            TWO_MARKERS.replace('\n', "\r\n"),
            TWO_MARKERS.replace("5\t6\n", "5\t6\t\t\n"),
            head.to_owned() + &rows.replace('\t', " "),
            TWO_MARKERS.replace("100.00\t100.00\t3", "  100.0\t\t 100.0\t\t  3"),
        ] {
            let other = parse(&text).unwrap();
            assert_eq!(
                (&other.frames, &other.names),
                (&plain.frames, &plain.names),
                "{text}"
            );
        }
    }

    #[test]
    fn what_the_header_says_wrongly_is_announced() {
        let warned = |from: &str, to: &str| {
            let markers = replaced(from, to).unwrap();
            (markers.sample_rate_hz, markers.warnings.join("; "))
        };
        assert_eq!(
            warned("100.00\t3\t2", "100.00\t900\t2").1,
            "`900` frames stated, 3 present: all are used"
        );
        assert_eq!(
            warned("100.00\t3\t2", "100.00\t3\t9").1,
            "`9` markers stated, 2 present: all are used"
        );
        let (rate, warning) = warned("\n100.00", "\n150.00");
        assert!((rate - 100.0).abs() < 1e-9);
        assert_eq!(
            warning,
            "the header states `150.00` Hz, the time column 100.00 Hz: the time column is used"
        );
        assert_eq!(
            warned("\tmm\t", "\tells\t").1,
            "unknown unit of length `ells`"
        );
    }

    #[test]
    fn times_rounded_to_milliseconds_leave_the_header_its_rate() {
        // 150 Hz: 0, 0.0067, 0.0133 s.
        let text = TWO_MARKERS
            .replace("\n100.00", "\n150.00")
            .replace("0.01", "0.007")
            .replace("0.02", "0.013");
        let markers = parse(&text).unwrap();
        assert_eq!(markers.sample_rate_hz.to_bits(), 150f64.to_bits());
        assert!(markers.warnings.is_empty(), "{:?}", markers.warnings);
    }

    #[test]
    fn broken_files_are_refused_where_they_break() {
        let problem = |from: &str, to: &str| replaced(from, to).unwrap_err().to_string();
        assert_eq!(
            problem("5\t6\n3", "5\n3"),
            "t.trc:8: expected 8 cells in the row (frame, time and 3 for each of 2 names), found 7"
        );
        assert_eq!(
            problem("5\t6\n3", "5\t6\t7\n3"),
            "t.trc:8: expected 8 cells in the row (frame, time and 3 for each of 2 names), found 9"
        );
        assert_eq!(
            problem("3\t0.02", "4\t0.02"),
            "t.trc:9: expected frame 3 later than 0.01 s, found frame 4 at 0.02 s"
        );
        assert_eq!(
            problem("5\t6\n3", "abc\t6\n3"),
            "t.trc:8: expected a number, found `abc`"
        );
        assert_eq!(
            problem("5\t6\n3", "inf\t6\n3"),
            "t.trc:8: expected a finite number, found `inf`"
        );
        assert_eq!(
            problem("Frame#", "Row"),
            "t.trc:4: expected Frame# and Time before the marker names, found `Row\\tTime\\tLANK\\t\\t\\tR.Heel\\t\\t`"
        );
        for cut in 1..TWO_MARKERS.find("1\t0.00").unwrap() {
            assert!(parse(&TWO_MARKERS[..cut]).is_err(), "cut at byte {cut}");
        }
        assert_eq!(
            parse("").unwrap_err().to_string(),
            "t.trc: the file is empty"
        );
    }
}
