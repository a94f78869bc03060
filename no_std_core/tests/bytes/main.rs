//! Bytes: packs and recognizers that are read, types that hold them, and what is made of them
//! everywhere alike.

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
