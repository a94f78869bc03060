//! Reader of C3D, the binary format of marker recordings: positions by frame, with parameters.
//!
//! After "The C3D File Format: User Guide" (Motion Lab Systems, 2008) and <https://www.c3d.org>.
//! The crate c3dio 0.8 is not used, since it panics on truncated files and does not locate errors.
//! Points that are not positions (angles, forces, moments, powers) are left out by the lists in the
//! file that name them. Names of subjects are not read.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use glam::DVec3;

use super::{MAX_POSITIONS, Markers, MotionFormat, RATE_HZ, metres};
use crate::error::{Error, FilePlace, Result};

mod machine;
mod parameters;
#[cfg(test)]
mod tests;

use machine::NumberFormat;
use parameters::{C3dParameters, ParameterSection, unsigned};

/// Size of a block, in which the format counts places, bytes.
const BLOCK: usize = 512;

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

/// The words of the header that are used, in the order of the file.
struct C3dHeader {
    points: u16,
    analog_samples: u16,
    first_frame: u16,
    last_frame: u16,
    scale: f64,
    data_block: u16,
    rate_hz: f64,
}

impl C3dHeader {
    fn parse(block: &[u8; BLOCK], machine: NumberFormat) -> Self {
        let word = |at: usize| machine.word([block[at], block[at + 1]]);
        let real =
            |at: usize| machine.real([block[at], block[at + 1], block[at + 2], block[at + 3]]);
        Self {
            points: word(2),
            analog_samples: word(4),
            first_frame: word(6),
            last_frame: word(8),
            scale: real(12),
            data_block: word(16),
            rate_hz: real(20),
        }
    }

    /// Returns the number of frames from the first and last; none if 16 bits may not suffice.
    fn frames(&self) -> Option<f64> {
        let is_sound = self.last_frame >= self.first_frame && self.last_frame < u16::MAX;
        is_sound.then(|| f64::from(self.last_frame) - f64::from(self.first_frame) + 1.0)
    }
}

/// The layout of frames of points in the data section.
struct PointsLayout {
    machine: NumberFormat,
    /// Byte at which the first frame begins.
    start: u64,
    frames: usize,
    points: usize,
    /// Bytes of a frame, analog samples included.
    stride: usize,
    /// Source units in one count; `None` for floats.
    scale: Option<f64>,
}

/// Reads a whole file.
///
/// # Errors
/// For incomplete files: damaged parameters, fewer frames than stated, no markers.
pub(super) fn read(path: &Path) -> Result<Markers> {
    let file = File::open(path).map_err(|source| Error::io(path, source))?;
    let length = file
        .metadata()
        .map_err(|source| Error::io(path, source))?
        .len();
    read_from(path, BufReader::new(file), length)
}

fn read_from(path: &Path, mut file: impl Read + Seek, length: u64) -> Result<Markers> {
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

    let layout = layout(&header, &parameters, machine, &mut warnings).map_err(wrong)?;
    let (names, kept) = names(&parameters, layout.points, &mut warnings).map_err(wrong)?;
    let sample_rate_hz = rate_hz(&header, &parameters, &mut warnings).map_err(wrong)?;
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
    let frames = read_frames(path, &mut file, &layout, &kept)?;
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

/// Returns the layout of the data from header and parameters, which must agree.
fn layout(
    header: &C3dHeader,
    parameters: &C3dParameters,
    machine: NumberFormat,
    warnings: &mut Vec<String>,
) -> std::result::Result<PointsLayout, String> {
    let points = header.points;
    if let Some(used) = parameters.count("POINT:USED")
        && used != f64::from(points)
    {
        return Err(format!(
            "the header counts {points} points, POINT:USED {used}: expected the same"
        ));
    }
    if points == 0 {
        return Err("no markers: the file has 0 points".into());
    }
    let scale = parameters.number("POINT:SCALE").unwrap_or(header.scale);
    if scale.is_nan() || scale == 0.0 || (scale < 0.0) != (header.scale < 0.0) {
        return Err(format!(
            "expected one scale of points, positive for integers or negative for floats, found {} in the header and {scale} in POINT:SCALE",
            header.scale
        ));
    }
    let start = match header.data_block {
        0 => parameters.count("POINT:DATA_START").unwrap_or_default(),
        block => block.into(),
    };
    if start < 2.0 {
        return Err(format!("expected the data from block 2 on, found {start}"));
    }
    let width = if scale < 0.0 { 4 } else { 2 };
    Ok(PointsLayout {
        machine,
        start: (whole(start) as u64 - 1) * BLOCK as u64,
        frames: whole(frame_count(header, parameters, warnings)?),
        points: points.into(),
        stride: width * (4 * usize::from(points) + usize::from(header.analog_samples)),
        scale: (scale > 0.0).then_some(scale),
    })
}

/// Returns a count as an index, clamped to the range of indices.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates, and the result is compared with the file's length"
)]
fn whole(count: f64) -> usize {
    count as usize
}

/// Returns the header's count of frames, or one from the parameters if its 16 bits do not suffice.
fn frame_count(
    header: &C3dHeader,
    parameters: &C3dParameters,
    warnings: &mut Vec<String>,
) -> std::result::Result<f64, String> {
    // Two words, the low one first, or one number.
    let field = |name| match *parameters.numbers(name) {
        [low, high, ..] => Some(unsigned(low) + 65_536.0 * unsigned(high)),
        [number] => Some(unsigned(number)),
        [] => None,
    };
    let trial = field("TRIAL:ACTUAL_START_FIELD")
        .zip(field("TRIAL:ACTUAL_END_FIELD"))
        .map(|(start, end)| end - start + 1.0);
    let long = parameters.number("POINT:LONG_FRAMES");
    let added = [trial, long, parameters.count("POINT:FRAMES")];
    let plausible = |count: &f64| *count >= 1.0 && count.is_finite();
    let beyond = [trial, long]
        .into_iter()
        .flatten()
        .find(|&count| count > 65_535.0);
    let count = beyond
        .or(header.frames())
        .or(added.into_iter().flatten().find(plausible))
        .filter(plausible)
        .ok_or_else(|| {
            format!(
                "expected at least one frame, found frames {} to {}",
                header.first_frame, header.last_frame
            )
        })?;
    // POINT:FRAMES is one word and cannot state larger counts.
    let others = [trial, long, added[2].filter(|_| count < 65_535.0)];
    if let Some(other) = others.into_iter().flatten().find(|&other| other != count) {
        warnings.push(format!(
            "the stated numbers of frames differ, {count} and {other}: {count} are used"
        ));
    }
    Ok(count)
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
