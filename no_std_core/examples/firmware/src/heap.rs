//! An arena for tiny-skia, with its peak use.

use core::alloc::{GlobalAlloc, Layout};
use core::sync::atomic::{AtomicUsize, Ordering};
use embedded_alloc::LlffHeap;

struct Counted {
    heap: LlffHeap,
    peak: AtomicUsize,
}

#[global_allocator]
static HEAP: Counted = Counted {
    heap: LlffHeap::empty(),
    peak: AtomicUsize::new(0),
};

// SAFETY: every call goes to the inner allocator.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promises are passed on.
        let block = unsafe { self.heap.alloc(layout) };
        self.peak.fetch_max(self.heap.used(), Ordering::Relaxed);
        block
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are passed on.
        unsafe { self.heap.dealloc(block, layout) }
    }
}

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
    unsafe { HEAP.heap.init(start.addr(), bytes) }
}

/// Returns the most bytes of the arena that were in use together, with the allocator's overhead.
#[must_use]
pub fn peak() -> usize {
    HEAP.peak.load(Ordering::Relaxed)
}
