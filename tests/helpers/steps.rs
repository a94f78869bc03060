//! Steps judged by the ankles' joints: where feet are in the middle of their stances.

use glam::DVec3;

/// A foot in the middle of a stance.
#[derive(Clone, Copy, Debug)]
pub struct MidStance {
    /// Whether it is the left foot.
    pub is_left: bool,
    /// Place of its ankle.
    pub ankle: DVec3,
}

/// Returns the middles of stances in order: the moments when the other ankle passes the standing
/// one. `ankles` are places by moment, left first, and `ahead` is the direction of progression
/// around a moment.
pub fn mid_stances(ankles: &[[DVec3; 2]], ahead: impl Fn(usize) -> DVec3) -> Vec<MidStance> {
    let passing = |(moment, pair): (usize, &[[DVec3; 2]])| {
        let ahead = ahead(moment);
        let [before, after] = [pair[0], pair[1]].map(|[left, right]| (left - right).dot(ahead));
        // The foot that falls behind stands.
        let is_left = before > after;
        let foot = usize::from(!is_left);
        ((before > 0.0) != (after > 0.0)).then(|| MidStance {
            is_left,
            ankle: pair[0][foot].lerp(pair[1][foot], before / (before - after)),
        })
    };
    ankles.windows(2).enumerate().filter_map(passing).collect()
}
