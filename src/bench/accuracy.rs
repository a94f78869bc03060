//! How often a recognizer is right, with the runtime and the settings that it was timed with.

use super::inputs::Scene;
use crate::error::{Error, Result};
use crate::evaluate::contest::{Drawn, Entrant, Wish};
use crate::score::Recognizer;
use serde::{Deserialize, Serialize};

/// Rank-1 on walks that training has not seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// The protocol by its name.
    pub protocol: String,
    /// From how many viewpoints each walk was seen.
    pub viewpoints: usize,
    /// Inputs that were recognized.
    pub probes: u64,
    /// Share of hits, 0..1.
    pub rank1: f64,
    /// Lower end of Wilson's 95 % interval.
    pub rank1_low: f64,
    /// Upper end.
    pub rank1_high: f64,
    /// The 95 % interval that draws people rather than probes, [low, high].
    pub rank1_by_subjects: Option<(f64, f64)>,
    /// Probes whose output was not finite: they are misses.
    pub non_finite: u64,
}

impl Accuracy {
    /// Looks for the scene's people from each of its viewpoints, as `edgegait score` does unless
    /// another protocol is named.
    ///
    /// # Errors
    /// When a figure cannot be drawn, or the recognizer fails.
    pub fn of(recognizer: Box<dyn Recognizer>, scene: &Scene<'_>, seed: u64) -> Result<Self> {
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
        let result =
            result.ok_or_else(|| Error::Failed("expected the result of one recognizer".into()))?;
        Ok(Self {
            protocol: result.protocol,
            viewpoints: views.list.len(),
            probes: result.probes,
            rank1: result.rank1,
            rank1_low: result.rank1_low,
            rank1_high: result.rank1_high,
            rank1_by_subjects: result.rank1_by_subjects,
            non_finite: result.non_finite,
        })
    }
}
