//! A body: joint offsets and low-poly convex hulls, read in place.

#[cfg(test)]
mod tests;

use crate::bits::BitReader;
use crate::budget::{MAX_DRAPED_HULLS, MAX_HULL_POINTS, MAX_HULLS, MAX_POINTS};
use crate::clothes::Clothes;
use crate::format::{
    AVATAR_HEADER_BYTES, CLOTHES_BITS, DRESSED, FITTED, FITTED_BYTES, FormatError, HULL_COUNT_MASK,
    JOINT_BITS, MAX_OFFSET_WIDTH, OFFSET_STEP_M, OFFSET_WIDTH_BITS, SYMMETRIC_SKELETON, u16_at,
};
pub use crate::hull::Hull;
use crate::hull::mirrored;
use crate::skeleton::{JOINTS, Joint, Skeleton};
use glam::Vec3;

/// A body in a pack's bytes: where its joints are, and its hulls.
#[derive(Clone, Copy, Debug)]
pub struct Avatar<'a> {
    bytes: &'a [u8],
}

impl<'a> Avatar<'a> {
    /// Checks every hull of `bytes`; reading cannot fail afterwards.
    ///
    /// # Errors
    /// If the bytes are not exactly one avatar within the budget.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, FormatError> {
        if bytes.len() < AVATAR_HEADER_BYTES {
            return Err(FormatError::new(bytes.len(), "an avatar header of 5 bytes"));
        }
        let avatar = Self::over(bytes);
        if avatar.step_um() == 0 {
            return Err(FormatError::new(2, "a step above 0 micrometres"));
        }
        if avatar.header_bytes() > bytes.len() {
            return Err(FormatError::new(bytes.len(), "a Jaccard index of 2 bytes"));
        }
        if avatar.jaccard().is_some_and(|jaccard| jaccard > 1.0) {
            return Err(FormatError::new(
                AVATAR_HEADER_BYTES,
                "a Jaccard index of at most 10,000",
            ));
        }
        let behind_offsets = avatar.check_offsets()?;
        let used = avatar.check_hulls(behind_offsets)?;
        if used.div_ceil(8) != avatar.stream().len() {
            return Err(FormatError::new(
                avatar.header_bytes() + used.div_ceil(8),
                "the end of the avatar after its last hull",
            ));
        }
        if let (Some(last), rest @ 1..) = (bytes.last(), used % 8)
            && last >> rest != 0
        {
            return Err(FormatError::new(
                bytes.len() - 1,
                "zeros after an avatar's last hull",
            ));
        }
        Ok(avatar)
    }

    /// Returns the avatar of bytes that [`Self::parse`] has checked, without looking at them.
    pub(crate) const fn over(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    /// Checks the joint offsets and clothes, and returns a reader at the first hull.
    fn check_offsets(&self) -> Result<BitReader<'a>, FormatError> {
        let width = BitReader::new(self.stream()).unsigned(OFFSET_WIDTH_BITS);
        if width > MAX_OFFSET_WIDTH {
            return Err(FormatError::new(
                self.header_bytes(),
                "joint offsets of at most 16 bits",
            ));
        }
        let mut bits = self.bits_behind_offsets();
        if bits.is_overrun() {
            return Err(FormatError::new(
                self.bytes.len(),
                "the rest of the joint offsets",
            ));
        }
        let at = self.header_bytes() + bits.position() / 8;
        if read_clothes(&mut bits).is_some_and(|bits| Clothes::of_bits(bits).is_none()) {
            return Err(FormatError::new(at, "a fit and legs of 0 to 2"));
        }
        Ok(bits)
    }

    /// Checks the hulls except their points, and returns the number of bits in the whole stream.
    fn check_hulls(&self, bits: BitReader<'a>) -> Result<usize, FormatError> {
        let mut stored = self.stored(bits);
        let (mut hulls, mut points) = (0, 0);
        // Points of each draped hull.
        let mut spanned = [0; MAX_DRAPED_HULLS];
        loop {
            let at = self.header_bytes() + stored.bits.position() / 8;
            let Some(hull) = stored.next() else {
                break;
            };
            // Checked first: past the end the reader returns zeros, which would give a misleading
            // error.
            if stored.bits.is_overrun() {
                return Err(FormatError::new(self.bytes.len(), "the rest of a hull"));
            }
            let hull = hull.map_err(|error| error.behind(self.header_bytes()))?;
            let copies = 1 + usize::from(hull.image().is_some());
            hulls += copies;
            points += copies * hull.len();
            if let Some(drape) = hull.drape() {
                let budget = "at most 4 draped hulls of 32 points each";
                let spanned = spanned.get_mut(drape);
                let spanned = spanned.ok_or_else(|| FormatError::new(at, budget))?;
                *spanned += copies * hull.len();
                if *spanned > MAX_HULL_POINTS {
                    return Err(FormatError::new(at, budget));
                }
            }
            if hulls > MAX_HULLS || points > MAX_POINTS {
                return Err(FormatError::new(
                    at,
                    "at most 32 hulls of 768 points in all",
                ));
            }
        }
        if stored.parts > 0 {
            return Err(FormatError::new(
                4,
                "as many hulls as a draped hull has parts",
            ));
        }
        Ok(stored.bits.position())
    }

    /// Returns the joint offsets.
    #[must_use]
    pub fn skeleton(&self) -> Skeleton {
        let mut bits = BitReader::new(self.stream());
        let width = bits.unsigned(OFFSET_WIDTH_BITS).min(MAX_OFFSET_WIDTH);
        let mut coordinate = || {
            let is_stored = bits.unsigned(1) == 1;
            #[expect(clippy::cast_precision_loss, reason = "at most 16 bits")]
            let steps = bits.signed(if is_stored { width } else { 0 }) as f32;
            steps * OFFSET_STEP_M
        };
        let mut offsets = [Vec3::ZERO; JOINTS];
        for joint in Joint::ALL.into_iter().skip(1) {
            let offset = match self.coordinates(joint) {
                3 => Vec3::new(coordinate(), coordinate(), coordinate()),
                2 => Vec3::new(0.0, coordinate(), coordinate()),
                _ => {
                    let other = offsets.get(joint.mirrored().index());
                    mirrored(other.copied().unwrap_or_default())
                }
            };
            if let Some(place) = offsets.get_mut(joint.index()) {
                *place = offset;
            }
        }
        Skeleton { offsets }
    }

    /// Returns how many coordinates of a joint's offset are stored. A symmetric skeleton stores
    /// neither the right side nor the x of joints in the middle.
    fn coordinates(&self, joint: Joint) -> usize {
        let other = joint.mirrored();
        match self.flags() & SYMMETRIC_SKELETON {
            0 => 3,
            _ if other < joint => 0,
            _ if other == joint => 2,
            _ => 3,
        }
    }

    /// Returns the hulls, and the parts of draped ones, in file order, each mirrored one followed
    /// by its image. The parts of a draped hull are adjacent ([`Hull::drape`]).
    pub fn hulls(&self) -> impl Iterator<Item = Hull<'a>> + use<'a> {
        self.stored(self.hull_bits())
            .filter_map(Result::ok)
            .flat_map(|hull| [Some(hull), hull.image()].into_iter().flatten())
    }

    /// Returns the clothes that the hulls of a dressed avatar include; `None` for a plain body.
    #[must_use]
    pub fn clothes(&self) -> Option<Clothes> {
        read_clothes(&mut self.bits_behind_offsets()).and_then(Clothes::of_bits)
    }

    /// Returns the number of hulls that are drawn. All parts of a draped hull count as one.
    #[must_use]
    pub fn drawn_hulls(&self) -> usize {
        let rigid = self.hulls().filter(|hull| hull.drape().is_none()).count();
        let draped = self.hulls().filter_map(|hull| hull.drape()).max();
        rigid + draped.map_or(0, |last| last + 1)
    }

    fn stored(&self, bits: BitReader<'a>) -> StoredHulls<'a> {
        StoredHulls {
            bits,
            step_um: self.step_um(),
            left: self.stored_hulls(),
            drapes: 0,
            parts: 0,
        }
    }

    /// Returns the greatest distance that the encoder measured between a hull's points and its
    /// input, mm, rounded up to 0.01 mm.
    #[must_use]
    pub fn max_error_mm(&self) -> f32 {
        f32::from(u16_at(self.bytes, 0)) * 0.01
    }

    /// Returns how well hulls that were fitted to a mesh match it: the mean Jaccard index of their
    /// silhouettes and the mesh's, in poses and from viewpoints held out from the fit. `None` for a
    /// body that was not fitted to a mesh.
    #[must_use]
    pub fn jaccard(&self) -> Option<f32> {
        let is_fitted = self.flags() & FITTED != 0;
        is_fitted.then(|| f32::from(u16_at(self.bytes, AVATAR_HEADER_BYTES)) * 1e-4)
    }

    /// Returns the size of the avatar in its pack, bytes.
    #[must_use]
    pub fn len_bytes(&self) -> usize {
        self.bytes.len()
    }

    /// Returns the quantisation step, micrometres.
    fn step_um(&self) -> u16 {
        u16_at(self.bytes, 2)
    }

    /// Returns the number of hulls, not counting mirror images.
    fn stored_hulls(&self) -> u8 {
        self.flags() & HULL_COUNT_MASK
    }

    fn flags(&self) -> u8 {
        self.bytes.get(4).copied().unwrap_or_default()
    }

    /// Returns a reader at the first hull.
    fn hull_bits(&self) -> BitReader<'a> {
        let mut bits = self.bits_behind_offsets();
        read_clothes(&mut bits);
        bits
    }

    fn bits_behind_offsets(&self) -> BitReader<'a> {
        let mut bits = BitReader::new(self.stream());
        let width = bits.unsigned(OFFSET_WIDTH_BITS).min(MAX_OFFSET_WIDTH) as usize;
        let joints = Joint::ALL.into_iter().skip(1);
        for _ in 0..joints.map(|joint| self.coordinates(joint)).sum() {
            let is_stored = bits.unsigned(1) == 1;
            bits.skip(if is_stored { width } else { 0 });
        }
        bits
    }

    fn header_bytes(&self) -> usize {
        AVATAR_HEADER_BYTES
            + if self.flags() & FITTED == 0 {
                0
            } else {
                FITTED_BYTES
            }
    }

    fn stream(&self) -> &'a [u8] {
        self.bytes.get(self.header_bytes()..).unwrap_or_default()
    }
}

/// Reads the byte of clothes, if there is one, and moves past it.
fn read_clothes(bits: &mut BitReader<'_>) -> Option<u8> {
    if bits.clone().unsigned(JOINT_BITS) != DRESSED {
        return None;
    }
    bits.skip(JOINT_BITS as usize);
    u8::try_from(bits.unsigned(CLOTHES_BITS)).ok()
}

/// An iterator over the hulls as they are stored.
struct StoredHulls<'a> {
    bits: BitReader<'a>,
    step_um: u16,
    /// Hulls still to be read.
    left: u8,
    /// Draped hulls begun so far.
    drapes: u8,
    /// The number of next hulls that are parts of the last draped hull.
    parts: u8,
}

impl<'a> Iterator for StoredHulls<'a> {
    type Item = Result<Hull<'a>, FormatError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.left = self.left.checked_sub(1)?;
        let at = self.bits;
        let hull = match Hull::read(&mut self.bits, self.step_um) {
            Ok(hull) => hull,
            Err(error) => return Some(Err(error)),
        };
        match (hull.parts(), self.parts) {
            (0, 0) => return Some(Ok(hull)),
            (0, _) => {}
            (parts, 0) => {
                self.parts = parts;
                self.drapes += 1;
            }
            _ => {
                let expected = "the other parts of a draped hull first";
                return Some(Err(FormatError::new(at.position() / 8, expected)));
            }
        }
        self.parts -= 1;
        Some(Ok(hull.of_drape(self.drapes)))
    }
}
