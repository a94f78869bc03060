//! Measuring the dimensions of a statue as ANSUR II defines them (Hotzman et al. 2011, "Measurer's
//! Handbook", NATICK/TR-11/017).

use super::statue::{Statue, extent, levels};
use edgegait::people::cohort::anthropometry::Dimensions;
use edgegait_core::pack::Sex;
use edgegait_core::skeleton::Joint::{self, *};

/// One dimension of one body.
pub struct Measured {
    pub name: &'static str,
    pub asked_m: f64,
    pub found_m: f64,
    /// The share of the dimension that a walking body should have: 1, except for flexed muscles and
    /// stretched hands.
    pub share: f64,
}

impl Measured {
    /// Returns the relative error.
    pub fn error(&self) -> f64 {
        self.found_m / (self.share * self.asked_m) - 1.0
    }
}

const X: usize = 0;
const Y: usize = 1;
const Z: usize = 2;
/// The parts that calipers on the trunk touch, with the arms held away.
const TRUNK: [Joint; 5] = [Pelvis, Spine, Thorax, LeftThigh, RightThigh];
const SHOULDERS: [Joint; 5] = [
    Thorax,
    LeftClavicle,
    RightClavicle,
    LeftUpperArm,
    RightUpperArm,
];

/// Measures all dimensions, in the order of [`Dimensions`]' fields.
pub fn measure(statue: &Statue, d: &Dimensions, sex: Sex) -> Vec<Measured> {
    let mut all = Vec::new();
    let mut add = |name, asked_m, share, found_m| {
        all.push(Measured {
            name,
            asked_m,
            found_m,
            share,
        });
    };
    let height = |joint| statue.joint(joint).y;
    let size = |of: &[Joint], axis| {
        let (from, to) = statue.extent(of, axis);
        to - from
    };
    let most = |from, to, at: &dyn Fn(f64) -> f64| extent(levels(from, to).map(at)).1;
    let least = |from, to, at: &dyn Fn(f64) -> f64| extent(levels(from, to).map(at)).0;

    let vertex = statue.extent(&[Head], Y).1;
    add("stature", d.stature, 1.0, vertex);

    // The acromion is where the outline of the shoulder is half the breadth from the middle. A
    // tenth of a millimetre keeps the cut away from the edge of the hull, here and at the wrist.
    let across = statue.breadth(&SHOULDERS, d.acromial_height - 1e-4);
    add("biacromial_breadth", d.biacromial_breadth, 1.0, across);
    let deltoids = most(height(LeftUpperArm) - 0.1, d.acromial_height, &|y| {
        statue.breadth(&SHOULDERS, y)
    });
    add("bideltoid_breadth", d.bideltoid_breadth, 1.0, deltoids);

    // At the level of the rearmost point of the buttocks.
    let back = |y: &f64| extent(statue.cut(&[Pelvis], Y, *y).iter().map(|p| p.z)).0;
    let buttock = levels(d.trochanterion_height - 0.04, d.trochanterion_height + 0.05)
        .min_by(|a, b| back(a).total_cmp(&back(b)))
        .expect("levels");
    let hips = statue.breadth(&TRUNK, buttock);
    add("hip_breadth", d.hip_breadth, 1.0, hips);
    // A breadth between bones, deep under the skin of the waist, which determines the hip joints
    // (Harrington 2007, z of a pelvis 0.85 times as wide).
    let pelvis = (statue.joint(LeftThigh).x - 0.0073) / (0.33 * 0.85);
    add("bicristal_breadth", d.bicristal_breadth, 1.0, pelvis);

    let breadth = statue.breadth(&TRUNK, d.chest_height);
    add("chest_breadth", d.chest_breadth, 1.0, breadth);
    let depth = statue.depth(&TRUNK, d.chest_height);
    add("chest_depth", d.chest_depth, 1.0, depth);

    // At the navel, which is on average this far below the iliac crests.
    let navel = d.iliocristale_height
        - match sex {
            Sex::Male => 1.0616 - 1.0565,
            Sex::Female => 0.9957 - 0.9801,
        };
    let breadth = statue.breadth(&TRUNK, navel);
    add("waist_breadth", d.waist_breadth, 1.0, breadth);
    let depth = statue.depth(&TRUNK, navel);
    add("waist_depth", d.waist_depth, 1.0, depth);
    let depth = statue.depth(&TRUNK, buttock);
    add("buttock_depth", d.buttock_depth, 1.0, depth);

    // Below the buttock; above the patella, which is 4 to 5 cm long with its middle at the level of
    // the epicondyle; at the thickest part of the calf and the thinnest of the ankle.
    let around = |y| statue.tape(&[LeftThigh], y);
    let thigh = most(d.crotch_height - 0.06, d.crotch_height, &around);
    add("thigh_circumference", d.thigh_circumference, 1.0, thigh);
    let lower = statue.tape(&[LeftThigh, LeftShank], height(LeftShank) + 0.022);
    add(
        "lower_thigh_circumference",
        d.lower_thigh_circumference,
        1.0,
        lower,
    );
    let (knee, ankle) = (height(LeftShank), height(LeftFoot));
    let along = |share: f64| knee + share * (ankle - knee);
    let around = |y| statue.tape(&[LeftShank], y);
    let calf = most(along(0.5), along(0.2), &around);
    add("calf_circumference", d.calf_circumference, 1.0, calf);
    let thinnest = least(along(0.92), along(0.7), &around);
    add("ankle_circumference", d.ankle_circumference, 1.0, thinnest);

    // Flexed muscles are thicker than those of hanging arms, for which 0.92 and 0.95 of the
    // dimension are expected. The biceps is thickest at about 0.6 of the way from the acromion to
    // the elbow.
    let peak = d.acromial_height - 0.6 * d.acromion_radiale_length;
    let biceps = statue.tape(&[LeftUpperArm], peak);
    add("biceps_circumference", d.biceps_circumference, 0.92, biceps);
    let (elbow, wrist) = (height(LeftForearm), height(LeftHand));
    let along = |share: f64| elbow + share * (wrist - elbow);
    let forearm = most(along(0.4), along(0.1), &|y| statue.tape(&[LeftForearm], y));
    add(
        "forearm_circumference",
        d.forearm_circumference,
        0.95,
        forearm,
    );
    let thin = statue.tape(&[LeftForearm, LeftHand], wrist + 1e-4);
    add("wrist_circumference", d.wrist_circumference, 1.0, thin);
    // Below the thyroid cartilage, between the breastbone and the seventh vertebra.
    let throat = statue.tape(&[Neck], 0.5 * (height(Neck) + height(LeftClavicle)));
    add("neck_circumference", d.neck_circumference, 1.0, throat);

    add("head_breadth", d.head_breadth, 1.0, size(&[Head], X));
    add("head_length", d.head_length, 1.0, size(&[Head], Z));

    let beside = statue.cut(&SHOULDERS, X, 0.5 * d.biacromial_breadth);
    let acromion = extent(beside.iter().map(|point| point.y)).1;
    add("acromial_height", d.acromial_height, 1.0, acromion);
    // Landmarks of bone close to the skin, at the joints.
    for (name, asked_m, joint) in [
        ("cervicale_height", d.cervicale_height, Neck),
        ("suprasternale_height", d.suprasternale_height, LeftClavicle),
        ("trochanterion_height", d.trochanterion_height, LeftThigh),
    ] {
        add(name, asked_m, 1.0, height(joint));
    }
    // The lowest skin between the legs.
    let between = statue.cut(&TRUNK, X, 0.0);
    let crotch = extent(between.iter().map(|point| point.y)).0;
    add("crotch_height", d.crotch_height, 1.0, crotch);
    add("knee_height", d.knee_height, 1.0, knee);
    add("malleolus_height", d.malleolus_height, 1.0, ankle);
    let crest = height(Spine);
    add("iliocristale_height", d.iliocristale_height, 1.0, crest);
    // The foremost point of the rib cage.
    let ribs = statue.points(&[Thorax]);
    let ahead = ribs.iter().max_by(|a, b| a.z.total_cmp(&b.z));
    let nipples = ahead.expect("a rib cage").y;
    add("chest_height", d.chest_height, 1.0, nipples);

    let arm = acromion - elbow;
    add(
        "acromion_radiale_length",
        d.acromion_radiale_length,
        1.0,
        arm,
    );
    add(
        "radiale_stylion_length",
        d.radiale_stylion_length,
        1.0,
        elbow - wrist,
    );
    // The hand is half closed.
    let hand = wrist - statue.extent(&[LeftHand], Y).0;
    add("hand_length", d.hand_length, 0.85, hand);
    add("hand_breadth", d.hand_breadth, 1.0, size(&[LeftHand], Z));
    add("foot_length", d.foot_length, 1.0, size(&[LeftFoot], Z));
    add("foot_breadth", d.foot_breadth, 1.0, size(&[LeftFoot], X));
    let head = vertex - height(Head);
    add("tragion_to_vertex", d.tragion_to_vertex, 1.0, head);
    all
}
