//! The frames of one job, posed once and drawn from any view.

use super::column_images::SweepColumns;
use super::extras::Extras;
use super::job_memory::JobMemory;
use super::posed_walker::PosedWalker;
use super::settings::{Aim, FramingMode, Lens, Settings};
use super::walker::{Dressed, Walker};
use super::{Job, Moments, View, recording, walk_name};
use crate::draw::confounders::DosePlan;
use crate::error::{Cause, Error, Result, SweepError};
use edgegait_core::camera::{self, Camera, Viewpoint};
use edgegait_core::pack::Pack;
use edgegait_core::raster::columns::{Azimuth, ElevationImages, FigurePlace};
use edgegait_core::raster::{self, Drawing, Placement, Renderer};
use edgegait_core::silhouette::Size;
use glam::{DVec3, Vec2, Vec3};
use std::ops::Range;

/// The share of the scale that a fitted framing gives up, so that rounding never clips: 0.005 of
/// 50 pixels, while coordinates of walkers within 100 m are rounded by 0.0003.
const MARGIN: f32 = 1e-4;

/// The number of points that are fitted together: a multiple of any processor's registers.
const CHUNK: usize = 16;

/// The posed frames of one job.
pub(super) struct PosedFrames<'a> {
    job: Job<'a>,
    /// The walk's number and name, for errors.
    name: String,
    pub(super) settings: Settings,
    pub(super) plan: &'a DosePlan,
    pub(super) frames: Vec<PosedWalker<'a>>,
    /// The additions to the figure in each frame, if confounders act on images.
    pub(super) extras: Vec<Extras<'a>>,
    /// The number of the frame that each frame shows: its own, unless it was lost.
    pub(super) sources: Vec<u32>,
    /// The mean position of the pelvis.
    mean: Vec3,
    pub(super) walker: Walker<'a>,
    /// The points of all frames by axis, for the fitted framing.
    points: [Vec<f32>; 3],
    /// The last fitted framing, and the direction to the image's right for which it was fitted.
    fitted: Option<(Vec3, camera::Framing)>,
}

/// A view, and the framing that all frames share there, if there is one.
#[derive(Clone, Copy)]
pub(super) struct FramedView<'v> {
    requested: &'v View,
    viewpoint: Viewpoint,
    framing: Option<camera::Framing>,
}

impl<'v> FramedView<'v> {
    /// Returns the view as requested.
    pub(super) const fn requested(&self) -> &'v View {
        self.requested
    }

    /// Returns the viewpoint under the job's condition.
    pub(super) const fn viewpoint(&self) -> Viewpoint {
        self.viewpoint
    }
}

impl<'a> PosedFrames<'a> {
    /// Creates the frames of the job's dressed figure, none of which is posed.
    ///
    /// # Errors
    /// If there is no such walk or variation.
    pub(super) fn new(
        pack: &Pack<'a>,
        job: Job<'a>,
        dressed: &'a mut Dressed,
        settings: Settings,
        memory: &mut JobMemory,
    ) -> Result<Self> {
        let settings = recording::settings(dressed.plan(), settings);
        settings.check()?;
        recording::check(dressed.plan(), &settings)?;
        let walker = Walker::new(pack, job, dressed, settings.seed)?;
        Ok(Self {
            job,
            name: walk_name(pack, job.walk),
            settings,
            plan: walker.plan(),
            frames: std::mem::take(&mut memory.frames),
            extras: Vec::new(),
            sources: Vec::new(),
            mean: Vec3::ZERO,
            walker,
            points: std::mem::take(&mut memory.points),
            fitted: None,
        })
    }

    /// Gives the memory of the frames back.
    pub(super) fn leave(self, memory: &mut JobMemory) {
        let mut frames = self.frames;
        frames.clear();
        // The standard library collects in place: no frames, but their memory.
        memory.frames = frames.into_iter().map_while(|_| None).collect();
        memory.points = self.points;
    }

    /// Poses these frames, which replace the previous ones.
    pub(super) fn pose(&mut self, moments: Moments, frames: Range<u32>) {
        let all = moments.count(self.settings.frames_per_cycle);
        self.sources = recording::sources(self.plan, frames, all);
        self.frames.clear();
        self.extras.clear();
        for &frame in &self.sources {
            let moment = moments.of_frame(frame, self.settings.frames_per_cycle);
            let posed = self.walker.at(moment);
            if self.acts_on_images() {
                let extras = Extras::new(self.plan, &self.walker, moment, &posed);
                self.extras.push(extras);
            }
            self.frames.push(posed);
        }
        let sum: DVec3 = self.frames.iter().map(|f| f.pelvis.as_dvec3()).sum();
        self.mean = (sum / self.frames.len().max(1) as f64).as_vec3();
        self.fitted = None;
        if self.settings.framing == FramingMode::Cycle {
            self.gather();
        }
    }

    /// Gathers the points of all frames, and repeats the last one to fill up a chunk.
    fn gather(&mut self) {
        let all = self.frames.iter().flat_map(|frame| frame.figure.points());
        for (axis, coordinates) in self.points.iter_mut().enumerate() {
            coordinates.clear();
            coordinates.extend(all.clone().map(|point| point[axis]));
            let last = coordinates.last().copied().unwrap_or_default();
            coordinates.resize(coordinates.len().next_multiple_of(CHUNK), last);
        }
    }

    /// Returns the points of each hull, frame by frame, metres.
    pub(super) fn figures(&self) -> Vec<Vec<Vec<Vec3>>> {
        let points =
            |posed: &PosedWalker<'_>| posed.figure.hulls().map(Iterator::collect).collect();
        self.frames.iter().map(points).collect()
    }

    /// Returns the number of posed frames.
    pub(super) fn len(&self) -> usize {
        self.frames.len()
    }

    /// Returns whether silhouettes are made by [`Self::segmented`], not drawn directly.
    pub(super) fn acts_on_images(&self) -> bool {
        recording::acts_on_images(self.plan, self.settings.framing)
    }

    /// Returns rows and columns of the silhouettes.
    pub(super) const fn size(&self) -> Size {
        self.settings.size
    }

    /// Returns the joint positions, metres: `[frames][19][3]`, f32, little-endian.
    pub(super) fn joints(&self) -> Vec<u8> {
        let positions = self.frames.iter().flat_map(|frame| frame.model.positions);
        let numbers = positions.flat_map(|at| at.to_array());
        numbers.flat_map(f32::to_le_bytes).collect()
    }

    /// Returns the joints of one of the posed frames in the image with this placement, pixels:
    /// `[19][2]`, f32, little-endian; NaN where the position is unknown.
    ///
    /// # Errors
    /// The errors of [`Self::draw`].
    pub(super) fn keypoints(
        &self,
        index: usize,
        view: &FramedView<'_>,
        placed: Option<Placement>,
    ) -> Result<Vec<u8>> {
        let camera = self.render_view(index, view)?.camera;
        let appears = |point: Vec3| {
            let image = raster::projected(&camera, point).ok()?;
            Some(placed?.place(image))
        };
        let positions = self.frames[index].model.positions;
        let places = positions.map(|at| appears(at).unwrap_or(Vec2::NAN).to_array());
        Ok(places
            .into_iter()
            .flatten()
            .flat_map(f32::to_le_bytes)
            .collect())
    }

    /// Returns a view with the framing that the frames share there.
    ///
    /// # Errors
    /// If the condition moves the camera to an invalid viewpoint.
    pub(super) fn framed_view<'v>(&mut self, view: &'v View) -> Result<FramedView<'v>> {
        let viewpoint = recording::viewpoint(self.plan, view)?;
        let framing = match self.settings.framing {
            FramingMode::Height => Some(camera::Framing::Height),
            FramingMode::Box => Some(camera::Framing::Box),
            FramingMode::Cycle => Some(self.fit(view.viewpoint())),
            FramingMode::Camera => None,
        };
        Ok(FramedView {
            requested: view,
            viewpoint,
            framing,
        })
    }

    /// Draws one of the posed frames.
    ///
    /// # Errors
    /// If the frame cannot be drawn.
    pub(super) fn draw<'r>(
        &self,
        index: usize,
        view: &FramedView<'_>,
        renderer: &'r mut Renderer,
    ) -> Result<Drawing<'r>> {
        let posed = &self.frames[index];
        let raster::RenderView {
            camera,
            framing,
            jitter,
        } = self.render_view(index, view)?;
        renderer
            .draw(&posed.figure, &camera, framing, jitter)
            .map_err(|error| self.refusal(view.requested, error))
    }

    /// Draws one of the posed frames from several views, and gives each drawing to `take` with the
    /// number of its view.
    ///
    /// # Errors
    /// If the frame cannot be drawn, or the first error of `take`.
    pub(super) fn draw_views(
        &self,
        index: usize,
        views: &[FramedView<'_>],
        renderer: &mut Renderer,
        mut take: impl FnMut(usize, Drawing<'_>) -> Result<()>,
    ) -> Result<()> {
        let render_views: Vec<raster::RenderView> = views
            .iter()
            .map(|view| self.render_view(index, view))
            .collect::<Result<_>>()?;
        renderer.draw_views(
            &self.frames[index].figure,
            &render_views,
            |number, drawing| {
                let refused = |error| self.refusal(views[number].requested, error);
                take(number, drawing.map_err(refused)?)
            },
        )
    }

    /// Draws one of the posed frames at all elevations of an azimuth. Returns the share of the
    /// figure outside of each image, measured with bit rows, or an empty list if all of it is
    /// inside.
    ///
    /// # Errors
    /// If the frame cannot be drawn.
    pub(super) fn draw_elevations(
        &self,
        index: usize,
        views: &[FramedView<'_>],
        azimuth: &Azimuth,
        renderer: &mut SweepColumns,
        images: &mut ElevationImages,
    ) -> Result<Vec<f64>> {
        let Some(view) = views.first() else {
            return Ok(Vec::new());
        };
        let posed = &self.frames[index];
        let (_, framing) = self.placed(view, posed)?;
        let camera::Framing::Fixed {
            centre,
            pixels_per_metre,
        } = framing
        else {
            return Err(self.refusal(view.requested, "expected one scale for all elevations"));
        };
        let place = FigurePlace {
            centre,
            pixels_per_metre,
            jitter: self.settings.jitter.of_frame(self.sources[index]),
        };
        let drawn = renderer
            .columns
            .draw(&posed.figure, azimuth, &place, images);
        drawn.map_err(|error| self.refusal(view.requested, error))?;
        if images.is_whole() {
            return Ok(Vec::new());
        }
        let mut clipped = |view| {
            let drawing = self.draw(index, view, &mut renderer.measure)?;
            Ok(f64::from(drawing.clipped_share))
        };
        views.iter().map(&mut clipped).collect()
    }

    /// Returns camera, framing and jitter of one of the posed frames.
    pub(super) fn render_view(
        &self,
        index: usize,
        view: &FramedView<'_>,
    ) -> Result<raster::RenderView> {
        let (camera, framing) = self.placed(view, &self.frames[index])?;
        let jitter = self.settings.jitter.of_frame(self.sources[index]);
        Ok(raster::RenderView {
            camera,
            framing,
            jitter: jitter * self.settings.rasterizer.spacing(),
        })
    }

    /// Returns the camera and the framing of one frame: the sensor's, unless frames share one.
    fn placed(
        &self,
        view: &FramedView<'_>,
        posed: &PosedWalker<'_>,
    ) -> Result<(Camera, camera::Framing)> {
        let Settings {
            sensor, lens, size, ..
        } = self.settings;
        let aim = match sensor.aim {
            Aim::Pelvis => posed.pelvis,
            Aim::Mean => self.mean,
            Aim::Point(point) => point,
        };
        let camera = match lens {
            Lens::Ortho => Camera::orthographic(view.viewpoint),
            Lens::Persp => Camera::perspective(view.viewpoint, aim, sensor.distance_m as f32)
                .map_err(|error| self.refusal(view.requested, error))?,
        };
        let framing = view.framing.unwrap_or_else(|| camera::Framing::Fixed {
            centre: aim,
            pixels_per_metre: sensor.pixels_per_metre(size),
        });
        Ok((camera, framing))
    }

    /// Returns the framing that all frames share at this azimuth. It clips nothing at any
    /// elevation.
    ///
    /// A change of elevation turns height and depth about the image's right: points within a circle
    /// around their middle stay within the rows.
    fn fit(&mut self, viewpoint: Viewpoint) -> camera::Framing {
        let right = viewpoint.right();
        if let Some((_, fitted)) = self.fitted.filter(|(known, _)| *known == right) {
            return fitted;
        }
        let depth = Vec3::new(-right.z, 0.0, right.x);
        // Sums and products in the order of a dot product: vectorised, with the same results.
        let [x, y, z] = self
            .points
            .each_ref()
            .map(|axis| axis.as_chunks::<CHUNK>().0);
        let along = |direction: Vec3, x: f32, z: f32| x * direction.x + z * direction.z;
        let (mut least, mut most) = ([[f32::INFINITY; CHUNK]; 3], [[f32::NEG_INFINITY; CHUNK]; 3]);
        for ((x, y), z) in x.iter().zip(y).zip(z) {
            for lane in 0..CHUNK {
                let seen = [
                    along(right, x[lane], z[lane]),
                    y[lane],
                    along(depth, x[lane], z[lane]),
                ];
                for axis in 0..3 {
                    least[axis][lane] = if seen[axis] < least[axis][lane] {
                        seen[axis]
                    } else {
                        least[axis][lane]
                    };
                    most[axis][lane] = if seen[axis] > most[axis][lane] {
                        seen[axis]
                    } else {
                        most[axis][lane]
                    };
                }
            }
        }
        let least = Vec3::from(least.map(|lanes| lanes.into_iter().fold(f32::INFINITY, f32::min)));
        let most =
            Vec3::from(most.map(|lanes| lanes.into_iter().fold(f32::NEG_INFINITY, f32::max)));
        let middle = 0.5 * (least + most);
        let mut squares = [0.0f32; CHUNK];
        for ((x, y), z) in x.iter().zip(y).zip(z) {
            for lane in 0..CHUNK {
                let (up, near) = (
                    y[lane] - middle.y,
                    along(depth, x[lane], z[lane]) - middle.z,
                );
                let square = up * up + near * near;
                squares[lane] = if square > squares[lane] {
                    square
                } else {
                    squares[lane]
                };
            }
        }
        let radius = squares.into_iter().fold(0.0, f32::max).sqrt();
        let size = self.settings.size;
        let columns = size.columns() as f32 / (most.x - least.x);
        let rows = size.rows() as f32 / (2.0 * radius);
        let fitted = camera::Framing::Fixed {
            centre: middle.x * right + middle.y * Vec3::Y + middle.z * depth,
            pixels_per_metre: columns.min(rows) * (1.0 - MARGIN),
        };
        self.fitted = Some((right, fitted));
        fitted
    }

    pub(super) fn refusal(&self, view: &View, cause: impl Into<Cause>) -> Error {
        let refusal = SweepError::Unseen {
            walk: self.name.clone(),
            variation: self.job.variation,
            azimuth_deg: view.azimuth_deg,
            elevation_deg: view.elevation_deg,
            cause: cause.into(),
        };
        refusal.into()
    }
}
