//! Reports for people: an HTML page, terminal tables, and pictures.
//!
//! A report computes no results: it shows those of [`crate::evaluate`].

pub(crate) mod axis_ticks;
#[cfg(feature = "plots")]
mod camera_effects;
#[cfg(feature = "plots")]
mod camera_view;
mod cells;
mod chart;
mod cmc_roc;
#[cfg(feature = "plots")]
mod confounders;
mod contest_table;
pub(crate) mod drawing;
#[cfg(feature = "plots")]
mod galleries;
mod headline_scope;
mod heatmap;
mod html;
#[cfg(feature = "plots")]
mod labelled_sheet;
#[cfg(feature = "plots")]
mod lettering;
#[cfg(feature = "train")]
mod literature;
mod paired;
mod people;
mod picture;
mod probe_sets;
mod scatter;
mod speed_error;
pub(crate) mod standalone;
#[cfg(feature = "plots")]
mod strengths;
#[cfg(all(feature = "import", feature = "train", feature = "plots"))]
mod study;
mod summary;
mod table;
#[cfg(test)]
pub(crate) mod text_extent;
mod viewpoints;

#[cfg(feature = "plots")]
pub(crate) use confounders::{strength_table, write_strengths};
pub(crate) use contest_table::contest_table;
pub(crate) use drawing::SVG_START;
#[cfg(feature = "plots")]
pub(crate) use galleries::{condition_gallery, template_gallery};
pub(crate) use html::{TemplateSample, write_page};
#[cfg(feature = "train")]
pub(crate) use literature::{garments_table, literature_table};
pub(crate) use picture::{
    SheetRow, cells, contact_sheet, gif, is_own_gif, is_own_png, png, write_png,
};
pub(crate) use speed_error::{SpeedError, SpeedErrorPlot, speed_error_svg};
#[cfg(all(feature = "import", feature = "train", feature = "plots"))]
pub(crate) use study::{study_tables, write_study};
pub(crate) use table::table;

/// The end of the title of every page, by which the program recognizes its files.
pub(crate) const TITLE_END: &str = " · EdgeGait</title>";

/// U+202F, a narrow no-break space.
const THIN: &str = "\u{202f}";

/// Formats a rate in percent with one decimal, such as `41.2`. Only a true 100 % is `100.0` and
/// only a true 0 % is `0.0`, so that a single miss in a million is visible.
pub(crate) fn percent(rate: f64) -> String {
    let rounded = (rate * 1000.0).round() / 10.0;
    let honest = if rate < 1.0 && rounded >= 100.0 {
        99.9
    } else if rate > 0.0 && rounded <= 0.0 {
        0.1
    } else {
        rounded
    };
    format!("{honest:.1}")
}

/// Formats a count in groups of three digits, such as `182 780`, separated by `gap`.
pub(crate) fn grouped(count: u64, gap: &str) -> String {
    let digits = count.to_string();
    let mut out = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            out.push_str(gap);
        }
        out.push(digit);
    }
    out
}

/// Formats microseconds with three significant digits, such as `5.31` or `1 240`.
pub(crate) fn microseconds(us: f64, gap: &str) -> String {
    if !us.is_finite() || us < 0.0 {
        "?".into()
    } else if us < 9.995 {
        format!("{us:.2}")
    } else if us < 99.95 {
        format!("{us:.1}")
    } else {
        // Rounded and not negative; saturates far beyond any latency.
        grouped(us.round() as u64, gap)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_rounds_but_never_hides_a_miss_or_a_hit() {
        assert_eq!(percent(0.4125), "41.3");
        assert_eq!(percent(1.0), "100.0");
        assert_eq!(percent(0.999_999), "99.9");
        assert_eq!(percent(0.0), "0.0");
        assert_eq!(percent(0.000_001), "0.1");
    }

    #[test]
    fn counts_and_times_are_grouped_in_threes() {
        assert_eq!(grouped(0, ","), "0");
        assert_eq!(grouped(999, ","), "999");
        assert_eq!(grouped(182_780, ","), "182,780");
        assert_eq!(grouped(6_500_000, ","), "6,500,000");
        assert_eq!(microseconds(5.314, ","), "5.31");
        assert_eq!(microseconds(53.14, ","), "53.1");
        assert_eq!(microseconds(1240.4, ","), "1,240");
        assert_eq!(microseconds(f64::NAN, ","), "?");
    }
}
