//! Checks for tests of the positions of texts in a chart, with widths that are rather over- than
//! underestimated.

/// Asserts that no text of any `<svg>` extends beyond its `viewBox`, and that no two texts on one
/// line overlap.
///
/// Texts have the size on a phone (16 units, see `style.css`), and a letter has the width of the
/// widest digits of common fonts: 0.6 of that.
#[track_caller]
pub(crate) fn assert_texts_are_readable(html: &str) {
    assert_texts_of_size_are_readable(html, 16.0);
}

/// Asserts as [`assert_texts_are_readable`], for letters of this height.
#[track_caller]
pub(super) fn assert_texts_of_size_are_readable(html: &str, letter: f64) {
    for svg in html.split("<svg").skip(1) {
        let svg = svg.split("</svg>").next().unwrap_or_default();
        let size: Vec<f64> = value(svg, "viewBox")
            .unwrap_or_default()
            .split(' ')
            .map(|number| number.parse().expect("a number"))
            .collect();
        let mut lines: Vec<(f64, f64, f64, &str)> = Vec::new();
        for text in svg.split("<text").skip(1) {
            let (attributes, rest) = text.split_once('>').expect("a tag ends");
            let content = rest.split('<').next().unwrap_or_default();
            let number = |name: &str| -> f64 {
                let number = value(attributes, name).unwrap_or_else(|| panic!("{name}: {text}"));
                number.parse().expect("a number")
            };
            let width = content.chars().count() as f64 * letter * 0.6;
            let (x, y) = (number("x"), number("y"));
            let left = match value(attributes, "text-anchor") {
                Some("middle") => x - width / 2.0,
                Some("end") => x - width,
                _ => x,
            };
            assert!(
                left >= 0.0
                    && left + width <= size[2]
                    && y >= 0.75 * letter
                    && y + 0.25 * letter <= size[3],
                "{content:?} at {left} to {} and {y} is cut off by {size:?}",
                left + width
            );
            for &(other_left, other_right, other_y, other) in &lines {
                let apart = left >= other_right
                    || left + width <= other_left
                    || (y - other_y).abs() >= 0.875 * letter;
                assert!(apart, "{content:?} lies over {other:?}");
            }
            lines.push((left, left + width, y, content));
        }
    }
}

/// Returns the value of an attribute.
fn value<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = tag.split_once(&format!(" {name}=\""))?;
    rest.split('"').next()
}

#[test]
#[should_panic(expected = "cut off")]
fn a_text_that_is_cut_off_is_found() {
    assert_texts_are_readable(
        "<svg viewBox=\"0 0 99 40\"><text x=\"50\" y=\"20\" text-anchor=\"middle\">elevation, degrees</text></svg>",
    );
}

#[test]
#[should_panic(expected = "lies over")]
fn texts_that_overlap_are_found() {
    assert_texts_are_readable(
        "<svg viewBox=\"0 0 99 40\"><text x=\"0\" y=\"20\">150</text><text x=\"20\" y=\"20\">180</text></svg>",
    );
}
