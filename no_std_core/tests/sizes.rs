//! How many bytes each type takes: the memory table of this crate's README.
//!
//! `cargo test -p edgegait-core --test sizes -- --nocapture` prints it.

use edgegait_core::avatar::{Avatar, Hull, PosedHulls};
use edgegait_core::clip::{Clip, Expanded};
use edgegait_core::outline::Outline;
use edgegait_core::pack::Pack;
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::silhouette::{Coverage, Frame, Silhouette};
use edgegait_core::skeleton::Skeleton;
use edgegait_core::template::{Gei, GeiBuilder};

/// Prints a line of the table.
///
/// # Panics
/// If `T` takes more than `most` bytes (measured where pointers have 64 bits), or less than
/// half as many, so that the README would mislead.
fn assert_size<T>(name: &str, most: usize) {
    let bytes = size_of::<T>();
    println!("{name:<12}{bytes:>7}");
    assert!(
        bytes <= most,
        "{name}: {bytes} bytes, expected at most {most}"
    );
    assert!(
        bytes * 2 >= most,
        "{name}: {bytes} bytes, expected about {most}"
    );
}

#[test]
fn types_are_as_small_as_the_readme_says() {
    assert_size::<Pack<'_>>("Pack", 240);
    assert_size::<Avatar<'_>>("Avatar", 24);
    assert_size::<Hull<'_>>("Hull", 48);
    assert_size::<Clip<'_>>("Clip", 128);
    assert_size::<Expanded<'_>>("Expanded", 656);
    assert_size::<Skeleton>("Skeleton", 228);
    assert_size::<Pose>("Pose", 316);
    assert_size::<ModelPose>("ModelPose", 912);
    assert_size::<PosedHulls>("PosedHulls", 9_296);
    assert_size::<Outline>("Outline", 296);
    assert_size::<Silhouette>("Silhouette", 200);
    assert_size::<Coverage>("Coverage", 1_500);
    assert_size::<Frame>("Frame", 1_504);
    assert_size::<Gei>("Gei", 1_500);
    assert_size::<GeiBuilder>("GeiBuilder", 6_004);
}

#[cfg(feature = "skia")]
#[test]
fn a_renderer_is_small_and_its_heap_bounded() {
    use edgegait_core::budget::{SKIA_HEAP_BYTES, SKIA_RESIDENT_BYTES, SKIA_TRANSIENT_BYTES};
    use edgegait_core::raster::{Drawing, Renderer};

    assert_size::<Renderer>("Renderer", 112);
    assert_size::<Drawing>("Drawing", 1_508);
    for (name, bytes, most) in [
        ("resident", SKIA_RESIDENT_BYTES, 6_734),
        ("transient", SKIA_TRANSIENT_BYTES, 5_507),
        ("heap", SKIA_HEAP_BYTES, 12_241),
    ] {
        println!("{name:<12}{bytes:>7}");
        assert_eq!(bytes, most, "{name}");
    }
}
