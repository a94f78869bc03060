//! How many bytes each type takes: the memory table of this crate's README.
//!
//! `cargo test -p edgegait-core --test sizes -- --nocapture` prints it.

use edgegait_core::avatar::{Avatar, Hull};
use edgegait_core::body::{Body, Figure};
use edgegait_core::clip::{Clip, Expanded};
use edgegait_core::outline::Outline;
use edgegait_core::pack::Pack;
use edgegait_core::pose::{ModelPose, Pose};
use edgegait_core::raster::{Drawing, Renderer, columns};
use edgegait_core::silhouette::{Coverage, Frame, Ninths, Silhouette};
use edgegait_core::skeleton::Skeleton;
use edgegait_core::template::{Gei, GeiBuilder, GeiTally, TemplateBuilder};

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
    assert_size::<Body>("Body", 101_824);
    assert_size::<Figure<'_>>("Figure", 50_088);
    assert_size::<Renderer>("Renderer", 30_688);
    assert_size::<Drawing<'_>>("Drawing", 16);
    assert_size::<columns::Renderer>("columns", 23576);
    assert_size::<columns::Images>("Images", 12352);
    assert_size::<GeiTally>("GeiTally", 258624);
    assert_size::<Outline>("Outline", 296);
    assert_size::<Silhouette>("Silhouette", 520);
    assert_size::<Ninths>("Ninths", 2_056);
    assert_size::<Coverage>("Coverage", 4_097);
    assert_size::<Frame>("Frame", 4_104);
    assert_size::<Gei>("Gei", 4_097);
    assert_size::<GeiBuilder>("GeiBuilder", 16_400);
    assert_size::<TemplateBuilder>("TemplateBuilder", 81_970);
}

#[cfg(feature = "skia")]
#[test]
fn the_heap_of_tiny_skia_is_bounded() {
    use edgegait_core::budget::{SKIA_HEAP_BYTES, SKIA_RESIDENT_BYTES, SKIA_TRANSIENT_BYTES};

    for (name, bytes, most) in [
        ("resident", SKIA_RESIDENT_BYTES, 8_526),
        ("transient", SKIA_TRANSIENT_BYTES, 5_507),
        ("heap", SKIA_HEAP_BYTES, 14_033),
    ] {
        println!("{name:<12}{bytes:>7}");
        assert_eq!(bytes, most, "{name}");
    }
}
