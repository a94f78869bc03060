//! How often a recognizer is right, with the runtime and the settings that it was timed with.

use super::inputs::Scene;
use crate::error::{Error, Result};
use crate::evaluate::contest::{Drawn, Entrant, Wish};
use crate::evaluate::intervals::Rank1Intervals;
use crate::score::Recognizer;
use serde::{Deserialize, Serialize};

/// Rank-1 on walks that training has not seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Accuracy {
    /// The protocol by its name.
    pub protocol: String,
    /// From how many viewpoints each walk was seen.
    pub viewpoints: usize,
    /// Inputs that were recognized.
    pub probes: u64,
    /// Share of hits, 0..1.
    pub rank1: f64,
    /// Its 95 % intervals.
    #[serde(flatten)]
    pub intervals: Rank1Intervals,
    /// Probes whose output was not finite: they are misses.
    pub non_finite: u64,
}

impl Accuracy {
    /// Looks for the scene's people from each of its viewpoints, as `edgegait score` does unless
    /// another protocol is named; and what to know before trusting it.
    ///
    /// # Errors
    /// When a figure cannot be drawn, or the recognizer fails.
    pub(crate) fn of(
        recognizer: Box<dyn Recognizer>,
        scene: &Scene<'_>,
        seed: u64,
    ) -> Result<(Self, Vec<String>)> {
        let Scene {
            pack,
            walks,
            views,
            settings,
        } = *scene;
        let entrants = [Entrant {
            recognizer,
            settings,
        }];
        let wish = Wish {
            views: Some(views.clone()),
            ..Wish::default()
        };
        let drawn = Drawn::new((pack, walks), &entrants, wish)?;
        let outcome = drawn
            .contest
            .run(&entrants, seed, &mut |_| {}, &mut |_| {})?;
        let result = outcome.results.into_iter().next();
        let result = result.ok_or(Error::Missing("the result of one recognizer"))?;
        let warnings = [drawn.warnings, outcome.warnings].concat();
        let accuracy = Self {
            protocol: result.protocol,
            viewpoints: views.list.len(),
            probes: result.probes,
            rank1: result.rank1,
            intervals: result.intervals,
            non_finite: result.non_finite,
        };
        Ok((accuracy, warnings))
    }
}
