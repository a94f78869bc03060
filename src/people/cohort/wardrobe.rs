//! Clothes of synthetic people, drawn at random.
//!
//! How often which cut is worn, and how far it stands away, has not been measured: the shares here
//! are ours. They are near the annotations of pedestrians in PETA (Deng et al. 2014: long hair
//! 24 %, shorts 4 %, short skirts 5 % of all images; recalled, not checked), with more garments
//! that change an outline.

use crate::people::clothes::{
    Ease, Outfit, Wearer, clothes, coat, hair, shoes, short_hair, skirt, wide_trousers,
};
use crate::people::{Body, BodyHull};
use edgegait_core::clothes::{Clothes, ClothesFit, Legs};
use edgegait_core::pack::Sex;
use edgegait_core::skeleton::Skeleton;
use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// The occasions on which people change their clothes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dressing {
    /// Never: clothes are a part of the person.
    ForGood,
    /// For each take.
    PerTake,
}

impl Dressing {
    /// Returns the name in flags and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ForGood => "for-good",
            Self::PerTake => "per-take",
        }
    }
}

/// Probabilities that clothes are tight, and tight or normal; others are loose.
const FITS: [f64; 2] = [0.25, 0.75];
/// Distances of clothes from trunk, upper arms, forearms, thighs and shanks, metres, by fit.
/// People differ from them by up to a quarter.
const EASES_M: [[f64; 5]; 3] = [
    [0.004, 0.004, 0.003, 0.004, 0.005],
    [0.011, 0.010, 0.005, 0.010, 0.014],
    [0.020, 0.018, 0.010, 0.018, 0.026],
];
const EASE_SPREAD: f64 = 0.25;
/// Probabilities of short sleeves and of a coat, and the range of a coat's strength.
const SHORT_SLEEVES: f64 = 0.3;
const COAT: f64 = 0.12;
const COATS: [f64; 2] = [0.5, 1.0];
/// Probability of a skirt for women, and of shorts and wide trousers for people without one, with
/// the ranges of a skirt's length and of the trousers' width as strengths.
const SKIRT: f64 = 0.22;
const SKIRTS: [f64; 2] = [0.35, 1.0];
const SHORTS: f64 = 0.07;
const WIDE_TROUSERS: f64 = 0.15;
const WIDTHS: [f64; 2] = [0.3, 1.0];
/// How far shorts stand away from the thighs at the hips and above the knees, metres.
const SHORTS_M: [f64; 2] = [0.012, 0.030];
/// Thickness of stockings, metres.
const STOCKINGS_M: f64 = 0.002;
/// Probabilities of long hair for women and men, and the ranges of its strength and of the
/// thickness of short hair, metres.
const LONG_HAIR: [f64; 2] = [0.6, 0.06];
const LONG_HAIRS: [f64; 2] = [0.3, 1.0];
const SHORT_HAIRS_M: [f64; 2] = [0.004, 0.022];
/// Ranges of the strength of women's and men's shoes, whose heels differ.
const SHOES: [[f64; 2]; 2] = [[0.2, 1.0], [0.3, 0.9]];

/// The clothes of one person.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Worn {
    /// Summary of the clothes.
    pub clothes: Clothes,
    ease: Ease,
    /// Strengths of the confounders of these names; 0 if not worn.
    wide_trousers: f64,
    skirt: f64,
    coat: f64,
    long_hair: f64,
    shoes: f64,
    short_hair_m: f64,
}

impl Worn {
    /// Draws clothes at random. The number of draws is constant, so that each garment depends only
    /// on its own.
    pub(super) fn random(rng: &mut ChaCha8Rng, sex: Sex) -> Self {
        let mut share = || rng.random::<f64>();
        let woman = usize::from(sex == Sex::Male);
        let fit = share();
        let (fit, eases) = match FITS.iter().filter(|&&below| fit >= below).count() {
            0 => (ClothesFit::Tight, EASES_M[0]),
            1 => (ClothesFit::Normal, EASES_M[1]),
            _ => (ClothesFit::Loose, EASES_M[2]),
        };
        let more = 1.0 + EASE_SPREAD * (2.0 * share() - 1.0);
        let [trunk_m, upper_arms_m, forearms_m, thighs_m, shanks_m] = eases.map(|m| m * more);
        let has_short_sleeves = share() < SHORT_SLEEVES;
        let (legs, cut, amount) = (share(), share(), share());
        let is_skirt = sex == Sex::Female && legs < SKIRT;
        let legs = match () {
            () if is_skirt => Legs::Skirt,
            () if cut < SHORTS => Legs::Shorts,
            () => Legs::Trousers,
        };
        let is_wide = legs == Legs::Trousers && cut > 1.0 - WIDE_TROUSERS;
        let (coat, long, thick, heel) = (share() < COAT, share(), share(), share());
        let has_long_hair = long < LONG_HAIR[woman];
        let between = |[least, most]: [f64; 2], share: f64| least + share * (most - least);
        let only = |is_worn: bool, strength: f64| if is_worn { strength } else { 0.0 };
        Self {
            clothes: Clothes {
                fit,
                legs,
                // A coat would hide a skirt beneath it.
                has_coat: coat && !is_skirt,
                has_long_hair,
                has_short_sleeves,
            },
            ease: Ease {
                trunk_m,
                upper_arms_m,
                forearms_m: only(!has_short_sleeves, forearms_m),
                thighs_m: match legs {
                    Legs::Trousers => [thighs_m; 2],
                    Legs::Shorts => SHORTS_M,
                    Legs::Skirt => [STOCKINGS_M; 2],
                },
                shanks_m: match legs {
                    Legs::Trousers => shanks_m,
                    Legs::Shorts => 0.0,
                    Legs::Skirt => STOCKINGS_M,
                },
            },
            wide_trousers: only(is_wide, between(WIDTHS, amount)),
            skirt: only(is_skirt, between(SKIRTS, amount)),
            coat: only(coat && !is_skirt, between(COATS, amount)),
            long_hair: only(has_long_hair, between(LONG_HAIRS, thick)),
            shoes: between(SHOES[woman], heel),
            short_hair_m: only(!has_long_hair, between(SHORT_HAIRS_M, thick)),
        }
    }

    /// Returns a synthetic body in these clothes.
    pub(super) fn put_on(&self, body: &Body, sex: Sex, stature_m: f64, mass_kg: f64) -> Body {
        let wearer = Wearer {
            skeleton: Skeleton {
                offsets: body.offsets.map(DVec3::as_vec3),
            },
            sex: Some(sex),
            stature_m,
            mass_kg,
        };
        let mut outfit = Outfit::of_body(body);
        clothes(&mut outfit, &wearer, &self.ease);
        wide_trousers(&mut outfit, &wearer, self.wide_trousers);
        shoes(&mut outfit, &wearer, self.shoes);
        skirt(&mut outfit, &wearer, self.skirt);
        coat(&mut outfit, &wearer, self.coat);
        short_hair(&mut outfit, &wearer, self.short_hair_m);
        hair(&mut outfit, &wearer, self.long_hair);
        let mut dressed = Body {
            clothes: Some(self.clothes),
            ..outfit.into_body(body)
        };
        make_symmetric(body, &mut dressed);
        dressed
    }
}

/// Makes the sides of a dressed body mirror images of each other, like those of the bare body.
/// Triangles across a flat side are not symmetric, and points moved along the mean normal of the
/// triangles beside them.
fn make_symmetric(bare: &Body, dressed: &mut Body) {
    let image = |point: DVec3| DVec3::new(-point.x, point.y, point.z);
    let left: Vec<BodyHull> = dressed.hulls.clone();
    for (hull, before) in dressed.hulls.iter_mut().zip(&bare.hulls) {
        let joint = hull.joint.mirrored();
        let pairs = left
            .iter()
            .zip(&bare.hulls)
            .filter(|(of, _)| of.joint == joint);
        for (place, at) in hull.points.iter_mut().zip(&before.points) {
            let found = pairs.clone().find_map(|(other, before)| {
                let near = |point: &DVec3| image(*point).distance_squared(*at) < 1e-12;
                other.points.get(before.points.iter().position(near)?)
            });
            if let Some(other) = found {
                *place = 0.5 * (*place + image(*other));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::people::cohort::{CohortOptions, Person, subject};
    use crate::people::{Subject, Track, forward_kinematics};
    use edgegait_core::skeleton::Joint;
    use rand::SeedableRng;
    use std::collections::BTreeSet;

    fn person(dressed: Option<Dressing>, number: usize) -> Subject {
        let options = CohortOptions {
            speeds_kmh: vec![3.0, 5.0, 9.0],
            dressed,
            ..CohortOptions::default()
        };
        subject(&options, number).expect("a person")
    }

    fn drawn(sex: Sex) -> Vec<Worn> {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        (0..4_000).map(|_| Worn::random(&mut rng, sex)).collect()
    }

    #[test]
    fn garments_are_as_frequent_as_is_stated() {
        for (sex, skirts, long_hair) in [(Sex::Female, 0.22, 0.6), (Sex::Male, 0.0, 0.06)] {
            let all = drawn(sex);
            let assert_share = |stated: f64, is_worn: fn(&Worn) -> bool| {
                let found = all.iter().filter(|worn| is_worn(worn)).count() as f64;
                let (count, sd) = (4_000.0, (4_000.0 * stated * (1.0 - stated)).sqrt());
                assert!(
                    (found - count * stated).abs() <= 4.0 * sd,
                    "{found} {stated}"
                );
            };
            assert_share(skirts, |worn| worn.clothes.legs == Legs::Skirt);
            assert_share((1.0 - skirts) * 0.07, |worn| {
                worn.clothes.legs == Legs::Shorts
            });
            assert_share((1.0 - skirts) * 0.12, |worn| worn.clothes.has_coat);
            assert_share((1.0 - skirts) * 0.15, |worn| worn.wide_trousers > 0.0);
            assert_share(long_hair, |worn| worn.clothes.has_long_hair);
            assert_share(0.3, |worn| worn.clothes.has_short_sleeves);
            assert_share(0.25, |worn| worn.clothes.fit == ClothesFit::Tight);
            assert_share(0.5, |worn| worn.clothes.fit == ClothesFit::Normal);
        }
    }

    #[test]
    fn clothes_say_what_is_worn() {
        for worn in [drawn(Sex::Female), drawn(Sex::Male)].concat() {
            let Clothes {
                legs,
                has_coat,
                has_long_hair,
                has_short_sleeves,
                ..
            } = worn.clothes;
            assert_eq!(worn.skirt > 0.0, legs == Legs::Skirt);
            assert_eq!(worn.coat > 0.0, has_coat);
            assert_eq!(worn.long_hair > 0.0, has_long_hair);
            assert_eq!(worn.short_hair_m > 0.0, !has_long_hair);
            assert_eq!(worn.ease.forearms_m == 0.0, has_short_sleeves);
            assert_eq!(worn.ease.shanks_m == 0.0, legs == Legs::Shorts);
            assert!(!(has_coat && legs == Legs::Skirt));
            let strengths = [worn.wide_trousers, worn.skirt, worn.coat, worn.long_hair];
            assert!(
                strengths
                    .iter()
                    .all(|strength| (0.0..=1.0).contains(strength))
            );
            assert!((0.2..=1.0).contains(&worn.shoes));
        }
    }

    #[test]
    fn clothes_are_for_good_or_for_a_take() {
        let (mut kinds, mut changes) = (BTreeSet::new(), 0);
        for number in 0..12 {
            let bare = person(None, number);
            let for_good = person(Some(Dressing::ForGood), number);
            let per_take = person(Some(Dressing::PerTake), number);
            assert!(bare.body.clothes.is_none() && bare.body.draped.is_empty());
            let own = for_good.body.clothes.expect("a dressed person");
            assert_eq!(per_take.body.clothes, Some(own));
            kinds.insert(own.bits());
            for (take, (kept, changed)) in for_good.walks.iter().zip(&per_take.walks).enumerate() {
                assert!(kept.worn.is_none());
                assert_eq!(changed.worn.is_some(), take > 0);
                if let Some(worn) = &changed.worn {
                    assert_eq!(worn.offsets, bare.body.offsets);
                    changes += usize::from(worn.clothes != Some(own));
                }
            }
        }
        assert!(kinds.len() > 6 && changes > 12, "{kinds:?} {changes}");
    }

    /// Returns how far a hull reaches in a direction.
    fn support(hull: &BodyHull, direction: DVec3) -> f64 {
        let along = hull.points.iter().map(|point| point.dot(direction));
        along.fold(f64::MIN, f64::max)
    }

    #[test]
    fn the_body_is_inside_and_both_sides_are_images() {
        let mut draped = BTreeSet::new();
        for number in 0..40 {
            let bare = Person::of_cohort(3, number).expect("a person").body;
            let options = CohortOptions {
                seed: 3,
                speeds_kmh: vec![5.0],
                dressed: Some(Dressing::ForGood),
                ..CohortOptions::default()
            };
            let body = subject(&options, number).expect("a person").body;
            assert_eq!(body.hulls.len(), bare.hulls.len());
            for (hull, before) in body.hulls.iter().zip(&bare.hulls) {
                assert_eq!(hull.joint, before.joint);
                for step in 0..200 {
                    let (turn, up) = (2.4 * f64::from(step), f64::from(step) / 100.0 - 0.995);
                    let level = (1.0 - up * up).sqrt();
                    let way = DVec3::new(level * turn.cos(), up, level * turn.sin());
                    let grown = support(hull, way) - support(before, way);
                    assert!((-0.001..0.15).contains(&grown), "{:?} {grown}", hull.joint);
                }
                let other = body
                    .hulls
                    .iter()
                    .find(|of| of.joint == hull.joint.mirrored());
                let other = other.expect("the other side");
                for point in &hull.points {
                    let image = DVec3::new(-point.x, point.y, point.z);
                    let off = other.points.iter().map(|p| p.distance(image));
                    assert!(off.fold(f64::MAX, f64::min) < 1e-9, "{:?}", hull.joint);
                }
            }
            for parts in &body.draped {
                draped.insert(parts.iter().map(|part| part.joint).collect::<Vec<_>>());
            }
        }
        // Hair, and a skirt or a coat that hangs over the knees.
        let legs = [
            Joint::LeftThigh,
            Joint::LeftShank,
            Joint::RightThigh,
            Joint::RightShank,
        ];
        let long: Vec<Joint> = [Joint::Spine, Joint::Pelvis]
            .into_iter()
            .chain(legs)
            .collect();
        assert!(draped.contains(&vec![Joint::Head, Joint::Thorax]));
        assert!(draped.contains(&long), "{draped:?}");
    }

    #[test]
    fn shoes_are_on_the_floor() {
        // The lowest point of both feet, over a cycle at 5 km/h.
        let lowest = |subject: &Subject| {
            let Track::Loop(cycle) = &subject.walks[1].motion else {
                panic!("a take");
            };
            let frames = cycle.root.iter().zip(&cycle.rotations);
            let lows = frames.map(|(root, rotations)| {
                let (places, turns) = forward_kinematics(&subject.body.offsets, *root, rotations);
                let feet = subject.body.hulls.iter();
                let feet =
                    feet.filter(|hull| matches!(hull.joint, Joint::LeftFoot | Joint::RightFoot));
                let heights = feet.flat_map(|hull| {
                    let at = hull.joint.index();
                    let points = hull.points.iter();
                    points.map(move |point| (places[at] + turns[at] * *point).y)
                });
                heights.fold(f64::MAX, f64::min)
            });
            lows.collect::<Vec<f64>>()
        };
        for number in 0..8 {
            let lows = lowest(&person(Some(Dressing::ForGood), number));
            let bare = lowest(&person(None, number));
            let mean = |lows: &[f64]| lows.iter().sum::<f64>() / lows.len() as f64;
            let least = lows.iter().copied().fold(f64::MAX, f64::min);
            assert!((mean(&lows) - mean(&bare)).abs() < 0.004, "{number}");
            assert!(least > -0.015, "{number}: {least}");
        }
    }
}
