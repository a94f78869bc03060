//! The training methods, with their options.

use crate::train::subspaces::SubspaceOptions;
use crate::train::{TrainMethod, feature_choice};

/// A training method, with its options.
#[derive(Clone, Copy, Debug)]
pub(super) enum FittingMethod {
    /// A linear method on principal components.
    Linear(TrainMethod),
    FeatureChoice,
    GaborSubspaces(SubspaceOptions),
    ViewTransformation,
}

impl FittingMethod {
    /// Returns whether the method uses principal components.
    pub(super) const fn has_components(self) -> bool {
        matches!(self, Self::Linear(_) | Self::ViewTransformation)
    }

    /// Returns the method's name in results.
    pub(super) fn said(self) -> String {
        match self {
            Self::Linear(method) => method.to_string(),
            Self::FeatureChoice => feature_choice::METHOD.to_owned(),
            Self::GaborSubspaces(subspaces) => subspaces.to_string(),
            Self::ViewTransformation => "view transformation".to_owned(),
        }
    }
}
