//! Sizes in bytes that are the same in every run, written beside criterion's results for `edgegait
//! gate`. With `--test` nothing is written.
#![expect(unsafe_code, reason = "a counting global allocator requires it")]

use edgegait::encode::{MAX_ERROR_MM, encode_subjects};
use edgegait::people::cohort::{CohortOptions, subjects};
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::budget::SKIA_HEAP_BYTES;
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::compact::Budget;
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::Size;
use edgegait_core::skeleton::Joint;
use edgegait_core::template::GeiBuilder;
use glam::{Vec2, Vec3};
use serde_json::json;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::error::Error;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// An allocator that sums the requested bytes by thread.
struct Counting;

thread_local! {
    static ASKED_BYTES: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is passed on unchanged to the system's allocator, which keeps the contract;
// the counter starts as a constant and has no destructor, so that counting neither allocates nor
// runs after it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ASKED_BYTES.set(ASKED_BYTES.get().wrapping_add(layout.size()));
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn main() -> Result<(), Box<dyn Error>> {
    let heap = heap_bytes()?;
    println!("bytes/heap: {heap}");
    if env::args().any(|argument| argument == "--test") {
        return Ok(());
    }
    // 26 people at 10 speeds, with their bodies; 13 s on one core.
    let people = subjects(&CohortOptions::default())?;
    let study_pack = encode_subjects(&people, MAX_ERROR_MM, &|| Ok(()))?.len();
    // One of each type that is needed to make a GEI.
    let gei_types = Budget::UNPACKED_BYTES;
    for (name, bytes) in [
        ("skia-aa-heap", SKIA_HEAP_BYTES),
        ("heap", heap),
        ("gei-types", gei_types),
        ("study-pack", study_pack),
    ] {
        write(&format!("bytes/{name}"), bytes)?;
    }
    Ok(())
}

/// Writes a size as criterion writes its estimates.
fn write(name: &str, bytes: usize) -> Result<(), Box<dyn Error>> {
    let beside = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("criterion");
    let criterion = env::var_os("CRITERION_HOME").map_or(beside, PathBuf::from);
    let folder = criterion.join(name).join("new");
    fs::create_dir_all(&folder)?;
    let benchmark = json!({ "full_id": name });
    fs::write(folder.join("benchmark.json"), benchmark.to_string())?;
    let estimates = json!({ "bytes": { "point_estimate": bytes } });
    fs::write(folder.join("estimates.json"), estimates.to_string())?;
    println!("{name}: {bytes}");
    Ok(())
}

/// Returns the bytes that are requested to make a GEI with each rasteriser but `skia-aa`, in each
/// size.
fn heap_bytes() -> Result<usize, Box<dyn Error>> {
    let before = ASKED_BYTES.get();
    let mut body = UnpackedBody::default();
    let box_of_corners =
        (0..8u8).map(|corner| Vec3::from([0, 1, 2].map(|axis| f32::from(corner >> axis & 1))));
    body.push(Joint::Pelvis, box_of_corners)?;
    let figure = Figure::at_rest(&body);
    let camera = Camera::orthographic(Viewpoint::from_degrees(30.0, 20.0)?);
    for rasterizer in [Rasterizer::Skia, Rasterizer::Rows, Rasterizer::Rows3x3] {
        for size in Size::ALL {
            let mut renderer = Renderer::new(rasterizer, size);
            let mut gei = GeiBuilder::new(size);
            for _ in 0..32 {
                let drawing = renderer.draw(&figure, &camera, Framing::Height, Vec2::ZERO)?;
                gei.add(drawing.frame)?;
            }
            black_box(gei.gei());
        }
    }
    Ok(ASKED_BYTES.get() - before)
}
