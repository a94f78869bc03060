//! Figures of a study: box plots, curves, overlaid silhouettes, and components as pictures.

use crate::error::Result;
use crate::evaluate::study::{BoxPlot, ComparedSubspaces, Overlay, Recognition, SIZE, Similarity};
use crate::report::drawing::{Axes, LINES, LineStyle, Tick, percents, to_tenth};
use crate::report::{percent, png};
use image::{GrayImage, Luma, Rgb, RgbImage};
use maud::{Markup, html};

/// The styles of the experiments' lines: those of all charts, and grey.
const STYLES: [LineStyle; 7] = [
    LINES[0],
    LINES[1],
    LINES[2],
    LINES[3],
    LINES[4],
    LINES[5],
    LineStyle::new("#707780", "5 2"),
];

/// The maximum number of people in overlays.
const OVERLAID: usize = 6;
/// Enlargement of pixels in overlays and components.
const SCALE: u32 = 3;
/// Background of pictures: neither black nor white.
const GROUND: u8 = 24;

/// A chart with its size and title.
pub(super) struct Chart {
    /// Width and height, pixels.
    pub size: (f64, f64),
    /// The title.
    pub title: String,
    /// The contents of the SVG.
    pub drawn: Markup,
}

impl Chart {
    /// Returns the chart for a page.
    pub(super) fn svg(&self) -> Markup {
        let (width, height) = self.size;
        html! {
            div.wide { svg.study viewBox=(format!("0 0 {width} {height}")) width=(width) height=(height)
                role="img" aria-label=(self.title) { (self.drawn) } }
        }
    }
}

/// Draws box plots of Jaccard indices by person: a box for pairs of cycles of one take, and one for
/// pairs of a cycle and the twin's.
pub(super) fn boxes(similarity: &Similarity) -> Option<Chart> {
    let groups: Vec<(&str, &crate::evaluate::study::SimilarityGroup)> = similarity
        .groups()
        .filter(|(name, _)| *name != "R-R, two takes")
        .collect();
    let mut people: Vec<&str> = groups
        .iter()
        .flat_map(|(_, group)| group.people.iter().map(|(name, _)| name.as_str()))
        .collect();
    people.sort_unstable();
    people.dedup();
    if people.is_empty() {
        return None;
    }
    let lows = groups.iter().flat_map(|(_, group)| &group.people);
    let least = lows.fold(1.0_f64, |least, (_, plot)| least.min(plot.low));
    // Rounded down to a tenth.
    let floor = (10.0 * least - 1e-9).floor() / 10.0;
    let step = 26.0;
    let axes = Axes {
        left: 44.0,
        top: 12.0,
        width: step * people.len() as f64,
        height: 190.0,
    };
    let share = |index: f64| (index - floor) / (1.0 - floor);
    let tenths = (0..=10).map(|tenth| floor + f64::from(tenth) * 0.1);
    let across: Vec<Tick> = tenths
        .filter(|index| *index <= 1.0 + 1e-9)
        .map(|index| Tick::new(share(index), format!("{index:.1}")))
        .collect();
    let place = |at: usize| (at as f64 + 0.5) / people.len() as f64;
    let names: Vec<Tick> = people
        .iter()
        .enumerate()
        .map(|(at, name)| Tick::new(place(at), name))
        .collect();
    let drawn = html! {
        (axes.across(&across))
        (axes.below(&names))
        @for (number, (name, group)) in groups.iter().enumerate() {
            @for (person, plot) in &group.people {
                @if let Some(at) = people.iter().position(|known| known == person) {
                    @let x = axes.place((place(at), 0.0)).0 + 10.0 * number as f64 - 5.0;
                    (one_box(x, plot, LINES[number].colour, &format!("{person}, {name}"), &|index| axes.place((0.0, share(index))).1))
                }
            }
        }
    };
    Some(Chart {
        size: (axes.left + axes.width + 8.0, 232.0),
        title: format!(
            "Jaccard index by person, view {}, masks {}: blue {}, red {}",
            similarity.view,
            similarity.masks,
            groups.first().map_or("", |group| group.0),
            groups.get(1).map_or("", |group| group.0),
        ),
        drawn,
    })
}

fn one_box(x: f64, plot: &BoxPlot, colour: &str, title: &str, y_of: &dyn Fn(f64) -> f64) -> Markup {
    let [low, q1, median, q3, high] =
        [plot.low, plot.q1, plot.median, plot.q3, plot.high].map(y_of);
    html! {
        g stroke=(colour) {
            line x1=(to_tenth(x)) x2=(to_tenth(x)) y1=(to_tenth(low)) y2=(to_tenth(high)) {}
            rect x=(to_tenth(x - 4.0)) y=(to_tenth(q3)) width="8" height=(to_tenth((q1 - q3).max(0.5)))
                fill=(colour) fill-opacity="0.35" {}
            line x1=(to_tenth(x - 4.0)) x2=(to_tenth(x + 4.0)) y1=(to_tenth(median)) y2=(to_tenth(median)) stroke-width="2" {}
            title { (title) ": median " (format!("{:.3}", plot.median)) ", quartiles "
                (format!("{:.3} to {:.3}", plot.q1, plot.q3)) ", " (plot.count) " frames" }
        }
    }
}

/// Draws accuracy over the number of components, with a line for each experiment and its 95 %
/// interval at the end.
pub(super) fn accuracies(title: String, found: &[&Recognition]) -> Option<Chart> {
    let most = found
        .iter()
        .flat_map(|group| group.curve.points.iter().map(|point| point.components))
        .max()?;
    let axes = Axes {
        left: 48.0,
        top: 12.0,
        width: 330.0,
        height: 220.0,
    };
    let share = |components: usize| components as f64 / most as f64;
    let ticks: Vec<Tick> = (0..=most)
        .step_by(10)
        .map(|at| Tick::new(share(at), at))
        .collect();
    let drawn = html! {
        (axes.across(&percents([0, 25, 50, 75, 100])))
        (axes.below(&ticks))
        text.axis x="213" y="272" text-anchor="middle" { "principal components" }
        @for (one, style) in found.iter().zip(STYLES) {
            @let points = one.curve.points.iter().map(|point| (share(point.components), point.accuracy));
            (axes.curve(one.curve.experiment.name(), points, style))
            @if let Some(last) = one.curve.last() {
                @let place = |rate: f64| axes.place((share(last.components), rate));
                @if let (Some(low), Some(high)) = (last.low, last.high) {
                    line.error stroke=(style.colour) x1=(to_tenth(place(low).0)) x2=(to_tenth(place(low).0))
                        y1=(to_tenth(place(low).1)) y2=(to_tenth(place(high).1)) {}
                }
                circle cx=(to_tenth(place(last.accuracy).0)) cy=(to_tenth(place(last.accuracy).1)) r="3" fill=(style.colour) {
                    title { (one.curve.experiment.name()) ": " (percent(last.accuracy)) " %" }
                }
            }
        }
        @for (number, (one, style)) in found.iter().zip(STYLES).enumerate() {
            @let y = 24.0 + 20.0 * number as f64;
            path.curve d=(format!("M396 {y}L424 {y}")) stroke=(style.colour) stroke-dasharray=(style.dashes) {}
            text.tick x="430" y=(to_tenth(y + 4.0)) { (one.curve.experiment.name()) }
        }
    };
    Some(Chart {
        size: (560.0, 284.0),
        title,
        drawn,
    })
}

/// Returns the people in a picture of overlays.
pub(super) fn overlaid(similarity: &Similarity) -> &[Overlay] {
    &similarity.overlays[..similarity.overlays.len().min(OVERLAID)]
}

/// Returns a PNG file of overlaid frames of the first people, a row for each: green is both, red
/// only the real figure, yellow only the twin.
///
/// # Errors
/// If it cannot be encoded.
pub(super) fn overlays(similarity: &Similarity) -> Result<Option<Vec<u8>>> {
    let shown = overlaid(similarity);
    let columns = shown
        .iter()
        .map(|group| group.frames.len())
        .max()
        .unwrap_or(0);
    if columns == 0 {
        return Ok(None);
    }
    let cell = (SIZE.columns() as u32 + 1, SIZE.rows() as u32 + 1);
    let mut image = RgbImage::from_pixel(
        SCALE * (cell.0 * columns as u32 + 1),
        SCALE * (cell.1 * shown.len() as u32 + 1),
        Rgb([GROUND; 3]),
    );
    for (row, one) in (0..).zip(shown) {
        for (column, (real, twin)) in (0..).zip(&one.frames) {
            for (x, y) in pixels() {
                let colour = match (
                    real.is_on(y as usize, x as usize),
                    twin.is_on(y as usize, x as usize),
                ) {
                    (true, true) => [0, 158, 115],
                    (true, false) => [213, 60, 40],
                    (false, true) => [240, 228, 66],
                    (false, false) => continue,
                };
                let corner = (column * cell.0 + x + 1, row * cell.1 + y + 1);
                enlarge(corner, |x, y| image.put_pixel(x, y, Rgb(colour)));
            }
        }
    }
    Ok(Some(png(&image)?))
}

/// Returns a PNG file of the mean and the nine components of R, if there are real silhouettes, and
/// of S below; grey is 0.
///
/// # Errors
/// If it cannot be encoded.
pub(super) fn components(subspaces: &ComparedSubspaces, has_real: bool) -> Result<Vec<u8>> {
    let real = has_real.then_some(&subspaces.real);
    let sides: Vec<_> = real.into_iter().chain([&subspaces.synthetic]).collect();
    let columns = sides.iter().map(|side| side.components.nrows() + 1).max();
    let columns = columns.unwrap_or(1) as u32;
    let cell = (SIZE.columns() as u32 + 1, SIZE.rows() as u32 + 1);
    let mut image = GrayImage::from_pixel(
        SCALE * (cell.0 * columns + 1),
        SCALE * (cell.1 * sides.len() as u32 + 1),
        Luma([GROUND]),
    );
    for (row, side) in (0..).zip(sides) {
        let components = side.components.outer_iter().map(|component| {
            let most = component
                .iter()
                .fold(1e-12_f64, |most, at| most.max(at.abs()));
            component.mapv(|at| 0.5 + 0.5 * at / most).to_vec()
        });
        let all = std::iter::once(side.mean.clone()).chain(components);
        for (column, pixels_of) in (0..).zip(all) {
            for (x, y) in pixels() {
                let share = pixels_of[y as usize * SIZE.columns() + x as usize];
                // 0..=255, rounded.
                let grey = Luma([(255.0 * share.clamp(0.0, 1.0) + 0.5) as u8]);
                let corner = (column * cell.0 + x + 1, row * cell.1 + y + 1);
                enlarge(corner, |x, y| image.put_pixel(x, y, grey));
            }
        }
    }
    png(&image)
}

/// Returns the coordinates of a silhouette's pixels.
fn pixels() -> impl Iterator<Item = (u32, u32)> {
    let rows = 0..SIZE.rows() as u32;
    rows.flat_map(|y| (0..SIZE.columns() as u32).map(move |x| (x, y)))
}

/// Calls `put` for each pixel of an enlarged pixel.
fn enlarge((x, y): (u32, u32), mut put: impl FnMut(u32, u32)) {
    for (right, down) in (0..SCALE * SCALE).map(|at| (at % SCALE, at / SCALE)) {
        put(SCALE * x + right, SCALE * y + down);
    }
}
