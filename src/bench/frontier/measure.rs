//! Measures all configurations of one scene.

use super::pareto::{ConfigurationCost, pareto};
use super::recognition::{Rank1, ShippedRecognizers};
use super::timing::{Timed, least_ns};
use crate::draw::sweep::{Job, Settings, View, Views};
use crate::encode::encode_subjects;
use crate::encode::within_error::configuration::{
    Configuration, DrawConfiguration, Encoding, configurations, drawings,
};
use crate::encode::within_error::reference::{Deviation, Reference, ReferenceSample, exact_geis};
use crate::encode::within_error::spread_views;
use crate::error::{Error, Result};
use crate::people::Subject;
use crate::people::cohort::{self, CohortOptions};
use crate::people::fewer_points::with_thinner_bodies;
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::pack::Pack;
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::raster::{self, Renderer};
use edgegait_core::template::GeiBuilder;
use serde::Serialize;
use std::collections::BTreeMap;

/// The variations of each walk that are probes of Rank-1, as in `score`.
const PROBES: [u32; 2] = [1_000, 1_001];
/// The maximum number of walks that errors are averaged over.
const MOST_WALKS: usize = 18;
/// The number of rounds in which every configuration is timed once.
const ROUNDS: usize = 4;

/// The source of the walks.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FrontierPeople<'a> {
    /// People of the built-in cohort, encoded in each of the encodings.
    BuiltIn,
    /// Walks of a pack, used as they are stored.
    Pack {
        /// The pack.
        bytes: &'a [u8],
        /// The numbers of the walks.
        walks: &'a [usize],
    },
}

/// The settings of a measurement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrontierStudy<'a> {
    /// The source of the walks.
    pub scene: FrontierPeople<'a>,
    /// The seed of the probes' variations.
    pub seed: u64,
    /// Whether a rough answer is enough: two people, four viewpoints, one round.
    pub is_quick: bool,
}

/// The results of one configuration.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct FrontierPoint {
    /// The settings in words.
    pub name: String,
    /// The rasteriser.
    pub raster: &'static str,
    /// The positions in pixels at which each frame is sampled.
    pub jitter: &'static str,
    /// The number of points of all hulls of the largest body.
    pub hull_points: usize,
    /// The number of frames of each cycle.
    pub frames_per_cycle: u32,
    /// The greatest error of a walk, mm.
    pub track_error_mm: f64,
    /// The shortest time of a complete silhouette on one thread.
    pub ns_per_silhouette: f64,
    /// The shortest time of all frames of a cycle.
    pub ns_per_gei: f64,
    /// The time of a silhouette, relative to the default in the same run.
    pub time_ratio: f64,
    /// The mean Jaccard index over all frames.
    pub jaccard: f64,
    /// The root mean square error of a GEI, of 255.
    pub gei_rmse: f64,
    /// Rank-1 minus that on the reference, mean over the shipped recognizers.
    pub rank1_delta: f64,
    /// Rank-1 minus that on the reference, for each recognizer.
    pub rank1_delta_by: BTreeMap<String, f64>,
    /// The size of the whole pack.
    pub pack_bytes: usize,
    /// The peak heap of the rasteriser.
    pub heap_bytes: usize,
    /// The size of the core's types that one GEI needs.
    pub stack_bytes: usize,
    /// Whether it is the default configuration.
    pub is_default: bool,
    /// Whether no other configuration beats it.
    pub pareto: bool,
}

impl FrontierPoint {
    /// Returns the values that configurations are compared by.
    #[must_use]
    pub(crate) const fn merits(&self) -> ConfigurationCost {
        ConfigurationCost {
            ns_per_gei: self.ns_per_gei,
            pack_bytes: self.pack_bytes,
            gei_rmse: self.gei_rmse,
        }
    }
}

/// The packs of the same people: the finest, and one for each encoding.
struct Packs {
    finest: Vec<u8>,
    encoded: Vec<(Option<Encoding>, Vec<u8>)>,
}

impl Packs {
    /// Uses a pack as its own reference.
    fn as_stored(bytes: Vec<u8>) -> Self {
        Self {
            encoded: vec![(None, bytes.clone())],
            finest: bytes,
        }
    }

    /// Encodes people in each encoding of the configurations, and in the finest.
    fn encoded(
        people: &[Subject],
        configurations: &[Configuration],
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<Self> {
        let mut encoded: Vec<(Option<Encoding>, Vec<u8>)> = Vec::new();
        for encoding in encodings(configurations) {
            let thinner = with_thinner_bodies(people, encoding.hull_points)?;
            let bytes = encode_subjects(&thinner, encoding.track_error_mm, &|| Ok(()))?;
            encoded.push((Some(encoding), bytes));
            progress()?;
        }
        let finest = encode_subjects(people, Encoding::FINEST.track_error_mm, &|| Ok(()))?;
        progress()?;
        Ok(Self { finest, encoded })
    }

    fn pack(&self, configuration: &Configuration) -> Result<&[u8]> {
        let mut encoded = self.encoded.iter();
        let found = encoded.find(|(encoding, _)| *encoding == configuration.encoding);
        found
            .map(|(_, bytes)| bytes.as_slice())
            .ok_or(Error::Missing("a pack of each configuration"))
    }
}

/// Returns the encodings of a list of configurations, each once.
fn encodings(configurations: &[Configuration]) -> Vec<Encoding> {
    let mut distinct = Vec::new();
    for encoding in configurations.iter().filter_map(|c| c.encoding) {
        if !distinct.contains(&encoding) {
            distinct.push(encoding);
        }
    }
    distinct
}

impl FrontierStudy<'_> {
    /// Returns the configurations to measure, the default first.
    #[must_use]
    pub(crate) fn configurations(&self) -> Vec<Configuration> {
        if matches!(self.scene, FrontierPeople::BuiltIn) {
            return configurations();
        }
        let mut drawings: Vec<DrawConfiguration> = drawings().collect();
        drawings.sort_by_key(|&drawing| drawing != DrawConfiguration::DEFAULT);
        let stored = |drawing| Configuration {
            drawing,
            encoding: None,
        };
        drawings.into_iter().map(stored).collect()
    }

    /// Returns how often [`Self::run`] calls its `progress`.
    #[must_use]
    pub(crate) fn steps(&self) -> usize {
        let configurations = self.configurations();
        let encodings = match self.scene {
            FrontierPeople::BuiltIn => encodings(&configurations).len() + 1,
            FrontierPeople::Pack { .. } => 1,
        };
        encodings + 2 + configurations.len() * (2 + self.rounds())
    }

    /// Returns the viewpoints for errors and Rank-1.
    ///
    /// # Errors
    /// Never.
    pub(crate) fn views(&self) -> Result<Views> {
        if self.is_quick {
            Views::grid("quick spread", [0.0, 90.0], [0.0, 60.0])
        } else {
            spread_views()
        }
    }

    const fn rounds(&self) -> usize {
        if self.is_quick { 1 } else { ROUNDS }
    }

    /// Returns the viewpoints that share a pose in timing.
    fn timed_views(&self) -> Result<Vec<View>> {
        if self.is_quick {
            return Ok(self.views()?.list);
        }
        let degrees = |last: u8, step| (0..=last).step_by(step).map(f32::from);
        Ok(Views::grid("timed", degrees(180, 10), degrees(90, 15))?.list)
    }

    /// Measures every configuration.
    ///
    /// # Errors
    /// If a figure cannot be drawn or encoded.
    pub(crate) fn run(
        &self,
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<Vec<FrontierPoint>> {
        let configurations = self.configurations();
        let people = self.people()?;
        let of_cohort;
        let (packs, probed) = match self.scene {
            FrontierPeople::BuiltIn => {
                let packs = Packs::encoded(&people, &configurations, progress)?;
                (packs, None)
            }
            FrontierPeople::Pack { bytes, .. } => {
                let error_mm = Encoding::DEFAULT.track_error_mm;
                of_cohort = Packs::as_stored(encode_subjects(&people, error_mm, &|| Ok(()))?);
                progress()?;
                (Packs::as_stored(bytes.to_vec()), Some(&of_cohort))
            }
        };
        let probed = probed.unwrap_or(&packs);
        let errors = self.errors(&packs, &configurations, progress)?;
        let rank1 = self.rank1(probed, &configurations, progress)?;
        let times = self.times(&packs, &configurations, progress)?;
        let mut points = Vec::new();
        for (index, configuration) in configurations.iter().enumerate() {
            let bytes = packs.pack(configuration)?;
            let stored = stored(bytes)?;
            let asked_mm = configuration.encoding.map(|asked| asked.track_error_mm);
            let drawing = configuration.drawing;
            let deltas: Vec<f64> = rank1[index].values().copied().collect();
            points.push(FrontierPoint {
                name: configuration.to_string(),
                raster: drawing.rasterizer.name(),
                jitter: drawing.jitter.name(),
                hull_points: stored.hull_points,
                frames_per_cycle: drawing.frames_per_cycle,
                track_error_mm: asked_mm.unwrap_or(stored.track_error_mm),
                ns_per_silhouette: times[index],
                ns_per_gei: times[index] * f64::from(drawing.frames_per_cycle),
                // The default comes first.
                time_ratio: times[index] / times[0],
                jaccard: errors[index].jaccard,
                gei_rmse: errors[index].gei_rmse,
                rank1_delta: deltas.iter().sum::<f64>() / deltas.len() as f64,
                rank1_delta_by: rank1[index].clone(),
                pack_bytes: bytes.len(),
                heap_bytes: drawing.heap_bytes(),
                stack_bytes: stack_bytes(),
                is_default: configuration.is_default(),
                pareto: false,
            });
        }
        let set = pareto(&points.iter().map(FrontierPoint::merits).collect::<Vec<_>>());
        for (point, is_best) in points.iter_mut().zip(set) {
            point.pareto = is_best;
        }
        Ok(points)
    }

    /// Returns the built-in cohort at 5 km/h, as the shipped recognizers were trained. In the
    /// built-in scene the first people also walk at 3 and 10 km/h.
    fn people(&self) -> Result<Vec<Subject>> {
        let (everyone, walking) = if self.is_quick {
            (2, 1)
        } else {
            (cohort::PEOPLE, 6)
        };
        let made = |people, speeds_kmh| {
            cohort::subjects(&CohortOptions {
                people,
                speeds_kmh,
                ..CohortOptions::default()
            })
        };
        let mut people = made(everyone, vec![5.0])?;
        if matches!(self.scene, FrontierPeople::BuiltIn) {
            let more = made(walking, vec![3.0, 10.0])?;
            for (person, more) in people.iter_mut().zip(more) {
                person.walks.extend(more.walks);
            }
        }
        Ok(people)
    }

    fn errors(
        &self,
        packs: &Packs,
        configurations: &[Configuration],
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<Vec<Deviation>> {
        let finest = Pack::parse(&packs.finest)?;
        let walks = match self.scene {
            FrontierPeople::BuiltIn => of_walkers(&finest),
            FrontierPeople::Pack { walks, .. } => walks.to_vec(),
        };
        let sample = ReferenceSample::spread(&walks, &self.views()?.list, (MOST_WALKS, usize::MAX));
        let settings = Settings::default();
        let reference = Reference::new(&finest, &sample, settings, &|| Ok(()))?;
        progress()?;
        let measured = configurations.iter().map(|configuration| {
            let pack = Pack::parse(packs.pack(configuration)?)?;
            let settings = configuration.drawing.applied_to(settings);
            let found = reference.deviation(&pack, &sample, settings)?;
            progress()?;
            Ok(found)
        });
        measured.collect()
    }

    /// Returns for each configuration Rank-1 minus that on the reference, by recognizer.
    fn rank1(
        &self,
        packs: &Packs,
        configurations: &[Configuration],
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<Vec<BTreeMap<String, f64>>> {
        let finest = Pack::parse(&packs.finest)?;
        let walks = finest.walks().enumerate();
        let probed = walks.filter(|(_, walk)| walk.name == "walk-5kmh");
        let jobs = probed.flat_map(|(walk, _)| PROBES.map(|cycle| Job::plain(walk, cycle)));
        let sample = ReferenceSample {
            jobs: jobs.collect(),
            views: self.views()?.list,
        };
        let settings = Settings {
            seed: self.seed,
            ..Settings::default()
        };
        let recognition = ShippedRecognizers::shipped()?;
        let geis = exact_geis(&finest, &sample, settings, &|| Ok(()))?;
        let expected = recognition.of_exact(&finest, &sample, &geis)?;
        progress()?;
        let measured = configurations.iter().map(|configuration| {
            let pack = Pack::parse(packs.pack(configuration)?)?;
            let settings = configuration.drawing.applied_to(settings);
            let found = recognition.of_drawn(&pack, &sample, settings)?;
            progress()?;
            let delta =
                |(found, expected): (Rank1, &Rank1)| (found.name, found.rank1 - expected.rank1);
            Ok(found.into_iter().zip(&expected).map(delta).collect())
        });
        measured.collect()
    }

    fn times(
        &self,
        packs: &Packs,
        configurations: &[Configuration],
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<Vec<f64>> {
        let cases = configurations.iter().map(|configuration| {
            Ok(Timed {
                pack: Pack::parse(packs.pack(configuration)?)?,
                settings: configuration.drawing.applied_to(Settings::default()),
            })
        });
        let cases: Vec<Timed<'_>> = cases.collect::<Result<_>>()?;
        least_ns(&cases, &self.timed_views()?, self.rounds(), progress)
    }
}

/// Returns the walks of people with several walks.
fn of_walkers(pack: &Pack<'_>) -> Vec<usize> {
    let subjects: Vec<usize> = pack.walks().map(|walk| walk.subject).collect();
    let count = |subject: usize| subjects.iter().filter(|&&other| other == subject).count();
    let has_several = |walk: &usize| count(subjects[*walk]) > 1;
    (0..subjects.len()).filter(has_several).collect()
}

/// Returns the greatest error that a pack states, and the points of its largest body.
fn stored(bytes: &[u8]) -> Result<Encoding> {
    let pack = Pack::parse(bytes)?;
    let clips = (0..pack.clip_count()).filter_map(|index| pack.clip(index));
    let errors = clips.map(|clip| f64::from(clip.max_error_mm()));
    let avatars = (0..pack.avatar_count()).filter_map(|index| pack.avatar(index));
    let points = avatars.map(|avatar| avatar.hulls().map(|hull| hull.len()).sum());
    Ok(Encoding {
        track_error_mm: errors.fold(0.0, f64::max),
        hull_points: points.max().unwrap_or(0),
    })
}

/// Returns the stack that one GEI needs for the core's types, without the frames of functions.
const fn stack_bytes() -> usize {
    size_of::<Pose>()
        + size_of::<ModelPose>()
        + size_of::<UnpackedBody>()
        + size_of::<Figure<'_>>()
        + size_of::<Renderer>()
        + size_of::<raster::Drawing<'_>>()
        + size_of::<GeiBuilder>()
}
