//! Joint centres from markers on the skin.

use glam::{DMat3, DVec3};

use super::joints::each;
use super::rigid::Rigid;

/// Returns the point at `depth_m` from the marker `at`, in the plane of `at`, `from` and `wand`,
/// where the lines to `at` and to `from` make a right angle, on the side of the line from `from` to
/// `at` that is away from the wand. None if the three lie on a line or `from` is within `depth_m`.
///
/// The chord construction of Plug-in Gait, after Kadaba, Ramakrishnan & Wootten (1990),
/// "Measurement of lower extremity kinematics during level walking", J. Orthop. Res. 8:383-392,
/// and Davis et al. (1991): `from` is the joint centre above, `wand` the marker of the segment.
pub(super) fn chord(wand: DVec3, from: DVec3, at: DVec3, depth_m: f64) -> Option<DVec3> {
    let line = from - at;
    let length = line.length();
    if length <= depth_m {
        return None;
    }
    let along = line / length;
    let aside = (wand - at).reject_from_normalized(along).try_normalize()?;
    let cos = depth_m / length;
    let sin = libm::sqrt(1.0 - cos * cos);
    Some(at + depth_m * (cos * along - sin * aside))
}

/// The point to which a [`shared_centre`] is drawn where the motion does not determine it.
#[derive(Clone, Copy)]
pub(super) enum Prior<'a> {
    /// Draws to a point by frame, in all directions.
    Near(&'a [DVec3]),
    /// Draws to a point by frame, along the second vector alone: a hinge's axis.
    Across(&'a [DVec3], &'a [DVec3]),
}

/// Returns the point that two clusters share: where they turn about each other.
///
/// It minimises, in least squares over the frames, the distance between the point as carried by one
/// cluster and by the other, as in the symmetrical centre of rotation of Ehrig et al. (2006), "A
/// survey of formal methods for determining the centre of rotation of ball joints", J. Biomech.
/// 39:2798-2809, but with one point for both. The prior is ours.
pub(super) fn shared_centre(
    upper: &[Rigid],
    lower: &[Rigid],
    prior: Prior<'_>,
) -> Option<Vec<DVec3>> {
    /// Weights of a prior against the motion. Across a hinge it need only break the tie. An ankle
    /// turns by a quarter of a radian, so this counts about as much as the motion. Our choice.
    const ACROSS: f64 = 0.1;
    const NEAR: f64 = 0.3;
    let mut normal = DMat3::ZERO;
    let mut right = DVec3::ZERO;
    let mut add = |row: DVec3, value: f64| {
        normal += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
        right += row * value;
    };
    for (frame, (up, low)) in upper.iter().zip(lower).enumerate() {
        let difference = DMat3::from_quat(up.turn) - DMat3::from_quat(low.turn);
        let shift = low.shift - up.shift;
        for axis in 0..3 {
            add(difference.row(axis), shift[axis]);
        }
        let mut draw = |weight: f64, along: DVec3, to: DVec3| {
            add(
                weight * (up.turn.inverse() * along),
                weight * along.dot(to - up.shift),
            );
        };
        match prior {
            Prior::Near(to) => DVec3::AXES
                .into_iter()
                .for_each(|axis| draw(NEAR, axis, to[frame])),
            Prior::Across(to, left) => draw(ACROSS, left[frame], to[frame]),
        }
    }
    if normal.determinant().abs() < 1e-9 {
        return None;
    }
    let centre = normal.inverse() * right;
    centre.is_finite().then(|| {
        each(upper, lower, |up, low| {
            up.apply(centre).midpoint(low.apply(centre))
        })
    })
}

/// Returns a cluster's motion from its first frame; none if a frame cannot be fitted.
pub(super) fn motion_of(cluster: &[&[DVec3]]) -> Option<Vec<Rigid>> {
    let frames = cluster.first()?.len();
    (0..frames)
        .map(|frame| {
            let pairs: Vec<(DVec3, DVec3)> = cluster
                .iter()
                .map(|track| (track[0], track[frame]))
                .collect();
            Rigid::fit(&pairs)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn the_chord_is_that_of_pycgm() {
        // The two examples in the documentation of pyCGM's findJointC, millimetres.
        for (wand, from, at, depth, expected) in [
            (
                [468.14532471, 325.09780884, 673.12591553],
                [355.90861996, 365.38260964, 940.6974861],
                [452.35180664, 329.0609436, 524.77893066],
                59.5,
                [396.25286248, 347.91367254, 518.63620527],
            ),
            (
                [775.40887891, 788.64742014, 514.4063264],
                [424.5706403, 46.17046141, 305.73130661],
                [618.98284978, 848.86492206, 133.51848843],
                42.5,
                [599.66684491, 843.26056826, 96.07876121],
            ),
        ] {
            let [wand, from, at] = [wand, from, at].map(DVec3::from_array);
            let found = chord(wand, from, at, depth).unwrap();
            assert!(
                found.distance(DVec3::from_array(expected)) < 0.02,
                "{found}"
            );
        }
    }

    #[test]
    fn two_clusters_about_a_hinge_share_its_middle() {
        let centre = DVec3::new(0.1, 0.5, 0.0);
        let still = Rigid {
            turn: DQuat::IDENTITY,
            shift: DVec3::ZERO,
        };
        let upper = vec![still; 40];
        let lower: Vec<Rigid> = (0..40)
            .map(|i| {
                let turn = DQuat::from_rotation_x(0.5 * libm::sin(f64::from(i) * 0.2));
                Rigid {
                    turn,
                    shift: centre - turn * centre,
                }
            })
            .collect();
        let middle = vec![DVec3::new(0.1, 0.0, 0.3); 40];
        let found = shared_centre(&upper, &lower, Prior::Across(&middle, &[DVec3::X; 40])).unwrap();
        assert!(found[7].distance(centre) < 1e-6, "{}", found[7]);
    }
}
