//! Computes the list of hashes that must be equal on every target, and compares it with the list
//! that the core's tests use on a host. Draws with every rasteriser, unpacked bodies too, in far
//! more memory than `study` has.
#![no_std]
#![no_main]

#[path = "../../../../tests/golden/mod.rs"]
mod golden;

use core::fmt::{Arguments, Write};
use cortex_m_rt::entry;
use edgegait_firmware::line::Line;
use semihosting::{println, process};

#[entry]
fn main() -> ! {
    edgegait_firmware::arena!(32 * 1024);
    let mut expected = golden::HASHES.lines();
    let (mut equal, mut other) = (0, 0);
    golden::list(&mut |name: Arguments<'_>, hash| {
        let mut text = Line::EMPTY;
        let _ = write!(text, "{name} {:016x}", hash.0);
        let line = expected.next().unwrap_or("no line");
        if text.as_str() == line {
            equal += 1;
        } else {
            other += 1;
            println!("{name} {:016x}: expected {line}", hash.0);
        }
    });
    let missing = expected.count();
    println!("golden: {equal} hashes equal, {other} not, {missing} not made");
    process::exit(i32::from(other + missing > 0 || equal == 0));
}
