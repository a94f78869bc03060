//! Makes the correlations of scores in src/guide/results.md: of drawn walks, and of silhouettes from
//! other software.
//!
//! The other set shows skinned bodies in motion capture. EdgeGait draws the same captures, and the
//! same recognizers are scored on both, for each pair of viewpoints.

use crate::command::done;
use crate::data::given;
use crate::means::mean;
use crate::people::rows;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// Returns the clips of the people of the other set.
fn sources(data: &Path) -> BTreeSet<String> {
    let rows = rows(&data.join("reallike/manifest.csv"));
    let open = rows.iter().filter(|row| row["split"] == "open");
    open.map(|row| data.join("mocap/clips").join(&row["source"]))
        .map(|path| path.display().to_string())
        .collect()
}

/// Returns the rank-1 of both sets for each pair of different viewpoints that both have.
fn pairs(real: &Value, twin: &Value) -> Vec<(f64, f64)> {
    let (real, twin) = (&real["cross_view"], &twin["cross_view"]);
    let views = |set: &Value| set["views"].as_array().expect("a list").clone();
    let (of_real, of_twin) = (views(real), views(twin));
    let place = |view: &Value| {
        of_twin
            .iter()
            .position(|other| other == view)
            .expect("seen")
    };
    let cell = |set: &Value, row: usize, column: usize| {
        set["rank1"][row][column].as_f64().expect("somebody met")
    };
    let mut found = Vec::new();
    for (row, from) in of_real.iter().enumerate() {
        for (column, to) in of_real.iter().enumerate().filter(|(at, _)| *at != row) {
            let twin = cell(twin, place(from), place(to));
            found.push((cell(real, row, column), twin));
        }
    }
    found
}

/// Returns Pearson's correlation coefficient.
fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let of = |of: fn(&(f64, f64)) -> f64| mean(pairs.iter().map(of));
    let (x, y) = (of(|pair| pair.0), of(|pair| pair.1));
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        pairs.iter().map(|pair| of(pair.0 - x, pair.1 - y)).sum()
    };
    sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt()
}

mod slow_of_data {
    use super::*;

    /// The order of difficulty of pairs of viewpoints carries over (measured correlations 0.88,
    /// 0.72, 0.72); the level does not (11 to 21 points apart).
    #[test]
    #[ignore = "slow without optimisation; needs EDGEGAIT_DATA"]
    fn what_is_hard_for_the_twins_is_hard_for_the_others() {
        let data = given();
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path();
        let sources = sources(&data);
        let mut import = vec!["import"];
        import.extend(sources.iter().map(String::as_str));
        import.extend([
            "--subject-from",
            "folder",
            "--cycles",
            "mean",
            "--out",
            "twins.egp",
        ]);
        done(at, &import);
        let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
        let model = |name: &str| models.join(name).display().to_string();
        let (side, spread) = (model("side.onnx"), model("spread.onnx"));
        let score = |data: &str, more: &[&str]| -> Value {
            let arguments = ["score", "pixels", &side, &spread, data, "--json", "-"];
            let protocol = ["--protocol", "cross-view"];
            let text = done(at, &[&arguments[..], &protocol, more].concat());
            serde_json::from_str(&text).expect("JSON")
        };
        let real = score(&data.join("reallike").display().to_string(), &[]);
        let seen = [
            "--azimuth-deg",
            "0,45,90,135,180",
            "--elevation-deg",
            "0,15",
            "--lens",
            "persp",
            "--distance-m",
            "6",
        ];
        let twins = score("twins.egp", &seen);
        for recognizer in 0..3 {
            let of = |results: &Value| results["recognizers"][recognizer].clone();
            let (real, twins) = (of(&real), of(&twins));
            let pairs = pairs(&real["probe_sets"][0], &twins["probe_sets"][0]);
            let found = correlation(&pairs);
            let apart = mean(pairs.iter().map(|(a, b)| (a - b).abs()));
            println!(
                "{}: rank-1 {:.1} % (others), {:.1} % (twins); {} pairs of viewpoints, correlation {found:.2}, {:.0} points apart",
                real["name"],
                100.0 * real["rank1"].as_f64().expect("a rate"),
                100.0 * twins["rank1"].as_f64().expect("a rate"),
                pairs.len(),
                100.0 * apart,
            );
            assert_eq!(pairs.len(), 90);
            assert!(found > 0.6, "{found}");
        }
    }
}
