//! Reader of YUV4MPEG2, a plain video format for pipes: a line of text, and for each frame a line
//! and its planes (mjpegtools, yuv4mpeg(5)).

use crate::error::{Error, FilePlace, Result};
use crate::files::hex;
use image::RgbImage;
use rayon::prelude::*;
use sha2::{Digest as _, Sha256};
use std::io::{BufRead, Read as _};
use std::path::{Path, PathBuf};

/// The maximum number of rows or columns in a frame.
pub(super) const MAX_SIDE: u32 = 8192;
/// The maximum number of pixels in a frame: 16 Mi, more than 4K video has.
pub(super) const MAX_PIXELS: u32 = 1 << 24;
/// The maximum number of bytes in a line of text; programs write about 80.
const MAX_LINE: u64 = 1 << 10;

/// The number of pixels that share a colour, across and down, or none for grey video.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Chroma {
    Shared(u32, u32),
    None,
}

/// The size and the colours of a video's frames.
#[derive(Clone, Copy)]
struct FrameFormat {
    columns: u32,
    rows: u32,
    chroma: Chroma,
    /// Whether bytes use their full range, not only 16 to 235 or 240.
    full: bool,
}

/// A video that is read frame by frame.
pub(super) struct Y4m<R> {
    reader: R,
    /// The path that errors name.
    path: PathBuf,
    format: FrameFormat,
    /// The frame rate, if the first line states it.
    fps: Option<f64>,
    /// Bytes read so far.
    at: usize,
    hash: Sha256,
}

impl<R: BufRead> Y4m<R> {
    /// Reads the first line.
    ///
    /// # Errors
    /// If it is not the first line of such a video, the kind is not supported, or reading fails.
    pub(super) fn open(reader: R, path: &Path) -> Result<Self> {
        let mut video = Self {
            reader,
            path: path.to_path_buf(),
            format: FrameFormat {
                columns: 0,
                rows: 0,
                chroma: Chroma::Shared(2, 2),
                full: false,
            },
            fps: None,
            at: 0,
            hash: Sha256::new(),
        };
        let line = video.line()?;
        let line = line.unwrap_or_default();
        let Some(parameters) = line.strip_prefix("YUV4MPEG2") else {
            return Err(video.refuse("expected a video that begins with YUV4MPEG2 (Y4M, as ffmpeg -f yuv4mpegpipe writes it), found something else"));
        };
        let is_full = |name: &str| name.eq_ignore_ascii_case("COLORRANGE=FULL");
        for parameter in parameters.split_ascii_whitespace() {
            let mut letters = parameter.chars();
            let tag = letters.next().unwrap_or(' ');
            let value = letters.as_str();
            match tag {
                'W' => video.format.columns = video.side(parameter, value)?,
                'H' => video.format.rows = video.side(parameter, value)?,
                'F' => video.fps = rate(value),
                'C' => video.format.chroma = video.chroma_of(value)?,
                'I' if !matches!(value, "p" | "?") => {
                    return Err(video.refuse(format!(
                        "expected whole frames (Ip), found {parameter}, interlaced fields (deinterlace first, as ffmpeg -vf yadif does)"
                    )));
                }
                'X' if is_full(value) => video.format.full = true,
                _ => {}
            }
        }
        let pixels = u64::from(video.format.columns) * u64::from(video.format.rows);
        if pixels == 0 || pixels > u64::from(MAX_PIXELS) {
            return Err(video.refuse(format!(
                "expected a width (W) and a height (H) of 1 to {MAX_PIXELS} pixels in all, found {}x{}",
                video.format.columns, video.format.rows
            )));
        }
        Ok(video)
    }

    /// Returns the columns and rows of each frame.
    pub(super) const fn size(&self) -> (u32, u32) {
        (self.format.columns, self.format.rows)
    }

    /// Returns the frame rate, if the first line states it.
    pub(super) const fn fps(&self) -> Option<f64> {
        self.fps
    }

    /// Returns the path that errors name.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the SHA-256 of the bytes read, except frames of [`Self::frame`].
    pub(super) fn sha256(self) -> String {
        hex(&self.hash.finalize())
    }

    /// Reads the next frames, at most `most`; fewer only at the end.
    ///
    /// # Errors
    /// If a frame is truncated or begins with something else, or reading fails.
    pub(super) fn read(&mut self, most: usize) -> Result<Vec<RgbImage>> {
        let mut frames = Vec::new();
        while frames.len() < most {
            match self.planes()? {
                Some(planes) => {
                    self.hash.update(&planes);
                    frames.push(planes);
                }
                None => break,
            }
        }
        let format = self.format;
        Ok(frames
            .par_iter()
            .map(|planes| rgb(planes, format))
            .collect())
    }

    /// Reads the bytes of the next frame; none at the end.
    fn planes(&mut self) -> Result<Option<Vec<u8>>> {
        let Some(line) = self.line()? else {
            return Ok(None);
        };
        if line != "FRAME" && !line.starts_with("FRAME ") {
            return Err(self.refuse("expected FRAME, found something else"));
        }
        let luma = self.format.columns as usize * self.format.rows as usize;
        let length = luma
            + 2 * self
                .format
                .chroma
                .pixels(self.format.columns, self.format.rows);
        // Memory grows with the bytes present, since a header may lie.
        let mut bytes = Vec::new();
        let mut read = self.reader.by_ref().take(length as u64);
        let found = read.read_to_end(&mut bytes);
        let found = found.map_err(|error| Error::io(&self.path, error))?;
        if found < length {
            return Err(self.refuse(format!(
                "expected {length} bytes of a frame, found {found} before the end"
            )));
        }
        self.at += found;
        Ok(Some(bytes))
    }

    /// Reads the next frame, on this thread and without hashing it; none at the end.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub(super) fn frame(&mut self) -> Result<Option<RgbImage>> {
        let format = self.format;
        Ok(self.planes()?.map(|planes| rgb(&planes, format)))
    }

    /// Reads a line without its end; none at the end of the video.
    fn line(&mut self) -> Result<Option<String>> {
        let mut line = Vec::new();
        let mut read = self.reader.by_ref().take(MAX_LINE);
        let found = read.read_until(b'\n', &mut line);
        if found.map_err(|error| Error::io(&self.path, error))? == 0 {
            return Ok(None);
        }
        if line.last() != Some(&b'\n') {
            return Err(self.refuse("expected a line of text that ends, found none"));
        }
        self.at += line.len();
        self.hash.update(&line);
        line.pop();
        Ok(Some(String::from_utf8_lossy(&line).into_owned()))
    }

    fn side(&self, parameter: &str, value: &str) -> Result<u32> {
        let side = value
            .parse()
            .ok()
            .filter(|side| (1..=MAX_SIDE).contains(side));
        side.ok_or_else(|| {
            self.refuse(format!(
                "expected 1 to {MAX_SIDE} pixels, found {parameter}"
            ))
        })
    }

    fn chroma_of(&self, value: &str) -> Result<Chroma> {
        match value {
            "420" | "420jpeg" | "420mpeg2" | "420paldv" => Ok(Chroma::Shared(2, 2)),
            "422" => Ok(Chroma::Shared(2, 1)),
            "444" => Ok(Chroma::Shared(1, 1)),
            "mono" => Ok(Chroma::None),
            other => Err(self.refuse(format!(
                "expected C420, C422, C444 or Cmono, of 8 bits, found C{other} (convert it, as ffmpeg -pix_fmt yuv420p does)"
            ))),
        }
    }

    fn refuse(&self, problem: impl Into<String>) -> Error {
        Error::at(&self.path, FilePlace::Byte(self.at), problem)
    }
}

impl Chroma {
    /// Returns the number of bytes of a plane of colour.
    fn pixels(self, columns: u32, rows: u32) -> usize {
        match self {
            Self::Shared(across, down) => {
                columns.div_ceil(across) as usize * rows.div_ceil(down) as usize
            }
            Self::None => 0,
        }
    }
}

/// Parses a frame rate such as `30:1` or `30000:1001`; none for `0:0`, which means unknown.
fn rate(value: &str) -> Option<f64> {
    let (over, under) = value.split_once(':')?;
    let (over, under): (u32, u32) = (over.parse().ok()?, under.parse().ok()?);
    (over > 0 && under > 0).then(|| f64::from(over) / f64::from(under))
}

/// Converts a frame to RGB (Rec. ITU-R BT.601-7, 2.5.1 and 2.5.3). A shared colour is used for each
/// of its pixels.
fn rgb(planes: &[u8], format: FrameFormat) -> RgbImage {
    let FrameFormat {
        columns,
        rows,
        chroma,
        full,
    } = format;
    let luma = columns as usize * rows as usize;
    let colour = chroma.pixels(columns, rows);
    let (luma, rest) = planes.split_at(luma);
    let (blue, red) = rest.split_at(colour);
    let (black, light, share) = if full {
        (0.0, 1.0, 1.0)
    } else {
        (16.0, 255.0 / 219.0, 255.0 / 224.0)
    };
    RgbImage::from_fn(columns, rows, |x, y| {
        let level = light * (f32::from(luma[(y * columns + x) as usize]) - black);
        let (b, r) = match chroma {
            Chroma::None => (0.0, 0.0),
            Chroma::Shared(across, down) => {
                let at = (y / down * columns.div_ceil(across) + x / across) as usize;
                let part = |plane: &[u8]| share * (f32::from(plane[at]) - 128.0);
                (part(blue), part(red))
            }
        };
        // 2 (1 - 0.299) for red and 2 (1 - 0.114) for blue; green is what they leave, over 0.587.
        let green = level - 0.344_136 * b - 0.714_136 * r;
        let byte = |value: f32| (value + 0.5) as u8;
        image::Rgb([
            byte(level + 1.402 * r),
            byte(green),
            byte(level + 1.772 * b),
        ])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(bytes: &[u8]) -> Result<Y4m<&[u8]>> {
        Y4m::open(bytes, Path::new("x.y4m"))
    }

    fn frames(bytes: &[u8]) -> Vec<RgbImage> {
        let mut video = open(bytes).unwrap();
        let mut frames = Vec::new();
        loop {
            let more = video.read(2).unwrap();
            if more.is_empty() {
                return frames;
            }
            frames.extend(more);
        }
    }

    fn refused(bytes: &[u8]) -> String {
        match open(bytes).and_then(|mut video| video.read(9)) {
            Ok(_) => panic!("it is read"),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn the_first_line_says_the_rate_unless_it_is_not_known() {
        let fps = |rate: &str| {
            let bytes = format!("YUV4MPEG2 W2 H2 {rate} Cmono\n").into_bytes();
            open(&bytes).unwrap().fps()
        };
        assert_eq!(
            [fps("F30:1"), fps("F25:2"), fps("F0:0"), fps("")],
            [Some(30.0), Some(12.5), None, None]
        );
        assert!((fps("F30000:1001").unwrap() - 29.970_03).abs() < 1e-5);
    }

    #[test]
    fn colours_are_those_of_bt_601() {
        // Black is 16 and white 235. Red of 75 % has 16 + 65.481 x 0.75 = 65, Cb 100, Cr 212, and
        // becomes 191 again within rounding.
        let bytes =
            b"YUV4MPEG2 W3 H1 F25:1 Ip A1:1 C444\nFRAME\n\x10\xeb\x41\x80\x80\x64\x80\x80\xd4";
        let found = &frames(bytes)[0];
        assert_eq!(found.get_pixel(0, 0).0, [0, 0, 0]);
        assert_eq!(found.get_pixel(1, 0).0, [255, 255, 255]);
        let [r, g, b] = found.get_pixel(2, 0).0;
        assert!(r.abs_diff(191) <= 1 && g <= 1 && b <= 1, "{r} {g} {b}");
    }

    #[test]
    fn pixels_share_colours_as_the_first_line_says() {
        // 3 columns and 3 rows: planes of colour are 2 x 2, 2 x 3 or 3 x 3.
        let luma = [128_u8; 9];
        let video = |kind: &str, blue: &[u8], red: &[u8]| {
            let head = format!("YUV4MPEG2 W3 H3{kind} XCOLORRANGE=FULL\nFRAME Ip\n");
            [head.as_bytes(), &luma, blue, red].concat()
        };
        // Cb of 178 adds 1.772 x 50 = 88.6 to blue.
        let is_blue = |bytes: &[u8]| -> Vec<bool> {
            let frame = &frames(bytes)[0];
            frame.pixels().map(|pixel| pixel.0[2] == 217).collect()
        };
        let corner = |bytes: &[u8]| is_blue(bytes).iter().filter(|blue| **blue).count();
        let plain = |length: usize| vec![128_u8; length];
        let mut blue = plain(4);
        blue[0] = 178;
        for kind in ["", " C420", " C420jpeg", " C420mpeg2", " C420paldv"] {
            assert_eq!(corner(&video(kind, &blue, &plain(4))), 4);
        }
        let mut blue = plain(6);
        blue[3] = 178;
        // The second row, the last column, whose partner is outside.
        let found = is_blue(&video(" C422", &blue, &plain(6)));
        assert_eq!(found.iter().position(|blue| *blue), Some(5));
        let mut blue = plain(9);
        blue[7] = 178;
        let found = is_blue(&video(" C444", &blue, &plain(9)));
        assert_eq!(
            (found[7], found.iter().filter(|blue| **blue).count()),
            (true, 1)
        );
        let grey = [b"YUV4MPEG2 Cmono W2 H1\nFRAME\n".as_slice(), &[16, 126]].concat();
        assert_eq!(frames(&grey)[0].as_raw(), &[0, 0, 0, 128, 128, 128]);
    }

    #[test]
    fn frames_come_until_the_end() {
        let frame = |grey: u8| [b"FRAME\n".as_slice(), &[grey, grey]].concat();
        let bytes = [
            b"YUV4MPEG2 W2 H1 Cmono\n".to_vec(),
            frame(16),
            frame(235),
            frame(60),
        ]
        .concat();
        let found = frames(&bytes);
        let greys: Vec<u8> = found.iter().map(|frame| frame.as_raw()[0]).collect();
        assert_eq!(greys, [0, 255, 51]);

        // Frames read one by one are the same; frames read in batches are hashed.
        let mut video = open(&bytes).unwrap();
        let mut one_by_one = Vec::new();
        while let Some(frame) = video.frame().unwrap() {
            one_by_one.push(frame);
        }
        assert_eq!(one_by_one, found);
        let mut video = open(&bytes).unwrap();
        assert_eq!(video.read(9).unwrap().len(), 3);
        assert!(video.read(9).unwrap().is_empty());
        assert_eq!(video.sha256(), hex(&Sha256::digest(&bytes)));
    }

    #[test]
    fn what_is_not_supported_or_broken_is_refused_by_name() {
        for (bytes, expected) in [
            (
                &b""[..],
                "x.y4m at byte 0: expected a video that begins with YUV4MPEG2",
            ),
            (b"RIFF\n", "begins with YUV4MPEG2"),
            (b"YUV4MPEG2 W2 H2 C420p10\n", "found C420p10"),
            (b"YUV4MPEG2 W2 H2 C411\n", "found C411"),
            (b"YUV4MPEG2 W2 H2 C444alpha\n", "found C444alpha"),
            (b"YUV4MPEG2 W2 H2 It\n", "found It, interlaced"),
            (b"YUV4MPEG2 W0 H2\n", "found W0"),
            (b"YUV4MPEG2 W-3 H2\n", "found W-3"),
            (b"YUV4MPEG2 W99999999999999999999 H2\n", "found W9999"),
            (b"YUV4MPEG2 W8192 H8192\n", "found 8192x8192"),
            (b"YUV4MPEG2 H2\n", "found 0x2"),
            (b"YUV4MPEG2 W2 H2", "that ends"),
            (b"YUV4MPEG2 W2 H1 Cmono\nFRAM\n", "byte 27: expected FRAME"),
            (
                b"YUV4MPEG2 W2 H1 Cmono\nFRAME\n\x01",
                "expected 2 bytes of a frame, found 1",
            ),
            (b"YUV4MPEG2 W4096 H4096\nFRAME\nx", "found 1 before the end"),
        ] {
            let found = refused(bytes);
            assert!(found.contains(expected), "{found}");
        }
        let endless = vec![b' '; 5000];
        assert!(refused(&endless).contains("that ends"));
    }
}
