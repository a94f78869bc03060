//! Tests of the gates between benchmarks: their arithmetic, and the results that they reject.

#[path = "../../benches/gates/check/mod.rs"]
mod check;

use check::{Gates, Need, Results};
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::Path;
use std::time::{Duration, SystemTime};
use tempfile::TempDir;

const SHIPPED: &str = include_str!("../../benches/gates.toml");

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

    /// Writes the parts of criterion 0.8.2's results of one benchmark that are read.
    fn measured(self, id: &str, median_ns: f64, throughput: &str, minutes_ago: u64) -> Self {
        let estimates = format!(
            r#"{{"mean":{{"point_estimate":1e9,"standard_error":1.5}},
               "median":{{"confidence_interval":{{"confidence_level":0.95}},"point_estimate":{median_ns}}},
               "slope":null}}"#
        );
        let benchmark = format!(r#"{{"group_id":"raster","throughput":{throughput}}}"#);
        let new = format!("criterion/{id}/new");
        self.write(&format!("{new}/estimates.json"), &estimates, minutes_ago);
        self.write(&format!("{new}/benchmark.json"), &benchmark, minutes_ago);
        self
    }

    /// Writes a result of ten minutes ago that counts no elements.
    fn median(self, id: &str, median_ns: f64) -> Self {
        self.measured(id, median_ns, "null", 10)
    }

    /// Returns whether the gates hold on a machine that lacks only AVX-512, and the table without
    /// its first and last line.
    fn check(&self, gates: &str) -> (bool, String) {
        let criterion = self.folder.path().join("criterion");
        let results = Results::new(self.folder.path(), criterion, self.now);
        let gates = parse(gates).expect("gates");
        let report = gates.check(&results, |need| need != Need::Avx512f);
        let table = report.to_string();
        let mut lines: Vec<&str> = table.lines().collect();
        let last = lines.pop().expect("a count");
        assert_eq!(report.passes(), last.starts_with("0 of "), "{table}");
        (report.passes(), lines[1..].join("\n"))
    }

    /// Returns the table with the reason why a gate's number is unknown.
    fn unknown(&self, gates: &str) -> String {
        let (passes, table) = self.check(gates);
        assert!(!passes && table.contains("UNKNOWN"), "{table}");
        table
    }
}

fn parse(gates: &str) -> edgegait::error::Result<Gates> {
    Gates::parse(Path::new("gates.toml"), gates)
}

/// Returns a gate between the benchmarks `raster/old` and `raster/new`.
fn ratio(at_least: &str) -> String {
    format!(
        "[[ratio]]\nname = \"rows\"\nreason = \"rows are faster\"\nslow = \"raster/old\"\nfast = \"raster/new\"\nat_least = {at_least}\n"
    )
}

#[test]
fn a_ratio_is_of_medians_and_its_margin_a_share_of_the_limit() {
    let fixture = Fixture::new();
    let fixture = fixture
        .median("raster/old", 1000.0)
        .median("raster/new", 100.0);
    let [eight, less] = [
        "rows     10.00      >= 8   +25 %",
        "rows     10.00    >= 2.5  +300 %",
    ];
    assert_eq!(fixture.check(&ratio("8")), (true, eight.to_owned()));
    assert_eq!(fixture.check(&ratio("2.5")), (true, less.to_owned()));
}

#[test]
fn a_number_at_its_limit_holds_and_one_beyond_it_is_missed_with_its_reason() {
    let fixture = Fixture::new();
    let fixture = fixture
        .median("raster/old", 1000.0)
        .median("raster/new", 100.0);
    assert!(fixture.check(&ratio("10.0")).0);
    let (passes, table) = fixture.check(&ratio("10.5"));
    assert!(!passes);
    assert!(
        table.contains("-5 %  MISSED\n    rows are faster"),
        "{table}"
    );
}

#[test]
fn benchmarks_that_count_elements_are_compared_for_each_element() {
    // 20 us for one element, and 5 us for each of 64: four times.
    let fixture = Fixture::new()
        .measured("raster/old", 20_000.0, r#"{"Elements":1}"#, 10)
        .measured("raster/new", 320_000.0, r#"{"Elements":64}"#, 10);
    let (passes, table) = fixture.check(&ratio("4"));
    assert!(passes && table.contains("4.00"), "{table}");
}

#[test]
fn benchmarks_of_which_one_counts_elements_are_not_compared() {
    let fixture = Fixture::new()
        .measured("raster/old", 20_000.0, r#"{"Elements":1}"#, 10)
        .median("raster/new", 10.0);
    assert!(
        fixture
            .unknown(&ratio("4"))
            .contains("both or neither to count elements")
    );
    let fixture = fixture.measured("raster/new", 10.0, r#"{"Bytes":64}"#, 10);
    assert!(
        fixture
            .unknown(&ratio("4"))
            .contains("unknown variant `Bytes`")
    );
}

#[test]
fn a_sum_counts_each_part_as_often_as_the_whole_does_it() {
    // 10 x 50 + 3 x 100 = 800, and 1000 is 1.25 times as much.
    let gate = "[[sum]]\nname = \"gei\"\nreason = \"no overhead\"\nwhole = \"score/all\"\nat_most = 1.25\n\
                parts = { \"raster/old\" = 10, \"raster/new\" = 3 }";
    let fixture = Fixture::new();
    let fixture = fixture
        .median("raster/old", 50.0)
        .median("raster/new", 100.0);
    let fixture = fixture.median("score/all", 1000.0);
    let (passes, table) = fixture.check(gate);
    assert!(
        passes && table.contains("1.25   <= 1.25    +0 %"),
        "{table}"
    );
    let fixture = fixture.median("score/all", 1250.0);
    let (passes, table) = fixture.check(gate);
    assert!(
        !passes && table.contains("1.56   <= 1.25   -25 %  MISSED"),
        "{table}"
    );
}

#[test]
fn bytes_are_made_from_the_library() {
    // Window, path, 64 edges of 80 bytes; 65 runs of 2 bytes and 65 bytes of coverage.
    let heap = 4_096 + 334 + 5_120 + 195;
    let gate = |at_most: u32| {
        format!(
            "[[bytes]]\nname = \"heap\"\nreason = \"small\"\nfigure = \"skia-heap\"\nat_most = {at_most}"
        )
    };
    let fixture = Fixture::new();
    assert!(fixture.check(&gate(heap)).0);
    assert!(!fixture.check(&gate(heap - 1)).0);
}

#[test]
fn a_limit_of_0_bytes_holds_for_none_and_is_missed_by_any() {
    let gate = |figure: &str| {
        format!("[[bytes]]\nname = \"heap\"\nreason = \"none\"\nfigure = \"{figure}\"\nat_most = 0")
    };
    let (passes, table) = Fixture::new().check(&gate("rows-heap"));
    assert!(passes && table.contains("0      <= 0    +0 %"), "{table}");
    assert!(!Fixture::new().check(&gate("skia-heap")).0);
}

#[test]
fn a_gate_that_needs_what_the_machine_lacks_is_skipped_even_without_results() {
    let gate = |need: &str| format!("{}needs = \"{need}\"", ratio("8"));
    let fixture = Fixture::new();
    let skipped = "rows  skipped: this machine has no AVX-512".to_owned();
    assert_eq!(fixture.check(&gate("avx512f")), (true, skipped));
    assert!(!fixture.check(&gate("avx2")).0);
}

#[test]
fn a_processor_with_avx_512_has_avx2() {
    assert!(Need::Avx2.is_met() || !Need::Avx512f.is_met());
}

#[test]
fn a_missing_result_names_the_benchmark_to_run() {
    let fixture = Fixture::new().median("raster/old", 1000.0);
    let unknown = fixture.unknown(&ratio("8"));
    let expected = "criterion/raster/new/new/estimates.json: expected a result, found none (run cargo bench --bench raster)";
    assert!(unknown.contains(expected), "{unknown}");
}

#[test]
fn a_result_of_yesterday_is_refused() {
    let minutes = 24 * 60 + 1;
    let fixture = Fixture::new().median("raster/new", 100.0);
    let fixture = fixture.measured("raster/old", 1000.0, "null", minutes);
    let unknown = fixture.unknown(&ratio("8"));
    assert!(unknown.contains("the last 24 hours"), "{unknown}");
}

#[test]
fn a_result_older_than_the_code_it_measured_is_refused() {
    for changed in ["src/draw/sweep/mod.rs", "benches/raster.rs", "Cargo.lock"] {
        let fixture = Fixture::new();
        let fixture = fixture
            .median("raster/old", 1000.0)
            .median("raster/new", 100.0);
        fixture.write("benches/score.rs", "", 9);
        assert!(fixture.check(&ratio("8")).0, "another benchmark's code");
        fixture.write(changed, "", 9);
        let unknown = fixture.unknown(&ratio("8"));
        let again = format!("{changed} (run cargo bench --bench raster again)");
        assert!(unknown.contains(&again), "{unknown}");
    }
}

#[test]
fn results_of_different_runs_are_not_compared() {
    let fixture = Fixture::with_code_changed(600);
    let fixture = fixture.measured("raster/old", 1000.0, "null", 131);
    let fixture = fixture.median("raster/new", 100.0);
    let unknown = fixture.unknown(&ratio("8"));
    let expected = "raster/old and raster/new: expected results at most 2 hours apart";
    assert!(unknown.contains(expected), "{unknown}");
}

#[test]
fn a_list_with_a_mistake_is_refused_with_its_line() {
    let good = ratio("8");
    for (gates, expected) in [
        (
            good.replace("slow", "slower"),
            "gates.toml:4: unknown field `slower`",
        ),
        (
            good.replace("at_least = 8", ""),
            "gates.toml:1: missing field `at_least`",
        ),
        (
            ratio("-8"),
            "gates.toml:6: expected a limit above 0, found -8",
        ),
        (
            ratio("nan"),
            "gates.toml:6: expected a limit above 0, found NaN",
        ),
        (
            format!("{good}needs = \"sse\""),
            "gates.toml:7: unknown variant `sse`",
        ),
        (
            format!("{good}{good}"),
            "gates.toml: rows: expected each name once",
        ),
        (
            good.replace("rows are faster", " "),
            "gates.toml: rows: expected a reason",
        ),
        (
            "[[sum]]\nname = \"gei\"\nreason = \"r\"\nwhole = \"gei/a\"\nparts = {}\nat_most = 1"
                .to_owned(),
            "gates.toml: gei: expected at least one part",
        ),
    ] {
        let error = parse(&gates).expect_err(expected).to_string();
        assert!(error.starts_with(expected), "{error}");
    }
}

/// Returns the benchmarks that a list names, found without its parser.
fn benchmarks(gates: &str) -> BTreeSet<String> {
    let names = gates.lines().filter(|line| !line.starts_with('#'));
    let names = names.flat_map(|line| line.split('"').skip(1).step_by(2));
    let names = names.filter(|name| name.contains('/') && !name.contains(' '));
    names.map(str::to_owned).collect()
}

#[test]
fn the_shipped_gates_are_between_benchmarks_of_files_that_exist() {
    parse(SHIPPED).expect("the shipped gates");
    let named = benchmarks(SHIPPED);
    assert!(named.contains("sweep/skia-threads-2/19-views"), "{named:?}");
    for id in named {
        let bench = id.split('/').next().expect("a first word");
        let path = format!("{}/benches/{bench}.rs", env!("CARGO_MANIFEST_DIR"));
        assert!(Path::new(&path).exists(), "{id}: no {path}");
    }
}
