//! A tree of silhouettes: pictures of walkers in the folder layout of CASIA-B and OpenGait.
//!
//! `root/<person>/<take>/<view>/` holds one PNG or JPEG per frame, or one NumPy array of all frames
//! (`.npy`, or pickled as in github.com/ShiqiYu/OpenGait, docs/2.prepare_dataset.md) or pickled list
//! of them. A person is named like `001`, a take like `nm-01`, and a view by its azimuth (`090`), here optionally with its elevation (`090e15`).
//! An azimuth of 90 shows the walker's left in EdgeGait; other data may mean the right. Where views
//! are cameras or recordings (Gait3D, GREW, CCPG), their names state no angles.

mod files;
mod frame;
mod layout;
mod pickle;
mod view_name;

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::MANIFEST;
use super::manifest::read_manifest;
use super::pixel_check::PixelCheck;
use crate::draw::sweep::FramingMode;
use crate::error::{Error, Remedy, Result};
use edgegait_core::cycle::LowerBody;
use edgegait_core::silhouette::Size;
use files::FrameFiles;
pub(super) use files::{TEMPLATE, decode};
pub use frame::framed;
use frame::{GreyPicture, PictureFraming};
pub use layout::{Modality, TreeLayout};
pub(super) use pickle::pickled;
use view_name::NamedView;

/// The maximum number of sequences of a tree. OU-MVLP has 288,596.
const MAX_SEQUENCES: usize = 1 << 19;
/// The maximum number of frames in a sequence: more than five minutes at 30 frames/s.
const MAX_FRAMES: usize = 10_000;
/// The maximum number of rows or columns in a picture.
const MAX_SIDE: u32 = 4096;
/// The maximum number of bytes for decoding a picture, and of a pickle.
const MAX_BYTES: u64 = 1 << 27;
/// The range of all pictures of a sequence.
const ALL: Range<usize> = 0..MAX_FRAMES;

/// Sequences of silhouettes, listed but not read.
#[derive(Clone, Debug)]
pub struct Tree {
    root: PathBuf,
    modality: Option<Modality>,
    sequences: Vec<TreeSequence>,
    skipped: Vec<String>,
}

/// One take of a person from one view.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeSequence {
    /// The person's name.
    pub subject: String,
    /// The take's name, usually the condition and a number: `nm-01`.
    pub take: String,
    /// The view's name.
    pub view: String,
    /// The azimuth and elevation that the view's name states, degrees; none if views have other
    /// names.
    pub angles_deg: Option<(f64, f64)>,
}

/// The silhouettes of a sequence.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Silhouettes {
    /// The pixels `[frames][rows][columns]`; 0 or 255 if EdgeGait framed them.
    pub pixels: Vec<u8>,
    /// The number of silhouettes.
    pub frames: usize,
    /// The number of further frames that were left out because they were empty.
    pub empty: usize,
    /// The mean share of the figure that is cut off at the sides, 0..1; 0 without frames.
    pub clipped_share: f64,
}

impl Tree {
    /// Lists the sequences of a tree, sorted by person, take and view. Looks into folders of three
    /// levels and ignores files beside them. Reads no files, except the file names of the first
    /// sequence if views are not named by angles. If any person has views named by angles, people
    /// without such views are skipped, and [`Self::skipped`] names them.
    ///
    /// # Errors
    /// If a folder cannot be read, a person has both views named by angles and others,
    /// there is no sequence, or there are more than 524,288.
    pub fn open(root: impl AsRef<Path>, layout: &TreeLayout) -> Result<Self> {
        let root = root.as_ref().to_path_buf();
        let mut tree = Self {
            root: root.clone(),
            modality: layout.modality.clone(),
            sequences: Vec::new(),
            skipped: Vec::new(),
        };
        for subject in folders(&root)? {
            tree.person(&subject)?;
            if tree.sequences.len() > MAX_SEQUENCES {
                return Err(Error::input(
                    root,
                    format!("expected at most {MAX_SEQUENCES} sequences, found more"),
                ));
            }
        }
        if tree.sequences.is_empty() {
            return Err(Error::input(
                root,
                "expected a tree of silhouettes, <person>/<take>/<view>/, found no such folders",
            ));
        }
        let has_angle = |sequence: &TreeSequence| sequence.angles_deg.is_some();
        if layout.named_views || !tree.sequences.iter().any(has_angle) {
            tree.sequences
                .iter_mut()
                .for_each(|sequence| sequence.angles_deg = None);
            // Names without angles do not show whether this is a tree.
            FrameFiles::list(&tree.folder(0), tree.modality.as_ref())?;
            return Ok(tree);
        }
        tree.check_angles()?;
        Ok(tree)
    }

    /// Skips people without any view named by an angle.
    ///
    /// # Errors
    /// If a person has both views named by angles and others.
    fn check_angles(&mut self) -> Result<()> {
        let all = std::mem::take(&mut self.sequences);
        for views in all.chunk_by(|a, b| a.subject == b.subject) {
            let is_named = |view: &&TreeSequence| view.angles_deg.is_none();
            match views.iter().find(is_named) {
                None => self.sequences.extend_from_slice(views),
                Some(named) if views.iter().all(|view| view.angles_deg.is_none()) => {
                    self.skipped.push(named.subject.clone());
                }
                Some(TreeSequence {
                    subject,
                    take,
                    view,
                    ..
                }) => {
                    let path = self.root.join(subject).join(take).join(view);
                    return Err(Error::input(path, view_name::expected(view))
                        .with_remedy(Remedy::NamedViews));
                }
            }
        }
        Ok(())
    }

    /// Returns whether a folder looks like a tree: it has three levels of folders, of which the first 16 of
    /// each are looked at.
    #[must_use]
    pub fn is_at(root: &Path) -> bool {
        !Self::some_views(root).is_empty()
    }

    /// Returns folders three levels down, at most 16, without listing the whole tree.
    pub(in crate::dataset) fn some_views(root: &Path) -> Vec<PathBuf> {
        let deepen = |paths: Vec<PathBuf>| -> Vec<PathBuf> {
            let inner = paths.iter().map(|path| {
                let names = folders(path).unwrap_or_default().into_iter();
                names.map(|name| path.join(name)).collect::<Vec<_>>()
            });
            inner.flatten().take(16).collect()
        };
        deepen(deepen(deepen(vec![root.to_path_buf()])))
    }

    /// Returns all sequences, sorted by name.
    #[must_use]
    pub fn sequences(&self) -> &[TreeSequence] {
        &self.sequences
    }

    /// Returns the names of folders that hold something other than a person's sequences.
    #[must_use]
    pub fn skipped(&self) -> &[String] {
        &self.skipped
    }

    /// Returns the folder of a sequence.
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

    /// Reads a sequence and frames each figure like a synthetic figure. Pixels of 128 and more are
    /// the figure; frames without any are left out and counted.
    ///
    /// OpenGait normalises pictures once (height by cubic interpolation, the median column in the
    /// middle), stores them grey, 64x64, and cuts 10 columns off each side while it reads
    /// (`BaseSilCuttingTransform`). [`Self::stored`] reproduces that bit for bit.
    ///
    /// # Errors
    /// If the framing needs a camera, a file is broken, there are no or too many pictures, or they
    /// are grey or black on white.
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn silhouettes(
        &self,
        index: usize,
        size: Size,
        framing: FramingMode,
    ) -> Result<Silhouettes> {
        self.silhouettes_of(index, ALL, size, framing)
    }

    /// Checks that pictures can be brought into a framing.
    ///
    /// # Errors
    /// If the framing depends on the camera's position.
    pub fn require_framing(framing: FramingMode) -> Result<()> {
        PictureFraming::from_mode(framing).map(drop)
    }

    /// Reads and frames some pictures of a sequence, by their numbers from 0; see
    /// [`Self::silhouettes`].
    ///
    /// # Errors
    /// As [`Self::silhouettes`].
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn silhouettes_of(
        &self,
        index: usize,
        frames: Range<usize>,
        size: Size,
        framing: FramingMode,
    ) -> Result<Silhouettes> {
        let fit = PictureFraming::from_mode(framing)?;
        let mut found = Silhouettes::default();
        let mut clipped = 0.0;
        self.pictures(index, frames, Grey::IsNoMask, |_, picture| {
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

    /// Reads a sequence as it is stored: grey, and including empty frames. Its pictures must have
    /// this size, or have it after `10 * (columns / 64)` columns are cut off each side, as by
    /// OpenGait's `BaseSilCuttingTransform`.
    ///
    /// # Errors
    /// If a picture has another size, a file is broken, or there are no or too many pictures.
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn stored(&self, index: usize, size: Size) -> Result<Silhouettes> {
        self.stored_of(index, ALL, size)
    }

    /// Reads some pictures of a sequence as they are stored, by their numbers from 0; see
    /// [`Self::stored`].
    ///
    /// # Errors
    /// As [`Self::stored`].
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn stored_of(&self, index: usize, frames: Range<usize>, size: Size) -> Result<Silhouettes> {
        let mut found = Silhouettes::default();
        self.pictures(index, frames, Grey::IsMeant, |path, picture| {
            let rows = picture.pixels.len() / picture.columns;
            let kept = kept(rows, picture.columns, size)
                .ok_or_else(|| other_size(path, (rows, picture.columns), size))?;
            for row in picture.pixels.chunks_exact(picture.columns) {
                found.pixels.extend_from_slice(&row[kept.clone()]);
            }
            found.frames += 1;
            Ok(())
        })?;
        Ok(found)
    }

    /// Calls `show` with each stored picture of a sequence, grey with rows from the top, and its
    /// number of columns. [`framed`] frames such a picture.
    ///
    /// # Errors
    /// If a file is broken, there are no or too many pictures, their sizes differ, they are grey or
    /// black on white, or `show` fails.
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn show(
        &self,
        index: usize,
        mut show: impl FnMut(&[u8], usize) -> Result<()>,
    ) -> Result<()> {
        self.pictures(index, ALL, Grey::IsNoMask, |_, picture| {
            show(picture.pixels, picture.columns)
        })
    }

    /// Returns the number of frames of each gait cycle, if the manifest states that EdgeGait made
    /// the tree from whole cycles.
    #[must_use]
    pub fn frames_per_cycle(&self) -> Option<usize> {
        let manifest = read_manifest(&self.root.join(MANIFEST)).ok()?;
        let settings = &manifest.header.settings;
        let is_even = manifest.format.is_tree() && !settings.contains_key("fps");
        let frames = settings.get("frames_per_cycle").filter(|_| is_even)?;
        usize::try_from(frames.as_u64()?)
            .ok()
            .filter(|frames| *frames > 0)
    }

    /// Returns the number of pictures of a sequence; none if it is not known before reading them.
    ///
    /// # Errors
    /// If a file is broken, or there are no or too many pictures.
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn frames(&self, index: usize) -> Result<Option<usize>> {
        FrameFiles::list(&self.folder(index), self.modality.as_ref())?.count()
    }

    /// Reads a sequence and measures the legs in each of its unframed pictures; `None`
    /// where nobody is visible. [`crate::dataset::gait_cycles::CycleFinder`] finds gait cycles in them.
    ///
    /// # Errors
    /// If a file is broken, or there are no or too many pictures.
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn lower_bodies(&self, index: usize) -> Result<Vec<Option<LowerBody>>> {
        let mut found = Vec::new();
        self.pictures(index, ALL, Grey::IsNoMask, |_, picture| {
            found.push(LowerBody::of_pixels(picture.pixels, picture.columns));
            Ok(())
        })?;
        Ok(found)
    }

    /// Adds the sequences of a person.
    fn person(&mut self, subject: &str) -> Result<()> {
        let person = self.root.join(subject);
        for take in folders(&person)? {
            for view in folders(&person.join(&take))? {
                let angle = NamedView::parse(&view);
                self.sequences.push(TreeSequence {
                    subject: subject.to_owned(),
                    take: take.clone(),
                    angles_deg: angle.map(|angle| (angle.azimuth_deg, angle.elevation_deg)),
                    view,
                });
            }
        }
        Ok(())
    }

    /// Checks from the beginnings of files that all pictures of a sequence have one size, and that
    /// [`Self::stored`] can read them in each of the sizes `stored`. Much faster than reading them.
    ///
    /// # Errors
    /// If sizes differ or do not fit; the message names the file.
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn check_size(&self, index: usize, stored: &[Size]) -> Result<()> {
        let folder = self.folder(index);
        let found = FrameFiles::list(&folder, self.modality.as_ref())?.size()?;
        let Some((rows, columns)) = found else {
            return Ok(());
        };
        let other = stored
            .iter()
            .find(|size| kept(rows, columns, **size).is_none());
        other.map_or(Ok(()), |&size| {
            Err(other_size(&folder, (rows, columns), size))
        })
    }

    /// Returns what is doubtful about the order of a sequence's frames, or about their being evenly
    /// spaced in time: two names with the same number, or gaps in the numbers.
    ///
    /// # Errors
    /// If the folder cannot be read, or holds something else.
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn doubts(&self, index: usize) -> Result<Option<String>> {
        let files = FrameFiles::list(&self.folder(index), self.modality.as_ref())?;
        Ok(files.doubts())
    }

    /// Calls `show` with these pictures of a sequence, in order, and the file of each.
    ///
    /// # Errors
    /// If the pictures show no white figures on black, or, with [`Grey::IsNoMask`], are grey.
    fn pictures(
        &self,
        index: usize,
        frames: Range<usize>,
        grey: Grey,
        mut show: impl FnMut(&Path, GreyPicture<'_>) -> Result<()>,
    ) -> Result<()> {
        let folder = self.folder(index);
        let mut check = PixelCheck::default();
        FrameFiles::list(&folder, self.modality.as_ref())?.show(frames, |path, picture| {
            check.add(picture.pixels, picture.columns);
            show(path, picture)
        })?;
        let is_grey = || match grey {
            Grey::IsNoMask => check.grey(),
            Grey::IsMeant => None,
        };
        match check.inverted().or_else(is_grey) {
            Some(problem) => Err(Error::input(folder, problem)),
            None => Ok(()),
        }
    }
}

/// Whether grey areas are part of stored pictures.
#[derive(Clone, Copy)]
enum Grey {
    IsNoMask,
    IsMeant,
}

/// Returns the columns that are kept of stored pictures, if these have this size or are cut to it.
fn kept(rows: usize, columns: usize, size: Size) -> Option<Range<usize>> {
    let cut = 10 * (columns / 64);
    let kept = if columns == size.columns() {
        0..columns
    } else {
        cut..columns - cut
    };
    ((rows, kept.len()) == (size.rows(), size.columns())).then_some(kept)
}

fn other_size(path: &Path, (rows, columns): (usize, usize), size: Size) -> Error {
    Error::input(
        path,
        format!(
            "expected pictures of {size} that are framed already (for 64x44 also 64x64, cut as OpenGait does), found {rows}x{columns}"
        ),
    )
    .with_remedy(Remedy::FrameAnew)
}

/// Checks that a view's name states an azimuth.
///
/// # Errors
/// If it does not; the message shows what is expected.
pub fn check_view_name(name: &str) -> Result<()> {
    NamedView::parse(name)
        .map(drop)
        .ok_or_else(|| Error::Usage(view_name::expected(name)))
}

/// Returns the sorted names of the folders in a folder, without hidden ones.
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

#[cfg(test)]
mod tests;
