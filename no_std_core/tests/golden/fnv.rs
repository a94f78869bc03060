//! The hash of drawn images.

/// An FNV-1a hash of 64 bits (Fowler, Noll & Vo 1991).
#[derive(Clone, Copy)]
pub struct Fnv(pub u64);

impl Fnv {
    pub const NEW: Self = Self(0xcbf2_9ce4_8422_2325);

    pub fn add(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}
