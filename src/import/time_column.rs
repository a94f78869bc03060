//! The times of a table's rows: their unit, their rate, and rows at even times.
//!
//! Cameras drop frames and webcams take them unevenly, so rows are not always one period apart.
//! Everything after the readers needs even frames, so uneven rows are interpolated here.

use glam::DVec3;

use super::RATE_HZ;

/// Largest relative difference between the header's rate and the times'. Our choice.
const RATE_TOLERANCE: f64 = 0.005;

/// Largest error of the time between two rows, seconds: times are rounded, often to a millisecond.
const ROUNDING_S: f64 = 0.001;

/// Largest relative difference between a rate and the usual step of uneven or rounded times. Our
/// choice: units differ by a factor of 60 at least.
const STEP_TOLERANCE: f64 = 0.05;

/// Largest distance of a row from its even time, as a share of a step, at which rows count as even.
/// Our choice.
const EVEN: f64 = 0.1;

/// Longest time between two rows between which others are interpolated, seconds: as for gaps of
/// single markers. Nothing is seen in longer ones.
const LONGEST_GAP_S: f64 = 0.2;

/// The units of time columns beside seconds: seconds in one, and their name.
const UNITS: [(f64, &str); 3] = [
    (1e-3, "milliseconds"),
    (1e-6, "microseconds"),
    (60.0, "minutes"),
];

/// The markers of a row: positions of those that were seen.
type Row = Vec<Option<DVec3>>;

/// The times of the rows of a table, one each.
pub(super) struct TimeColumn {
    /// The times, ascending unless the user gives a rate.
    pub(super) times: Vec<f64>,
    /// The numbers of the rows' frames, ascending.
    pub(super) numbers: Vec<f64>,
    /// The smallest difference that the times' digits can state.
    pub(super) resolution: f64,
}

/// The rates that a file's header and the user state, Hz.
#[derive(Clone, Copy)]
pub(super) struct StatedRates<'a> {
    /// The header's, as text.
    pub(super) header: &'a str,
    /// The header's, if it is possible.
    pub(super) header_hz: Option<f64>,
    /// The user's, which prevails.
    pub(super) given_hz: Option<f64>,
}

/// Rows at even times.
pub(super) struct EvenRows {
    pub(super) rows: Vec<Row>,
    pub(super) rate_hz: f64,
}

impl TimeColumn {
    /// Returns rows at even times, and their rate: the given one, else the header's if the times
    /// agree, else the times' own. Rows that are even already stay as they are.
    ///
    /// # Errors
    /// A sentence, if neither the times nor the header give a possible rate, or there would be more
    /// than `most` rows.
    pub(super) fn even_rows(
        mut self,
        rows: Vec<Row>,
        stated: StatedRates<'_>,
        most: usize,
        warnings: &mut Vec<String>,
    ) -> Result<EvenRows, String> {
        let ascend = self.times.windows(2).all(|pair| pair[1] > pair[0]);
        if self.times.len() < 2 || !ascend {
            let rate_hz = stated.given_hz.or(stated.header_hz);
            let rate_hz = rate_hz.ok_or_else(|| impossible(stated.header))?;
            return Ok(EvenRows { rows, rate_hz });
        }
        self.count_in_seconds(stated, warnings);
        if self.is_even() {
            let rate_hz = self.rate_hz(stated, warnings)?;
            return Ok(EvenRows { rows, rate_hz });
        }
        let step_s = self.usual_step();
        if let Some(given) = stated.given_hz
            && !agree(step_s * given)
        {
            warnings.push(format!(
                "the time column is uneven and its usual step of {step_s:.4} s is not that of {given} Hz: it is not used"
            ));
            return Ok(EvenRows {
                rows,
                rate_hz: given,
            });
        }
        let known = stated.header_hz.filter(|rate| agree(step_s * rate));
        let rate_hz = stated.given_hz.or(known).unwrap_or(1.0 / step_s);
        if !RATE_HZ.contains(&rate_hz) {
            return Err(impossible(stated.header));
        }
        let even = self.interpolated(&rows, rate_hz, most)?;
        let steps = || self.times.windows(2).map(|pair| pair[1] - pair[0]);
        let open = steps().filter(|step| *step > LONGEST_GAP_S).count();
        warnings.push(format!(
            "the time column is uneven, with steps of {:.4} to {:.4} s: rows are interpolated to {rate_hz:.2} Hz{}",
            steps().fold(f64::INFINITY, f64::min),
            steps().fold(0.0, f64::max),
            match open {
                0 => String::new(),
                open => format!(", except in {open} gaps of more than {LONGEST_GAP_S} s"),
            }
        ));
        Ok(EvenRows {
            rows: even,
            rate_hz,
        })
    }

    /// Converts the times to seconds. Without a unit, they are seconds, unless a stated rate or the
    /// range of possible rates shows another unit.
    fn count_in_seconds(&mut self, stated: StatedRates<'_>, warnings: &mut Vec<String>) {
        let (usual, mean) = (self.usual_step(), self.mean_step());
        let fits = |unit_s: f64| match stated.given_hz.or(stated.header_hz) {
            Some(rate) => agree(usual * unit_s * rate) || agree(mean * unit_s * rate),
            None => RATE_HZ.contains(&(1.0 / (usual * unit_s))),
        };
        if fits(1.0) {
            return;
        }
        let unit = UNITS.into_iter().find(|(unit_s, _)| fits(*unit_s));
        let counts_frames = || self.times == self.numbers;
        let rate = stated.given_hz.or(stated.header_hz);
        let (unit_s, name) = match (unit, rate) {
            (Some(unit), _) => unit,
            (None, Some(rate)) if counts_frames() => (1.0 / (usual * rate), "frames"),
            _ => return,
        };
        warnings.push(format!("the time column is in {name}, not seconds"));
        for time in &mut self.times {
            *time *= unit_s;
        }
        self.resolution *= unit_s;
    }

    /// Returns the rate of even rows, Hz.
    fn rate_hz(&self, stated: StatedRates<'_>, warnings: &mut Vec<String>) -> Result<f64, String> {
        if let Some(given) = stated.given_hz {
            return Ok(given);
        }
        let measured = 1.0 / self.mean_step();
        let tolerance = (ROUNDING_S / self.span()).max(RATE_TOLERANCE);
        match stated.header_hz {
            Some(stated) if (measured / stated - 1.0).abs() < tolerance => Ok(stated),
            _ if RATE_HZ.contains(&measured) => {
                warnings.push(format!(
                    "the header states `{}` Hz, the time column {measured:.2} Hz: the time column is used",
                    stated.header
                ));
                Ok(measured)
            }
            Some(header) => Err(format!(
                "the header states {header} Hz, but the time column has a row every {:.6} s: expected the same, in seconds",
                self.mean_step()
            )),
            None => Err(impossible(stated.header)),
        }
    }

    fn span(&self) -> f64 {
        self.times[self.times.len() - 1] - self.times[0]
    }

    fn mean_step(&self) -> f64 {
        self.span() / (self.times.len() - 1) as f64
    }

    /// Returns the median step.
    fn usual_step(&self) -> f64 {
        let mut steps: Vec<f64> = self
            .times
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .collect();
        steps.sort_by(f64::total_cmp);
        steps[steps.len() / 2]
    }

    /// Returns whether every time is near the even one, apart from rounding.
    fn is_even(&self) -> bool {
        let step = self.mean_step();
        let near = self.resolution.max(EVEN * step);
        let first = self.times[0];
        let mut numbered = self.times.iter().enumerate();
        numbered.all(|(row, time)| (time - first - row as f64 * step).abs() <= near)
    }

    /// Returns rows at even times from the first to the last.
    fn interpolated(&self, rows: &[Row], rate_hz: f64, most: usize) -> Result<Vec<Row>, String> {
        let near = self.resolution.max(EVEN / rate_hz);
        let count = ((self.span() + near) * rate_hz).floor() + 1.0;
        if count > most as f64 {
            return Err(format!(
                "the time column spans {count} frames at {rate_hz:.2} Hz, expected at most {most}: cut the recording"
            ));
        }
        let mut before = 0;
        let mut even = Vec::with_capacity(count as usize);
        for frame in 0..count as usize {
            let time = self.times[0] + frame as f64 / rate_hz;
            while before + 2 < rows.len() && self.times[before + 1] <= time {
                before += 1;
            }
            let [here, next] = [before, before + 1].map(|row| (self.times[row] - time).abs());
            even.push(if here.min(next) <= near {
                rows[before + usize::from(next < here)].clone()
            } else if self.times[before + 1] - self.times[before] > LONGEST_GAP_S {
                vec![None; rows[before].len()]
            } else {
                let markers = 0..rows[before].len();
                markers
                    .map(|marker| self.between(rows, before, marker, time))
                    .collect()
            });
        }
        Ok(even)
    }

    /// Returns the place of a marker at a time between two rows, on the cubic through both with the
    /// slopes of the parabolas through their neighbours; none if it was not seen in both.
    fn between(&self, rows: &[Row], before: usize, marker: usize, time: f64) -> Option<DVec3> {
        let seen = |row: usize| rows.get(row)?.get(marker).copied().flatten();
        let step = |row: usize| self.times[row + 1] - self.times[row];
        let (from, to) = (seen(before)?, seen(before + 1)?);
        let span = step(before);
        let slope = (to - from) / span;
        let bent = |beside: Option<(DVec3, f64)>| match beside {
            Some((other, apart)) if apart <= LONGEST_GAP_S => {
                (other * span + slope * apart) / (span + apart)
            }
            _ => slope,
        };
        let earlier = before.checked_sub(1).and_then(|row| {
            let apart = step(row);
            Some(((from - seen(row)?) / apart, apart))
        });
        let later = seen(before + 2).map(|other| {
            let apart = step(before + 1);
            ((other - to) / apart, apart)
        });
        let (at_from, at_to) = (bent(earlier), bent(later));
        let u = (time - self.times[before]) / span;
        let (u2, u3) = (u * u, u * u * u);
        Some(
            from * (2.0 * u3 - 3.0 * u2 + 1.0)
                + at_from * (span * (u3 - 2.0 * u2 + u))
                + to * (3.0 * u2 - 2.0 * u3)
                + at_to * (span * (u3 - u2)),
        )
    }
}

/// Returns whether a ratio is near 1.
fn agree(ratio: f64) -> bool {
    (ratio - 1.0).abs() < STEP_TOLERANCE
}

fn impossible(stated: &str) -> String {
    format!("expected a frame rate of 1 to 10000 Hz, found `{stated}`")
}
