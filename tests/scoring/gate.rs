//! Tests of `edgegait gate` with a planted slowdown, a loss of accuracy and a busy machine.

use crate::command::{code, done, edgegait, refused, text};
use crate::network::write_network;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

/// Measures `model` briefly, writes the results to `name`, and changes them.
fn benched(at: &Path, (model, name): (&str, &str), change: impl FnOnce(&mut Value)) {
    let flags = [
        "--no-accuracy",
        "--window-s",
        "0.2",
        "--windows",
        "3",
        "--batch",
        "2",
        "--frames-per-cycle",
        "8",
        "--max-seconds",
        "3",
    ];
    let out = ["--json", name, "--overwrite", "--quiet"];
    let printed = done(at, &[&["bench", model][..], &flags, &out].concat());
    assert_eq!(printed, "", "quiet");
    let text = fs::read_to_string(at.join(name)).expect("results");
    let mut value: Value = serde_json::from_str(&text).expect("JSON");
    change(&mut value);
    fs::write(at.join(name), value.to_string()).expect("written");
}

/// Sets the load as on an idle machine, as the machine of a test is not idle.
fn idle(value: &mut Value) {
    value["load_of_others"] = json!(0.0);
    value["models"][0]["others_busy"] = json!(0.0);
}

fn gated(at: &Path, arguments: &[&str]) -> (i32, String) {
    let output = edgegait(at, &[&["gate"], arguments].concat());
    (code(&output), text(&output.stdout) + &text(&output.stderr))
}

#[test]
fn a_planted_slowdown_is_missed_and_a_busy_machine_cannot_tell() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    write_network(at, "m", 0, None);
    benched(at, ("m.onnx", "main.json"), idle);
    // The same network with extra work that does not change its answers.
    write_network(at, "m", 40, None);
    benched(at, ("m.onnx", "slow.json"), idle);
    let starter = done(at, &["gate", "--init", "main.json"]);
    assert!(
        starter.contains("figure = \"models[m].p50_us\""),
        "{starter}"
    );
    fs::write(
        at.join("limits.toml"),
        "[[limit]]\nfigure = \"models[m].p50_us\"\nratio_at_most = 1.5\nreason = \"the door opens in time\"\n",
    )
    .expect("written");
    let (status, said) = gated(at, &["limits.toml", "main.json", "main.json"]);
    assert_eq!(
        status,
        if said.contains("cannot") { 3 } else { 0 },
        "{said}"
    );
    let forms = [
        "--markdown",
        "c.md",
        "--junit",
        "g.xml",
        "--bencher",
        "b.json",
        "--json",
        "g.json",
    ];
    let (status, said) = gated(
        at,
        &[&["limits.toml", "slow.json", "main.json"][..], &forms].concat(),
    );
    assert_eq!(status, 4, "{said}");
    assert!(
        said.contains("missed") && said.contains("the door opens in time"),
        "{said}"
    );
    let read = |name: &str| fs::read_to_string(at.join(name)).expect(name);
    assert!(read("c.md").contains("❌ **missed**"), "{}", read("c.md"));
    assert!(
        read("g.xml").contains("<failure type=\"missed\""),
        "{}",
        read("g.xml")
    );
    let metrics: Value = serde_json::from_str(&read("b.json")).expect("JSON");
    assert!(
        metrics["models[m]"]["p50_us"]["value"].as_f64().is_some(),
        "{metrics}"
    );
    let report: Value = serde_json::from_str(&read("g.json")).expect("JSON");
    assert_eq!(
        (&report["command"], &report["outcome"]),
        (&json!("gate"), &json!("missed"))
    );
    // Earlier results of its own are replaced.
    assert_eq!(
        gated(
            at,
            &[&["limits.toml", "slow.json", "main.json"][..], &forms].concat()
        )
        .0,
        4
    );

    // As slow, but other processes keep the machine busy during the measurement.
    let is_over = AtomicBool::new(false);
    thread::scope(|scope| {
        let threads = thread::available_parallelism().map_or(2, usize::from);
        for _ in 0..threads {
            let busy = || {
                while !is_over.load(Ordering::Relaxed) {
                    std::hint::black_box(fs::metadata("/").is_ok());
                }
            };
            let started = thread::Builder::new().spawn_scoped(scope, busy);
            started.expect("a thread");
        }
        benched(at, ("m.onnx", "busy.json"), |_| {});
        is_over.store(true, Ordering::Relaxed);
    });
    let (status, said) = gated(at, &["limits.toml", "busy.json", "main.json"]);
    assert_eq!(status, 3, "{said}");
    assert!(
        said.contains("other processes kept") && said.contains("the limit is undecided"),
        "{said}"
    );
}

/// Writes criterion's result of a benchmark.
fn measured(at: &Path, id: &str, median_ns: f64) {
    let new = at.join("criterion").join(id).join("new");
    fs::create_dir_all(&new).expect("a folder");
    let write = |name: &str, value: Value| fs::write(new.join(name), value.to_string());
    write(
        "benchmark.json",
        json!({ "full_id": id, "throughput": null }),
    )
    .expect("written");
    let interval = json!({ "lower_bound": 0.99 * median_ns, "upper_bound": 1.01 * median_ns });
    let median = json!({ "point_estimate": median_ns, "confidence_interval": interval });
    write("estimates.json", json!({ "median": median })).expect("written");
}

#[test]
fn a_limit_on_criterions_results_is_missed_and_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    measured(at, "draw/slow", 1000.0);
    measured(at, "draw/fast", 100.0);
    let write = |name: &str, text: &str| fs::write(at.join(name), text).expect("written");
    let time = "[[limit]]\nfigure = \"benchmarks[draw/slow].median_ns\"\nat_most = 1200\n";
    write("time.toml", time);
    write(
        "ratio.toml",
        "[criterion]\nmax_age_hours = 24\nmax_apart_hours = 2\n\
         [[limit]]\nfigure = \"benchmarks[draw/slow].median_ns\"\nper = \"benchmarks[draw/fast].median_ns\"\nat_least = 8\n\
         [[limit]]\nfigure = \"benchmarks[draw/none].median_ns\"\nat_most = 1\nneeds = \"two-threads\"\n",
    );
    assert_eq!(gated(at, &["time.toml", "criterion"]).0, 0);
    let (status, said) = gated(
        at,
        &["ratio.toml", "criterion", "--busy", "--json", "g.json"],
    );
    assert_eq!(status, 0, "{said}");
    assert!(
        said.contains("warning: line 9: skipped: this machine has no idle second thread"),
        "{said}"
    );
    let report: Value =
        serde_json::from_str(&fs::read_to_string(at.join("g.json")).expect("a report"))
            .expect("JSON");
    assert_eq!(report["limits"][0]["found"]["value"], 10.0);
    assert_eq!(report["inputs"][1]["path"], "criterion");
    measured(at, "draw/slow", 1300.0);
    let (status, said) = gated(at, &["time.toml", "criterion"]);
    assert_eq!(status, 4, "{said}");
    measured(at, "draw/fast", 200.0);
    let (status, said) = gated(at, &["ratio.toml", "criterion", "--busy"]);
    assert_eq!(status, 4, "{said}");
    write("once.json", "{}");
    refused(
        at,
        &["gate", "time.toml", "once.json", "criterion"],
        1,
        &["once.json: expected the JSON results"],
    );
}

/// Returns the file with noise on the numbers of its largest tensor: the longest run of bytes that
/// look like float weights.
fn with_noise(file: &[u8]) -> Vec<u8> {
    let weight = |at: usize| f32::from_le_bytes(file[at..at + 4].try_into().expect("four"));
    let is_weight = |at: usize| (1e-9..4.0).contains(&weight(at).abs());
    let run_from = |start: usize| {
        let places = (start..file.len() - 3).step_by(4);
        places.take_while(|&at| is_weight(at)).count()
    };
    let (mut best, mut start) = ((0, 0), 0);
    while start + 4 < file.len() {
        let length = run_from(start);
        best = best.max((length, start));
        start += if length > 64 { 4 * length } else { 1 };
    }
    let (length, start) = best;
    let mut noisy = file.to_vec();
    let mut seed = 1_u32;
    for at in (start..start + 4 * length).step_by(4) {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = (seed >> 8) as f32 / 8_388_608.0 - 1.0;
        noisy[at..at + 4].copy_from_slice(&(weight(at) + 0.3 * noise).to_le_bytes());
    }
    noisy
}

#[test]
fn a_planted_loss_of_accuracy_is_missed() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let weights = fs::read("models/gei-small.onnx").expect("a shipped model");
    let contract = fs::read_to_string("models/gei-small.toml").expect("its contract");
    let score = |name: &str, weights: &[u8]| {
        fs::write(at.join("m.onnx"), weights).expect("written");
        fs::write(at.join("m.toml"), &contract).expect("written");
        let views = [
            "--azimuth-deg",
            "0,60,120",
            "--elevation-deg",
            "0,30",
            "--raster",
            "rows",
        ];
        let out = ["--no-baselines", "--json", name, "--overwrite", "--quiet"];
        done(at, &[&["score", "m.onnx"][..], &views, &out].concat());
    };
    score("main.json", &weights);
    let noisy = with_noise(&weights);
    score("noisy.json", &noisy);
    fs::write(
        at.join("limits.toml"),
        "[[limit]]\nfigure = \"recognizers[gei-small].rank1\"\nnot_worse = true\n",
    )
    .expect("written");
    let (status, said) = gated(at, &["limits.toml", "main.json", "main.json"]);
    assert_eq!(status, 0, "{said}");
    let (status, said) = gated(at, &["limits.toml", "noisy.json", "main.json"]);
    assert_eq!(status, 4, "{said}");
    let (status, said) = gated(at, &["limits.toml", "main.json", "noisy.json"]);
    assert_eq!(status, 0, "{said}");
}

#[test]
fn what_cannot_be_judged_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let results = |seed: u64| {
        json!({
            "schema": 1, "command": "sweep", "version": "0.1.0", "seed": seed, "inputs": [], "settings": {},
            "warnings": [], "silhouettes_per_second": 5.0,
        })
    };
    let write = |name: &str, text: &str| fs::write(at.join(name), text).expect("written");
    write("one.json", &results(1).to_string());
    write("two.json", &results(2).to_string());
    write("none.json", "{}");
    write(
        "limits.toml",
        "[[limit]]\nfigure = \"silhouettes_per_second\"\nat_least = 4\n",
    );
    write(
        "lacking.toml",
        "[[limit]]\nfigure = \"rank1\"\nat_least = 0.5\n",
    );
    assert_eq!(gated(at, &["limits.toml", "one.json"]).0, 0);
    let cases: [(&[&str], i32, &[&str]); 10] = [
        (&["limits.toml"], 2, &["FILE"]),
        (
            &["one.json", "limits.toml"],
            1,
            &["one.json: expected limits (TOML), found JSON"],
        ),
        (
            &["limits.toml", "one.json", "--run", "one.json"],
            2,
            &["one.json: appears twice"],
        ),
        (
            &["limits.toml", "none.json"],
            1,
            &["none.json: expected the JSON results"],
        ),
        (&["none.toml", "one.json"], 1, &["none.toml"]),
        (
            &["lacking.toml", "one.json"],
            1,
            &["lacking.toml:2: one.json: the results have no \"rank1\""],
        ),
        (
            &["limits.toml", "one.json", "two.json"],
            1,
            &["two.json: cannot be compared: the seed is 2, and 1 in one.json"],
        ),
        (
            &["limits.toml", "one.json", "--baseline-run", "two.json"],
            2,
            &["--baseline-run"],
        ),
        (&["--init", "none.json"], 1, &["none.json"]),
        (
            &["limits.toml", "one.json", "--junit", "one.json"],
            2,
            &["--junit one.json"],
        ),
    ];
    for (arguments, status, words) in cases {
        refused(at, &[&["gate"], arguments].concat(), status, words);
    }
    write("again.json", &results(1).to_string());
    let runs = ["limits.toml", "one.json", "--run", "again.json"];
    assert_eq!(gated(at, &runs).0, 0);
    // JSON that is not a list of metrics belongs to another program.
    write("package.json", "{\n  \"name\": \"mine\"\n}\n");
    let over = [
        "gate",
        "limits.toml",
        "one.json",
        "--bencher",
        "package.json",
    ];
    refused(at, &over, 2, &["--bencher package.json", "--overwrite"]);
    // If no limit is left to judge, the result is undecided.
    write(
        "beside.toml",
        "[[limit]]\nfigure = \"silhouettes_per_second\"\nratio_at_least = 0.8\n",
    );
    let (status, said) = gated(at, &["beside.toml", "one.json", "--without-baseline"]);
    assert_eq!(status, 3, "{said}");
    assert!(said.contains("no limit is left to judge"), "{said}");
}

#[test]
fn checks_say_what_is_wrong_with_a_model() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    write_network(at, "m", 1, None);
    let output = edgegait(at, &["check", "m.onnx", "--json", "c.json"]);
    let said = text(&output.stdout);
    assert_eq!(code(&output), 0, "{said}");
    for words in [
        "contract from m.toml: silhouettes of 64x44 (NTHW)",
        "8 inputs",
        "embeddings of 512 numbers",
        "seen from 60, 90 and 120 degrees: ",
        "no problems found",
    ] {
        assert!(said.contains(words), "{said}");
    }
    let found: Value =
        serde_json::from_str(&fs::read_to_string(at.join("c.json")).expect("results"))
            .expect("JSON");
    assert_eq!(found["problems"], json!([]));
    // The inputs overflow f32, so that the outputs are not finite.
    let contract = fs::read_to_string(at.join("m.toml")).expect("a contract");
    fs::write(at.join("m.toml"), contract + "std = 1e-38\n").expect("written");
    let output = edgegait(at, &["check", "m.onnx"]);
    assert_eq!(code(&output), 4, "{}", text(&output.stderr));
    assert!(
        text(&output.stdout).contains("are not finite"),
        "{}",
        text(&output.stdout)
    );
    refused(at, &["check", "none.onnx"], 1, &["none.onnx"]);
}
