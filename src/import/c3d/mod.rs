//! Reader of C3D, the binary format of marker recordings: positions by frame, with parameters.
//!
//! After "The C3D File Format: User Guide" (Motion Lab Systems, 2008) and <https://www.c3d.org>.
//! The crate c3dio 0.8 is not used, since it panics on truncated files and does not locate errors.
//! Points that are not positions (angles, forces, moments, powers) are left out by the lists in the
//! file that name them. Names of subjects are not read.

use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use glam::DVec3;

use super::{MAX_POSITIONS, Markers, MotionFormat, RATE_HZ, metres};
use crate::error::{Error, FilePlace, Remedy, Result};
use crate::files::open;

mod layout;
mod machine;
mod parameters;
#[cfg(test)]
mod tests;

use layout::{BLOCK, C3dHeader, PointsLayout, Statement};
use machine::NumberFormat;
use parameters::{C3dParameters, ParameterSection};

/// The second byte of every C3D file.
const KEY: u8 = 80;

/// The lists of points that are not positions; `POINT:TYPE_GROUPS` may name more.
const NOT_POSITIONS: [&str; 7] = [
    "ANGLES",
    "FORCES",
    "MOMENTS",
    "POWERS",
    "SCALARS",
    "REACTIONS",
    "MODELED_MARKERS",
];

/// Reads a whole file. A frame rate from the user prevails over the file's.
///
/// # Errors
/// For incomplete files: damaged parameters, fewer frames than stated, no markers.
pub(super) fn read(path: &Path, given_hz: Option<f64>) -> Result<Markers> {
    let file = open(path)?;
    let length = file
        .metadata()
        .map_err(|source| Error::io(path, source))?
        .len();
    read_from(path, BufReader::new(file), length, given_hz)
}

fn read_from(
    path: &Path,
    mut file: impl Read + Seek,
    length: u64,
    given_hz: Option<f64>,
) -> Result<Markers> {
    let mut block = [0; BLOCK];
    fill(path, &mut file, &mut block, 0, length)?;
    if block[1] != KEY || block[0] < 2 {
        return Err(Error::at(
            path,
            FilePlace::Byte(0),
            format!(
                "expected a C3D header (parameter block, 80), found {} {}",
                block[0], block[1]
            ),
        ));
    }
    let start = (usize::from(block[0]) - 1) * BLOCK;
    let mut first = [0; 4];
    fill(path, &mut file, &mut first, start, length)?;
    let Some(machine) = NumberFormat::from_byte(first[3]) else {
        return Err(Error::at(
            path,
            FilePlace::Byte(start + 3),
            format!("expected processor 84, 85 or 86, found {}", first[3]),
        ));
    };
    let header = C3dHeader::parse(&block, machine);
    // Some writers leave the count of blocks at 0: the section then ends where the data begin.
    let blocks = match first[2] {
        0 => usize::from(header.data_block).saturating_sub(usize::from(block[0])),
        blocks => blocks.into(),
    };
    // The count may lie: it is compared with the file's length before memory is allocated.
    let mut bytes = Vec::new();
    let size = (blocks * BLOCK).max(4);
    if ends_before(start, size, length) {
        return Err(cut_short(path, start, size, length));
    }
    bytes.resize(size, 0);
    fill(path, &mut file, &mut bytes, start, length)?;
    let parameters = C3dParameters::read(ParameterSection {
        path,
        bytes: &bytes,
        start,
        machine,
    })?;
    let mut warnings = parameters.warnings.clone();
    let wrong = |problem: String| Error::input(path, problem);

    let statement = Statement {
        header: &header,
        parameters: &parameters,
        length,
    };
    let layout = statement.layout(machine, &mut warnings).map_err(wrong)?;
    let (names, kept) = names(&parameters, layout.points, &mut warnings).map_err(wrong)?;
    let sample_rate_hz = match given_hz {
        Some(given_hz) => given_hz,
        None => rate_hz(&header, &parameters, &mut warnings)
            .map_err(|problem| wrong(problem).with_remedy(Remedy::StateFrameRate))?,
    };
    let expected = layout.frames as u64 * layout.stride as u64;
    if layout.start.saturating_add(expected) > length {
        let present = length.saturating_sub(layout.start) / (layout.stride as u64).max(1);
        return Err(Error::at(
            path,
            FilePlace::Byte(usize::try_from(length).unwrap_or(usize::MAX)),
            format!(
                "the file ends after {present} of {} frames (is it truncated?)",
                layout.frames
            ),
        ));
    }
    if layout.frames.saturating_mul(kept.len()) > MAX_POSITIONS {
        return Err(wrong(format!(
            "{} frames of {} markers are more than {MAX_POSITIONS} positions: cut the recording",
            layout.frames,
            kept.len()
        )));
    }
    let mut frames = read_frames(path, &mut file, &layout, &kept)?;
    if layout.is_filled {
        // The rest of the last block may look like frames without markers.
        let padding = (BLOCK - 1) / layout.stride;
        let seen = |frame: &Vec<Option<DVec3>>| frame.iter().any(Option::is_some);
        let last = frames.iter().rposition(seen).unwrap_or(0);
        frames.truncate((last + 1).max(frames.len() - padding));
    }
    let unit_m = match parameters.texts("POINT:UNITS").first() {
        Some(unit) => metres(unit, &mut warnings),
        None => {
            warnings.push("the file states no unit of length".into());
            None
        }
    };
    Ok(Markers {
        format: MotionFormat::C3d,
        names,
        sample_rate_hz,
        frames,
        unit_m,
        warnings,
    })
}

fn ends_before(start: usize, size: usize, length: u64) -> bool {
    (start as u64).saturating_add(size as u64) > length
}

fn cut_short(path: &Path, start: usize, size: usize, length: u64) -> Error {
    if length == 0 {
        return Error::input(path, "the file is empty");
    }
    Error::at(
        path,
        FilePlace::Byte(usize::try_from(length).unwrap_or(usize::MAX)),
        format!("the file ends inside of the {size} bytes from byte {start} (is it truncated?)"),
    )
}

/// Fills `bytes` from byte `start` of the file.
fn fill(
    path: &Path,
    file: &mut (impl Read + Seek),
    bytes: &mut [u8],
    start: usize,
    length: u64,
) -> Result<()> {
    if ends_before(start, bytes.len(), length) {
        return Err(cut_short(path, start, bytes.len(), length));
    }
    file.seek(SeekFrom::Start(start as u64))
        .and_then(|_| file.read_exact(bytes))
        .map_err(|source| Error::io(path, source))
}

/// Returns the names and indices of the points that are markers.
fn names(
    parameters: &C3dParameters,
    points: usize,
    warnings: &mut Vec<String>,
) -> std::result::Result<(Vec<String>, Vec<usize>), String> {
    // Pairs of a list's name and the kind of its points.
    let groups = parameters.texts("POINT:TYPE_GROUPS");
    let others: Vec<&str> = groups
        .chunks(2)
        .filter_map(|pair| pair.first().copied())
        .chain(NOT_POSITIONS)
        .flat_map(|list| parameters.texts(&format!("POINT:{}", list.to_ascii_uppercase())))
        .collect();
    let labels = parameters.texts("POINT:LABELS");
    let (mut names, mut kept, mut unnamed) = (Vec::new(), Vec::new(), 0);
    for point in 0..points {
        match labels.get(point) {
            None | Some(&"") => unnamed += 1,
            Some(label) if others.contains(label) => {}
            Some(label) => {
                names.push((*label).to_owned());
                kept.push(point);
            }
        }
    }
    if unnamed > 0 {
        warnings.push(format!("{unnamed} points have no label: they are not used"));
    }
    if names.is_empty() {
        return Err(format!(
            "no markers: none of the {points} points is a labelled position"
        ));
    }
    Ok((names, kept))
}

fn rate_hz(
    header: &C3dHeader,
    parameters: &C3dParameters,
    warnings: &mut Vec<String>,
) -> std::result::Result<f64, String> {
    let stated = parameters
        .number("POINT:RATE")
        .filter(|rate| RATE_HZ.contains(rate));
    let rate = stated.unwrap_or(header.rate_hz);
    if !RATE_HZ.contains(&rate) {
        return Err(format!(
            "expected a frame rate of 1 to 10000 Hz, found {rate}"
        ));
    }
    if (header.rate_hz - rate).abs() > 1e-3 * rate {
        warnings.push(format!(
            "POINT:RATE states {rate} Hz, the header {} Hz: {rate} Hz is used",
            header.rate_hz
        ));
    }
    Ok(rate)
}

fn read_frames(
    path: &Path,
    file: &mut (impl Read + Seek),
    layout: &PointsLayout,
    kept: &[usize],
) -> Result<Vec<Vec<Option<DVec3>>>> {
    file.seek(SeekFrom::Start(layout.start))
        .map_err(|source| Error::io(path, source))?;
    let mut buffer = vec![0; layout.stride];
    let mut frames = Vec::with_capacity(layout.frames);
    for frame in 0..layout.frames {
        file.read_exact(&mut buffer)
            .map_err(|source| Error::io(path, source))?;
        let points = kept.iter().map(|&point| position(&buffer, layout, point));
        let points: Vec<Option<DVec3>> = points.collect();
        if let Some(at) = points.iter().flatten().position(|p| !p.is_finite()) {
            // Integers are finite: a point is four floats.
            let at = layout.start + (frame * layout.stride + 16 * kept[at]) as u64;
            return Err(Error::at(
                path,
                FilePlace::Byte(usize::try_from(at).unwrap_or(usize::MAX)),
                format!("frame {frame}: expected a finite position"),
            ));
        }
        frames.push(points);
    }
    Ok(frames)
}

/// Returns a point of a frame; none if the residual is negative, or the coordinates are NaN or
/// exactly zero.
fn position(frame: &[u8], layout: &PointsLayout, point: usize) -> Option<DVec3> {
    let machine = layout.machine;
    let [x, y, z, residual] = match layout.scale {
        None => frame.as_chunks::<16>().0.get(point)?.as_chunks::<4>().0[..]
            .try_into()
            .map(|reals: [[u8; 4]; 4]| reals.map(|real| machine.real(real)))
            .ok()?,
        Some(scale) => {
            let words: [[u8; 2]; 4] = frame.as_chunks::<8>().0.get(point)?.as_chunks::<2>().0[..]
                .try_into()
                .ok()?;
            let [x, y, z, residual] = words.map(|word| f64::from(machine.integer(word)));
            [x * scale, y * scale, z * scale, residual]
        }
    };
    let position = DVec3::new(x, y, z);
    let is_missing = residual < 0.0 || position.is_nan() || position == DVec3::ZERO;
    (!is_missing).then_some(position)
}
