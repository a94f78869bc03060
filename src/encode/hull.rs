//! One hull as rows of whole steps: the inverse of the core's `hull.rs`.

use super::bits::{BitWriter, signed_width};
use edgegait_core::format::{
    DRAPED, JOINT_BITS, PARTS_BITS, ROW_LENGTH_BITS, ROW_MIDDLE_BITS, ROWS_BITS, SHARED_BITS,
    WIDTH_BITS,
};
use edgegait_core::skeleton::Joint;
use std::collections::{BTreeMap, BTreeSet};

/// A point in steps of its body.
pub(super) type StepPoint = [i32; 3];

/// Most stored points of a row.
const MAX_ROW: usize = 1 << ROW_LENGTH_BITS;
/// Most points of a row in the plane x = 0.
const MAX_MIDDLE: usize = (1 << ROW_MIDDLE_BITS) - 1;

/// A hull as it is stored.
#[derive(Clone, Debug)]
pub(super) struct StoredHull {
    /// The joint that carries it.
    pub joint: Joint,
    /// Whether its image on the other side is left out.
    pub is_mirrored: bool,
    /// Whether its points of negative x are left out.
    pub is_symmetric: bool,
    /// Its points, each once; those that are left out are not among them.
    pub points: BTreeSet<StepPoint>,
}

/// Appends what stands before so many stored parts of a draped hull.
pub(super) fn write_drape(parts: usize, writer: &mut BitWriter) {
    writer.unsigned(DRAPED, JOINT_BITS);
    writer.unsigned(narrow(parts - 1), PARTS_BITS);
}

/// Points that follow each other in the stream.
#[derive(Clone, Debug, Default)]
struct EncodedRow {
    /// What all of its points have on the shared axis, if there is one.
    shared: i32,
    /// Points that stand for themselves.
    alone: Vec<StepPoint>,
    /// Points that stand for themselves and their mirror images.
    pairs: Vec<StepPoint>,
}

/// An unsigned integer and how many bits it takes.
type BitField = (u32, u32);

impl StoredHull {
    /// Its points as they are read: where it is symmetric, both halves.
    #[must_use]
    pub(super) fn all_points(&self) -> BTreeSet<StepPoint> {
        let mut points = self.points.clone();
        if self.is_symmetric {
            points.extend(self.points.iter().map(|&point| image(point)));
        }
        points
    }

    /// Appends it, with rows along the axis that makes it shortest.
    pub(super) fn write(&self, writer: &mut BitWriter) {
        let ways = [None, Some(0), Some(1), Some(2)].map(|shared| self.fields(shared));
        let bits = |fields: &Vec<BitField>| fields.iter().map(|&(_, width)| width).sum::<u32>();
        for (value, width) in ways.into_iter().min_by_key(bits).unwrap_or_default() {
            writer.unsigned(value, width);
        }
    }

    /// All of its fields, with rows of points that share their coordinate on this axis.
    fn fields(&self, shared: Option<usize>) -> Vec<BitField> {
        let rows = self.rows(shared);
        let points = || {
            rows.iter()
                .flat_map(|row| row.alone.iter().chain(&row.pairs))
        };
        let widths: [u32; 3] = std::array::from_fn(|axis| {
            let widths = points().map(|point| self.field(point[axis], axis, None).1);
            widths.max().unwrap_or(0)
        });
        let mut fields = vec![
            (narrow(self.joint.index()), JOINT_BITS),
            (u32::from(self.is_symmetric), 1),
            (u32::from(self.is_mirrored), 1),
            (narrow(shared.map_or(0, |axis| axis + 1)), SHARED_BITS),
            (narrow(rows.len() - 1), ROWS_BITS),
        ];
        fields.extend(widths.map(|width| (width, WIDTH_BITS)));
        for row in &rows {
            let stored = row.alone.len() + row.pairs.len();
            fields.push((narrow(stored - 1), ROW_LENGTH_BITS));
            if self.is_symmetric {
                fields.push((narrow(row.alone.len()), ROW_MIDDLE_BITS));
            }
            if let Some(axis) = shared {
                fields.push(self.field(row.shared, axis, Some(widths[axis])));
            }
            let alone = row.alone.iter().map(|point| (point, self.is_symmetric));
            let pairs = row.pairs.iter().map(|point| (point, false));
            for (point, is_middle) in alone.chain(pairs) {
                let own = (0..3).filter(|&axis| Some(axis) != shared && !(is_middle && axis == 0));
                fields.extend(own.map(|axis| self.field(point[axis], axis, Some(widths[axis]))));
            }
        }
        fields
    }

    /// Its points in rows, those in the plane x = 0 of a symmetric hull first.
    fn rows(&self, shared: Option<usize>) -> Vec<EncodedRow> {
        let mut shares: BTreeMap<i32, Vec<StepPoint>> = BTreeMap::new();
        for &point in &self.points {
            let share = shared.map_or(0, |axis| point[axis]);
            shares.entry(share).or_default().push(point);
        }
        let mut rows: Vec<EncodedRow> = Vec::new();
        for (shared, points) in shares {
            let is_middle = |point: &StepPoint| self.is_symmetric && point[0] == 0;
            let (middle, others): (Vec<StepPoint>, Vec<StepPoint>) =
                points.into_iter().partition(is_middle);
            let mut row = EncodedRow {
                shared,
                ..EncodedRow::default()
            };
            for point in middle.into_iter().chain(others) {
                let is_middle = is_middle(&point);
                let is_full = row.alone.len() + row.pairs.len() == MAX_ROW
                    || is_middle && row.alone.len() == MAX_MIDDLE;
                if is_full {
                    rows.push(std::mem::take(&mut row));
                    row.shared = shared;
                }
                if self.is_symmetric && !is_middle {
                    row.pairs.push(point);
                } else {
                    row.alone.push(point);
                }
            }
            rows.push(row);
        }
        rows
    }

    /// A coordinate and its width, or the least one that holds it. The x of a symmetric
    /// hull is counted from 1.
    fn field(&self, value: i32, axis: usize, width: Option<u32>) -> BitField {
        if axis == 0 && self.is_symmetric {
            let value = value.cast_unsigned().saturating_sub(1);
            (value, width.unwrap_or(u32::BITS - value.leading_zeros()))
        } else {
            let width = width.unwrap_or_else(|| signed_width(value));
            (value.cast_unsigned(), width)
        }
    }
}

/// The mirror image on the walker's other side.
#[must_use]
pub(super) fn image([x, y, z]: StepPoint) -> StepPoint {
    [-x, y, z]
}

/// A number of joints, rows or points, which the budget keeps below 33.
fn narrow(value: usize) -> u32 {
    #[expect(clippy::cast_possible_truncation, reason = "stated above")]
    let value = value as u32;
    value
}
