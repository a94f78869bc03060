//! Tests of the size of each type against the memory table of this crate's README.
//!
//! `cargo test -p edgegait-core --test bytes sizes -- --nocapture` prints it.

use edgegait_core::avatar::{Avatar, Hull};
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::camera::Camera;
use edgegait_core::clip::{Clip, Expanded};
use edgegait_core::compact::{self, CompactRows, Room};
use edgegait_core::cycle::{CycleDetector, LowerBody};
use edgegait_core::linear::LinearRecognizer;
use edgegait_core::outline::Outline;
use edgegait_core::pack::Pack;
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::raster::{Drawing, Renderer, Skia, columns};
use edgegait_core::silhouette::{AnySilhouette, Coverage, Ninths, Silhouette};
use edgegait_core::skeleton::Skeleton;
use edgegait_core::template::{Gei, GeiBuilder, GeiInPlace, GeiTally, TemplateBuilder};

const README: &str = include_str!("../../README.md");

/// Prints a line of the table, and checks it against the README.
///
/// # Panics
/// If the README states another number of bytes for `T` on this target, or none.
fn assert_size<T>(name: &str) {
    let bytes = size_of::<T>();
    println!("{name:<24}{bytes:>7}");
    let row = format!("| `{name}` | ");
    let row = README.lines().find_map(|line| line.strip_prefix(&row));
    let mut stated = row.expect("a row of the README's table").split(" | ");
    let column = if cfg!(target_pointer_width = "64") {
        0
    } else {
        1
    };
    let stated = stated.nth(column).expect("a cell").replace(',', "");
    assert_eq!(stated, bytes.to_string(), "{name}");
}

#[test]
fn types_take_what_the_readme_says() {
    assert_size::<Pack<'_>>("Pack");
    assert_size::<Avatar<'_>>("Avatar");
    assert_size::<Hull<'_>>("Hull");
    assert_size::<Clip<'_>>("Clip");
    assert_size::<Expanded<'_>>("Expanded");
    assert_size::<Skeleton>("Skeleton");
    assert_size::<Pose>("Pose");
    assert_size::<ModelPose>("ModelPose");
    assert_size::<Camera>("Camera");
    assert_size::<compact::CompactBody<488, 896>>("compact::CompactBody<488, 896>");
    assert_size::<compact::CompactFigure<'_>>("compact::CompactFigure");
    assert_size::<Renderer<CompactRows>>("Renderer<CompactRows>");
    assert_size::<Renderer<Skia>>("Renderer<Skia>");
    assert_size::<GeiInPlace<'_>>("GeiInPlace");
    assert_size::<LinearRecognizer<'_>>("LinearRecognizer");
    assert_size::<CycleDetector>("CycleDetector");
    assert_size::<LowerBody>("LowerBody");
    assert_size::<Silhouette>("Silhouette");
    assert_size::<UnpackedBody>("UnpackedBody");
    assert_size::<Figure<'_>>("Figure");
    assert_size::<Renderer>("Renderer");
    assert_size::<Drawing<'_>>("Drawing");
    assert_size::<Outline>("Outline");
    assert_size::<Ninths>("Ninths");
    assert_size::<Coverage>("Coverage");
    assert_size::<AnySilhouette>("AnySilhouette");
    assert_size::<Gei>("Gei");
    assert_size::<GeiBuilder>("GeiBuilder");
    assert_size::<TemplateBuilder>("TemplateBuilder");
    assert_size::<columns::ColumnRenderer>("columns::ColumnRenderer");
    assert_size::<columns::ElevationImages>("columns::ElevationImages");
    assert_size::<GeiTally>("GeiTally");
}

#[test]
fn a_cycle_detector_takes_a_kilobyte_at_most() {
    assert!(size_of::<CycleDetector>() <= 1_024);
}

#[test]
fn a_body_takes_the_bytes_of_its_room() {
    fn assert_bytes<const POINTS: usize, const FACETS: usize>() {
        let room = Room {
            hulls: 19,
            points: POINTS,
            facets: FACETS,
        };
        let bytes = size_of::<compact::CompactBody<POINTS, FACETS>>();
        assert_eq!(room.bytes(), bytes, "{POINTS} points, {FACETS} facets");
    }
    assert_bytes::<0, 0>();
    assert_bytes::<1, 0>();
    assert_bytes::<0, 1>();
    assert_bytes::<1, 1>();
    assert_bytes::<2, 5>();
    assert_bytes::<3, 6>();
    assert_bytes::<488, 900>();
    assert_bytes::<488, 896>();
    assert_bytes::<767, 1535>();
    assert_bytes::<768, 1536>();
}

#[test]
fn the_heap_of_tiny_skia_is_bounded() {
    use edgegait_core::budget::{SKIA_HEAP_BYTES, SKIA_RESIDENT_BYTES, SKIA_TRANSIENT_BYTES};

    for (name, bytes, most) in [
        ("resident", SKIA_RESIDENT_BYTES, 4_430),
        ("transient", SKIA_TRANSIENT_BYTES, 5_315),
        ("heap", SKIA_HEAP_BYTES, 9_745),
    ] {
        println!("{name:<24}{bytes:>7}");
        assert_eq!(bytes, most, "{name}");
    }
}
