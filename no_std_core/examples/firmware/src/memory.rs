//! Memory: what the linker gave out, and the deepest that the stack has been, by what it was
//! painted with before `main`.

use core::ptr;

unsafe extern "C" {
    /// Top of the stack, and the end of static memory, from the linker script of `cortex-m-rt`.
    static _stack_start: u32;
    static __sheap: u32;
    static __sdata: u32;
    static __stext: u32;
    static __etext: u32;
    static __srodata: u32;
    static __erodata: u32;
}

/// Bytes of RAM that the stack has used until now.
///
/// # Panics
/// If nothing of the paint is left: then it has run into static memory.
#[must_use]
pub fn stack_used() -> usize {
    let (mut at, top) = (ptr::addr_of!(__sheap), ptr::addr_of!(_stack_start));
    // SAFETY: words of RAM between what is static and the top of the stack.
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

/// Bytes of static memory.
#[must_use]
pub fn static_bytes() -> usize {
    ptr::addr_of!(__sheap).addr() - ptr::addr_of!(__sdata).addr()
}

/// Bytes of flash: code, and constants, of which packs are a part.
#[must_use]
pub fn flash_bytes() -> [usize; 2] {
    let between = |from: *const u32, to: *const u32| to.addr() - from.addr();
    [
        between(ptr::addr_of!(__stext), ptr::addr_of!(__etext)),
        between(ptr::addr_of!(__srodata), ptr::addr_of!(__erodata)),
    ]
}
