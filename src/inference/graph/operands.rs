//! The inputs of an operator and their shapes.

use super::{AttributeValue, Node, StoredTensor};
use std::collections::HashMap;

/// An operation and the known tensors.
pub(super) struct Operands<'a> {
    pub node: &'a Node,
    pub tensors: &'a HashMap<&'a str, StoredTensor>,
}

impl<'a> Operands<'a> {
    pub(super) fn name(&self, at: usize) -> Option<&'a str> {
        let name = self.node.inputs.get(at)?.as_str();
        (!name.is_empty()).then_some(name)
    }

    pub(super) fn shape(&self, at: usize) -> Option<&'a [u64]> {
        Some(&self.tensors.get(self.name(at)?)?.shape)
    }

    pub(super) fn known(&self, at: usize) -> Option<&'a [i64]> {
        self.tensors.get(self.name(at)?)?.integers.as_deref()
    }

    pub(super) fn integer(&self, name: &str, default: i64) -> i64 {
        match self.node.attributes.get(name) {
            Some(AttributeValue::Integer(value)) => *value,
            _ => default,
        }
    }

    pub(super) fn list(&self, name: &str) -> Option<&'a [i64]> {
        match self.node.attributes.get(name) {
            Some(AttributeValue::Integers(values)) => Some(values),
            _ => None,
        }
    }

    /// Returns an attribute of old operator sets, or the input that replaced it; `Ok(None)` if
    /// there is neither, and an error if the input's numbers are not known.
    pub(super) fn list_or_input(&self, name: &str, at: usize) -> Result<Option<&'a [i64]>, ()> {
        match (self.list(name), self.name(at)) {
            (Some(values), _) => Ok(Some(values)),
            (None, None) => Ok(None),
            (None, Some(_)) => self.known(at).map(Some).ok_or(()),
        }
    }
}

pub(super) fn broadcast(a: &[u64], b: &[u64]) -> Option<Vec<u64>> {
    let rank = a.len().max(b.len());
    let at = |shape: &[u64], i: usize| match (i + shape.len()).checked_sub(rank) {
        Some(i) => shape[i],
        None => 1,
    };
    (0..rank)
        .map(|i| match (at(a, i), at(b, i)) {
            (x, 1) => Some(x),
            (1, y) => Some(y),
            (x, y) => (x == y).then_some(x),
        })
        .collect()
}

/// Converts numbers to sizes, if none is negative.
pub(super) fn sizes(numbers: &[i64]) -> Option<Vec<u64>> {
    let sizes = numbers.iter().map(|&number| u64::try_from(number).ok());
    sizes.collect()
}
