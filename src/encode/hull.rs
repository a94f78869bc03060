//! Writing of hulls as rows of points in steps, the inverse of the core's `hull.rs`.

use super::bits::{BitWriter, signed_width};
use edgegait_core::format::{
    DRAPED, JOINT_BITS, PARTS_BITS, ROW_LENGTH_BITS, ROW_MIDDLE_BITS, ROWS_BITS, SHARED_BITS,
    WIDTH_BITS,
};
use edgegait_core::skeleton::Joint;
use std::collections::{BTreeMap, BTreeSet};

/// A point in whole steps of its body.
pub(super) type StepPoint = [i32; 3];

/// The maximum number of stored points of a row.
const MAX_ROW: usize = 1 << ROW_LENGTH_BITS;
/// The maximum number of points in a row in the plane x = 0.
const MAX_MIDDLE: usize = (1 << ROW_MIDDLE_BITS) - 1;

/// A hull in the form in which it is stored.
#[derive(Clone, Debug)]
pub(super) struct StoredHull {
    /// The joint that carries the hull.
    pub joint: Joint,
    /// Whether the hull also stands for its mirror image on the other side.
    pub is_mirrored: bool,
    /// Whether points of negative x are left out, as mirror images.
    pub is_symmetric: bool,
    /// The stored points, each once.
    pub points: BTreeSet<StepPoint>,
}

/// Appends the marker of a draped hull with its number of stored parts.
pub(super) fn write_drape(parts: usize, writer: &mut BitWriter) {
    writer.unsigned(DRAPED, JOINT_BITS);
    writer.unsigned(narrow(parts - 1), PARTS_BITS);
}

/// A row of points in the stream.
#[derive(Clone, Debug, Default)]
struct EncodedRow {
    /// The coordinate of all points on the shared axis, if there is one.
    shared: i32,
    /// Points without mirror images.
    alone: Vec<StepPoint>,
    /// Points that also stand for their mirror images.
    pairs: Vec<StepPoint>,
}

/// An unsigned integer and its number of bits.
struct BitField {
    value: u32,
    width: u32,
}

impl StoredHull {
    /// Returns the points as they are decoded: both halves of a symmetric hull.
    #[must_use]
    pub(super) fn all_points(&self) -> BTreeSet<StepPoint> {
        let mut points = self.points.clone();
        if self.is_symmetric {
            points.extend(self.points.iter().map(|&point| image(point)));
        }
        points
    }

    /// Appends the hull, with rows along the axis that needs the fewest bits.
    pub(super) fn write(&self, writer: &mut BitWriter) {
        let ways = [None, Some(0), Some(1), Some(2)].map(|shared| self.fields(shared));
        let bits = |fields: &Vec<BitField>| fields.iter().map(|field| field.width).sum::<u32>();
        for field in ways.into_iter().min_by_key(bits).unwrap_or_default() {
            writer.unsigned(field.value, field.width);
        }
    }

    /// Returns all fields, with rows of points that share their coordinate on this axis.
    fn fields(&self, shared: Option<usize>) -> Vec<BitField> {
        let rows = self.rows(shared);
        let points = || {
            rows.iter()
                .flat_map(|row| row.alone.iter().chain(&row.pairs))
        };
        let widths: [u32; 3] = std::array::from_fn(|axis| {
            let widths = points().map(|point| self.field(point[axis], axis, None).width);
            widths.max().unwrap_or(0)
        });
        let field = |value, width| BitField { value, width };
        let mut fields = vec![
            field(narrow(self.joint.index()), JOINT_BITS),
            field(u32::from(self.is_symmetric), 1),
            field(u32::from(self.is_mirrored), 1),
            field(narrow(shared.map_or(0, |axis| axis + 1)), SHARED_BITS),
            field(narrow(rows.len() - 1), ROWS_BITS),
        ];
        fields.extend(widths.map(|width| field(width, WIDTH_BITS)));
        for row in &rows {
            let stored = row.alone.len() + row.pairs.len();
            fields.push(field(narrow(stored - 1), ROW_LENGTH_BITS));
            if self.is_symmetric {
                fields.push(field(narrow(row.alone.len()), ROW_MIDDLE_BITS));
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

    /// Returns the points in rows. In symmetric hulls, points in the plane x = 0 come first.
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

    /// Returns a coordinate with this width, or with the least width that holds it. The x of a
    /// symmetric hull is counted from 1.
    fn field(&self, value: i32, axis: usize, width: Option<u32>) -> BitField {
        let (value, least) = if axis == 0 && self.is_symmetric {
            let value = value.cast_unsigned().saturating_sub(1);
            (value, u32::BITS - value.leading_zeros())
        } else {
            (value.cast_unsigned(), signed_width(value))
        };
        let width = width.unwrap_or(least);
        BitField { value, width }
    }
}

/// Returns the mirror image of a point on the walker's other side.
#[must_use]
pub(super) fn image([x, y, z]: StepPoint) -> StepPoint {
    [-x, y, z]
}

/// Converts a number of joints, rows or points, which the budget keeps below 33.
fn narrow(value: usize) -> u32 {
    #[expect(clippy::cast_possible_truncation, reason = "stated above")]
    let value = value as u32;
    value
}
