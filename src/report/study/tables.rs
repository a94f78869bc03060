//! The terminal tables of a study.

use crate::encode::inspect::optional;
use crate::evaluate::study::{AccuracyCurve, ChangeEffect, Findings, Recognition, SimilarityGroup};
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use crate::report::percent;

/// Returns the main numbers of all parts.
pub(crate) fn study_tables(findings: &Findings) -> String {
    let parts = [
        counts(findings),
        similarity(findings),
        subspaces(findings),
        recognition(findings),
        prices(findings),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    parts.join("\n")
}

fn counts(findings: &Findings) -> Option<String> {
    let mut table = Table::new(&[Left(0), Left(0), Right(0)]);
    table
        .row("view|masks|cycles of R|cycles of S|takes without|mask Jaccard|worst take".split('|'));
    for counts in &findings.counts {
        table.row([
            counts.view.clone(),
            counts.masks.to_owned(),
            counts.real.to_string(),
            counts.synthetic.to_string(),
            counts.without.len().to_string(),
            optional(counts.mask_jaccard, 3),
            optional(counts.worst_mask_jaccard, 3),
        ]);
        for reason in &counts.without {
            table.note(format!("    without a cycle: {reason}"));
        }
    }
    (!findings.counts.is_empty()).then(|| format!("{} people\n{table}", findings.people.len()))
}

fn similarity(findings: &Findings) -> Option<String> {
    let mut table = Table::new(&[Left(0), Left(0), Left(0), Left(0), Right(0)]);
    table.row(
        "view|masks|framing|pairs of cycles|pairs|unaligned|by phase|fitted|half a cycle off %"
            .split('|'),
    );
    for one in &findings.similarity {
        for (name, group) in one.groups() {
            let SimilarityGroup {
                pairs,
                unaligned,
                by_phase,
                fitted,
                half_a_cycle,
                ..
            } = group;
            table.row([
                one.view.clone(),
                one.masks.to_owned(),
                one.framing.to_owned(),
                name.to_owned(),
                pairs.to_string(),
                format!("{:.3}", unaligned.mean),
                format!("{:.3}", by_phase.mean),
                format!("{:.3}", fitted.mean),
                percent(*half_a_cycle),
            ]);
        }
    }
    (!findings.similarity.is_empty())
        .then(|| format!("Mean Jaccard index of frames (R: real, S: synthetic)\n{table}"))
}

fn subspaces(findings: &Findings) -> Option<String> {
    let mut table = Table::new(&[Left(0), Right(0)]);
    table.row("view|R: variance of nine %|S|principal angles, least|median|greatest|of halves of R, greatest|mean GEI difference".split('|'));
    for one in &findings.subspaces {
        let held = |shares: &[f64]| percent(shares.iter().sum());
        let angles = &one.angles_deg;
        let angle = |at: usize| {
            angles
                .get(at)
                .map_or_else(String::new, |at| format!("{at:.0}°"))
        };
        table.row([
            one.view.clone(),
            held(&one.real.explained),
            held(&one.synthetic.explained),
            angle(0),
            angle(angles.len() / 2),
            angle(angles.len().saturating_sub(1)),
            one.halves_deg
                .last()
                .map_or_else(String::new, |at| format!("{at:.0}°")),
            format!("{:.1}", one.means_apart),
        ]);
    }
    (!findings.subspaces.is_empty())
        .then(|| format!("Subspaces of nine principal components\n{table}"))
}

fn recognition(findings: &Findings) -> Option<String> {
    let mut table = Table::new(&[
        Left(0),
        Left(0),
        Left(0),
        Left(0),
        Left(0),
        Left(0),
        Right(0),
    ]);
    table.row(
        "view|masks|framing|flips, crops|train - test|split|people|accuracy %|95 %|components|nearest pixels %|95 %|chance %"
            .split('|'),
    );
    for Recognition {
        view,
        masks,
        framing,
        augmented,
        curve,
    } in &findings.recognition
    {
        let AccuracyCurve {
            experiment,
            split,
            people,
            nearest,
            chance,
            ..
        } = curve;
        let Some(last) = curve.last() else { continue };
        table.row([
            view.clone(),
            (*masks).to_owned(),
            (*framing).to_owned(),
            if *augmented { "with" } else { "" }.to_owned(),
            experiment.name().to_owned(),
            split
                .map_or("", crate::evaluate::study::SplitUnit::name)
                .to_owned(),
            people.to_string(),
            percent(last.accuracy),
            span(last.low, last.high),
            last.components.to_string(),
            percent(nearest.accuracy),
            span(nearest.low, nearest.high),
            percent(*chance),
        ]);
    }
    (!findings.recognition.is_empty())
        .then(|| format!("Recognition: PCA and linear SVM (intervals over people)\n{table}"))
}

fn prices(findings: &Findings) -> Option<String> {
    let mut table = Table::new(&[Left(0), Left(0), Right(0)]);
    table.row(
        "view|S with|Jaccard with R|with S as it is|S - R %|95 %|nearest pixels %|95 %".split('|'),
    );
    for ChangeEffect {
        view,
        change,
        jaccard,
        own,
        learnt,
        nearest,
    } in &findings.prices
    {
        table.row([
            view.clone(),
            change.clone(),
            index(*jaccard),
            index(*own),
            percent(learnt.accuracy),
            span(learnt.low, learnt.high),
            percent(nearest.accuracy),
            span(nearest.low, nearest.high),
        ]);
    }
    (!findings.prices.is_empty()).then(|| {
        format!("What separates S from R (trained on S with a change, tested on R)\n{table}")
    })
}

/// Formats a Jaccard index, if there is one.
pub(super) fn index(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| format!("{value:.3}"))
}

/// Formats an interval of rates, percent.
pub(super) fn span(low: Option<f64>, high: Option<f64>) -> String {
    low.zip(high).map_or_else(String::new, |(low, high)| {
        format!("{}-{}", percent(low), percent(high))
    })
}
