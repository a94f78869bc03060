//! Text in pictures of pixels.

use crate::error::{ReportError, Result};
use ab_glyph::{Font, FontRef, ScaleFont};

/// Height of the letters, pixels.
const TEXT: f32 = 12.0;

/// Calls `paint` for each pixel that a line of text covers, with the share of it that is covered,
/// 0..=1. The text begins at this upper left corner, and the line is 18 pixels high.
pub(super) fn letters(
    (x, y): (u32, u32),
    text: &str,
    mut paint: impl FnMut((u32, u32), f32),
) -> Result<()> {
    let font = FontRef::try_from_slice(epaint_default_fonts::HACK_REGULAR)
        .map_err(|error| ReportError::Font(error.into()))?;
    // Half of the letters' height above the base line.
    let base = (y + 4) as f32 + TEXT / 2.0;
    let mut pen = x as f32;
    for letter in text.chars() {
        let id = font.glyph_id(letter);
        if let Some(outline) = font.outline_glyph(id.with_scale(TEXT)) {
            let (left, top) = (pen as u32, (base + outline.px_bounds().min.y) as u32);
            outline.draw(|x, y, covered| paint((left + x, top + y), covered));
        }
        pen += font.as_scaled(TEXT).h_advance(id);
    }
    Ok(())
}
