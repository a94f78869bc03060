//! What people wear, drawn.
//!
//! Nobody has measured how often which cut is seen from how far away it stands: the shares here
//! are ours. They are near what is annotated of pedestrians in PETA (Deng et al. 2014: long hair
//! 24 %, shorts 4 %, short skirts 5 % of all images; recalled, not checked), with more of what
//! changes an outline.

use crate::scene::wear::{
    Ease, Outfit, Wearer, clothes, coat, hair, shoes, short_hair, skirt, wide_trousers,
};
use crate::scene::{Body, BodyHull};
use edgegait_core::clothes::{Clothes, Fit, Legs};
use edgegait_core::pack::Sex;
use edgegait_core::skeleton::Skeleton;
use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// How often people change their clothes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dressing {
    /// Never: they are a part of the person.
    ForGood,
    /// For each take.
    PerTake,
}

/// How likely clothes are tight, or tight or normal; the others are loose.
const FITS: [f64; 2] = [0.25, 0.75];
/// How far they stand away from trunk, upper arms, forearms, thighs and shanks, metres, by fit.
/// People differ from it by a quarter.
const EASES_M: [[f64; 5]; 3] = [
    [0.004, 0.004, 0.003, 0.004, 0.005],
    [0.011, 0.010, 0.005, 0.010, 0.014],
    [0.020, 0.018, 0.010, 0.018, 0.026],
];
const EASE_SPREAD: f64 = 0.25;
/// How likely sleeves are short, and a coat is worn, and how strong it is then.
const SHORT_SLEEVES: f64 = 0.3;
const COAT: f64 = 0.12;
const COATS: [f64; 2] = [0.5, 1.0];
/// How likely a woman wears a skirt, and somebody else shorts, or wide trousers.
const SKIRT: f64 = 0.22;
const SKIRTS: [f64; 2] = [0.35, 1.0];
const SHORTS: f64 = 0.07;
const WIDE_TROUSERS: f64 = 0.15;
const WIDTHS: [f64; 2] = [0.3, 1.0];
/// How far shorts stand away from the thighs at the hips and above the knees, metres.
const SHORTS_M: [f64; 2] = [0.012, 0.030];
/// Stockings, metres.
const STOCKINGS_M: f64 = 0.002;
/// How likely women and men have long hair, how strong it is, and how thick short hair is, metres.
const LONG_HAIR: [f64; 2] = [0.6, 0.06];
const LONG_HAIRS: [f64; 2] = [0.3, 1.0];
const SHORT_HAIRS_M: [f64; 2] = [0.004, 0.022];
/// How strong shoes of women and men are: their heels differ.
const SHOES: [[f64; 2]; 2] = [[0.2, 1.0], [0.3, 0.9]];

/// What one person wears.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Worn {
    /// In short.
    pub clothes: Clothes,
    ease: Ease,
    /// Strengths, as of the confounders of these names; 0 without.
    wide_trousers: f64,
    skirt: f64,
    coat: f64,
    long_hair: f64,
    shoes: f64,
    short_hair_m: f64,
}

impl Worn {
    /// Draws as many numbers whatever comes out, so that each garment depends on its own alone.
    pub(super) fn random(rng: &mut ChaCha8Rng, sex: Sex) -> Self {
        let mut share = || rng.random::<f64>();
        let woman = usize::from(sex == Sex::Male);
        let fit = share();
        let (fit, eases) = match FITS.iter().filter(|&&below| fit >= below).count() {
            0 => (Fit::Tight, EASES_M[0]),
            1 => (Fit::Normal, EASES_M[1]),
            _ => (Fit::Loose, EASES_M[2]),
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
                // A coat hides what would hang beneath it.
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

    /// A made body with all of it.
    pub(super) fn put_on(&self, body: &Body, (sex, stature_m, mass_kg): (Sex, f64, f64)) -> Body {
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

/// Makes the sides of a dressed body each other's images, as those of the bare one are: triangles
/// across a flat side are not, and points move along the mean of those beside them.
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
