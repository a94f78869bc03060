//! The form of a recognizer's input (order of axes, values of pixels), and the distance between its
//! embeddings.
//!
//! Templates of several images have their channels first. One image may be given as several equal
//! channels, in the layout's order.

use crate::draw::template::{Template, TemplateShape};
use serde::{Deserialize, Serialize};

/// The values of background and foreground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum InputRange {
    /// Background 0, pixels that are always foreground 1.
    #[default]
    #[serde(rename = "0..1")]
    Unit,
    /// Background 0, pixels that are always foreground 255.
    #[serde(rename = "0..255")]
    Byte,
    /// Background -1, pixels that are always foreground 1.
    #[serde(rename = "-1..1")]
    Signed,
}

impl InputRange {
    /// Converts a pixel's byte to this range.
    #[must_use]
    pub fn of_byte(self, byte: u8) -> f32 {
        match self {
            Self::Unit => f32::from(byte) / 255.0,
            Self::Byte => f32::from(byte),
            Self::Signed => f32::from(byte) / 127.5 - 1.0,
        }
    }

    /// Returns the name used in contracts.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unit => "0..1",
            Self::Byte => "0..255",
            Self::Signed => "-1..1",
        }
    }
}

/// The order of the input's axes: N inputs, T frames, C channels (1, except for templates of
/// several images and repeated images), H rows, W columns, D numbers of a vector or an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum InputLayout {
    /// Images: batch, channel, row, column.
    #[default]
    Nchw,
    /// Single images: batch, row, column, channel.
    Nhwc,
    /// Single images: batch, row, column.
    Nhw,
    /// Silhouettes: batch, frame, row, column.
    Nthw,
    /// Silhouettes: batch, frame, channel, row, column.
    Ntchw,
    /// Silhouettes: batch, channel, frame, row, column.
    Ncthw,
    /// Vectors, and single images row by row: batch, number.
    #[serde(alias = "NC")]
    Nd,
}

/// An axis of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum InputAxis {
    Batch,
    Frame,
    Channel,
    Row,
    Column,
    /// All numbers of a template.
    Number,
}

impl InputLayout {
    /// All layouts.
    pub const ALL: [Self; 7] = [
        Self::Nchw,
        Self::Nhwc,
        Self::Nhw,
        Self::Nthw,
        Self::Ntchw,
        Self::Ncthw,
        Self::Nd,
    ];

    /// Returns the name used in contracts.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nchw => "NCHW",
            Self::Nhwc => "NHWC",
            Self::Nhw => "NHW",
            Self::Nthw => "NTHW",
            Self::Ntchw => "NTCHW",
            Self::Ncthw => "NCTHW",
            Self::Nd => "ND",
        }
    }

    /// Returns whether this layout can hold a template.
    #[must_use]
    pub fn holds(self, template: Template) -> bool {
        let is_sequence = template == Template::Silhouettes;
        match (self, template.shape_of(1, 1)) {
            (Self::Nd, TemplateShape::Vector(_)) => true,
            (_, TemplateShape::Vector(_)) => false,
            (Self::Nd, shape) => !is_sequence && shape.numbers() == 1,
            (Self::Nthw | Self::Ntchw | Self::Ncthw, _) => is_sequence,
            (Self::Nchw, _) => !is_sequence,
            (Self::Nhwc | Self::Nhw, shape) => !is_sequence && shape.numbers() == 1,
        }
    }

    /// Returns the default layout of a template: the first that can hold it.
    #[must_use]
    pub fn for_template(template: Template) -> Self {
        let first = Self::ALL.into_iter().find(|layout| layout.holds(template));
        first.unwrap_or_default()
    }

    /// Returns whether it has an axis of channels.
    #[must_use]
    pub fn has_channels(self) -> bool {
        self.axes().contains(&InputAxis::Channel)
    }

    pub(super) const fn axes(self) -> &'static [InputAxis] {
        use InputAxis::{Batch, Channel, Column, Frame, Number, Row};
        match self {
            Self::Nchw => &[Batch, Channel, Row, Column],
            Self::Nhwc => &[Batch, Row, Column, Channel],
            Self::Nhw => &[Batch, Row, Column],
            Self::Nthw => &[Batch, Frame, Row, Column],
            Self::Ntchw => &[Batch, Frame, Channel, Row, Column],
            Self::Ncthw => &[Batch, Channel, Frame, Row, Column],
            Self::Nd => &[Batch, Number],
        }
    }
}

/// The distance between two embeddings. With parts, it is the mean over the parts, unless stated
/// otherwise below.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Distance {
    /// The length of their difference.
    #[default]
    Euclidean,
    /// One minus the cosine of the angle between them.
    Cosine,
    /// The share of parts that vote for another person. Each part votes for the person who is
    /// nearest by Euclidean distance.
    Votes,
    /// The Euclidean distance in the part of the probe's viewpoint.
    View,
}

impl Distance {
    /// Returns the name used in contracts and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Euclidean => "euclidean",
            Self::Cosine => "cosine",
            Self::Votes => "votes",
            Self::View => "view",
        }
    }

    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_a_layout_spells_its_axes() {
        for layout in InputLayout::ALL {
            let letter = |axis: &InputAxis| match axis {
                InputAxis::Batch => 'N',
                InputAxis::Frame => 'T',
                InputAxis::Channel => 'C',
                InputAxis::Row => 'H',
                InputAxis::Column => 'W',
                InputAxis::Number => 'D',
            };
            let spelt: String = layout.axes().iter().map(letter).collect();
            assert_eq!(layout.name(), spelt);
            let has_frames = spelt.contains('T');
            assert_eq!(layout.holds(Template::Silhouettes), has_frames);
            assert_eq!(layout.holds(Template::Kfd), spelt == "ND");
            assert_eq!(layout.holds(Template::Frequency), spelt == "NCHW");
            let is_of_one_image = ["NCHW", "NHWC", "NHW", "ND"].contains(&spelt.as_str());
            assert_eq!(layout.holds(Template::Mhi), is_of_one_image);
            let stated = serde_json::to_value(layout).expect("a name");
            assert_eq!(stated, layout.name());
        }
    }

    #[test]
    fn contracts_state_names() {
        let json = |value: &dyn Fn() -> serde_json::Result<serde_json::Value>| value().ok();
        for distance in [
            Distance::Euclidean,
            Distance::Cosine,
            Distance::Votes,
            Distance::View,
        ] {
            assert_eq!(
                json(&|| serde_json::to_value(distance)),
                Some(distance.name().into())
            );
        }
    }

    #[test]
    fn white_is_one_or_255() {
        let of = |range: InputRange| [0, 51, 255].map(|byte| range.of_byte(byte));
        assert_eq!(of(InputRange::Unit), [0.0, 0.2, 1.0]);
        assert_eq!(of(InputRange::Byte), [0.0, 51.0, 255.0]);
        assert_eq!(of(InputRange::Signed), [-1.0, -0.6, 1.0]);
    }
}
