//! Memory: the linker's sections, and the deepest use of the stack, which is painted before `main`.

use core::ptr;

unsafe extern "C" {
    /// The top of the stack, and section bounds, from the linker script of `cortex-m-rt`.
    static _stack_start: u32;
    static __sheap: u32;
    static __sdata: u32;
    static __stext: u32;
    static __etext: u32;
    static __srodata: u32;
    static __erodata: u32;
}

/// Returns the bytes of RAM that the stack has used until now.
///
/// # Panics
/// If no paint is left: the stack has then run into static memory.
#[must_use]
pub fn stack_used() -> usize {
    let (mut at, top) = (ptr::addr_of!(__sheap), ptr::addr_of!(_stack_start));
    // SAFETY: words of RAM between static memory and the top of the stack.
    while at < top && unsafe { at.read_volatile() } == cortex_m_rt::STACK_PAINT_VALUE {
        // SAFETY: not beyond the top.
        at = unsafe { at.add(1) };
    }
    assert!(
        at != ptr::addr_of!(__sheap),
        "the stack has run into static memory"
    );
    top.addr() - at.addr()
}

/// Returns the bytes of static memory.
#[must_use]
pub fn static_bytes() -> usize {
    ptr::addr_of!(__sheap).addr() - ptr::addr_of!(__sdata).addr()
}

/// Returns the bytes of flash: code, and constants, which include packs.
#[must_use]
pub fn flash_bytes() -> [usize; 2] {
    let between = |from: *const u32, to: *const u32| to.addr() - from.addr();
    [
        between(ptr::addr_of!(__stext), ptr::addr_of!(__etext)),
        between(ptr::addr_of!(__srodata), ptr::addr_of!(__erodata)),
    ]
}
