//! Gathers the samples of `train` from packs, datasets and trees.

use super::TrainArgs;
use super::mix::SharedSource;
use super::opened_source::{ChosenSource, TemplateSettings};
use crate::error::{Error, Result};
use crate::files::ResultHeader;
use crate::train::{CycleShare, MixPart, Samples, joined, strangers};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

/// The training samples, and their header.
pub(super) struct Gathered {
    pub samples: Samples,
    pub header: ResultHeader,
    /// The result of each source, if there are several or a share is used.
    pub sources: Vec<SourceResult>,
}

/// The part of a source that is used.
#[derive(Serialize)]
pub(super) struct SourceResult {
    name: String,
    kind: &'static str,
    path: String,
    share: f64,
    people: usize,
    samples_before: usize,
    samples_after: usize,
    settings: BTreeMap<String, Value>,
}

impl fmt::Display for SourceResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            name,
            kind,
            people,
            samples_before,
            samples_after,
            ..
        } = self;
        write!(
            f,
            "{name} ({kind}): {people} people, {samples_after} of {samples_before} samples"
        )
    }
}

/// Gathers the samples of all sources.
///
/// # Errors
/// Before long work, for flags and sources that contradict each other; then for data that cannot be
/// read, drawn or made into templates.
pub(super) fn gathered(args: &TrainArgs) -> Result<Gathered> {
    let shared = args.mix.shared_sources(&args.sources, args.common.seed)?;
    refuse_twice(&args.sources)?;
    let making = TemplateSettings {
        settings: args.draw.settings(args.common.seed)?,
        augmentation: args.augmentation()?,
        views: args.views.views("side")?,
    };
    let opened = args.opened()?;
    args.check(&opened, &making)?;
    let selections = args.selections(&opened)?;
    let chosen: Vec<ChosenSource> = opened
        .into_iter()
        .zip(&selections)
        .map(|(source, selection)| args.chosen(source, selection, &making))
        .collect::<Result<_>>()?;
    if !args.states_sources() {
        let only = chosen
            .into_iter()
            .next()
            .ok_or(Error::Missing("a source"))?;
        let (samples, header) = args.part(only, CycleShare::ALL, &making)?;
        return Ok(Gathered {
            samples,
            header,
            sources: Vec::new(),
        });
    }
    let (mut parts, mut sources) = (Vec::new(), Vec::new());
    let mut header = ResultHeader::new("train", args.common.seed);
    if args.mix.is_given() {
        header = header.with("mix", args.mix.to_string());
    }
    for (chosen, shared) in chosen.into_iter().zip(shared) {
        let SharedSource { name, share } = shared;
        let (kind, path) = (chosen.source.kind(), chosen.source.path());
        let (samples, own) = args.part(chosen, share, &making)?;
        for input in own.inputs {
            // All trees share a partition.
            if !header.inputs.contains(&input) {
                header.inputs.push(input);
            }
        }
        let warnings = own.warnings.iter();
        let named = warnings.map(|warning| format!("{name}: {warning}"));
        header.warnings.extend(named);
        sources.push(SourceResult {
            name: name.clone(),
            kind,
            path,
            share: share.part(),
            people: samples.names.len(),
            samples_before: samples.found,
            samples_after: samples.labels.len(),
            settings: own.settings,
        });
        parts.push(MixPart {
            name,
            share,
            samples,
        });
    }
    header.warnings.extend(strangers(&parts));
    let samples = joined(parts)?;
    Ok(Gathered {
        header: header
            .with("template", samples.template.name())
            .with("size", samples.size.name())
            .with("framing", samples.framing.unwrap_or_default().name())
            .augmented(making.augmentation),
        samples,
        sources,
    })
}

/// Rejects a source that is given twice.
fn refuse_twice(sources: &[PathBuf]) -> Result<()> {
    for (at, path) in sources.iter().enumerate() {
        let is_same = |other: &PathBuf| {
            let whole = |path: &PathBuf| std::fs::canonicalize(path).ok();
            other == path || (whole(other).is_some() && whole(other) == whole(path))
        };
        if let Some(other) = sources[..at].iter().find(|other| is_same(other)) {
            return Err(Error::Usage(format!(
                "{}: expected each source once, found it again as {}",
                path.display(),
                other.display()
            )));
        }
    }
    Ok(())
}

impl TrainArgs {
    /// Returns whether results state each source: if there are several, or a share is used.
    pub(super) fn states_sources(&self) -> bool {
        self.sources.len() > 1 || self.mix.is_given()
    }
}
