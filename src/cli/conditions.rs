//! Flags that choose the conditions.

use super::args::file_with;
use crate::draw::confounders::{
    CATALOGUE, Condition, Conditions, DoseUnit, NAMES, RandomDoses, dose,
};
use crate::draw::confounders::{Dose, Doses};
use crate::error::{Error, Result};
use crate::files::text_table::Column::Left;
use crate::files::text_table::Table;
use crate::files::{InputFile, ResultHeader};
use std::path::PathBuf;

/// The flags that choose the conditions.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct ConditionArgs {
    /// Conditions: casia-b (NM, BG, CL), bag-coat, tum-iitkgp, domain-random (all together, sampled),
    /// each (every confounder alone, at strength 1), or a .toml file
    #[arg(long, value_name = "NAME|FILE", conflicts_with = "confound")]
    conditions: Option<String>,
    /// One condition: confounders with their strengths, as in backpack=0.5,roll=5deg
    /// (`edgegait sweep --list-conditions` lists them)
    #[arg(long, value_name = "NAME=STRENGTH[,..]", value_delimiter = ',', value_parser = dose, allow_hyphen_values = true)]
    confound: Vec<Dose>,
}

impl ConditionArgs {
    /// Returns the file of conditions, if `--conditions` names one.
    pub(super) fn file(&self) -> Option<PathBuf> {
        file_with("toml", self.conditions.as_ref())
    }

    /// Returns whether any condition was requested.
    #[must_use]
    pub(super) fn is_given(&self) -> bool {
        self.conditions.is_some() || !self.confound.is_empty()
    }

    /// Rejects conditions for a folder, whose images are used as they are.
    ///
    /// # Errors
    /// If any condition was requested.
    pub(super) fn refuse_for_folders(&self) -> Result<()> {
        if self.is_given() {
            return Err(Error::Usage(
                "--conditions, --confound: a folder is used as it was drawn (use a pack, or sweep another dataset)".into(),
            ));
        }
        Ok(())
    }

    /// Returns the conditions, in order: those of `usual` if none were requested. States them, and
    /// their file, in the header.
    ///
    /// # Errors
    /// If the name is unknown, or the file cannot be used.
    pub(super) fn load(
        &self,
        usual: Option<&str>,
        header: &mut ResultHeader,
    ) -> Result<Vec<Condition>> {
        if let Some(twice) = (1..self.confound.len()).find(|&at| {
            let before = self.confound[..at].iter();
            before
                .clone()
                .any(|dose| dose.kind == self.confound[at].kind)
        }) {
            let name = self.confound[twice].kind.confounder().name;
            return Err(Error::Usage(format!("--confound: {name} appears twice")));
        }
        let list = match self.conditions.as_deref().or(usual) {
            Some(name) if self.confound.is_empty() => {
                if name.ends_with(".toml") {
                    header.inputs.push(InputFile::read(name)?);
                }
                Conditions::named(name)?.list
            }
            _ if self.confound.is_empty() => Vec::new(),
            _ => vec![Condition::from_doses(Doses::new(
                self.confound.iter().copied(),
            ))],
        };
        if !list.is_empty() {
            *header = header.clone().with("conditions", serde_json::json!(list));
        }
        Ok(list)
    }
}

/// Lists all confounders and built-in conditions as text.
///
/// # Errors
/// Never: built-in conditions can be read.
pub(super) fn listing() -> Result<String> {
    let mut table = Table::new(&[Left(22)]);
    table.note("confounders (strength 0 to 1; with ±, -1 to 1):");
    let mut class = None;
    let mut all: Vec<_> = CATALOGUE.iter().collect();
    all.sort_by_key(|confounder| confounder.class);
    for confounder in all {
        if class != Some(confounder.class) {
            class = Some(confounder.class);
            table.note(format!("\n  {}", confounder.class.name()));
        }
        let sign = if confounder.is_signed { "±" } else { " " };
        let unit = confounder
            .unit
            .map_or(String::new(), |DoseUnit { name, full }| {
                format!(" [1 = {full} {name}]")
            });
        table.row([
            format!("  {sign} {}", confounder.name),
            format!("{}{unit}", confounder.at_full),
        ]);
    }
    table.note("\nbuilt-in conditions:");
    for set in NAMES {
        table.note(format!("\n  --conditions {set}"));
        for condition in Conditions::named(set)?.list {
            table.row([format!("    {}", condition.name), described(&condition)]);
        }
    }
    Ok(table.to_string())
}

/// Describes the confounders of a condition.
fn described(condition: &Condition) -> String {
    let own = condition.confounders.to_string();
    let choices: Vec<String> = condition
        .one_of
        .iter()
        .map(RandomDoses::to_string)
        .collect();
    match (own.is_empty(), choices.is_empty()) {
        (true, true) => "nothing".to_owned(),
        (false, true) => own,
        (true, false) => format!("one of {}, by person", choices.join(" | ")),
        (false, false) => format!("{own}, and one of {}, by person", choices.join(" | ")),
    }
}
