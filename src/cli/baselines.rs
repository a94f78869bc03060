//! The baselines of a command: `pixels` by its name, and those that it adds.

use crate::error::{Error, Result};
use crate::evaluate::contest::{BaselineKind, Contest, Entrant};
use crate::files::ResultHeader;
use crate::inference::baseline::PIXELS;
use edgegait_core::pack::Pack;
use std::path::{Path, PathBuf};

/// Returns whether a name stands for the pixel baseline.
pub(super) fn is_baseline(path: &Path) -> bool {
    path == Path::new(PIXELS) && !path.exists()
}

/// The baselines that take part beside recognizers. They are the same, whether they are named or
/// not, and whatever else is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WantedBaselines {
    /// Whether the pixel baseline was named: it is listed before the recognizers then.
    pub has_pixels: bool,
    /// Whether all baselines take part.
    pub has_all: bool,
    /// Whether they are only those of the first recognizer's input.
    pub is_of_first: bool,
}

impl WantedBaselines {
    /// Separates the pixel baseline from models, if it is named beside other recognizers: how it is
    /// shown sequences depends on these.
    pub(super) fn apart(&mut self, models: &mut Vec<PathBuf>, has_others: bool) {
        if has_others || models.iter().any(|path| !is_baseline(path)) {
            self.has_pixels = models.iter().any(|path| is_baseline(path));
            models.retain(|path| !is_baseline(path));
        }
    }

    /// Adds the baselines to a contest's recognizers; random ones have the header's seed.
    ///
    /// # Errors
    /// The same as [`Contest::baselines`].
    pub(super) fn add(
        self,
        contest: &Contest<'_>,
        entrants: &mut Vec<Entrant>,
        pack: Option<&Pack<'_>>,
        header: &mut ResultHeader,
    ) -> Result<()> {
        let seed = header.seed;
        let mut of = |kinds: &[BaselineKind], entrants: &[Entrant]| {
            if kinds.is_empty() {
                return Ok(Vec::new());
            }
            let found = contest.baselines(entrants, kinds, pack, seed)?;
            for warning in found.warnings {
                if !header.warnings.contains(&warning) {
                    header.warnings.push(warning);
                }
            }
            Ok::<_, Error>(found.entrants)
        };
        let (before, after): (&[BaselineKind], &[BaselineKind]) =
            match (self.has_pixels, self.has_all) {
                (false, false) => (&[], &[]),
                (false, true) => (&[], &[BaselineKind::Pixels, BaselineKind::Random]),
                (true, false) => (&[BaselineKind::Pixels], &[]),
                (true, true) => (&[BaselineKind::Pixels], &[BaselineKind::Random]),
            };
        let count = if self.is_of_first { 1 } else { entrants.len() };
        let like = &entrants[..count.min(entrants.len())];
        let [before, after] = [of(before, like)?, of(after, like)?];
        entrants.splice(0..0, before);
        entrants.extend(after);
        Ok(())
    }
}
