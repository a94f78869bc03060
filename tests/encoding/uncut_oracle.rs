//! A second decoder of uncut motions, in f64, implemented from FORMAT.md, to check the core's
//! decoder.

use edgegait::people::UncutMotion;
use edgegait_core::skeleton::{JOINTS, Joint, Skeleton};
use glam::{DQuat, DVec3};

/// The unpacked channels of an uncut motion.
pub struct Oracle {
    duration_us: u64,
    interval_us: u64,
    channels: Vec<Channel>,
    /// The reference times the basis, and the inverse of the basis, by joint.
    frames: Vec<(DQuat, DQuat)>,
}

struct Channel {
    step: f64,
    spacing: u32,
    knots: Vec<i64>,
}

struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Bits<'_> {
    fn unsigned(&mut self, width: usize) -> i64 {
        let bit = |at: usize| i64::from(self.bytes[at / 8] >> (at % 8) & 1);
        let value = (0..width).map(|i| bit(self.at + i) << i).sum();
        self.at += width;
        value
    }

    fn signed(&mut self, width: usize) -> i64 {
        let value = self.unsigned(width);
        if width > 0 && value >> (width - 1) == 1 {
            value - (1 << width)
        } else {
            value
        }
    }
}

fn word(bytes: &[u8], at: usize, len: usize) -> u64 {
    (0..len).map(|i| u64::from(bytes[at + i]) << (8 * i)).sum()
}

impl Oracle {
    /// Unpacks an uncut motion with its codebook.
    pub fn new(take: &[u8], codebook: &[u8]) -> Self {
        assert_eq!(take[0], 2);
        let (duration_us, interval_us) = (word(take, 2, 8), word(take, 10, 4));
        let intervals = duration_us.div_ceil(interval_us).max(1);
        let rest = &take[22..];
        let mut table = Bits { bytes: rest, at: 0 };
        let steps: Vec<f64> = (0..60)
            .map(|channel| {
                let index = u32::from(take[1]) + u32::from(codebook[228 + channel]);
                (f64::from(index.min(255)) / 8.0 - 20.0).exp2()
            })
            .collect();
        let heading = steps[..3].iter().copied().fold(f64::MAX, f64::min);
        let mut heads = Vec::new();
        let mut channels = Vec::new();
        for step in steps.into_iter().chain([heading]) {
            let spacing = table.unsigned(2) as u32;
            let width = table.unsigned(5) as usize;
            let least = table.signed(width);
            let (mut base, mut widest, mut knots) = (0, 0, vec![least]);
            if spacing < 3 {
                (base, widest) = (table.unsigned(5) as usize, table.unsigned(5));
                knots.clear();
            }
            heads.push((least, base, widest));
            channels.push(Channel {
                step,
                spacing,
                knots,
            });
        }
        let ends_at = table.at.div_ceil(8);
        let wanted = |channel: &Channel| intervals.div_ceil(1 << channel.spacing) as usize + 3;
        let blocks = channels
            .iter()
            .filter(|channel| channel.spacing < 3)
            .map(|channel| wanted(channel).div_ceil(16 >> channel.spacing))
            .max()
            .unwrap_or(0);
        let (mut start, body) = (0, ends_at + 4 * blocks);
        for block in 0..blocks {
            let end = word(rest, ends_at + 4 * block, 4) as usize;
            let mut bits = Bits {
                bytes: &rest[body + start..body + end],
                at: 0,
            };
            for (channel, &(least, base, widest)) in channels.iter_mut().zip(&heads) {
                if channel.spacing == 3 {
                    continue;
                }
                let left = wanted(channel) - channel.knots.len();
                let count = left.min(16 >> channel.spacing);
                if count == 0 {
                    continue;
                }
                let base = least + bits.unsigned(base);
                let bits_of_width = (0..6).find(|bits| widest >> bits == 0).unwrap();
                let width = bits.unsigned(bits_of_width) as usize;
                for _ in 0..count {
                    channel.knots.push(base + bits.unsigned(width));
                }
            }
            assert_eq!(bits.at.div_ceil(8), end - start);
            start = end;
        }
        assert_eq!(body + start, rest.len());
        let component = |at: usize| f64::from(word(codebook, at, 2) as u16 as i16) * 4.0 / 32_767.0;
        let vector = |at| DVec3::new(component(at), component(at + 2), component(at + 4));
        let frames = (0..JOINTS)
            .map(|joint| {
                let basis = turn(vector(12 * joint + 6));
                (turn(vector(12 * joint)) * basis, basis.inverse())
            })
            .collect();
        Self {
            duration_us,
            interval_us,
            channels,
            frames,
        }
    }

    fn value(&self, channel: usize, seconds: f64) -> f64 {
        let channel = &self.channels[channel];
        if channel.spacing == 3 {
            return channel.knots[0] as f64 * channel.step;
        }
        let apart = (self.interval_us << channel.spacing) as f64;
        let position = (seconds * 1e6).clamp(0.0, self.duration_us as f64) / apart;
        let first = (position as usize).min(channel.knots.len() - 4);
        // De Boor's recursion over the knots' own indices.
        let x = position - first as f64;
        let mut points: Vec<f64> = (0..4).map(|i| channel.knots[first + i] as f64).collect();
        for level in 1..4usize {
            for i in (level..4).rev() {
                // The knots of the recursion are at -2, -1, 0, 1, 2, 3 intervals.
                let (low, high) = (i as f64 - 3.0, i as f64 - level as f64 + 1.0);
                let share = (x - low) / (high - low);
                points[i] = points[i - 1] * (1.0 - share) + points[i] * share;
            }
        }
        points[3] * channel.step
    }

    /// Returns the root and the rotations at a time.
    pub fn sample(&self, seconds: f64) -> (DVec3, [DQuat; JOINTS]) {
        let vector = |first| DVec3::from_array([0, 1, 2].map(|i| self.value(first + i, seconds)));
        let mut rotations = [DQuat::IDENTITY; JOINTS];
        for (joint, (left, right)) in self.frames.iter().enumerate() {
            rotations[joint] = *left * turn(vector(3 * joint)) * *right;
        }
        rotations[0] = DQuat::from_rotation_y(self.value(60, seconds)) * rotations[0];
        (vector(57), rotations)
    }

    /// Returns the greatest distance of the six points 3 cm off each joint from their places in the
    /// frames of `span`, mm.
    pub fn max_error_mm(&self, span: &UncutMotion, skeleton: &Skeleton) -> f64 {
        let points = |(root, rotations): &(DVec3, [DQuat; JOINTS])| {
            let mut placed = [(*root, rotations[0]); JOINTS];
            for joint in Joint::ALL {
                if let Some(parent) = joint.parent() {
                    let (at, turned) = placed[parent.index()];
                    let offset = skeleton.offsets[joint.index()].as_dvec3();
                    placed[joint.index()] =
                        (at + turned * offset, turned * rotations[joint.index()]);
                }
            }
            let arms = [
                DVec3::X,
                DVec3::Y,
                DVec3::Z,
                -DVec3::X,
                -DVec3::Y,
                -DVec3::Z,
            ];
            placed.map(|(at, turned)| arms.map(|arm| at + turned * arm * 0.03))
        };
        let frames = span.roots.iter().zip(&span.rotations).enumerate();
        let errors = frames.flat_map(|(frame, (root, rotations))| {
            let truth = points(&(*root, *rotations));
            let found = points(&self.sample(frame as f64 / span.sample_rate_hz));
            let pairs = truth.into_iter().flatten().zip(found.into_iter().flatten());
            pairs.map(|(a, b)| a.distance(b) * 1e3).collect::<Vec<_>>()
        });
        errors.fold(0.0, f64::max)
    }
}

/// Converts a vector of length 4 tan(angle / 4) along an axis to a rotation.
fn turn(vector: DVec3) -> DQuat {
    let length = vector.length();
    if length == 0.0 {
        return DQuat::IDENTITY;
    }
    DQuat::from_axis_angle(vector / length, 4.0 * (length / 4.0).atan())
}
