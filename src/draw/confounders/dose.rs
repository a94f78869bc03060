//! Doses: confounders with their strengths.

use super::catalogue::ConfounderKind;
use std::fmt;

/// A confounder and its strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dose {
    /// The confounder that acts.
    pub kind: ConfounderKind,
    /// The strength: 0 changes nothing, 1 (or -1) is what [`CATALOGUE`](super::CATALOGUE)
    /// describes.
    pub strength: f64,
}

/// Confounders that act together, in the order of application.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Doses(Vec<Dose>);

impl Doses {
    /// Keeps the doses that change something, and sorts them.
    pub fn new(doses: impl IntoIterator<Item = Dose>) -> Self {
        let changes = |dose: &Dose| dose.strength != 0.0;
        let mut doses: Vec<Dose> = doses.into_iter().filter(changes).collect();
        doses.sort_by_key(|dose| dose.kind);
        Self(doses)
    }

    /// Returns the doses in the order of application.
    #[must_use]
    pub fn list(&self) -> &[Dose] {
        &self.0
    }

    /// Returns the strength of a confounder, or `None` if it changes nothing.
    #[must_use]
    pub fn strength(&self, kind: ConfounderKind) -> Option<f64> {
        let found = self.0.iter().find(|dose| dose.kind == kind);
        found.map(|dose| dose.strength)
    }
}

/// Writes `backpack=0.5,roll=0.2`.
impl fmt::Display for Doses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for Dose { kind, strength } in &self.0 {
            write!(f, "{separator}{}={strength}", kind.confounder().name)?;
            separator = ",";
        }
        Ok(())
    }
}
