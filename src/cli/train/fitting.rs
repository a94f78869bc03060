//! How a model is made of samples.

use crate::train::subspaces::SubspaceOptions;
use crate::train::{TrainMethod, feature_choice};

/// How a model is made.
#[derive(Clone, Copy, Debug)]
pub(super) enum How {
    /// On principal components.
    Linear(TrainMethod),
    FeatureChoice,
    GaborSubspaces(SubspaceOptions),
    ViewTransformation,
}

impl How {
    /// Whether principal components are found first.
    pub(super) const fn has_components(self) -> bool {
        matches!(self, Self::Linear(_) | Self::ViewTransformation)
    }

    /// What results say of it.
    pub(super) fn said(self) -> String {
        match self {
            Self::Linear(method) => method.to_string(),
            Self::FeatureChoice => feature_choice::METHOD.to_owned(),
            Self::GaborSubspaces(subspaces) => subspaces.to_string(),
            Self::ViewTransformation => "view transformation".to_owned(),
        }
    }
}
