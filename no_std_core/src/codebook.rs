//! The codebook: numbers that all clips of a pack share, stored once to keep clips small.
//!
//! A joint's rotation is `reference * basis * v * basis^-1`: a usual pose, then a small rotation
//! `v` about the axes in which this joint mainly moves. The steps of a channel's numbers suit how
//! far the joint moves whatever hangs on it, and the parameters of its Rice codes suit the pack's
//! own walks. A template is a mean walk, from which clips store their differences.

use crate::bits::BitReader;
use crate::entry_table::EntryTable;
use crate::format::{
    CHANNELS, CODEBOOK_BYTES, DIRECT_CODES, FRAME_BYTES, FRAME_STEP, FormatError, GROUPS_BITS,
    GROUPS_RICE_BITS, JOINT_ERRORS_AT, MAX_GROUPS, MAX_RICE, RICE_BITS, STEPS_AT,
    TEMPLATE_HEADER_BYTES, i16_at, step_size, u16_at,
};
use crate::rotation::{product, quaternion};
use crate::skeleton::Joint;
use glam::{Quat, Vec3};

/// A pack's codebook, read in place.
#[derive(Clone, Copy, Debug)]
pub struct Codebook<'a> {
    fixed: &'a [u8],
    parameters: &'a [u8],
    templates: EntryTable<'a>,
}

/// The two rotations by which a joint's own rotation is multiplied.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointFrame {
    /// The reference times the basis.
    pub left: [f32; 4],
    /// The basis's inverse.
    pub right: [f32; 4],
}

impl JointFrame {
    /// Returns the joint's rotation for a vector in its basis.
    #[inline]
    pub(crate) fn turn(&self, vector: [f32; 3]) -> [f32; 4] {
        product(product(self.left, quaternion(vector)), self.right)
    }
}

impl<'a> Codebook<'a> {
    /// Checks every field of `bytes`; reading cannot fail afterwards.
    ///
    /// # Errors
    /// If the bytes are not exactly one codebook.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let (Some(fixed), Some(parameters)) =
            (bytes.get(..CODEBOOK_BYTES), bytes.get(CODEBOOK_BYTES..))
        else {
            return Err(FormatError::new(bytes.len(), "the rest of the codebook"));
        };
        let codebook = Self {
            fixed,
            parameters,
            templates: EntryTable::EMPTY,
        };
        let mut bits = BitReader::new(parameters);
        let error = |bits: &BitReader<'_>, expected| {
            FormatError::new(CODEBOOK_BYTES + bits.position() / 8, expected)
        };
        for _ in 0..CHANNELS {
            let Some(channel) = ChannelParameters::read(&mut bits) else {
                return Err(error(&bits, "at most 32 groups in a channel"));
            };
            let mut last = 0;
            for group in 0..usize::from(channel.groups) {
                last = next_code(&mut bits, group, last);
                if last > MAX_RICE {
                    return Err(error(&bits, "Rice parameters of 0 to 15"));
                }
            }
        }
        bits.check_end()
            .map_err(|error| error.behind(CODEBOOK_BYTES))?;
        Ok(codebook)
    }

    /// Adds the mean walks of section `TMPL`.
    ///
    /// # Errors
    /// If the bytes are not a table of at most 255 mean walks.
    pub fn with_templates(self, section: &'a [u8]) -> Result<Self, FormatError> {
        self.with_checked(section, &CodeTable::from_codebook(&self))
    }

    /// Adds the templates of a section, checked with codes that were read from the codebook.
    pub(crate) fn with_checked(
        mut self,
        section: &'a [u8],
        codes: &CodeTable,
    ) -> Result<Self, FormatError> {
        self.templates = EntryTable::parse(section)?;
        if self.templates.len() > usize::from(u8::MAX) {
            return Err(FormatError::new(0, "at most 255 templates"));
        }
        for (at, entry) in self.templates.entries() {
            MeanWalk::check(entry, codes).map_err(|e| e.behind(at))?;
        }
        Ok(self)
    }

    /// Adds the templates of a section that was checked before.
    pub(crate) fn over(mut self, section: &'a [u8]) -> Result<Self, FormatError> {
        self.templates = EntryTable::parse(section)?;
        Ok(self)
    }

    /// Returns the number of mean walks.
    #[must_use]
    pub fn template_count(&self) -> usize {
        self.templates.len()
    }

    /// Returns the template that a clip names: 0 is none.
    pub(crate) fn template(&self, number: u8) -> Option<MeanWalk<'a>> {
        let index = usize::from(number).checked_sub(1)?;
        // Cannot fail for an entry: `with_templates` has checked all of them.
        MeanWalk::new(self.templates.entry(index)?.1)
    }

    /// Returns the greatest and the mean error of one joint over all clips of the pack, mm, as the
    /// encoder measured them at virtual points 3 cm off the joint, in the walker's space.
    #[must_use]
    pub fn joint_error_mm(&self, joint: Joint) -> (f32, f32) {
        let at = JOINT_ERRORS_AT + 4 * joint.index();
        let millimetres = |at| f32::from(u16_at(self.fixed, at)) * 0.01;
        (millimetres(at), millimetres(at + 2))
    }

    /// Returns the rotation of a joint for a vector of [`crate::rotation`] in its basis.
    #[must_use]
    pub fn rotation(&self, joint: Joint, vector: Vec3) -> Quat {
        Quat::from_array(self.frame(joint).turn(vector.to_array()))
    }

    /// Returns the two factors around a joint's own rotation: the joint's rotation is the first
    /// times [`crate::rotation::rotation`] of its vector times the second.
    #[must_use]
    pub fn frame_rotations(&self, joint: Joint) -> (Quat, Quat) {
        let JointFrame { left, right } = self.frame(joint);
        (Quat::from_array(left), Quat::from_array(right))
    }

    /// Returns the two factors around a joint's own rotation.
    pub(crate) fn frame(&self, joint: Joint) -> JointFrame {
        let at = FRAME_BYTES * joint.index();
        let component = |at| f32::from(i16_at(self.fixed, at)) * FRAME_STEP;
        let vector = |at| [component(at), component(at + 2), component(at + 4)];
        let basis = quaternion(vector(at + FRAME_BYTES / 2));
        let [x, y, z, w] = basis;
        JointFrame {
            left: product(quaternion(vector(at)), basis),
            right: [-x, -y, -z, w],
        }
    }

    /// Returns the step of a channel's numbers, radians or metres, in a clip of this scale.
    #[must_use]
    pub fn step(&self, channel: usize, scale: u8) -> f32 {
        let offset = self.fixed.get(STEPS_AT + channel).copied().unwrap_or(0);
        step_size(scale.saturating_add(offset))
    }

    /// Returns the step of an uncut clip's heading, radians: the finest step of the pelvis's
    /// rotation, of which the heading is a part.
    #[must_use]
    pub fn heading_step(&self, scale: u8) -> f32 {
        let pelvis = 3 * Joint::Pelvis.index();
        (pelvis..pelvis + 3).fold(f32::MAX, |finest, channel| {
            finest.min(self.step(channel, scale))
        })
    }

    /// Returns a reader of the Rice parameters of all channels.
    pub(crate) const fn parameters(&self) -> BitReader<'a> {
        BitReader::new(self.parameters)
    }

    /// Returns the size of the codebook in its pack, bytes, without mean walks.
    #[must_use]
    pub const fn len_bytes(&self) -> usize {
        self.fixed.len() + self.parameters.len()
    }
}

/// The codebook's parameters of one channel.
#[derive(Clone, Copy)]
pub(crate) struct ChannelParameters {
    /// The maximum number of groups that a clip has in this channel.
    pub groups: u8,
    usual_groups: u8,
    /// The Rice parameter of the difference from `usual_groups`.
    groups_rice: u8,
}

/// The Rice parameter of each group of one channel.
pub(crate) type Codes = [u8; MAX_GROUPS];

impl ChannelParameters {
    /// A channel without groups.
    pub(crate) const NONE: Self = Self {
        groups: 0,
        usual_groups: 0,
        groups_rice: 0,
    };

    /// Reads the channel's head, which its codes follow; `None` if it has more groups than there
    /// are harmonics.
    pub(crate) fn read(bits: &mut BitReader<'_>) -> Option<Self> {
        let groups = bits.unsigned(GROUPS_BITS);
        if groups == 0 {
            return Some(Self::NONE);
        }
        let usual = bits.unsigned(GROUPS_BITS + GROUPS_RICE_BITS);
        let [groups, usual, ..] = [groups, usual].map(|field| field.to_le_bytes()[0]);
        (usize::from(groups) <= MAX_GROUPS).then_some(Self {
            groups,
            usual_groups: usual & ((1 << GROUPS_BITS) - 1),
            groups_rice: usual >> GROUPS_BITS,
        })
    }

    /// Reads the channel's codes, which a checked codebook has, into the start of `codes`.
    #[inline]
    pub(crate) fn read_codes<'c>(
        &self,
        bits: &mut BitReader<'_>,
        codes: &'c mut Codes,
    ) -> &'c [u8] {
        let codes = codes
            .get_mut(..usize::from(self.groups))
            .unwrap_or_default();
        bits.codes(codes);
        codes
    }

    /// Reads how many groups a clip has in this channel; `None` if there are more than the codebook
    /// has.
    #[inline(always)]
    pub(crate) fn read_groups(&self, numbers: &mut BitReader<'_>) -> Option<usize> {
        if self.groups == 0 {
            return Some(0);
        }
        let difference = numbers.rice(u32::from(self.groups_rice));
        let groups = i32::from(self.usual_groups) + difference;
        let groups = usize::try_from(groups).ok()?;
        (groups <= usize::from(self.groups)).then_some(groups)
    }
}

/// Reads the Rice parameter of a channel's next group; `last` is the previous one's.
#[inline]
fn next_code(bits: &mut BitReader<'_>, group: usize, last: u32) -> u32 {
    if group < DIRECT_CODES {
        bits.unsigned(RICE_BITS)
    } else {
        last.wrapping_sub(bits.rice(0).cast_unsigned())
    }
}

/// The codebook's parameters of all channels, read once to check many clips. 2 kB.
pub(crate) struct CodeTable {
    channels: [ChannelParameters; CHANNELS],
    /// The Rice parameters of all channels, one channel after another.
    codes: heapless::Vec<u8, { CHANNELS * MAX_GROUPS }>,
}

impl CodeTable {
    #[inline]
    pub(crate) fn from_codebook(codebook: &Codebook<'_>) -> Self {
        let mut table = Self {
            channels: [ChannelParameters::NONE; CHANNELS],
            codes: heapless::Vec::new(),
        };
        table.read(BitReader::new(codebook.parameters));
        table
    }

    /// Reads the channels. Separate from [`Self::from_codebook`], so that a board needs no copy of the table.
    #[inline(never)]
    fn read(&mut self, mut bits: BitReader<'_>) {
        let mut codes = [0; MAX_GROUPS];
        for channel in &mut self.channels {
            // A codebook's channels have been checked.
            *channel = ChannelParameters::read(&mut bits).unwrap_or(ChannelParameters::NONE);
            let codes = channel.read_codes(&mut bits, &mut codes);
            // At most as many as there are channels times groups, which the capacity allows.
            let _ = self.codes.extend_from_slice(codes);
        }
    }

    /// Returns the channels in order, each with its codes.
    pub(crate) fn channels(&self) -> impl Iterator<Item = (&ChannelParameters, &[u8])> {
        let mut rest = self.codes.as_slice();
        self.channels.iter().map(move |channel| {
            let (codes, behind) = rest
                .split_at_checked(usize::from(channel.groups))
                .unwrap_or_default();
            rest = behind;
            (channel, codes)
        })
    }
}

/// A mean walk from which clips store their differences, read in place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeanWalk<'a> {
    /// The scale of its steps.
    pub scale: u8,
    /// A reader of its numbers.
    pub bits: BitReader<'a>,
}

impl<'a> MeanWalk<'a> {
    /// Returns the template of these bytes, checking only their length.
    fn new(bytes: &'a [u8]) -> Option<Self> {
        Some(Self {
            scale: *bytes.first()?,
            bits: BitReader::new(bytes.get(TEMPLATE_HEADER_BYTES..)?),
        })
    }

    /// Checks every field of `bytes`.
    fn check(bytes: &'a [u8], codes: &CodeTable) -> Result<(), FormatError> {
        let Some(Self { mut bits, .. }) = Self::new(bytes) else {
            return Err(FormatError::new(bytes.len(), "a template's scale"));
        };
        for (channel, codes) in codes.channels() {
            let Some(numbers) = TemplateChannel::read(&mut bits, channel) else {
                return Err(FormatError::new(
                    TEMPLATE_HEADER_BYTES + bits.position() / 8,
                    "no more groups than the codebook has for the channel",
                ));
            };
            for (group, &code) in codes.iter().take(numbers.groups).enumerate() {
                skip_group(&mut bits, group, numbers.code(code));
            }
        }
        bits.check_end()
            .map_err(|error| error.behind(TEMPLATE_HEADER_BYTES))
    }
}

/// One channel of a template.
#[derive(Clone, Copy, Default)]
pub(crate) struct TemplateChannel {
    /// The number of its groups.
    pub groups: usize,
    /// The excess of its Rice parameters over those of clips' differences.
    larger: u32,
}

impl TemplateChannel {
    /// Reads the channel's head; `None` if it has more groups than the codebook.
    #[inline]
    pub(crate) fn read(bits: &mut BitReader<'_>, channel: &ChannelParameters) -> Option<Self> {
        if channel.groups == 0 {
            return Some(Self::default());
        }
        let head = bits.unsigned(GROUPS_BITS + RICE_BITS);
        let groups = head & ((1 << GROUPS_BITS) - 1);
        (groups <= u32::from(channel.groups)).then_some(Self {
            groups: groups as usize,
            larger: head >> GROUPS_BITS,
        })
    }

    /// Returns the Rice parameter of a group in which clips' differences have the parameter `code`.
    #[inline]
    pub(crate) fn code(&self, code: u8) -> u32 {
        (u32::from(code) + self.larger).min(MAX_RICE)
    }
}

/// The numbers of a channel's groups: for the constant a number and 0, then for each harmonic those
/// of the cosine and the sine.
pub(crate) type ChannelNumbers = [[i32; 2]; MAX_GROUPS];

/// Reads the numbers of one group for each of `codes`.
#[inline]
pub(crate) fn read_numbers<'n>(
    bits: &mut BitReader<'_>,
    mut codes: impl ExactSizeIterator<Item = u32>,
    numbers: &'n mut ChannelNumbers,
) -> &'n [[i32; 2]] {
    let len = codes.len();
    let [constant, harmonics @ ..] = numbers;
    // A copy is kept in registers.
    let mut here = *bits;
    if let Some(code) = codes.next() {
        *constant = [here.rice(code), 0];
    }
    for (code, numbers) in codes.zip(harmonics) {
        *numbers = here.rice_pair(code);
    }
    *bits = here;
    numbers.get(..len).unwrap_or_default()
}

/// Skips the numbers of a group.
#[inline]
pub(crate) fn skip_group(bits: &mut BitReader<'_>, group: usize, code: u32) {
    bits.skip_rice(code);
    if group > 0 {
        bits.skip_rice(code);
    }
}
