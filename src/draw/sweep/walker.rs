//! The figure of one job, dressed and posed at any moment.

use super::job_memory::JobMemory;
use super::posed_walker::PosedWalker;
use super::{Job, Moments, walk_name};
use crate::draw::confounders::appearance::{self, BodyPart, Outfit, Wearer};
use crate::draw::confounders::image::{Crossing, Floor};
use crate::draw::confounders::motion::{self, GaitFacts};
use crate::draw::confounders::{Condition, ConfounderKind, DosePlan, Stage};
use crate::error::{Result, SweepError};
use crate::people::variation::{CycleSeed, Variation};
use edgegait_core::avatar::Avatar;
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::clip::{Clip, Expanded, Loop};
use edgegait_core::format::crc32;
use edgegait_core::pack::{Pack, SubjectEntry, WalkEntry};
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::skeleton::Skeleton;
use glam::{DVec3, Vec3};
use std::cell::OnceCell;
use std::sync::Arc;

/// The number of poses from which the mean and the floor of a walk are computed.
const MEAN_POSES: u32 = 64;

/// A moment of a walk.
#[derive(Clone, Copy, Debug)]
pub(super) enum Moment {
    /// The phase, in cycles.
    Phase(f32),
    /// The time from the clip's first frame, seconds.
    Seconds(f64),
}

impl Moments {
    /// Returns the moment of a frame.
    pub(super) fn of_frame(self, frame: u32, frames_per_cycle: u32) -> Moment {
        match self {
            Self::Cycle => Moment::Phase(frame as f32 / frames_per_cycle as f32),
            Self::Seconds { start_s, fps, .. } => Moment::Seconds(start_s + f64::from(frame) / fps),
        }
    }

    /// Returns the number of frames.
    pub(super) const fn count(self, frames_per_cycle: u32) -> u32 {
        match self {
            Self::Cycle => frames_per_cycle,
            Self::Seconds { frames, .. } => frames,
        }
    }
}

/// A job's body, dressed, and its motion, unpacked.
pub(super) struct Dressed {
    plan: DosePlan,
    body: Arc<UnpackedBody>,
    skeleton: Skeleton,
    /// The pack's body, if a condition changed the body.
    bare: Option<Arc<UnpackedBody>>,
    /// The body of the person who crosses, if there is one.
    crossing: Option<Arc<UnpackedBody>>,
    /// The kind of each of the body's hulls.
    parts: Vec<BodyPart>,
    /// The coefficients of a loop, for [`Walker::new`].
    coefficients: Vec<f32>,
}

impl Dressed {
    /// Dresses the body of a job's walker for its condition.
    ///
    /// # Errors
    /// If there is no such walk, or clothes and loads exceed the budget.
    pub(super) fn new(
        pack: &Pack<'_>,
        job: Job<'_>,
        seed: u64,
        memory: &mut JobMemory,
    ) -> Result<Self> {
        let JobParts {
            walk,
            subject,
            avatar,
            ..
        } = parts(pack, job)?;
        let plan = DosePlan::new(job.condition, seed_of(job, seed, &walk, &subject));
        let outfit = Outfit::from_avatar(&avatar);
        let body = memory.body(&outfit, true, |body| {
            body.push_avatar(&avatar);
            Ok(())
        })?;
        let mut dressed = Self {
            plan,
            body,
            skeleton: avatar.skeleton(),
            bare: None,
            crossing: None,
            parts: parts_of(&outfit),
            coefficients: Vec::new(),
        };
        if !dressed.plan.doses().list().is_empty() {
            dressed
                .put_on(outfit, &subject, memory)
                .map_err(|error| SweepError::Undrawn {
                    what: format!("condition {}", job.condition_name()),
                    cause: error.into(),
                })?;
        }
        Ok(dressed)
    }

    /// Changes the body for the condition, and makes the body of the person who crosses.
    fn put_on(
        &mut self,
        mut outfit: Outfit,
        subject: &SubjectEntry<'_>,
        memory: &mut JobMemory,
    ) -> Result<()> {
        let wearer = Wearer::new(self.skeleton.clone(), subject);
        if let Some(strength) = self.plan.strength(ConfounderKind::Age) {
            self.skeleton = wearer.aged(strength).skeleton;
        }
        dress(&mut outfit, &self.plan, &wearer);
        if self.plan.acts_at(Stage::Body) {
            let body = memory.body(&outfit, false, |body| outfit.unpack(body))?;
            self.bare = Some(std::mem::replace(&mut self.body, body));
            self.parts = parts_of(&outfit);
        }
        if let Some(strength) = self.plan.strength(ConfounderKind::MovingOccluder) {
            let mut rng = self.plan.of_cycle(ConfounderKind::MovingOccluder);
            let scale = Crossing::new(strength, &mut rng).scale();
            for (_, point) in outfit.hulls.iter_mut().flat_map(|hull| &mut hull.points) {
                *point *= scale;
            }
            self.crossing = Some(memory.body(&outfit, false, |body| outfit.unpack(body))?);
        }
        Ok(())
    }

    /// Returns the doses for the job.
    pub(super) const fn plan(&self) -> &DosePlan {
        &self.plan
    }
}

/// Returns the kind of each hull.
fn parts_of(outfit: &Outfit) -> Vec<BodyPart> {
    outfit.hulls.iter().map(|hull| hull.part).collect()
}

/// Puts on clothes and loads.
fn dress(outfit: &mut Outfit, plan: &DosePlan, wearer: &Wearer) {
    for dose in plan.doses().list() {
        let put_on = match dose.kind {
            ConfounderKind::BodyMass => appearance::body_mass,
            ConfounderKind::Build => appearance::build,
            ConfounderKind::Age => appearance::age_body,
            ConfounderKind::Hair => appearance::hair,
            ConfounderKind::Shoes => appearance::shoes,
            ConfounderKind::WideTrousers => appearance::wide_trousers,
            ConfounderKind::Skirt => appearance::skirt,
            ConfounderKind::Coat => appearance::coat,
            ConfounderKind::OpenCoat => appearance::open_coat,
            ConfounderKind::DownJacket => appearance::down_jacket,
            ConfounderKind::Hood => appearance::hood,
            ConfounderKind::Hat => appearance::hat,
            ConfounderKind::Backpack => appearance::backpack,
            ConfounderKind::ShoulderBag => appearance::shoulder_bag,
            ConfounderKind::Suitcase => appearance::suitcase,
            ConfounderKind::Umbrella => appearance::umbrella,
            ConfounderKind::CarriedBox => appearance::carried_box,
            ConfounderKind::Stroller => appearance::stroller,
            _ => continue,
        };
        put_on(outfit, wearer, dose.strength);
    }
}

/// The motion of a walk.
struct WalkMotion<'a> {
    clip: Clip<'a>,
    /// A loop's coefficients; none of an uncut motion.
    cycle: Option<(Loop<'a>, Expanded<'a>)>,
}

impl<'a> WalkMotion<'a> {
    /// Expands a loop into `coefficients`.
    fn new(clip: Clip<'a>, coefficients: &'a mut Vec<f32>) -> Self {
        let cycle = clip.as_loop().map(|cycle| {
            coefficients.resize(cycle.expanded_len(), 0.0);
            let expanded = cycle.expand(coefficients);
            (
                cycle,
                expanded.expect("a buffer of the length that it needs"),
            )
        });
        Self { clip, cycle }
    }

    fn duration_s(&self) -> f64 {
        self.clip.duration_s()
    }

    const fn is_loop(&self) -> bool {
        self.cycle.is_some()
    }

    /// Returns the pose at a phase: 0..1 is the whole motion.
    fn pose(&self, phase: f32) -> Pose {
        match &self.cycle {
            Some((_, expanded)) => expanded.pose(phase),
            None => self.clip.sample(f64::from(phase) * self.duration_s()),
        }
    }

    /// Returns evenly spaced poses.
    fn evenly(&self) -> impl Iterator<Item = Pose> {
        let share = |at| f64::from(at) / f64::from(MEAN_POSES);
        (0..MEAN_POSES).map(move |at| self.sample(share(at) * self.duration_s()))
    }

    /// Returns the pose at a time, seconds.
    fn sample(&self, seconds: f64) -> Pose {
        match &self.cycle {
            Some((cycle, expanded)) => expanded.pose(cycle.phase(seconds)),
            None => self.clip.sample(seconds),
        }
    }
}

/// The walker of one job, from which a figure can be posed at any moment.
pub(super) struct Walker<'a> {
    plan: &'a DosePlan,
    /// The dressed body, its skeleton, and the kinds of its hulls.
    body: &'a UnpackedBody,
    skeleton: Skeleton,
    parts: &'a [BodyPart],
    /// The pack's body and skeleton.
    bare: (&'a UnpackedBody, Skeleton),
    crossing: &'a UnpackedBody,
    motion: WalkMotion<'a>,
    variation: Variation,
    /// Facts of the walk for effects on motion and time.
    gait: GaitFacts,
    /// The height of the lowest point of the pack's body in the stored motion, metres; 0 without
    /// confounders.
    floor_m: OnceCell<f32>,
}

impl<'a> Walker<'a> {
    pub(super) fn new(
        pack: &Pack<'a>,
        job: Job<'_>,
        dressed: &'a mut Dressed,
        seed: u64,
    ) -> Result<Self> {
        let JobParts {
            walk,
            subject,
            avatar,
            clip,
        } = parts(pack, job)?;
        if job.variation > 0 && clip.as_uncut().is_some() {
            return Err(SweepError::UncutHasNoVariations(walk_name(pack, job.walk)).into());
        }
        let Dressed {
            plan,
            body,
            skeleton,
            bare,
            crossing,
            parts,
            coefficients,
        } = dressed;
        let (plan, body): (&DosePlan, &UnpackedBody) = (plan, body);
        let bare = (bare.as_deref().unwrap_or(body), avatar.skeleton());
        let motion = WalkMotion::new(clip, coefficients);
        let duration_s = motion.duration_s();
        let speed_mps = 1e-3 * f64::from(walk.speed_mm_per_s);
        // Without confounders, the mean pose is not needed.
        let poses = (!plan.doses().list().is_empty()).then(|| motion.evenly());
        let poses = poses.into_iter().flatten();
        Ok(Self {
            floor_m: OnceCell::new(),
            gait: GaitFacts::from_poses(skeleton.clone(), poses, speed_mps, duration_s),
            plan,
            body,
            skeleton: skeleton.clone(),
            parts,
            bare,
            crossing: crossing.as_deref().unwrap_or(body),
            motion,
            variation: Variation::new(seed_of(job, seed, &walk, &subject)),
        })
    }

    /// Returns the doses for the job.
    pub(super) const fn plan(&self) -> &'a DosePlan {
        self.plan
    }

    /// Returns the kind of each of the body's hulls.
    pub(super) const fn parts(&self) -> &'a [BodyPart] {
        self.parts
    }

    /// Returns length (metres) and duration (seconds) of a cycle under the condition. A whole uncut
    /// motion counts as one cycle.
    pub(super) fn stride(&self) -> (f64, f64) {
        let plan = self.plan;
        let paces = [
            plan.strength(ConfounderKind::Speed).map(motion::speed_pace),
            plan.strength(ConfounderKind::Age).map(motion::age_pace),
            plan.strength(ConfounderKind::Skirt).map(motion::skirt_pace),
        ];
        let own = (self.gait.stride_m, self.gait.duration_s);
        paces
            .into_iter()
            .flatten()
            .fold(own, |(stride_m, duration_s), pace| {
                (stride_m * pace.stride, duration_s * pace.duration)
            })
    }

    /// Returns the number of strides since the first frame.
    pub(super) fn strides(&self, moment: Moment) -> f64 {
        match moment {
            Moment::Phase(phase) => f64::from(phase),
            Moment::Seconds(seconds) => seconds / self.stride().1,
        }
    }

    /// Returns the figure `seconds` later, before a static camera: a cycle, which is otherwise
    /// walked on the spot, moves ahead; an uncut motion has its own path.
    pub(super) fn passing(&self, moment: Moment, seconds: f64) -> Figure<'a> {
        let (stride_m, duration_s) = self.stride();
        let later = match moment {
            #[expect(clippy::cast_possible_truncation, reason = "a phase")]
            Moment::Phase(phase) => Moment::Phase(phase + (seconds / duration_s) as f32),
            Moment::Seconds(at) => Moment::Seconds(at + seconds),
        };
        let PosedWalker {
            mut figure,
            mut model,
            ..
        } = self.at(later);
        if self.motion.is_loop() {
            #[expect(clippy::cast_possible_truncation, reason = "a length")]
            let ahead = Vec3::new(0.0, 0.0, (stride_m / duration_s * seconds) as f32);
            for position in &mut model.positions {
                *position += ahead;
            }
            figure.update(&model);
        }
        figure
    }

    /// Returns the body of the person who crosses: the walker's, scaled by the condition.
    pub(super) const fn crossing(&self) -> &'a UnpackedBody {
        self.crossing
    }

    /// Returns the floor below a pelvis, at the height of the stored cycle's lowest point.
    pub(super) fn floor(&self, pelvis: Vec3) -> Floor {
        let (bare, skeleton) = &self.bare;
        let height = |pose| bare.lowest(&ModelPose::new(skeleton, &pose), 0.0, 0.0);
        let lowest = || match self.plan.doses().list() {
            [] => 0.0,
            _ => self.motion.evenly().map(height).fold(f32::MAX, f32::min),
        };
        Floor {
            point: Vec3::new(pelvis.x, *self.floor_m.get_or_init(lowest), pelvis.z),
            normal: self.floor_normal().as_vec3(),
        }
    }

    /// Returns the upward normal of the floor, a unit vector.
    fn floor_normal(&self) -> DVec3 {
        let slope = self.plan.strength(ConfounderKind::Slope);
        slope.map_or(DVec3::Y, motion::floor_normal)
    }

    /// Poses the figure. A changed figure keeps the stored cycle's clearance from the floor.
    pub(super) fn at(&self, moment: Moment) -> PosedWalker<'a> {
        let (mut pose, phase) = self.stored(moment);
        let (bare, skeleton) = &self.bare;
        let mut model = ModelPose::new(skeleton, &pose);
        let before = pose.rotations;
        self.variation.apply(&mut pose, phase, &self.skeleton);
        self.act(&mut pose);
        if pose.rotations != before || !std::ptr::eq(*bare, self.body) {
            let clearance = bare.lowest(&model, 0.0, 0.0);
            model.update(&self.skeleton, &pose);
            let normal = self.floor_normal();
            #[expect(clippy::cast_possible_truncation, reason = "a tangent")]
            let rise = (-normal.z / normal.y) as f32;
            pose.root.y += clearance - self.body.lowest(&model, rise, pose.root.z);
            model.update(&self.skeleton, &pose);
        }
        PosedWalker {
            figure: Figure::new(self.body, &model),
            pelvis: pose.root,
            model,
        }
    }

    /// Returns the pack's pose at a moment, and its phase in the cycle.
    fn stored(&self, moment: Moment) -> (Pose, f32) {
        let duration_s = self.motion.duration_s();
        match moment {
            Moment::Phase(phase) => {
                let limp = self.plan.strength(ConfounderKind::AsymmetricGait);
                #[expect(clippy::cast_possible_truncation, reason = "a phase")]
                let phase = limp
                    .filter(|_| self.motion.is_loop())
                    .map_or(phase, |strength| {
                        motion::limp_phase(f64::from(phase), strength) as f32
                    });
                (self.motion.pose(phase), phase)
            }
            Moment::Seconds(seconds) => {
                #[expect(clippy::cast_possible_truncation, reason = "a phase")]
                let phase = (seconds / duration_s).rem_euclid(1.0) as f32;
                (self.motion.sample(seconds), phase)
            }
        }
    }

    /// Applies the condition's effects on motion to a pose.
    fn act(&self, pose: &mut Pose) {
        let effects: [(ConfounderKind, motion::Effect); 13] = [
            (ConfounderKind::Speed, motion::speed),
            (ConfounderKind::Age, motion::age_gait),
            (ConfounderKind::Skirt, motion::skirt_gait),
            (ConfounderKind::ArmStill, motion::arm_still),
            (ConfounderKind::HandsInPockets, motion::hands_in_pockets),
            (ConfounderKind::Phone, motion::phone_at_ear),
            (ConfounderKind::Backpack, motion::load_lean),
            (ConfounderKind::Suitcase, motion::carried_arm),
            (ConfounderKind::Umbrella, motion::under_umbrella),
            (ConfounderKind::CarriedBox, motion::around_box),
            (ConfounderKind::Stroller, motion::at_the_bar),
            (ConfounderKind::AsymmetricGait, motion::limp),
            (ConfounderKind::Slope, motion::slope),
        ];
        for (kind, effect) in effects {
            if let Some(strength) = self.plan.strength(kind) {
                effect(pose, &self.gait, strength);
            }
        }
    }
}

/// Returns all doses of a job whose condition is random, such as `coat=0.5`, or an empty text if
/// the condition is fixed.
///
/// # Errors
/// If there is no such walk.
pub fn drawn(pack: &Pack<'_>, job: Job<'_>, seed: u64) -> Result<String> {
    if job.condition.is_none_or(Condition::is_fixed) {
        return Ok(String::new());
    }
    let JobParts { walk, subject, .. } = parts(pack, job)?;
    let plan = DosePlan::new(job.condition, seed_of(job, seed, &walk, &subject));
    Ok(plan.doses().to_string())
}

/// Returns the hash that seeds a person's random numbers, whatever else is in the pack.
fn subject_hash(name: &str) -> u64 {
    u64::from(crc32(name.as_bytes()))
}

/// Returns the seed of a cycle's variation and of its other random numbers.
fn seed_of(job: Job<'_>, seed: u64, walk: &WalkEntry<'_>, subject: &SubjectEntry<'_>) -> CycleSeed {
    CycleSeed {
        seed,
        subject: subject_hash(subject.name),
        walk: u64::from(crc32(walk.name.as_bytes())) << 16 | u64::from(walk.cycle),
        variation: job.variation,
    }
}

/// The entries of a pack that a job draws.
struct JobParts<'a> {
    walk: WalkEntry<'a>,
    subject: SubjectEntry<'a>,
    avatar: Avatar<'a>,
    clip: Clip<'a>,
}

fn parts<'a>(pack: &Pack<'a>, job: Job<'_>) -> Result<JobParts<'a>> {
    let walk = pack.walk(job.walk);
    let subject = walk.and_then(|walk| pack.subject(walk.subject));
    let parts = walk.zip(subject).and_then(|(walk, subject)| {
        Some(JobParts {
            walk,
            subject,
            avatar: pack.avatar(walk.avatar)?,
            clip: pack.clip(walk.clip)?,
        })
    });
    parts.ok_or_else(|| {
        SweepError::NoWalk {
            number: job.walk,
            walks: pack.walks().len(),
        }
        .into()
    })
}
