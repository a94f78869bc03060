//! How large the batches are that are measured.

use super::cap::{Share, batch_within, largest};
use super::measure::Task;
use super::memory;
use super::timed::First;
use crate::error::Result;
use crate::score::Recognizer;

/// The share of the memory that the machine can give that a batch may take. Ours.
const MEMORY_SHARE: f64 = 0.8;

/// How large batches can be.
pub(super) enum Sized {
    /// Of so many inferences; why not of more, if so.
    Of(usize, &'static str),
    /// Not at all, and why.
    No(&'static str),
}

impl Sized {
    /// How it is less than was asked for, in words; none if it is not.
    pub(super) fn less_than(&self, asked: usize) -> Option<String> {
        match *self {
            Self::Of(size, _) if size >= asked => None,
            Self::Of(size, why) => Some(format!("batches of {size}, not {asked} ({why})")),
            Self::No(why) => Some(format!("no batches ({why})")),
        }
    }
}

/// How large batches can be in the time and the memory that there are: a batch of two says how much
/// memory one more takes, before one of many ends the process.
pub(super) fn batch(
    (recognizer, draw): (&dyn Recognizer, &dyn Fn(usize) -> Result<Vec<f32>>),
    (task, share): (&Task<'_>, &Share),
    (first, call_s): (&First, f64),
) -> Result<Sized> {
    const TIME: &str = "others would take too long";
    const MEMORY: &str = "others would take more memory than there is";
    let asked = task.batch;
    let all_s = task.plan.takes_s(asked as f64 * call_s, asked);
    let size = if all_s <= share.most_s {
        Some(asked)
    } else {
        batch_within(share.most_s - 2.0 * call_s, call_s, asked)
    };
    let Some(size) = size else {
        return Ok(Sized::No(TIME));
    };
    if size <= 2 {
        return Ok(Sized::Of(size, TIME));
    }
    memory::forget_peak();
    recognizer.run(&draw(2)?, 2)?;
    let more = memory::peak_rss_bytes()
        .zip(first.peak_rss_bytes)
        .map_or(0, |(two, one)| two.saturating_sub(one));
    let available = memory::available_bytes().map_or(f64::INFINITY, |bytes| bytes as f64);
    let is_held = |size: usize| (size - 1) as f64 * more as f64 <= MEMORY_SHARE * available;
    Ok(match largest(size, is_held) {
        Some(held) if held < size => Sized::Of(held, MEMORY),
        Some(size) => Sized::Of(size, TIME),
        None => Sized::No(MEMORY),
    })
}
