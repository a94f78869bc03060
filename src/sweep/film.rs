//! The frames of one job, posed once and seen from any view.

use super::columns::ColumnRenderer;
use super::settings::{Aim, Framing, Lens, Settings};
use super::{Job, Moments, View, walk_name};
use crate::error::{Error, Result};
use crate::scene::variation::{CycleSeed, Variation};
use edgegait_core::avatar::Avatar;
use edgegait_core::body::{Body, Figure};
use edgegait_core::camera::{self, Camera, Viewpoint};
use edgegait_core::clip::Clip;
use edgegait_core::format::crc32;
use edgegait_core::pack::{Pack, Subject, Walk};
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::raster::columns::{Azimuth, Images, Place};
use edgegait_core::raster::{Drawing, Renderer};
use edgegait_core::skeleton::Skeleton;
use glam::{DVec3, Vec3};
use std::fmt::Display;
use std::ops::Range;

/// Share of the scale that a fitted framing gives up, so that rounding never clips: 0.005 of 50
/// pixels, where coordinates of walkers within 100 m are rounded by 0.0003.
const MARGIN: f32 = 1e-4;

/// Points that are fitted together: whole registers of any processor.
const CHUNK: usize = 16;

/// Posed frames of one job.
pub struct Film<'a> {
    job: Job,
    /// For errors.
    name: String,
    settings: Settings,
    first: u32,
    frames: Vec<Posed<'a>>,
    /// Mean position of the pelvis.
    mean: Vec3,
    walker: Walker<'a>,
    /// Points of all frames by axis, to fit them.
    points: [Vec<f32>; 3],
    /// The framing fitted last, and for which direction of the image's right.
    fitted: Option<(Vec3, camera::Framing)>,
}

/// A view, and the framing that all frames share there, if they do.
#[derive(Clone, Copy)]
pub struct Sight<'v> {
    view: &'v View,
    framing: Option<camera::Framing>,
}

impl Sight<'_> {
    /// From where it is.
    pub const fn viewpoint(&self) -> Viewpoint {
        self.view.viewpoint()
    }
}

/// A figure at one moment.
struct Posed<'a> {
    figure: Figure<'a>,
    pelvis: Vec3,
}

impl<'a> Film<'a> {
    /// The job's figure, with the body that [`body`] gives, without any frame.
    ///
    /// # Errors
    /// When there is no such walk or variation.
    pub fn new(pack: &Pack<'a>, job: Job, body: &'a Body, settings: Settings) -> Result<Self> {
        Ok(Self {
            job,
            name: walk_name(pack, job.walk),
            settings,
            first: 0,
            frames: Vec::new(),
            mean: Vec3::ZERO,
            walker: Walker::new(pack, job, body, settings.seed)?,
            points: Default::default(),
            fitted: None,
        })
    }

    /// Poses these frames in place of those before.
    pub fn pose(&mut self, moments: Moments, frames: Range<u32>) {
        self.first = frames.start;
        self.frames.clear();
        self.frames.extend(frames.map(|frame| {
            let moment = moments.of_frame(frame, self.settings.frames_per_cycle);
            self.walker.at(moment)
        }));
        let sum: DVec3 = self.frames.iter().map(|f| f.pelvis.as_dvec3()).sum();
        self.mean = (sum / self.frames.len().max(1) as f64).as_vec3();
        self.fitted = None;
        if self.settings.framing == Framing::Cycle {
            self.gather();
        }
    }

    /// Gathers the points of all frames, the last one again to fill up a chunk.
    fn gather(&mut self) {
        let all = self.frames.iter().flat_map(|frame| frame.figure.points());
        for (axis, coordinates) in self.points.iter_mut().enumerate() {
            coordinates.clear();
            coordinates.extend(all.clone().map(|point| point[axis]));
            let last = coordinates.last().copied().unwrap_or_default();
            coordinates.resize(coordinates.len().next_multiple_of(CHUNK), last);
        }
    }

    /// The points of each hull, frame by frame, metres.
    pub fn figures(&self) -> Vec<Vec<Vec<Vec3>>> {
        let points = |posed: &Posed<'_>| posed.figure.hulls().map(Iterator::collect).collect();
        self.frames.iter().map(points).collect()
    }

    /// How many frames are posed.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// A view with the framing that the frames share there.
    pub fn sight<'v>(&mut self, view: &'v View) -> Sight<'v> {
        let framing = match self.settings.framing {
            Framing::Height => Some(camera::Framing::Height),
            Framing::Box => Some(camera::Framing::Box),
            Framing::Cycle => Some(self.fit(view.viewpoint())),
            Framing::Camera => None,
        };
        Sight { view, framing }
    }

    /// Draws one of the posed frames.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn draw<'r>(
        &self,
        index: usize,
        sight: &Sight<'_>,
        renderer: &'r mut Renderer,
    ) -> Result<Drawing<'r>> {
        let posed = &self.frames[index];
        let (camera, framing) = self.placed(sight.view, posed, sight.framing)?;
        let jitter = self.settings.jitter.of_frame(self.first + index as u32);
        let jitter = jitter * self.settings.rasterizer.spacing();
        renderer
            .draw(&posed.figure, &camera, framing, jitter)
            .map_err(|error| self.refusal(sight.view, &error))
    }

    /// Draws one of the posed frames at all elevations of an azimuth: the share of it that lies
    /// outside of each image, measured with bit rows; none if all of it is known to be inside.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn draw_elevations(
        &self,
        index: usize,
        (sights, azimuth): (&[Sight<'_>], &Azimuth),
        renderer: &mut ColumnRenderer,
        images: &mut Images,
    ) -> Result<Vec<f64>> {
        let Some(sight) = sights.first() else {
            return Ok(Vec::new());
        };
        let posed = &self.frames[index];
        let (_, framing) = self.placed(sight.view, posed, sight.framing)?;
        let camera::Framing::Fixed {
            centre,
            pixels_per_metre,
        } = framing
        else {
            return Err(self.refusal(sight.view, &"expected one scale for all elevations"));
        };
        let place = Place {
            centre,
            pixels_per_metre,
            jitter: self.settings.jitter.of_frame(self.first + index as u32),
        };
        let drawn = renderer
            .columns
            .draw(&posed.figure, azimuth, &place, images);
        drawn.map_err(|error| self.refusal(sight.view, &error))?;
        if images.is_whole() {
            return Ok(Vec::new());
        }
        let mut clipped = |sight| {
            let drawing = self.draw(index, sight, &mut renderer.measure)?;
            Ok(f64::from(drawing.clipped_share))
        };
        sights.iter().map(&mut clipped).collect()
    }

    /// The camera and the framing of one frame: what a sensor sees, unless frames share one.
    fn placed(
        &self,
        view: &View,
        posed: &Posed,
        shared: Option<camera::Framing>,
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
            Lens::Ortho => Camera::orthographic(view.viewpoint()),
            Lens::Persp => Camera::perspective(view.viewpoint(), aim, sensor.distance_m as f32)
                .map_err(|error| self.refusal(view, &error))?,
        };
        let framing = shared.unwrap_or_else(|| camera::Framing::Fixed {
            centre: aim,
            pixels_per_metre: sensor.pixels_per_metre(size),
        });
        Ok((camera, framing))
    }

    /// The framing that all frames share at this azimuth: nothing is clipped, whatever the
    /// elevation is.
    ///
    /// Turning the elevation turns height and depth about the image's right: what is within a
    /// circle around their middle stays within the rows.
    fn fit(&mut self, viewpoint: Viewpoint) -> camera::Framing {
        let right = viewpoint.right();
        if let Some((_, fitted)) = self.fitted.filter(|(known, _)| *known == right) {
            return fitted;
        }
        let depth = Vec3::new(-right.z, 0.0, right.x);
        // Sums and products in the order of a dot product: many at once, and the same numbers.
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

    fn refusal(&self, view: &View, error: &impl Display) -> Error {
        Error::Failed(format!(
            "{}, cycle {}, azimuth {} and elevation {} degrees: {error}",
            self.name, self.job.cycle, view.azimuth_deg, view.elevation_deg
        ))
    }
}

/// A moment of a walk.
#[derive(Clone, Copy, Debug)]
enum Moment {
    /// In cycles.
    Phase(f32),
    /// From the clip's first frame.
    Seconds(f64),
}

impl Moments {
    /// The moment of a frame.
    fn of_frame(self, frame: u32, frames_per_cycle: u32) -> Moment {
        match self {
            Self::Cycle => Moment::Phase(frame as f32 / frames_per_cycle as f32),
            Self::Seconds { start_s, fps, .. } => Moment::Seconds(start_s + f64::from(frame) / fps),
        }
    }
}

/// One job's figure at any moment.
struct Walker<'a> {
    body: &'a Body,
    skeleton: Skeleton,
    clip: Clip<'a>,
    variation: Variation,
}

impl<'a> Walker<'a> {
    fn new(pack: &Pack<'a>, job: Job, body: &'a Body, seed: u64) -> Result<Self> {
        let (walk, subject, avatar, clip) = parts(pack, job)?;
        if job.cycle > 0 && clip.as_take().is_some() {
            return Err(Error::Failed(format!(
                "{} is a whole take: it has no variations (leave out --cycle)",
                walk_name(pack, job.walk)
            )));
        }
        Ok(Self {
            skeleton: avatar.skeleton(),
            body,
            clip,
            variation: Variation::new(CycleSeed {
                seed,
                subject: u64::from(crc32(subject.name.as_bytes())),
                walk: u64::from(crc32(walk.name.as_bytes())) << 16 | u64::from(walk.cycle),
                cycle: job.cycle,
            }),
        })
    }

    /// The posed figure; a varied one keeps the stored cycle's clearance from the floor.
    fn at(&self, moment: Moment) -> Posed<'a> {
        let duration_s = self.clip.duration_s();
        let (mut pose, phase) = match (moment, self.clip.as_loop()) {
            (Moment::Phase(phase), Some(cycle)) => (cycle.pose(phase), phase),
            (Moment::Phase(phase), None) => {
                (self.clip.sample(f64::from(phase) * duration_s), phase)
            }
            (Moment::Seconds(seconds), _) => {
                #[expect(clippy::cast_possible_truncation, reason = "a phase")]
                let phase = (seconds / duration_s).rem_euclid(1.0) as f32;
                (self.clip.sample(seconds), phase)
            }
        };
        let model = |pose: &Pose| ModelPose::new(&self.skeleton, pose);
        let mut figure = Figure::new(self.body, &model(&pose));
        let before = pose.rotations;
        self.variation.apply(&mut pose, phase);
        if pose.rotations != before {
            let clearance = lowest(&figure);
            figure.update(&model(&pose));
            pose.root.y += clearance - lowest(&figure);
            figure.update(&model(&pose));
        }
        Posed {
            figure,
            pelvis: pose.root,
        }
    }
}

/// The body of a job's walker, unpacked: 101 kB.
///
/// # Errors
/// When there is no such walk.
pub fn body(pack: &Pack<'_>, job: Job) -> Result<Box<Body>> {
    let (_, _, avatar, _) = parts(pack, job)?;
    Ok(Box::new(Body::new(&avatar)))
}

type Parts<'a> = (Walk<'a>, Subject<'a>, Avatar<'a>, Clip<'a>);

/// What a job is made of.
fn parts<'a>(pack: &Pack<'a>, job: Job) -> Result<Parts<'a>> {
    let walk = pack.walks().nth(job.walk);
    let subject = walk.and_then(|walk| pack.subject(walk.subject));
    let parts = walk.zip(subject).and_then(|(walk, subject)| {
        let (avatar, clip) = (pack.avatar(subject.avatar)?, pack.clip(walk.clip)?);
        Some((walk, subject, avatar, clip))
    });
    parts.ok_or_else(|| {
        Error::Failed(format!(
            "there is no walk {}: expected a number below {}",
            job.walk,
            pack.walks().len()
        ))
    })
}

/// The height of a figure's lowest point, metres.
fn lowest(figure: &Figure<'_>) -> f32 {
    figure.points().map(|p| p.y).fold(f32::MAX, f32::min)
}
