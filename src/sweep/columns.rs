//! Sweeps by columns: all elevations of an azimuth at once.

use super::film::{Film, Sight};
use super::painter::Seen;
use super::views::{View, by_azimuth};
use crate::error::{ChoiceError, Error, Result};
use edgegait_core::raster::columns::{self, Azimuth, Images};
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::{Frame, Size};
use edgegait_core::template::GeiTally;

/// What draws and sums by columns. 310 kB.
pub(super) struct Columns {
    renderer: ColumnRenderer,
    tally: GeiTally,
}

/// What draws by columns.
pub(super) struct ColumnRenderer {
    pub(super) columns: columns::Renderer,
    /// Tells which share of a figure lies outside of an image.
    pub(super) measure: Renderer,
}

impl Columns {
    pub(super) fn new(size: Size) -> Self {
        Self {
            renderer: ColumnRenderer {
                columns: columns::Renderer::new(),
                measure: Renderer::new(Rasterizer::Rows, size),
            },
            tally: GeiTally::new(size),
        }
    }

    /// The GEIs of the views of these numbers; none of the other views.
    pub(super) fn see(
        &mut self,
        film: &mut Film<'_>,
        views: &[View],
        numbers: &[usize],
    ) -> Result<Vec<Option<Seen>>> {
        let mut seen = vec![None; views.len()];
        for group in by_azimuth(views, numbers)? {
            let sights: Vec<Sight<'_>> = group
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
                seen[at] = Some(Seen {
                    templates: vec![self.tally.gei(elevation).pixels().to_vec()],
                    clipped,
                    ..Seen::default()
                });
            }
        }
        Ok(seen)
    }

    /// One frame from one view.
    pub(super) fn frame(
        &mut self,
        film: &Film<'_>,
        frame: usize,
        sight: Sight<'_>,
    ) -> Result<Frame> {
        let azimuth = Azimuth::new(&[sight.viewpoint()])?;
        let mut images = Images::empty(self.renderer.measure.size());
        film.draw_elevations(frame, (&[sight], &azimuth), &mut self.renderer, &mut images)?;
        Ok(Frame::Binary(images.silhouette(0)))
    }
}

fn too_many() -> Error {
    ChoiceError::ColumnsFrames(GeiTally::MAX_FRAMES).into()
}
