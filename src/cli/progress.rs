//! Progress of long work: a bar on a terminal, plain lines otherwise, on standard error.

use super::args::Common;
use super::stop::Stop;
use crate::error::{Result, visible_name};
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::VecDeque;
use std::io::IsTerminal as _;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Time before the first plain line, and between two others.
const FIRST: Duration = Duration::from_secs(1);
const INTERVAL: Duration = Duration::from_secs(3);

/// Number of plain lines over which the time of a piece is averaged.
const REMEMBERED: usize = 10;
/// Number of pieces in more than one batch, from which the remaining time is estimated at once.
const BATCHES: u64 = 20;
/// Remaining time, seconds, above which advice on reducing the work is printed.
const LONG_S: f64 = 600.0;

/// Counts done pieces of work and shows them.
#[derive(Debug)]
pub(super) struct Progress {
    /// What is done, and the unit of its pieces, such as "importing" and "files".
    what: (&'static str, &'static str),
    /// Number of pieces; none if it is unknown.
    total: Option<u64>,
    bar: Option<ProgressBar>,
    plain: Mutex<Plain>,
    /// Advice about long work, printed once.
    advice: Option<&'static str>,
    is_quiet: bool,
    stop: Stop,
}

/// The state of plain lines.
#[derive(Debug)]
struct Plain {
    done: u64,
    /// Times at which lines were printed, with the pieces done by then; at first the start.
    printed: VecDeque<(Instant, u64)>,
    is_advised: bool,
}

impl Plain {
    /// Returns the remaining time, seconds, at the pace of the last lines.
    fn left_s(&self, now: Instant, total: u64) -> Option<f64> {
        // Pieces come in batches, and the first line may be about a batch that has only begun.
        if self.printed.len() < 2 && self.done < BATCHES {
            return None;
        }
        let &(since, done) = self.printed.front()?;
        let pieces = self.done.checked_sub(done).filter(|pieces| *pieces > 0)?;
        let each_s = (now - since).as_secs_f64() / pieces as f64;
        Some(each_s * total.saturating_sub(self.done) as f64)
    }

    /// Returns the advice about long work, the first time that the remaining time is long.
    fn advised(&mut self, advice: Option<&str>, left_s: Option<f64>) -> Option<String> {
        let left_s = left_s.filter(|left_s| *left_s > LONG_S && !self.is_advised)?;
        let advice = advice?;
        self.is_advised = true;
        Some(format!(
            "this takes about {} more: {advice}",
            time_of(left_s)
        ))
    }
}

/// Returns whether progress is shown as a bar.
fn has_bar(common: &Common) -> bool {
    std::io::stderr().is_terminal() && !common.quiet
}

impl Progress {
    /// Starts work of `total` pieces, if their number is known: what is done, and the unit of the
    /// pieces, as in ("importing", "files").
    #[must_use]
    pub(super) fn new(
        common: &Common,
        what: (&'static str, &'static str),
        total: impl Into<Option<usize>>,
    ) -> Self {
        let total = total.into().map(|total| total as u64);
        let bar = has_bar(common).then(|| {
            let (bar, template) = match total {
                Some(total) => (
                    ProgressBar::new(total),
                    "{msg} [{bar:30}] {pos}/{len}, {eta} left",
                ),
                None => (ProgressBar::no_length(), "{msg} {pos}"),
            };
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.set_message(format!("{} {}", what.0, what.1));
            bar
        });
        Self {
            what,
            total,
            bar,
            plain: Mutex::new(Plain {
                done: 0,
                printed: VecDeque::from([(Instant::now(), 0)]),
                is_advised: false,
            }),
            advice: None,
            is_quiet: common.quiet,
            stop: common.stop.clone(),
        }
    }

    /// Adds advice, which is printed if the work takes more than ten minutes longer.
    #[must_use]
    pub(super) fn advising(mut self, advice: &'static str) -> Self {
        self.advice = Some(advice);
        self
    }

    /// Checks before a long piece whether the work may go on.
    ///
    /// # Errors
    /// If it is to end.
    pub(super) fn check(&self) -> Result<()> {
        self.stop.check()
    }

    /// Counts a finished piece. Without a terminal, prints a line every few seconds, so that short
    /// work prints none.
    ///
    /// # Errors
    /// If the work is to end.
    pub(super) fn step(&self) -> Result<()> {
        self.stop.check()?;
        self.count();
        Ok(())
    }

    fn count(&self) {
        if let Some(bar) = &self.bar {
            bar.inc(1);
        }
        let Ok(mut plain) = self.plain.lock() else {
            return;
        };
        if self.is_quiet {
            return;
        }
        plain.done += 1;
        let now = Instant::now();
        let is_first = plain.printed.len() < 2;
        let interval = if is_first { FIRST } else { INTERVAL };
        if plain
            .printed
            .back()
            .is_some_and(|(then, _)| now - *then < interval)
        {
            return;
        }
        let left_s = self.total.and_then(|total| plain.left_s(now, total));
        let line = line_of(self.what, plain.done, self.total, left_s, is_first);
        let done = plain.done;
        plain.printed.push_back((now, done));
        if plain.printed.len() > REMEMBERED {
            plain.printed.pop_front();
        }
        let advice = plain.advised(self.advice, left_s);
        match (&self.bar, advice) {
            (Some(bar), Some(advice)) => bar.println(advice),
            (Some(_), None) => {}
            (None, advice) => {
                eprintln!("{line}");
                advice.iter().for_each(|advice| eprintln!("{advice}"));
            }
        }
    }
}

/// Returns a plain line. The first one states the whole work.
fn line_of(
    (doing, unit): (&str, &str),
    done: u64,
    total: Option<u64>,
    left_s: Option<f64>,
    is_first: bool,
) -> String {
    let left = left_s.map(time_of);
    match (total, left) {
        (Some(total), Some(left)) if is_first => format!("{doing} {total} {unit}, about {left}"),
        (Some(total), None) if is_first => format!("{doing} {total} {unit}"),
        (Some(total), Some(left)) => format!("{doing} {unit}: {done} of {total}, {left} left"),
        (Some(total), None) => format!("{doing} {unit}: {done} of {total}"),
        (None, _) => format!("{doing} {unit}: {done}"),
    }
}

/// Formats a duration in seconds for people: `40 s`, `12 min`, `3 h 20 min`.
#[must_use]
pub(super) fn time_of(seconds: f64) -> String {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates far beyond any work"
    )]
    let whole = seconds.max(0.0).round() as u64;
    // From 100 s on, whole minutes.
    let minutes = (whole + 30) / 60;
    match (whole, minutes) {
        (0..100, _) => format!("{whole} s"),
        (_, 0..100) => format!("{minutes} min"),
        _ if minutes.is_multiple_of(60) => format!("{} h", minutes / 60),
        _ => format!("{} h {} min", minutes / 60, minutes % 60),
    }
}

/// Shows the current work and a remaining time that the caller states.
#[derive(Debug)]
pub(super) struct TimedProgress {
    bar: Option<ProgressBar>,
    /// The last printed work, and when it was printed.
    printed: Mutex<(String, Instant)>,
    is_quiet: bool,
    stop: Stop,
}

impl TimedProgress {
    /// Starts the display.
    #[must_use]
    pub(super) fn new(common: &Common) -> Self {
        let bar = has_bar(common).then(|| {
            let bar = ProgressBar::new_spinner();
            if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} [{elapsed}]") {
                bar.set_style(style);
            }
            bar
        });
        Self {
            bar,
            printed: Mutex::new((String::new(), Instant::now())),
            is_quiet: common.quiet,
            stop: common.stop.clone(),
        }
    }

    /// Shows the current work and the remaining time of all work. Without a terminal, prints a line
    /// every few seconds, and one for each new kind of work if much time remains.
    ///
    /// # Errors
    /// If the work is to end.
    pub(super) fn now(&self, what: &str, left_s: f64) -> Result<()> {
        self.stop.check()?;
        self.show(what, left_s);
        Ok(())
    }

    fn show(&self, what: &str, left_s: f64) {
        let what = visible_name(what);
        let line = format!("{what}, about {} left", time_of(left_s));
        if let Some(bar) = &self.bar {
            bar.set_message(line);
            return;
        }
        let Ok(mut printed) = self.printed.lock() else {
            return;
        };
        if self.is_quiet {
            return;
        }
        let is_new = printed.0 != *what && left_s > 10.0 * INTERVAL.as_secs_f64();
        if is_new || printed.1.elapsed() >= INTERVAL {
            *printed = (what.into_owned(), Instant::now());
            eprintln!("{line}");
        }
    }
}

impl Drop for TimedProgress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_begin_with_what_is_done_and_end_with_what_is_left() {
        let line =
            |total, left_s, is_first| line_of(("drawing", "cycles"), 30, total, left_s, is_first);
        let all = Some(90);
        assert_eq!(line(all, None, true), "drawing 90 cycles");
        assert_eq!(line(all, Some(8.4), true), "drawing 90 cycles, about 8 s");
        assert_eq!(
            line(all, Some(8.4), false),
            "drawing cycles: 30 of 90, 8 s left"
        );
        assert_eq!(line(None, None, false), "drawing cycles: 30");
    }

    #[test]
    fn times_are_in_the_unit_that_people_use() {
        let times = [0.4, 99.4, 100.0, 209.0, 5939.0, 5971.0, 7200.0, 12_000.0];
        let expected = [
            "0 s",
            "99 s",
            "2 min",
            "3 min",
            "99 min",
            "1 h 40 min",
            "2 h",
            "3 h 20 min",
        ];
        assert_eq!(times.map(time_of), expected);
    }

    #[test]
    fn long_work_is_advised_about_once() {
        let mut plain = Plain {
            done: 0,
            printed: VecDeque::new(),
            is_advised: false,
        };
        let advice = Some("ask for less");
        assert_eq!(plain.advised(advice, None), None);
        assert_eq!(plain.advised(advice, Some(600.0)), None);
        assert_eq!(plain.advised(None, Some(7200.0)), None);
        let said = plain.advised(advice, Some(7200.0));
        assert_eq!(
            said.as_deref(),
            Some("this takes about 2 h more: ask for less")
        );
        assert_eq!(plain.advised(advice, Some(7200.0)), None);
    }

    #[test]
    fn what_is_left_follows_the_pace_of_the_last_lines() {
        let begin = Instant::now();
        let at = |s: u64| begin + Duration::from_secs(s);
        // A hundred that were known already, then one every two seconds.
        let plain = Plain {
            done: 110,
            printed: VecDeque::from([(at(3), 100), (at(13), 108)]),
            is_advised: false,
        };
        assert_eq!(plain.left_s(at(23), 210), Some(200.0));
        assert_eq!(plain.left_s(at(23), 110), Some(0.0));
        let none = Plain { done: 100, ..plain };
        assert_eq!(none.left_s(at(23), 210), None);
        // One of a batch whose others are done in the same moment.
        let first = Plain {
            done: 1,
            printed: VecDeque::from([(begin, 0)]),
            is_advised: false,
        };
        assert_eq!(first.left_s(at(5), 18_278), None);
    }
}
