//! The page of a study: one self-contained HTML document.

use super::StudyFigure;
use super::figures::{accuracies, boxes, components, overlaid, overlays};
use super::tables::{index, span};
use crate::error::Result;
use crate::evaluate::study::{
    ChangeEffect, Findings, PaperOrder, Recognition, SIZE, Similarity, SplitUnit, banded,
};
use crate::files::ResultHeader;
use crate::report::html::{document, provenance};
use crate::report::percent;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

/// The figures of a study by part.
#[derive(Default)]
pub(super) struct Figures {
    likeness: Vec<StudyFigure>,
    overlays: Vec<StudyFigure>,
    components: Vec<StudyFigure>,
    accuracies: Vec<StudyFigure>,
}

impl Figures {
    pub(super) fn from_findings(findings: &Findings) -> Result<Self> {
        let mut figures = Self::default();
        for one in &findings.similarity {
            let Similarity {
                view,
                masks,
                framing,
                ..
            } = one;
            let name = format!("{view}-{masks}-{framing}");
            if let Some(chart) = boxes(one) {
                let figure = StudyFigure::of_chart(format!("likeness-{name}"), &chart);
                figures.likeness.push(figure);
            }
            if let Some(bytes) = overlays(one)? {
                let people = overlaid(one).iter().map(|group| group.person.as_str());
                let people: Vec<&str> = people.collect();
                let caption = format!(
                    "View {view}, masks {masks}, framing {framing}: {}, eight phases of a cycle each. Green pixels belong to both figures, red ones only to the real figure, yellow ones only to the twin",
                    people.join(", ")
                );
                let figure = StudyFigure::of_png(format!("overlays-{name}"), caption, bytes);
                figures.overlays.push(figure);
            }
        }
        let has_real = has_real(findings);
        for one in &findings.subspaces {
            let whose = if has_real {
                "R (above) and S (below)"
            } else {
                "S"
            };
            let caption = format!(
                "View {}: the mean and the first nine principal components of {whose}; grey is 0",
                one.view
            );
            let figure = StudyFigure::of_png(
                format!("components-{}", one.view),
                caption,
                components(one, has_real)?,
            );
            figures.components.push(figure);
        }
        for (setting, found) in settings(&findings.recognition) {
            if let Some(chart) = accuracies(setting.title(), &found) {
                figures.accuracies.push(StudyFigure::of_chart(
                    format!("accuracy-{}", setting.file()),
                    &chart,
                ));
            }
        }
        Ok(figures)
    }

    /// Returns all figures.
    pub(super) fn all(&self) -> impl Iterator<Item = &StudyFigure> {
        let parts = [
            &self.likeness,
            &self.overlays,
            &self.components,
            &self.accuracies,
        ];
        parts.into_iter().flatten()
    }
}

/// The setting of one chart of accuracies.
#[derive(PartialEq)]
struct Setting<'a> {
    view: &'a str,
    masks: &'a str,
    framing: &'a str,
    augmented: bool,
    split: SplitUnit,
}

impl Setting<'_> {
    fn title(&self) -> String {
        format!(
            "View {}, masks {}, framing {}, split {}{}",
            self.view,
            self.masks,
            self.framing,
            self.split.name(),
            if self.augmented {
                ", flips and crops"
            } else {
                ""
            }
        )
    }

    fn file(&self) -> String {
        let split = match self.split {
            SplitUnit::Cycle => "cycle",
            SplitUnit::Take => "take",
        };
        let augmented = if self.augmented { "-augmented" } else { "" };
        format!(
            "{}-{}-{}-{split}{augmented}",
            self.view, self.masks, self.framing
        )
    }
}

/// Groups experiments by setting. Experiments without a split, and S-S, which has no masks, are in
/// every group.
fn settings(all: &[Recognition]) -> Vec<(Setting<'_>, Vec<&Recognition>)> {
    let mut found: Vec<(Setting<'_>, Vec<&Recognition>)> = Vec::new();
    for one in all {
        let Some(split) = one.curve.split else {
            continue;
        };
        let setting = Setting {
            view: &one.view,
            masks: one.masks,
            framing: one.framing,
            augmented: one.augmented,
            split,
        };
        if found.iter().any(|(known, _)| *known == setting) {
            continue;
        }
        let goes_with = |other: &&Recognition| {
            other.view == one.view
                && (other.framing, other.augmented) == (one.framing, one.augmented)
                && other.curve.split.is_none_or(|unit| unit == split)
                && (other.masks == one.masks || other.curve.experiment.is_synthetic())
        };
        found.push((setting, all.iter().filter(goes_with).collect()));
    }
    found
}

/// Returns a picture for a page.
pub(super) fn picture(caption: &str, png: &[u8]) -> Markup {
    let source = format!("data:image/png;base64,{}", STANDARD.encode(png));
    html! { img.study src=(source) alt=(caption); }
}

/// Returns the page as HTML.
pub(super) fn page(header: &ResultHeader, findings: &Findings, figures: &Figures) -> String {
    let title = if has_real(findings) {
        "Real and synthetic silhouettes"
    } else {
        "Synthetic silhouettes"
    };
    let real: usize = findings
        .counts
        .iter()
        .map(|counts| counts.real)
        .max()
        .unwrap_or(0);
    let synthetic = findings.counts.iter().map(|counts| counts.synthetic).max();
    let body = html! {
                header {
                    h1 { (title) }
                    p.facts { "edgegait " (header.version) " " (header.command) " · seed " (header.seed)
                        " · " (findings.people.len()) " people · " (real) " real and "
                        (synthetic.unwrap_or(0)) " synthetic gait cycles from each viewpoint" }
                    @if has_real(findings) {
                        p { "The experiments of Charalambous & Bharath (BMVC 2016) on real silhouettes (R) and on "
                            "silhouettes of synthetic twins of the same people (S). A twin has a body with the "
                            "person's measurements and moves by the motion capture of each walk. All silhouettes have "
                            (SIZE.rows()) " by " (SIZE.columns()) " pixels." }
                    } @else {
                        p { "The experiments of Charalambous & Bharath (BMVC 2016) that need no real silhouettes "
                            "(R), on silhouettes of synthetic people (S) of " (SIZE.rows()) " by "
                            (SIZE.columns()) " pixels." }
                    }
                    @if !header.warnings.is_empty() {
                        section.warnings {
                            strong { "Before trusting the numbers" }
                            ul { @for warning in &header.warnings { li { (warning) } } }
                        }
                    }
                }
                main {
                    (orders(&findings.orders))
                    (without(findings))
                    (masks(findings))
                    @if !findings.similarity.is_empty() {
                        h2 { "1. Similarity of silhouettes" }
                        (likeness(&findings.similarity))
                        (shown(&figures.likeness))
                        (shown(&figures.overlays))
                        (rows(&findings.similarity))
                    }
                    h2 { "2. Subspaces" }
                    (subspaces(findings))
                    (shown(&figures.components))
                    h2 { "3. Recognition" }
                    p { "Linear support vector machines (C = 1, one-versus-rest for each person) on principal "
                        "components that are fitted to the training data only. R-R is also the control for "
                        "70%R+S - 30%R. The 95 % intervals resample people. In a split by cycle, training "
                        "cycles next to a test cycle are left out. Cycles of one take are still near copies, so "
                        "a split by take is harder." }
                    (recognition(&findings.recognition))
                    (shown(&figures.accuracies))
                    @if !findings.prices.is_empty() {
                        h2 { "What separates S from R" }
                        (prices(&findings.prices))
                    }
                    (provenance(header))
                }
    };
    document(title, &body)
}

fn shown(figures: &[StudyFigure]) -> Markup {
    html! { @for figure in figures {
        figure { (figure.shown) figcaption { (figure.caption) } }
    } }
}

fn orders(orders: &[PaperOrder]) -> Markup {
    let says = |holds: bool| if holds { "yes" } else { "no" };
    let gain = |gain: f64| format!("{:+.1}", 100.0 * gain);
    html! { @if !orders.is_empty() {
        h2 { "The paper's order, and ours" }
        p { "The paper found R-R and S-S best, both mixed experiments above 95 % given enough components, and R-S and "
            "S-R lowest. Here, with the most components:" }
        div.wide { table.study {
            thead { tr { th { "setting" } th { "R-R, S-S best" } th { "mixed above 95 %" } th { "R-S, S-R lowest" }
                th { "gain by S over 70 % of R, points" } th { "over 30 %" } th { "order, accuracy %" } } }
            tbody { @for order in orders { tr {
                td { (Setting { view: &order.view, masks: order.masks, framing: order.framing,
                    augmented: order.augmented, split: order.split }.title()) }
                td { (says(order.own_is_best)) } td { (says(order.mixed_above_95)) }
                td { (says(order.across_is_lowest)) }
                td.number { (gain(order.gain_of_seventy)) } td.number { (gain(order.gain_of_thirty)) }
                td { @for (number, (experiment, rate)) in order.ranked.iter().enumerate() {
                    @if number > 0 { ", " } (experiment.name()) " " (percent(*rate)) } }
            } } }
        } }
    } }
}

fn without(findings: &Findings) -> Markup {
    let without: Vec<&String> = findings
        .counts
        .iter()
        .flat_map(|count| &count.without)
        .collect();
    html! { @if !without.is_empty() {
        h2 { "Takes without a gait cycle" }
        ul { @for reason in without { li { (reason) } } }
    } }
}

/// Describes the masks, and their similarity to those of the tree.
fn masks(findings: &Findings) -> Markup {
    html! { @if !findings.similarity.is_empty() {
        h2 { "Cycles and masks" }
        p { "Given masks are those of the tree. Segmented masks are made by turning the given ones into a video (textured "
            "wall and floor, clothes of random colours, noise, changing light, a shadow) and applying " code { "segment" }
            ". Degraded masks have wavering outlines, holes and missing parts. Their similarity to the given masks, as "
            "stored:" }
        div.wide { table.study {
            thead { tr { th { "view" } th { "masks" } th { "cycles of R" } th { "of S" } th { "Jaccard index with the given ones" } th { "of the worst take" } } }
            tbody { @for one in &findings.counts { tr {
                td { (one.view) } td { (one.masks) } td.number { (one.real) } td.number { (one.synthetic) }
                td.number { (index(one.mask_jaccard)) } td.number { (index(one.worst_mask_jaccard)) }
            } } }
        } }
    } }
}

fn likeness(all: &[Similarity]) -> Markup {
    html! {
        p { "Mean Jaccard indices of frames. Unaligned: the phase of a frame follows from its time. By phase: "
            "all frames of a cycle are shifted by the share of the cycle that makes them most similar. Fitted: "
            "they are also moved by up to two pixels and scaled by up to 6 %." }
        div.wide { table.study {
            thead { tr { th { "view" } th { "masks" } th { "framing" } th { "cycles" } th { "pairs" }
                th { "unaligned" } th { "by phase" } th { "fitted" } th { "pairs half a cycle off, %" }
                th { "phase shift, % of a cycle" } th { "scaled by" } th { "moved right" } th { "moved down" } } }
            tbody { @for one in all { @for (name, group) in one.groups() { tr {
                td { (one.view) } td { (one.masks) } td { (one.framing) } td { (name) }
                td.number { (group.pairs) }
                td.number { (format!("{:.3}", group.unaligned.mean)) }
                td.number { (format!("{:.3}", group.by_phase.mean)) }
                td.number { (format!("{:.3}", group.fitted.mean)) }
                td.number { (percent(group.half_a_cycle)) }
                td.number { (percent(group.phase)) }
                td.number { (format!("{:.3}", group.scale)) }
                td.number { (format!("{:+.2}", group.across)) }
                td.number { (format!("{:+.2}", group.down)) }
            } } } }
        } }
    }
}

/// Shows where one figure covers pixels that the other does not.
fn rows(all: &[Similarity]) -> Markup {
    html! {
        p { "Where silhouettes differ, by rows of the figure: the share of the union that only R covers, and "
            "the share that only S covers. "
            "All shares add up to 1 minus the index by phase." }
        div.wide { table.study {
            thead { tr { th { "view" } th { "masks" } th { "framing" }
                @for (name, _) in crate::evaluate::study::BANDS { th { (name) ": only R, %" } th { "only S" } } } }
            tbody { @for one in all { @if one.synthetic.is_some() { tr {
                td { (one.view) } td { (one.masks) } td { (one.framing) }
                @for (real, synthetic) in banded(&one.rows) {
                    td.number { (percent(real)) } td.number { (percent(synthetic)) }
                }
            } } } }
        } }
    }
}

/// Returns whether there are real silhouettes.
fn has_real(findings: &Findings) -> bool {
    !findings.similarity.is_empty()
}

fn subspaces(findings: &Findings) -> Markup {
    let angles = |angles: &[f64]| {
        let angles: Vec<String> = angles.iter().map(|angle| format!("{angle:.0}")).collect();
        angles.join(", ")
    };
    let held = |shares: &[f64]| {
        let shares: Vec<String> = shares.iter().map(|share| percent(*share)).collect();
        shares.join(", ")
    };
    let has_real = has_real(findings);
    html! {
        div.wide { table.study {
            thead { tr { th { "view" } @if has_real { th { "R: variance of each component, %" } }
                th { "S" } @if has_real { th { "components for 95 %: R" } } th { "S" }
                @if has_real { th { "principal angles, degrees" }
                th { "of two halves of R" } th { "difference of mean GEIs, of 255" } } } }
            tbody { @for one in &findings.subspaces { tr {
                td { (one.view) } @if has_real { td { (held(&one.real.explained)) } }
                td { (held(&one.synthetic.explained)) }
                @if has_real { td.number { (one.real.for_95_percent) } }
                td.number { (one.synthetic.for_95_percent) }
                @if has_real {
                    td { (angles(&one.angles_deg)) } td { (angles(&one.halves_deg)) }
                    td.number { (format!("{:.1}", one.means_apart)) }
                }
            } } }
        } }
    }
}

fn recognition(all: &[Recognition]) -> Markup {
    html! {
        div.wide { table.study {
            thead { tr { th { "view" } th { "masks" } th { "framing" } th { "flips, crops" }
                th { "train - test" } th { "split" } th { "test people" } th { "training cycles" }
                th { "test cycles" } th { "accuracy, %" } th { "95 %" } th { "components" }
                th { "nearest pixels, %" } th { "95 %" } th { "chance, %" } } }
            tbody { @for one in all {
                @let curve = &one.curve;
                @if let Some(last) = curve.last() { tr {
                    td { (one.view) } td { (one.masks) } td { (one.framing) }
                    td { @if one.augmented { "with" } }
                    td { (curve.experiment.name()) }
                    td { (curve.split.map_or("", SplitUnit::name)) }
                    td.number { (curve.people) " of " (curve.classes) }
                    td.number { (format!("{:.0}", curve.trained)) } td.number { (format!("{:.0}", curve.tested)) }
                    td.number { (percent(last.accuracy)) } td.number { (span(last.low, last.high)) }
                    td.number { (last.components) }
                    td.number { (percent(curve.nearest.accuracy)) }
                    td.number { (span(curve.nearest.low, curve.nearest.high)) }
                    td.number { (percent(curve.chance)) }
                } }
            } }
        } }
    }
}

fn prices(all: &[ChangeEffect]) -> Markup {
    html! {
        p { "Each row changes one property of S, and shows the similarity of frames to R and the share of cycles of R "
            "that are recognized after training on S. The gain shows what this difference between R and S costs. Mean "
            "differences are means over all people of this study, so they do not help to identify anybody." }
        div.wide { table.study {
            thead { tr { th { "view" } th { "S with" } th { "Jaccard index with R" } th { "with S as it is" }
                th { "S - R, %" } th { "95 %" } th { "nearest pixels, %" } th { "95 %" } } }
            tbody { @for one in all { tr {
                td { (one.view) } td { (one.change) }
                td.number { (index(one.jaccard)) } td.number { (index(one.own)) }
                td.number { (percent(one.learnt.accuracy)) } td.number { (span(one.learnt.low, one.learnt.high)) }
                td.number { (percent(one.nearest.accuracy)) } td.number { (span(one.nearest.low, one.nearest.high)) }
            } } }
        } }
    }
}
