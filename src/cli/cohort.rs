//! `edgegait cohort`: makes synthetic people.

use super::args::{Common, FileArgs};
use super::encoding::{EncodingArgs, say_choice};
use super::outputs::{Output, OutputKind};
use super::progress::Progress;
use super::values::SexArg;
use crate::dataset::sequences::stored;
use crate::encode::Effort;
use crate::encode::inspect::Summary;
use crate::encode::within_error::EncodedPack;
use crate::error::Result;
use crate::files::{ResultHeader, write_bytes};
use crate::people::cohort::{
    self, CohortOptions, Dressing, LATER_KMH, PEOPLE, Profile, ReferencePopulation, SPEEDS_KMH,
};
use rayon::prelude::*;
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;

/// Make the built-in cohort (26 people at 10 speeds, from published norms) as a pack
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  edgegait cohort --out cohort.egp --speeds-kmh 4,5,6")]
pub(super) struct CohortArgs {
    /// Where to write the pack
    #[arg(long, value_name = "PATH", default_value = "cohort.egp")]
    out: PathBuf,
    /// Number of people, or a slice A..B of a population: people A to B-1. In slices, and in packs
    /// of more than 999 people, a person's bytes do not depend on the others
    #[arg(long, value_name = "N|A..B", default_value_t = PeopleChoice::First(PEOPLE))]
    people: PeopleChoice,
    /// Encode each person alone, without searching for the fewest bytes: many times as fast, with
    /// the same error limit, but walks take about two thirds more bytes
    #[arg(long)]
    quick: bool,
    /// Speeds in km/h, 3 to 12; people run at 7.5 and above [default: 3, 4, ... 12]
    #[arg(long, value_name = "V[,V..]", value_delimiter = ',')]
    speeds_kmh: Option<Vec<f64>>,
    /// Number of sessions, each on another day, with the walks s2-walk-5kmh, s3-... [default: 1, and
    /// without --speeds-kmh 2, of which the second has 4, 5 and 6 km/h]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=9))]
    sessions: Option<u8>,
    /// Population whose statures, masses and shoulders people have
    #[arg(long, value_name = "NAME", value_enum, default_value_t)]
    population: ReferencePopulation,
    /// Sex of all people [default: women and men alternate]
    #[arg(long, value_name = "SEX")]
    sex: Option<SexArg>,
    /// Age of all people, 18 to 80 years; 19 to 65 in britain, 18 to 60 in china [default: sampled;
    /// from 18 to 58 in us-army]
    #[arg(long, value_name = "YEARS")]
    age_years: Option<f64>,
    /// Stature of all people in metres [default: sampled]
    #[arg(long, value_name = "M")]
    stature_m: Option<f64>,
    /// Mass of all people in kg [default: sampled]
    #[arg(long, value_name = "KG")]
    mass_kg: Option<f64>,
    /// Sample clothes, hair and shoes for each person, once or for each take [default: no clothes]
    #[arg(
        long,
        value_name = "WHEN",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "for-good"
    )]
    dressed: Option<Dressing>,
    /// Measure the decoded and rendered people, and print the results beside published norms
    #[cfg(feature = "import")]
    #[arg(long)]
    audit: bool,
    #[command(flatten)]
    encoding: EncodingArgs,
    #[command(flatten)]
    pub common: Common,
}

/// The maximum number of people that are encoded together, which takes fewer bytes and more memory.
const MOST_TOGETHER: usize = 999;

/// The people to make.
#[derive(Clone, Debug)]
enum PeopleChoice {
    /// This many people, from the first on.
    First(usize),
    /// The people with these numbers.
    Slice(Range<usize>),
}

impl PeopleChoice {
    fn numbers(&self) -> Range<usize> {
        match self {
            Self::First(count) => 0..*count,
            Self::Slice(numbers) => numbers.clone(),
        }
    }

    /// Returns whether each person is encoded separately.
    const fn is_population(&self) -> bool {
        !matches!(self, Self::First(1..=MOST_TOGETHER))
    }
}

impl FromStr for PeopleChoice {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let number = |text: &str| {
            text.trim()
                .parse::<u32>()
                .ok()
                .map(|number| number as usize)
        };
        let people = match text.split_once("..") {
            None => number(text).map(Self::First),
            Some((from, to)) => number(from)
                .zip(number(to))
                .map(|(from, to)| Self::Slice(from..to)),
        };
        people
            .filter(|people| !people.numbers().is_empty())
            .ok_or_else(|| {
                "expected a number of people, such as 26, or a slice of at least one, such as 100..200".into()
            })
    }
}

impl fmt::Display for PeopleChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::First(count) => count.fmt(f),
            Self::Slice(Range { start, end }) => write!(f, "{start}..{end}"),
        }
    }
}

impl CohortArgs {
    /// Returns the files that the command reads and writes.
    pub(super) fn files(&self) -> FileArgs {
        FileArgs {
            inputs: Vec::new(),
            outputs: vec![Output::new("--out", &self.out, OutputKind::Pack)],
        }
    }
}

/// Runs the subcommand.
pub(super) fn run(args: &CohortArgs) -> Result<()> {
    args.encoding.check()?;
    // Later sessions have the requested speeds, or else those of the built-in cohort.
    let (speeds_kmh, later_kmh, usual) = match &args.speeds_kmh {
        Some(speeds) => (speeds.clone(), speeds.clone(), 1),
        None => (SPEEDS_KMH.to_vec(), LATER_KMH.to_vec(), 2),
    };
    let sessions = args.sessions.map_or(usual, usize::from);
    let options = CohortOptions {
        seed: args.common.seed,
        first: args.people.numbers().start,
        people: args.people.numbers().len(),
        speeds_kmh,
        later_kmh: vec![later_kmh; sessions - 1],
        profile: Profile {
            reference: args.population,
            sex: args.sex.map(SexArg::sex),
            age_years: args.age_years,
            stature_m: args.stature_m,
            mass_kg: args.mass_kg,
        },
        dressed: args.dressed,
    };
    options.check()?;
    let known = stored(&options).filter(|_| args.encoding.is_usual());
    let encoded = match known {
        _ if args.people.is_population() || args.quick => {
            let walks = options.people * options.sessions().map(<[f64]>::len).sum::<usize>();
            let make = |number| cohort::subject(&options, number);
            let effort = if args.quick {
                Effort::Quick
            } else {
                Effort::Searched
            };
            let progress = Progress::new(&args.common, ("encoding", "walks"), walks);
            args.encoding
                .encode_population(&progress, options.numbers(), effort, &make)?
        }
        Some(bytes) => EncodedPack::usual(bytes.to_vec()),
        None => {
            let progress = Progress::new(&args.common, ("making", "people"), options.people);
            let make = |number| {
                progress.step()?;
                cohort::subject(&options, number)
            };
            let people: Vec<_> = options
                .numbers()
                .into_par_iter()
                .map(make)
                .collect::<Result<_>>()?;
            drop(progress);
            args.encoding.encode(&people, &args.common)?
        }
    };
    let header = ResultHeader::new("cohort", args.common.seed)
        .with("people", options.people)
        .with("first_person", options.first)
        .with("population", args.population.name())
        .with("quick", args.quick)
        .with("dressed", args.dressed.map(Dressing::name))
        .with("speeds_kmh", options.speeds_kmh.clone())
        .with("later_kmh", options.later_kmh.clone());
    let mut header = args.encoding.stated(header, &encoded);
    header.warnings.extend(encoded.missed_errors()?);
    let summary = Summary::from_bytes(header, &args.out, &encoded.bytes)?;
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
