//! Reads the frames of a video in batches: from a folder of pictures, a stream, or a file.

use super::background::{MIN_FRAMES, median, sample};
use super::evenly_spaced::EvenlySpaced;
use super::stream::Stream;
use super::y4m::{MAX_PIXELS, MAX_SIDE};
use crate::error::{Error, Remedy, Result};
use crate::files::{InputFile, doubts, hex, numbered_files, open, picture_limits, read};
use image::{ImageFormat, ImageReader, RgbImage};
use rayon::prelude::*;
use sha2::{Digest as _, Sha256};
use std::fs;
use std::io::{BufRead, BufReader, Cursor, Seek};
use std::path::{Path, PathBuf};

/// The maximum number of bytes in a picture's file.
const MAX_BYTES: u64 = 1 << 28;
/// The maximum number of frames in a batch, and of their bytes. Our choice: a few for each thread.
const BATCH: usize = 32;
const BATCH_BYTES: usize = 1 << 26;

/// A video that is read from its beginning to its end.
pub struct Video {
    path: PathBuf,
    size: (u32, u32),
    read: usize,
    source: FrameSource,
}

enum FrameSource {
    /// Pictures in order, and the hash of those read so far.
    Folder(Vec<PathBuf>, Box<Sha256>),
    Stream(Box<Stream>),
}

impl Video {
    /// Opens a folder of pictures (`.png`, `.jpg`, `.jpeg`), whose headers are all read, a Y4M
    /// file, a video that an installed `ffmpeg` reads, or Y4M on standard input (`-`).
    ///
    /// Pictures come in natural order: numbers in their names are compared as numbers.
    ///
    /// # Errors
    /// If there are no frames, frames have different sizes or more than 16 Mi pixels, or something
    /// else is found.
    pub fn open(path: &Path) -> Result<Self> {
        if path != Path::new("-") && path.is_dir() {
            let files = pictures(path)?;
            let size = size_of_all(&files)?;
            return Ok(Self {
                path: path.to_path_buf(),
                size,
                read: 0,
                source: FrameSource::Folder(files, Box::new(Sha256::new())),
            });
        }
        let stream = Stream::open(path)?;
        Ok(Self {
            path: path.to_path_buf(),
            size: stream.size(),
            read: 0,
            source: FrameSource::Stream(Box::new(stream)),
        })
    }

    /// Returns the columns and rows of each frame.
    #[must_use]
    pub const fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Returns the number of frames, if it is known before the end.
    #[must_use]
    pub fn frames(&self) -> Option<usize> {
        match &self.source {
            FrameSource::Folder(files, _) => Some(files.len()),
            FrameSource::Stream(_) => None,
        }
    }

    /// Reads the next frames, at most 32; none at the end.
    ///
    /// # Errors
    /// If a frame is broken, the video ends too early, or reading fails.
    pub fn batch(&mut self) -> Result<Vec<RgbImage>> {
        let bytes = 3 * self.size.0 as usize * self.size.1 as usize;
        let most = (BATCH_BYTES / bytes.max(1)).clamp(1, BATCH);
        let first = self.read;
        let frames = match &mut self.source {
            FrameSource::Folder(files, hash) => {
                let end = (first + most).min(files.len());
                let read: Vec<Result<_>> = files[first..end]
                    .par_iter()
                    .map(|file| {
                        let bytes = bytes_of(file)?;
                        let frame = decoded(file, &bytes)?;
                        Ok((bytes, frame))
                    })
                    .collect();
                let mut frames = Vec::new();
                for (file, read) in files[first..end].iter().zip(read) {
                    let (bytes, frame) = read?;
                    check_size(file, frame.dimensions(), self.size)?;
                    hash.update(&bytes);
                    frames.push(frame);
                }
                frames
            }
            FrameSource::Stream(stream) => stream.read(most)?,
        };
        self.read += frames.len();
        if self.read == 0 {
            return Err(Error::input(&self.path, "expected frames, found none"));
        }
        Ok(frames)
    }

    /// Reads the next frame, on this thread; none at the end. [`Self::input`] does not include it.
    ///
    /// # Errors
    /// As [`Self::batch`].
    pub(crate) fn frame(&mut self) -> Result<Option<RgbImage>> {
        let frame = match &mut self.source {
            FrameSource::Folder(files, _) => {
                let Some(file) = files.get(self.read) else {
                    return Ok(None);
                };
                let frame = decoded(file, &bytes_of(file)?)?;
                check_size(file, frame.dimensions(), self.size)?;
                Some(frame)
            }
            FrameSource::Stream(stream) => stream.frame()?,
        };
        self.read += usize::from(frame.is_some());
        Ok(frame)
    }

    /// Returns to the beginning.
    ///
    /// # Errors
    /// If a file can no longer be opened, or has changed its size.
    ///
    /// # Panics
    /// On standard input, which cannot be read again.
    pub(crate) fn again(&mut self) -> Result<()> {
        if let FrameSource::Stream(stream) = &mut self.source {
            assert!(self.path != Path::new("-"), "a file");
            let anew = Stream::open(&self.path)?;
            check_size(&self.path, anew.size(), self.size)?;
            **stream = anew;
        }
        self.read = 0;
        Ok(())
    }

    /// Returns what is doubtful about the order of a folder's pictures, or about their being evenly
    /// spaced in time, or what `ffmpeg` found wrong up to the end.
    #[must_use]
    pub fn doubts(&self) -> Option<String> {
        match &self.source {
            FrameSource::Folder(files, _) => doubts(files),
            FrameSource::Stream(stream) => stream.doubts(),
        }
    }

    /// Returns the frame rate, if the video states it.
    pub(crate) fn fps(&self) -> Option<f64> {
        match &self.source {
            FrameSource::Folder(..) => None,
            FrameSource::Stream(stream) => stream.fps(),
        }
    }

    /// Returns whether another process decodes the video.
    pub(crate) fn is_decoded_elsewhere(&self) -> bool {
        match &self.source {
            FrameSource::Folder(..) => false,
            FrameSource::Stream(stream) => stream.has_ffmpeg(),
        }
    }

    /// Returns the video as an input with its SHA-256: of the pictures one after another, of the
    /// stream as read, or of the whole file if `ffmpeg` decodes it.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn input(self) -> Result<InputFile> {
        match self.source {
            FrameSource::Folder(_, hash) => Ok(InputFile {
                path: self.path.display().to_string(),
                sha256: hex(&hash.finalize()),
            }),
            FrameSource::Stream(stream) => stream.input(&self.path),
        }
    }
}

/// Returns the frames whose median is a video's background: evenly spaced, at most [`sample`] many.
/// A file is read from beginning to end for this.
///
/// # Errors
/// If there are fewer than 10 frames, if the video is standard input, which cannot be read twice,
/// or as for [`Video`].
pub(super) fn background_of(path: &Path) -> Result<Vec<RgbImage>> {
    if path == Path::new("-") {
        return Err(Error::input(
            "standard input",
            "expected a picture of the empty scene, found none: a stream cannot be read twice, first for a background and then for its frames",
        )
        .with_remedy(Remedy::GiveBackground));
    }
    let mut video = Video::open(path)?;
    let most = sample(video.size);
    let (frames, count) = if let FrameSource::Folder(files, _) = &video.source {
        (spaced(files, most, video.size)?, files.len())
    } else {
        let mut spread = EvenlySpaced::new(most);
        loop {
            let batch = video.batch()?;
            if batch.is_empty() {
                break;
            }
            for frame in batch {
                spread.push(|| frame);
            }
        }
        let count = spread.seen();
        (spread.into_kept(), count)
    };
    if count < MIN_FRAMES {
        return Err(Error::input(
            path,
            format!("expected at least {MIN_FRAMES} frames, whose median is the background, found {count}"),
        )
        .with_remedy(Remedy::GiveBackground));
    }
    Ok(frames)
}

/// Returns a picture of the empty scene, or the median of several in a folder, of this size, with
/// the files that were read.
///
/// # Errors
/// If it is missing, not a picture, or of another size.
pub(super) fn given_background(
    path: &Path,
    size: (u32, u32),
) -> Result<(RgbImage, Vec<InputFile>)> {
    let files = if path.is_dir() {
        pictures(path)?
    } else {
        vec![path.to_path_buf()]
    };
    for file in &files {
        check_background_size(file, size_of(file)?, size)?;
    }
    let frames = spaced(&files, sample(size), size)?;
    let picture = median(&frames).ok_or(Error::Missing("a background"))?;
    let inputs: Result<Vec<InputFile>> = files.iter().map(InputFile::read).collect();
    Ok((picture, inputs?))
}

/// Reads at most `most` evenly spaced pictures, including the first.
fn spaced(files: &[PathBuf], most: usize, size: (u32, u32)) -> Result<Vec<RgbImage>> {
    let count = files.len().min(most);
    let numbers = (0..count).map(|at| at * files.len() / count);
    let numbers: Vec<usize> = numbers.collect();
    let read = |number: usize| {
        let file = &files[number];
        let frame = decoded(file, &bytes_of(file)?)?;
        check_size(file, frame.dimensions(), size)?;
        Ok(frame)
    };
    numbers.into_par_iter().map(read).collect()
}

/// Lists the pictures of a folder, in order.
fn pictures(folder: &Path) -> Result<Vec<PathBuf>> {
    let files = numbered_files(folder)?;
    let is_picture = |path: &PathBuf| {
        let extension = path.extension().unwrap_or_default();
        let known = ["png", "jpg", "jpeg"];
        known
            .iter()
            .any(|known| extension.eq_ignore_ascii_case(known))
            && path.is_file()
    };
    if let Some(other) = files.iter().find(|path| !is_picture(path)) {
        return Err(Error::input(
            other,
            "expected a folder of frames of one video, as .png or .jpg, found another file in it",
        ));
    }
    if files.is_empty() {
        return Err(Error::input(
            folder,
            "expected frames as .png or .jpg, found none",
        ));
    }
    Ok(files)
}

/// Returns the common size of all pictures, read from their headers.
fn size_of_all(files: &[PathBuf]) -> Result<(u32, u32)> {
    let sizes: Vec<Result<(u32, u32)>> = files.par_iter().map(|file| size_of(file)).collect();
    let mut first = None;
    for (file, size) in files.iter().zip(sizes) {
        let size = size?;
        check_size(file, size, *first.get_or_insert(size))?;
    }
    first.ok_or(Error::Missing("frames"))
}

fn check_size(file: &Path, found: (u32, u32), expected: (u32, u32)) -> Result<()> {
    if found == expected {
        return Ok(());
    }
    Err(Error::input(
        file,
        format!(
            "expected a frame of {}x{} pixels, like those before, found {}x{}",
            expected.0, expected.1, found.0, found.1
        ),
    ))
}

fn check_background_size(file: &Path, found: (u32, u32), expected: (u32, u32)) -> Result<()> {
    if found == expected {
        return Ok(());
    }
    Err(Error::input(
        file,
        format!(
            "expected a background of {}x{} pixels, like the frames, found {}x{}",
            expected.0, expected.1, found.0, found.1
        ),
    ))
}

/// Reads a picture's size from its header.
fn size_of(file: &Path) -> Result<(u32, u32)> {
    let size = known(file, BufReader::new(open(file)?), (0, 0))?
        .into_dimensions()
        .map_err(|error| no_picture(file, &error))?;
    let pixels = u64::from(size.0) * u64::from(size.1);
    if pixels == 0 || pixels > u64::from(MAX_PIXELS) || size.0.max(size.1) > MAX_SIDE {
        return Err(Error::input(
            file,
            format!(
                "expected a picture of 1 to {MAX_PIXELS} pixels, at most {MAX_SIDE} in a row or column, found {}x{}",
                size.0, size.1
            ),
        ));
    }
    Ok(size)
}

/// Reads a picture's file.
fn bytes_of(file: &Path) -> Result<Vec<u8>> {
    let io = |error| Error::io(file, error);
    let length = fs::metadata(file).map_err(io)?.len();
    if length > MAX_BYTES {
        return Err(Error::input(
            file,
            format!("expected a picture of at most {MAX_BYTES} bytes, found {length}"),
        ));
    }
    read(file)
}

/// Decodes a picture.
fn decoded(file: &Path, bytes: &[u8]) -> Result<RgbImage> {
    let of_size = |size| known(file, Cursor::new(bytes), size);
    let size = of_size((0, 0))?.into_dimensions();
    let size = size.map_err(|error| no_picture(file, &error))?;
    let picture = of_size(size)?.decode();
    let picture = picture.map_err(|error| no_picture(file, &error))?;
    Ok(picture.into_rgb8())
}

/// Returns a reader of a picture of this size, or of its header, with limits. Rejects pictures that
/// are neither PNG nor JPEG.
fn known<R: BufRead + Seek>(file: &Path, from: R, size: (u32, u32)) -> Result<ImageReader<R>> {
    let mut reader = ImageReader::new(from);
    // By its name, unless its bytes say otherwise.
    if let Ok(format) = ImageFormat::from_path(file) {
        reader.set_format(format);
    }
    let reader = reader.with_guessed_format();
    let mut reader = reader.map_err(|error| Error::io(file, error))?;
    reader.limits(picture_limits(MAX_SIDE, size));
    match reader.format() {
        Some(ImageFormat::Png | ImageFormat::Jpeg) => Ok(reader),
        _ => Err(Error::input(
            file,
            "expected a picture, PNG or JPEG, found neither",
        )),
    }
}

fn no_picture(file: &Path, error: &image::ImageError) -> Error {
    Error::input(file, format!("cannot be read as a picture: {error}"))
}
