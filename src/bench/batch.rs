//! The sizes of the batches that are measured.

use super::memory;
use super::time_budget::{batch_within, largest};
use super::timed_model::{FirstInference, TimedWork};
use crate::error::Result;
use crate::inference::Recognizer;

/// The largest share of the available memory that a batch may take. Our choice.
const MEMORY_SHARE: f64 = 0.8;

/// The largest possible batch.
pub(super) enum Sized {
    /// A batch of this many inferences, and the reason why it is not larger.
    Of(usize, &'static str),
    /// No batch is possible, with the reason.
    No(&'static str),
}

impl Sized {
    /// Describes how the batch is smaller than requested; none if it is not.
    pub(super) fn less_than(&self, asked: usize) -> Option<String> {
        match *self {
            Self::Of(size, _) if size >= asked => None,
            Self::Of(size, why) => Some(format!("batches of {size}, not {asked} ({why})")),
            Self::No(why) => Some(format!("no batches ({why})")),
        }
    }
}

const TIME: &str = "larger ones would take too long";
const MEMORY: &str = "larger ones would take more memory than there is";

/// Returns the largest batch that fits the time and the memory. A batch of two shows how much
/// memory each further inference takes, before a large one ends the process.
pub(super) fn batch(
    recognizer: &dyn Recognizer,
    draw: &dyn Fn(usize) -> Result<Vec<f32>>,
    first: &FirstInference,
    work: &TimedWork<'_>,
) -> Result<Sized> {
    let &TimedWork {
        plan,
        share,
        call_s,
        batch: asked,
    } = work;
    let all_s = plan.takes_s(asked as f64 * call_s, asked);
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
    Ok(held(size, more as f64, available))
}

/// Returns the largest batch of at most `size` that memory allows, if each further inference takes
/// `more` of the `available` bytes.
fn held(size: usize, more: f64, available: f64) -> Sized {
    let is_held = |size: usize| (size - 1) as f64 * more <= MEMORY_SHARE * available;
    match largest(size, is_held) {
        Some(held) if held < size => Sized::Of(held, MEMORY),
        Some(size) => Sized::Of(size, TIME),
        None => Sized::No(MEMORY),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 8 of 10 MB may be taken: three further inferences at 2.5 MB each, 31 at 0.25 MB.
    #[test]
    fn a_batch_takes_no_more_memory_than_there_is() {
        let said = |size, more| held(size, more, 10e6).less_than(64);
        let memory = |size| Some(format!("batches of {size}, not 64 ({MEMORY})"));
        assert_eq!(said(64, 0.0), None);
        assert_eq!(said(64, 0.12e6), None);
        assert_eq!(said(64, 0.13e6), memory(32));
        assert_eq!(said(64, 2.5e6), memory(4));
        assert_eq!(said(64, 7.9e6), memory(2));
        assert_eq!(said(64, 8.1e6), Some(format!("no batches ({MEMORY})")));
        // The time limit had already reduced the batch.
        assert_eq!(
            said(16, 0.13e6),
            Some(format!("batches of 16, not 64 ({TIME})"))
        );
        assert_eq!(said(16, 2.5e6), memory(4));
        assert_eq!(held(64, 1e9, f64::INFINITY).less_than(64), None);
    }
}
