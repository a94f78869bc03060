//! How a leg swings from one stance to the next.

use std::f64::consts::PI;

/// The minimum flexion of a knee, radians. Our choice: 5 degrees, since a straight knee jerks.
pub(super) const LEAST_KNEE: f64 = 0.09;

/// How much further the toes are raised late in a walker's swing, radians. Our choice: after 95 % of
/// the cycle the norm's angles raise them by 17 degrees, recorded walkers of four laboratories by 19
/// to 30.
pub(super) const LATE_TOES: f64 = 0.062;
/// 7^7 / 6^6, by which the late curve is 1 at its greatest.
const LATE_SCALE: f64 = 17.651_384_602_194_79;

/// A leg in polar coordinates about its hip.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polar {
    /// Flexion of the knee, radians.
    pub knee: f64,
    /// Angle of the ankle ahead of straight down, seen from the hip, radians.
    pub ahead: f64,
    /// The ankle's place to the side, metres.
    pub side_m: f64,
    /// How far the toes are raised, radians.
    pub pitch: f64,
}

impl Polar {
    pub(super) fn map2(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            knee: of(self.knee, other.knee),
            ahead: of(self.ahead, other.ahead),
            side_m: of(self.side_m, other.side_m),
            pitch: of(self.pitch, other.pitch),
        }
    }
}

/// The correction of a swing between the end of one stance and the beginning of the next: curves
/// that are added to the leg that the angles give, and a lift.
#[derive(Clone, Copy, Debug)]
pub(super) struct Swing {
    /// Offsets at both ends.
    pub ends: [Polar; 2],
    /// Slopes of the offsets at both ends, over the whole swing.
    pub speeds: [Polar; 2],
    /// How much further the toes are raised in the middle, and late, radians.
    pub toes_up: f64,
    pub late_toes: f64,
    /// By how much the leg is shorter in the middle, metres.
    pub lift_m: f64,
}

impl Polar {
    const ZERO: Self = Self {
        knee: 0.0,
        ahead: 0.0,
        side_m: 0.0,
        pitch: 0.0,
    };
}

impl Swing {
    pub(super) const NONE: Self = Self {
        ends: [Polar::ZERO; 2],
        speeds: [Polar::ZERO; 2],
        toes_up: 0.0,
        late_toes: 0.0,
        lift_m: 0.0,
    };

    /// Returns the offset at a share of the swing: the cubic Hermite curve of the ends, and slopes
    /// that decay with the fifth power, so that they act only at the ends (our choice).
    pub(super) fn at(&self, share: f64) -> Polar {
        let (t, rest) = (share, 1.0 - share);
        let power = |share: f64| share * share * share * share * share;
        let weights = [
            (1.0 + 2.0 * t) * rest * rest,
            t * power(rest),
            t * t * (3.0 - 2.0 * t),
            -power(t) * rest,
        ];
        let [first, last] = self.ends;
        let [leaving, landing] = self.speeds;
        [first, leaving, last, landing]
            .into_iter()
            .zip(weights)
            .fold(Polar::ZERO, |sum, (value, weight)| {
                sum.map2(value, |sum, value| sum + weight * value)
            })
    }

    /// Returns how far a foot has risen at a share of the swing, 0..1.
    pub(super) fn rise(share: f64) -> f64 {
        // Greatest before the middle: toes are lowest after a third of the swing.
        libm::sin(PI * libm::pow(share, 0.8))
    }

    /// Returns how much shorter the leg is at a share of the swing, metres, and how much further the
    /// toes are raised, radians. `rise` is [`Swing::rise`] there.
    pub(super) fn lift(&self, share: f64, rise: f64) -> (f64, f64) {
        // Greatest at 6/7 of the swing.
        let cubed = share * share * share;
        let late = LATE_SCALE * cubed * cubed * (1.0 - share);
        let toes_up = self.toes_up * rise * rise + self.late_toes * late;
        (self.lift_m * rise * rise, toes_up)
    }
}

/// Returns a knee's flexion, radians, limited to at least [`LEAST_KNEE`] by a smooth maximum.
pub(super) fn floored(knee: f64) -> f64 {
    let above = knee - LEAST_KNEE;
    LEAST_KNEE + 0.5 * (above + libm::sqrt(above * above + 0.05 * 0.05))
}

/// Returns the least value in a range that is not `too_little`, by bisection.
pub(super) fn least((mut low, mut high): (f64, f64), too_little: impl Fn(f64) -> bool) -> f64 {
    if !too_little(low) {
        return low;
    }
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        if too_little(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swing_begins_and_ends_with_what_it_is_given() {
        let polar = |knee| Polar {
            knee,
            ..Polar::ZERO
        };
        let swing = Swing {
            ends: [polar(0.3), polar(-0.2)],
            speeds: [polar(2.0), polar(1.0)],
            ..Swing::NONE
        };
        assert!((swing.at(0.0).knee - 0.3).abs() < 1e-12);
        assert!((swing.at(1.0).knee + 0.2).abs() < 1e-12);
        // Its slopes, by differences.
        let slope = |share: f64| (swing.at(share + 1e-6).knee - swing.at(share - 1e-6).knee) / 2e-6;
        assert!((slope(0.0) - 2.0).abs() < 1e-4, "{}", slope(0.0));
        assert!((slope(1.0) - 1.0).abs() < 1e-4, "{}", slope(1.0));
    }

    #[test]
    fn toes_are_raised_late_and_land_as_they_would() {
        let swing = Swing {
            late_toes: 0.5,
            ..Swing::NONE
        };
        let raised = |share| swing.lift(share, 0.0).1;
        assert!((raised(6.0 / 7.0) - 0.5).abs() < 1e-12);
        assert!(raised(0.5) < 0.08 && raised(1.0) == 0.0);
    }

    #[test]
    fn a_knee_never_falls_below_the_least_and_is_itself_far_above() {
        assert!(floored(-1.0) > LEAST_KNEE);
        assert!((floored(1.0) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn bisection_finds_where_enough_begins() {
        assert!((least((0.0, 4.0), |value| value * value < 2.0) - 2f64.sqrt()).abs() < 1e-5);
        assert!((least((3.0, 4.0), |value| value < 2.0) - 3.0).abs() < 1e-12);
    }
}
