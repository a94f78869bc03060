//! Cells of tables: shortened text, and coloured rates.

use super::heatmap::{colour, ink};
use super::percent;
use crate::error::visible_name;
use crate::evaluate::results::RecognizerResult;
use maud::{Markup, html};

/// Shortens text to at most `width` characters, with a mark where it was cut. Hidden
/// characters become escapes.
pub(super) fn shortened(text: &str, width: usize) -> String {
    let mut clean = visible_name(text).into_owned();
    if let Some((cut, _)) = clean.char_indices().nth(width) {
        let last = clean[..cut].char_indices().last().map_or(0, |(at, _)| at);
        clean.truncate(last);
        clean.push('~');
    }
    clean
}

/// Returns a table cell in the colour of its rate.
pub(super) fn rate_cell(rank1: Option<f64>) -> Markup {
    html! {
        @match rank1 {
            Some(rank1) => td style=(format!("background:{};color:{}", colour(rank1), ink(rank1))) {
                (percent(rank1))
            },
            None => td { "–" },
        }
    }
}

/// Returns the chance level.
pub(super) fn chance(result: &RecognizerResult) -> f64 {
    1.0 / result.classes.max(1) as f64
}
