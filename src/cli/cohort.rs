//! `edgegait cohort`: make the built-in people.

use super::args::{Common, Files};
use super::encoding::{EncodingArgs, say_choice};
use super::outputs::{Kind, Output};
use super::values::SexArg;
use crate::dataset::{Header, write_bytes};
use crate::error::Result;
use crate::frontier::Encoded;
use crate::scene::cohort::{self, CohortOptions, PEOPLE, Profile, SPEEDS_KMH};
use crate::source::stored;
use crate::summary::Summary;
use std::path::PathBuf;

/// Make the built-in cohort (26 people at 10 speeds, from published norms) as a pack
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  edgegait cohort --out cohort.egp --speeds-kmh 4,5,6")]
pub(super) struct Args {
    /// Where to write the pack
    #[arg(long, value_name = "PATH", default_value = "cohort.egp")]
    out: PathBuf,
    /// How many people
    #[arg(long, value_name = "N", default_value_t = PEOPLE as u16, value_parser = clap::value_parser!(u16).range(1..=999))]
    people: u16,
    /// Speeds in km/h, each 3 to 12; people run from 7.5 on
    #[arg(long, value_name = "V[,V..]", value_delimiter = ',', default_values_t = SPEEDS_KMH)]
    speeds_kmh: Vec<f64>,
    /// Sex of all of them [default: women and men alternate]
    #[arg(long, value_name = "SEX")]
    sex: Option<SexArg>,
    /// Age of all of them, 18 to 80 years [default: drawn from 18 to 58]
    #[arg(long, value_name = "YEARS")]
    age_years: Option<f64>,
    /// Stature of all of them [default: drawn]
    #[arg(long, value_name = "M")]
    stature_m: Option<f64>,
    /// Mass of all of them [default: drawn]
    #[arg(long, value_name = "KG")]
    mass_kg: Option<f64>,
    /// Measure people as they are decoded and drawn, and print it beside what is published
    #[cfg(feature = "import")]
    #[arg(long)]
    audit: bool,
    #[command(flatten)]
    encoding: EncodingArgs,
    #[command(flatten)]
    pub common: Common,
}

impl Args {
    /// What it reads and writes.
    pub(super) fn files(&self) -> Files {
        Files {
            inputs: Vec::new(),
            outputs: vec![Output::new("--out", &self.out, Kind::Pack)],
        }
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> Result<()> {
    args.encoding.check()?;
    let options = CohortOptions {
        seed: args.common.seed,
        people: usize::from(args.people),
        speeds_kmh: args.speeds_kmh.clone(),
        profile: Profile {
            sex: args.sex.map(SexArg::sex),
            age_years: args.age_years,
            stature_m: args.stature_m,
            mass_kg: args.mass_kg,
        },
    };
    let encoded = match stored(&options).filter(|_| args.encoding.is_usual()) {
        Some(bytes) => Encoded::usual(bytes.to_vec()),
        None => args
            .encoding
            .encode("walks", &cohort::subjects(&options)?)?,
    };
    let header = Header::new("cohort", args.common.seed)
        .with("people", options.people)
        .with("speeds_kmh", args.speeds_kmh.clone());
    let mut header = args.encoding.stated(header, &encoded);
    header.warnings.extend(encoded.missed_errors()?);
    let summary = Summary::of(header, &args.out, &encoded.bytes)?;
    #[cfg(feature = "import")]
    let summary = if args.audit {
        summary.with_audit(&encoded.bytes)
    } else {
        summary
    };
    say_choice(&encoded, &args.common);
    args.common.say(&summary);
    write_bytes(&args.out, &encoded.bytes)?;
    args.common
        .say(format_args!("wrote {}", args.out.display()));
    args.common.write_json(&summary)
}
