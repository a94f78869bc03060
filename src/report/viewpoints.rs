//! One recognizer in the report: where it works.

use maud::{Markup, html};

use super::heatmap::{Grid, colour, ink, legend};
use super::{THIN, grouped, measures, percent};
use crate::evaluate::bands::{AZIMUTHS, Bands, ELEVATIONS};
use crate::evaluate::rank::Tally;
use crate::evaluate::results::RecognizerResult;

/// A recognizer's section: the heatmap, or a list of viewpoints that are no grid, and
/// the bands.
pub(super) fn recognizer(result: &RecognizerResult) -> Markup {
    let bands = Bands::of(&result.by_viewpoint);
    let grid = Grid::of(&result.by_viewpoint);
    // A short list of viewpoints is its own summary.
    let has_bands = bands.all().probes > 0 && (grid.is_some() || result.by_viewpoint.len() > 25);
    html! {
        section {
            h2 { (result.name) }
            (measures::page(result))
            h3 { "Rank-1 by viewpoint" }
            @if grid.is_none() { (viewpoints(result)) }
            div.views {
                @if let Some(grid) = grid {
                    figure {
                        div.wide { (grid.svg(result)) }
                        (legend(result.classes, result.at_training().probes > 0))
                    }
                }
                @if has_bands { (band_table(&bands)) }
            }
        }
    }
}

fn band_table(bands: &Bands) -> Markup {
    html! {
        div.scroll { table.bands {
            caption { "Rank-1 in percent by bands of elevation (rows) and azimuth (columns), degrees"
                @if bands.outside > 0 {
                    "; " (grouped(bands.outside as u64, THIN)) " viewpoints are in no band"
                }
            }
            thead { tr {
                th scope="col" { "elevation" }
                @for azimuth in AZIMUTHS { th scope="col" { (azimuth.replace('-', "–")) } }
                th scope="col" { "all" }
            } }
            tbody {
                @for (band, elevation) in ELEVATIONS.iter().enumerate().rev() {
                    tr {
                        th scope="row" { (elevation.replace('-', "–")) }
                        @for tally in bands.cells[band] { (cell(tally)) }
                        td.sum { (rate(bands.elevation(band))) }
                    }
                }
                tr {
                    th scope="row" { "all" }
                    @for band in 0..AZIMUTHS.len() { td.sum { (rate(bands.azimuth(band))) } }
                    td.sum { (rate(bands.all())) }
                }
            }
        } }
    }
}

fn cell(tally: Tally) -> Markup {
    rate_cell(tally.rank1())
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

/// Viewpoints that are no grid, one by one.
fn viewpoints(result: &RecognizerResult) -> Markup {
    html! {
        div.scroll { table {
            caption { "Chance is " (percent(chance(result))) " %" }
            thead { tr {
                th scope="col" { "azimuth, °" }
                th scope="col" { "elevation, °" }
                th scope="col" { "probes" }
                th scope="col" { "rank-1, %" }
                th scope="col" { "95 % interval" }
                th.text scope="col" { "" }
            } }
            tbody { @for viewpoint in &result.by_viewpoint {
                @let tally = viewpoint.tally();
                @let interval = tally.interval();
                tr {
                    td { (viewpoint.azimuth_deg) }
                    td { (viewpoint.elevation_deg) }
                    td { (grouped(viewpoint.probes, THIN)) }
                    (cell(tally))
                    td { (percent(interval.low)) " to " (percent(interval.high)) }
                    td.text { @if result.is_trained_at(viewpoint) { "trained here" } }
                }
            } }
        } }
    }
}

/// The rate of guessing.
pub(super) fn chance(result: &RecognizerResult) -> f64 {
    1.0 / result.classes.max(1) as f64
}

/// A rate in percent, or a dash without probes.
pub(super) fn rate(tally: Tally) -> String {
    tally.rank1().map_or("–".into(), percent)
}
