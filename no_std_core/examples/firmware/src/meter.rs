//! A count of instructions by the emulator's clock.

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;

/// The value from which SysTick counts down.
const FULL: u32 = 0x00ff_ffff;
/// Nanoseconds of one instruction: `-icount shift=6`.
const INSTRUCTION_NS: u64 = 64;
/// Nanoseconds of one tick of the emulated board, from `build.rs`.
const TICK_NS: u64 = match u64::from_str_radix(env!("TICK_NS"), 10) {
    Ok(ns) => ns,
    Err(_) => panic!("TICK_NS is a number"),
};

/// The number of times that SysTick has reached 0.
static ENDS: AtomicU32 = AtomicU32::new(0);

#[exception]
fn SysTick() {
    ENDS.store(ENDS.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
}

/// A counter of instructions. It is meaningful only in QEMU with `-icount shift=6`, and counts
/// instructions, neither cycles nor time.
pub struct Meter {
    empty: u64,
}

impl Meter {
    /// Starts SysTick.
    #[must_use]
    pub fn new(peripherals: Peripherals) -> Self {
        let mut syst = peripherals.SYST;
        syst.set_clock_source(SystClkSource::Core);
        syst.set_reload(FULL);
        syst.clear_current();
        syst.enable_interrupt();
        syst.enable_counter();
        let mut meter = Self { empty: 0 };
        (_, meter.empty) = meter.count(|| ());
        meter
    }

    /// Runs `work`, and returns its result and its number of instructions, to about one in ten
    /// million.
    pub fn count<R>(&mut self, work: impl FnOnce() -> R) -> (R, u64) {
        let before = ticks();
        let result = work();
        let instructions = (ticks() - before) * TICK_NS / INSTRUCTION_NS;
        (result, instructions.saturating_sub(self.empty))
    }
}

/// Returns the ticks since SysTick began.
fn ticks() -> u64 {
    loop {
        let ends = ENDS.load(Ordering::Relaxed);
        let passed = FULL - SYST::get_current();
        if ends == ENDS.load(Ordering::Relaxed) {
            return u64::from(ends) * (u64::from(FULL) + 1) + u64::from(passed);
        }
    }
}
