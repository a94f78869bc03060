//! An arena for tiny-skia.

use embedded_alloc::LlffHeap;

#[global_allocator]
static HEAP: LlffHeap = LlffHeap::empty();

/// Makes an arena of this many bytes the heap; call it once, before anything is allocated.
#[macro_export]
macro_rules! arena {
    ($bytes:expr) => {{
        // In words of 8 bytes, so that none are lost to alignment.
        static mut ARENA: [core::mem::MaybeUninit<u64>; $bytes / 8] =
            [core::mem::MaybeUninit::uninit(); $bytes / 8];
        // SAFETY: called once, and the arena is named nowhere else.
        unsafe { $crate::heap::init(core::ptr::addr_of_mut!(ARENA).cast(), $bytes) }
    }};
}

/// Gives the heap its memory.
///
/// # Safety
/// `start..start + bytes` must belong to the heap alone, and this must be called only once.
pub unsafe fn init(start: *mut u8, bytes: usize) {
    // SAFETY: the caller's promise.
    unsafe { HEAP.init(start.addr(), bytes) }
}
