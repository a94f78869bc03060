//! A dose: a confounder at a strength.

use super::catalogue::ConfounderKind;
use std::fmt;

/// A confounder and its strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dose {
    /// Which.
    pub kind: ConfounderKind,
    /// 0 changes nothing, 1 (or -1) is what [`CATALOGUE`] says.
    pub strength: f64,
}

/// Confounders that act together, in the order in which they are applied.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Doses(Vec<Dose>);

impl Doses {
    /// The doses that change something.
    pub fn new(doses: impl IntoIterator<Item = Dose>) -> Self {
        let changes = |dose: &Dose| dose.strength != 0.0;
        let mut doses: Vec<Dose> = doses.into_iter().filter(changes).collect();
        doses.sort_by_key(|dose| dose.kind);
        Self(doses)
    }

    /// In the order in which they are applied.
    #[must_use]
    pub fn list(&self) -> &[Dose] {
        &self.0
    }

    /// The strength of a confounder; none if it changes nothing.
    #[must_use]
    pub fn strength(&self, kind: ConfounderKind) -> Option<f64> {
        let found = self.0.iter().find(|dose| dose.kind == kind);
        found.map(|dose| dose.strength)
    }
}

/// `backpack=0.5,roll=0.2`.
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
