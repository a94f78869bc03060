//! The picture files of one sequence, and how they are read.

use std::fs;
use std::io::{BufRead, BufReader, Cursor, Read as _, Seek};
use std::ops::Range;
use std::path::{Path, PathBuf};

use image::{ImageFormat, ImageReader};

use super::frame::GreyPicture;
use super::{MAX_BYTES, MAX_FRAMES, MAX_SIDE, Modality, pickle};
use crate::dataset::npy::{mask_array, stated_shape};
use crate::error::{Error, FilePlace, Remedy, Result};
use crate::files::{doubts, numbered_files, open, picture_limits};

/// The maximum number of names that a message lists.
const LISTED: usize = 12;

/// The files that hold the pictures of a sequence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum FrameFiles {
    /// One PNG or JPEG for each frame, in order.
    Pictures(Vec<PathBuf>),
    /// One pickle or .npy file of all frames.
    Array(PathBuf),
}

impl FrameFiles {
    /// Lists the files in a folder, or those of a modality.
    pub(super) fn list(folder: &Path, modality: Option<&Modality>) -> Result<Self> {
        let all = files(folder)?;
        let refuse = |problem: String| Err(Error::input(folder, problem));
        let files = match modality {
            None => all,
            Some(modality) => {
                let found = listed(&all);
                let chosen = modality.select(all);
                if chosen.is_empty() {
                    return refuse(format!(
                        "expected files of modality {modality}, found {found}"
                    ));
                }
                chosen
            }
        };
        let kind = |path: &PathBuf| StoredFormat::from_name(path);
        if let Some(other) = files.iter().find(|path| kind(path).is_none()) {
            let found = if other.is_dir() {
                "a folder (are people's folders one level further down?)"
            } else {
                "another kind of file"
            };
            return Err(Error::input(
                other,
                format!("expected frames as {FRAMES}, found {found}"),
            ));
        }
        let count = |wanted| {
            let files = files.iter();
            files.filter(|file| kind(file) == Some(wanted)).count()
        };
        let [pickles, arrays, pngs, jpegs] = [
            StoredFormat::Pickle,
            StoredFormat::Npy,
            StoredFormat::Png,
            StoredFormat::Jpeg,
        ]
        .map(count);
        match (files.len(), pickles + arrays) {
            (0, _) if folder.join(TEMPLATE).exists() => refuse(format!(
                "expected frames as {FRAMES}, found only {TEMPLATE}, a template (GEIs go into geis.npy with an index.csv)"
            )),
            (0, _) => refuse(format!("expected frames as {FRAMES}, found none")),
            (1, 1) => Ok(Self::Array(files.into_iter().next().unwrap_or_default())),
            (found, 0) if found > MAX_FRAMES => refuse(format!(
                "expected at most {MAX_FRAMES} frames, found {found}"
            )),
            (_, 0) if pngs > 0 && jpegs > 0 => refuse(format!(
                "expected frames of one kind, found {pngs} .png and {jpegs} .jpg"
            )),
            (_, 0) => Ok(Self::Pictures(files)),
            (found, arrays) => Err(Error::input(
                folder,
                format!(
                    "expected one .pkl or .npy and nothing else, found {arrays} and {} pictures: {}",
                    found - arrays,
                    listed(&files)
                ),
            )
            .with_remedy(Remedy::OneModality)),
        }
    }

    /// Calls `show` with the pictures of these numbers, in order, and the file of each.
    pub(super) fn show(
        &self,
        frames: Range<usize>,
        mut show: impl FnMut(&Path, GreyPicture<'_>) -> Result<()>,
    ) -> Result<()> {
        let wanted = |all: usize| frames.start.min(all)..frames.end.min(all);
        match self {
            Self::Array(path) => show_array(path, wanted, show),
            Self::Pictures(paths) => {
                let mut first = None;
                paths[wanted(paths.len())].iter().try_for_each(|path| {
                    let (mut pixels, columns) = decode(path)?;
                    // Masks of 0 and 1 are stored so that they look black.
                    if pixels.iter().max() == Some(&1)
                        && StoredFormat::from_name(path) == Some(StoredFormat::Png)
                    {
                        pixels.iter_mut().for_each(|pixel| *pixel *= 255);
                    }
                    let size = (pixels.len() / columns, columns);
                    check_same(path, size, *first.get_or_insert(size))?;
                    let pixels = &pixels;
                    show(path, GreyPicture { pixels, columns })
                })
            }
        }
    }

    /// Returns what is doubtful about the order of the pictures, or about their being evenly spaced.
    pub(super) fn doubts(&self) -> Option<String> {
        match self {
            Self::Array(_) => None,
            Self::Pictures(paths) => doubts(paths),
        }
    }

    /// Counts the pictures, in an array from its beginning; none if the beginning has no shape.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub(super) fn count(&self) -> Result<Option<usize>> {
        match self {
            Self::Array(path) => Ok(beginning(path)?.map(|[frames, ..]| frames)),
            Self::Pictures(paths) => Ok(Some(paths.len())),
        }
    }

    /// Returns the rows and columns of the pictures from the beginnings of the files; none if a
    /// file does not begin with its size.
    ///
    /// # Errors
    /// If pictures of one sequence have different sizes, or a file cannot be read.
    pub(super) fn size(&self) -> Result<Option<(usize, usize)>> {
        match self {
            Self::Array(path) => {
                let shape = beginning(path)?;
                Ok(shape.map(|[_, rows, columns]| (rows, columns)))
            }
            Self::Pictures(paths) => {
                let mut first = None;
                for path in paths {
                    // Unreadable files are reported when they are read in full.
                    let header = reader(path, BufReader::new(open(path)?), (0, 0));
                    let Ok((columns, rows)) = header.into_dimensions() else {
                        return Ok(None);
                    };
                    let size = (rows as usize, columns as usize);
                    check_same(path, size, *first.get_or_insert(size))?;
                }
                Ok(first)
            }
        }
    }
}

/// The number of bytes within which NumPy writes the shape.
const BEGINNING: u64 = 512;

/// Reads the shape of an array from the beginning of its file, if it is there.
fn beginning(path: &Path) -> Result<Option<[usize; 3]>> {
    let mut start = Vec::new();
    let mut file = open(path)?.take(BEGINNING);
    let read = file.read_to_end(&mut start);
    read.map_err(|error| Error::io(path, error))?;
    Ok(match StoredFormat::from_name(path) {
        Some(StoredFormat::Npy) => stated_shape(&start),
        _ => pickle::shape(&start),
    })
}

fn check_same(path: &Path, size: (usize, usize), expected: (usize, usize)) -> Result<()> {
    if size == expected {
        return Ok(());
    }
    Err(Error::input(
        path,
        format!(
            "expected {}x{} pixels as in the frames before, found {}x{}",
            expected.0, expected.1, size.0, size.1
        ),
    ))
}

/// Lists the names of files for a message.
fn listed(files: &[PathBuf]) -> String {
    let names = files
        .iter()
        .take(LISTED)
        .filter_map(|path| path.file_name());
    let names: Vec<_> = names.map(|name| name.to_string_lossy()).collect();
    match files.len() {
        0 => "none".to_owned(),
        all if all > LISTED => format!("{}, ... ({all} in all)", names.join(", ")),
        _ => names.join(", "),
    }
}

/// The name of a GEI that CASIA-B's tools leave among the frames; OpenGait's pretreatment ignores it.
pub(in crate::dataset) const TEMPLATE: &str = "gei.png";

/// Lists the files in a folder in natural order, without a GEI.
fn files(path: &Path) -> Result<Vec<PathBuf>> {
    let mut files = numbered_files(path)?;
    files.retain(|file| file.file_name().is_none_or(|name| name != TEMPLATE));
    Ok(files)
}

/// The kinds of files that hold frames, for messages.
const FRAMES: &str = ".png or .jpg, or all of them in one .pkl or .npy";

/// The format of a file of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StoredFormat {
    Png,
    Jpeg,
    Pickle,
    Npy,
}

impl StoredFormat {
    /// Returns the format that a name states by its extension.
    fn from_name(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_ascii_lowercase();
        match extension.to_str()? {
            "png" => Some(Self::Png),
            "jpg" | "jpeg" => Some(Self::Jpeg),
            "pkl" => Some(Self::Pickle),
            "npy" => Some(Self::Npy),
            _ => None,
        }
    }
}

/// Returns a reader of a picture of this size, or of its header, with limits.
fn reader<R: BufRead + Seek>(path: &Path, from: R, size: (u32, u32)) -> ImageReader<R> {
    let format = match StoredFormat::from_name(path) {
        Some(StoredFormat::Jpeg) => ImageFormat::Jpeg,
        _ => ImageFormat::Png,
    };
    let mut reader = ImageReader::with_format(from, format);
    reader.limits(picture_limits(MAX_SIDE, size));
    reader
}

/// Decodes a picture; returns its grey pixels and the number of columns.
pub(in crate::dataset) fn decode(path: &Path) -> Result<(Vec<u8>, usize)> {
    let mut bytes = Vec::new();
    let read = open(path)?.take(MAX_BYTES).read_to_end(&mut bytes);
    read.map_err(|error| Error::io(path, error))?;
    let name = match StoredFormat::from_name(path) {
        Some(StoredFormat::Jpeg) => "JPEG",
        _ => "PNG",
    };
    let of_size = |size| reader(path, Cursor::new(&bytes), size);
    let size = of_size((0, 0)).into_dimensions();
    let picture = size
        .and_then(|size| of_size(size).decode())
        .map_err(|error| Error::input(path, format!("cannot be read as {name}: {error}")))?;
    if picture.color().has_alpha() {
        return Err(Error::input(
            path,
            "expected a silhouette in grey, found one with transparency (flatten it onto black)",
        ));
    }
    let columns = picture.width() as usize;
    if picture.color().has_color() {
        let is_grey = |pixel: &image::Rgb<u8>| pixel.0.iter().all(|part| *part == pixel.0[0]);
        if !picture.to_rgb8().pixels().all(is_grey) {
            return Err(Error::input(
                path,
                "expected a silhouette in grey, found a picture in colour (segment it first)",
            ));
        }
    }
    Ok((picture.into_luma8().into_raw(), columns))
}

/// Calls `show` with pictures of an array `[frames][rows][columns]`; `wanted` chooses them
/// given the number of frames.
fn show_array(
    path: &Path,
    wanted: impl Fn(usize) -> Range<usize>,
    mut show: impl FnMut(&Path, GreyPicture<'_>) -> Result<()>,
) -> Result<()> {
    let io = |error| Error::io(path, error);
    let length = fs::metadata(path).map_err(io)?.len();
    if length > MAX_BYTES {
        return Err(Error::input(
            path,
            format!("expected an array of at most {MAX_BYTES} bytes, found {length}"),
        ));
    }
    let bytes = crate::files::read(path)?;
    let array = match StoredFormat::from_name(path) {
        Some(StoredFormat::Npy) => {
            mask_array(&bytes).map_err(|problem| Error::input(path, problem))?
        }
        _ => pickle::read(&bytes)
            .map_err(|refused| Error::at(path, FilePlace::Byte(refused.byte), refused.problem))?,
    };
    let side = 1..=MAX_SIDE as usize;
    match *array.shape {
        [all @ 1..=MAX_FRAMES, rows, columns]
            if side.contains(&rows) && side.contains(&columns) =>
        {
            let wanted = wanted(all);
            let frames = array.bytes.chunks_exact(rows * columns);
            let mut frames = frames.skip(wanted.start).take(wanted.len());
            frames.try_for_each(|pixels| show(path, GreyPicture { pixels, columns }))
        }
        _ => Err(Error::input(
            path,
            format!(
                "expected an array of 1 to {MAX_FRAMES} frames of at most {MAX_SIDE}x{MAX_SIDE}, [frames][rows][columns], found {:?}",
                array.shape
            ),
        )),
    }
}
