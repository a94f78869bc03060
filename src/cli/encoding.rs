//! Flags that choose the error or size of encoded walks.

use super::args::{Common, gei_rmse, stated_choice};
use super::progress::Progress;
use crate::encode::within_error::{EncodedPack, EncodingGoal, encoded};
use crate::encode::{BUDGET_TRIES, Effort, MAX_ERROR_MM, STEPS_OF_WALK, encode_population};
use crate::error::{Error, Result};
use crate::files::ResultHeader;
use crate::people::Subject;
use crate::people::fewer_points::thinned;
use std::ops::Range;

/// The flags that choose the encoding.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct EncodingArgs {
    /// Maximum encoding error of a walk in mm; the limit of a body is two fifths of it, at most 4
    /// mm
    /// [default: 5; 1 with a body that is fitted to a mesh]
    #[arg(long, value_name = "E")]
    max_error_mm: Option<f64>,
    /// Maximum size of the pack in bytes; chooses the smallest error that fits, from 0.1 mm on
    #[arg(long, value_name = "N", conflicts_with = "max_error_mm")]
    budget_bytes: Option<usize>,
    /// Maximum number of points in all hulls of a body, 64 to 768: the farthest points are kept. A
    /// body that is fitted to a mesh is fitted with this many, 96 to 512 [default: all; 384 for a
    /// fitted body]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(64..=768))]
    pub hull_points: Option<u16>,
    /// Choose the error and hull points with the fewest bytes whose GEIs differ by at most this
    /// root mean square (of 255) from the finest encoding, on a sample of these walks at 20
    /// viewpoints
    #[arg(long, value_name = "X", value_parser = gei_rmse, conflicts_with_all = ["max_error_mm", "budget_bytes", "hull_points"])]
    max_gei_rmse: Option<f64>,
}

impl EncodingArgs {
    /// Checks the error limit, before any work is done.
    ///
    /// # Errors
    /// If it is out of range or not a number.
    pub(super) fn check(&self) -> Result<()> {
        match self.max_error_mm {
            Some(error) if !(0.0..=1e6).contains(&error) => Err(Error::Usage(format!(
                "--max-error-mm {error}: expected 0 to 1,000,000"
            ))),
            _ => Ok(()),
        }
    }

    fn goal(&self) -> EncodingGoal {
        match (self.max_error_mm, self.budget_bytes, self.max_gei_rmse) {
            (Some(error), _, _) => EncodingGoal::ErrorMm(error),
            (_, Some(bytes), _) => EncodingGoal::Bytes(bytes),
            (_, _, Some(rmse)) => EncodingGoal::GeiRmse(rmse),
            _ => EncodingGoal::Usual,
        }
    }

    /// Returns whether all encoding flags have their defaults.
    #[must_use]
    pub(super) fn is_usual(&self) -> bool {
        (self.goal(), self.hull_points) == (EncodingGoal::Usual, None)
    }

    /// Encodes people with a progress bar.
    ///
    /// # Errors
    /// The same as [`encoded`].
    pub(super) fn encode(&self, people: &[Subject], common: &Common) -> Result<EncodedPack> {
        let tries = self.budget_bytes.map_or(1, |_| BUDGET_TRIES);
        let walks: usize = people.iter().map(|subject| subject.walks.len()).sum();
        let progress = Progress::new(
            common,
            ("encoding in", "steps"),
            STEPS_OF_WALK * walks * tries,
        );
        let hull_points = self.hull_points.map(usize::from);
        encoded(people, self.goal(), hull_points, &|| progress.step())
    }

    /// Encodes the people of these numbers separately; `progress` counts walks.
    ///
    /// # Errors
    /// The same as [`encode_population`], and for flags that compare packs.
    pub(super) fn encode_population(
        &self,
        progress: &Progress,
        people: Range<usize>,
        effort: Effort,
        make: &(dyn Fn(usize) -> Result<Subject> + Sync),
    ) -> Result<EncodedPack> {
        if self.budget_bytes.is_some() || self.max_gei_rmse.is_some() {
            return Err(Error::Usage(
                "--budget-bytes and --max-gei-rmse try several encodings of a pack, which a population (a slice A..B, or more than 999 people) does not allow (use --max-error-mm)".into(),
            ));
        }
        let max_error_mm = self.max_error_mm.unwrap_or(MAX_ERROR_MM);
        let hull_points = self.hull_points.map(usize::from);
        let thinner = |number| {
            progress.check()?;
            let mut subject = make(number)?;
            if let Some(most) = hull_points {
                subject.body = thinned(&subject.body, most)?;
            }
            Ok(subject)
        };
        let bytes = encode_population(people, &thinner, max_error_mm, effort, &|| progress.step())?;
        Ok(EncodedPack {
            bytes,
            max_error_mm,
            hull_points,
            choice: None,
        })
    }

    /// Adds to a result's header how people were encoded, under the names of the flags.
    #[must_use]
    pub(super) fn stated(&self, header: ResultHeader, encoded: &EncodedPack) -> ResultHeader {
        let header = header
            .with("max_error_mm", encoded.max_error_mm)
            .with("budget_bytes", self.budget_bytes)
            .with("hull_points", encoded.hull_points);
        match &encoded.choice {
            Some(choice) => stated_choice(header, self.max_gei_rmse, choice),
            None => header,
        }
    }
}

/// Prints what `--max-gei-rmse` chose, and why.
pub(super) fn say_choice(encoded: &EncodedPack, common: &Common) {
    if let Some(choice) = &encoded.choice {
        common.say(format_args!("chosen: {choice}"));
    }
}
