//! What a design leaves to chance: drawn for each person or cycle from the seed, whatever else is
//! made.

use super::{Angles, Speeds};
use crate::sweep::Job;
use edgegait_core::format::crc32;
use edgegait_core::pack::Pack;
use rand::{Rng, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Streams of people's own draws begin here; bodies and clothes have others.
const PEOPLE: u64 = 1 << 62;
/// Streams of cycles' draws begin here.
const CYCLES: u64 = 3 << 62;
/// Steps of an age in a year, of a speed in a km/h, and of an angle in a degree: results state
/// what is drawn exactly.
const YEAR: f64 = 1.0;
const KMH: f64 = 10.0;
const DEGREE: f32 = 8.0;

/// What draws for the person of a number.
pub(super) fn of_person(seed: u64, number: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(PEOPLE | number as u64);
    rng
}

/// What draws for a cycle, by the names of who walks and of the walk, as variations are drawn. All
/// conditions have the same viewpoints.
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

/// A whole number of steps from one to the other, each as likely.
fn steps(rng: &mut impl Rng, [low, high]: [f64; 2], steps: f64) -> f64 {
    let (low, high) = ((low * steps).ceil(), (high * steps).floor());
    let count = (high - low).max(0.0) as u32;
    (low + f64::from(rng.random_range(0..=count))) / steps
}

/// An age, years.
pub(super) fn years(rng: &mut impl Rng, between: [f64; 2]) -> f64 {
    steps(rng, between, YEAR)
}

impl Speeds {
    /// How many different ones there are.
    pub(super) fn count(between: [f64; 2]) -> usize {
        let [low, high] = between;
        ((high * KMH).floor() - (low * KMH).ceil()).max(-1.0) as usize + 1
    }

    /// The slowest and the fastest, or all.
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

    /// One person's, slowest first, each once.
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
    /// One of them.
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
