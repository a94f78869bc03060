//! Synthetic twins: bodies with the measurements of a manifest's people that walk as in their
//! recordings.

use super::example::{Example, SIZE, gei};
use super::likeness::PHASES;
use super::manifest::{Pairing, listed};
use crate::draw::confounders::Condition;
use crate::draw::sweep::{
    FramingMode, Job, Lens, Moments, Sensor, Settings, Shot, View, silhouettes,
};
use crate::encode::{Effort, MAX_ERROR_MM, encode_population};
use crate::error::{Error, FilePlace, Result};
use crate::people::cohort::{self, CohortOptions};
use crate::people::encodable::without;
use crate::people::measured::MeasuredPeople;
use crate::people::recorded::{BodyOptions, Keep, ReadOptions, Recording, SubjectName, subjects};
use crate::people::{Subject, Track};
use edgegait_core::pack::Pack;
use edgegait_core::raster::Rasterizer;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// A recording of a person, and the takes that show it.
#[derive(Clone, Debug)]
pub(crate) struct TwinRecording {
    /// The number of the person.
    pub person: usize,
    /// The path of the file.
    pub path: PathBuf,
    /// The takes that show it.
    pub takes: Vec<ShownSpan>,
}

/// The part of a recording that a take shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShownSpan {
    /// The number of the take.
    pub take: usize,
    /// Start and end in the recording, seconds.
    pub span_s: (f64, f64),
}

/// One gait cycle of a twin.
#[derive(Clone, Copy, Debug)]
struct TwinCycle {
    /// The number of the walk in the pack.
    walk: usize,
    /// The number of the variation of the walk.
    variation: u32,
    person: usize,
    /// The number of the take that is nearest in time.
    take: usize,
    /// The number of the cycle in that take.
    position: usize,
    span_s: (f64, f64),
}

/// The recordings to be retargeted to bodies.
pub(crate) struct Walkers {
    sources: Vec<TwinRecording>,
    recordings: Vec<Recording>,
    /// The recordings that were left out, and the reasons.
    pub warnings: Vec<String>,
}

/// The twins as a pack, ready to be drawn.
pub(crate) struct Twins {
    pack: Vec<u8>,
    cycles: Vec<TwinCycle>,
}

/// Finds the file of a pairing's recording in one of the folders or their subfolders `clips`. If a
/// folder has the name that the row states, only such folders are searched.
///
/// # Errors
/// If it is in none of them.
pub(crate) fn find(pairing: &Pairing, manifest: &Path, folders: &[PathBuf]) -> Result<PathBuf> {
    let is_called = |folder: &&PathBuf| {
        let name = folder.file_name().map(|name| name.to_string_lossy());
        name.is_some() && name.as_deref() == pairing.root.as_deref()
    };
    let named: Vec<&PathBuf> = folders.iter().filter(is_called).collect();
    let all: Vec<&PathBuf> = folders.iter().collect();
    let places = if named.is_empty() { all } else { named };
    let files = places.iter().flat_map(|folder| {
        [
            folder.join(&pairing.source),
            folder.join("clips").join(&pairing.source),
        ]
    });
    files
        .into_iter()
        .find(|file| file.is_file())
        .ok_or_else(|| {
            let places: Vec<String> = places.iter().map(|it| it.display().to_string()).collect();
            Error::at(
                manifest,
                FilePlace::Line(pairing.line),
                format!(
                    "source: expected the recording {} in {} or in its folder clips, found none",
                    pairing.source,
                    if places.is_empty() {
                        "a folder of recordings (none was named)".into()
                    } else {
                        listed(&places)
                    }
                ),
            )
        })
}

impl Walkers {
    /// Reads the recordings on all cores; `names` are the names of the people. Recordings without a
    /// gait cycle are left out with a warning.
    ///
    /// # Errors
    /// If none is left.
    pub(crate) fn read(
        sources: &[TwinRecording],
        names: &[String],
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<Self> {
        let read = |source: &TwinRecording| {
            let options = ReadOptions {
                keep: Keep::Cycles,
                subject: SubjectName::Given(names[source.person].clone()),
                ..ReadOptions::default()
            };
            let recording = Recording::read(&source.path, &options);
            progress()?;
            Ok(recording)
        };
        let found: Vec<Result<Recording>> = sources.par_iter().map(read).collect::<Result<_>>()?;
        let mut walkers = Self {
            sources: Vec::new(),
            recordings: Vec::new(),
            warnings: Vec::new(),
        };
        for (number, (source, found)) in sources.iter().zip(found).enumerate() {
            match found {
                Ok(mut recording) => {
                    // Files with the same name in several folders are different walks.
                    recording.name = format!("{number}");
                    walkers.sources.push(source.clone());
                    walkers.recordings.push(recording);
                }
                Err(error) => walkers.warnings.push(format!("left out: {error}")),
            }
        }
        if walkers.recordings.is_empty() {
            return Err(Error::Failed(format!(
                "no recording has a gait cycle: {}",
                listed(&walkers.warnings)
            )));
        }
        Ok(walkers)
    }

    /// Names the file of a recording that is refused.
    fn named(&self, error: Error) -> Error {
        match error {
            Error::Refused(refused) => without(&mut self.recordings.clone(), &refused)
                .into_iter()
                .next()
                .unwrap_or(Error::Refused(refused)),
            other => other,
        }
    }

    /// Makes twins with bodies of these measurements, and with trunks that lean further ahead by
    /// `lean_deg` degrees.
    ///
    /// # Errors
    /// If a body is implausible or a walk cannot be encoded.
    pub(crate) fn with_bodies(&self, measured: &MeasuredPeople, lean_deg: f64) -> Result<Twins> {
        let options = BodyOptions {
            measured: measured.clone(),
            ..BodyOptions::default()
        };
        let mut people = subjects(&self.recordings, &options).map_err(|it| self.named(it))?;
        for person in &mut people {
            let walks = person.walks.iter_mut();
            for motion in walks.map(|walk| &mut walk.motion) {
                if let Track::Loop(cycle) = motion
                    && lean_deg != 0.0
                {
                    *cycle = cycle.leaning_ahead(&person.body.offsets, lean_deg);
                }
            }
        }
        let pack = pack(&people, &|| Ok(())).map_err(|it| self.named(it))?;
        let parsed = Pack::parse(&pack)?;
        let mut cycles: Vec<TwinCycle> = Vec::new();
        for (number, walk) in parsed.walks().enumerate() {
            let owner = parsed
                .subjects()
                .nth(walk.subject)
                .map(|subject| subject.name);
            let known = self.recordings.iter().zip(&self.sources);
            let mut known = known.filter(|(recording, _)| {
                recording.name == walk.name && Some(recording.subject.as_str()) == owner
            });
            let (recording, source) = known.next().ok_or(Error::Missing("a walk"))?;
            let cut = recording.cut.as_ref().ok_or(Error::Missing("cycles"))?;
            let cycle = &cut.cycles[usize::from(walk.cycle)];
            let span_s = (cycle.start_s, cycle.start_s + cycle.cycle.period_s);
            let middle = f64::midpoint(span_s.0, span_s.1);
            let outside = |(from, to): (f64, f64)| (from - middle).max(middle - to).max(0.0);
            let takes = source.takes.iter();
            let nearest = takes.min_by(|a, b| outside(a.span_s).total_cmp(&outside(b.span_s)));
            let take = nearest.ok_or(Error::Missing("a take"))?.take;
            let position = cycles.iter().filter(|cycle| cycle.take == take).count();
            cycles.push(TwinCycle {
                walk: number,
                variation: 0,
                person: source.person,
                take,
                position,
                span_s,
            });
        }
        Ok(Twins { pack, cycles })
    }
}

/// Encodes people with the usual error, without searching for the fewest bytes, because the pack is
/// not stored.
fn pack(people: &[Subject], progress: &(dyn Fn() -> Result<()> + Sync)) -> Result<Vec<u8>> {
    let make = |number: usize| Ok(people[number].clone());
    encode_population(
        0..people.len(),
        &make,
        MAX_ERROR_MM,
        Effort::Quick,
        progress,
    )
}

impl Twins {
    /// Makes twins from the built-in cohort, which has no real people: takes of seeded variations
    /// of a walk at 5 km/h. Also returns the people's names.
    ///
    /// # Errors
    /// Never.
    pub(crate) fn of_cohort(
        takes: u32,
        cycles: u32,
        progress: &(dyn Fn() -> Result<()> + Sync),
    ) -> Result<(Self, Vec<String>)> {
        let options = CohortOptions {
            speeds_kmh: vec![5.0],
            ..CohortOptions::default()
        };
        let pack = pack(&cohort::subjects(&options)?, progress)?;
        let parsed = Pack::parse(&pack)?;
        let names = parsed
            .subjects()
            .map(|subject| subject.name.to_owned())
            .collect();
        let walks = parsed.walks().map(|walk| walk.subject).enumerate();
        let of = |(walk, person): (usize, usize)| {
            (0..takes * cycles).map(move |variation| TwinCycle {
                walk,
                variation,
                person,
                take: person * takes as usize + (variation / cycles) as usize,
                position: (variation % cycles) as usize,
                span_s: (f64::from(variation), f64::from(variation + 1)),
            })
        };
        let cycles = walks.flat_map(of).collect();
        Ok((Self { pack, cycles }, names))
    }

    /// Draws the gait cycles of all twins from one viewpoint in perspective, from `distance_m`
    /// metres, on all cores.
    ///
    /// # Errors
    /// If a figure cannot be drawn.
    pub(crate) fn draw(
        &self,
        view: View,
        distance_m: f64,
        framing: FramingMode,
        condition: Option<&Condition>,
    ) -> Result<Vec<Example>> {
        let pack = Pack::parse(&self.pack)?;
        let settings = Settings {
            rasterizer: Rasterizer::Rows.into(),
            size: SIZE,
            framing,
            lens: Lens::Persp,
            sensor: Sensor {
                distance_m,
                ..Sensor::default()
            },
            frames_per_cycle: PHASES as u32,
            ..Settings::default()
        };
        let draw = |cycle: &TwinCycle| -> Result<Example> {
            let job = Job {
                condition,
                ..Job::plain(cycle.walk, cycle.variation)
            };
            let shot = Shot {
                job,
                moments: Moments::Cycle,
                views: &[view],
            };
            let drawn = silhouettes(&pack, shot, settings)?;
            let drawn = drawn.into_iter().flatten().enumerate();
            let frames: Vec<_> = drawn
                .map(|(at, frame)| (at as f64 / PHASES as f64, frame.silhouette()))
                .collect();
            Ok(Example {
                person: cycle.person,
                take: cycle.take,
                position: cycle.position,
                span_s: cycle.span_s,
                gei: gei(frames.iter().map(|(_, frame)| frame)),
                frames,
            })
        };
        self.cycles.par_iter().map(draw).collect()
    }
}
