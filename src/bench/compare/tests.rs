use super::*;
use crate::report::SVG_START;
use crate::report::text_extent::assert_texts_are_readable;
use serde_json::{Value, json};

/// Returns the results of one model with this median time.
fn results(p50_us: f64, change: impl FnOnce(&mut Value)) -> BenchResults {
    let times = |us: f64| {
        json!({
            "calls": 100, "min_us": us, "mean_us": us, "sd_us": 0.0, "p50_us": us, "p90_us": us,
            "max_us": us, "throughput": 1e6 / us, "spread": 0.02,
            "window_mean_us": [0.99 * us, us, us, us, 1.01 * us],
        })
    };
    let mut model = times(p50_us);
    let more = json!({
        "name": "m", "runtime": { "name": "rten", "version": "1", "provider": "cpu" }, "threads": 1,
        "input": [1, 1, 50, 30], "bytes": 10, "params": 5, "runtime_load_ms": 0.1, "load_ms": 2.0,
        "first_ms": 1.0, "peak_rss_over_baseline_bytes": 1000,
        "parts": { "preprocessing": times(5.0), "end_to_end": times(9.0) },
        "accuracy": {
            "protocol": "first-take", "viewpoints": 703, "probes": 26, "rank1": 0.5, "rank1_low": 0.4,
            "rank1_high": 0.6, "rank1_wilson_low": 0.3, "rank1_wilson_high": 0.7, "non_finite": 0,
        },
        "conditions": { "start": { "clocks": [] }, "end": { "clocks": [] } }, "warnings": [],
    });
    let offline = json!({ "batch": 64, "batch_planned": 64 });
    let mut batch = times(40.0 * p50_us);
    let join = |into: &mut Value, more: Value| {
        let into = into.as_object_mut().expect("an object");
        into.extend(more.as_object().expect("an object").clone());
    };
    join(&mut batch, offline);
    join(&mut model, more);
    model["offline"] = batch;
    let mut value = json!({
        "schema": 1, "command": "bench", "version": "0.1.0", "seed": 1, "inputs": [],
        "settings": { "views": "paper", "raster": "skia", "pack": "built-in cohort", "build": "release" },
        "warnings": [], "date": "2026-11-25T00:00:00Z",
        "board": { "architecture": "aarch64", "cpus": [], "features": [] },
        "models": [model],
    });
    change(&mut value);
    serde_json::from_value(value).expect("results of bench")
}

fn compared(others: impl IntoIterator<Item = BenchResults>) -> Compared {
    let first = ("pi4".to_owned(), results(200.0, |_| {}));
    let others = (5..).zip(others).map(|(at, one)| (format!("pi{at}"), one));
    Compared {
        boards: std::iter::once(first).chain(others).collect(),
    }
}

#[test]
fn ratios_are_against_the_first_board_with_the_model() {
    let other = results(50.0, |value| {
        let model = value["models"][0].clone();
        value["models"].as_array_mut().expect("models").push(model);
        value["models"][1]["name"] = json!("n");
    });
    let compared = compared([results(100.0, |_| {}), other]);
    compared.check().expect("alike");
    let text = compared.render(TableFormat::Markdown);
    let line = |start: &str| {
        let line = text.lines().rfind(|line| line.starts_with(start));
        line.unwrap_or_else(|| panic!("{start}: {text}")).to_owned()
    };
    assert_eq!(line("| relative to"), "| relative to | pi4 | pi4 |");
    // 0.5 times 0.99 / 1.01, and times 1.01 / 0.99.
    assert_eq!(
        line("| one at a time: p50"),
        "| one at a time: p50 | 0.50 (0.49 - 0.51) | 0.25 (0.25 - 0.26) |"
    );
    assert_eq!(
        line("| a batch: p50"),
        "| a batch: p50 | 0.50 (0.49 - 0.51) | 0.25 (0.25 - 0.26) |"
    );
    assert_eq!(line("| load |"), "| load | 1.00 | 1.00 |");
}

#[test]
fn results_that_are_not_comparable_are_refused() {
    type Change = fn(&mut Value);
    let cases: [(Change, &str); 7] = [
        (
            |v| v["settings"]["views"] = json!("side"),
            "pi4 and pi5 cannot be compared: rank-1, \"views\": \"paper\" and \"side\"",
        ),
        (
            |v| v["settings"]["raster"] = json!("rows"),
            "\"raster\": \"skia\" and \"rows\"",
        ),
        (|v| v["seed"] = json!(2), "rank-1, the seed: 1 and 2"),
        (
            |v| v["settings"]["pack"] = json!("x"),
            "rank-1, the people: built-in cohort and x",
        ),
        (
            |v| v["models"][0]["accuracy"]["viewpoints"] = json!(9),
            "m of pi4 and of pi5 cannot be compared: viewpoints of rank-1: 703 and 9",
        ),
        (
            |v| v["models"][0]["accuracy"]["protocol"] = json!("p"),
            "protocols of rank-1: first-take and p",
        ),
        (
            |v| v["models"][0]["input"] = json!([1, 1, 64, 44]),
            "inputs: [1, 1, 50, 30] and [1, 1, 64, 44]",
        ),
    ];
    for (change, words) in cases {
        let found = compared([results(100.0, change)]);
        let said = found.check().expect_err(words).to_string();
        assert!(said.contains(words), "{said}");
    }
    // Without rank-1, settings that affect it may differ.
    let views = compared([results(100.0, |v| v["settings"]["views"] = json!("side"))]);
    let without = views.without_accuracy();
    without.check().expect("times alone");
    assert!(!without.render(TableFormat::Text).contains("rank-1"));
    let said = chart(&without).expect_err("no rank-1").to_string();
    assert!(said.contains("results with rank-1"), "{said}");
    // A board without rank-1 does not hide differences between the others.
    let mut three = compared([
        results(100.0, |_| {}),
        results(100.0, |v| v["settings"]["views"] = json!("side")),
    ]);
    three.boards[0].1.models[0].accuracy = None;
    let said = three.check().expect_err("of the others").to_string();
    assert!(said.contains("pi5 and pi6 cannot be compared"), "{said}");
    // Inputs are compared by model, not by board.
    let other_name = compared([results(100.0, |v| {
        v["models"][0]["name"] = json!("n");
        v["models"][0]["input"] = json!([1, 1, 64, 44]);
    })]);
    other_name.check().expect("other models");
}

#[test]
fn the_chart_has_a_point_for_each_model_and_board() {
    let svg = chart(&compared([results(100.0, |_| {}), results(50.0, |_| {})])).expect("a chart");
    assert!(svg.starts_with(SVG_START), "{svg}");
    assert_eq!(svg.matches("<circle").count(), 3);
    assert_texts_are_readable(&svg);
    for entry in [
        "m pi4: 50.0 % (40.0 to 60.0), 200 µs",
        "m pi5: 50.0 % (40.0 to 60.0), 100 µs",
        "m pi6: 50.0 % (40.0 to 60.0), 50.0 µs",
    ] {
        assert!(svg.contains(entry), "{entry}: {svg}");
    }
}

#[test]
fn each_batch_size_has_a_row_in_the_csv_file() {
    let one = results(100.0, |value| {
        let mut more = value["models"][0]["offline"].clone();
        more["batch"] = json!(8);
        value["models"][0]["batches"] = json!([more]);
    });
    let text = String::from_utf8(super::super::csv(&one).expect("a table")).expect("text");
    let lines: Vec<&str> = text.lines().collect();
    assert!(
        lines[0].starts_with("model,runtime,runtime_version,provider,threads,batch,frames,mean_us"),
        "{text}"
    );
    let starts = [
        "m,rten,1,cpu,1,1,,100",
        "m,rten,1,cpu,1,64,,4000",
        "m,rten,1,cpu,1,8,,4000",
    ];
    for (line, start) in lines[1..].iter().zip(starts) {
        assert!(line.starts_with(start), "{text}");
        assert!(line.ends_with(",0.5,0.4,0.6"), "{text}");
    }
    assert_eq!(lines.len(), 4);
}
