//! The size of a source's unit in metres, from the length of the legs.
//!
//! Files state no unit or a wrong one, and people's legs differ less than units do.

use crate::import::{Motion, MotionFormat};
use crate::people::retarget::joint_roles::JointRoles;

/// Possible hip-to-ankle lengths of a walker, metres: a small child to a giant (measured clips:
/// 0.59 to 0.99 from the pelvis).
const LEG_M: std::ops::RangeInclusive<f64> = 0.42..=1.15;

/// Hip-to-ankle length to which the chosen unit comes nearest when several fit, metres.
const USUAL_LEG_M: f64 = 0.8;

/// Hip-to-ankle lengths of usual walkers, metres: statures of 1.37 to 2.20 m. Outside of them, an
/// assumed unit is doubted.
const USUAL_LEGS_M: std::ops::RangeInclusive<f64> = 0.65..=1.05;

/// A unit: its size in metres, and its name.
type Unit = (f64, &'static str);

/// The units of motion files.
const UNITS: [Unit; 7] = [
    (1.0, "metre"),
    (0.01, "centimetre"),
    (0.001, "millimetre"),
    (0.0254, "inch"),
    (0.3048, "foot"),
    (0.1, "decimetre"),
    (0.08, "MikuMikuDance unit of 8 cm"),
];

/// The units of ASF files and of conversions of them, which keep the numbers of CMU's skeletons.
const ACCLAIM_UNITS: [Unit; 6] = [
    UNITS[0],
    UNITS[1],
    UNITS[2],
    UNITS[3],
    (0.0254 / 0.45, "0.45-inch ASF unit"),
    UNITS[4],
];

/// The units that a file may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::people) enum UnitFamily {
    /// An Acclaim skeleton or a conversion of one.
    Acclaim,
    /// Any other file.
    Other,
}

impl UnitFamily {
    /// Returns the family of a motion. Conversions of Acclaim skeletons keep the names of CMU's
    /// bones, of which no other maker has hip joints or femurs beside a lower back.
    pub(in crate::people) fn from_motion(motion: &Motion) -> Self {
        let has = |name: &str| {
            let mut joints = motion.joints.iter();
            joints.any(|joint| joint.name.eq_ignore_ascii_case(name))
        };
        let is_converted = has("lhipjoint") && has("rhipjoint") || has("lfemur") && has("rfemur");
        match is_converted || motion.format == MotionFormat::AsfAmc {
            true => Self::Acclaim,
            false => Self::Other,
        }
    }

    const fn units(self) -> &'static [Unit] {
        match self {
            Self::Acclaim => &ACCLAIM_UNITS,
            Self::Other => &UNITS,
        }
    }
}

/// Returns the length from hip to knee to ankle, the longer of both sides, source units.
pub(in crate::people) fn leg_of(motion: &Motion, roles: &JointRoles) -> f64 {
    let (points, _) = motion.globals(motion.frames.len() / 2);
    (0..2)
        .map(|side| {
            let (hip, knee, ankle) = (roles.thigh[side], roles.shank[side], roles.foot[side]);
            points[hip].distance(points[knee]) + points[knee].distance(points[ankle])
        })
        .fold(0.0, f64::max)
}

/// Returns the metres in one source unit: the unit that gives human legs, the stated one first.
/// `leg` is their length from hip to ankle, source units.
///
/// A warning names an assumed unit and the length that it gives the legs, if another is possible or
/// the length is unusual.
pub(in crate::people) fn choose_unit(
    leg: f64,
    stated: Option<f64>,
    family: UnitFamily,
    warnings: &mut Vec<String>,
) -> Result<f64, String> {
    if let Some(unit) = stated {
        if LEG_M.contains(&(leg * unit)) {
            return Ok(unit);
        }
        warnings.push(format!(
            "the stated unit makes the legs {:.2} m long: it is not used",
            leg * unit
        ));
    }
    let units = family.units().iter().copied();
    let mut fitting: Vec<Unit> = units
        .filter(|(unit, _)| LEG_M.contains(&(leg * unit)))
        .collect();
    let misfit = |unit: f64| libm::log(leg * unit / USUAL_LEG_M).abs();
    fitting.sort_by(|a, b| misfit(a.0).total_cmp(&misfit(b.0)));
    let legs_m = |unit: f64| format!("legs of {:.2} m", leg * unit);
    match fitting.as_slice() {
        [] => Err(format!(
            "no known unit gives legs of {leg:.3} units a human length"
        )),
        [(unit, name)] => {
            if !USUAL_LEGS_M.contains(&(leg * unit)) {
                warnings.push(format!(
                    "the unit is taken as the {name}, which gives {}: is that the walker's size?",
                    legs_m(*unit)
                ));
            }
            Ok(*unit)
        }
        [(unit, name), (other_unit, other), ..] => {
            warnings.push(format!(
                "the unit is the {name} ({}) or the {other} ({}): {name} assumed, which is nearer to a usual adult",
                legs_m(*unit),
                legs_m(*other_unit)
            ));
            Ok(*unit)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the unit of legs of this length, and the warning.
    fn chosen(leg: f64, family: UnitFamily) -> (f64, String) {
        let mut warnings = Vec::new();
        let unit = choose_unit(leg, None, family, &mut warnings).expect("a unit");
        (unit, warnings.join("; "))
    }

    #[test]
    fn legs_of_an_adult_give_each_unit() {
        for (unit, _) in UNITS {
            for leg_m in [0.75, 0.8, 0.84, 0.88] {
                let (found, _) = chosen(leg_m / unit, UnitFamily::Other);
                assert_eq!(found, unit, "{leg_m} m in units of {unit} m");
            }
        }
        let (found, warning) = chosen(0.75 / 0.0254 * 0.45, UnitFamily::Acclaim);
        assert_eq!((found, warning.as_str()), (0.0254 / 0.45, ""));
    }

    #[test]
    fn an_assumed_unit_is_named_if_another_fits_or_the_legs_are_unusual() {
        assert_eq!(chosen(84.0, UnitFamily::Other).1, "");
        assert_eq!(
            chosen(8.4, UnitFamily::Other).1,
            "the unit is the decimetre (legs of 0.84 m) or the MikuMikuDance unit of 8 cm (legs of 0.67 m): decimetre assumed, which is nearer to a usual adult"
        );
        assert_eq!(
            chosen(0.6, UnitFamily::Other).1,
            "the unit is taken as the metre, which gives legs of 0.60 m: is that the walker's size?"
        );
        assert_eq!(chosen(110.0, UnitFamily::Other).0, 0.01);
    }
}
