//! Mutated files for every reader, in this process: none may panic, take long, take much memory or
//! give numbers that are not finite.
//!
//! `EDGEGAIT_MUTATION_SECONDS` (10) is the time, and `EDGEGAIT_MUTATION_SEED` (1) the seed.
//! `EDGEGAIT_MUTATION_ONLY=bvh` runs one target, and `bvh:17` one execution. With `EDGEGAIT_DATA`,
//! the broken recordings in its folder `hard` are seeds, too.
#![expect(unsafe_code, reason = "a counting global allocator requires it")]
#![expect(
    clippy::ptr_arg,
    reason = "mutators have one type, and most change the length"
)]

#[path = "../helpers/data.rs"]
mod data;
#[path = "../helpers/recording.rs"]
mod recording;

mod chance;
mod memory;
mod mutators;
mod run;
mod targets;

use run::{Plan, Target, fresh};
use std::env;
use std::io::Write as _;
use std::path::Path;
use std::str::FromStr;
use std::time::Duration;

#[test]
fn no_reader_fails_on_a_mutated_file() {
    let only = env::var("EDGEGAIT_MUTATION_ONLY").ok().map(|only| {
        let (name, number) = only.split_once(':').unwrap_or((&only, ""));
        (name.to_owned(), number.parse().ok())
    });
    // In memory where possible: a file system on a disk takes longer than the readers.
    let memory = Path::new("/dev/shm");
    let place = if memory.is_dir() {
        memory
    } else {
        Path::new(env!("CARGO_TARGET_TMPDIR"))
    };
    let work = tempfile::Builder::new()
        .prefix("edgegait-mutation")
        .tempdir_in(place);
    let work = work.expect("a folder");
    let plan = Plan {
        seed: stated("EDGEGAIT_MUTATION_SEED", 1),
        time: Duration::from_secs(stated("EDGEGAIT_MUTATION_SECONDS", 10)),
        kept: fresh(&Path::new(env!("CARGO_TARGET_TMPDIR")).join("mutation")),
        work: work.path().to_path_buf(),
        only,
    };
    let targets = targets::all(&plan.work);
    let idle: Vec<String> = (targets.iter())
        .filter(|target| plan.is_asked(target))
        .filter_map(Target::refusal_of_seeds)
        .collect();
    assert!(
        idle.is_empty(),
        "targets that accept no seed of theirs: {idle:#?}"
    );
    let (table, findings) = run::run(&targets, &plan);
    // Past the harness, which shows nothing of a test that passes.
    let _ = write!(std::io::stderr(), "\nseed {}\n{table}", plan.seed);
    assert!(
        findings.is_empty(),
        "{} findings:\n{}",
        findings.len(),
        findings[..findings.len().min(60)].join("\n")
    );
}

fn stated<N: FromStr>(variable: &str, default: N) -> N {
    let Ok(text) = env::var(variable) else {
        return default;
    };
    let number = text.parse().ok();
    number.unwrap_or_else(|| panic!("{variable}: expected a number, found {text:?}"))
}
