//! Tests of the script of `.github/actions/edgegait-gate`, run as on a runner.

use crate::command::{code, names, text};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn action() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(".github/actions/edgegait-gate")
}

/// Runs the script with these variables.
fn run(at: &Path, variables: &[(&str, &str)]) -> Output {
    Command::new("bash")
        .arg(action().join("gate.sh"))
        .env("EDGEGAIT", env!("CARGO_BIN_EXE_edgegait"))
        .env("EDGEGAIT_CACHE", "none")
        .env("GITHUB_STEP_SUMMARY", at.join("summary.md"))
        .env("GITHUB_OUTPUT", at.join("output.txt"))
        .envs(variables.iter().copied())
        .current_dir(at)
        .output()
        .expect("bash starts")
}

#[test]
#[cfg(unix)]
fn a_build_passes_with_its_own_baseline_and_fails_where_a_limit_is_missed() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let write = |name: &str, limits: &str| fs::write(at.join(name), limits).expect("written");
    let rank1 = "[[limit]]\nfigure = \"recognizers[side].rank1\"\nat_least = 0.9\n";
    write("score.toml", rank1);
    write("paired.toml", &format!("{rank1}not_worse = true\n"));
    write(
        "bench.toml",
        "[[limit]]\nfigure = \"models[side].bytes\"\nat_most = 200000\nratio_at_most = 1.0\n",
    );
    write(
        "absolute.toml",
        "[[limit]]\nfigure = \"models[side].bytes\"\nat_most = 200000\n",
    );
    write(
        "small.toml",
        "[[limit]]\nfigure = \"models[side].bytes\"\nat_most = 1000\n",
    );
    let short = "--no-accuracy --window-s 0.01 --windows 2 --batch 2 --max-seconds 2";
    let usual = [
        ("MODELS", "side"),
        ("SCORE_ARGUMENTS", "--views side --no-baselines"),
        ("BENCH_ARGUMENTS", short),
        ("RUNS", "2"),
    ];
    let with = |more: &[(&'static str, &'static str)]| run(at, &[&usual[..], more].concat());

    let first = with(&[
        ("SCORE_LIMITS", "score.toml"),
        ("BENCH_LIMITS", "absolute.toml"),
        ("OUT", "main"),
    ]);
    assert_eq!(code(&first), 0, "{}", text(&first.stderr));
    for name in [
        "score.json",
        "bench-1.json",
        "bench-2.json",
        "score.xml",
        "bench.bencher.json",
        "comment.md",
    ] {
        assert!(names(&at.join("main")).contains(&name.to_owned()), "{name}");
    }
    let read = |name: &str| fs::read_to_string(at.join(name)).expect(name);
    assert!(
        read("summary.md").contains("### EdgeGait gate: "),
        "{}",
        read("summary.md")
    );
    assert!(
        read("output.txt").contains("outcome=holds"),
        "{}",
        read("output.txt")
    );

    let second = with(&[
        ("SCORE_LIMITS", "paired.toml"),
        ("BENCH_LIMITS", "bench.toml"),
        ("BASELINE", "main"),
    ]);
    assert_eq!(
        code(&second),
        0,
        "{}{}",
        text(&second.stdout),
        text(&second.stderr)
    );

    // Without a baseline, limits relative to one are left out.
    let early = with(&[("SCORE_LIMITS", "paired.toml")]);
    assert_eq!(code(&early), 0, "{}", text(&early.stderr));
    assert!(text(&early.stdout).contains("1 limit relative to a baseline left out"));

    // Models one per line, here only one.
    let lines = with(&[
        ("SCORE_LIMITS", "score.toml"),
        ("MODELS", "\nside\n\n"),
        ("OUT", "lines"),
    ]);
    assert_eq!(code(&lines), 0, "{}", text(&lines.stderr));

    let third = with(&[
        ("SCORE_LIMITS", "score.toml"),
        ("BENCH_LIMITS", "small.toml"),
        ("BASELINE", "none"),
    ]);
    assert_eq!(code(&third), 4, "{}", text(&third.stderr));
    assert!(text(&third.stdout).contains("::warning::EdgeGait gate: there is no folder none"));
    assert!(read("output.txt").contains("outcome=missed"));

    for (more, status, words) in [
        (
            &[("SCORE_LIMITS", "none.toml")][..],
            2,
            "none.toml: expected a file of limits",
        ),
        (
            &[("SCORE_LIMITS", "score.toml"), ("MODELS", " ")],
            2,
            "MODELS: expected models, found none",
        ),
        (
            &[
                ("SCORE_LIMITS", "score.toml"),
                ("BASELINE", "main"),
                ("OUT", "main"),
            ],
            2,
            "BASELINE and OUT: expected two folders",
        ),
        (&[], 2, "expected SCORE_LIMITS, BENCH_LIMITS or both"),
        (
            &[("SCORE_LIMITS", "score.toml"), ("RUNS", "0")],
            2,
            "RUNS: expected a number",
        ),
        (
            &[("SCORE_LIMITS", "score.toml"), ("CANNOT_TELL", "maybe")],
            2,
            "CANNOT_TELL: expected warn or fail",
        ),
    ] {
        let found = with(more);
        let said = text(&found.stderr);
        assert_eq!(code(&found), status, "{said}");
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn the_action_passes_each_of_its_inputs_on() {
    let yaml = fs::read_to_string(action().join("action.yml")).expect("an action");
    let script = fs::read_to_string(action().join("gate.sh")).expect("a script");
    let (_, inputs) = yaml.split_once("\ninputs:\n").expect("inputs");
    let (inputs, steps) = inputs.split_once("\nruns:\n").expect("steps");
    let (inputs, _) = inputs.split_once("\noutputs:\n").expect("outputs");
    let named = inputs
        .lines()
        .filter_map(|line| line.strip_prefix("  ")?.strip_suffix(':'));
    let named: Vec<&str> = named.filter(|name| !name.starts_with(' ')).collect();
    assert!(named.len() > 10, "{named:?}");
    for name in named {
        assert!(
            steps.contains(&format!("inputs.{name}")),
            "{name} is not used"
        );
        let variable = name.to_uppercase().replace('-', "_");
        if !["TOKEN", "COMMENT"].contains(&variable.as_str()) {
            assert!(
                steps.contains(&format!("{variable}: ")),
                "{variable} is not passed"
            );
            assert!(script.contains(&variable), "{variable} is not read");
        }
    }
    let workflow = fs::read_to_string(action().join("workflow.yml")).expect("a workflow");
    let (_, with) = workflow.split_once("        with:\n").expect("inputs");
    let given = with
        .lines()
        .map_while(|line| line.strip_prefix("          ")?.split_once(": "));
    for (name, _) in given {
        assert!(
            yaml.contains(&format!("\n  {name}:\n")),
            "{name}: the action has no such input"
        );
    }
}
