//! What all clips of a pack share: stated once, not in each of some hundred bytes.
//!
//! A joint's rotation is `reference * basis * v * basis^-1`: a usual pose, then a small
//! rotation `v` whose axes are those along which this joint really moves. A channel's
//! numbers come in steps that suit how far the joint moves what hangs on it, and in Rice
//! codes whose parameters are those of the pack's own walks. A template is a mean walk,
//! from which clips state their differences.

use crate::bits::BitReader;
use crate::format::{
    CHANNELS, CODEBOOK_BYTES, FRAME_BYTES, FRAME_STEP, FormatError, GROUPS_BITS, GROUPS_RICE_BITS,
    JOINT_ERRORS_AT, MAX_GROUPS, MAX_RICE, RICE_BITS, STEPS_AT, TEMPLATE_HEADER_BYTES, i16_at,
    step_size, u16_at,
};
use crate::rotation::{product, quaternion};
use crate::skeleton::Joint;
use crate::table::Table;
use glam::{Quat, Vec3};

/// A pack's codebook, read in place.
#[derive(Clone, Copy, Debug)]
pub struct Codebook<'a> {
    fixed: &'a [u8],
    parameters: &'a [u8],
    templates: Table<'a>,
}

/// The two rotations around a joint's own one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// Reference times basis.
    pub left: [f32; 4],
    /// The basis's inverse.
    pub right: [f32; 4],
}

impl Frame {
    /// The joint's rotation for a vector in its basis.
    #[inline]
    pub(crate) fn turn(&self, vector: [f32; 3]) -> [f32; 4] {
        product(product(self.left, quaternion(vector)), self.right)
    }
}

impl<'a> Codebook<'a> {
    /// Checks every field of `bytes`; reading cannot fail afterwards.
    ///
    /// # Errors
    /// Where the bytes are not one whole codebook.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let (Some(fixed), Some(parameters)) =
            (bytes.get(..CODEBOOK_BYTES), bytes.get(CODEBOOK_BYTES..))
        else {
            return Err(FormatError::new(bytes.len(), "the rest of the codebook"));
        };
        let codebook = Self {
            fixed,
            parameters,
            templates: Table::EMPTY,
        };
        let mut bits = BitReader::new(parameters);
        for _ in 0..CHANNELS {
            let Some(mut channel) = Parameters::read(&mut bits) else {
                return Err(FormatError::new(
                    CODEBOOK_BYTES + bits.position() / 8,
                    "at most 32 groups in a channel",
                ));
            };
            while let Some(parameter) = channel.next(&mut bits) {
                if parameter > MAX_RICE {
                    return Err(FormatError::new(
                        CODEBOOK_BYTES + bits.position() / 8,
                        "Rice parameters of 0 to 15",
                    ));
                }
            }
        }
        bits.check_end()
            .map_err(|error| error.behind(CODEBOOK_BYTES))?;
        Ok(codebook)
    }

    /// The same codebook with the templates of section `TMPL`.
    ///
    /// # Errors
    /// Where the bytes are not a table of templates, at most 255.
    pub fn with_templates(mut self, section: &'a [u8]) -> Result<Self, FormatError> {
        self.templates = Table::parse(section)?;
        if self.templates.len() > usize::from(u8::MAX) {
            return Err(FormatError::new(0, "at most 255 templates"));
        }
        for (at, entry) in self.templates.entries() {
            Template::parse(entry, &self).map_err(|e| e.behind(at))?;
        }
        Ok(self)
    }

    /// How many templates there are.
    #[must_use]
    pub fn template_count(&self) -> usize {
        self.templates.len()
    }

    /// The template that a clip names: 0 is none.
    pub(crate) fn template(&self, number: u8) -> Option<Template<'a>> {
        let index = usize::from(number).checked_sub(1)?;
        // Cannot fail for an entry: `with_templates` has been through all of them.
        Template::new(self.templates.entry(index)?.1)
    }

    /// Greatest and mean error of one joint over all clips of the pack, mm: virtual points
    /// 3 cm off the joint, in the walker's space, as the encoder measured them.
    #[must_use]
    pub fn joint_error_mm(&self, joint: Joint) -> (f32, f32) {
        let at = JOINT_ERRORS_AT + 4 * joint.index();
        let millimetres = |at| f32::from(u16_at(self.fixed, at)) * 0.01;
        (millimetres(at), millimetres(at + 2))
    }

    /// The rotation of a joint for a vector of [`crate::rotation`] in its basis.
    #[must_use]
    pub fn rotation(&self, joint: Joint, vector: Vec3) -> Quat {
        Quat::from_array(self.frame(joint).turn(vector.to_array()))
    }

    /// The rotations around a joint's own one: a joint's rotation is the first times
    /// [`crate::rotation::rotation`] of its vector times the second.
    #[must_use]
    pub fn frame_rotations(&self, joint: Joint) -> (Quat, Quat) {
        let Frame { left, right } = self.frame(joint);
        (Quat::from_array(left), Quat::from_array(right))
    }

    /// The rotations around a joint's own one.
    pub(crate) fn frame(&self, joint: Joint) -> Frame {
        let at = FRAME_BYTES * joint.index();
        let component = |at| f32::from(i16_at(self.fixed, at)) * FRAME_STEP;
        let vector = |at| [component(at), component(at + 2), component(at + 4)];
        let basis = quaternion(vector(at + FRAME_BYTES / 2));
        let [x, y, z, w] = basis;
        Frame {
            left: product(quaternion(vector(at)), basis),
            right: [-x, -y, -z, w],
        }
    }

    /// The step of a channel's numbers, radians or metres, in a clip of this scale.
    #[must_use]
    pub fn step(&self, channel: usize, scale: u8) -> f32 {
        let offset = self.fixed.get(STEPS_AT + channel).copied().unwrap_or(0);
        step_size(scale.saturating_add(offset))
    }

    /// The step of a take's heading, radians: the finest of the pelvis's rotation, which it
    /// is a part of.
    #[must_use]
    pub fn heading_step(&self, scale: u8) -> f32 {
        let pelvis = 3 * Joint::Pelvis.index();
        (pelvis..pelvis + 3).fold(f32::MAX, |finest, channel| {
            finest.min(self.step(channel, scale))
        })
    }

    /// The Rice parameters of all channels, from the first.
    pub(crate) const fn parameters(&self) -> BitReader<'a> {
        BitReader::new(self.parameters)
    }

    /// Bytes that the codebook takes in its pack.
    #[must_use]
    pub const fn len_bytes(&self) -> usize {
        self.fixed.len() + self.parameters.len()
    }
}

/// The Rice parameters of one channel, read as they are needed.
pub(crate) struct Parameters {
    /// Most groups that a clip has in this channel.
    pub groups: u32,
    /// Usual number of groups.
    pub usual_groups: i32,
    /// Rice parameter of the difference to it.
    pub groups_rice: u32,
    read: u32,
    last: u32,
}

impl Parameters {
    /// The channel's head; `None` where it has more groups than there are harmonics.
    pub(crate) fn read(bits: &mut BitReader<'_>) -> Option<Self> {
        let groups = bits.unsigned(GROUPS_BITS);
        let (usual_groups, groups_rice) = if groups == 0 {
            (0, 0)
        } else {
            let usual = bits.unsigned(GROUPS_BITS);
            (usual.cast_signed(), bits.unsigned(GROUPS_RICE_BITS))
        };
        (groups as usize <= MAX_GROUPS).then_some(Self {
            groups,
            usual_groups,
            groups_rice,
            read: 0,
            last: 0,
        })
    }

    /// The next group's Rice parameter: the constant's and the first harmonic's as they
    /// are, the others' as differences to the one before.
    pub(crate) fn next(&mut self, bits: &mut BitReader<'_>) -> Option<u32> {
        if self.read == self.groups {
            return None;
        }
        self.last = if self.read < 2 {
            bits.unsigned(RICE_BITS)
        } else {
            self.last.wrapping_sub(bits.rice(0).cast_unsigned())
        };
        self.read += 1;
        Some(self.last)
    }
}

/// A mean walk that clips state their differences from, read in place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Template<'a> {
    /// Scale of its steps.
    pub scale: u8,
    /// Its numbers.
    pub bits: BitReader<'a>,
}

impl<'a> Template<'a> {
    /// The template of these bytes, unchecked but for their length.
    fn new(bytes: &'a [u8]) -> Option<Self> {
        Some(Self {
            scale: *bytes.first()?,
            bits: BitReader::new(bytes.get(TEMPLATE_HEADER_BYTES..)?),
        })
    }

    /// Checks every field of `bytes`.
    fn parse(bytes: &'a [u8], codebook: &Codebook<'_>) -> Result<Self, FormatError> {
        let Some(template) = Self::new(bytes) else {
            return Err(FormatError::new(bytes.len(), "a template's scale"));
        };
        let (mut bits, mut parameters) = (template.bits, codebook.parameters());
        for _ in 0..CHANNELS {
            let whole = Parameters::read(&mut parameters).and_then(|mut channel| {
                let numbers = TemplateChannel::read(&mut bits, &channel)?;
                let mut group = 0;
                while let Some(parameter) = channel.next(&mut parameters) {
                    numbers.group(&mut bits, group, parameter);
                    group += 1;
                }
                Some(())
            });
            if whole.is_none() {
                return Err(FormatError::new(
                    TEMPLATE_HEADER_BYTES + bits.position() / 8,
                    "no more groups than the codebook has for the channel",
                ));
            }
        }
        bits.check_end()
            .map_err(|error| error.behind(TEMPLATE_HEADER_BYTES))?;
        Ok(template)
    }
}

/// One channel of a template.
#[derive(Clone, Copy, Default)]
pub(crate) struct TemplateChannel {
    /// Groups that it has.
    pub groups: u32,
    /// How much larger its Rice parameters are than those of differences.
    larger: u32,
}

impl TemplateChannel {
    /// The channel's head; `None` where it has more groups than the codebook.
    pub(crate) fn read(bits: &mut BitReader<'_>, channel: &Parameters) -> Option<Self> {
        if channel.groups == 0 {
            return Some(Self::default());
        }
        let groups = bits.unsigned(GROUPS_BITS);
        let larger = bits.unsigned(RICE_BITS);
        (groups <= channel.groups).then_some(Self { groups, larger })
    }

    /// The numbers of a group: the constant's first is its only one.
    pub(crate) fn group(&self, bits: &mut BitReader<'_>, group: u32, parameter: u32) -> [i32; 2] {
        if group >= self.groups {
            return [0, 0];
        }
        group_numbers(bits, group, (parameter + self.larger).min(MAX_RICE))
    }
}

/// The numbers of a group that is there: a constant alone, or a cosine and a sine.
pub(crate) fn group_numbers(bits: &mut BitReader<'_>, group: u32, parameter: u32) -> [i32; 2] {
    let first = bits.rice(parameter);
    if group == 0 {
        return [first, 0];
    }
    [first, bits.rice(parameter)]
}
