//! An arena for tiny-skia, and the most of it that was used.

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

// SAFETY: all is left to the allocator within.
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

/// Makes an arena of so many bytes the heap; once, before anything is allocated.
#[macro_export]
macro_rules! arena {
    ($bytes:expr) => {{
        // In words of 8 bytes, so that none are lost to alignment.
        static mut ARENA: [core::mem::MaybeUninit<u64>; $bytes / 8] =
            [core::mem::MaybeUninit::uninit(); $bytes / 8];
        // SAFETY: once, and named nowhere else.
        unsafe { $crate::heap::init(core::ptr::addr_of_mut!(ARENA).cast(), $bytes) }
    }};
}

/// # Safety
/// `start..start + bytes` belongs to the heap alone, and this is called once.
pub unsafe fn init(start: *mut u8, bytes: usize) {
    // SAFETY: the caller's promise.
    unsafe { HEAP.heap.init(start.addr(), bytes) }
}

/// Most bytes of the arena that were in use at once, with what the allocator adds to blocks.
#[must_use]
pub fn peak() -> usize {
    HEAP.peak.load(Ordering::Relaxed)
}
