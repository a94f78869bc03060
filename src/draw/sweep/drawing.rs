//! Painters: they draw the posed frames of one job and make the requested outputs.

use super::columns::Columns;
use super::painted_view::PaintedView;
use super::posed_frames::{FramedView, PosedFrames};
use super::views::ListedViews;
use super::{Raster, Settings, Swept, Wanted};
use crate::draw::confounders::image::FineRenderer;
use crate::draw::registers::registers;
use crate::draw::template::{Builder, Template};
use crate::error::Result;
use edgegait_core::raster::{Drawing, Placement, Rasterizer, Renderer, Simd};
use edgegait_core::silhouette::{AnySilhouette, Silhouette, Size};

/// Views whose templates are made together: few enough to keep their sums in a processor's cache,
/// and enough to amortise the loading of a figure.
const VIEWS_AT_ONCE: usize = 16;

/// A painter for each kind of [`Raster`].
pub(super) enum Painter {
    Each(Box<Brush>),
    Columns(Box<Columns>),
}

impl Painter {
    /// # Errors
    /// As [`registers`].
    pub(super) fn new(settings: &Settings) -> Result<Self> {
        let (size, simd) = (settings.size, registers()?);
        Ok(match settings.rasterizer {
            Raster::Each(rasterizer) => Self::Each(Box::new(Brush::new(rasterizer, size, simd))),
            Raster::Columns => Self::Columns(Box::new(Columns::new(size, simd))),
        })
    }

    /// Makes the requested outputs of the posed frames. Equal views are drawn once.
    pub(super) fn sweep(
        &mut self,
        posed: &mut PosedFrames<'_>,
        views: &ListedViews<'_>,
        wanted: &Wanted,
    ) -> Result<Swept> {
        let mut painted = match self {
            Self::Each(brush) => brush.paint(posed, views, wanted)?,
            Self::Columns(columns) => columns.paint(posed, views)?,
        };
        let firsts = views.firsts();
        let mut swept = Swept::default();
        for (at, &first) in firsts.iter().enumerate() {
            // The last of equal views takes the outputs; the others get copies.
            let is_last = firsts[at + 1..].iter().all(|&other| other != first);
            let view = if is_last {
                painted[first].take()
            } else {
                painted[first].clone()
            };
            let view = view.unwrap_or_default();
            swept.clipped += view.clipped;
            swept.empty += view.empty;
            swept.templates.extend(view.templates);
            swept.keypoints.push(view.keypoints);
        }
        if wanted.joints {
            swept.joints = posed.joints();
        }
        swept.frames = u32::try_from(posed.len()).unwrap_or(u32::MAX);
        Ok(swept)
    }

    /// Draws one frame from one view.
    pub(super) fn frame(
        &mut self,
        posed: &PosedFrames<'_>,
        frame: usize,
        view: FramedView<'_>,
    ) -> Result<AnySilhouette> {
        match self {
            Self::Each(brush) => {
                let drawn = brush.pen.draw(posed, frame, &view)?;
                Ok(drawn
                    .frame
                    .map_or_else(|| blank(posed.size()), |frame| *frame))
            }
            Self::Columns(columns) => columns.frame(posed, frame, view),
        }
    }
}

/// The painter that draws frames one by one.
pub(super) struct Brush {
    pen: Pen,
    /// Builders of the requested templates for each view of a batch.
    builders: Vec<Vec<Builder>>,
}

impl Brush {
    fn new(rasterizer: Rasterizer, size: Size, simd: Simd) -> Self {
        Self {
            pen: Pen::new(rasterizer, size, simd),
            builders: Vec::new(),
        }
    }

    /// Makes the requested outputs of the views that are drawn, and `None` for the others.
    fn paint(
        &mut self,
        posed: &mut PosedFrames<'_>,
        views: &ListedViews<'_>,
        wanted: &Wanted,
    ) -> Result<Vec<Option<PaintedView>>> {
        let painted = self.paint_all(posed, views, wanted);
        if painted.is_err() {
            // They hold parts of the frames that could not be drawn.
            self.builders.clear();
        }
        painted
    }

    fn paint_all(
        &mut self,
        posed: &mut PosedFrames<'_>,
        views: &ListedViews<'_>,
        wanted: &Wanted,
    ) -> Result<Vec<Option<PaintedView>>> {
        let Self { pen, builders } = self;
        let (list, numbers) = (views.list(), views.drawn());
        let mut painted = vec![None; list.len()];
        let frames = u32::try_from(posed.len()).unwrap_or(u32::MAX);
        let is_fit =
            |builders: &Vec<Builder>| builders.iter().all(|builder| builder.frames() == frames);
        if !builders.iter().all(is_fit) {
            builders.clear();
        }
        while builders.len() < numbers.len().min(VIEWS_AT_ONCE) {
            let of = |&template: &Template| Builder::new(template, posed.size(), frames);
            builders.push(wanted.templates.iter().map(of).collect());
        }
        for batch in numbers.chunks(VIEWS_AT_ONCE) {
            let mut outputs = vec![PaintedView::default(); batch.len()];
            let framed_views: Vec<FramedView<'_>> = batch
                .iter()
                .map(|&at| posed.framed_view(&list[at]))
                .collect::<Result<_>>()?;
            for frame in 0..posed.len() {
                pen.draw_views(posed, frame, &framed_views, |number, drawn| {
                    let output = &mut outputs[number];
                    output.clipped += drawn.clipped;
                    output.empty += u64::from(drawn.frame.is_none());
                    for builder in &mut builders[number] {
                        match drawn.frame {
                            Some(frame) => builder.add(frame)?,
                            None if wanted.blanks
                                && builder.template() == Template::Silhouettes =>
                            {
                                builder.add(&blank(posed.size()))?;
                            }
                            None => {}
                        }
                    }
                    if wanted.joints {
                        let view = &framed_views[number];
                        let keypoints = posed.keypoints(frame, view, drawn.placement)?;
                        output.keypoints.extend(keypoints);
                    }
                    Ok(())
                })?;
            }
            for (&at, (builders, mut output)) in batch.iter().zip(builders.iter_mut().zip(outputs))
            {
                output.templates = builders.iter_mut().map(Builder::finish).collect();
                painted[at] = Some(output);
            }
        }
        Ok(painted)
    }
}

/// Draws single frames.
struct Pen {
    renderer: Renderer,
    /// The renderer of frames under confounders of the image, created on demand.
    fine: Option<FineRenderer>,
    framed: AnySilhouette,
}

impl Pen {
    fn new(rasterizer: Rasterizer, size: Size, simd: Simd) -> Self {
        Self {
            renderer: Renderer::with_simd(rasterizer, size, simd),
            fine: None,
            framed: AnySilhouette::Binary(Silhouette::empty(size)),
        }
    }

    /// Draws one of the posed frames from several views, and calls `take` with the number of each
    /// view and the result of [`Self::draw`].
    fn draw_views(
        &mut self,
        posed: &PosedFrames<'_>,
        frame: usize,
        views: &[FramedView<'_>],
        mut take: impl FnMut(usize, DrawnFrame<'_>) -> Result<()>,
    ) -> Result<()> {
        if !posed.acts_on_images() {
            return posed.draw_views(frame, views, &mut self.renderer, |number, drawing| {
                take(number, DrawnFrame::from_drawing(drawing))
            });
        }
        for (number, view) in views.iter().enumerate() {
            take(number, self.draw(posed, frame, view)?)?;
        }
        Ok(())
    }

    /// Draws one of the posed frames.
    fn draw(
        &mut self,
        posed: &PosedFrames<'_>,
        frame: usize,
        view: &FramedView<'_>,
    ) -> Result<DrawnFrame<'_>> {
        if !posed.acts_on_images() {
            return Ok(DrawnFrame::from_drawing(posed.draw(
                frame,
                view,
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
        let Some(framed) = posed.segmented(frame, view, fine)? else {
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
    fn from_drawing(drawing: Drawing<'f>) -> Self {
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
