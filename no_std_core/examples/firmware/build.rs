//! Writes the memory map of each program, with only the RAM that it may use, so that the linker
//! rejects anything larger.

use std::path::PathBuf;
use std::{env, fs};

const KIB: u32 = 1024;

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    let target = env::var("TARGET").expect("cargo sets it");
    // The boards mps2-an505 (its secure alias; 20 MHz) and mps2-an386 (25 MHz) in QEMU.
    let (flash, ram, tick_ns) = if target.starts_with("thumbv8m") {
        (0x1000_0000, 0x3800_0000, 50)
    } else {
        (0, 0x2000_0000_u32, 40)
    };
    println!("cargo:rustc-env=TICK_NS={tick_ns}");
    for (program, flash_kib, ram_kib) in [("study", 256, 16), ("golden", 4096, 2048)] {
        let folder = out.join(program);
        let map = format!(
            "MEMORY {{\n  FLASH : ORIGIN = {flash:#x}, LENGTH = {}\n  RAM : ORIGIN = {ram:#x}, LENGTH = {}\n}}\n",
            flash_kib * KIB,
            ram_kib * KIB,
        );
        fs::create_dir_all(&folder).expect("a folder for the build");
        fs::write(folder.join("memory.x"), map).expect("a place for the build");
        println!("cargo:rustc-link-arg-bin={program}=-L{}", folder.display());
    }
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=--nmagic");
    println!("cargo:rerun-if-changed=build.rs");
}
