//! A convex hull in an avatar's bit stream: rows of points that share a coordinate.
//!
//! Generated bodies consist of rings, and quantised points lie on common planes, so a row stores a
//! shared coordinate once. Symmetric hulls are stored by half.

use crate::bits::BitReader;
use crate::budget::MAX_HULL_POINTS;
use crate::format::{
    DRAPED, FormatError, HULL_STEP_M, JOINT_BITS, PARTS_BITS, ROW_LENGTH_BITS, ROW_MIDDLE_BITS,
    ROWS_BITS, SHARED_BITS, WIDTH_BITS,
};
use crate::skeleton::Joint;
use glam::Vec3;

/// A convex hull of an avatar, or a part of a draped one, rigid with a joint. It is given by points
/// alone: the silhouette of a convex hull is the convex hull of its projected points.
#[derive(Clone, Copy, Debug)]
pub struct Hull<'a> {
    joint: Joint,
    is_mirrored: bool,
    /// The draped hull that it is a part of, counted from 1; 0 for none.
    drape: u8,
    /// The number of stored parts of a draped hull that begins here; 0 if none does.
    parts: u8,
    len: u8,
    rows: u8,
    layout: PointLayout,
    step: Vec3,
    bits: BitReader<'a>,
}

/// The points of one hull.
pub(crate) type HullPoints = heapless::Vec<Vec3, MAX_HULL_POINTS>;

/// The packing of the points of a hull's rows.
#[derive(Clone, Copy, Debug)]
struct PointLayout {
    is_symmetric: bool,
    /// The axis on which the points of a row are the same: 1 x, 2 y, 3 z.
    shared_axis: u8,
    /// Bits of that coordinate, which a row stores once.
    shared: u8,
    /// Bits of the x, y and z that each point stores: 0 for the shared coordinate.
    own: [u8; 3],
}

/// A row of points in the stream: first single points, then, in a symmetric hull, points that stand
/// for two.
#[derive(Clone, Copy, Debug)]
struct PointRow {
    alone: u8,
    pairs: u8,
    shared: Vec3,
}

impl<'a> Hull<'a> {
    /// Reads a hull's header, skips its points, and checks both. Past the end of the stream it
    /// reads zeros: the caller checks for an overrun.
    pub(crate) fn read(bits: &mut BitReader<'a>, step_um: u16) -> Result<Self, FormatError> {
        let mut hull = Self::read_header(bits, step_um)?;
        for _ in 0..hull.rows {
            let error = |expected| FormatError::new(bits.position() / 8, expected);
            let middle = error("no more middle points in a row than it has points");
            let budget = error("a hull of at most 32 points");
            let row = hull.layout.read_row(bits).ok_or(middle)?;
            hull.layout.skip_points(bits, row);
            hull.len += row.alone + 2 * row.pairs;
            if usize::from(hull.len) > MAX_HULL_POINTS {
                return Err(budget);
            }
        }
        Ok(hull)
    }

    /// Reads a hull's header. Its number of points is not known yet.
    fn read_header(bits: &mut BitReader<'a>, step_um: u16) -> Result<Self, FormatError> {
        let error =
            |bits: &BitReader<'_>, expected| FormatError::new(bits.position() / 8, expected);
        let mut start = *bits;
        let mut number = bits.unsigned(JOINT_BITS);
        let mut parts = 0;
        if number == DRAPED {
            parts = byte(bits.unsigned(PARTS_BITS)) + 1;
            start = *bits;
            number = bits.unsigned(JOINT_BITS);
        }
        let Some(joint) = Joint::from_index(number as usize) else {
            return Err(error(&start, "a hull's joint, below 19"));
        };
        let flags = *bits;
        let is_symmetric = bits.unsigned(1) == 1;
        let is_mirrored = bits.unsigned(1) == 1;
        if is_mirrored && !joint.is_left() {
            return Err(error(&flags, "a mirrored hull only on a left joint"));
        }
        let shared_axis = byte(bits.unsigned(SHARED_BITS));
        let rows = byte(bits.unsigned(ROWS_BITS)) + 1;
        let mut shared = 0;
        let mut own = [0; 3];
        for (axis, own) in (1..).zip(&mut own) {
            let width = byte(bits.unsigned(WIDTH_BITS));
            *(if axis == shared_axis {
                &mut shared
            } else {
                own
            }) = width;
        }
        Ok(Self {
            joint,
            is_mirrored,
            drape: 0,
            parts,
            len: 0,
            rows,
            layout: PointLayout {
                is_symmetric,
                shared_axis,
                shared,
                own,
            },
            step: Vec3::splat(f32::from(step_um) * HULL_STEP_M),
            bits: *bits,
        })
    }

    /// Returns the number of stored parts of a draped hull that begins with this one; 0 if none
    /// does.
    pub(crate) const fn parts(&self) -> u8 {
        self.parts
    }

    /// Returns the hull as a part of the draped hull with this number, counted from 1.
    pub(crate) const fn of_drape(self, drape: u8) -> Self {
        Self { drape, ..self }
    }

    /// Returns its mirror image, if it is stored for both sides.
    pub(crate) fn image(&self) -> Option<Self> {
        self.is_mirrored.then(|| Self {
            joint: self.joint.mirrored(),
            step: mirrored(self.step),
            is_mirrored: false,
            ..*self
        })
    }

    /// Returns the joint that carries the hull.
    #[must_use]
    pub const fn joint(&self) -> Joint {
        self.joint
    }

    /// Returns the number of the draped hull that it is a part of. The convex hull of all parts
    /// with that number is drawn in their place, as cloth that is taut between them. `None` for a
    /// separate hull.
    #[must_use]
    pub fn drape(&self) -> Option<usize> {
        usize::from(self.drape).checked_sub(1)
    }

    /// Returns the number of its points, 1 to 32.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.len as usize
    }

    /// Returns whether it has no points, which is never so for a hull of a parsed avatar.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns its points in the joint's frame, metres. Reads all of them at once, into 392 bytes.
    pub fn points(&self) -> impl Iterator<Item = Vec3> + use<> {
        self.read_all().into_iter()
    }

    /// Returns its points in a buffer, in the joint's frame, metres.
    pub(crate) fn read_all(&self) -> HullPoints {
        let mut bits = self.bits;
        self.read_points(&mut bits)
    }

    /// Returns its points in steps, whole numbers.
    pub(crate) fn read_steps(&self) -> HullPoints {
        self.steps_behind(&mut self.bits.clone())
    }

    /// Returns the length of a step along each axis, metres; along x it is negative for a mirror
    /// image.
    pub(crate) const fn step(&self) -> Vec3 {
        self.step
    }

    /// Reads its points from `bits`, in the joint's frame, metres.
    pub(crate) fn read_points(&self, bits: &mut BitReader<'a>) -> HullPoints {
        let mut points = self.steps_behind(bits);
        for point in &mut points {
            *point *= self.step;
        }
        points
    }

    /// Reads its points from `bits`, in steps.
    fn steps_behind(&self, bits: &mut BitReader<'a>) -> HullPoints {
        let mut points = HullPoints::new();
        for _ in 0..self.rows {
            let Some(row) = self.layout.read_row(bits) else {
                break;
            };
            // A parsed hull is within the budget.
            let _ = self.layout.read_points(bits, row, &mut points);
        }
        points
    }
}

impl PointLayout {
    /// Reads the head of a row; `None` if it states more middle points than points.
    fn read_row(self, bits: &mut BitReader<'_>) -> Option<PointRow> {
        let middle_bits = if self.is_symmetric {
            ROW_MIDDLE_BITS
        } else {
            0
        };
        let width = u32::from(self.shared);
        let word = bits.unsigned(ROW_LENGTH_BITS + middle_bits + width);
        let points = byte(word & ((1 << ROW_LENGTH_BITS) - 1)) + 1;
        let word = word >> ROW_LENGTH_BITS;
        let alone = if self.is_symmetric {
            byte(word & ((1 << ROW_MIDDLE_BITS) - 1))
        } else {
            points
        };
        let word = word >> middle_bits;
        let shared = match self.shared_axis {
            1 => Vec3::new(self.x(word, width), 0.0, 0.0),
            2 => Vec3::new(0.0, signed(word, width), 0.0),
            3 => Vec3::new(0.0, 0.0, signed(word, width)),
            _ => Vec3::ZERO,
        };
        Some(PointRow {
            alone,
            pairs: points.checked_sub(alone)?,
            shared,
        })
    }

    /// Skips a row's points.
    fn skip_points(self, bits: &mut BitReader<'_>, row: PointRow) {
        let bits_of = |widths: [u8; 3]| widths.map(usize::from).iter().sum::<usize>();
        bits.skip(usize::from(row.alone) * bits_of(self.alone()));
        bits.skip(usize::from(row.pairs) * bits_of(self.own));
    }

    /// Appends a row's points, in steps; `None` if they do not fit.
    fn read_points(
        self,
        bits: &mut BitReader<'_>,
        row: PointRow,
        points: &mut HullPoints,
    ) -> Option<()> {
        let mut shared = row.shared;
        if self.is_symmetric {
            shared.x = 0.0;
        }
        for _ in 0..row.alone {
            let own = self.read_counts(bits, self.alone());
            points.push(shared + own).ok()?;
        }
        for _ in 0..row.pairs {
            let left = row.shared + self.read_counts(bits, self.own) + Vec3::X;
            points.push(left).ok()?;
            points.push(mirrored(left)).ok()?;
        }
        Some(())
    }

    /// Returns the bits of the x, y and z of a single point: in a symmetric hull, its x is 0.
    const fn alone(self) -> [u8; 3] {
        let [x, y, z] = self.own;
        [if self.is_symmetric { 0 } else { x }, y, z]
    }

    /// Reads the next three coordinates, in steps. The x of a symmetric hull has no sign.
    fn read_counts(self, bits: &mut BitReader<'_>, widths: [u8; 3]) -> Vec3 {
        let [x, y, z] = widths.map(u32::from);
        // All three in one read, if possible.
        let [first, second, third] = if x + y + z <= 25 {
            let word = bits.unsigned(x + y + z);
            [word, word >> x, word >> (x + y)]
        } else {
            [bits.unsigned(x), bits.unsigned(y), bits.unsigned(z)]
        };
        Vec3::new(self.x(first, x), signed(second, y), signed(third, z))
    }

    /// Returns the `width` low bits of `word` as an x: in a symmetric hull it has no sign.
    fn x(self, word: u32, width: u32) -> f32 {
        if !self.is_symmetric {
            return signed(word, width);
        }
        #[expect(clippy::cast_precision_loss, reason = "at most 15 bits")]
        let x = (word & ((1 << width) - 1)) as f32;
        x
    }
}

/// Mirrors a point to the walker's other side.
pub(crate) const fn mirrored(point: Vec3) -> Vec3 {
    Vec3::new(-point.x, point.y, point.z)
}

/// Returns the `width` low bits of `word`, at most 15, as a two's complement integer.
fn signed(word: u32, width: u32) -> f32 {
    // Two shifts, because one by 32 for a width of 0 would not be defined.
    let top = (word << (31 - width) << 1).cast_signed();
    #[expect(clippy::cast_precision_loss, reason = "at most 15 bits")]
    let value = (top >> (31 - width) >> 1) as f32;
    value
}

/// Returns a field of at most 5 bits as a byte.
fn byte(field: u32) -> u8 {
    let [low, ..] = field.to_le_bytes();
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bits::packed;

    /// Returns the fields of a header: joint, symmetric, mirrored, shared axis, rows, and widths.
    fn header(flags: [i32; 4], rows: i32, widths: [i32; 3]) -> [(i32, usize); 8] {
        let [joint, symmetric, mirrored, shared] = flags;
        let [x, y, z] = widths;
        [
            (joint, 5),
            (symmetric, 1),
            (mirrored, 1),
            (shared, 2),
            (rows - 1, 5),
            (x, 4),
            (y, 4),
            (z, 4),
        ]
    }

    /// Returns the points of a hull in steps, if the fields are one.
    fn points(fields: &[(i32, usize)]) -> Result<HullPoints, FormatError> {
        let bytes = packed(fields);
        let mut bits = BitReader::new(&bytes);
        let hull = Hull::read(&mut bits, 1)?;
        assert!(!bits.is_overrun() && bits.position() > 8 * bytes.len() - 8);
        let mut points: HullPoints = hull.points().collect();
        assert_eq!(points.len(), hull.len());
        for point in &mut points {
            *point = (*point * 1e6).round();
        }
        Ok(points)
    }

    fn assert_points(fields: &[(i32, usize)], expected: &[[i32; 3]]) {
        let found = points(fields).expect("a hull");
        let expected = expected.iter().map(|p| Vec3::from(p.map(|c| c as f32)));
        assert!(found.iter().copied().eq(expected), "{found:?}");
    }

    #[test]
    fn points_of_no_shared_axis_are_signed() {
        let head = header([4, 0, 0, 0], 1, [3, 0, 15]);
        let row = [(1, 3), (-4, 3), (16_383, 15), (3, 3), (-16_384, 15)];
        let expected = [[-4, 0, 16_383], [3, 0, -16_384]];
        assert_points(&[head.as_slice(), &row].concat(), &expected);
    }

    #[test]
    fn coordinates_too_wide_for_one_word_are_read_one_by_one() {
        let head = header([4, 0, 0, 0], 1, [15, 14, 13]);
        let row = [(0, 3), (-12_345, 15), (6_789, 14), (-4_000, 13)];
        assert_points(
            &[head.as_slice(), &row].concat(),
            &[[-12_345, 6_789, -4_000]],
        );
    }

    #[test]
    fn the_points_of_a_row_share_its_coordinate_on_every_axis() {
        for (axis, expected) in [
            (1, [[-5, 1, 2], [-5, -1, -2], [6, 3, 0]]),
            (2, [[1, -5, 2], [-1, -5, -2], [3, 6, 0]]),
            (3, [[1, 2, -5], [-1, -2, -5], [3, 0, 6]]),
        ] {
            let mut widths = [3; 3];
            widths[axis as usize - 1] = 4;
            let head = header([13, 0, 1, axis], 2, widths);
            let first = [(1, 3), (-5, 4), (1, 3), (2, 3), (-1, 3), (-2, 3)];
            let second = [(0, 3), (6, 4), (3, 3), (0, 3)];
            assert_points(&[head.as_slice(), &first, &second].concat(), &expected);
        }
    }

    #[test]
    fn points_in_the_plane_of_a_symmetric_hull_are_not_doubled() {
        let head = header([0, 1, 0, 3], 1, [2, 3, 4]);
        // Three points, one of them in the plane; the x of the others is stored less 1.
        let row = [
            (2, 3),
            (1, 2),
            (7, 4),
            (-3, 3),
            (0, 2),
            (1, 3),
            (3, 2),
            (2, 3),
        ];
        let expected = [[0, -3, 7], [1, 1, 7], [-1, 1, 7], [4, 2, 7], [-4, 2, 7]];
        assert_points(&[head.as_slice(), &row].concat(), &expected);
    }

    #[test]
    fn a_row_that_shares_its_x_is_doubled_but_for_its_points_in_the_plane() {
        let head = header([5, 1, 0, 1], 1, [15, 3, 0]);
        let row = [(1, 3), (1, 2), (32_767, 15), (2, 3), (-1, 3)];
        let expected = [[0, 2, 0], [32_768, -1, 0], [-32_768, -1, 0]];
        assert_points(&[head.as_slice(), &row].concat(), &expected);
    }

    #[test]
    fn the_image_of_a_hull_is_exact() {
        let head = header([8, 0, 1, 0], 1, [7, 7, 7]);
        let row = [(0, 3), (-33, 7), (20, 7), (-60, 7)];
        let bytes = packed(&[head.as_slice(), &row].concat());
        let hull = Hull::read(&mut BitReader::new(&bytes), 2_345).expect("a hull");
        let image = hull.image().expect("a mirrored hull");
        assert_eq!(image.joint(), Joint::RightHand);
        assert!(image.image().is_none());
        for (point, image) in hull.points().zip(image.points()) {
            assert_eq!(image, Vec3::new(-point.x, point.y, point.z));
            assert!((point - Vec3::new(-0.077_385, 0.046_9, -0.140_7)).length() < 1e-6);
        }
    }

    #[test]
    fn a_hull_of_33_points_is_refused_where_they_are_exceeded() {
        // Points that take no bits, in rows of 8 and a last one of 8 or 1.
        let head = |symmetric, rows| header([1, symmetric, 0, 0], rows, [0; 3]);
        let four = [head(0, 4).as_slice(), &[(7, 3); 4]].concat();
        assert_eq!(points(&four).expect("32 points").len(), 32);
        let five = [head(0, 5).as_slice(), &[(7, 3); 4], &[(0, 3)]].concat();
        // After 26 bits of header and four rows of 3.
        assert_eq!(points(&five).expect_err("33 points").byte, 38 / 8);
        // Seventeen pairs are 34, in rows of 5 bits.
        let pairs = [(7, 3), (0, 2), (7, 3), (0, 2), (0, 3), (0, 2)];
        let pairs = [head(1, 3).as_slice(), &pairs].concat();
        assert_eq!(points(&pairs).expect_err("34 points").byte, 36 / 8);
    }
}
