//! The size of a source's unit in metres, from the length of the legs.
//!
//! Files state no unit or a wrong one, and people's legs differ less than units do.

use crate::import::Motion;
use crate::people::retarget::joint_roles::JointRoles;

/// Possible hip-to-ankle lengths of a walker, metres: a small child to a giant (measured clips:
/// 0.59 to 0.99 from the pelvis).
const LEG_M: std::ops::RangeInclusive<f64> = 0.42..=1.15;

/// Hip-to-ankle length to which the chosen unit comes nearest when several fit, metres.
const USUAL_LEG_M: f64 = 0.8;

/// The units of motion files: their size in metres and their names.
const UNITS: [(f64, &str); 6] = [
    (1.0, "metre"),
    (0.01, "centimetre"),
    (0.001, "millimetre"),
    (0.0254, "inch"),
    (0.0254 / 0.45, "0.45-inch ASF unit"),
    (0.3048, "foot"),
];

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
pub(in crate::people) fn choose_unit(
    leg: f64,
    stated: Option<f64>,
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
    let mut fitting: Vec<(f64, &str)> = UNITS
        .into_iter()
        .filter(|(unit, _)| LEG_M.contains(&(leg * unit)))
        .collect();
    let misfit = |unit: f64| libm::log(leg * unit / USUAL_LEG_M).abs();
    fitting.sort_by(|a, b| misfit(a.0).total_cmp(&misfit(b.0)));
    match fitting.as_slice() {
        [] => Err(format!(
            "no known unit gives legs of {leg:.3} units a human length"
        )),
        [(unit, _)] => Ok(*unit),
        [(unit, name), (_, other), ..] => {
            warnings.push(format!(
                "the unit is the {name} or the {other}: {name} assumed"
            ));
            Ok(*unit)
        }
    }
}
