//! A list of hashes of bytes that must be equal on every target: poses, silhouettes by each
//! rasteriser from hard viewpoints, GEIs and other templates. Without `std`, so that firmware
//! computes the list with the same code.

mod fnv;

use core::fmt::Arguments;
use edgegait_core::avatar::Avatar;
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::clip::{Clip, Loop};
use edgegait_core::compact;
use edgegait_core::pack::Pack;
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::raster::{Rasterizer, Renderer, Skia, Window};
use edgegait_core::silhouette::{AnySilhouette, Silhouette, Size};
use edgegait_core::template::{TemplateBuilder, TemplateKind};
use fnv::Fnv;
use glam::{Vec2, Vec3};

/// The built-in cohort: 26 people at 10 speeds.
const COHORT: &[u8] = include_bytes!("cohort.egp");
/// A pack with an uncut motion, and the bodies of the format's golden packs.
const TAKE: &[u8] = include_bytes!("take.egp");
/// The list of hashes: lines of a name, a space, and a hash of 16 digits.
pub const HASHES: &str = include_str!("hashes.txt");

/// Subjects of the built-in cohort and one of each person's walks, by their places in the pack.
const WALKS: [[usize; 2]; 3] = [[0, 2], [1, 7], [12, 9]];

/// Azimuth and elevation, degrees: along each axis, where facets are seen edge-on and points
/// coincide; slightly off; and in between.
const VIEWS: [[f32; 2]; 9] = [
    [0.0, 0.0],
    [90.0, 0.0],
    [180.0, 0.0],
    [90.0, 90.0],
    [45.0, 90.0],
    [0.0, -90.0],
    [89.9999, 0.0001],
    [65.0, 85.0],
    [37.0, 41.0],
];

impl Fnv {
    fn floats(&mut self, floats: impl IntoIterator<Item = f32>) {
        for float in floats {
            self.add(&float.to_bits().to_le_bytes());
        }
    }

    fn silhouette(&mut self, silhouette: &Silhouette) {
        for row in silhouette.rows() {
            self.add(&row.to_le_bytes());
        }
    }

    /// Adds a pose, and the joint places that follow from it.
    fn pose(&mut self, avatar: &Avatar<'_>, pose: &Pose) {
        self.floats(pose.root.to_array());
        for rotation in pose.rotations {
            self.floats(rotation.to_array());
        }
        let placed = ModelPose::new(&avatar.skeleton(), pose);
        for (position, orientation) in placed.positions.iter().zip(placed.orientations) {
            self.floats(position.to_array());
            self.floats(orientation.to_cols_array());
        }
    }
}

/// A callback for a line of the list.
pub type Line<'a> = &'a mut dyn FnMut(Arguments<'_>, Fnv);

/// Computes the whole list.
pub fn list(line: Line<'_>) {
    let pack = Pack::parse(COHORT).expect("the cohort");
    poses(&pack, line);
    takes(line);
    for [subject, walk] in WALKS {
        let (avatar, cycle) = walk_of(&pack, subject, walk);
        let body = UnpackedBody::new(&avatar);
        for &rasterizer in Rasterizer::ALL {
            silhouettes((subject, &avatar), (&body, &cycle), rasterizer, line);
            templates((subject, &avatar), (&body, &cycle), rasterizer, line);
        }
        compact_silhouettes(
            compact::CompactRows::new,
            ("compact-rows", subject),
            &avatar,
            &cycle,
            line,
        );
        compact_silhouettes(Skia::new, ("compact-skia", subject), &avatar, &cycle, line);
    }
}

/// Returns the body of a person, and one of that person's walks.
fn walk_of<'a>(pack: &Pack<'a>, subject: usize, walk: usize) -> (Avatar<'a>, Loop<'a>) {
    let person = pack.subject(subject).expect("a subject");
    let avatar = pack.avatar(person.avatar).expect("an avatar");
    let mut walks = pack.walks().filter(|walk| walk.subject == subject);
    let walk = walks.nth(walk).expect("a walk");
    let cycle = pack.clip(walk.clip).and_then(|clip| clip.as_loop());
    (avatar, cycle.expect("a cycle"))
}

fn poses(pack: &Pack<'_>, line: Line<'_>) {
    for [subject, walk] in WALKS {
        let (avatar, cycle) = walk_of(pack, subject, walk);
        let mut hash = Fnv::NEW;
        for phase in 0..50u8 {
            hash.pose(&avatar, &cycle.pose(f32::from(phase) / 50.0));
        }
        line(format_args!("poses/subject-{subject}"), hash);
        let mut buffer = [0.0; 60 * 63];
        let expanded = cycle.expand(&mut buffer).expect("room");
        let mut hash = Fnv::NEW;
        for phase in 0..50u8 {
            hash.pose(&avatar, &expanded.pose(f32::from(phase) / 50.0));
        }
        line(format_args!("expanded-poses/subject-{subject}"), hash);
    }
}

/// Adds poses of uncut motions at times in seconds, which are f64.
fn takes(line: Line<'_>) {
    let pack = Pack::parse(TAKE).expect("the take's pack");
    let avatar = pack.avatar(0).expect("an avatar");
    for walk in pack.walks() {
        let clip = pack.clip(walk.clip).expect("a clip");
        let mut hash = Fnv::NEW;
        for step in -3..60i8 {
            hash.pose(&avatar, &Clip::sample(&clip, f64::from(step) * 0.037));
        }
        line(format_args!("poses/take-{}", walk.name), hash);
    }
}

fn cameras() -> impl Iterator<Item = (&'static str, Camera)> {
    let viewpoint = |[azimuth, elevation]: [f32; 2]| {
        Viewpoint::from_degrees(azimuth, elevation).expect("a viewpoint")
    };
    let far = move |view| ("ortho", Camera::orthographic(viewpoint(view)));
    let near = move |view| {
        let aim = Vec3::new(0.0, 0.9, 0.0);
        let camera = Camera::perspective(viewpoint(view).rolled(7.0), aim, 2.5);
        ("persp", camera.expect("a camera"))
    };
    VIEWS
        .into_iter()
        .map(far)
        .chain(VIEWS.into_iter().map(near))
}

const FRAMINGS: [(&str, Framing); 3] = [
    ("height", Framing::Height),
    ("box", Framing::Box),
    (
        "fixed",
        Framing::Fixed {
            centre: Vec3::new(0.0, 0.9, 0.0),
            pixels_per_metre: 27.3,
        },
    ),
];

/// Adds two frames of a walk from every viewpoint with every framing, a line for each size and
/// framing.
fn silhouettes(
    (subject, avatar): (usize, &Avatar<'_>),
    (body, cycle): (&UnpackedBody, &Loop<'_>),
    rasterizer: Rasterizer,
    line: Line<'_>,
) {
    let skeleton = avatar.skeleton();
    let mut figure = Figure::at_rest(body);
    for size in Size::ALL {
        let mut renderer = Renderer::new(rasterizer, size);
        for (name, framing) in FRAMINGS {
            let mut hash = Fnv::NEW;
            for phase in [0.0, 0.3] {
                figure.update(&ModelPose::new(&skeleton, &cycle.pose(phase)));
                for (_, camera) in cameras() {
                    match renderer.draw(&figure, &camera, framing, Vec2::ZERO) {
                        Ok(drawing) => {
                            add_frame(&mut hash, drawing.frame);
                            hash.floats([drawing.clipped_share]);
                        }
                        Err(_) => hash.add(b"refused"),
                    }
                }
            }
            line(
                format_args!("{rasterizer}/{size}/{name}/subject-{subject}"),
                hash,
            );
        }
    }
}

fn add_frame(hash: &mut Fnv, frame: &AnySilhouette) {
    match frame {
        AnySilhouette::Binary(silhouette) => hash.silhouette(silhouette),
        grey => hash.add(grey.to_coverage().pixels()),
    }
}

/// Adds the same silhouettes drawn hull by hull.
fn compact_silhouettes<W>(
    window: impl Fn(Size) -> W,
    (name, subject): (&str, usize),
    avatar: &Avatar<'_>,
    cycle: &Loop<'_>,
    line: Line<'_>,
) where
    W: for<'a> Window<compact::CompactFigure<'a>, Image = Silhouette>,
{
    let skeleton = avatar.skeleton();
    let mut body = compact::CompactBody::<512, 1024>::EMPTY;
    body.load(avatar).expect("room");
    for size in Size::ALL {
        let mut renderer = Renderer::with_window(window(size));
        for (framed, framing) in FRAMINGS {
            let mut hash = Fnv::NEW;
            for phase in [0.0, 0.3] {
                let pose = ModelPose::new(&skeleton, &cycle.pose(phase));
                let posed = body.posed(&pose);
                for (_, camera) in cameras() {
                    match renderer.draw(&posed, &camera, framing, Vec2::ZERO) {
                        Ok(drawing) => {
                            hash.silhouette(drawing.frame);
                            hash.floats([drawing.clipped_share]);
                        }
                        Err(_) => hash.add(b"refused"),
                    }
                }
            }
            line(
                format_args!("{name}/{size}/{framed}/subject-{subject}"),
                hash,
            );
        }
    }
}

/// Adds every template of eight frames, from three viewpoints.
fn templates(
    (subject, avatar): (usize, &Avatar<'_>),
    (body, cycle): (&UnpackedBody, &Loop<'_>),
    rasterizer: Rasterizer,
    line: Line<'_>,
) {
    let skeleton = avatar.skeleton();
    let mut figure = Figure::at_rest(body);
    let mut renderer = Renderer::new(rasterizer, Size::S50x30);
    let mut bytes = [0; 3 * 50 * 30];
    for kind in TemplateKind::ALL {
        let mut hash = Fnv::NEW;
        for (_, camera) in cameras().skip(6).take(3) {
            let mut builder = TemplateBuilder::for_kind(kind, Size::S50x30, 8);
            for frame in 0..8u8 {
                let pose = cycle.pose(f32::from(frame) / 8.0);
                figure.update(&ModelPose::new(&skeleton, &pose));
                let drawing = renderer.draw(&figure, &camera, Framing::Height, Vec2::ZERO);
                builder.add(drawing.expect("a figure").frame).expect("room");
            }
            let template = &mut bytes[..kind.bytes(Size::S50x30)];
            builder.finish(template);
            hash.add(template);
        }
        let kind = kind.name();
        line(format_args!("{kind}/{rasterizer}/subject-{subject}"), hash);
    }
}
