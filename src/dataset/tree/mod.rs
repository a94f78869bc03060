//! A tree of silhouettes: pictures of walkers as CASIA-B has them and OpenGait reads them.
//!
//! `root/<person>/<take>/<view>/` holds one PNG a frame, or one pickled NumPy array of all frames
//! (github.com/ShiqiYu/OpenGait, docs/2.prepare_dataset.md). A person is called `001`, a take
//! `nm-01`, a view by its azimuth, `090`, and here also by its elevation, `090e15`. Whether an
//! azimuth of 90 shows the walker's left (as ours does) or right, is the data's to say. Where views
//! are cameras or recordings (Gait3D, GREW, CCPG), their names say nothing of angles.

mod files;
mod frame;
mod layout;
mod pickle;
mod view_name;

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::MANIFEST;
use super::reader::read_manifest;
use crate::error::{Error, Remedy, Result};
use crate::sweep::FramingMode;
use edgegait_core::cycle::LowerBody;
use edgegait_core::silhouette::Size;
use files::FrameFiles;
pub use frame::framed;
use frame::{GreyPicture, PictureFraming};
pub use layout::{Modality, TreeLayout};
pub(super) use pickle::pickled;
use view_name::NamedView;

/// Most sequences of a tree: OU-MVLP has 288,596.
const MAX_SEQUENCES: usize = 1 << 19;
/// Most frames of a sequence: more than five minutes at 30 a second.
const MAX_FRAMES: usize = 10_000;
/// Most rows or columns of a picture.
const MAX_SIDE: u32 = 4096;
/// Most bytes that a picture takes while it is decoded, and most bytes of a pickle.
const MAX_BYTES: u64 = 1 << 27;
/// All pictures of a sequence.
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
    /// The take's name, as a rule how the person walks and a number: `nm-01`.
    pub take: String,
    /// The view's name.
    pub view: String,
    /// Azimuth and elevation that the view's name states, degrees; none if views are named
    /// otherwise.
    pub angles_deg: Option<(f64, f64)>,
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
    /// into folders of three levels and into no file but those of the first sequence where views are
    /// not named by angles; files beside those folders are passed over. If any person has views that
    /// are named by angles, so have all: others are passed over, and [`Self::skipped`] names them.
    ///
    /// # Errors
    /// If a folder cannot be read, a person has views named by angles and others that are not,
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
                .for_each(|one| one.angles_deg = None);
            // The names say nothing of whether this is a tree at all.
            FrameFiles::of(&tree.folder(0), tree.modality.as_ref())?;
            return Ok(tree);
        }
        tree.check_angles()?;
        Ok(tree)
    }

    /// Passes over people none of whose views are named by an angle.
    ///
    /// # Errors
    /// For a view that is not, of a person who has others that are.
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
    pub fn silhouettes(
        &self,
        index: usize,
        size: Size,
        framing: FramingMode,
    ) -> Result<Silhouettes> {
        self.silhouettes_of((index, ALL), size, framing)
    }

    /// Refuses a framing that pictures of figures cannot be brought into.
    ///
    /// # Errors
    /// For what follows from where a camera stood.
    pub fn require_framing(framing: FramingMode) -> Result<()> {
        PictureFraming::of(framing).map(drop)
    }

    /// The same of a part of the pictures, by their numbers from 0.
    ///
    /// # Errors
    /// As [`Self::silhouettes`].
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn silhouettes_of(
        &self,
        (index, frames): (usize, Range<usize>),
        size: Size,
        framing: FramingMode,
    ) -> Result<Silhouettes> {
        let fit = PictureFraming::of(framing)?;
        let mut found = Silhouettes {
            pixels: Vec::new(),
            frames: 0,
            empty: 0,
            clipped_share: 0.0,
        };
        let mut clipped = 0.0;
        self.pictures(index, frames, |_, picture| {
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
        self.stored_of((index, ALL), size)
    }

    /// The same of a part of the pictures, by their numbers from 0.
    ///
    /// # Errors
    /// As [`Self::stored`].
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn stored_of(
        &self,
        (index, frames): (usize, Range<usize>),
        size: Size,
    ) -> Result<Silhouettes> {
        let mut found = Silhouettes {
            pixels: Vec::new(),
            frames: 0,
            empty: 0,
            clipped_share: 0.0,
        };
        self.pictures(index, frames, |path, picture| {
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

    /// Shows each picture of a sequence as it is stored: grey, rows from the top, and how many columns
    /// it has. [`framed`] frames it.
    ///
    /// # Errors
    /// If a file is broken, there are no or too many pictures, or their sizes differ, and those of
    /// `show`.
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn show(
        &self,
        index: usize,
        mut show: impl FnMut(&[u8], usize) -> Result<()>,
    ) -> Result<()> {
        self.pictures(index, ALL, |_, picture| {
            show(picture.pixels, picture.columns)
        })
    }

    /// Frames of each gait cycle, if the tree was made here of whole cycles, as its manifest says.
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

    /// How many pictures a sequence has; none where that is not known before they are read.
    ///
    /// # Errors
    /// If a file is broken, or there are no or too many pictures.
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn frames(&self, index: usize) -> Result<Option<usize>> {
        FrameFiles::of(&self.folder(index), self.modality.as_ref())?.count()
    }

    /// Reads a sequence and measures the legs in each of its pictures as they are, unframed; `None`
    /// where nobody is. [`crate::gait_cycles::CycleFinder`] finds gait cycles in them.
    ///
    /// # Errors
    /// If a file is broken, or there are no or too many pictures.
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn lower_bodies(&self, index: usize) -> Result<Vec<Option<LowerBody>>> {
        let mut found = Vec::new();
        self.pictures(index, ALL, |_, picture| {
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

    /// Checks, by the beginnings of files, that a sequence's pictures have one size, and that it is, or
    /// is cut to, each of those that they are to be taken for as they are ([`Self::stored`]). Cheap
    /// beside reading them.
    ///
    /// # Errors
    /// Naming the file.
    ///
    /// # Panics
    /// If there is no such sequence.
    pub fn check_size(&self, index: usize, stored: &[Size]) -> Result<()> {
        let folder = self.folder(index);
        let found = FrameFiles::of(&folder, self.modality.as_ref())?.size()?;
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

    /// Shows these pictures of a sequence, in order, with the file that each is from.
    fn pictures(
        &self,
        index: usize,
        frames: Range<usize>,
        show: impl FnMut(&Path, GreyPicture<'_>) -> Result<()>,
    ) -> Result<()> {
        FrameFiles::of(&self.folder(index), self.modality.as_ref())?.show(frames, show)
    }
}

/// The columns that are kept of stored pictures, if these have this size or will have it.
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
            "expected pictures of {size} that are framed already (for 64x44 also 64x64, cut as OpenGait cuts), found {rows}x{columns}"
        ),
    )
    .with_remedy(Remedy::FrameAnew)
}

/// Refuses a view's name that states no azimuth.
///
/// # Errors
/// With what was expected of it.
pub fn check_view_name(name: &str) -> Result<()> {
    NamedView::parse(name)
        .map(drop)
        .ok_or_else(|| Error::Usage(view_name::expected(name)))
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

#[cfg(test)]
mod tests;
