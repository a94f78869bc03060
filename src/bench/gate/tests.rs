//! Tests of limits on results of `score` and `bench`.

use super::*;
use serde_json::{Value, json};

mod criterion;

/// Returns results of `bench` with one model, whose median call takes `p50_us`.
fn bench(p50_us: f64, change: impl FnOnce(&mut Value)) -> ResultFile {
    let mut value = json!({
        "schema": 1, "command": "bench", "version": "0.1.0", "seed": 1,
        "inputs": [{ "path": "m.onnx", "sha256": "00" }], "settings": { "batch": 64 }, "warnings": [],
        "board": { "model": "Pi 4" }, "load_of_others": 0.01,
        "models": [{
            "name": "m", "threads": 1, "p50_us": p50_us, "throughput": 1e6 / p50_us, "bytes": 1000,
            "window_mean_us": [0.99 * p50_us, p50_us, 1.01 * p50_us, p50_us, p50_us],
            "accuracy": { "rank1": 0.5, "rank1_low": 0.4, "rank1_high": 0.6 },
        }],
    });
    change(&mut value);
    ResultFile::parse(Path::new("bench.json"), &value.to_string()).expect("results")
}

/// Returns results of `score`: ten people with ten probes each.
fn score(hits: [u64; 10]) -> ResultFile {
    let people: Vec<Value> = (0..)
        .zip(hits)
        .map(|(at, hits)| json!({ "person": format!("p{at}"), "probes": 10, "hits": hits }))
        .collect();
    let rank1 = hits.iter().sum::<u64>() as f64 / 100.0;
    let value = json!({
        "schema": 1, "command": "score", "version": "0.1.0", "seed": 1,
        "inputs": [], "settings": {}, "warnings": [],
        "recognizers": [{ "name": "m", "baseline": false, "rank1": rank1, "by_person": people, "eer": 0.2 }],
    });
    ResultFile::parse(Path::new("score.json"), &value.to_string()).expect("results")
}

fn report(text: &str, runs: &[ResultFile], baselines: &[ResultFile]) -> Result<GateReport> {
    let path = Path::new("limits.toml");
    let limits = GateLimits::parse(path, text).expect("limits");
    gate(
        path,
        &limits,
        &JudgedRuns {
            runs,
            baselines,
            without_baseline: false,
            is_busy: false,
            now: SystemTime::UNIX_EPOCH,
        },
        ResultHeader::new("gate", 1),
    )
}

fn outcomes(text: &str, runs: &[ResultFile], baselines: &[ResultFile]) -> Vec<GateOutcome> {
    let report = report(text, runs, baselines).expect("judged");
    report.limits.iter().map(|line| line.outcome).collect()
}

const SLOWER: &str = "[[limit]]\nfigure = \"models.p50_us\"\nratio_at_most = 1.2\n";
use GateOutcome::{CannotTell, Holds, Missed};

#[test]
fn a_slowdown_is_missed_and_noise_cannot_be_told() {
    let before = [bench(100.0, |_| {})];
    let of = |now: ResultFile| outcomes(SLOWER, &[now], &before);
    assert_eq!(of(bench(100.0, |_| {})), [Holds]);
    assert_eq!(of(bench(150.0, |_| {})), [Missed]);
    // Within the spread of the windows.
    assert_eq!(of(bench(120.0, |_| {})), [CannotTell]);
    let busy = |value: &mut Value| value["models"][0]["others_busy"] = json!(0.5);
    assert_eq!(of(bench(150.0, busy)), [CannotTell]);
    assert_eq!(of(bench(100.0, busy)), [Holds]);
    let other = |value: &mut Value| value["board"]["model"] = json!("Pi 5");
    assert_eq!(of(bench(50.0, other)), [CannotTell]);
}

#[test]
fn several_runs_speak_by_their_median() {
    let runs = [90.0, 300.0, 100.0, 101.0, 95.0].map(|p50_us| bench(p50_us, |_| {}));
    let limit = "[[limit]]\nfigure = \"models[m].p50_us\"\nat_most = 100\n";
    let found = report(limit, &runs, &[]).expect("judged");
    let line = &found.limits[0];
    assert_eq!(
        (line.found.value, line.found.low, line.found.high),
        (100.0, 90.0, 300.0)
    );
    assert_eq!(found.outcome, CannotTell);
    let by_value = format!("{limit}judge = \"value\"\n");
    assert_eq!(outcomes(&by_value, &runs, &[]), [Holds]);
    let other = bench(90.0, |value| value["inputs"][0]["sha256"] = json!("01"));
    let said = report(limit, &[bench(90.0, |_| {}), other], &[]).expect_err("another model");
    assert!(said.to_string().contains("found other models"), "{said}");
}

#[test]
fn rank_1_is_compared_person_by_person() {
    let limit = "[[limit]]\nfigure = \"recognizers.rank1\"\nnot_worse = true\n";
    let before = [score([9, 8, 7, 6, 5, 9, 8, 7, 6, 5])];
    // One hit less for every person: far within the spread of people.
    assert_eq!(
        outcomes(limit, &[score([8, 7, 6, 5, 4, 8, 7, 6, 5, 4])], &before),
        [Missed]
    );
    assert_eq!(
        outcomes(limit, &[score([9, 8, 7, 6, 5, 9, 8, 7, 6, 4])], &before),
        [CannotTell]
    );
    assert_eq!(outcomes(limit, &before, &before), [Holds]);
    let close = "[[limit]]\nfigure = \"recognizers.rank1\"\ndifference_at_least = -0.02\n";
    let one_less = [score([9, 8, 7, 6, 5, 9, 8, 7, 6, 4])];
    // The interval is the same, whatever decides.
    let by_value = report(&format!("{close}judge = \"value\"\n"), &one_less, &before);
    let by_value = by_value.expect("judged").limits.remove(0);
    let by_interval = report(close, &one_less, &before)
        .expect("judged")
        .limits
        .remove(0);
    assert_eq!(by_value.difference, by_interval.difference);
    assert_eq!(by_value.outcome, Holds);
    assert_eq!(outcomes(close, &one_less, &before), [CannotTell]);
    // No hits by person: the values only.
    let eer = "[[limit]]\nfigure = \"recognizers.eer\"\nratio_at_most = 1.0\nnot_worse = true\n";
    assert_eq!(outcomes(eer, &one_less, &before), [Holds, Holds]);
}

#[test]
fn hits_and_probes_that_no_run_has_are_refused() {
    let limit = "[[limit]]\nfigure = \"recognizers.rank1\"\nnot_worse = true\n";
    for (probes, hits) in [(u64::MAX, 9), (1 << 33, 9), (10, 11)] {
        let mut wrong = [score([9; 10])];
        let person = &mut wrong[0].value["recognizers"][0]["by_person"][3];
        person["probes"] = json!(probes);
        person["hits"] = json!(hits);
        let said = report(limit, &wrong, &[score([9; 10])]).expect_err("too many");
        let problem = format!("probes of p3 and no more hits, found {probes} and {hits}");
        assert!(said.to_string().contains(&problem), "{said}");
    }
}

#[test]
fn what_cannot_be_judged_is_an_error_and_no_pass() {
    let one = [bench(100.0, |_| {})];
    for (text, words) in [
        (
            SLOWER,
            "limits.toml:2: models[m].p50_us: expected a baseline for this limit, found none",
        ),
        (
            "[[limit]]\nfigure = \"models.p51_us\"\nat_most = 1\n",
            "limits.toml:2: bench.json: models[m] has no \"p51_us\"",
        ),
        (
            "[[limit]]\nfigure = \"models[n].p50_us\"\nat_most = 1\n",
            "found 0 among m",
        ),
        (
            "[[limit]]\nfigure = \"models.energy.single_mj\"\nat_most = 1\n",
            "models[m] has no \"energy\"",
        ),
    ] {
        let said = report(text, &one, &[]).expect_err(text).to_string();
        assert!(said.contains(words), "{said}");
    }
    let vague = "[[limit]]\nfigure = \"models.threads\"\nnot_worse = true\n";
    let said = report(vague, &one, &one).expect_err("vague").to_string();
    assert!(
        said.contains("better direction, found \"threads\""),
        "{said}"
    );
    let without = [bench(100.0, |value| {
        value["models"][0]
            .as_object_mut()
            .expect("a model")
            .remove("p50_us");
    })];
    let said = report(SLOWER, &one, &without)
        .expect_err("lacks it")
        .to_string();
    assert!(
        said.contains("limits.toml:2: bench.json: models[m] has no \"p50_us\""),
        "{said}"
    );
    let others = [bench(100.0, |value| value["settings"]["batch"] = json!(8))];
    let said = report(SLOWER, &one, &others)
        .expect_err("settings")
        .to_string();
    assert!(
        said.contains("the setting \"batch\" is 8, and 64"),
        "{said}"
    );
}

#[test]
fn a_ratio_of_two_values_of_one_result_is_limited() {
    let tail = |p99_us: f64| {
        [bench(100.0, |value| {
            value["models"][0]["p99_us"] = json!(p99_us);
        })]
    };
    let limit = "[[limit]]\nfigure = \"models[m].p99_us\"\nper = \"models.p50_us\"\nat_most = 2\n";
    assert_eq!(outcomes(limit, &tail(150.0), &[]), [Holds]);
    assert_eq!(outcomes(limit, &tail(250.0), &[]), [Missed]);
    assert_eq!(outcomes(limit, &tail(200.0), &[]), [CannotTell]);
    let busy = [bench(100.0, |value| {
        value["models"][0]["p99_us"] = json!(250.0);
        value["models"][0]["others_busy"] = json!(0.5);
    })];
    assert_eq!(outcomes(limit, &busy, &[]), [CannotTell]);
    // The ratio is compared with that of the baseline.
    let beside = limit.replace("at_most = 2", "ratio_at_most = 1.2");
    assert_eq!(outcomes(&beside, &tail(200.0), &tail(200.0)), [Holds]);
    assert_eq!(outcomes(&beside, &tail(300.0), &tail(200.0)), [Missed]);
    for (from, to, words) in [
        (
            "models.p50_us",
            "models.p51_us",
            "limits.toml:2: bench.json: per: models[m] has no \"p51_us\"",
        ),
        (
            "models.p50_us",
            "models.bytes",
            "expected two times, two of throughput, or two others",
        ),
        (
            "\"models.p50_us\"",
            "{ \"models.missing\" = 2 }",
            "models[m] has no \"missing\"",
        ),
    ] {
        let said = report(&limit.replace(from, to), &tail(1.0), &[]).expect_err(to);
        assert!(said.to_string().contains(words), "{said}");
    }
    let zero = [bench(100.0, |value| value["models"][0]["macs"] = json!(0))];
    let by_zero = "[[limit]]\nfigure = \"models.bytes\"\nper = \"models.macs\"\nat_least = 2\n";
    let said = report(by_zero, &zero, &[]).expect_err("by 0").to_string();
    let words = "expected a value of at least 0 and one above 0, found 1000 and 0";
    assert!(said.contains(words), "{said}");
}

#[test]
fn the_worst_outcome_is_that_of_all_and_each_form_says_it() {
    let text = "[[limit]]\nfigure = \"models[m].bytes\"\nat_most = 900\nname = \"small <enough>\"\nreason = \"flash & RAM\"\n\
                [[limit]]\nfigure = \"models.p50_us\"\nat_most = 100\n\
                [[limit]]\nfigure = \"models[*].accuracy.rank1\"\nat_least = 0.45\nnot_worse = true\n";
    let found = report(text, &[bench(100.0, |_| {})], &[bench(100.0, |_| {})]).expect("judged");
    let outcomes: Vec<_> = found.limits.iter().map(|line| line.outcome).collect();
    assert_eq!(outcomes, [Missed, CannotTell, Holds, Holds]);
    assert_eq!(found.outcome, Missed);
    let text = found.to_string();
    for words in [
        "missed       small <enough>",
        "flash & RAM",
        "100 (99 to 101)",
        "the limit is within the interval",
        "1 of 4 limits missed, 1 undecided",
    ] {
        assert!(text.contains(words), "{text}");
    }
    let markdown = found.markdown();
    assert!(
        markdown.starts_with("### EdgeGait gate: 1 of 4 limits missed"),
        "{markdown}"
    );
    assert!(
        markdown.contains(
            "| ❌ **missed** | small &lt;enough&gt;<br>flash &amp; RAM | 1,000 | at most 900 |"
        ),
        "{markdown}"
    );
    let junit = found.junit();
    assert!(junit.starts_with(JUNIT_START), "{junit}");
    assert!(
        junit.contains("tests=\"4\" failures=\"1\" errors=\"1\""),
        "{junit}"
    );
    assert!(junit.contains("<failure type=\"missed\" message=\"found 1,000, limit at most 900, baseline 1,000: flash &amp; RAM\"/>"), "{junit}");
    let bencher = found.bencher();
    let expected = json!({
        "bytes": { "value": 1000.0 },
        "p50_us": { "value": 100.0, "lower_value": 99.0, "upper_value": 101.0 },
    });
    assert_eq!(bencher["models[m]"], expected);
    assert_eq!(bencher["models[m].accuracy"]["rank1"]["value"], 0.5);
}

#[test]
fn a_starter_holds_for_the_results_that_it_is_from() {
    let one = bench(100.0, |_| {});
    let text = starter(&one).expect("limits");
    for line in [
        "figure = \"models[m].p50_us\" # now 100",
        "ratio_at_least = 0.8",
        "figure = \"models[m].accuracy.rank1\" # now 0.5",
        "at_least = 0.48",
    ] {
        assert!(text.lines().any(|found| found == line), "{line}: {text}");
    }
    let found = report(
        &text,
        std::slice::from_ref(&one),
        std::slice::from_ref(&one),
    );
    assert_eq!(found.expect("judged").outcome, Holds);
    // Alone too, on a busy machine and where a window has no interval.
    let busy = bench(100.0, |value| {
        value["models"][0]["others_busy"] = json!(0.5);
    });
    let one_window = bench(100.0, |value| {
        value["models"][0]["window_mean_us"] = json!([100.0]);
    });
    for alone in [one, busy, one_window] {
        let text = starter(&alone).expect("limits");
        let found = report(&text, &[alone], &[]).expect("judged");
        assert_eq!(found.outcome, Holds, "{text}");
        assert_eq!(found.limits.len(), 4);
    }
    let mut scored = score([5; 10]);
    scored.value["recognizers"][0]["non_finite"] = json!(3);
    let text = starter(&scored).expect("limits");
    assert!(text.contains("recognizers[m].rank1"), "{text}");
    let found = report(&text, &[scored], &[]).expect("judged");
    assert_eq!((found.outcome, found.limits.len()), (Holds, 2));
}

#[test]
fn other_results_have_a_limit_on_each_value_with_a_better_direction() {
    let of = |value: Value| ResultFile {
        value,
        ..score([5; 10])
    };
    let found = of(json!({
        "points": [
            { "name": "a", "pack_bytes": 1000, "jaccard": 0.91, "rank1_delta": -0.03, "frames": 8 },
            { "name": "b", "pack_bytes": 1890, "jaccard": 0.98, "rank1_delta": 0.0, "frames": 16 },
        ],
        "a.b": { "geis_per_second": 41.0, "rank1": 0.5, "rank1_low": 0.4, "rank1_high": 0.6 },
        "not": [{ "p50_us": null }, { "p50_us": 1.0 }],
        "settings": { "size_bytes": 1 },
    }));
    let text = starter(&found).expect("limits");
    let limits: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    // The worst of a list counts.
    let expected = "
[[limit]]
figure = '\"a.b\".geis_per_second' # now 41
at_least = 13
ratio_at_least = 0.8

[[limit]]
figure = '\"a.b\".rank1' # now 0.5
at_least = 0.48
not_worse = true

[[limit]]
figure = \"points[*].jaccard\" # now 0.91
at_least = 0.89
not_worse = true

[[limit]]
figure = \"points[*].pack_bytes\" # now 1,890
at_most = 2100

[[limit]]
figure = \"points[*].rank1_delta\" # now -0.03
at_least = -0.05
not_worse = true";
    assert_eq!(limits.join("\n"), expected);
    let judged = report(&text, &[found], &[]).expect("judged");
    assert_eq!((judged.outcome, judged.limits.len()), (Holds, 8));
    let nothing = of(json!({ "rows": 3, "settings": { "p50_us": 1.0 } }));
    let said = starter(&nothing).expect_err("no values").to_string();
    assert!(
        said.contains("expected results with a time, a size or a rate, found those of score"),
        "{said}"
    );
}

#[test]
fn limits_beside_a_baseline_can_be_left_out_before_there_is_one() {
    let path = Path::new("limits.toml");
    let text = format!("{SLOWER}at_most = 200\n");
    let limits = GateLimits::parse(path, &text).expect("limits");
    let runs = [bench(100.0, |_| {})];
    let judged = JudgedRuns {
        runs: &runs,
        baselines: &[],
        without_baseline: true,
        is_busy: false,
        now: SystemTime::UNIX_EPOCH,
    };
    let found = gate(path, &limits, &judged, ResultHeader::new("gate", 1)).expect("judged");
    assert_eq!(found.limits.len(), 1);
    assert_eq!(
        found.header.warnings,
        ["1 limit relative to a baseline left out, because there is none"]
    );
}

#[test]
fn what_is_doubtful_in_one_run_or_cut_does_not_decide() {
    let busy = |value: &mut Value| value["models"][0]["others_busy"] = json!(0.5);
    let before = [bench(100.0, |_| {}), bench(20.0, busy)];
    // The busy run does not count where there is a quiet one.
    assert_eq!(outcomes(SLOWER, &[bench(100.0, |_| {})], &before), [Holds]);
    let rank1 = "[[limit]]\nfigure = \"models.accuracy.rank1\"\nnot_worse = true\n";
    let cut = |value: &mut Value| {
        value["models"][0]["accuracy"]["viewpoints"] = json!(9);
        value["models"][0]["accuracy"]["viewpoints_planned"] = json!(703);
    };
    let found = report(rank1, &[bench(1.0, cut)], &[bench(1.0, |_| {})]).expect("judged");
    assert_eq!(found.limits[0].outcome, CannotTell);
    let why = found.limits[0].why.as_deref().expect("a reason");
    assert!(why.contains("9 of 703 viewpoints"), "{why}");
    // Two equal runs have the interval of each.
    let by_interval =
        "[[limit]]\nfigure = \"models.accuracy.rank1\"\nat_least = 0.45\njudge = \"interval\"\n";
    let twice = [bench(1.0, |_| {}), bench(1.0, |_| {})];
    assert_eq!(outcomes(by_interval, &twice, &[]), [CannotTell]);
}

#[test]
fn a_model_of_another_name_is_the_one_that_is_meant() {
    let renamed = bench(100.0, |value| value["models"][0]["name"] = json!("v2"));
    assert_eq!(
        outcomes(SLOWER, &[renamed], &[bench(100.0, |_| {})]),
        [Holds]
    );
}
