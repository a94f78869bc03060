//! An image of imported walkers next to silhouettes that other software rendered from skinned
//! bodies.

use crate::command::done;
use crate::data::given;
use crate::npy::npy;
use crate::people::{Row, body, recordings, rows};
use crate::skinned::spans;
use edgegait::Tree;
use edgegait::dataset::TreeLayout;
use edgegait::draw::sweep::FramingMode;
use edgegait_core::silhouette::Size;
use image::{GrayImage, Luma};
use std::fs;
use std::path::Path;

/// The people that may be shown, and the number of their takes.
const SHOWN: [(&str, usize); 9] = [
    ("101", 2),
    ("102", 1),
    ("104", 1),
    ("105", 1),
    ("106", 1),
    ("107", 1),
    ("108", 1),
    ("109", 1),
    ("110", 1),
];
/// The viewpoints and phases of the columns: the left contact, and a third of a cycle later.
const COLUMNS: [(&str, f64); 4] = [
    ("000", 0.0),
    ("000", 1.0 / 3.0),
    ("090", 0.0),
    ("090", 1.0 / 3.0),
];
const SIZE: Size = Size::S64x44;
const FRAMES: usize = 48;
/// The size of a silhouette's pixel in the image, and the gaps between columns and rows.
const SCALE: usize = 2;
const GAP: [usize; 2] = [12, 4];

/// Returns the frames of a cycle of a walk, as EdgeGait draws the person of a table's row.
fn drawn(data: &Path, person: &Row, (walk, view): (&str, &str)) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let id = &person["id"];
    fs::write(folder.path().join("body.csv"), body(person)).expect("a table");
    let import = format!(
        "import --subject {id} --bodies body.csv --cycles mean --keep-going --out walks.egp"
    );
    let sources = recordings(data, id);
    let mut import: Vec<&str> = import.split(' ').collect();
    import.extend(sources.iter().map(String::as_str));
    done(folder.path(), &import);
    let azimuth_deg: f64 = view.parse().expect("degrees");
    let render = format!(
        "render walks.egp --walks {walk} --size 64x44 --azimuth-deg {azimuth_deg} --lens persp --distance-m 6 --frames-per-cycle {FRAMES} --out frames.npy"
    );
    done(folder.path(), &render.split(' ').collect::<Vec<_>>());
    npy(folder.path().join("frames.npy")).1
}

fn put(image: &mut GrayImage, frame: &[u8], (left, top): (usize, usize)) {
    for (at, pixel) in frame.iter().enumerate() {
        let (x, y) = (at % SIZE.columns() * SCALE, at / SIZE.columns() * SCALE);
        for inner in 0..SCALE * SCALE {
            let (x, y) = (left + x + inner % SCALE, top + y + inner / SCALE);
            image.put_pixel(x as u32, y as u32, Luma([*pixel]));
        }
    }
}

#[test]
#[ignore = "needs EDGEGAIT_DATA"]
fn ten_walkers_as_a_picture() {
    let data = given();
    let bodies = rows(&data.join("people/bodies.csv"));
    let takes = rows(&data.join("people/manifest.csv"));
    let tree = Tree::open(data.join("people/people"), &TreeLayout::default()).expect("a tree");
    let (rows, columns) = (SIZE.rows() * SCALE, SIZE.columns() * SCALE);
    let walkers: usize = SHOWN.iter().map(|(_, takes)| takes).sum();
    let wide = COLUMNS.len() * (2 * columns + GAP[0]) - GAP[0];
    let tall = walkers * (rows + GAP[1]) - GAP[1];
    let grey = Luma([96]);
    let mut image = GrayImage::from_pixel(wide as u32, tall as u32, grey);
    let mut top = 0;
    for (id, count) in SHOWN {
        let person = bodies.iter().find(|row| row["id"] == id).expect("a body");
        let of_view = |view: &str| -> Vec<&Row> {
            let own = takes.iter().filter(|row| row["id"] == id);
            own.filter(|row| row["view"] == view).collect()
        };
        for take in 0..count {
            for (column, (view, phase)) in COLUMNS.into_iter().enumerate() {
                let row = of_view(view)[take];
                let place = tree.sequences().iter().position(|one| {
                    one.subject == id && one.take == row["take"] && one.view == view
                });
                let seen = tree.silhouettes(place.expect("a sequence"), SIZE, FramingMode::Height);
                let seen = seen.expect("silhouettes");
                let size = seen.pixels.len() / seen.frames;
                let (from, to) = spans(&row["cycles"])[0];
                let left = row["lhs"].split(';').next().expect("a contact");
                let left: f64 = left.parse().expect("a frame");
                let at = (left + phase * (to - from)).round() as usize;
                let walk = Path::new(&row["source"]).file_stem().expect("a name");
                let walk = walk.to_string_lossy();
                let frames = drawn(&data, person, (&walk, view));
                let drawn = &frames[(phase * FRAMES as f64).round() as usize * size..][..size];
                let corner = column * (2 * columns + GAP[0]);
                put(&mut image, &seen.pixels[at * size..][..size], (corner, top));
                put(&mut image, drawn, (corner + columns, top));
            }
            top += rows + GAP[1];
        }
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("beside.png");
    image.save(&path).expect("a picture");
    println!("{}", path.display());
}
