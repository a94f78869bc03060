//! Samples what a design leaves to chance, for each person or cycle from the seed, independently of
//! other people and cycles.

use super::{Angles, Speeds};
use crate::draw::sweep::Job;
use edgegait_core::format::crc32;
use edgegait_core::pack::Pack;
use rand::{Rng, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// First random stream of people's speeds and ages; bodies and clothes have others.
const PEOPLE: u64 = 1 << 62;
/// First random stream of cycles' viewpoints.
const CYCLES: u64 = 3 << 62;
/// Steps in a year of age, in a km/h of speed and in a degree of angle, so that results state
/// sampled values exactly.
const YEAR: f64 = 1.0;
const KMH: f64 = 10.0;
const DEGREE: f32 = 8.0;

/// Returns the random generator of the person with this number.
pub(super) fn of_person(seed: u64, number: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(PEOPLE | number as u64);
    rng
}

/// Returns the random generator of a cycle, seeded by the names of the person and of the walk, as
/// for variations. All conditions have the same viewpoints.
pub(super) fn of_cycle(seed: u64, pack: &Pack<'_>, job: Job<'_>) -> ChaCha8Rng {
    let walk = pack.walk(job.walk);
    let subject = walk.and_then(|walk| pack.subject(walk.subject));
    let hash = |name: &str| u64::from(crc32(name.as_bytes()));
    let subject = hash(subject.map_or("", |subject| subject.name));
    let walk = hash(walk.map_or("", |walk| walk.name));
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ subject << 32 ^ walk);
    rng.set_stream(CYCLES | u64::from(job.variation));
    rng
}

/// Samples a multiple of a step between two numbers, uniformly.
fn steps(rng: &mut impl Rng, [low, high]: [f64; 2], steps: f64) -> f64 {
    let (low, high) = ((low * steps).ceil(), (high * steps).floor());
    let count = (high - low).max(0.0) as u32;
    (low + f64::from(rng.random_range(0..=count))) / steps
}

/// Samples an age, years.
pub(super) fn years(rng: &mut impl Rng, between: [f64; 2]) -> f64 {
    steps(rng, between, YEAR)
}

impl Speeds {
    /// Returns the number of different speeds between two.
    pub(super) fn count(between: [f64; 2]) -> usize {
        let [low, high] = between;
        let more = ((high * KMH).floor() - (low * KMH).ceil()).max(-1.0);
        (more + 1.0) as usize
    }

    /// Returns the slowest and the fastest speed, or all.
    pub(super) fn bounds(&self) -> Vec<f64> {
        match self {
            Self::Each(speeds) => speeds.clone(),
            Self::Drawn {
                between: [low, high],
                ..
            } if low < high => vec![*low, *high],
            Self::Drawn { between, .. } => vec![between[0]],
        }
    }

    /// Samples the speeds of one person, all different, slowest first.
    pub(super) fn drawn(&self, rng: &mut impl Rng) -> Vec<f64> {
        let (between, walks) = match self {
            Self::Each(speeds) => return speeds.clone(),
            Self::Drawn { between, walks } => (*between, *walks),
        };
        let mut speeds: Vec<f64> = Vec::new();
        while speeds.len() < walks {
            let speed = steps(rng, between, KMH);
            if !speeds.contains(&speed) {
                speeds.push(speed);
            }
        }
        speeds.sort_by(f64::total_cmp);
        speeds
    }
}

impl Angles {
    /// Samples an angle.
    pub(super) fn drawn(&self, rng: &mut impl Rng) -> f32 {
        match self {
            Self::Choice(angles) => angles[rng.random_range(0..angles.len())],
            Self::Between(between) => {
                let degree = f64::from(DEGREE);
                steps(rng, between.map(f64::from), degree) as f32
            }
        }
    }
}
