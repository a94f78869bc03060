//! The section of one recognizer in the report: its results by viewpoint.

use super::cells::{chance, rate_cell};
use super::heatmap::{HeatmapGrid, label, legend};
use super::{THIN, cmc_roc, grouped, headline_scope, percent, probe_sets, scatter};
use crate::evaluate::bands::{AZIMUTHS, Bands, ELEVATIONS};
use crate::evaluate::rank1::Tally;
use crate::evaluate::results::RecognizerResult;
use maud::{Markup, html};

/// The maximum number of viewpoints that are listed one by one rather than in bands.
const LISTED: usize = 25;

/// Returns a recognizer's section: its sets of probes, a picture of its viewpoints, and a list of
/// them or, if there are many, the bands.
pub(super) fn recognizer(result: &RecognizerResult, all: &[RecognizerResult]) -> Markup {
    let bands = Bands::sum(&result.by_viewpoint);
    let grid = HeatmapGrid::from_viewpoints(&result.by_viewpoint);
    let is_listed = grid.is_none() || result.by_viewpoint.len() <= LISTED;
    let has_bands = bands.all().probes > 0 && result.by_viewpoint.len() > LISTED;
    let has_training = result.at_training().probes > 0;
    html! {
        section {
            (probe_sets::page(result))
            @if let Some(charts) = cmc_roc::more(result, all) { (charts) }
            @if !result.by_viewpoint.is_empty() {
                h3 { "Rank-1 by viewpoint" }
                p {
                    (result.name)
                    @if let Some(which) = headline_scope::probe_sets(result) { " on " (which) }
                    ": " (headline_scope::counts(result, THIN)) " in all. Azimuth increases to "
                    "the right: 0 is in front of the walker, 90 on the walker's left, 180 behind. Elevation "
                    "increases upwards: 0 is level, 90 straight above."
                }
                div.views {
                    figure {
                        div.wide {
                            @match grid {
                                Some(grid) => (grid.svg(result)),
                                None => (scatter::svg(result)),
                            }
                        }
                        (legend(result.classes, has_training))
                    }
                    @if has_bands { (band_table(&bands)) }
                    @if is_listed { (viewpoints(result)) }
                }
            }
        }
    }
}

/// Returns the pictures of the viewpoints of all recognizers side by side, if there are several.
pub(super) fn small_multiples(results: &[RecognizerResult]) -> Markup {
    let grids = headline_scope::ranked(results)
        .into_iter()
        .filter_map(|result| {
            let grid = HeatmapGrid::from_viewpoints(&result.by_viewpoint)?;
            (result.by_viewpoint.len() > 1).then_some((result, grid))
        });
    let grids: Vec<_> = grids.collect();
    html! {
        @if let [(first, _), _, ..] = &grids[..] {
            h2 { "Rank-1 by viewpoint" }
            p.quiet { "How often the right person is found, percent, by the viewpoint from which people are sought." }
            div.multiples { @for (result, grid) in &grids {
                figure { figcaption { (result.name) } (grid.svg(result)) }
            } }
            (legend(first.classes, grids.iter().any(|(result, _)| result.at_training().probes > 0)))
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
                @if bands.between > 0 {
                    "; " (grouped(bands.between as u64, THIN)) " are not multiples of 5 and count as the nearest one"
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

/// Returns a table of the viewpoints.
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
                    td { (label(viewpoint.azimuth_deg)) }
                    td { (label(viewpoint.elevation_deg)) }
                    td { (grouped(viewpoint.probes, THIN)) }
                    (cell(tally))
                    td { (percent(interval.low)) " to " (percent(interval.high)) }
                    td.text { @if result.is_trained_at(viewpoint) { "trained here" } }
                }
            } }
        } }
    }
}

/// Formats a rate in percent, or a dash without probes.
pub(super) fn rate(tally: Tally) -> String {
    tally.rank1().map_or("–".into(), percent)
}
