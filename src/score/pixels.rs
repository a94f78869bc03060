//! The baseline that needs no model: a GEI, or another template, is its own embedding.
//!
//! Comparing GEIs pixel by pixel (Han & Bhanu 2006, "Individual recognition using gait energy
//! image", IEEE Trans. Pattern Anal. 28:316, "real templates") shows what the pictures alone tell
//! of a person, before anything has been learnt.

use super::{Contract, Layout, Outputs, Recognizer, RuntimeName};
use crate::error::Result;
use crate::sweep::Framing;
use crate::template::Template;
use edgegait_core::silhouette::Size;

/// What the baseline is called among models.
pub(crate) const NAME: &str = "pixels";

/// Answers with the template that it was given.
#[derive(Clone, Debug)]
pub(crate) struct Pixels {
    contract: Contract,
    runtime: RuntimeName,
}

impl Pixels {
    /// The baseline for this template of silhouettes of this size and framing.
    #[must_use]
    pub(crate) fn new(template: Template, size: Size, framing: Framing) -> Self {
        Self {
            contract: Contract {
                name: NAME.into(),
                rows: size.rows(),
                columns: size.columns(),
                layout: Layout::of(template),
                framing,
                template,
                ..Contract::default()
            },
            runtime: RuntimeName {
                name: "none".into(),
                ..RuntimeName::default()
            },
        }
    }
}

impl Recognizer for Pixels {
    fn runtime(&self) -> &RuntimeName {
        &self.runtime
    }

    fn contract(&self) -> &Contract {
        &self.contract
    }

    fn run(&self, geis: &[f32], batch: usize) -> Result<Outputs> {
        self.contract.frames_in(geis.len(), batch)?;
        Ok(Outputs {
            embedding: geis.to_vec(),
            embedding_dims: geis.len() / batch.max(1),
            embedding_parts: 1,
            non_finite: geis.iter().filter(|number| !number.is_finite()).count(),
            ..Outputs::default()
        })
    }
}
