//! The doses of a condition for one cycle of a walk, sampled where the condition is random.

use super::dose::{Dose, Doses};
use super::random_strength::{Per, RandomDose};
use super::{Condition, ConfounderKind, Stage};
use crate::people::variation::{CYCLES_OF_A_TAKE, CycleSeed};
use edgegait_core::format::crc32;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// The doses for one cycle, and the source of their random numbers.
#[derive(Clone, Debug)]
pub struct DosePlan {
    doses: Doses,
    seed: u64,
    of: CycleSeed,
}

impl DosePlan {
    /// Samples the doses of `condition` for a cycle; without a condition there are none.
    #[must_use]
    pub fn new(condition: Option<&Condition>, of: CycleSeed) -> Self {
        let mut plan = Self {
            doses: Doses::default(),
            seed: condition.map_or(0, |condition| condition.seed),
            of,
        };
        if let Some(condition) = condition {
            let draws = condition.draws(plan.choice());
            plan.doses = Doses::new(draws.into_iter().map(|draw| plan.drawn(draw)));
        }
        plan
    }

    /// Samples one confounder's dose for this cycle.
    fn drawn(&self, draw: &RandomDose) -> Dose {
        let name = u64::from(crc32(draw.kind.confounder().name.as_bytes())) << 32;
        let of = &self.of;
        let parts = match draw.per {
            Per::Person => [of.subject, 0, name],
            Per::Take => [of.subject, of.walk, name | u64::from(take_of(of.variation))],
            Per::Cycle => [of.subject, of.walk, name | u64::from(of.variation)],
        };
        // Viewpoints use the other streams.
        draw.dose(&mut self.draws(parts, u64::MAX))
    }

    /// Samples a person's choice among alternatives, which does not depend on the walk.
    fn choice(&self) -> usize {
        self.draws([self.of.subject, 0, 0], 0).random::<u32>() as usize
    }

    /// Returns the strength of a confounder, or `None` if it changes nothing.
    #[must_use]
    pub fn strength(&self, kind: ConfounderKind) -> Option<f64> {
        self.doses.strength(kind)
    }

    /// Returns the amount of a confounder in the catalogue's unit, or `None` if it changes nothing
    /// or has no unit.
    #[must_use]
    pub fn amount(&self, kind: ConfounderKind) -> Option<f64> {
        let unit = kind.confounder().unit?;
        Some(self.strength(kind)? * unit.full)
    }

    /// Returns whether any confounder acts at a stage.
    #[must_use]
    pub fn acts_at(&self, stage: Stage) -> bool {
        let mut doses = self.doses.list().iter();
        doses.any(|dose| dose.kind.confounder().stage == stage)
    }

    /// Returns the doses in the order of application.
    #[must_use]
    pub const fn doses(&self) -> &Doses {
        &self.doses
    }

    /// Returns the random numbers of a confounder for the whole cycle, the same for all viewpoints.
    #[must_use]
    pub fn of_cycle(&self, kind: ConfounderKind) -> ChaCha8Rng {
        let name = u64::from(crc32(kind.confounder().name.as_bytes()));
        let variation = u64::from(self.of.variation);
        self.draws([self.of.subject, self.of.walk, name << 32 | variation], 0)
    }

    /// Returns the random numbers of a confounder for one viewpoint, the same for all frames.
    #[must_use]
    pub fn of_view(
        &self,
        kind: ConfounderKind,
        (azimuth_deg, elevation_deg): (f32, f32),
    ) -> ChaCha8Rng {
        let mut rng = self.of_cycle(kind);
        let bits = |angle: f32| u64::from((angle + 0.0).to_bits());
        rng.set_stream(1 + (bits(azimuth_deg) << 32 | bits(elevation_deg)) % (u64::MAX - 1));
        rng
    }

    /// Returns the random numbers of a confounder for one frame from one viewpoint.
    #[must_use]
    pub fn of_picture(&self, kind: ConfounderKind, view: (f32, f32), frame: u32) -> ChaCha8Rng {
        let mut rng = self.of_view(kind, view);
        // 2^32 words a frame: more than any effect uses.
        rng.set_word_pos(u128::from(frame + 1) << 32);
        rng
    }

    fn draws(&self, parts: [u64; 3], stream: u64) -> ChaCha8Rng {
        let mut key = [0; 32];
        // Combines the seeds of settings and condition; the factor is 2^64 / phi.
        let seed = self.of.seed ^ self.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        for (bytes, part) in key
            .chunks_exact_mut(8)
            .zip([[seed].as_slice(), &parts].concat())
        {
            bytes.copy_from_slice(&part.to_le_bytes());
        }
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(stream);
        rng
    }
}

/// Returns the take that a variation belongs to.
const fn take_of(variation: u32) -> u32 {
    variation / CYCLES_OF_A_TAKE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::confounders::Conditions;
    use std::path::Path;

    fn cycle_seed(subject: u64, variation: u32) -> CycleSeed {
        CycleSeed {
            seed: 1,
            subject,
            walk: 9,
            variation,
        }
    }

    fn bag() -> Condition {
        let one = |kind| {
            let dose = Dose {
                kind,
                strength: 1.0,
            };
            Doses::new([dose]).into()
        };
        Condition {
            one_of: vec![one(ConfounderKind::Backpack), one(ConfounderKind::Suitcase)],
            ..Condition::from_doses(Doses::default())
        }
    }

    #[test]
    fn a_person_has_the_same_choice_in_all_cycles_and_people_differ() {
        let bag = bag();
        let choice = |subject, cycle| {
            DosePlan::new(Some(&bag), cycle_seed(subject, cycle)).strength(ConfounderKind::Backpack)
        };
        let first: Vec<_> = (0..40).map(|subject| choice(subject, 0)).collect();
        let other: Vec<_> = (0..40).map(|subject| choice(subject, 7)).collect();
        assert_eq!(first, other);
        let with_backpack = first.iter().filter(|strength| strength.is_some()).count();
        assert!((10..=30).contains(&with_backpack), "{with_backpack}");
    }

    #[test]
    fn draws_depend_on_confounder_cycle_view_frame_and_seed_and_on_nothing_else() {
        let plan = |cycle| DosePlan::new(Some(&bag()), cycle_seed(3, cycle));
        let first = |mut rng: ChaCha8Rng| rng.random::<u64>();
        let view = (90.0, 0.0);
        let draws = [
            first(plan(0).of_cycle(ConfounderKind::Holes)),
            first(plan(1).of_cycle(ConfounderKind::Holes)),
            first(plan(0).of_cycle(ConfounderKind::Light)),
            first(plan(0).of_view(ConfounderKind::Holes, view)),
            first(plan(0).of_view(ConfounderKind::Holes, (0.0, 0.0))),
            first(plan(0).of_picture(ConfounderKind::Holes, view, 0)),
            first(plan(0).of_picture(ConfounderKind::Holes, view, 1)),
        ];
        for (at, draw) in draws.iter().enumerate() {
            assert!(!draws[..at].contains(draw), "{at}");
        }
        assert_eq!(
            first(plan(0).of_view(ConfounderKind::Holes, view)),
            draws[3]
        );
        let mut seeded = bag();
        seeded.seed = 1;
        let other = DosePlan::new(Some(&seeded), cycle_seed(3, 0));
        assert_ne!(first(other.of_cycle(ConfounderKind::Holes)), draws[0]);
    }

    #[test]
    fn strengths_are_drawn_for_a_person_a_take_or_a_cycle() {
        let text = "[[conditions]]\nname = 'a'\nconfounders = { coat = { uniform = [0.1, 1], per = 'person' }, hat = { uniform = [0.1, 1], per = 'take' }, hair = { uniform = [0.1, 1] } }";
        let conditions = Conditions::parse(Path::new("c.toml"), text).expect("a condition");
        let drawn = |subject, walk, variation| {
            let of = CycleSeed {
                walk,
                ..cycle_seed(subject, variation)
            };
            let plan = DosePlan::new(Some(&conditions.list[0]), of);
            [
                ConfounderKind::Coat,
                ConfounderKind::Hat,
                ConfounderKind::Hair,
            ]
            .map(|kind| plan.strength(kind))
        };
        let same = |a: [Option<f64>; 3], b: [Option<f64>; 3]| [0, 1, 2].map(|at| a[at] == b[at]);
        let first = drawn(3, 9, 0);
        assert_eq!(same(first, drawn(3, 9, 0)), [true; 3]);
        assert_eq!(same(first, drawn(3, 9, 7)), [true, true, false]);
        assert_eq!(same(first, drawn(3, 9, 8)), [true, false, false]);
        assert_eq!(same(first, drawn(3, 10, 0)), [true, false, false]);
        assert_eq!(same(first, drawn(4, 9, 0)), [false; 3]);
        // Confounders have different random numbers.
        assert!(first[0] != first[1] && first[1] != first[2]);
    }
}
