//! One gait cycle in a few hundred bytes.
//!
//! A clip holds 60 channels (three of a rotation vector for each joint, three of
//! the pelvis's position), each a Fourier series of the phase: what repeats once
//! a cycle is short as a Fourier series, any phase decodes directly, and the last
//! frame meets the first by construction. A joint's rotation is a constant
//! reference followed by the rotation vector, so that vectors stay short.

use crate::bits::BitReader;
use crate::budget::{MAX_COEFFICIENTS, MAX_HARMONICS};
use crate::format::{
    CLIP_HEADER_BYTES, CLIP_LOOP, COUNT_BITS, FormatError, REFERENCE_BITS, STEP_BITS, WIDTH_BITS,
    band_length, step_size, u16_at, u32_at,
};
use crate::pose::Pose;
use crate::skeleton::{JOINTS, Joint};
use glam::{Quat, Vec3};

/// A closed gait cycle, read in place from a pack's bytes.
#[derive(Clone, Copy, Debug)]
pub struct Clip<'a> {
    header: &'a [u8],
    stream: &'a [u8],
}

impl<'a> Clip<'a> {
    /// Checks every length and field of `bytes`; decoding cannot fail afterwards.
    ///
    /// # Errors
    /// Where the bytes are not one whole clip of this version.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let (Some(header), Some(stream)) = (
            bytes.get(..CLIP_HEADER_BYTES),
            bytes.get(CLIP_HEADER_BYTES..),
        ) else {
            return Err(FormatError::new(bytes.len(), "a clip header of 16 bytes"));
        };
        if header.first() != Some(&CLIP_LOOP) {
            return Err(FormatError::new(0, "clip kind 1 (loop)"));
        }
        if header.get(1) != Some(&0) {
            return Err(FormatError::new(1, "a reserved byte of 0"));
        }
        if u32_at(header, 2) == 0 {
            return Err(FormatError::new(2, "a period above 0 microseconds"));
        }
        if usize::from(u16_at(header, 14)) != stream.len() {
            return Err(FormatError::new(14, "the length of the clip's bit stream"));
        }
        let clip = Self { header, stream };
        let used = clip.check_stream()?;
        if used.div_ceil(8) != stream.len() {
            return Err(FormatError::new(
                CLIP_HEADER_BYTES,
                "a bit stream that ends with its last channel",
            ));
        }
        // Whatever decodes to the same walk is the same bytes.
        if let (Some(last), rest @ 1..) = (stream.last(), used % 8)
            && last >> rest != 0
        {
            return Err(FormatError::new(
                bytes.len() - 1,
                "zeros behind a clip's last channel",
            ));
        }
        Ok(clip)
    }

    /// Walks the bit stream without decoding it; the bits that it uses.
    fn check_stream(&self) -> Result<usize, FormatError> {
        let mut bits = BitReader::new(self.stream);
        let check = |bits: &BitReader<'_>| {
            if bits.is_overrun() {
                return Err(FormatError::new(
                    CLIP_HEADER_BYTES + self.stream.len(),
                    "the rest of a clip's bit stream",
                ));
            }
            Ok(())
        };
        for _ in 0..JOINTS {
            read_reference(&mut bits);
            for _ in 0..3 {
                skip_channel(&mut bits);
                check(&bits)?;
            }
        }
        for _ in 0..3 {
            skip_channel(&mut bits);
            check(&bits)?;
        }
        Ok(bits.position())
    }

    /// Duration of the cycle, seconds.
    #[must_use]
    pub fn period_s(&self) -> f32 {
        // At most 4,295 s: f32 keeps 0.3 ms of that, and 60 ns of a second.
        #[expect(clippy::cast_precision_loss, reason = "stated above")]
        let microseconds = u32_at(self.header, 2) as f32;
        microseconds * 1e-6
    }

    /// Metres travelled along +Z in one cycle.
    #[must_use]
    pub fn drift_m(&self) -> f32 {
        #[expect(clippy::cast_precision_loss, reason = "16 m keep 1 micrometre")]
        let micrometres = u32_at(self.header, 6).cast_signed() as f32;
        micrometres * 1e-6
    }

    /// Greatest error that the encoder measured, mm: virtual points 3 cm off each
    /// joint, in the walker's space, over all frames, against what it was given.
    #[must_use]
    pub fn max_error_mm(&self) -> f32 {
        f32::from(u16_at(self.header, 10)) * 0.01
    }

    /// Mean of the same errors, mm.
    #[must_use]
    pub fn mean_error_mm(&self) -> f32 {
        f32::from(u16_at(self.header, 12)) * 0.01
    }

    /// Bytes that the clip takes in its pack.
    #[must_use]
    pub fn len_bytes(&self) -> usize {
        self.header.len() + self.stream.len()
    }

    /// The pose at `phase`, in cycles: 0 is the left heel's contact and 1 is the
    /// same pose again. The travel along +Z is left out, so that the walker stays
    /// at the origin; it is [`Clip::drift_m`] times the phase.
    ///
    /// Any float is taken; one that is not finite counts as 0. Reads the whole
    /// stream: 2 to 4 microseconds on a host.
    #[must_use]
    pub fn pose(&self, phase: f32) -> Pose {
        let basis = Basis::new(phase);
        let mut bits = BitReader::new(self.stream);
        let mut pose = Pose::REST;
        for joint in Joint::ALL {
            let reference = read_reference(&mut bits);
            let vector = read_vector(&mut bits, &basis);
            pose.rotations[joint.index()] = (reference * rotation(vector)).normalize();
        }
        pose.root = read_vector(&mut bits, &basis);
        pose
    }
}

/// Values of the Fourier basis at one phase: 1, cos 1, sin 1, cos 2, sin 2...
struct Basis {
    values: [f32; MAX_COEFFICIENTS],
}

impl Basis {
    fn new(phase: f32) -> Self {
        let phase = if phase.is_finite() {
            phase - libm::floorf(phase)
        } else {
            0.0
        };
        let (sin, cos) = libm::sincosf(core::f32::consts::TAU * phase);
        let mut values = [1.0; MAX_COEFFICIENTS];
        let (mut harmonic_cos, mut harmonic_sin) = (cos, sin);
        for harmonic in 1..=MAX_HARMONICS {
            values[2 * harmonic - 1] = harmonic_cos;
            values[2 * harmonic] = harmonic_sin;
            (harmonic_cos, harmonic_sin) = (
                harmonic_cos * cos - harmonic_sin * sin,
                harmonic_cos * sin + harmonic_sin * cos,
            );
        }
        Self { values }
    }
}

/// The rotation about `vector` by its length, radians.
fn rotation(vector: Vec3) -> Quat {
    let angle = vector.length();
    if angle < 1e-6 {
        let half = vector * 0.5;
        return Quat::from_xyzw(half.x, half.y, half.z, 1.0);
    }
    let (sin, cos) = libm::sincosf(0.5 * angle);
    let axis = vector * (sin / angle);
    Quat::from_xyzw(axis.x, axis.y, axis.z, cos)
}

/// A unit quaternion as its three smallest components (Gea 2012, "smallest three").
fn read_reference(bits: &mut BitReader<'_>) -> Quat {
    const LIMIT: f32 = core::f32::consts::FRAC_1_SQRT_2;
    #[expect(clippy::cast_precision_loss, reason = "15 bits")]
    const SCALE: f32 = LIMIT / ((1 << (REFERENCE_BITS - 1)) - 1) as f32;
    let largest = bits.unsigned(2) as usize;
    let mut components = [0.0; 4];
    let mut squares = 0.0;
    for (index, component) in components.iter_mut().enumerate() {
        if index != largest {
            #[expect(clippy::cast_precision_loss, reason = "15 bits")]
            let value = bits.signed(REFERENCE_BITS) as f32 * SCALE;
            *component = value;
            squares += value * value;
        }
    }
    components[largest] = libm::sqrtf((1.0 - squares).max(0.0));
    Quat::from_array(components).normalize()
}

/// Three channels as a vector.
fn read_vector(bits: &mut BitReader<'_>, basis: &Basis) -> Vec3 {
    let x = read_channel(bits, basis);
    let y = read_channel(bits, basis);
    let z = read_channel(bits, basis);
    Vec3::new(x, y, z)
}

/// One channel's value: the sum of its coefficients times the basis.
fn read_channel(bits: &mut BitReader<'_>, basis: &Basis) -> f32 {
    let count = bits.unsigned(COUNT_BITS) as usize;
    if count == 0 {
        return 0.0;
    }
    let step = step_size(bits.unsigned(STEP_BITS));
    let mut sum = 0.0;
    let mut first = 0;
    let mut band = 0;
    while first < count {
        let last = (first + band_length(band)).min(count);
        let width = bits.unsigned(WIDTH_BITS);
        for value in basis.values.iter().take(last).skip(first) {
            #[expect(clippy::cast_precision_loss, reason = "at most 15 bits")]
            let coefficient = bits.signed(width) as f32;
            sum += coefficient * value;
        }
        first = last;
        band += 1;
    }
    sum * step
}

/// Moves over one channel.
fn skip_channel(bits: &mut BitReader<'_>) {
    let count = bits.unsigned(COUNT_BITS) as usize;
    if count == 0 {
        return;
    }
    bits.unsigned(STEP_BITS);
    let mut first = 0;
    let mut band = 0;
    while first < count {
        let last = (first + band_length(band)).min(count);
        let width = bits.unsigned(WIDTH_BITS);
        for _ in first..last {
            bits.unsigned(width);
        }
        first = last;
        band += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clip of all-constant joints: identity references and no coefficients,
    /// so that each joint takes 2 + 45 + 18 bits and the root 18.
    fn resting_clip() -> [u8; CLIP_HEADER_BYTES + 157] {
        let mut bytes = [0; CLIP_HEADER_BYTES + 157];
        bytes[0] = CLIP_LOOP;
        bytes[2..6].copy_from_slice(&1_100_000u32.to_le_bytes());
        bytes[6..10].copy_from_slice(&1_500_000i32.to_le_bytes());
        bytes[14..16].copy_from_slice(&157u16.to_le_bytes());
        for joint in 0..JOINTS {
            let bit = joint * 65;
            let byte = CLIP_HEADER_BYTES + bit / 8;
            let flags = 3u16 << (bit % 8); // largest component: w
            bytes[byte] |= flags.to_le_bytes()[0];
            bytes[byte + 1] |= flags.to_le_bytes()[1];
        }
        bytes
    }

    #[test]
    fn a_clip_without_coefficients_rests() {
        let bytes = resting_clip();
        let clip = Clip::parse(&bytes).expect("a whole clip");
        assert_eq!(clip.pose(0.3), Pose::REST);
        assert!((clip.period_s() - 1.1).abs() < 1e-6);
        assert!((clip.drift_m() - 1.5).abs() < 1e-6);
    }

    #[test]
    fn every_truncation_is_refused() {
        let bytes = resting_clip();
        for length in 0..bytes.len() {
            assert!(Clip::parse(&bytes[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn any_phase_is_taken() {
        let bytes = resting_clip();
        let clip = Clip::parse(&bytes).expect("a whole clip");
        for phase in [f32::NAN, f32::INFINITY, -1e30, 1e30, -0.25, 7.5] {
            assert_eq!(clip.pose(phase), Pose::REST);
        }
    }

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
    fn a_rotation_vector_turns_about_itself() {
        let turned = rotation(Vec3::new(0.0, core::f32::consts::FRAC_PI_2, 0.0)) * Vec3::Z;
        assert!((turned - Vec3::X).length() < 1e-6);
        let tiny = rotation(Vec3::new(1e-8, 0.0, 0.0));
        assert!((tiny.length() - 1.0).abs() < 1e-6);
    }
}
