//! Tests of limits on criterion's results: ratios, sizes, and results that are too old.

use super::*;
use serde_json::json;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::PathBuf;
use std::time::Duration;
use tempfile::TempDir;

/// A package whose code was changed two hours ago, and results of its benchmarks.
struct Fixture {
    folder: TempDir,
    now: SystemTime,
}

impl Fixture {
    fn new() -> Self {
        Self::with_code_changed(120)
    }

    fn with_code_changed(minutes_ago: u64) -> Self {
        let fixture = Self {
            folder: tempfile::tempdir().expect("a folder"),
            now: SystemTime::UNIX_EPOCH + Duration::from_hours(500_000),
        };
        for file in [
            "Cargo.toml",
            "Cargo.lock",
            "src/lib.rs",
            "src/draw/sweep/mod.rs",
            "no_std_core/Cargo.toml",
            "no_std_core/src/lib.rs",
            "benches/common/mod.rs",
            "benches/raster.rs",
            "benches/score.rs",
        ] {
            fixture.write(file, "", minutes_ago);
        }
        fixture
    }

    /// Writes a file with a modification time this many minutes ago.
    fn write(&self, name: &str, text: &str, minutes_ago: u64) {
        let path = self.folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a new folder");
        fs::write(&path, text).expect("a new file");
        let file = File::options().write(true).open(path).expect("the file");
        let changed = self.now - Duration::from_mins(minutes_ago);
        file.set_modified(changed).expect("its time is ours");
    }

    fn criterion(&self) -> PathBuf {
        self.folder.path().join("criterion")
    }

    /// Writes files of a benchmark.
    fn result(self, id: &str, estimates: &Value, throughput: &Value, minutes_ago: u64) -> Self {
        let benchmark = json!({ "group_id": "raster", "full_id": id, "throughput": throughput });
        let new = format!("criterion/{id}/new");
        let estimates = estimates.to_string();
        self.write(&format!("{new}/estimates.json"), &estimates, minutes_ago);
        self.write(
            &format!("{new}/benchmark.json"),
            &benchmark.to_string(),
            minutes_ago,
        );
        self
    }

    /// Writes the parts of criterion 0.8.2's results of one benchmark that are read.
    fn measured(self, id: &str, median_ns: f64, throughput: &Value, minutes_ago: u64) -> Self {
        let interval = json!({
            "confidence_level": 0.95, "lower_bound": 0.9 * median_ns, "upper_bound": 1.1 * median_ns,
        });
        let estimates = json!({
            "mean": { "point_estimate": 1e9, "standard_error": 1.5 },
            "median": { "confidence_interval": interval, "point_estimate": median_ns },
            "slope": null,
        });
        self.result(id, &estimates, throughput, minutes_ago)
    }

    /// Writes a result of ten minutes ago that counts no elements.
    fn median(self, id: &str, median_ns: f64) -> Self {
        self.measured(id, median_ns, &Value::Null, 10)
    }

    /// Writes a size of ten minutes ago.
    fn bytes(self, id: &str, bytes: u32) -> Self {
        let estimates = json!({ "bytes": { "point_estimate": bytes } });
        self.result(id, &estimates, &Value::Null, 10)
    }

    /// Judges by the values with what the shipped limits say of fresh results.
    fn report(&self, limits: &str) -> Result<GateReport> {
        let (_, shipped) = SHIPPED.split_once("[criterion]").expect("a table");
        let (fresh, _) = shipped.split_once("[[limit]]").expect("a limit");
        let text = format!("judge = \"value\"\n[criterion]{fresh}{limits}");
        let path = self.folder.path().join("benches/gates.toml");
        let judged = JudgedRuns {
            runs: &[ResultFile::read(&self.criterion())?],
            baselines: &[],
            without_baseline: false,
            is_busy: true,
            now: self.now,
        };
        let limits = GateLimits::parse(&path, &text).expect("limits");
        gate(&path, &limits, &judged, ResultHeader::new("gate", 1))
    }

    /// Returns whether all limits hold, and the table.
    fn check(&self, limits: &str) -> (bool, String) {
        let report = self.report(limits).expect("judged");
        assert_ne!(report.outcome, CannotTell, "the value decides");
        (report.outcome == Holds, report.to_string())
    }

    /// Returns the reason why a limit cannot be judged.
    fn unknown(&self, limits: &str) -> String {
        self.report(limits).expect_err("unknown").to_string()
    }
}

const SHIPPED: &str = include_str!("../../../../benches/gates.toml");

/// Returns a limit of this value of `raster/old`, divided by that of `raster/new`.
fn ratio_of(key: &str, at_least: &str) -> String {
    format!(
        "[[limit]]\nname = \"rows\"\nreason = \"rows are faster\"\nfigure = \"benchmarks[raster/old].{key}\"\n\
         per = \"benchmarks[raster/new].{key}\"\nat_least = {at_least}\n"
    )
}

fn ratio(at_least: &str) -> String {
    ratio_of("median_ns", at_least)
}

/// Returns a limit of the size `bytes/heap`.
fn heap(at_most: u32) -> String {
    format!("[[limit]]\nfigure = \"benchmarks[bytes/heap].bytes\"\nat_most = {at_most}\n")
}

/// Returns results in which `raster/old` takes ten times as long as `raster/new`.
fn ten_times() -> Fixture {
    let fixture = Fixture::new();
    fixture
        .median("raster/old", 1000.0)
        .median("raster/new", 100.0)
}

#[test]
fn a_ratio_is_of_medians() {
    let fixture = ten_times();
    for limit in ["8", "2.5"] {
        let (holds, table) = fixture.check(&ratio(limit));
        assert!(holds, "{table}");
        let row = format!("holds  rows    10 (8.182 to 12.22)  at least {limit}");
        assert!(table.contains(&row), "{table}");
    }
}

#[test]
fn a_number_at_its_limit_holds_and_one_beyond_it_is_missed_with_its_reason() {
    let fixture = ten_times();
    assert!(fixture.check(&ratio("10.0")).0);
    let (holds, table) = fixture.check(&ratio("10.5"));
    assert!(!holds);
    assert!(table.contains("missed  rows"), "{table}");
    assert!(table.contains("rows are faster"), "{table}");
}

#[test]
fn the_interval_of_a_ratio_spans_those_of_its_sides() {
    let limit = format!("{}judge = \"interval\"\n", ratio("10.0"));
    let report = ten_times().report(&limit).expect("judged");
    assert_eq!(report.outcome, CannotTell, "{report}");
    let line = &report.limits[0];
    assert_eq!(
        line.per.as_deref(),
        Some("benchmarks[raster/new].median_ns")
    );
    let measures = &report.bencher()["benchmarks[raster/old]"];
    let measure = &measures["median_ns per benchmarks[raster/new].median_ns"];
    assert_eq!(measure["value"], 10.0, "{measures}");
}

#[test]
fn benchmarks_that_count_elements_are_compared_for_each_element() {
    // 20 us for one element, and 5 us for each of 64: four times.
    let fixture = Fixture::new()
        .measured("raster/old", 20_000.0, &json!({ "Elements": 1 }), 10)
        .measured("raster/new", 320_000.0, &json!({ "Elements": 64 }), 10);
    let (holds, table) = fixture.check(&ratio_of("per_element_ns", "4"));
    assert!(holds && table.contains("rows    4 (3.273 to"), "{table}");
    assert!(!fixture.check(&ratio_of("per_element_ns", "4.1")).0);
    let both = json!({ "ElementsAndBytes": { "elements": 32, "bytes": 1 } });
    let fixture = fixture.measured("raster/new", 320_000.0, &both, 10);
    let (_, table) = fixture.check(&ratio_of("per_element_ns", "1"));
    assert!(table.contains("rows    2 (1.636 to"), "{table}");
    let mixed = ratio_of("median_ns", "4").replace("old].median_ns", "old].per_element_ns");
    assert!(fixture.unknown(&mixed).contains("both or neither"));
}

#[test]
fn benchmarks_of_which_one_counts_elements_are_not_compared() {
    let old = || Fixture::new().measured("raster/old", 20_000.0, &json!({ "Elements": 1 }), 10);
    for fixture in [
        old().median("raster/new", 10.0),
        old().measured("raster/new", 10.0, &json!({ "Bytes": 64 }), 10),
        old().measured("raster/new", 10.0, &json!({ "Elements": 0 }), 10),
    ] {
        let unknown = fixture.unknown(&ratio("4"));
        assert!(
            unknown.contains("both or neither to count elements"),
            "{unknown}"
        );
        let unknown = fixture.unknown(&ratio_of("per_element_ns", "4"));
        let lacks = "benchmarks[raster/new] has no \"per_element_ns\"";
        assert!(unknown.contains(lacks), "{unknown}");
    }
}

#[test]
fn a_sum_counts_each_part_as_often_as_the_whole_does_it() {
    // 10 x 50 + 3 x 100 = 800, and 1000 is 1.25 times as much.
    let limit = "[[limit]]\nfigure = \"benchmarks[score/all].median_ns\"\nat_most = 1.25\n[limit.per]\n\
                 \"benchmarks[raster/old].median_ns\" = 10\n\"benchmarks[raster/new].median_ns\" = 3\n";
    let fixture = Fixture::new();
    let fixture = fixture
        .median("raster/old", 50.0)
        .median("raster/new", 100.0);
    let fixture = fixture.median("score/all", 1000.0);
    let (holds, table) = fixture.check(limit);
    let named = "benchmarks[score/all].median_ns per 3 x benchmarks[raster/new].median_ns + 10 x benchmarks[raster/old].median_ns";
    assert!(
        holds && table.contains(named) && table.contains("1.25 ("),
        "{table}"
    );
    // Parts of a sum may count elements: it is of iterations.
    let fixture = fixture.measured("raster/old", 50.0, &json!({ "Elements": 7 }), 10);
    assert!(fixture.check(limit).0);
    let fixture = fixture.median("score/all", 1250.0);
    let (holds, table) = fixture.check(limit);
    assert!(!holds && table.contains("1.562 ("), "{table}");
}

#[test]
fn bytes_are_within_their_limit_up_to_the_last_one() {
    // Window, path, 64 edges of 80 bytes; 65 runs of 2 bytes and 65 bytes of coverage.
    let skia = 4_096 + 334 + 5_120 + 195;
    let fixture = Fixture::new().bytes("bytes/heap", skia);
    fixture.write("benches/bytes.rs", "", 120);
    assert!(fixture.check(&heap(skia)).0);
    assert!(!fixture.check(&heap(skia - 1)).0);
}

#[test]
fn a_limit_of_0_bytes_holds_for_none_and_is_missed_by_any() {
    let fixture = Fixture::new().bytes("bytes/heap", 0);
    fixture.write("benches/bytes.rs", "", 120);
    assert!(fixture.check(&heap(0)).0);
    assert!(!fixture.bytes("bytes/heap", 1).check(&heap(0)).0);
}

#[test]
fn a_limit_that_needs_what_the_machine_lacks_is_skipped_even_without_results() {
    let fixture = ten_times();
    let other = ratio("8").replace("raster/old", "none");
    // The machine of the fixture is busy.
    let needy = format!("{other}needs = \"two-threads\"\n{}", ratio("8"));
    let report = fixture.report(&needy).expect("judged");
    assert_eq!((report.outcome, report.limits.len()), (Holds, 1));
    let skipped = "rows: skipped: this machine has no idle second thread";
    assert_eq!(report.header.warnings, [skipped]);
    assert!(fixture.unknown(&other).contains("[none]"));
    // No processor has both.
    let both = ["avx2", "neon"].map(|need| format!("{}needs = \"{need}\"\n", ratio("8")));
    let report = fixture.report(&both.concat()).expect("judged");
    assert!(!report.header.warnings.is_empty());
    // If no limit is left, nothing is decided.
    let only = format!("{}needs = \"two-threads\"\n", ratio("8"));
    let report = fixture.report(&only).expect("judged");
    assert_eq!(report.outcome, CannotTell);
}

#[test]
fn a_missing_result_names_the_benchmark_to_run() {
    let fixture = Fixture::new().median("raster/old", 1000.0);
    let unknown = fixture.unknown(&ratio("8"));
    let expected =
        "criterion: benchmarks: expected one element for [raster/new], found 0 among raster/old";
    assert!(unknown.contains(expected), "{unknown}");
    let folder = tempfile::tempdir().expect("a folder");
    let said = ResultFile::read(folder.path()).expect_err("empty");
    let expected = "expected criterion's results (NAME/new/estimates.json), found none";
    assert!(said.to_string().ends_with(expected), "{said}");
}

#[test]
fn a_result_that_is_not_criterions_is_refused() {
    let fixture = ten_times().result("raster/bad", &json!({ "median": 3 }), &Value::Null, 10);
    let said = fixture.unknown(&ratio("8"));
    let expected = "raster/bad/new/estimates.json: expected criterion's JSON: invalid type";
    assert!(said.contains(expected), "{said}");
    let fixture = ten_times().median("raster/bad", 0.0);
    let said = fixture.unknown(&ratio("8"));
    let expected = "expected a median above 0 ns, found 0";
    assert!(said.contains(expected), "{said}");
    // Results without a time of measurement are not criterion's.
    let limits = "[criterion]\n[[limit]]\nfigure = \"models.p50_us\"\nat_most = 200\n";
    let said = report(limits, &[bench(100.0, |_| {})], &[]).expect_err("bench");
    let expected = "[criterion]: expected criterion's results, found others";
    assert!(said.to_string().contains(expected), "{said}");
}

#[test]
fn a_result_of_yesterday_is_refused() {
    let minutes = 24 * 60 + 1;
    let fixture = Fixture::with_code_changed(2 * minutes).median("raster/new", 100.0);
    let fixture = fixture.measured("raster/old", 1000.0, &Value::Null, minutes);
    let unknown = fixture.unknown(&ratio("8"));
    assert!(unknown.contains("the last 24 hours"), "{unknown}");
}

#[test]
fn a_result_older_than_the_code_it_measured_is_refused() {
    for changed in ["src/draw/sweep/mod.rs", "benches/raster.rs", "Cargo.lock"] {
        let fixture = ten_times();
        fixture.write("benches/score.rs", "", 9);
        assert!(fixture.check(&ratio("8")).0, "another benchmark's code");
        fixture.write(changed, "", 9);
        let unknown = fixture.unknown(&ratio("8"));
        let named = changed.trim_start_matches("benches/");
        let again = format!("{named} (run the benchmark raster again)");
        assert!(unknown.contains(&again), "{unknown}");
    }
}

#[test]
fn results_of_different_runs_are_not_compared() {
    let fixture = Fixture::with_code_changed(600);
    let fixture = fixture.measured("raster/old", 1000.0, &Value::Null, 131);
    let fixture = fixture.median("raster/new", 100.0);
    let unknown = fixture.unknown(&ratio("8"));
    let expected = "raster/old and raster/new: expected results at most 2 hours apart";
    assert!(unknown.contains(expected), "{unknown}");
}

#[test]
fn each_benchmark_is_compared_with_that_of_the_baseline() {
    let limits = "[[limit]]\nfigure = \"benchmarks[*].median_ns\"\nratio_at_most = 1.5\n";
    let read = |fixture: Fixture| [ResultFile::read(&fixture.criterion()).expect("results")];
    let slower = Fixture::new()
        .median("raster/old", 1000.0)
        .median("raster/new", 200.0);
    let before = read(ten_times());
    assert_eq!(outcomes(limits, &read(slower), &before), [Missed, Holds]);
    let text = starter(&before[0]).expect("limits");
    assert!(
        text.contains("\"benchmarks[raster/old].median_ns\" # now 1,000\nat_most = 3300\nratio_at_most = 1.2\n"),
        "{text}"
    );
    let found = report(&text, &before, &before).expect("judged");
    assert_eq!(found.limits.len(), 4);
    // Without a baseline, the own bound of each is judged.
    let found = report(&text, &before, &[]).expect("judged");
    assert_eq!((found.limits.len(), found.outcome), (2, Holds));
}

#[test]
fn the_shipped_limits_are_on_benchmarks_of_files_that_exist() {
    let limits = GateLimits::parse(Path::new("gates.toml"), SHIPPED).expect("shipped limits");
    let limits = limits.limits;
    assert_eq!(limits.len(), 26);
    let named: BTreeSet<&str> = limits
        .iter()
        .filter_map(|limit| limit.name.as_deref())
        .collect();
    assert_eq!(named.len(), limits.len(), "each name once: {named:?}");
    let is_told = |limit: &GateLimit| {
        limit
            .reason
            .as_ref()
            .is_some_and(|it| !it.trim().is_empty())
    };
    assert!(limits.iter().all(is_told), "each has a reason");
    // Found without the parser.
    let lines = SHIPPED.lines().filter(|line| !line.starts_with('#'));
    let benchmarks = lines.filter_map(|line| line.split_once("benchmarks[")?.1.split_once(']'));
    let benchmarks: BTreeSet<&str> = benchmarks.map(|(name, _)| name).collect();
    assert!(benchmarks.contains("sweep/skia-threads-2/19-views"));
    for id in benchmarks {
        let bench = id.split('/').next().expect("a first word");
        let path = format!("{}/benches/{bench}.rs", env!("CARGO_MANIFEST_DIR"));
        assert!(Path::new(&path).exists(), "{id}: no {path}");
    }
}
