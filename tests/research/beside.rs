//! Makes the picture of ten walkers in src/guide/importing.md: imported ones next to silhouettes that
//! other software rendered from skinned bodies.

use crate::command::done;
use crate::data::given;
use crate::npy::npy;
use crate::people::{Row, Seen, spans};
use crate::walker::{bodies, import_person, takes, walk};
use edgegait::Tree;
use edgegait::dataset::TreeLayout;
use edgegait_core::silhouette::Size;
use image::{GrayImage, Luma};
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

/// Returns the frames of a cycle of a take, as EdgeGait draws the imported person.
fn drawn(at: &Path, take: &Row) -> Vec<u8> {
    let azimuth_deg: f64 = take["view"].parse().expect("degrees");
    let render = format!(
        "render {}.egp --walks {} --size 64x44 --azimuth-deg {azimuth_deg} --lens persp --distance-m 6 --frames-per-cycle {FRAMES} --out frames.npy --overwrite",
        take["id"],
        walk(take)
    );
    done(at, &render.split(' ').collect::<Vec<_>>());
    npy(at.join("frames.npy")).1
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

mod slow_of_data {
    use super::*;

    #[test]
    #[ignore = "slow without optimisation; needs EDGEGAIT_DATA"]
    fn ten_walkers_as_a_picture() {
        let data = given();
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path();
        let (bodies, takes) = (bodies(&data), takes(&data));
        let tree = Tree::open(data.join("people/people"), &TreeLayout::default()).expect("a tree");
        let (rows, columns) = (SIZE.rows() * SCALE, SIZE.columns() * SCALE);
        let walkers: usize = SHOWN.iter().map(|(_, takes)| takes).sum();
        let wide = COLUMNS.len() * (2 * columns + GAP[0]) - GAP[0];
        let tall = walkers * (rows + GAP[1]) - GAP[1];
        let grey = Luma([96]);
        let mut image = GrayImage::from_pixel(wide as u32, tall as u32, grey);
        let mut top = 0;
        for (id, count) in SHOWN {
            let person = bodies.iter().find(|row| row["id"] == id);
            import_person(at, &data, person.expect("a body"), "mean");
            for take in 0..count {
                for (column, (view, phase)) in COLUMNS.into_iter().enumerate() {
                    let own = takes.iter().filter(|row| row["id"] == id);
                    let row = own.filter(|row| row["view"] == view).nth(take);
                    let row = row.expect("a take");
                    let (from, to) = spans(&row["cycles"])[0];
                    let left = row["lhs"].split(';').next().expect("a contact");
                    let left: f64 = left.parse().expect("a frame");
                    let seen_at = (left + phase * (to - from)).round() as usize;
                    let seen = Seen::of(&tree, row, SIZE);
                    let seen = seen.frame(seen_at).expect("a frame");
                    let drawn = drawn(at, row);
                    let drawn_at = (phase * FRAMES as f64).round() as usize * seen.len();
                    let corner = column * (2 * columns + GAP[0]);
                    put(&mut image, seen, (corner, top));
                    put(
                        &mut image,
                        &drawn[drawn_at..][..seen.len()],
                        (corner + columns, top),
                    );
                }
                top += rows + GAP[1];
            }
        }
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("beside.png");
        image.save(&path).expect("a picture");
        println!("{}", path.display());
    }
}
