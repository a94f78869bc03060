//! An avatar of given hulls, written from the layout in `FORMAT.md`.

/// A point, steps.
pub type Point = [i32; 3];

/// Returns an avatar of hulls on the pelvis of up to 32 points, with coordinates from -16,384 to
/// 16,383 steps of `step_um` micrometres. All joints are in one place.
pub fn avatar(step_um: u16, hulls: &[Vec<Point>]) -> Vec<u8> {
    let mut bits: Vec<bool> = Vec::new();
    let mut push = |value: i32, width: u32| {
        bits.extend((0..width).map(|bit| value >> bit & 1 == 1));
    };
    // Offsets of 18 joints that are 0.
    push(0, 5);
    (0..18).for_each(|_| push(0, 3));
    for hull in hulls {
        // Joint 0, neither symmetric nor mirrored, no shared axis.
        push(0, 5 + 1 + 1 + 2);
        let rows = hull.chunks(8);
        push(rows.len() as i32 - 1, 5);
        (0..3).for_each(|_| push(15, 4));
        for row in rows {
            push(row.len() as i32 - 1, 3);
            for &coordinate in row.as_flattened() {
                push(coordinate, 15);
            }
        }
    }
    let mut bytes = vec![0, 0];
    bytes.extend(step_um.to_le_bytes());
    bytes.push(hulls.len() as u8);
    bytes.extend(bits.chunks(8).map(|bits| {
        let ones = bits.iter().enumerate().filter(|(_, bit)| **bit);
        ones.fold(0, |byte, (at, _)| byte | 1 << at)
    }));
    bytes
}
