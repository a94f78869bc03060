//! Executes targets in turn until the time is over, and judges each execution.

use crate::chance::Chance;
use crate::memory::peak_of;
use crate::mutators::{Mutator, mutated};
use std::any::Any;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The most bytes that an execution may have in use.
const MOST_BYTES: usize = 1 << 30;
/// The longest time of an execution; a longer one is repeated, as the machine may be busy.
const LONGEST: Duration = Duration::from_secs(5);
/// The time after which an execution is taken for endless.
const ENDLESS: Duration = Duration::from_secs(90);
/// Mutated files that are kept of each target.
const KEPT: usize = 20;

/// What a reader says: an error is a refusal.
pub type Outcome = Result<(), Box<dyn Error>>;

/// Reads a mutated file in one of several ways.
type Reader = dyn Fn(&[u8], &mut Chance) -> Outcome;

/// A reader and what it is given.
pub struct Target {
    pub name: &'static str,
    /// Executions in a round: many of quick ones, few of slow ones.
    pub in_a_round: u64,
    pub seeds: Vec<Vec<u8>>,
    /// Mutators of the format.
    pub own: Vec<Mutator>,
    /// Mutators of any bytes or text.
    pub any: Vec<Mutator>,
    pub read: Box<Reader>,
}

impl Target {
    /// Returns why the reader refuses all seeds as they are, if it does: then it would be mutated
    /// files of one refusal only.
    pub fn refusal_of_seeds(&self) -> Option<String> {
        let mut last = None;
        for seed in &self.seeds {
            match (self.read)(seed, &mut Chance::new(0, self.name, 0)) {
                Ok(()) => return None,
                Err(error) => last = Some(format!("{}: {error}", self.name)),
            }
        }
        last
    }
}

#[derive(Default)]
struct Tally {
    executions: u64,
    accepted: u64,
    refused: u64,
    findings: u64,
    slowest: Duration,
    most_bytes: usize,
    spent: Duration,
}

/// How long, from which seed, and in which folders.
pub struct Plan {
    pub seed: u64,
    pub time: Duration,
    /// Where targets write what readers read.
    pub work: PathBuf,
    /// Where mutated files are kept that a reader fails on.
    pub kept: PathBuf,
    /// The only target to run, and its only execution.
    pub only: Option<(String, Option<u64>)>,
}

impl Plan {
    pub fn is_asked(&self, target: &Target) -> bool {
        self.only
            .as_ref()
            .is_none_or(|(name, _)| name == target.name)
    }
}

/// What the hook of panics heard last.
static HEARD: Mutex<String> = Mutex::new(String::new());

/// Runs the targets, and returns a table and the findings.
pub fn run(targets: &[Target], plan: &Plan) -> (String, Vec<String>) {
    let hook = take_hook();
    set_hook(Box::new(|panic| {
        // The first of several threads is the cause.
        let mut heard = HEARD.lock().unwrap_or_else(PoisonError::into_inner);
        if heard.is_empty() {
            *heard = panic.to_string().replace('\n', " ");
        }
    }));
    let (begin, begun) = channel();
    let running = plan.work.join("running");
    let watch = std::thread::Builder::new().spawn(move || watch(&begun, &running));
    let watch = watch.expect("a thread");
    let started = Instant::now();
    let mut tallies: Vec<Tally> = targets.iter().map(|_| Tally::default()).collect();
    let mut findings = Vec::new();
    'rounds: for round in 0.. {
        for (target, tally) in targets.iter().zip(&mut tallies) {
            if !plan.is_asked(target) {
                continue;
            }
            let numbers = round * target.in_a_round..(round + 1) * target.in_a_round;
            let asked = plan
                .only
                .as_ref()
                .and_then(|(_, number)| *number)
                .map(|number| number..number + 1);
            for number in asked.clone().unwrap_or(numbers) {
                if started.elapsed() > plan.time {
                    break 'rounds;
                }
                let _ = begin.send(format!("{} number {number}", target.name));
                findings.extend(execute(target, number, plan, tally));
            }
            if asked.is_some() {
                break 'rounds;
            }
        }
    }
    drop(begin);
    let _ = watch.join();
    set_hook(hook);
    (table(targets, &tallies), findings)
}

/// Ends the process if an execution does not end.
fn watch(begun: &Receiver<String>, file: &Path) {
    let mut running = String::new();
    loop {
        match begun.recv_timeout(ENDLESS) {
            Ok(next) => running = next,
            Err(RecvTimeoutError::Disconnected) => return,
            Err(RecvTimeoutError::Timeout) => {
                let _ = writeln!(std::io::stderr(), "endless: {running}: {}", file.display());
                std::process::abort();
            }
        }
    }
}

/// Does one execution, and returns what is wrong with it.
fn execute(target: &Target, number: u64, plan: &Plan, tally: &mut Tally) -> Option<String> {
    let name = target.name;
    let mut chance = Chance::new(plan.seed, name, number);
    let bytes = mutated(&target.seeds, &target.own, &target.any, &mut chance);
    // Left behind by an execution that ends the process.
    let running = plan.work.join("running");
    let _ = fs::write(&running, &bytes);
    let mut chance = Chance::new(!plan.seed, name, number);
    let mut judge = || {
        HEARD.lock().unwrap_or_else(PoisonError::into_inner).clear();
        let start = Instant::now();
        let read = || catch_unwind(AssertUnwindSafe(|| (target.read)(&bytes, &mut chance)));
        let (read, peak) = peak_of(read);
        (read, peak, start.elapsed())
    };
    let (read, peak, mut took) = judge();
    if took > LONGEST {
        took = took.min(judge().2);
    }
    tally.executions += 1;
    tally.slowest = tally.slowest.max(took);
    tally.spent += took;
    tally.most_bytes = tally.most_bytes.max(peak);
    match &read {
        Ok(Ok(())) => tally.accepted += 1,
        Ok(Err(_)) => tally.refused += 1,
        Err(_) => {}
    }
    let problem = match read {
        Err(panic) => Some(heard(&*panic)),
        _ if took > LONGEST => Some(format!("took {:.1} s", took.as_secs_f64())),
        _ if peak > MOST_BYTES => Some(format!("had {} MB in use", peak >> 20)),
        _ => None,
    }?;
    tally.findings += 1;
    let kept = plan.kept.join(format!("{name}-{number}"));
    if tally.findings <= KEPT as u64 {
        let _ = fs::copy(&running, &kept);
    }
    let again = format!(
        "EDGEGAIT_MUTATION_SEED={} EDGEGAIT_MUTATION_ONLY={name}:{number}",
        plan.seed
    );
    Some(format!("{}: {problem} ({again})", kept.display()))
}

fn heard(panic: &(dyn Any + Send)) -> String {
    let heard = HEARD.lock().unwrap_or_else(PoisonError::into_inner);
    if heard.is_empty() {
        return format!("a silent panic: {:?}", panic.downcast_ref::<String>());
    }
    heard.chars().take(400).collect()
}

fn table(targets: &[Target], tallies: &[Tally]) -> String {
    let mut text = format!(
        "{:<18}{:>11}{:>10}{:>9}{:>9}{:>12}{:>9}{:>9}\n",
        "target",
        "executions",
        "accepted",
        "refused",
        "findings",
        "slowest_ms",
        "peak_MB",
        "spent_s"
    );
    let mut all = 0;
    for (target, tally) in targets
        .iter()
        .zip(tallies)
        .filter(|pair| pair.1.executions > 0)
    {
        let _ = writeln!(
            text,
            "{:<18}{:>11}{:>10}{:>9}{:>9}{:>12}{:>9}{:>9.1}",
            target.name,
            tally.executions,
            tally.accepted,
            tally.refused,
            tally.findings,
            tally.slowest.as_millis(),
            tally.most_bytes >> 20,
            tally.spent.as_secs_f64(),
        );
        all += tally.executions;
    }
    let _ = writeln!(text, "{all} executions");
    text
}

/// Makes an empty folder.
pub fn fresh(folder: &Path) -> PathBuf {
    let _ = fs::remove_dir_all(folder);
    fs::create_dir_all(folder).expect("a folder");
    folder.to_path_buf()
}
