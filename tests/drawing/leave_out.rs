//! Tests of `edgegait score --protocol leave-one-take-out`.

use crate::command::{done, refused};

#[test]
fn every_take_is_a_probe_against_all_others_at_its_viewpoint() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    done(at, &["cohort", "--people", "4", "--out", "four.egp"]);
    let score = |walks: &str| {
        let text = done(
            at,
            &[
                "score",
                "pixels",
                "four.egp",
                "--protocol",
                "leave-one-take-out",
                "--walks",
                walks,
                "--azimuth-deg",
                "0,90",
                "--elevation-deg",
                "0",
                "--raster",
                "rows",
                "--json",
                "-",
            ],
        );
        let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        json["recognizers"][0].clone()
    };
    // Four people at two similar speeds, from two viewpoints.
    let near = score("walk-5kmh,walk-6kmh");
    assert_eq!(
        (near["name"].as_str(), near["probes"].as_u64()),
        (Some("pixels"), Some(16))
    );
    assert_eq!(near["classes"].as_u64(), Some(4));
    assert_eq!(near["protocol"], "leave-one-take-out");
    assert_eq!(near["by_viewpoint"][1]["probes"].as_u64(), Some(8));
    // If a person's other take is a run, the nearest image is another person's at the same speed.
    let far = score("walk-3kmh,run-12kmh");
    let rank1 = |result: &serde_json::Value| result["rank1"].as_f64().expect("a rate");
    assert!(rank1(&near) > rank1(&far), "{near} {far}");
    let common = [
        "score",
        "pixels",
        "four.egp",
        "--protocol",
        "leave-one-take-out",
    ];
    // With one take each, further takes are generated from it, and a warning states that.
    let made = done(
        at,
        &[&common[..], &["--walks", "walk-5kmh", "--views", "side"]].concat(),
    );
    assert!(
        made.contains("warning: every person has one take"),
        "{made}"
    );
    refused(
        at,
        &[&common[..], &["--cycles", "2"]].concat(),
        2,
        &["--cycles"],
    );
}
