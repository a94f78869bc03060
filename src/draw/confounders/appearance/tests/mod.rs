//! Outfits of built-in people and of a body as hull fits return it, checked by support functions,
//! ratios computed by hand, and silhouettes.

mod shape;
mod worn;

use super::*;
use crate::encode::encode_avatar;
use crate::people::cohort::Person;
use edgegait_core::body::Figure;
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::{AnySilhouette, Silhouette, Size};
use edgegait_core::skeleton::JOINTS;
use glam::{DQuat, DVec3, Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

type Dress = fn(&mut Outfit, &Wearer, f64);

/// Garments and loads, first those that fit together on the largest body.
const GARMENTS: [(&str, Dress); TOGETHER + 5] = [
    ("wide trousers", wide_trousers),
    ("shoes", shoes),
    ("skirt", skirt),
    ("coat", coat),
    ("hair", hair),
    ("hat", hat),
    ("backpack", backpack),
    ("shoulder bag", shoulder_bag),
    ("suitcase", suitcase),
    ("hood", hood),
    ("open coat", open_coat),
    ("down jacket", down_jacket),
    ("umbrella", umbrella),
    ("carried box", carried_box),
    ("stroller", stroller),
];
const TOGETHER: usize = 10;
const SHAPES: [(&str, Dress); 3] = [
    ("body mass", body_mass),
    ("build", build),
    ("age", age_body),
];

struct Walker {
    outfit: Outfit,
    wearer: Wearer,
    poses: Vec<ModelPose>,
}

impl Walker {
    fn new(person: &Person) -> Self {
        let offsets = person.body.offsets.map(DVec3::as_vec3);
        let wearer = Wearer {
            skeleton: Skeleton { offsets },
            sex: Some(person.sex),
            stature_m: person.dimensions.stature,
            mass_kg: person.mass_kg,
        };
        let hulls = person.body.hulls.iter().map(|hull| WornHull {
            part: BodyPart::Body,
            points: hull
                .points
                .iter()
                .map(|p| (hull.joint, p.as_vec3()))
                .collect(),
        });
        let cycle = person.cycle(5.0);
        let poses = (0..cycle.root.len())
            .step_by(cycle.root.len() / 12)
            .map(|frame| {
                let pose = Pose {
                    root: cycle.root[frame].as_vec3(),
                    rotations: cycle.rotations[frame].map(DQuat::as_quat),
                };
                ModelPose::new(&wearer.skeleton, &pose)
            });
        Self {
            outfit: Outfit {
                hulls: hulls.collect(),
            },
            poses: poses.collect(),
            wearer,
        }
    }

    fn average(sex: Sex) -> Self {
        Self::new(&Person::average(sex))
    }

    /// Returns a body as a fit to a mesh returns it: 24 hulls and 512 points, some joints with two
    /// hulls, points in no order, each moved by up to 4 mm along each axis.
    fn fitted(seed: u64) -> Self {
        let mut walker = Self::average(Sex::Female);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let limbs = [0, 2, 11, 13, 15];
        for hull in limbs {
            let mut half = walker.outfit.hulls[hull].clone();
            let own = &mut walker.outfit.hulls[hull];
            let mut heights: Vec<f32> = own.points.iter().map(|(_, point)| point.y).collect();
            heights.sort_by(f32::total_cmp);
            let (low, high) = (heights[heights.len() / 3], heights[2 * heights.len() / 3]);
            half.points.retain(|(_, point)| point.y >= low);
            own.points.retain(|(_, point)| point.y <= high);
            walker.outfit.hulls.push(half);
        }
        let mut random = |reach: f32| rng.random_range(-reach..reach);
        let count = |outfit: &Outfit| {
            outfit
                .hulls
                .iter()
                .map(|hull| hull.points.len())
                .sum::<usize>()
        };
        for index in 0.. {
            if count(&walker.outfit) >= 512 {
                break;
            }
            let hulls = walker.outfit.hulls.len();
            let points = &mut walker.outfit.hulls[index % hulls].points;
            if points.len() < MAX_HULL_POINTS {
                points.push(points[index / hulls]);
            }
        }
        while count(&walker.outfit) > 512 {
            let longest = walker
                .outfit
                .hulls
                .iter_mut()
                .max_by_key(|hull| hull.points.len());
            longest.expect("a hull").points.pop();
        }
        for (_, point) in walker
            .outfit
            .hulls
            .iter_mut()
            .flat_map(|hull| &mut hull.points)
        {
            *point += Vec3::new(random(0.004), random(0.004), random(0.004));
        }
        assert_eq!(
            (walker.outfit.hulls.len(), count(&walker.outfit)),
            (24, 512)
        );
        walker
    }

    fn all() -> [Self; 4] {
        [
            Self::average(Sex::Male),
            Self::average(Sex::Female),
            Self::new(&Person::of_cohort(1, 6).expect("a person")),
            Self::fitted(5),
        ]
    }

    fn dressed(&self, dress: Dress, strength: f64) -> Outfit {
        let mut outfit = self.outfit.clone();
        dress(&mut outfit, &self.wearer, strength);
        outfit
    }

    fn in_everything(&self, strength: f64) -> Outfit {
        let mut outfit = self.outfit.clone();
        for (_, dress) in &GARMENTS[..TOGETHER] {
            dress(&mut outfit, &self.wearer, strength);
        }
        outfit
    }
}

/// Returns the positions of each hull's points in a pose.
fn posed(outfit: &Outfit, pose: &ModelPose) -> Vec<Vec<Vec3>> {
    let place = |&(joint, point): &(Joint, Vec3)| {
        pose.orientations[joint.index()] * point + pose.positions[joint.index()]
    };
    let hulls = outfit.hulls.iter();
    hulls
        .map(|hull| hull.points.iter().map(place).collect())
        .collect()
}

/// Returns how far points stand out of a convex hull, metres, by its support function in 2,000
/// directions (spiral of Vogel 1979), so that facets are not needed.
fn stands_out(hull: &[Vec3], points: &[Vec3]) -> f32 {
    let most =
        |points: &[Vec3], way: Vec3| points.iter().map(|p| p.dot(way)).fold(f32::MIN, f32::max);
    let ways = (0..2_000).map(|index| {
        let y = 1.0 - (2.0 * index as f32 + 1.0) / 2_000.0;
        let (sin, cos) = (2.399_963_2 * index as f32).sin_cos();
        let radius = (1.0 - y * y).sqrt();
        Vec3::new(radius * cos, y, radius * sin)
    });
    ways.map(|way| most(points, way) - most(hull, way))
        .fold(f32::MIN, f32::max)
}

fn unpacked(outfit: &Outfit) -> Result<Box<UnpackedBody>> {
    let mut body = Box::default();
    outfit.unpack(&mut body)?;
    Ok(body)
}

/// Renders all poses from nine viewpoints, in an image that does not follow the figure.
fn silhouettes(outfit: &Outfit, poses: &[ModelPose]) -> Vec<Silhouette> {
    let body = unpacked(outfit).expect("within the budget");
    let mut renderer = Renderer::new(Rasterizer::Rows, Size::S64x64);
    let mut frames = Vec::new();
    for pose in poses {
        let figure = Figure::new(&body, pose);
        let centre = Vec3::new(pose.positions[0].x, 0.95, pose.positions[0].z);
        let framing = Framing::Fixed {
            centre,
            pixels_per_metre: 28.0,
        };
        for azimuth in [0.0, 45.0, 90.0] {
            for elevation in [0.0, 30.0, 80.0] {
                let viewpoint = Viewpoint::from_degrees(azimuth, elevation).expect("in range");
                let camera = Camera::orthographic(viewpoint);
                let drawing = renderer.draw(&figure, &camera, framing, Vec2::ZERO);
                let AnySilhouette::Binary(frame) = drawing.expect("a figure").frame else {
                    panic!("rows draw binary frames");
                };
                frames.push(*frame);
            }
        }
    }
    frames
}

/// Returns how many pixels of `a` are not in `b`.
fn missing(a: &Silhouette, b: &Silhouette) -> u32 {
    let rows = a.rows().iter().zip(b.rows());
    rows.map(|(a, b)| (a & !b).count_ones()).sum()
}

#[test]
fn an_avatar_that_wears_nothing_is_its_own_body() {
    let person = Person::average(Sex::Male);
    let encoded = encode_avatar(&person.body, 2.0).expect("a body");
    let avatar = Avatar::parse(&encoded.bytes).expect("our own bytes");
    let outfit = Outfit::from_avatar(&avatar);
    assert!(outfit.hulls.iter().all(|hull| hull.part == BodyPart::Body));
    let body = unpacked(&outfit).expect("within the budget");
    let expected = UnpackedBody::new(&avatar);
    let (found, expected) = (Figure::at_rest(&body), Figure::at_rest(&expected));
    assert_eq!(found.hulls().count(), expected.hulls().count());
    for (found, expected) in found.hulls().zip(expected.hulls()) {
        assert!(found.eq(expected));
    }
}

#[test]
fn nothing_changes_at_strength_0() {
    for walker in Walker::all() {
        for (name, dress) in GARMENTS.into_iter().chain(SHAPES) {
            assert_eq!(walker.dressed(dress, 0.0), walker.outfit, "{name}");
        }
        assert_eq!(walker.wearer.aged(0.0), walker.wearer);
    }
}

#[test]
fn little_changes_at_little_strength() {
    for walker in Walker::all() {
        let before = silhouettes(&walker.outfit, &walker.poses[..3]);
        let area: u32 = before.iter().map(Silhouette::area).sum();
        for (name, dress) in GARMENTS.into_iter().chain(SHAPES) {
            let after = silhouettes(&walker.dressed(dress, 1e-3), &walker.poses[..3]);
            let changed: u32 = before
                .iter()
                .zip(&after)
                .map(|(a, b)| missing(a, b) + missing(b, a))
                .sum();
            assert!(1_000 * changed < 3 * area, "{name}: {changed} of {area}");
        }
    }
}

#[test]
fn everything_at_once_is_within_the_budget_of_the_largest_body() {
    let walker = Walker::fitted(1);
    for strength in [0.01, 0.5, 1.0] {
        let outfit = walker.in_everything(strength);
        assert_eq!(outfit.hulls.len(), MAX_HULLS);
        assert!(unpacked(&outfit).is_ok());
    }
}

#[test]
fn what_exceeds_the_budget_is_named_with_what_to_do() {
    let walker = Walker::fitted(1);
    let mut outfit = walker.in_everything(1.0);
    hat(&mut outfit, &walker.wearer, 1.0);
    let error = unpacked(&outfit).expect_err("34 hulls").to_string();
    assert!(error.contains("at most 32 hulls, found 34"), "{error}");
    assert!(error.contains("leave out a garment or a load"), "{error}");
    let mut outfit = walker.outfit.clone();
    for _ in 0..5 {
        skirt(&mut outfit, &walker.wearer, 1.0);
    }
    let error = unpacked(&outfit).expect_err("5 skirts").to_string();
    assert!(error.contains("at most 4 draped hulls, found 5"), "{error}");
}

#[test]
fn left_and_right_stay_mirror_images() {
    let walker = Walker::average(Sex::Male);
    let mut symmetric: Vec<_> = GARMENTS[..7].to_vec();
    symmetric.extend(SHAPES);
    for (name, dress) in symmetric {
        let outfit = walker.dressed(dress, 0.7);
        let points = || outfit.hulls.iter().flat_map(|hull| &hull.points);
        for (joint, point) in points() {
            let mirrored = Vec3::new(-point.x, point.y, point.z);
            let nearest = points()
                .filter(|(other, _)| *other == joint.mirrored())
                .map(|(_, other)| other.distance(mirrored))
                .fold(f32::MAX, f32::min);
            assert!(nearest < 1e-4, "{name}: {joint:?} {point}, {nearest} m off");
        }
    }
}

#[test]
fn a_wearer_of_unknown_stature_is_estimated_from_the_skeleton() {
    for sex in [Sex::Male, Sex::Female] {
        let person = Person::average(sex);
        let skeleton = Skeleton {
            offsets: person.body.offsets.map(DVec3::as_vec3),
        };
        let mut subject = SubjectEntry {
            name: "someone",
            sex: Some(sex),
            age_years: None,
            stature_mm: 0,
            mass_hg: 0,
            avatar: 0,
        };
        let estimated = Wearer::new(skeleton.clone(), &subject);
        assert!((estimated.stature_m - person.dimensions.stature).abs() < 1e-3);
        assert!((estimated.mass_kg - person.mass_kg).abs() < 0.2);
        subject.sex = None;
        let unknown = Wearer::new(skeleton.clone(), &subject);
        assert!((unknown.stature_m / person.dimensions.stature - 1.0).abs() < 0.01);
        (subject.stature_mm, subject.mass_hg) = (1_830, 912);
        let known = Wearer::new(skeleton, &subject);
        assert!((known.stature_m - 1.83).abs() < 1e-9 && (known.mass_kg - 91.2).abs() < 1e-9);
    }
}

#[test]
fn a_skeleton_without_lengths_and_a_body_without_hulls_are_dressed_without_harm() {
    let wearer = Wearer {
        skeleton: Skeleton {
            offsets: [Vec3::ZERO; JOINTS],
        },
        sex: None,
        stature_m: 0.0,
        mass_kg: 0.0,
    };
    let point = WornHull {
        part: BodyPart::Body,
        points: vec![(Joint::LeftFoot, Vec3::ZERO)],
    };
    for hulls in [vec![], vec![point]] {
        let mut outfit = Outfit { hulls };
        for (_, dress) in SHAPES.into_iter().chain(GARMENTS) {
            dress(&mut outfit, &wearer, 1.0);
        }
        let points = outfit.hulls.iter().flat_map(|hull| &hull.points);
        assert!(points.into_iter().all(|(_, point)| point.is_finite()));
        assert!(unpacked(&outfit).is_ok());
    }
}
