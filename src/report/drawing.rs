//! What drawn pictures share: one font, and colours that everybody can tell apart.

use crate::error::{Error, ReportError};
use plotters::style::{FontStyle, RGBColor};
use std::sync::Once;

/// The only font: a monospaced one lines lists up. SVG viewers take their own.
pub(crate) const FONT: &str = "monospace";

/// Okabe and Ito's colours (2008), safe for the colour-blind.
pub(crate) const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// Makes the font known, from this program alone: what the system has does not matter.
pub(crate) fn register_font() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let font = epaint_default_fonts::HACK_REGULAR;
        let known = plotters::style::register_font(FONT, FontStyle::Normal, font);
        debug_assert!(known.is_ok(), "the font is a font");
    });
}

/// Why something could not be drawn.
pub(crate) fn failed(error: impl std::fmt::Display) -> Error {
    ReportError::Plot(error.to_string()).into()
}
