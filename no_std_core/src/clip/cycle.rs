//! A gait cycle stored as a Fourier series, in a few hundred bytes.
//!
//! A loop holds 60 channels (three for the rotation of each joint, three for the pelvis's
//! position), each a Fourier series of the phase. Such a series is short for a periodic motion, any
//! phase decodes directly, and the last frame meets the first by construction. Its numbers are in
//! Rice codes, as differences from a mean walk of the codebook if the loop names one.

use super::basis::Basis;
use super::expanded::Expanded;
use crate::bits::BitReader;
use crate::codebook::{
    ChannelNumbers, ChannelParameters, CodeTable, Codebook, Codes, MeanWalk, TemplateChannel,
    read_numbers, skip_group,
};
use crate::format::{
    CHANNELS, CLIP_LOOP, FormatError, LOOP_HEADER_BYTES, MAX_GROUPS, u16_at, u32_at,
};
use crate::pose::Pose;
use crate::skeleton::Joint;
use glam::{Quat, Vec3};

/// A closed gait cycle, read in place from a pack's bytes.
#[derive(Clone, Copy, Debug)]
pub struct Loop<'a> {
    header: &'a [u8],
    stream: &'a [u8],
    codebook: Codebook<'a>,
}

impl<'a> Loop<'a> {
    /// Returns the loop of these bytes, which the caller has checked or will check.
    ///
    /// # Errors
    /// If the bytes are too few for a loop's header.
    pub(super) fn over(bytes: &'a [u8], codebook: &Codebook<'a>) -> Result<Self, FormatError> {
        let Some((header, stream)) = bytes.split_at_checked(LOOP_HEADER_BYTES) else {
            return Err(FormatError::new(bytes.len(), "a loop's header of 19 bytes"));
        };
        debug_assert_eq!(header.first(), Some(&CLIP_LOOP), "the caller looked");
        Ok(Self {
            header,
            stream,
            codebook: *codebook,
        })
    }

    /// Checks every length and field; `codes` are those of its codebook.
    pub(super) fn check(&self, codes: &CodeTable) -> Result<(), FormatError> {
        if usize::from(self.template_number()) > self.codebook.template_count() {
            return Err(FormatError::new(1, "the number of a template, or 0"));
        }
        if u32_at(self.header, 3) == 0 {
            return Err(FormatError::new(3, "a period above 0 microseconds"));
        }
        let mut numbers = BitReader::new(self.stream);
        for (channel, codes) in codes.channels() {
            let Some(groups) = channel.read_groups(&mut numbers) else {
                return Err(FormatError::new(
                    LOOP_HEADER_BYTES + numbers.position() / 8,
                    "no more groups than the codebook has for the channel",
                ));
            };
            for (group, &code) in codes.iter().take(groups).enumerate() {
                skip_group(&mut numbers, group, u32::from(code));
            }
        }
        numbers
            .check_end()
            .map_err(|error| error.behind(LOOP_HEADER_BYTES))
    }

    /// Returns the duration of the cycle, seconds, exact to a microsecond.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        f64::from(u32_at(self.header, 3)) * 1e-6
    }

    /// Returns the distance travelled along +Z in one cycle, metres.
    #[must_use]
    pub fn drift_m(&self) -> f32 {
        #[expect(clippy::cast_precision_loss, reason = "16 m keep 1 micrometre")]
        let micrometres = u32_at(self.header, 7).cast_signed() as f32;
        micrometres * 1e-6
    }

    /// Returns the greatest error that the encoder measured, mm ([`super::Clip::max_error_mm`]).
    #[must_use]
    pub fn max_error_mm(&self) -> f32 {
        f32::from(u16_at(self.header, 11)) * 0.01
    }

    /// Returns the mean error that the encoder measured, mm.
    #[must_use]
    pub fn mean_error_mm(&self) -> f32 {
        f32::from(u16_at(self.header, 13)) * 0.01
    }

    /// Returns the greatest distance by which closing the recorded cycle moved a joint before
    /// encoding, mm; 0 for a cycle that was generated closed.
    #[must_use]
    pub fn closure_mm(&self) -> f32 {
        f32::from(u16_at(self.header, 15)) * 0.1
    }

    /// Returns the number of frames that the encoder was given.
    #[must_use]
    pub fn frames(&self) -> u32 {
        u32::from(u16_at(self.header, 17))
    }

    /// Returns the number, from 1, of the mean walk from which its numbers are stored as
    /// differences; 0 for none.
    #[must_use]
    pub fn template_number(&self) -> u8 {
        self.header.get(1).copied().unwrap_or(0)
    }

    fn scale(&self) -> u8 {
        self.header.get(2).copied().unwrap_or(0)
    }

    /// Returns the size of the clip in its pack, bytes.
    #[must_use]
    pub const fn len_bytes(&self) -> usize {
        self.header.len() + self.stream.len()
    }

    /// Returns the pose at a time, seconds ([`super::Clip::sample`]).
    #[must_use]
    pub fn sample(&self, seconds: f64) -> Pose {
        self.pose(self.phase(seconds))
    }

    /// Returns the phase at a time, seconds: 0..1, in cycles. A time that is not finite counts as 0.
    #[must_use]
    pub fn phase(&self, seconds: f64) -> f32 {
        phase_at(seconds, self.period_s())
    }

    /// Returns the pose at `phase`, in cycles: 0 is the left heel's contact and 1 is the same pose
    /// again. The travel along +Z is left out, so that the walker stays at the origin; it is
    /// [`Loop::drift_m`] times the phase.
    ///
    /// Any float is accepted; one that is not finite counts as 0. Reads the whole stream, and the
    /// template's: about 3 microseconds on a host ([`Loop::expand`] is for many poses of one loop).
    #[must_use]
    pub fn pose(&self, phase: f32) -> Pose {
        let basis = Basis::new(phase);
        let mut reader = CoefficientReader::new(self);
        let mut channels = [0.0; CHANNELS];
        for (channel, value) in channels.iter_mut().enumerate() {
            reader.channel(channel, |group, coefficients| {
                let [first, second] = basis.pairs[group % MAX_GROUPS];
                *value += coefficients[0] * first;
                *value += coefficients[1] * second;
            });
        }
        let mut pose = Pose::REST;
        let (vectors, _) = channels.as_chunks::<3>();
        for (joint, &vector) in Joint::ALL.into_iter().zip(vectors) {
            let turned = self.codebook.frame(joint).turn(vector);
            pose.rotations[joint.index()] = Quat::from_array(turned);
        }
        pose.root = vectors.last().map_or(Vec3::ZERO, |&root| root.into());
        pose
    }

    /// Returns the length of the buffer that [`Loop::expand`] needs.
    #[must_use]
    pub fn expanded_len(&self) -> usize {
        let mut most = 0;
        self.coefficients(|_, index, _| most = most.max(index + 1));
        Expanded::len_for(most)
    }

    /// Unpacks the coefficients into `buffer` once, so that each pose takes a 15th of the time;
    /// `None` if `buffer` is shorter than [`Loop::expanded_len`]. Poses are the same, bit for bit.
    #[must_use]
    pub fn expand<'b>(&self, buffer: &'b mut [f32]) -> Option<Expanded<'b>> {
        let buffer = buffer.get_mut(..self.expanded_len())?;
        buffer.fill(0.0);
        self.coefficients(|channel, index, coefficient| {
            if let Some(slot) = buffer.get_mut(Expanded::slot(channel, index)) {
                *slot = coefficient;
            }
        });
        Some(Expanded::new(buffer, &self.codebook))
    }

    /// Calls `each` with the channel, index and value of every coefficient.
    fn coefficients(&self, mut each: impl FnMut(usize, usize, f32)) {
        let mut reader = CoefficientReader::new(self);
        for channel in 0..CHANNELS {
            reader.channel(channel, |group, [first, second]| {
                let index = (2 * group).saturating_sub(1);
                each(channel, index, first);
                if group > 0 {
                    each(channel, index + 1, second);
                }
            });
        }
    }
}

/// Returns the phase at a time of a cycle of `period_s`, 0..1.
fn phase_at(seconds: f64, period_s: f64) -> f32 {
    if !seconds.is_finite() {
        return 0.0;
    }
    // `fmod` is exact: phases are as precise in the tenth hour as in the first second.
    #[expect(clippy::cast_possible_truncation, reason = "a phase")]
    let phase = (libm::fmod(seconds, period_s) / period_s) as f32;
    phase
}

/// A reader of a loop's coefficients, channel by channel.
struct CoefficientReader<'a> {
    codebook: Codebook<'a>,
    parameters: BitReader<'a>,
    numbers: BitReader<'a>,
    scale: u8,
    template: Option<MeanWalk<'a>>,
    /// The Rice parameters of the current channel's groups, its own numbers, and the template's
    /// numbers.
    codes: Codes,
    own: ChannelNumbers,
    usual: ChannelNumbers,
}

impl<'a> CoefficientReader<'a> {
    fn new(cycle: &Loop<'a>) -> Self {
        Self {
            codebook: cycle.codebook,
            parameters: cycle.codebook.parameters(),
            numbers: BitReader::new(cycle.stream),
            scale: cycle.scale(),
            template: cycle.codebook.template(cycle.template_number()),
            codes: [0; MAX_GROUPS],
            own: [[0; 2]; MAX_GROUPS],
            usual: [[0; 2]; MAX_GROUPS],
        }
    }

    /// Reads the next channel, which is `channel`: calls `each` with the number of each stored
    /// group and its two coefficients; the constant's second one is 0. Nothing can be missing: the
    /// loop and its codebook were checked.
    #[inline]
    fn channel(&mut self, channel: usize, mut each: impl FnMut(usize, [f32; 2])) {
        // One stream after another, so that the state of each reader stays in registers.
        let parameters =
            ChannelParameters::read(&mut self.parameters).unwrap_or(ChannelParameters::NONE);
        if parameters.groups == 0 {
            return;
        }
        let codes = parameters.read_codes(&mut self.parameters, &mut self.codes);
        let groups = parameters.read_groups(&mut self.numbers).unwrap_or(0);
        let own_codes = codes.get(..groups).unwrap_or_default();
        let own_codes = own_codes.iter().map(|&code| u32::from(code));
        let own = read_numbers(&mut self.numbers, own_codes, &mut self.own);
        let step = self.codebook.step(channel, self.scale);
        let (mut usual, mut mean_step) = (&[][..], 0.0);
        if let Some(template) = &mut self.template {
            let mean = TemplateChannel::read(&mut template.bits, &parameters).unwrap_or_default();
            let codes = codes.get(..mean.groups).unwrap_or_default();
            let codes = codes.iter().map(|&code| mean.code(code));
            usual = read_numbers(&mut template.bits, codes, &mut self.usual);
            mean_step = self.codebook.step(channel, template.scale);
        }
        for (group, (&own, &usual)) in own.iter().zip(usual).enumerate() {
            let [first, second] =
                [0, 1].map(|of| as_float(own[of]) * step + as_float(usual[of]) * mean_step);
            each(group, [first, second]);
        }
        // Groups that only one of them has: the other's product is 0.
        let shared = own.len().min(usual.len());
        for (numbers, step) in [(own, step), (usual, mean_step)] {
            for (group, numbers) in numbers.iter().enumerate().skip(shared) {
                each(group, numbers.map(|number| as_float(number) * step));
            }
        }
    }
}

#[inline]
fn as_float(number: i32) -> f32 {
    #[expect(clippy::cast_precision_loss, reason = "24 bits and less")]
    let number = number as f32;
    number
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::MAX_HARMONICS;

    #[test]
    fn the_basis_is_the_cosines_and_sines_of_the_phase() {
        let basis = Basis::new(0.2);
        for harmonic in 1..=MAX_HARMONICS {
            let angle = core::f64::consts::TAU * 0.2 * harmonic as f64;
            let (cos, sin) = (libm::cos(angle), libm::sin(angle));
            assert!((f64::from(basis.pairs[harmonic][0]) - cos).abs() < 1e-5);
            assert!((f64::from(basis.pairs[harmonic][1]) - sin).abs() < 1e-5);
        }
    }

    #[test]
    fn the_tenth_hour_has_the_phases_of_the_first_second() {
        let period_s = 1.1;
        for cycles in [1.0, 1_000.0, 32_727.0] {
            for phase in [0.0, 0.1, 0.5, 0.9] {
                let found = phase_at((cycles + phase) * period_s, period_s);
                let off = (f64::from(found) - phase + 0.5).rem_euclid(1.0) - 0.5;
                assert!(off.abs() < 1e-7, "{cycles} + {phase}: {found}");
            }
        }
        for wild in [f64::NAN, f64::INFINITY, -1e300, f64::MIN_POSITIVE] {
            assert!((-1.0..=1.0).contains(&phase_at(wild, period_s)));
        }
    }
}
