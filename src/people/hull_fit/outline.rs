//! Convex outlines as two chains from the top to the bottom, walked row by row.

/// The maximum number of corners in a chain.
const CAPACITY: usize = 129;
use glam::Vec2;

/// The left and the right side of a convex polygon, from its least y to its greatest.
pub(super) struct Chains {
    left: Chain,
    right: Chain,
}

/// One side, corners by y.
struct Chain {
    corners: [Vec2; CAPACITY],
    len: usize,
}

/// Sorts points by y, then x.
pub(super) fn sort(points: &mut [Vec2]) {
    // Insertion sort: the points are few and nearly sorted.
    for i in 1..points.len() {
        let point = points[i];
        let mut at = i;
        while at > 0 && is_before(point, points[at - 1]) {
            points[at] = points[at - 1];
            at -= 1;
        }
        points[at] = point;
    }
}

fn is_before(a: Vec2, b: Vec2) -> bool {
    a.y < b.y || (a.y == b.y && a.x < b.x)
}

impl Chain {
    const fn new() -> Self {
        Self {
            corners: [Vec2::ZERO; CAPACITY],
            len: 0,
        }
    }

    /// Adds a corner further down; `side` is 1 for the left chain and -1 for the right one.
    fn push(&mut self, point: Vec2, side: f32) {
        while self.len >= 2 {
            let (before, last) = (self.corners[self.len - 2], self.corners[self.len - 1]);
            if side * (last - before).perp_dot(point - before) < 0.0 {
                break;
            }
            self.len -= 1;
        }
        self.corners[self.len] = point;
        self.len += 1;
    }

    /// Returns x at this y, which is between the chain's ends.
    fn x_at(&self, y: f32) -> f32 {
        let corners = &self.corners[..self.len];
        let mut low = corners[0];
        for &high in &corners[1..] {
            if high.y >= y {
                let rise = high.y - low.y;
                return if rise > 0.0 {
                    low.x + (y - low.y) / rise * (high.x - low.x)
                } else {
                    low.x
                };
            }
            low = high;
        }
        low.x
    }
}

/// A walk down a chain.
struct ChainWalk<'a> {
    corners: &'a [Vec2],
    next: usize,
    x: f32,
    slope: f32,
}

impl<'a> ChainWalk<'a> {
    fn new(chain: &'a Chain) -> Self {
        Self {
            corners: &chain.corners[..chain.len],
            next: 0,
            x: 0.0,
            slope: 0.0,
        }
    }

    /// Returns x one row further down, at `y`.
    fn step(&mut self, y: f32) -> f32 {
        if self.next < self.corners.len() && self.corners[self.next].y <= y {
            while self.next < self.corners.len() && self.corners[self.next].y <= y {
                self.next += 1;
            }
            let low = self.corners[self.next - 1];
            if let Some(high) = self.corners.get(self.next) {
                self.slope = (high.x - low.x) / (high.y - low.y);
                self.x = low.x + (y - low.y) * self.slope;
            } else {
                self.x = low.x;
                self.slope = 0.0;
            }
            return self.x;
        }
        self.x += self.slope;
        self.x
    }
}

impl Chains {
    /// Returns the chains of points that are sorted by y.
    pub(super) fn from_sorted(points: &[Vec2]) -> Self {
        let (mut left, mut right) = (Chain::new(), Chain::new());
        for &point in points {
            left.push(point, 1.0);
            right.push(point, -1.0);
        }
        Self { left, right }
    }

    /// Returns the chains of points that are sorted by y, and of one more.
    pub(super) fn with(points: &[Vec2], more: Vec2) -> Self {
        let (mut left, mut right) = (Chain::new(), Chain::new());
        let mut push = |point| {
            left.push(point, 1.0);
            right.push(point, -1.0);
        };
        let at = points
            .iter()
            .position(|&point| is_before(more, point))
            .unwrap_or(points.len());
        points[..at].iter().for_each(|&point| push(point));
        push(more);
        points[at..].iter().for_each(|&point| push(point));
        Self { left, right }
    }

    /// Returns the first and last y.
    fn ends(&self) -> Option<(f32, f32)> {
        let len = self.left.len;
        (len > 0).then(|| (self.left.corners[0].y, self.left.corners[len - 1].y))
    }

    /// Returns whether a point is inside.
    pub(super) fn contains(&self, point: Vec2) -> bool {
        let Some((top, bottom)) = self.ends() else {
            return false;
        };
        (top..=bottom).contains(&point.y)
            && self.left.x_at(point.y) <= point.x
            && point.x <= self.right.x_at(point.y)
    }

    /// Calls `call` for each row of `from..to` whose middle is inside, with its first and last x.
    pub(super) fn each_span(
        &self,
        (from, to): (usize, usize),
        mut call: impl FnMut(usize, f32, f32),
    ) {
        let Some((top, bottom)) = self.ends() else {
            return;
        };
        // A figure out of the picture has no rows in it.
        if from >= to {
            return;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to rows"
        )]
        let row = |y: f32| (y - 0.5).ceil().clamp(from as f32, to as f32) as usize;
        let (mut left, mut right) = (ChainWalk::new(&self.left), ChainWalk::new(&self.right));
        for row in row(top)..row(bottom) {
            let y = row as f32 + 0.5;
            call(row, left.step(y), right.step(y));
        }
    }

    /// Calls `call` for each row with the range of pixels whose middles are inside, in an image of
    /// this size.
    pub(super) fn each_row(
        &self,
        rows: usize,
        columns: usize,
        mut call: impl FnMut(usize, usize, usize),
    ) {
        let column = |x: f32| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "clamped to columns"
            )]
            let column = (x - 0.5).ceil().clamp(0.0, columns as f32) as usize;
            column
        };
        self.each_span((0, rows), |row, from, to| {
            let (from, to) = (column(from), column(to));
            if from < to {
                call(row, from, to);
            }
        });
    }
}
