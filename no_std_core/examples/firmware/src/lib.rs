//! Measurements of firmware by itself: instructions, stack and heap.
#![no_std]

#[cfg(feature = "skia")]
pub mod heap;
pub mod line;
pub mod memory;
pub mod meter;
