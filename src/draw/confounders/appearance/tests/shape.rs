//! Bodies of another mass, build and age, by ratios of published dimensions.

use super::*;

/// Returns breadth and depth of some joints' hulls within 0.5 mm of a height above the pelvis.
fn spans(walker: &Walker, outfit: &Outfit, joints: &[Joint], height: f64) -> (f64, f64) {
    let standing = RestJoints::from_skeleton(&walker.wearer.skeleton);
    let (min, max) = standing
        .slice(outfit, joints, height - 5e-4..=height + 5e-4)
        .bounds();
    (max.x - min.x, max.z - min.z)
}

#[test]
fn a_man_of_30_percent_more_mass_is_as_much_broader_as_the_regressions_say() {
    let walker = Walker::average(Sex::Male);
    let (heavy, light) = (
        walker.dressed(body_mass, 1.0),
        walker.dressed(body_mass, -1.0),
    );
    let standing = RestJoints::from_skeleton(&walker.wearer.skeleton);
    // ANSUR II's mean man, 1.7562 m and 27.69 kg/m2, has a waist 326.47 mm broad and 237.79 mm
    // deep; each kg/m2 is 7.348 and 7.447 mm more. 30 % more mass is 8.307 kg/m2 more, and as
    // much less is 6.390.
    // Measures the points of the navel's ring, since the convex hull may be broader there.
    let navel = standing.at(Joint::Spine).y - 0.010;
    let of = |outfit: &Outfit| {
        let points = outfit.hulls.iter().flat_map(|hull| &hull.points);
        let places = points
            .filter(|(joint, _)| *joint == Joint::Spine)
            .map(|&point| standing.place(point))
            .filter(|place| (place.y - navel).abs() < 5e-4);
        let (min, max) = places.fold((DVec3::MAX, DVec3::MIN), |(min, max), place| {
            (min.min(place), max.max(place))
        });
        (max.x - min.x, max.z - min.z)
    };
    let (breadth, depth) = of(&walker.outfit);
    for (outfit, more) in [(&heavy, 8.307), (&light, -6.390)] {
        let found = of(outfit);
        let expected = (1.0 + 7.348 * more / 326.47, 1.0 + 7.447 * more / 237.79);
        assert!((found.0 / breadth - expected.0).abs() < 2e-3, "{found:?}");
        assert!((found.1 / depth - expected.1).abs() < 2e-3, "{found:?}");
    }
}

#[test]
fn a_body_of_another_mass_is_the_one_that_is_made_of_that_mass() {
    for sex in [Sex::Male, Sex::Female] {
        let walker = Walker::average(sex);
        let heavy = walker.dressed(body_mass, 1.0);
        let mass_kg = 1.3 * walker.wearer.mass_kg;
        let stature_m = walker.wearer.stature_m;
        let person = Dimensions::expected(stature_m, mass_kg, Some(sex), &[0.0; DIMENSIONS]);
        let person = person.expect("a heavy person");
        // On the skeleton of the lighter person, since the change of mass keeps the joints.
        let offsets = walker.wearer.skeleton.offsets.map(Vec3::as_dvec3);
        let made = crate::people::cohort::body::body(&person, offsets);
        let made = Outfit {
            hulls: made
                .hulls
                .iter()
                .map(|hull| WornHull {
                    part: BodyPart::Body,
                    points: hull
                        .points
                        .iter()
                        .map(|p| (hull.joint, p.as_vec3()))
                        .collect(),
                })
                .collect(),
        };
        let standing = RestJoints::from_skeleton(&walker.wearer.skeleton);
        let at = |joint: Joint, more: f64| standing.at(joint).y + more;
        for (joint, height) in [
            (Joint::Pelvis, at(Joint::Pelvis, -0.02)),
            (Joint::Spine, at(Joint::Spine, 0.0)),
            (Joint::Thorax, at(Joint::Thorax, 0.06)),
            (Joint::LeftThigh, at(Joint::LeftThigh, -0.15)),
            (Joint::LeftShank, at(Joint::LeftShank, -0.12)),
            (Joint::LeftUpperArm, at(Joint::LeftUpperArm, -0.15)),
            (Joint::LeftForearm, at(Joint::LeftForearm, -0.06)),
        ] {
            let found = spans(&walker, &heavy, &[joint], height);
            let expected = spans(&walker, &made, &[joint], height);
            println!("{sex:?} {joint:?}: {found:?}, made {expected:?}");
            for (found, expected) in [(found.0, expected.0), (found.1, expected.1)] {
                assert!(
                    (found - expected).abs() < 0.02,
                    "{joint:?}: {found} {expected}"
                );
            }
        }
    }
}

#[test]
fn a_broad_build_is_two_residual_deviations_broader_at_the_waist() {
    let walker = Walker::average(Sex::Female);
    let standing = RestJoints::from_skeleton(&walker.wearer.skeleton);
    // The navel's ring.
    let height = standing.at(Joint::Spine).y - 0.010;
    let of = |outfit: &Outfit| spans(&walker, outfit, &[Joint::Spine], height).0;
    // ANSUR II's mean woman, 1.6285 m and 25.50 kg/m2: a waist of -84.43 + 119.28 * 1.6285 +
    // 7.455 * 25.50 = 299.92 mm, and a residual deviation of 18.1 mm.
    for strength in [-1.0, 0.5, 1.0] {
        let ratio = of(&walker.dressed(build, strength)) / of(&walker.outfit);
        let expected = 1.0 + 2.0 * 18.1 * strength / 299.92;
        assert!((ratio - expected).abs() < 2e-3, "{ratio} {expected}");
    }
}

#[test]
fn men_lose_5_cm_and_women_8_cm_by_the_age_of_80() {
    for (sex, loss) in [(Sex::Male, 0.05), (Sex::Female, 0.08)] {
        let walker = Walker::average(sex);
        let high = |outfit: &Outfit, skeleton: &Skeleton| {
            let pose = ModelPose::new(skeleton, &Pose::REST);
            let places = posed(outfit, &pose).into_iter().flatten();
            places.map(|place| place.y).fold(f32::MIN, f32::max)
        };
        let before = high(&walker.outfit, &walker.wearer.skeleton);
        let aged = walker.wearer.aged(1.0);
        let after = high(&walker.dressed(age_body, 1.0), &aged.skeleton);
        assert!((before - after - loss).abs() < 1e-4, "{}", before - after);
        let lost = walker.wearer.stature_m - aged.stature_m;
        assert!((lost - f64::from(loss)).abs() < 1e-6);
    }
}
