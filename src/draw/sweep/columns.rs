//! Sweeps by columns: all elevations of an azimuth in one pass.

use super::column_images::SweepColumns;
use super::painted_view::PaintedView;
use super::posed_frames::{FramedView, PosedFrames};
use super::settings::Raster;
use super::views::{ListedViews, by_azimuth};
use crate::error::{Error, Result, SettingError};
use edgegait_core::raster::columns::{self, Azimuth, ElevationImages};
use edgegait_core::raster::{Rasterizer, Renderer, Simd};
use edgegait_core::silhouette::{AnySilhouette, Size};
use edgegait_core::template::GeiTally;

/// The renderer by columns with its sums of frames, 310 kB.
pub(super) struct Columns {
    renderer: SweepColumns,
    tally: GeiTally,
}

impl Columns {
    pub(super) fn new(size: Size, simd: Simd) -> Self {
        Self {
            renderer: SweepColumns {
                columns: columns::ColumnRenderer::with_simd(simd),
                measure: Renderer::with_simd(Rasterizer::Rows, size, simd),
            },
            tally: GeiTally::new(size),
        }
    }

    /// Returns the GEIs of the views that are drawn, and `None` for the others.
    pub(super) fn paint(
        &mut self,
        posed: &mut PosedFrames<'_>,
        views: &ListedViews<'_>,
    ) -> Result<Vec<Option<PaintedView>>> {
        let list = views.list();
        let mut painted = vec![None; list.len()];
        for group in by_azimuth(list, &views.drawn())? {
            let framed_views: Vec<FramedView<'_>> = group
                .views
                .iter()
                .map(|&at| posed.framed_view(&list[at]))
                .collect::<Result<_>>()?;
            let mut clipped = vec![0.0; framed_views.len()];
            self.tally.clear();
            for frame in 0..posed.len() {
                let images = self.tally.next_frame().ok_or_else(too_many)?;
                let azimuth = &group.azimuth;
                let renderer = &mut self.renderer;
                let shares =
                    posed.draw_elevations(frame, &framed_views, azimuth, renderer, images)?;
                for (sum, share) in clipped.iter_mut().zip(shares) {
                    *sum += share;
                }
            }
            for (elevation, (&at, clipped)) in group.views.iter().zip(clipped).enumerate() {
                painted[at] = Some(PaintedView {
                    templates: vec![self.tally.gei(elevation).pixels().to_vec()],
                    clipped,
                    ..PaintedView::default()
                });
            }
        }
        Ok(painted)
    }

    /// Draws one frame from one view.
    pub(super) fn frame(
        &mut self,
        posed: &PosedFrames<'_>,
        frame: usize,
        view: FramedView<'_>,
    ) -> Result<AnySilhouette> {
        let azimuth = Azimuth::new(&[view.viewpoint()])?;
        let mut images = ElevationImages::empty(self.renderer.measure.size());
        let renderer = &mut self.renderer;
        posed.draw_elevations(frame, &[view], &azimuth, renderer, &mut images)?;
        Ok(AnySilhouette::Binary(images.silhouette(0)))
    }
}

fn too_many() -> Error {
    SettingError::ColumnsFrames(GeiTally::MAX_FRAMES).refuses("raster", Raster::Columns.name())
}
