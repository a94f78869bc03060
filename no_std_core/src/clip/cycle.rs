//! One gait cycle in a few hundred bytes.
//!
//! A loop holds 60 channels (three of a rotation for each joint, three of the pelvis's
//! position), each a Fourier series of the phase: what repeats once a cycle is short as a
//! Fourier series, any phase decodes directly, and the last frame meets the first by
//! construction. Its numbers are differences to a template of the codebook, if it names
//! one, in Rice codes.

use super::expanded::Expanded;
use crate::bits::BitReader;
use crate::budget::{MAX_COEFFICIENTS, MAX_HARMONICS};
use crate::codebook::{Codebook, Parameters, Template, TemplateChannel, group_numbers};
use crate::format::{CHANNELS, CLIP_LOOP, FormatError, LOOP_HEADER_BYTES, u16_at, u32_at};
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
    /// Checks every length and field of `bytes`.
    pub(super) fn parse(bytes: &'a [u8], codebook: &Codebook<'a>) -> Result<Self, FormatError> {
        let (Some(header), Some(stream)) = (
            bytes.get(..LOOP_HEADER_BYTES),
            bytes.get(LOOP_HEADER_BYTES..),
        ) else {
            return Err(FormatError::new(bytes.len(), "a loop's header of 19 bytes"));
        };
        debug_assert_eq!(header.first(), Some(&CLIP_LOOP), "the caller looked");
        let cycle = Self {
            header,
            stream,
            codebook: *codebook,
        };
        if usize::from(cycle.template_number()) > codebook.template_count() {
            return Err(FormatError::new(1, "the number of a template, or 0"));
        }
        if u32_at(header, 3) == 0 {
            return Err(FormatError::new(3, "a period above 0 microseconds"));
        }
        let mut reader = Reader::new(&cycle);
        for channel in 0..CHANNELS {
            if reader.channel(channel, |_, _| ()).is_none() {
                return Err(FormatError::new(
                    LOOP_HEADER_BYTES + reader.numbers.position() / 8,
                    "no more groups than the codebook has for the channel",
                ));
            }
        }
        reader
            .numbers
            .check_end()
            .map_err(|error| error.behind(LOOP_HEADER_BYTES))?;
        Ok(cycle)
    }

    /// Duration of the cycle, seconds, exact to a microsecond.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        f64::from(u32_at(self.header, 3)) * 1e-6
    }

    /// Metres travelled along +Z in one cycle.
    #[must_use]
    pub fn drift_m(&self) -> f32 {
        #[expect(clippy::cast_precision_loss, reason = "16 m keep 1 micrometre")]
        let micrometres = u32_at(self.header, 7).cast_signed() as f32;
        micrometres * 1e-6
    }

    /// Greatest error that the encoder measured, mm ([`super::Clip::max_error_mm`]).
    #[must_use]
    pub fn max_error_mm(&self) -> f32 {
        f32::from(u16_at(self.header, 11)) * 0.01
    }

    /// Mean of the same errors, mm.
    #[must_use]
    pub fn mean_error_mm(&self) -> f32 {
        f32::from(u16_at(self.header, 13)) * 0.01
    }

    /// How far closing the recorded cycle moved any joint at most, mm, before it was
    /// encoded; 0 for a cycle that was made closed.
    #[must_use]
    pub fn closure_mm(&self) -> f32 {
        f32::from(u16_at(self.header, 15)) * 0.1
    }

    /// Frames that the encoder was given.
    #[must_use]
    pub fn frames(&self) -> u32 {
        u32::from(u16_at(self.header, 17))
    }

    /// The template that its numbers are differences to, counted from 1; 0 for none.
    #[must_use]
    pub fn template_number(&self) -> u8 {
        self.header.get(1).copied().unwrap_or(0)
    }

    fn scale(&self) -> u8 {
        self.header.get(2).copied().unwrap_or(0)
    }

    /// Bytes that the clip takes in its pack.
    #[must_use]
    pub const fn len_bytes(&self) -> usize {
        self.header.len() + self.stream.len()
    }

    /// The pose at a time, seconds ([`super::Clip::sample`]).
    #[must_use]
    pub fn sample(&self, seconds: f64) -> Pose {
        self.pose(phase_at(seconds, self.period_s()))
    }

    /// The pose at `phase`, in cycles: 0 is the left heel's contact and 1 is the
    /// same pose again. The travel along +Z is left out, so that the walker stays
    /// at the origin; it is [`Loop::drift_m`] times the phase.
    ///
    /// Any float is taken; one that is not finite counts as 0. Reads the whole
    /// stream, and the template's: 3 to 6 microseconds on a host ([`Loop::expand`] is for
    /// many poses of one loop).
    #[must_use]
    pub fn pose(&self, phase: f32) -> Pose {
        let basis = Basis::new(phase);
        let mut reader = Reader::new(self);
        let mut channels = [0.0; CHANNELS];
        for (channel, value) in channels.iter_mut().enumerate() {
            // Cannot end early: `parse` has been through all channels.
            let _ = reader.channel(channel, |index, coefficient| {
                *value += coefficient * basis.values.get(index).copied().unwrap_or(0.0);
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

    /// How many numbers [`Loop::expand`] needs.
    #[must_use]
    pub fn expanded_len(&self) -> usize {
        let mut most = 0;
        self.coefficients(|_, index, _| most = most.max(index + 1));
        Expanded::len_for(most)
    }

    /// Unpacks the coefficients into `buffer` once, for poses that take a 17th of the
    /// time; `None` if it is shorter than [`Loop::expanded_len`]. Poses are the same, bit
    /// for bit.
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

    /// Calls `each` with the channel, index and value of all coefficients.
    fn coefficients(&self, mut each: impl FnMut(usize, usize, f32)) {
        let mut reader = Reader::new(self);
        for channel in 0..CHANNELS {
            // Cannot end early: `parse` has been through all channels.
            let _ = reader.channel(channel, |index, value| each(channel, index, value));
        }
    }
}

/// The phase at a time of a cycle of `period_s`, in 0..1.
fn phase_at(seconds: f64, period_s: f64) -> f32 {
    if !seconds.is_finite() {
        return 0.0;
    }
    // `fmod` is exact: the tenth hour has the phases of the first second.
    #[expect(clippy::cast_possible_truncation, reason = "a phase")]
    let phase = (libm::fmod(seconds, period_s) / period_s) as f32;
    phase
}

/// Reads the coefficients of a loop, channel by channel.
struct Reader<'a> {
    codebook: Codebook<'a>,
    parameters: BitReader<'a>,
    numbers: BitReader<'a>,
    scale: u8,
    template: Option<Template<'a>>,
}

impl<'a> Reader<'a> {
    fn new(cycle: &Loop<'a>) -> Self {
        Self {
            codebook: cycle.codebook,
            parameters: cycle.codebook.parameters(),
            numbers: BitReader::new(cycle.stream),
            scale: cycle.scale(),
            template: cycle.codebook.template(cycle.template_number()),
        }
    }

    /// Reads the next channel, which is `channel`: calls `each` with the index and value of
    /// its coefficients up to the last that is stated. `None` where more groups are stated
    /// than the codebook has.
    fn channel(&mut self, channel: usize, mut each: impl FnMut(usize, f32)) -> Option<()> {
        let mut parameters = Parameters::read(&mut self.parameters)?;
        if parameters.groups == 0 {
            return Some(());
        }
        let difference = self.numbers.rice(parameters.groups_rice);
        let groups = u32::try_from(parameters.usual_groups.checked_add(difference)?).ok()?;
        if groups > parameters.groups {
            return None;
        }
        let step = self.codebook.step(channel, self.scale);
        let (mut mean, mut mean_step) = (TemplateChannel::default(), 0.0);
        if let Some(template) = &mut self.template {
            mean = TemplateChannel::read(&mut template.bits, &parameters)?;
            mean_step = self.codebook.step(channel, template.scale);
        }
        let mut group = 0;
        while let Some(parameter) = parameters.next(&mut self.parameters) {
            let own = if group < groups {
                group_numbers(&mut self.numbers, group, parameter)
            } else {
                [0, 0]
            };
            let usual = self.template.as_mut().map_or([0, 0], |template| {
                mean.group(&mut template.bits, group, parameter)
            });
            if group < groups.max(mean.groups) {
                #[expect(clippy::cast_precision_loss, reason = "24 bits and less")]
                let value = |of: usize| {
                    let (own, usual) = if of == 0 {
                        (own[0], usual[0])
                    } else {
                        (own[1], usual[1])
                    };
                    own as f32 * step + usual as f32 * mean_step
                };
                let index = (2 * group as usize).saturating_sub(1);
                each(index, value(0));
                if group > 0 {
                    each(index + 1, value(1));
                }
            }
            group += 1;
        }
        Some(())
    }
}

/// Values of the Fourier basis at one phase: 1, cos 1, sin 1, cos 2, sin 2...
pub(super) struct Basis {
    pub(super) values: [f32; MAX_COEFFICIENTS],
}

impl Basis {
    pub(super) fn new(phase: f32) -> Self {
        Self::up_to(phase, MAX_HARMONICS)
    }

    /// The same up to a harmonic, and 1 behind it.
    pub(super) fn up_to(phase: f32, harmonics: usize) -> Self {
        let phase = if phase.is_finite() {
            phase - libm::floorf(phase)
        } else {
            0.0
        };
        let (sin, cos) = libm::sincosf(core::f32::consts::TAU * phase);
        let mut values = [1.0; MAX_COEFFICIENTS];
        let (mut harmonic_cos, mut harmonic_sin) = (cos, sin);
        if let Some((_, pairs)) = values.split_first_mut() {
            for pair in pairs.as_chunks_mut::<2>().0.iter_mut().take(harmonics) {
                *pair = [harmonic_cos, harmonic_sin];
                (harmonic_cos, harmonic_sin) = (
                    harmonic_cos * cos - harmonic_sin * sin,
                    harmonic_cos * sin + harmonic_sin * cos,
                );
            }
        }
        Self { values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_basis_is_the_cosines_and_sines_of_the_phase() {
        let basis = Basis::new(0.2);
        for harmonic in 1..=MAX_HARMONICS {
            let angle = core::f64::consts::TAU * 0.2 * harmonic as f64;
            let (cos, sin) = (libm::cos(angle), libm::sin(angle));
            assert!((f64::from(basis.values[2 * harmonic - 1]) - cos).abs() < 1e-5);
            assert!((f64::from(basis.values[2 * harmonic]) - sin).abs() < 1e-5);
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
