//! Painters: they draw the posed frames of one job and make the requested outputs.

use super::columns::Columns;
use super::painted_view::PaintedView;
use super::posed_frames::{FramedView, PosedFrames};
use super::{Raster, Settings, Swept, View, Wanted};
use crate::confounders::image::FineRenderer;
use crate::error::Result;
use crate::template::{Builder, Template};
use edgegait_core::raster::{Drawing, Placement, Rasterizer, Renderer};
use edgegait_core::silhouette::{AnySilhouette, Silhouette, Size};

/// Views whose templates are made together: few enough to keep their sums in a processor's cache,
/// and enough to amortise the loading of a figure.
const VIEWS_AT_ONCE: usize = 16;

/// A painter for each kind of [`Raster`].
pub(super) enum Painter {
    Each(Box<Brush>, Vec<Vec<Builder>>),
    Columns(Box<Columns>),
}

impl Painter {
    pub(super) fn new(settings: &Settings) -> Self {
        match settings.rasterizer {
            Raster::Each(rasterizer) => {
                Self::Each(Box::new(Brush::new(rasterizer, settings.size)), Vec::new())
            }
            Raster::Columns => Self::Columns(Box::new(Columns::new(settings.size))),
        }
    }

    /// Makes the requested outputs of the posed frames. Equal views are drawn once.
    pub(super) fn sweep(
        &mut self,
        film: &mut PosedFrames<'_>,
        (views, firsts): (&[View], &[usize]),
        wanted: &Wanted,
    ) -> Result<Swept> {
        let drawn: Vec<usize> = (0..views.len()).filter(|&at| firsts[at] == at).collect();
        let mut seen = match self {
            Self::Each(brush, builders) => {
                let seen = see(film, (views, &drawn), wanted, (brush, builders));
                if seen.is_err() {
                    // They hold parts of the frames that could not be drawn.
                    builders.clear();
                }
                seen?
            }
            Self::Columns(columns) => columns.see(film, views, &drawn)?,
        };
        let mut swept = Swept::default();
        for (at, &first) in firsts.iter().enumerate() {
            // The last of equal views takes the outputs; the others get copies.
            let is_last = firsts[at + 1..].iter().all(|&other| other != first);
            let found = if is_last {
                seen[first].take()
            } else {
                seen[first].clone()
            };
            let found = found.unwrap_or_default();
            swept.clipped += found.clipped;
            swept.empty += found.empty;
            swept.templates.extend(found.templates);
            swept.keypoints.push(found.keypoints);
        }
        if wanted.joints {
            swept.joints = film.joints();
        }
        swept.frames = u32::try_from(film.len()).unwrap_or(u32::MAX);
        Ok(swept)
    }

    /// Draws one frame from one view.
    pub(super) fn frame(
        &mut self,
        film: &PosedFrames<'_>,
        frame: usize,
        sight: FramedView<'_>,
    ) -> Result<AnySilhouette> {
        match self {
            Self::Each(brush, _) => {
                let drawn = brush.draw(film, frame, &sight)?;
                Ok(drawn
                    .frame
                    .map_or_else(|| blank(film.size()), |frame| *frame))
            }
            Self::Columns(columns) => columns.frame(film, frame, sight),
        }
    }
}

/// The painter that draws frames one by one.
pub(super) struct Brush {
    renderer: Renderer,
    /// The renderer of frames under confounders of the image, created on demand.
    fine: Option<FineRenderer>,
    framed: AnySilhouette,
}

impl Brush {
    fn new(rasterizer: Rasterizer, size: Size) -> Self {
        Self {
            renderer: Renderer::new(rasterizer, size),
            fine: None,
            framed: AnySilhouette::Binary(Silhouette::empty(size)),
        }
    }

    /// Draws one of the posed frames from several views, and calls `take` with the number of each
    /// view and the result of [`Self::draw`].
    fn draw_views(
        &mut self,
        film: &PosedFrames<'_>,
        frame: usize,
        sights: &[FramedView<'_>],
        mut take: impl FnMut(usize, DrawnFrame<'_>) -> Result<()>,
    ) -> Result<()> {
        if !film.acts_on_images() {
            return film.draw_views(frame, sights, &mut self.renderer, |number, drawing| {
                take(number, DrawnFrame::of(drawing))
            });
        }
        for (number, sight) in sights.iter().enumerate() {
            take(number, self.draw(film, frame, sight)?)?;
        }
        Ok(())
    }

    /// Draws one of the posed frames.
    fn draw(
        &mut self,
        film: &PosedFrames<'_>,
        frame: usize,
        sight: &FramedView<'_>,
    ) -> Result<DrawnFrame<'_>> {
        if !film.acts_on_images() {
            return Ok(DrawnFrame::of(film.draw(
                frame,
                sight,
                &mut self.renderer,
            )?));
        }
        let fine = match &mut self.fine {
            Some(fine) => fine,
            none => none.insert(FineRenderer::new(
                self.renderer.rasterizer(),
                self.renderer.size(),
            )?),
        };
        let Some(framed) = film.segmented(frame, sight, fine)? else {
            return Ok(DrawnFrame {
                frame: None,
                clipped: 0.0,
                placement: None,
            });
        };
        self.framed = AnySilhouette::Binary(framed.silhouette);
        Ok(DrawnFrame {
            frame: Some(&self.framed),
            clipped: f64::from(framed.clipped_share),
            placement: Some(framed.placement),
        })
    }
}

/// A frame that was drawn from a view.
struct DrawnFrame<'f> {
    /// The frame, or `None` if nothing is left of the figure.
    frame: Option<&'f AnySilhouette>,
    /// The share of the figure outside of the image.
    clipped: f64,
    /// The map from image points to pixels, or `None` if nothing is left of the figure.
    placement: Option<Placement>,
}

impl<'f> DrawnFrame<'f> {
    fn of(drawing: Drawing<'f>) -> Self {
        Self {
            frame: Some(drawing.frame),
            clipped: f64::from(drawing.clipped_share),
            placement: Some(drawing.placement),
        }
    }
}

fn blank(size: Size) -> AnySilhouette {
    AnySilhouette::Binary(Silhouette::empty(size))
}

/// Makes the requested outputs of the numbered views, and returns `None` for the others.
fn see(
    film: &mut PosedFrames<'_>,
    (views, numbers): (&[View], &[usize]),
    wanted: &Wanted,
    (brush, builders): (&mut Brush, &mut Vec<Vec<Builder>>),
) -> Result<Vec<Option<PaintedView>>> {
    let mut seen = vec![None; views.len()];
    let frames = u32::try_from(film.len()).unwrap_or(u32::MAX);
    let is_fit = |builders: &Vec<Builder>| builders.iter().all(|one| one.frames() == frames);
    if !builders.iter().all(is_fit) {
        builders.clear();
    }
    while builders.len() < numbers.len().min(VIEWS_AT_ONCE) {
        let of = |&template: &Template| Builder::new(template, film.size(), frames);
        builders.push(wanted.templates.iter().map(of).collect());
    }
    for batch in numbers.chunks(VIEWS_AT_ONCE) {
        let mut all = vec![PaintedView::default(); batch.len()];
        let sights: Vec<FramedView<'_>> = batch
            .iter()
            .map(|&at| film.sight(&views[at]))
            .collect::<Result<_>>()?;
        for frame in 0..film.len() {
            brush.draw_views(film, frame, &sights, |number, drawn| {
                let seen = &mut all[number];
                seen.clipped += drawn.clipped;
                seen.empty += u64::from(drawn.frame.is_none());
                for builder in &mut builders[number] {
                    match drawn.frame {
                        Some(frame) => builder.add(frame)?,
                        None if wanted.blanks && builder.template() == Template::Silhouettes => {
                            builder.add(&blank(film.size()))?;
                        }
                        None => {}
                    }
                }
                if wanted.joints {
                    let keypoints = film.keypoints(frame, &sights[number], drawn.placement)?;
                    seen.keypoints.extend(keypoints);
                }
                Ok(())
            })?;
        }
        for (&at, (builders, mut one)) in batch.iter().zip(builders.iter_mut().zip(all)) {
            one.templates = builders.iter_mut().map(Builder::finish).collect();
            seen[at] = Some(one);
        }
    }
    Ok(seen)
}
