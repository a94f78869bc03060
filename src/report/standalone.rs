//! Charts in their own files (SVG).

use crate::error::visible;
use maud::{Markup, html};

/// The page's colours on white paper, because viewers other than browsers do not support CSS
/// variables.
const PAPER: [(&str, &str); 3] = [
    ("var(--ink)", "#16191d"),
    ("var(--quiet)", "#5b6470"),
    ("var(--line)", "#d9dde2"),
];

/// The maximum width of a letter, and its height, in a [`standalone`] chart.
pub(crate) const LETTER: (f64, f64) = (8.0, 13.0);

/// Returns a chart of this size in pixels as a file: on white, with letters of [`LETTER`].
pub(crate) fn standalone((width, height): (f64, f64), title: &str, chart: &Markup) -> String {
    let page = include_str!("chart.css").to_owned();
    let css = PAPER
        .iter()
        .fold(page, |css, (name, colour)| css.replace(name, colour));
    let svg = html! {
        svg xmlns="http://www.w3.org/2000/svg" data-made-by="EdgeGait" width=(width) height=(height)
            viewBox=(format!("0 0 {width} {height}")) role="img" aria-label=(title)
            font-family="system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif" {
            style { (css) "svg text { font-size: " (LETTER.1) "px; }" }
            rect width="100%" height="100%" fill="#ffffff" {}
            (chart)
        }
    };
    visible(&svg.into_string()).into_owned() + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::SVG_START;

    #[test]
    fn a_chart_in_a_file_is_known_again_and_needs_no_page() {
        let svg = standalone((30.0, 20.0), "a & b", &html! { line.rail {} });
        assert!(svg.starts_with(SVG_START), "{svg}");
        assert!(svg.contains("viewBox=\"0 0 30 20\"") && svg.contains("a &amp; b"));
        assert!(svg.contains(".rail { stroke: #d9dde2;") && !svg.contains("var("));
    }
}
