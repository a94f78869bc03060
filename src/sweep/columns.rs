//! Sweeps by columns: all elevations of an azimuth in one pass.

use super::column_images::SweepColumns;
use super::painted_view::PaintedView;
use super::posed_frames::{FramedView, PosedFrames};
use super::views::{View, by_azimuth};
use crate::error::{ChoiceError, Error, Result};
use edgegait_core::raster::columns::{self, Azimuth, ElevationImages};
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::{AnySilhouette, Size};
use edgegait_core::template::GeiTally;

/// The renderer by columns with its sums of frames, 310 kB.
pub(super) struct Columns {
    renderer: SweepColumns,
    tally: GeiTally,
}

impl Columns {
    pub(super) fn new(size: Size) -> Self {
        Self {
            renderer: SweepColumns {
                columns: columns::ColumnRenderer::new(),
                measure: Renderer::new(Rasterizer::Rows, size),
            },
            tally: GeiTally::new(size),
        }
    }

    /// Returns the GEIs of the numbered views, and `None` for the others.
    pub(super) fn see(
        &mut self,
        film: &mut PosedFrames<'_>,
        views: &[View],
        numbers: &[usize],
    ) -> Result<Vec<Option<PaintedView>>> {
        let mut seen = vec![None; views.len()];
        for group in by_azimuth(views, numbers)? {
            let sights: Vec<FramedView<'_>> = group
                .views
                .iter()
                .map(|&at| film.sight(&views[at]))
                .collect::<Result<_>>()?;
            let mut clipped = vec![0.0; sights.len()];
            self.tally.clear();
            for frame in 0..film.len() {
                let images = self.tally.next_frame().ok_or_else(too_many)?;
                let together = (sights.as_slice(), &group.azimuth);
                let shares = film.draw_elevations(frame, together, &mut self.renderer, images)?;
                for (sum, share) in clipped.iter_mut().zip(shares) {
                    *sum += share;
                }
            }
            for (elevation, (&at, clipped)) in group.views.iter().zip(clipped).enumerate() {
                seen[at] = Some(PaintedView {
                    templates: vec![self.tally.gei(elevation).pixels().to_vec()],
                    clipped,
                    ..PaintedView::default()
                });
            }
        }
        Ok(seen)
    }

    /// Draws one frame from one view.
    pub(super) fn frame(
        &mut self,
        film: &PosedFrames<'_>,
        frame: usize,
        sight: FramedView<'_>,
    ) -> Result<AnySilhouette> {
        let azimuth = Azimuth::new(&[sight.viewpoint()])?;
        let mut images = ElevationImages::empty(self.renderer.measure.size());
        film.draw_elevations(frame, (&[sight], &azimuth), &mut self.renderer, &mut images)?;
        Ok(AnySilhouette::Binary(images.silhouette(0)))
    }
}

fn too_many() -> Error {
    ChoiceError::ColumnsFrames(GeiTally::MAX_FRAMES).into()
}
