//! Cells of tables: shortened text, and rates in their colour.

use super::heatmap::{colour, ink};
use super::percent;
use crate::evaluate::results::RecognizerResult;
use maud::{Markup, html};

/// Text of at most `width` characters, its end marked if it was cut. Characters that
/// a terminal would obey become `?`.
pub(super) fn shortened(text: &str, width: usize) -> String {
    let mut clean: String = text
        .chars()
        .map(|c| if c.is_control() { '?' } else { c })
        .collect();
    if let Some((cut, _)) = clean.char_indices().nth(width) {
        let last = clean[..cut].char_indices().last().map_or(0, |(at, _)| at);
        clean.truncate(last);
        clean.push('~');
    }
    clean
}

/// A table's cell in the colour of its rate.
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

/// The rate of guessing.
pub(super) fn chance(result: &RecognizerResult) -> f64 {
    1.0 / result.classes.max(1) as f64
}
