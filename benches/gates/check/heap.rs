//! Counts the heap memory that drawing with bit rows uses.
#![expect(unsafe_code, reason = "a counting global allocator requires it")]

use edgegait::error::{Error, Result};
use edgegait_core::body::{Figure, UnpackedBody};
use edgegait_core::camera::{Camera, Framing, Viewpoint};
use edgegait_core::raster::{Rasterizer, Renderer};
use edgegait_core::silhouette::Size;
use edgegait_core::skeleton::Joint;
use edgegait_core::template::GeiBuilder;
use glam::{Vec2, Vec3};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

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

/// Returns the bytes that are requested to make a GEI with each sampling of bit rows, in each size.
pub fn rows_heap_bytes() -> Result<usize> {
    let failed = |error: &dyn std::error::Error| Error::Failed(format!("heap of rows: {error}"));
    let before = ASKED_BYTES.get();
    let mut body = UnpackedBody::default();
    let box_of_corners =
        (0..8u8).map(|corner| Vec3::from([0, 1, 2].map(|axis| f32::from(corner >> axis & 1))));
    body.push(Joint::Pelvis, box_of_corners)
        .map_err(|error| failed(&error))?;
    let figure = Figure::at_rest(&body);
    let viewpoint = Viewpoint::from_degrees(30.0, 20.0).map_err(|error| failed(&error))?;
    let camera = Camera::orthographic(viewpoint);
    for rasterizer in [Rasterizer::Rows, Rasterizer::Rows3x3] {
        for size in Size::ALL {
            let mut renderer = Renderer::new(rasterizer, size);
            let mut gei = GeiBuilder::new(size);
            for _ in 0..32 {
                let drawing = renderer.draw(&figure, &camera, Framing::Height, Vec2::ZERO);
                let frame = drawing.map_err(|error| failed(&error))?.frame;
                gei.add(frame).map_err(|error| failed(&error))?;
            }
            black_box(gei.gei());
        }
    }
    Ok(ASKED_BYTES.get() - before)
}
