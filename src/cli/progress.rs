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
    total: u64,
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
        let total = total as u64;
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(total);
            if let Ok(style) =
                ProgressStyle::with_template("{msg:>12} [{bar:40}] {pos}/{len}, {eta} left")
            {
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
            eprintln!("{}: {} of {}", self.what, plain.done, self.total);
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
