//! An avatar's clothes, in a byte.

use core::fmt;

/// The clothes that the hulls of a dressed avatar include, besides shoes, which all dressed people
/// wear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clothes {
    /// The distance of clothes from the body.
    pub fit: ClothesFit,
    /// The garment on the legs.
    pub legs: Legs,
    /// Whether a coat hangs over the rest.
    pub has_coat: bool,
    /// Whether hair reaches below the head.
    pub has_long_hair: bool,
    /// Whether forearms are bare.
    pub has_short_sleeves: bool,
}

/// The distance of clothes from the body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ClothesFit {
    /// A few millimetres.
    Tight,
    /// About a centimetre.
    #[default]
    Normal,
    /// Two centimetres and more.
    Loose,
}

/// The garment on the legs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Legs {
    /// Trousers.
    #[default]
    Trousers,
    /// Trousers that end above the knees.
    Shorts,
    /// A skirt or a dress.
    Skirt,
}

impl Clothes {
    /// Decodes the byte in a pack: bits 0 and 1 are the fit, 2 and 3 the legs, 4 the coat, 5 long
    /// hair, 6 short sleeves; `None` for any other byte.
    #[must_use]
    pub const fn of_bits(bits: u8) -> Option<Self> {
        let fit = match bits & 3 {
            0 => ClothesFit::Tight,
            1 => ClothesFit::Normal,
            2 => ClothesFit::Loose,
            _ => return None,
        };
        let legs = match bits >> 2 & 3 {
            0 => Legs::Trousers,
            1 => Legs::Shorts,
            2 => Legs::Skirt,
            _ => return None,
        };
        if bits >> 7 != 0 {
            return None;
        }
        Some(Self {
            fit,
            legs,
            has_coat: bits >> 4 & 1 == 1,
            has_long_hair: bits >> 5 & 1 == 1,
            has_short_sleeves: bits >> 6 & 1 == 1,
        })
    }

    /// Encodes the clothes as the byte in a pack.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.fit as u8
            | (self.legs as u8) << 2
            | (self.has_coat as u8) << 4
            | (self.has_long_hair as u8) << 5
            | (self.has_short_sleeves as u8) << 6
    }
}

impl fmt::Display for Clothes {
    /// Writes one word, such as `loose+shorts+long-hair`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.fit {
            ClothesFit::Tight => "tight",
            ClothesFit::Normal => "normal",
            ClothesFit::Loose => "loose",
        })?;
        f.write_str(match self.legs {
            Legs::Trousers => "+trousers",
            Legs::Shorts => "+shorts",
            Legs::Skirt => "+skirt",
        })?;
        for (is_worn, name) in [
            (self.has_coat, "+coat"),
            (self.has_short_sleeves, "+short-sleeves"),
            (self.has_long_hair, "+long-hair"),
        ] {
            f.write_str(if is_worn { name } else { "" })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_clothes_and_back_and_others_are_none() {
        let known = (0..=u8::MAX).filter_map(|bits| {
            let clothes = Clothes::of_bits(bits)?;
            assert_eq!(clothes.bits(), bits);
            Some(bits)
        });
        assert_eq!(known.count(), 3 * 3 * 2 * 2 * 2);
        let summer = Clothes::of_bits(0b110_0110).expect("known clothes");
        assert_eq!((summer.fit, summer.legs), (ClothesFit::Loose, Legs::Shorts));
        assert!(!summer.has_coat && summer.has_long_hair && summer.has_short_sleeves);
    }
}
