//! Progress of long work: a bar on a terminal, plain lines otherwise, on standard error.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal as _;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Time between two plain lines.
const INTERVAL: Duration = Duration::from_secs(3);

/// Counts done pieces of work and shows them.
#[derive(Debug)]
pub(super) struct Progress {
    what: &'static str,
    /// None where it is not known.
    total: Option<u64>,
    bar: Option<ProgressBar>,
    plain: Mutex<Plain>,
}

/// What plain lines need to know.
#[derive(Debug)]
struct Plain {
    done: u64,
    printed: Instant,
}

impl Progress {
    /// Starts work of `total` pieces; `what` says which, for example "walks".
    #[must_use]
    pub(super) fn new(what: &'static str, total: usize) -> Self {
        Self::of(what, Some(total as u64))
    }

    /// Starts work of which nobody knows how many pieces it has.
    #[must_use]
    pub(super) fn counting(what: &'static str) -> Self {
        Self::of(what, None)
    }

    fn of(what: &'static str, total: Option<u64>) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let (bar, template) = match total {
                Some(total) => (
                    ProgressBar::new(total),
                    "{msg:>12} [{bar:40}] {pos}/{len}, {eta} left",
                ),
                None => (ProgressBar::no_length(), "{msg:>12} {pos}"),
            };
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.set_message(what);
            bar
        });
        Self {
            what,
            total,
            bar,
            plain: Mutex::new(Plain {
                done: 0,
                printed: Instant::now(),
            }),
        }
    }

    /// One piece is done. Without a terminal a line is printed every few seconds, so that
    /// short work prints none.
    pub(super) fn step(&self) {
        if let Some(bar) = &self.bar {
            bar.inc(1);
            return;
        }
        let Ok(mut plain) = self.plain.lock() else {
            return;
        };
        plain.done += 1;
        if plain.printed.elapsed() >= INTERVAL {
            plain.printed = Instant::now();
            match self.total {
                Some(total) => eprintln!("{}: {} of {total}", self.what, plain.done),
                None => eprintln!("{}: {}", self.what, plain.done),
            }
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
