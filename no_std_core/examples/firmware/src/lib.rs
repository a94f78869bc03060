//! Measurements of firmware by itself: instructions and memory.
#![no_std]

#[cfg(feature = "tiny-skia")]
pub mod heap;
pub mod line;
pub mod memory;
pub mod meter;
