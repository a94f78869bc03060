//! Time of a GEI against its error, as a picture.

use super::Point;
use super::pareto::{Merits, pareto};
use crate::error::{ReportError, Result};
use crate::report::drawing::{COLOURS, FONT, failed, register_font};
use crate::report::signed;
use image::RgbImage;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::io::Cursor;
use std::ops::Range;

/// The chart, and the list of names beside it, pixels.
const CHART: (u32, u32) = (820, 820);
const LIST_WIDTH: u32 = 380;
const TEXT_SIZE: u32 = 13;
const TITLE_SIZE: u32 = 15;
/// Width and height of a character of the labels.
const CHARACTER: (i32, i32) = (8, 13);
const DOT: i32 = 5;
/// Radius of the ring about the default, which no label covers either.
const RING: i32 = 9;

/// The plot as SVG.
///
/// # Errors
/// When there is nothing to plot.
pub fn svg(points: &[Point]) -> Result<String> {
    let mut text = String::new();
    draw(
        &SVGBackend::with_string(&mut text, size()).into_drawing_area(),
        points,
    )?;
    Ok(text)
}

/// The plot as the bytes of a PNG file.
///
/// # Errors
/// When there is nothing to plot.
pub fn png(points: &[Point]) -> Result<Vec<u8>> {
    let (width, height) = size();
    let mut pixels = RgbImage::new(width, height);
    draw(
        &BitMapBackend::with_buffer(&mut pixels, size()).into_drawing_area(),
        points,
    )?;
    let mut bytes = Cursor::new(Vec::new());
    let encoder =
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive);
    pixels
        .write_with_encoder(encoder)
        .map_err(ReportError::Png)?;
    Ok(signed(&bytes.into_inner()))
}

const fn size() -> (u32, u32) {
    (CHART.0 + LIST_WIDTH, CHART.1)
}

/// A point's place: microseconds of a GEI, and its error.
fn place(point: &Point) -> (f64, f64) {
    (1e-3 * point.ns_per_gei, point.gei_rmse)
}

fn draw<B: DrawingBackend>(area: &DrawingArea<B, Shift>, points: &[Point]) -> Result<()> {
    register_font();
    area.fill(&WHITE).map_err(failed)?;
    let (chart, list) = area.split_horizontally(CHART.0);
    draw_chart(&chart, points)?;
    draw_list(&list, points)?;
    area.present().map_err(failed)
}

/// The least and the greatest, with room around them.
fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (least, most) = values.fold((f64::INFINITY, 0.0), |(least, most), value| {
        (value.min(least), value.max(most))
    });
    least / 1.3..most * 1.3
}

/// The colour of a rasteriser: by the order in which rasterisers appear.
fn colour(points: &[Point], raster: &str) -> RGBColor {
    let mut names: Vec<&str> = Vec::new();
    for point in points {
        if !names.contains(&point.raster) {
            names.push(point.raster);
        }
    }
    let index = names.iter().position(|name| *name == raster);
    COLOURS[index.unwrap_or(0) % COLOURS.len()]
}

fn draw_chart<B: DrawingBackend>(area: &DrawingArea<B, Shift>, points: &[Point]) -> Result<()> {
    let x = range(points.iter().map(|point| place(point).0));
    let y = range(points.iter().map(|point| place(point).1));
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(46)
        .y_label_area_size(56)
        .build_cartesian_2d(
            x.clone().log_scale().with_key_points(labelled(&x)),
            y.clone().log_scale().with_key_points(labelled(&y)),
        )
        .map_err(failed)?;
    chart
        .configure_mesh()
        .x_desc("time of a GEI on one thread, us")
        .y_desc("error of a GEI against exact coverage, RMS of 255")
        .label_style((FONT, TEXT_SIZE))
        .axis_desc_style((FONT, TITLE_SIZE))
        .light_line_style(RGBColor(240, 240, 240))
        .bold_line_style(RGBColor(215, 215, 215))
        .x_labels(12)
        .y_labels(14)
        .x_label_formatter(&|x| number(*x))
        .y_label_formatter(&|y| number(*y))
        .draw()
        .map_err(failed)?;
    chart
        .draw_series(LineSeries::new(
            front(points),
            BLACK.mix(0.5).stroke_width(2),
        ))
        .map_err(failed)?;
    let dots = points.iter().map(|point| {
        let colour = colour(points, point.raster);
        let style = if point.pareto {
            colour.filled()
        } else {
            colour.stroke_width(1)
        };
        Circle::new(place(point), DOT, style)
    });
    chart.draw_series(dots).map_err(failed)?;
    let rings = points.iter().filter(|point| point.is_default);
    let rings = rings.map(|point| Circle::new(place(point), RING, BLACK.stroke_width(2)));
    chart.draw_series(rings).map_err(failed)?;
    let at: Vec<(i32, i32)> = points
        .iter()
        .map(|point| chart.backend_coord(&place(point)))
        .collect();
    let origin = area.get_base_pixel();
    for (index, (x, y)) in labels(&at).into_iter().enumerate() {
        let text = (index + 1).to_string();
        let style = (FONT, TEXT_SIZE).into_text_style(area);
        let colour = colour(points, points[index].raster);
        let style = style.color(&colour);
        let at = (x - origin.0, y - origin.1);
        area.draw_text(&text, &style, at).map_err(failed)?;
    }
    Ok(())
}

/// Points that no other beats in the two plotted respects, from the fastest on.
fn front(points: &[Point]) -> Vec<(f64, f64)> {
    let merits = points.iter().map(|point| Merits {
        pack_bytes: 0,
        ..point.merits()
    });
    let set = pareto(&merits.collect::<Vec<_>>());
    let best = points.iter().zip(set).filter(|(_, is_best)| *is_best);
    let mut places: Vec<(f64, f64)> = best.map(|(point, _)| place(point)).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    places
}

/// Where an axis is labelled.
fn labelled(range: &Range<f64>) -> Vec<f64> {
    let decade = |power| [1.0, 2.0, 3.0, 5.0, 7.0].map(|digit| digit * 10f64.powi(power));
    let all = (-3..8).flat_map(decade);
    all.filter(|value| range.contains(value)).collect()
}

/// An axis label: one digit and zeros.
fn number(value: f64) -> String {
    if value < 1.0 {
        format!("{value:.3}")
    } else {
        format!("{value:.0}")
    }
}

/// Upper left corners of the points' numbers, each as near to its point as it can be without
/// covering another number or point.
fn labels(points: &[(i32, i32)]) -> Vec<(i32, i32)> {
    let boxed = |index: usize| (CHARACTER.0 * if index < 9 { 1 } else { 2 }, CHARACTER.1);
    let meets = |a: (i32, i32), a_size: (i32, i32), b: (i32, i32), b_size: (i32, i32)| {
        a.0 < b.0 + b_size.0 && b.0 < a.0 + a_size.0 && a.1 < b.1 + b_size.1 && b.1 < a.1 + a_size.1
    };
    let mut placed: Vec<(i32, i32)> = Vec::new();
    for (index, &(x, y)) in points.iter().enumerate() {
        let size = boxed(index);
        let mut best = (usize::MAX, (x, y));
        for distance in [12, 18, 26, 36, 48] {
            for (right, down) in [
                (1, 0),
                (0, -1),
                (-1, 0),
                (0, 1),
                (1, -1),
                (-1, -1),
                (1, 1),
                (-1, 1),
            ] {
                let centre = (
                    x + right * (distance + size.0 / 2),
                    y + down * (distance + size.1 / 2),
                );
                let at = (centre.0 - size.0 / 2, centre.1 - size.1 / 2);
                let on_labels = placed.iter().enumerate();
                let on_labels = on_labels.filter(|&(i, &other)| meets(at, size, other, boxed(i)));
                let side = (2 * RING, 2 * RING);
                let on_dots = points.iter();
                let on_dots =
                    on_dots.filter(|dot| meets(at, size, (dot.0 - RING, dot.1 - RING), side));
                let met = on_labels.count() + on_dots.count();
                if met < best.0 {
                    best = (met, at);
                }
            }
        }
        placed.push(best.1);
    }
    placed
}

/// The points' names by their numbers, and what the marks mean.
fn draw_list<B: DrawingBackend>(area: &DrawingArea<B, Shift>, points: &[Point]) -> Result<()> {
    let style = (FONT, TEXT_SIZE).into_text_style(area);
    let line = i32::try_from(TEXT_SIZE + 5).unwrap_or_default();
    let mut y = 16;
    for (index, point) in points.iter().enumerate() {
        let text = format!("{:>2} {}", index + 1, point.name);
        let colour = colour(points, point.raster);
        let style = style.color(&colour);
        area.draw_text(&text, &style, (18, y)).map_err(failed)?;
        if point.pareto {
            area.draw(&Circle::new((8, y + 5), 4, colour.filled()))
                .map_err(failed)?;
        }
        y += line;
    }
    let legend = [
        "filled: no other is better in time,",
        "bytes or error and not worse in the rest",
        "line: the best in time and error alone",
        "ring: the default",
    ];
    for text in legend {
        y += line;
        area.draw_text(text, &style, (18, y)).map_err(failed)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_covers_a_point_or_another_number() {
        // Three points so close that all would be labelled on their right, and one far away.
        let points = [(100, 100), (104, 100), (100, 103), (300, 100)];
        let found = labels(&points);
        assert_eq!(found[3], (312, 94));
        for (index, a) in found.iter().enumerate() {
            let apart = |b: (i32, i32), size: (i32, i32)| {
                a.0 + CHARACTER.0 <= b.0
                    || b.0 + size.0 <= a.0
                    || a.1 + CHARACTER.1 <= b.1
                    || b.1 + size.1 <= a.1
            };
            assert!(found[..index].iter().all(|&b| apart(b, CHARACTER)));
            let dot = |(x, y): (i32, i32)| apart((x - RING, y - RING), (2 * RING, 2 * RING));
            assert!(points.iter().all(|&point| dot(point)));
        }
    }

    #[test]
    fn axes_are_labelled_within_their_range() {
        assert_eq!(
            labelled(&(2.5..60.0)),
            [3.0, 5.0, 7.0, 10.0, 20.0, 30.0, 50.0]
        );
        let texts = [0.5, 7.0, 2000.0].map(number);
        assert_eq!(texts, ["0.500", "7", "2000"]);
        let room = range([2.0, 10.0].into_iter());
        assert!(room.start < 2.0 && room.end > 10.0);
    }
}
