//! Reads video as a stream: Y4M on standard input, in a file, or from an `ffmpeg` that decodes any
//! other file.

use super::y4m::Y4m;
use crate::error::{Error, Result};
use crate::files::InputFile;
use image::RgbImage;
use std::ffi::OsString;
use std::io::{BufRead, BufReader, ErrorKind, Read as _};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::thread::JoinHandle;

/// Bytes of a read: the size of a few pipe buffers.
const BUFFER: usize = 1 << 18;
/// The maximum number of bytes in the messages of `ffmpeg` that are shown.
const MOST_SAID: u64 = 1 << 12;

/// A stream of frames.
pub(super) struct Stream {
    video: Y4m<Box<dyn BufRead + Send>>,
    ffmpeg: Option<Ffmpeg>,
}

/// The process that writes the stream; dropping this ends it.
#[derive(Debug)]
struct Ffmpeg {
    process: Child,
    said: Option<JoinHandle<String>>,
    /// What it said though it did not fail.
    doubts: String,
}

impl Stream {
    /// Opens standard input for `-`, a file of Y4M, or another file that `ffmpeg` reads.
    ///
    /// # Errors
    /// If the file is not a video, of an unsupported kind, or `ffmpeg` is needed and missing.
    pub(super) fn open(path: &Path) -> Result<Self> {
        if path == Path::new("-") {
            let reader = BufReader::with_capacity(BUFFER, std::io::stdin());
            return Self::from_reader(Box::new(reader), Path::new("standard input"), None);
        }
        let file = crate::files::open(path)?;
        let mut reader = BufReader::with_capacity(BUFFER, file);
        let start = reader.fill_buf().map_err(|error| Error::io(path, error))?;
        let is_y4m = path
            .extension()
            .is_some_and(|found| found.eq_ignore_ascii_case("y4m"));
        if is_y4m || start.starts_with(b"YUV4MPEG2") {
            return Self::from_reader(Box::new(reader), path, None);
        }
        drop(reader);
        let (ffmpeg, frames) = Ffmpeg::start(path)?;
        Self::from_reader(Box::new(frames), path, Some(ffmpeg))
    }

    fn from_reader(
        reader: Box<dyn BufRead + Send>,
        path: &Path,
        mut ffmpeg: Option<Ffmpeg>,
    ) -> Result<Self> {
        match Y4m::open(reader, path) {
            Ok(video) => Ok(Self { video, ffmpeg }),
            Err(error) => {
                // An error of ffmpeg is more helpful than that its stream has no beginning.
                ffmpeg
                    .as_mut()
                    .map_or(Ok(()), |ffmpeg| ffmpeg.finish(path))?;
                Err(error)
            }
        }
    }

    /// Returns the columns and rows of each frame.
    pub(super) const fn size(&self) -> (u32, u32) {
        self.video.size()
    }

    /// Reads the next frames, at most `most`; fewer only at the end.
    ///
    /// # Errors
    /// If a frame is truncated, or `ffmpeg` fails, with its message.
    pub(super) fn read(&mut self, most: usize) -> Result<Vec<RgbImage>> {
        let frames = self.video.read(most);
        let is_end = frames.as_ref().map_or(true, |frames| frames.len() < most);
        if is_end && let Some(ffmpeg) = &mut self.ffmpeg {
            ffmpeg.finish(self.video.path())?;
        }
        frames
    }

    /// Reads the next frame, on this thread and without hashing it; none at the end.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub(super) fn frame(&mut self) -> Result<Option<RgbImage>> {
        let frame = self.video.frame();
        if !matches!(frame, Ok(Some(_)))
            && let Some(ffmpeg) = &mut self.ffmpeg
        {
            ffmpeg.finish(self.video.path())?;
        }
        frame
    }

    /// Returns the frame rate, if the first line states it.
    pub(super) const fn fps(&self) -> Option<f64> {
        self.video.fps()
    }

    /// Returns whether `ffmpeg` decodes the stream.
    pub(super) const fn has_ffmpeg(&self) -> bool {
        self.ffmpeg.is_some()
    }

    /// Returns what `ffmpeg` said though it did not fail, as of a file that was cut off.
    pub(super) fn doubts(&self) -> Option<String> {
        let said = &self.ffmpeg.as_ref()?.doubts;
        (!said.is_empty()).then(|| format!("ffmpeg says: {said}"))
    }

    /// Returns the video as an input with the SHA-256 of the bytes read, or of the whole file if
    /// `ffmpeg` decodes it.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub(super) fn input(self, path: &Path) -> Result<InputFile> {
        if self.ffmpeg.is_some() {
            return InputFile::read(path);
        }
        Ok(InputFile {
            path: path.display().to_string(),
            sha256: self.video.sha256(),
        })
    }
}

impl Ffmpeg {
    /// Starts `ffmpeg` on a file and returns it with its output.
    fn start(path: &Path) -> Result<(Self, impl BufRead + Send + use<>)> {
        // With the protocol's name, no path is mistaken for a flag or an address.
        let mut input = OsString::from("file:");
        input.push(path);
        let started = Command::new("ffmpeg")
            .args(["-nostdin", "-loglevel", "error", "-i"])
            .arg(input)
            .args(["-map", "0:v:0", "-pix_fmt", "yuv444p"])
            // The colours that the reader expects.
            .args(["-vf", "scale=out_color_matrix=bt601:out_range=tv"])
            .args(["-f", "yuv4mpegpipe", "pipe:1"])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn();
        let mut process = started.map_err(|error| match error.kind() {
            ErrorKind::NotFound => Error::input(
                path,
                "expected a folder of frames, or a video in Y4M; any other needs the program ffmpeg, which is not installed (install it, or decode the video into a folder of .png elsewhere)",
            ),
            _ => Error::Failed(format!("ffmpeg cannot be started: {error}")),
        })?;
        let frames = process
            .stdout
            .take()
            .ok_or(Error::Missing("ffmpeg's output"))?;
        // Read at the same time as the frames, so that neither pipe fills up while the other waits.
        let said = process
            .stderr
            .take()
            .map(|from| std::thread::Builder::new().spawn(move || said(from)))
            .transpose();
        let frames = BufReader::with_capacity(BUFFER, frames);
        // Ends the process if it is dropped.
        let mut ffmpeg = Self {
            process,
            said: None,
            doubts: String::new(),
        };
        ffmpeg.said = said.map_err(Error::Threads)?;
        Ok((ffmpeg, frames))
    }

    /// Waits for the end of `ffmpeg`.
    ///
    /// # Errors
    /// If it failed, with its message.
    fn finish(&mut self, path: &Path) -> Result<()> {
        let Some(said) = self.said.take() else {
            return Ok(());
        };
        let status = self.process.wait();
        let status = status.map_err(|error| Error::Failed(format!("ffmpeg: {error}")))?;
        let said = said.join().unwrap_or_default();
        if status.success() {
            said.trim().clone_into(&mut self.doubts);
            return Ok(());
        }
        Err(Error::input(
            path,
            format!("ffmpeg cannot read it ({status}): {}", said.trim()),
        ))
    }
}

impl Drop for Ffmpeg {
    fn drop(&mut self) {
        // Killing fails if the process has already ended.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Returns the beginning of the messages of `ffmpeg`; the rest is read and discarded.
fn said(mut from: ChildStderr) -> String {
    let mut bytes = Vec::new();
    let _ = from.by_ref().take(MOST_SAID).read_to_end(&mut bytes);
    let _ = std::io::copy(&mut from, &mut std::io::sink());
    String::from_utf8_lossy(&bytes).into_owned()
}
