use super::*;
use serde_json::json;

fn results() -> Value {
    json!({
        "seconds": 1.5,
        "note": "text",
        "absent": null,
        "models": [
            { "name": "a", "runtime": { "name": "r" }, "threads": 1, "p50_us": 1, "lengths": [] },
            { "name": "a", "runtime": { "name": "r" }, "threads": 2, "p50_us": 2, "accuracy": { "rank1": 0.5 } },
            { "name": "pixels as gei", "threads": 1, "p50_us": 3 },
        ],
        "dotted": [{ "name": "net.v2", "p50_us": 4 }, { "name": "net.v3", "p50_us": 5 }],
        "only": [{ "name": "x", "views": [
            { "azimuth_deg": 90.0, "elevation_deg": 0.0, "rank1": 0.1 },
            { "azimuth_deg": 90.0, "elevation_deg": 30.5, "rank1": 0.2 },
        ] }],
    })
}

fn found(path: &str) -> Result<Vec<(String, f64)>, String> {
    let results = results();
    let places = FigurePath::parse(path)?.places(&results)?;
    Ok(places.into_iter().map(|at| (at.path, at.value)).collect())
}

#[test]
fn a_figure_is_found_by_keys_and_by_what_elements_are_called() {
    for (path, value) in [
        ("seconds", 1.5),
        ("models[a,threads=2].p50_us", 2.0),
        ("models[name=a,threads=1].p50_us", 1.0),
        ("models[\"pixels as gei\"].p50_us", 3.0),
        ("models[pixels as gei].p50_us", 3.0),
        ("dotted[net.v2].p50_us", 4.0),
        ("dotted[\"net.v2\"].p50_us", 4.0),
        ("models[threads=2].accuracy.rank1", 0.5),
        ("only.views[90,0].rank1", 0.1),
        ("only[x].views[elevation_deg=30.5].rank1", 0.2),
        ("only.views[azimuth_deg=90,elevation_deg=0.0].rank1", 0.1),
    ] {
        assert_eq!(found(path).map(|all| all[0].1), Ok(value), "{path}");
    }
}

#[test]
fn each_of_several_has_a_path_that_finds_it_alone() {
    let all = found("models[*].p50_us").expect("three");
    let paths = [
        "models[a,threads=1].p50_us",
        "models[a,threads=2].p50_us",
        "models[pixels as gei].p50_us",
    ];
    assert_eq!(
        all.iter()
            .map(|(path, _)| path.as_str())
            .collect::<Vec<_>>(),
        paths
    );
    let views = found("only.views[*].rank1").expect("two");
    for (path, value) in all.into_iter().chain(views) {
        assert_eq!(found(&path), Ok(vec![(path, value)]));
    }
}

#[test]
fn what_is_not_there_is_said_with_what_is() {
    for (path, words) in [
        ("p50", &["no \"p50\"", "note, only, seconds"][..]),
        ("models.p50_us", &["one of 3", "[a,threads=1]"]),
        ("models[b].p50_us", &["found 0 among", "a,threads=2"]),
        ("models[a].p50_us", &["found 2"]),
        ("models[a,threads=1].accuracy.rank1", &["no \"accuracy\""]),
        ("models[a,threads=1].lengths.p50_us", &["is empty"]),
        ("note", &["expected a number, found text"]),
        ("note.x", &["expected an object with \"x\", found text"]),
        ("absent", &["was not measured"]),
        ("seconds[1]", &["expected a list, found a number"]),
        (
            "models[threads=2].accuracy",
            &["found an object with rank1"],
        ),
        ("", &["expected a key, found its end"]),
        ("a..b", &["expected a key, found '.' at letter 3"]),
        ("a[", &["expected a name"]),
        ("a[b", &["expected a comma or a closing bracket"]),
        ("a[b]c", &["expected a dot or the end"]),
    ] {
        let said = found(path).expect_err(path);
        for word in words {
            assert!(said.contains(word), "{path}: {said}");
        }
    }
}

#[test]
fn elements_that_nothing_tells_apart_have_numbers() {
    let results = json!({ "list": [{ "x": 1 }, { "x": 2 }, { "name": "n", "x": 3 }, { "name": "n", "x": 4 }] });
    let found = |path: &str| {
        FigurePath::parse(path).and_then(|path| {
            let places = path.places(&results)?;
            Ok(places
                .into_iter()
                .map(|at| (at.path, at.value))
                .collect::<Vec<_>>())
        })
    };
    let all = found("list[*].x").expect("four");
    assert_eq!(
        all.iter()
            .map(|(path, _)| path.as_str())
            .collect::<Vec<_>>(),
        ["list[#0].x", "list[#1].x", "list[#2].x", "list[#3].x"]
    );
    for one in all {
        assert_eq!(found(&one.0), Ok(vec![one]));
    }
    let one = json!({ "list": [{ "x": 5 }] });
    let places = FigurePath::parse("list.x").and_then(|path| {
        let places = path.places(&one)?;
        FigurePath::parse(&places[0].path)?
            .places(&one)
            .map(|again| again[0].path.clone())
    });
    assert_eq!(places.as_deref(), Ok("list[#0].x"));
    assert!(found("list[#4].x").is_err_and(|said| said.contains("below 4, found #4")));
    let many: Vec<Value> = (0..2000)
        .map(|at| json!({ "name": format!("n{at}"), "x": at }))
        .collect();
    let many = json!({ "list": many });
    let places = FigurePath::parse("list[n7].x")
        .and_then(|path| path.places(&many).map(|found| found[0].path.clone()));
    assert_eq!(places.as_deref(), Ok("list[#7].x"));
}
