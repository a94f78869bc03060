//! Tests of bytes: reading packs and recognizers, sizes of types, and results that are equal on
//! every target.

mod cycles;
mod format;
#[path = "../golden/mod.rs"]
mod golden;
mod hostile;
mod linear;
#[path = "../random/mod.rs"]
mod random;
mod same_bytes;
mod sizes;
#[path = "../small_pack/mod.rs"]
mod small_pack;
