//! Tests of drawing against independent plain code.

mod columns;
mod compact;
mod draped;
mod framing;
mod grey;
mod hard;
mod oracle;
#[path = "../plain/mod.rs"]
mod plain;
#[path = "../plain_avatar/mod.rs"]
mod plain_avatar;
#[path = "../random/mod.rs"]
mod random;
mod rows;
mod simd;
#[path = "../small_pack/mod.rs"]
#[expect(dead_code, reason = "clips alone are for other tests")]
mod small_pack;
mod template;
