//! Connected parts of a mask, and the boxes around them.

use super::mask::Mask;

/// The share of a figure's height by which its box is widened for its other parts. Our choice.
const WIDENED: f64 = 0.05;

/// The smallest upright rectangle around pixels: columns and rows, ends excluded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PixelBox {
    pub(super) left: f64,
    pub(super) right: f64,
    top: f64,
    bottom: f64,
}

impl PixelBox {
    const EMPTY: Self = Self {
        left: f64::INFINITY,
        right: f64::NEG_INFINITY,
        top: f64::INFINITY,
        bottom: f64::NEG_INFINITY,
    };

    fn joined(self, other: Self) -> Self {
        Self {
            left: self.left.min(other.left),
            right: self.right.max(other.right),
            top: self.top.min(other.top),
            bottom: self.bottom.max(other.bottom),
        }
    }

    pub(super) fn moved(self, (x, y): (f64, f64)) -> Self {
        Self {
            left: self.left + x,
            right: self.right + x,
            top: self.top + y,
            bottom: self.bottom + y,
        }
    }

    pub(super) fn widened(self) -> Self {
        let by = WIDENED * self.height();
        Self {
            left: self.left - by,
            right: self.right + by,
            top: self.top - by,
            bottom: self.bottom + by,
        }
    }

    pub(super) fn width(self) -> f64 {
        self.right - self.left
    }

    pub(super) fn height(self) -> f64 {
        self.bottom - self.top
    }

    fn area(self) -> f64 {
        self.width() * self.height()
    }

    pub(super) fn centre(self) -> (f64, f64) {
        (
            (self.left + self.right) / 2.0,
            (self.top + self.bottom) / 2.0,
        )
    }

    fn shared(self, other: Self) -> f64 {
        let across = self.right.min(other.right) - self.left.max(other.left);
        let down = self.bottom.min(other.bottom) - self.top.max(other.top);
        across.max(0.0) * down.max(0.0)
    }

    /// Returns the shared area over that of both together.
    pub(super) fn overlap(self, other: Self) -> f64 {
        let both = self.shared(other);
        both / (self.area() + other.area() - both)
    }

    /// Returns whether it is of a similar height and at most half of the height away.
    pub(super) fn is_beside(self, other: Self) -> bool {
        let ((x, y), (to_x, to_y)) = (self.centre(), other.centre());
        let ratio = self.height() / other.height();
        libm::hypot(to_x - x, to_y - y) <= 0.5 * other.height() && (0.8..=1.25).contains(&ratio)
    }

    /// Returns whether most of it lies in another box.
    pub(super) fn is_within(self, other: Self) -> bool {
        self.shared(other) > 0.5 * self.area()
    }
}

/// Connected pixels of a frame, or several such parts, as runs of pixels: row, first column, and
/// the column after the last.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(super) bounds: PixelBox,
    pub(super) area: usize,
    runs: Vec<(u32, u32, u32)>,
}

impl Part {
    fn join(&mut self, other: Self) {
        self.bounds = self.bounds.joined(other.bounds);
        self.area += other.area;
        self.runs.extend(other.runs);
    }

    /// Returns the parts of a mask, the first from above first. Gaps of up to twice `bridged`
    /// pixels do not split a part.
    pub(super) fn all(mask: &Mask, bridged: usize) -> Vec<Self> {
        let (part_of, parts) = mask.dilated(bridged).parts();
        let none = Self {
            bounds: PixelBox::EMPTY,
            area: 0,
            runs: Vec::new(),
        };
        let mut found = vec![none; parts];
        let columns = mask.columns();
        for (row, pixels) in mask.pixels().chunks_exact(columns).enumerate() {
            let mut column = 0;
            while column < columns {
                if !pixels[column] {
                    column += 1;
                    continue;
                }
                let start = column;
                while column < columns && pixels[column] {
                    column += 1;
                }
                // Pixels of a run are of one part, which their dilation keeps together.
                let part = &mut found[part_of[row * columns + start] as usize - 1];
                let (row, start, end) = (row as u32, start as u32, column as u32);
                part.runs.push((row, start, end));
                part.area += (end - start) as usize;
                part.bounds = part.bounds.joined(PixelBox {
                    left: start.into(),
                    right: end.into(),
                    top: row.into(),
                    bottom: (row + 1).into(),
                });
            }
        }
        found
    }

    pub(super) fn mask(&self, (columns, rows): (usize, usize)) -> Mask {
        let mut on = vec![false; columns * rows];
        for &(row, start, end) in &self.runs {
            on[row as usize * columns..][start as usize..end as usize].fill(true);
        }
        Mask::new(columns, on)
    }
}

/// Joins parts to one; none without parts.
pub(super) fn joined(parts: impl IntoIterator<Item = Part>) -> Option<Part> {
    parts.into_iter().reduce(|mut all, more| {
        all.join(more);
        all
    })
}
