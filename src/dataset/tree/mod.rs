//! A tree of silhouettes: pictures of walkers as CASIA-B has them and OpenGait reads them.
//!
//! `root/<person>/<take>/<view>/` holds one PNG a frame, or one pickled NumPy array of all frames
//! (github.com/ShiqiYu/OpenGait, docs/2.prepare_dataset.md). A person is called `001`, a take
//! `nm-01`, a view by its azimuth, `090`, and here also by its elevation, `090e15`. Whether an
//! azimuth of 90 shows the walker's left (as ours does) or right, is the data's to say.

mod angle;
mod frame;
mod pickle;

use std::fs;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use image::{ImageFormat, ImageReader};

use crate::error::{Error, Place, Remedy, Result};
use crate::sweep::Framing;
use angle::Angle;
use edgegait_core::silhouette::Size;
use frame::{Fit, Picture};
pub(super) use pickle::pickled;

/// Most sequences of a tree: OU-MVLP has 288,596.
const MAX_SEQUENCES: usize = 1 << 19;
/// Most frames of a sequence: more than five minutes at 30 a second.
const MAX_FRAMES: usize = 10_000;
/// Most rows or columns of a picture.
const MAX_SIDE: u32 = 4096;
/// Most bytes that a picture takes while it is decoded, and most bytes of a pickle.
const MAX_BYTES: u64 = 1 << 27;

/// Sequences of silhouettes, listed but not read.
#[derive(Clone, Debug)]
pub struct Tree {
    root: PathBuf,
    sequences: Vec<TreeSequence>,
    skipped: Vec<String>,
}

/// One take of a person from one view.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeSequence {
    /// The person's name.
    pub subject: String,
    /// The take's name, as a rule how the person walks and a number: `nm-01`.
    pub take: String,
    /// The view's name.
    pub view: String,
    /// Azimuth that the view's name states, degrees.
    pub azimuth_deg: f64,
    /// Elevation that the view's name states, degrees; 0 if it states none.
    pub elevation_deg: f64,
}

/// The silhouettes of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct Silhouettes {
    /// `[frames][rows][columns]`; 0 or 255 where they were framed here.
    pub pixels: Vec<u8>,
    /// How many there are.
    pub frames: usize,
    /// How many frames more were left out because nothing was on them.
    pub empty: usize,
    /// Mean share of the figure that is cut off at the sides, 0..1; 0 without frames.
    pub clipped_share: f64,
}

impl Tree {
    /// Lists the sequences of a tree by name: people, of each the takes, of each the views. Looks
    /// into folders of three levels and into no file; files beside those folders are passed over,
    /// and so are people none of whose views are named by an angle, which [`Self::skipped`] names.
    ///
    /// # Errors
    /// If a folder cannot be read, a person has views named by angles and others that are not,
    /// there is no sequence, or there are more than 524,288.
    pub fn open(root: impl AsRef<Path>) -> Result<Self> {
        let root = root.as_ref().to_path_buf();
        let mut tree = Self {
            root: root.clone(),
            sequences: Vec::new(),
            skipped: Vec::new(),
        };
        let mut unreadable = None;
        for subject in folders(&root)? {
            let (sequences, problem) = tree.person(&subject)?;
            match problem {
                Some(problem) if sequences.is_empty() => {
                    tree.skipped.push(subject);
                    unreadable.get_or_insert(problem);
                }
                Some(problem) => return Err(problem),
                None => tree.sequences.extend(sequences),
            }
            if tree.sequences.len() > MAX_SEQUENCES {
                return Err(Error::input(
                    root,
                    format!("expected at most {MAX_SEQUENCES} sequences, found more"),
                ));
            }
        }
        if tree.sequences.is_empty() {
            return Err(unreadable.unwrap_or_else(|| {
                Error::input(
                    root,
                    "expected a tree of silhouettes, <person>/<take>/<view>/, found no such folders",
                )
            }));
        }
        Ok(tree)
    }

    /// Whether a folder looks like such a tree: it has folders in folders in folders.
    #[must_use]
    pub fn is_at(root: &Path) -> bool {
        let deepen = |paths: Vec<PathBuf>| -> Vec<PathBuf> {
            let inner = paths.iter().map(|path| {
                let names = folders(path).unwrap_or_default().into_iter();
                names.map(|name| path.join(name)).collect::<Vec<_>>()
            });
            inner.flatten().take(16).collect()
        };
        !deepen(deepen(deepen(vec![root.to_path_buf()]))).is_empty()
    }

    /// All sequences, by name.
    #[must_use]
    pub fn sequences(&self) -> &[TreeSequence] {
        &self.sequences
    }

    /// Folders beside the people's that hold something else, by name.
    #[must_use]
    pub fn skipped(&self) -> &[String] {
        &self.skipped
    }

    /// The folder of a sequence.
    ///
    /// # Panics
    /// If there is no such sequence.
    #[must_use]
    pub fn folder(&self, index: usize) -> PathBuf {
        let sequence = &self.sequences[index];
        self.root
            .join(&sequence.subject)
            .join(&sequence.take)
            .join(&sequence.view)
    }

    /// Reads a sequence and frames each figure as figures are framed that are drawn here. Pixels
    /// of 128 and more are the figure; frames without any are left out and counted.
    ///
    /// OpenGait normalises pictures once (height by cubic interpolation, the median column in the
    /// middle), stores them grey, 64x64, and cuts 10 columns off each side while it reads
    /// (`BaseSilCuttingTransform`): for that, bit for bit, see [`Self::stored`].
    ///
    /// # Errors
    /// If the framing needs a camera, a file is broken, or there are no or too many pictures.
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn silhouettes(&self, index: usize, size: Size, framing: Framing) -> Result<Silhouettes> {
        let fit = Fit::of(framing)?;
        let mut found = Silhouettes {
            pixels: Vec::new(),
            frames: 0,
            empty: 0,
            clipped_share: 0.0,
        };
        let mut clipped = 0.0;
        self.pictures(index, |_, picture| {
            match picture.frame(size, fit, &mut found.pixels) {
                Some(share) => {
                    found.frames += 1;
                    clipped += share;
                }
                None => found.empty += 1,
            }
            Ok(())
        })?;
        if found.frames > 0 {
            found.clipped_share = clipped / found.frames as f64;
        }
        Ok(found)
    }

    /// Reads a sequence as it is stored, grey and with frames that are empty, where its pictures
    /// have this size, or have it once `10 * (columns / 64)` columns are cut off each side, as
    /// OpenGait's `BaseSilCuttingTransform` does.
    ///
    /// # Errors
    /// If a picture has another size, a file is broken, or there are no or too many pictures.
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn stored(&self, index: usize, size: Size) -> Result<Silhouettes> {
        let mut found = Silhouettes {
            pixels: Vec::new(),
            frames: 0,
            empty: 0,
            clipped_share: 0.0,
        };
        self.pictures(index, |path, picture| {
            let rows = picture.pixels.len() / picture.columns;
            let cut = 10 * (picture.columns / 64);
            let kept = if picture.columns == size.columns() {
                0..picture.columns
            } else {
                cut..picture.columns - cut
            };
            if (rows, kept.len()) != (size.rows(), size.columns()) {
                return Err(Error::input(
                    path,
                    format!(
                        "expected pictures of {size} that are framed already (for 64x44 also 64x64, cut as OpenGait cuts), found {rows}x{}",
                        picture.columns
                    ),
                )
                .with_remedy(Remedy::FrameAnew));
            }
            for row in picture.pixels.chunks_exact(picture.columns) {
                found.pixels.extend_from_slice(&row[kept.clone()]);
            }
            found.frames += 1;
            Ok(())
        })?;
        Ok(found)
    }

    /// The sequences of a person, and what is wrong with the first view that is no angle.
    fn person(&self, subject: &str) -> Result<(Vec<TreeSequence>, Option<Error>)> {
        let (mut sequences, mut problem) = (Vec::new(), None);
        let person = self.root.join(subject);
        for take in folders(&person)? {
            for view in folders(&person.join(&take))? {
                match Angle::parse(&view) {
                    Ok(angle) => sequences.push(TreeSequence {
                        subject: subject.to_owned(),
                        take: take.clone(),
                        view,
                        azimuth_deg: angle.azimuth_deg,
                        elevation_deg: angle.elevation_deg,
                    }),
                    Err(text) => {
                        let path = person.join(&take).join(&view);
                        problem.get_or_insert_with(|| Error::input(path, text));
                    }
                }
            }
        }
        Ok((sequences, problem))
    }

    /// Shows each picture of a sequence, in order, with the file that it is from.
    fn pictures(
        &self,
        index: usize,
        mut show: impl FnMut(&Path, Picture<'_>) -> Result<()>,
    ) -> Result<()> {
        let folder = self.folder(index);
        let files = files(&folder)?;
        let has_extension = |path: &PathBuf, wanted: &str| {
            let extension = path.extension().unwrap_or_default();
            extension.eq_ignore_ascii_case(wanted)
        };
        let other = files
            .iter()
            .find(|path| !has_extension(path, "png") && !has_extension(path, "pkl"));
        if let Some(other) = other {
            return Err(Error::input(
                other,
                "expected frames as .png, or all of them in one .pkl, found another kind of file",
            ));
        }
        let pickles = files
            .iter()
            .filter(|path| has_extension(path, "pkl"))
            .count();
        match (files.as_slice(), pickles) {
            ([], _) => Err(Error::input(
                folder,
                "expected frames as .png, or all of them in one .pkl, found neither",
            )),
            ([pickle], 1) => unpickle(pickle, show),
            (_, 0) if files.len() > MAX_FRAMES => Err(Error::input(
                folder,
                format!(
                    "expected at most {MAX_FRAMES} frames, found {}",
                    files.len()
                ),
            )),
            (_, 0) => {
                let mut first = None;
                files.iter().try_for_each(|path| {
                    let (pixels, columns) = decode(path)?;
                    let size = (pixels.len() / columns, columns);
                    let expected = *first.get_or_insert(size);
                    if size != expected {
                        return Err(Error::input(
                            path,
                            format!(
                                "expected {}x{} pixels as the frames before, found {}x{}",
                                expected.0, expected.1, size.0, size.1
                            ),
                        ));
                    }
                    let pixels = &pixels;
                    show(path, Picture { pixels, columns })
                })
            }
            (_, pickles) => Err(Error::input(
                folder,
                format!(
                    "expected one .pkl and nothing else, found {pickles} and {} .png (several modalities are not supported)",
                    files.len() - pickles
                ),
            )),
        }
    }
}

/// Refuses a view's name that states no azimuth.
///
/// # Errors
/// With what was expected of it.
pub fn check_view_name(name: &str) -> Result<()> {
    Angle::parse(name).map(drop).map_err(Error::Usage)
}

/// Names of the folders in a folder, in order, without hidden ones.
fn folders(path: &Path) -> Result<Vec<String>> {
    let io = |error| Error::io(path, error);
    let mut names = Vec::new();
    for entry in fs::read_dir(path).map_err(io)? {
        let entry = entry.map_err(io)?;
        let name = entry.file_name().into_string().map_err(|name| {
            Error::input(path, format!("expected names in UTF-8, found {name:?}"))
        })?;
        if !name.starts_with('.') && entry.path().is_dir() {
            names.push(name);
        }
    }
    names.sort_unstable();
    Ok(names)
}

/// The files in a folder, by name, without hidden ones and without `gei.png`, which CASIA-B's
/// tools leave among the frames and OpenGait's pretreatment passes over.
fn files(path: &Path) -> Result<Vec<PathBuf>> {
    let io = |error| Error::io(path, error);
    let mut files = Vec::new();
    for entry in fs::read_dir(path).map_err(io)? {
        let entry = entry.map_err(io)?;
        let name = entry.file_name();
        let is_hidden = name.as_encoded_bytes().starts_with(b".")
            || name == "Thumbs.db"
            || name == "desktop.ini";
        if !is_hidden && name != "gei.png" {
            files.push(entry.path());
        }
    }
    files.sort_unstable();
    Ok(files)
}

/// A PNG's pixels as grey, and how many columns they are.
fn decode(path: &Path) -> Result<(Vec<u8>, usize)> {
    let file = fs::File::open(path).map_err(|error| Error::io(path, error))?;
    let mut limits = image::Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    limits.max_alloc = Some(MAX_BYTES);
    let mut reader = ImageReader::with_format(BufReader::new(file), ImageFormat::Png);
    reader.limits(limits);
    let picture = reader
        .decode()
        .map_err(|error| Error::input(path, format!("cannot be read as PNG: {error}")))?;
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

/// Shows the pictures of a pickled array `[frames][rows][columns]`.
fn unpickle(path: &Path, mut show: impl FnMut(&Path, Picture<'_>) -> Result<()>) -> Result<()> {
    let io = |error| Error::io(path, error);
    let length = fs::metadata(path).map_err(io)?.len();
    if length > MAX_BYTES {
        return Err(Error::input(
            path,
            format!("expected a pickle of at most {MAX_BYTES} bytes, found {length}"),
        ));
    }
    let bytes = fs::read(path).map_err(io)?;
    let array = pickle::read(&bytes)
        .map_err(|refused| Error::at(path, Place::Byte(refused.byte), refused.problem))?;
    let side = 1..=MAX_SIDE as usize;
    match *array.shape {
        [1..=MAX_FRAMES, rows, columns] if side.contains(&rows) && side.contains(&columns) => {
            let mut frames = array.bytes.chunks_exact(rows * columns);
            frames.try_for_each(|pixels| show(path, Picture { pixels, columns }))
        }
        _ => Err(Error::input(
            path,
            format!(
                "expected an array of 1 to {MAX_FRAMES} frames of at most {MAX_SIDE}x{MAX_SIDE}, found {:?}",
                array.shape
            ),
        )),
    }
}

#[cfg(test)]
mod tests;
