//! Repairs faults of cameras and labelling: exchanged sides, spikes, short gaps.

use glam::DVec3;

use super::names::MarkerSide;
use super::set::Marks;

/// Largest speed of a marker on a walker or runner, m/s. Our choice: a sprinter's foot reaches 20
/// to 24.
const FASTEST_M_S: f64 = 25.0;

/// Tolerated labelling noise, metres. Our choice.
const NOISE_M: f64 = 0.02;

/// Largest acceleration of a marker, m/s^2. Our choice: a runner's heel at contact has about 300.
const LARGEST_ACCELERATION: f64 = 800.0;

/// Longest gap that is filled from the marker's own track, seconds.
pub(super) const LONGEST_GAP_S: f64 = 0.2;

/// Exchanged names make both markers of a pair jump. Exchanging them back must leave less than this
/// share of the jump, and the jump must be longer than [`LEAST_EXCHANGE_M`]. Our choice.
const EXCHANGE_SHARE: f64 = 0.4;
const LEAST_EXCHANGE_M: f64 = 0.12;

/// Exchanges left and right tracks back where they change places midway.
pub(super) fn mend_exchanged_sides(marks: &mut Marks, warnings: &mut Vec<String>) {
    for left in 0..marks.all.len() {
        let mark = &marks.all[left];
        if mark.side != MarkerSide::Left {
            continue;
        }
        let site = mark.site;
        let others = marks.all.iter().filter(|m| m.site == site);
        if others
            .clone()
            .filter(|m| m.side == MarkerSide::Left)
            .count()
            != 1
        {
            continue;
        }
        let Some(right) = marks
            .all
            .iter()
            .position(|m| m.site == site && m.side == MarkerSide::Right)
        else {
            continue;
        };
        let mut last: Option<(DVec3, DVec3)> = None;
        let mut exchanged = false;
        let mut first = None;
        let mut count = 0;
        for frame in 0..marks.frames {
            let (Some(mut a), Some(mut b)) =
                (marks.all[left].track[frame], marks.all[right].track[frame])
            else {
                // Across a gap in both, the sides cannot be followed: names are trusted again.
                if marks.all[left].track[frame].is_none() && marks.all[right].track[frame].is_none()
                {
                    last = None;
                    exchanged = false;
                }
                if exchanged {
                    exchange(marks, left, right, frame);
                }
                continue;
            };
            if exchanged {
                (a, b) = (b, a);
            }
            if let Some((c, d)) = last {
                let kept = a.distance(c) + b.distance(d);
                let crossed = a.distance(d) + b.distance(c);
                if kept > LEAST_EXCHANGE_M && crossed < EXCHANGE_SHARE * kept {
                    exchanged = !exchanged;
                    (a, b) = (b, a);
                    first.get_or_insert(frame);
                }
            }
            if exchanged {
                exchange(marks, left, right, frame);
                count += 1;
            }
            last = Some((a, b));
        }
        if let Some(frame) = first {
            warnings.push(format!(
                "markers {} and {} change places at frame {frame}: exchanged back in {count} frames",
                marks.all[left].name, marks.all[right].name
            ));
        }
    }
}

fn exchange(marks: &mut Marks, left: usize, right: usize, frame: usize) {
    let a = marks.all[left].track[frame];
    marks.all[left].track[frame] = marks.all[right].track[frame];
    marks.all[right].track[frame] = a;
}

/// Drops what a body cannot do: frames off their neighbours, and runs of frames that no possible
/// speed joins to the longest run.
pub(super) fn drop_spikes(marks: &mut Marks, warnings: &mut Vec<String>) {
    let rate = marks.sample_rate_hz;
    let step_m = FASTEST_M_S / rate + NOISE_M;
    let bend_m = 0.5 * LARGEST_ACCELERATION / (rate * rate) + NOISE_M;
    for mark in &mut marks.all {
        let before = mark.seen();
        let mut first = None;
        let track = mark.track.clone();
        for (frame, three) in track.windows(3).enumerate() {
            if let [Some(a), Some(b), Some(c)] = three
                && b.distance(a.midpoint(*c)) > bend_m
                && a.distance(*c) < b.distance(*a).min(b.distance(*c))
            {
                mark.track[frame + 1] = None;
                first.get_or_insert(frame + 1);
            }
        }
        let runs = runs(&mark.track, step_m);
        let Some(longest) = (0..runs.len()).max_by_key(|&run| runs[run].1 - runs[run].0) else {
            continue;
        };
        let track = mark.track.clone();
        let joins = |early: (usize, usize), late: (usize, usize)| {
            let (a, b) = (track[early.1 - 1], track[late.0]);
            let frames = (late.0 + 1 - early.1) as f64;
            a.zip(b)
                .is_some_and(|(a, b)| a.distance(b) <= step_m * frames)
        };
        let mut drop = |run: (usize, usize)| {
            mark.track[run.0..run.1].fill(None);
            first = Some(first.map_or(run.0, |frame: usize| frame.min(run.0)));
        };
        let mut end = runs[longest];
        for &run in &runs[longest + 1..] {
            if joins(end, run) {
                end = run;
            } else {
                drop(run);
            }
        }
        let mut start = runs[longest];
        for &run in runs[..longest].iter().rev() {
            if joins(run, start) {
                start = run;
            } else {
                drop(run);
            }
        }
        if let Some(frame) = first {
            warnings.push(format!(
                "marker {} jumps at frame {frame}: {} of its {before} frames are left out",
                mark.name,
                before - mark.seen()
            ));
        }
    }
}

/// Returns the runs of frames (start, end) without a gap or an impossible step.
fn runs(track: &[Option<DVec3>], step_m: f64) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (frame, point) in track.iter().enumerate() {
        let Some(point) = point else { continue };
        let goes_on =
            frame > 0 && track[frame - 1].is_some_and(|last| last.distance(*point) <= step_m);
        match runs.last_mut() {
            Some(run) if goes_on && run.1 == frame => run.1 = frame + 1,
            _ => runs.push((frame, frame + 1)),
        }
    }
    runs
}

/// Fills gaps of at most [`LONGEST_GAP_S`] by the cubic through both ends with their slopes.
pub(super) fn fill_short_gaps(marks: &mut Marks, warnings: &mut Vec<String>) {
    let longest = (LONGEST_GAP_S * marks.sample_rate_hz) as usize;
    let mut filled: Vec<String> = Vec::new();
    for mark in &mut marks.all {
        let mut count = 0;
        let seen: Vec<usize> = (0..mark.track.len())
            .filter(|&i| mark.track[i].is_some())
            .collect();
        let original = mark.track.clone();
        let slope = |at: usize, away: isize| {
            // Over 3 frames, to damp noise.
            let far = (1..=3).rev().find_map(|n| {
                let other = at.checked_add_signed(away * n)?;
                let point = original.get(other).copied().flatten()?;
                Some((point - original[at]?) / (away * n) as f64)
            });
            far.unwrap_or(DVec3::ZERO)
        };
        for pair in seen.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let gap = to - from - 1;
            if gap == 0 || gap > longest {
                continue;
            }
            let (Some(a), Some(b)) = (original[from], original[to]) else {
                continue;
            };
            let length = (to - from) as f64;
            let (u, v) = (slope(from, -1) * length, slope(to, 1) * length);
            for frame in from + 1..to {
                let t = (frame - from) as f64 / length;
                let s = 1.0 - t;
                let point =
                    a * (s * s * (1.0 + 2.0 * t)) + u * (t * s * s) + b * (t * t * (1.0 + 2.0 * s))
                        - v * (t * t * s);
                mark.track[frame] = Some(point);
                count += 1;
            }
        }
        if count > 0 {
            filled.push(format!("{} {count}", mark.name));
        }
    }
    if !filled.is_empty() {
        warnings.push(format!(
            "gaps of up to {LONGEST_GAP_S} s are filled (frames): {}",
            filled.join(", ")
        ));
    }
}
