//! The animation of a glTF file: tracks of keys, sampled at any time.

use std::collections::HashSet;

use glam::{DQuat, DVec3, DVec4};
use gltf::animation::{Animation, Interpolation, Property};

use super::buffers::Buffers;

/// The minimum rate at which keys are sampled, Hz, so that the curve between sparse keys is kept.
const LEAST_RATE_HZ: f64 = 30.0;

/// Highest rate at which uneven keys are sampled, Hz; otherwise it follows their least distance.
/// Our choice.
const UNEVEN_RATE_HZ: f64 = 240.0;

/// The maximum product of frames and nodes. Our choice: 200 MB of poses.
const MAX_POSES: f64 = 3e6;

/// The maximum number of keys in all tracks. Our choice: 200 MB.
const MAX_KEYS: usize = 5_000_000;

/// The property that a track moves, in the order of a node's transform.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Moves {
    Translation,
    Rotation,
    Scale,
}

/// The keys of one property of one node.
struct KeyTrack {
    node: usize,
    moves: Moves,
    interpolation: Interpolation,
    /// Times of the keys, strictly ascending, seconds.
    times: Vec<f64>,
    /// Values of the keys, one each; for a cubic spline, in-tangent, value and out-tangent.
    values: Vec<DVec4>,
}

/// The part of an animation that moves the given nodes.
pub(super) struct GltfAnimation {
    tracks: Vec<KeyTrack>,
    start_s: f64,
    pub(super) sample_rate_hz: f64,
    /// The number of frames; the first is at the first key.
    pub(super) len: usize,
    pub(super) warnings: Vec<String>,
}

impl GltfAnimation {
    pub(super) fn read(
        animation: &Animation,
        buffers: &Buffers,
        nodes: &[usize],
    ) -> Result<Self, String> {
        let nodes: HashSet<usize> = nodes.iter().copied().collect();
        let mut tracks: Vec<KeyTrack> = Vec::new();
        let mut keys = 0;
        for channel in animation.channels() {
            let node = channel.target().node().index();
            let moves = match channel.target().property() {
                Property::Translation => Moves::Translation,
                Property::Rotation => Moves::Rotation,
                Property::Scale => Moves::Scale,
                Property::MorphTargetWeights => continue,
            };
            if nodes.contains(&node) {
                let track = KeyTrack::read(&channel.sampler(), buffers, node, moves);
                let track = track.map_err(|problem| {
                    format!("channel {} of the animation: {problem}", channel.index())
                })?;
                keys += track.values.len();
                if keys > MAX_KEYS {
                    return Err(format!("more than {MAX_KEYS} keys: cut the animation"));
                }
                tracks.push(track);
            }
        }
        let Some(densest) = tracks
            .iter()
            .map(|track| &track.times)
            .max_by_key(|t| t.len())
        else {
            return Err("the animation moves none of the skin's joints".into());
        };
        let mut warnings = Vec::new();
        let sample_rate_hz = rate(densest, &mut warnings)?;
        let firsts = tracks.iter().map(|track| track.times[0]);
        let start_s = firsts.fold(f64::INFINITY, f64::min);
        let lasts = tracks
            .iter()
            .filter_map(|track| track.times.last().copied());
        let end_s = lasts.fold(start_s, f64::max);
        let steps = libm::round((end_s - start_s) * sample_rate_hz);
        if (steps + 1.0) * nodes.len() as f64 > MAX_POSES {
            return Err(format!(
                "{steps} frames of {} joints are too many: cut the animation",
                nodes.len()
            ));
        }
        Ok(Self {
            tracks,
            start_s,
            sample_rate_hz,
            len: steps as usize + 1,
            warnings,
        })
    }

    /// Returns the properties that the clip moves in a frame: node, property, value.
    pub(super) fn sample(&self, frame: usize) -> impl Iterator<Item = (usize, Moves, DVec4)> {
        let time = self.start_s + frame as f64 / self.sample_rate_hz;
        // Key times are f32: a frame this near to a key takes its value.
        let snap_s = 0.01 / self.sample_rate_hz;
        self.tracks
            .iter()
            .map(move |track| (track.node, track.moves, track.at(time, snap_s)))
    }
}

/// Returns the frame rate that preserves the keys, Hz.
fn rate(times: &[f64], warnings: &mut Vec<String>) -> Result<f64, String> {
    let [first, .., last] = times else {
        return Ok(LEAST_RATE_HZ);
    };
    let mean = (times.len() - 1) as f64 / (last - first);
    let whole = libm::round(mean);
    let mean = if (mean / whole - 1.0).abs() < 1e-4 {
        whole
    } else {
        mean
    };
    let is_even = times
        .iter()
        .enumerate()
        .all(|(i, time)| ((time - first) * mean - i as f64).abs() < 0.05);
    let dense = if is_even {
        mean
    } else {
        let least = times.windows(2).map(|pair| pair[1] - pair[0]);
        let dense = (1.0 / least.fold(f64::INFINITY, f64::min)).min(UNEVEN_RATE_HZ);
        warnings.push(format!(
            "the keys are unevenly spaced: sampled at {:.4} Hz",
            dense.max(LEAST_RATE_HZ)
        ));
        dense.max(LEAST_RATE_HZ)
    };
    if dense > 10_000.0 {
        return Err(format!(
            "expected keys at 10000 Hz at most, found {dense:.0}"
        ));
    }
    if dense < LEAST_RATE_HZ {
        let rate = dense * libm::ceil(LEAST_RATE_HZ / dense);
        warnings.push(format!(
            "the keys are at {dense:.4} Hz: sampled at {rate:.4} Hz"
        ));
        return Ok(rate);
    }
    Ok(dense)
}

impl KeyTrack {
    fn read(
        sampler: &gltf::animation::Sampler,
        buffers: &Buffers,
        node: usize,
        moves: Moves,
    ) -> Result<Self, String> {
        let interpolation = sampler.interpolation();
        let times: Vec<f64> = buffers
            .numbers(&sampler.input())?
            .into_iter()
            .map(|[t]| t)
            .collect();
        if times.is_empty() || times.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err("expected ascending key times".into());
        }
        let values: Vec<DVec4> = match moves {
            Moves::Rotation => buffers
                .numbers(&sampler.output())?
                .into_iter()
                .map(DVec4::from_array)
                .collect(),
            Moves::Translation | Moves::Scale => buffers
                .numbers(&sampler.output())?
                .into_iter()
                .map(|value| DVec3::from_array(value).extend(0.0))
                .collect(),
        };
        let each = match interpolation {
            Interpolation::CubicSpline => 3,
            _ => 1,
        };
        if values.len() != each * times.len() {
            return Err(format!(
                "expected {} values for {} keys, found {}",
                each * times.len(),
                times.len(),
                values.len()
            ));
        }
        let keys = values.iter().skip(each / 2).step_by(each);
        if moves == Moves::Rotation && keys.into_iter().any(|q| q.length() < 1e-6) {
            return Err("a rotation of length 0".into());
        }
        Ok(Self {
            node,
            moves,
            interpolation,
            times,
            values,
        })
    }

    /// Returns the value at a time, or of a key within `snap_s` of it; outside the keys, of the
    /// nearest key (glTF 2.0, appendix C).
    fn at(&self, time: f64, snap_s: f64) -> DVec4 {
        let after = self.times.partition_point(|key| *key <= time + snap_s);
        let last = self.times.len() - 1;
        let cubic = self.interpolation == Interpolation::CubicSpline;
        let value = |key: usize| self.values[if cubic { 3 * key + 1 } else { key }];
        if after == 0 || after > last || time - self.times[after - 1] <= snap_s {
            return value(after.saturating_sub(1));
        }
        let (a, b) = (after - 1, after);
        let span = self.times[b] - self.times[a];
        let u = (time - self.times[a]) / span;
        match self.interpolation {
            Interpolation::Step => value(a),
            Interpolation::Linear if self.moves == Moves::Rotation => {
                let [from, to] = [a, b].map(|key| DQuat::from_vec4(value(key).normalize()));
                from.slerp(to, u).into()
            }
            Interpolation::Linear => value(a).lerp(value(b), u),
            Interpolation::CubicSpline => {
                let (u2, u3) = (u * u, u * u * u);
                value(a) * (2.0 * u3 - 3.0 * u2 + 1.0)
                    + self.values[3 * a + 2] * (span * (u3 - 2.0 * u2 + u))
                    + value(b) * (3.0 * u2 - 2.0 * u3)
                    + self.values[3 * b] * (span * (u3 - u2))
            }
        }
    }
}
