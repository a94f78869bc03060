use super::*;
use crate::encode::{Effort, MAX_ERROR_MM, encode_population};
use crate::people::Track;
use std::collections::BTreeSet;

const TWENTY: &str = r#"seed = 7
conditions = "casia-b"

[population]
age_years = [20, 30]
sex = "female"
dressed = "per-take"

[walks]
speeds_kmh = { uniform = [4, 5.5], walks = 3 }
takes = 2
cycles = 3

[views]
azimuth_deg = { uniform = [0, 360] }
elevation_deg = [0, 15]
count = 5

[images]
size = "64x44"
raster = "rows"

[splits]
train = "0..30"
test = "30..40"
"#;

fn parsed(text: &str) -> Result<Design> {
    Design::parse(Path::new("d.toml"), text)
}

#[test]
fn designs_that_are_built_in_are_what_their_names_say() {
    let [casia, random] = NAMES.map(|name| Design::named(name).expect("built in"));
    let splits: Vec<_> = casia
        .splits
        .iter()
        .map(|split| (split.name.as_deref(), split.people.clone()))
        .collect();
    let expected = [(Some("test"), 74..124), (Some("train"), 0..74)];
    assert!(expected.iter().all(|split| splits.contains(split)));
    assert_eq!((casia.people(), casia.viewpoints()), (124, 11));
    let names = casia.conditions.iter().map(|c| c.name.as_str());
    assert_eq!(names.collect::<Vec<_>>(), ["NM", "BG", "CL"]);
    // Six plain takes, two with bags and two with coats.
    assert_eq!((casia.takes.len(), casia.cycles()), (10, 10));
    let acting = casia.takes.iter().map(|take| take.condition);
    let expected = [[None; 6].to_vec(), vec![Some(1); 2], vec![Some(2); 2]].concat();
    assert!(acting.eq(expected));

    assert_eq!((random.people(), random.viewpoints()), (1_000, 8));
    assert_eq!(random.population.ages, Some([18.0, 80.0]));
    assert_eq!(random.population.dressed, Some(Dressing::PerTake));
    assert!(!random.conditions[0].is_fixed());
}

#[test]
fn people_of_a_design_walk_in_its_sessions() {
    let design = parsed(&TWENTY.replace("takes = 2", "sessions = 2")).expect("a design");
    assert_eq!((design.walks(), design.cycles()), (6, 6 * 3 * 3));
    let person = design.subject(3).expect("a person");
    let (first, second) = person.walks.split_at(3);
    for (walk, again) in first.iter().zip(second) {
        assert_eq!(again.name, format!("s2-{}", walk.name));
        let [walk, again] = [walk, again].map(|walk| match &walk.motion {
            Track::Loop(cycle) => cycle,
            Track::Uncut(_) => panic!("a cycle"),
        });
        assert_ne!(walk.rotations, again.rotations, "another day");
    }
    let many = parsed(&TWENTY.replace("takes = 2", "sessions = 10"));
    let error = many.expect_err("too many").to_string();
    assert!(error.contains("at most 9 sessions, found 10"), "{error}");
}

#[test]
fn a_design_says_who_walks_how_and_seen_from_where() {
    let design = parsed(TWENTY).expect("a design");
    assert_eq!((design.people(), design.walks()), (40, 3));
    assert_eq!((design.takes.len(), design.cycles), (2, 3));
    assert_eq!(design.cycles(), 3 * 6 * 3);
    let settings = design.settings;
    assert_eq!((settings.seed, settings.size.name()), (7, "64x44"));
    let (mut ages, mut speeds) = (BTreeSet::new(), BTreeSet::new());
    for number in 0..40 {
        let person = design.subject(number).expect("a person");
        assert_eq!(person.sex, Some(Sex::Female));
        let age = person.age_years.expect("an age");
        assert!((20.0..=30.0).contains(&age) && age.fract() == 0.0);
        ages.insert(age as u32);
        let own: Vec<f64> = person
            .walks
            .iter()
            .map(|walk| 3.6 * walk.speed_mps)
            .collect();
        assert!(own.len() == 3 && own.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(own.iter().all(|speed| (3.99..5.51).contains(speed)));
        speeds.extend(own.iter().map(|speed| (10.0 * speed).round() as u32));
        assert!(person.walks[1].worn.is_some());
    }
    // Nearly all of 11 ages, and all of 16 speeds.
    assert!(
        ages.len() >= 10 && speeds.len() == 16,
        "{ages:?} {speeds:?}"
    );
}

#[test]
fn viewpoints_are_drawn_for_each_cycle_and_are_the_same_under_all_conditions() {
    let design = parsed(TWENTY).expect("a design");
    let make = |number| design.subject(number);
    let pack = |people| encode_population(people, &make, MAX_ERROR_MM, Effort::Quick, &|| Ok(()));
    let (all, some) = (pack(0..8).expect("a pack"), pack(5..7).expect("a pack"));
    let [all, some] = [&all, &some].map(|bytes| Pack::parse(bytes).expect("a pack"));
    let jobs = design.jobs(&all);
    assert_eq!(jobs.len(), 8 * design.cycles());
    let variations = jobs.iter().take(18).step_by(3).map(|job| job.variation);
    assert!(variations.eq([0, 1, 2, 8, 9, 10]));
    let (mut azimuths, mut seen) = (Vec::new(), BTreeSet::new());
    for cycle in jobs.chunks(3) {
        let names = cycle.iter().map(Job::condition_name);
        assert_eq!(names.collect::<Vec<_>>(), ["NM", "BG", "CL"]);
        let views = [0, 1, 2].map(|at| design.views_of(&all, cycle[at]).expect("views"));
        assert!(views[0] == views[1] && views[0] == views[2] && views[0].len() == 5);
        for view in &views[0] {
            assert!([0.0, 15.0].contains(&view.elevation_deg));
            // An eighth of a degree is exact.
            assert_eq!((8.0 * view.azimuth_deg).fract(), 0.0);
            azimuths.push(f64::from(view.azimuth_deg));
            seen.insert(view.azimuth_deg.to_bits());
        }
    }
    let (count, sum) = (azimuths.len() as f64, azimuths.iter().sum::<f64>());
    // Four standard errors of a uniform distribution's mean.
    let error = 360.0 / 12f64.sqrt() / count.sqrt();
    assert!((sum / count - 180.0).abs() < 4.0 * error, "{}", sum / count);
    assert!(azimuths.iter().all(|angle| (0.0..=360.0).contains(angle)));
    assert!(seen.len() > azimuths.len() / 2);

    // Viewpoints do not depend on the other people.
    let own = design.jobs(&some);
    let of_fifth = &jobs[5 * design.cycles()..][..2 * design.cycles()];
    for (own, among) in own.iter().zip(of_fifth) {
        let own = design.views_of(&some, *own).expect("views");
        assert_eq!(own, design.views_of(&all, *among).expect("views"));
    }
}

#[test]
fn what_is_no_design_is_refused_with_the_line_and_the_reason() {
    let lines: Vec<&str> = TWENTY.lines().collect();
    let line_of = |start: &str| {
        1 + lines
            .iter()
            .position(|line| line.starts_with(start))
            .unwrap()
    };
    for (written, instead, expected) in [
        ("seed = 7", "seeds = 7", "unknown field `seeds`"),
        ("takes = 2", "takes = 0", "a number from 1 to 1000, found 0"),
        ("cycles = 3", "cycles = 3.5", "3.5"),
        (
            "speeds_kmh",
            "speeds_kmh = { uniform = [5.5, 4], walks = 3 }",
            "expected uniform = [LOW, HIGH], found 5.5 and 4",
        ),
        (
            "speeds_kmh",
            "speeds_kmh = { uniform = [4, 4.1], walks = 3 }",
            "at most 2 walks",
        ),
        ("speeds_kmh", "speeds_kmh = []", "at least one speed"),
        (
            "speeds_kmh",
            "speeds_kmh = { normal = [4, 1] }",
            "unknown field `normal`",
        ),
        (
            "azimuth_deg",
            "azimuth_deg = { uniform = [nan, 1] }",
            "found NaN and 1",
        ),
        ("azimuth_deg", "azimuth_deg = 90", "a list such as [0, 90]"),
        (
            "size",
            "size = \"60x60\"",
            "expected 50x30, 64x44, 64x64, found \"60x60\"",
        ),
        ("raster", "raster = \"lines\"", "found \"lines\""),
        ("dressed", "dressed = \"often\"", "often"),
        ("conditions", "conditions = \"casia-c\"", "casia-c"),
        ("train", "train = \"0..31\"", "share people 30..31"),
        ("train", "train = \"30..20\"", "found \"30..20\""),
        ("train", "\"../train\" = \"0..30\"", "the name of a folder"),
    ] {
        let start = written.split(" =").next().expect("a key");
        let text: Vec<&str> = lines
            .iter()
            .map(|line| {
                if line.starts_with(start) {
                    instead
                } else {
                    *line
                }
            })
            .collect();
        let error = parsed(&text.join("\n")).expect_err(instead).to_string();
        assert!(error.contains(expected), "{instead}: {error}");
        assert!(error.starts_with("d.toml:"), "{instead}: {error}");
        let line: usize = error["d.toml:".len()..]
            .split(':')
            .next()
            .unwrap()
            .parse()
            .expect(&error);
        // Errors about several splits name the line of their table.
        let is_there = line == line_of(start) || start == "train" && line == line_of("[splits]");
        assert!(is_there, "{instead}: {error}");
    }
}

#[test]
fn what_does_not_go_together_is_refused_with_what_to_do() {
    for (written, instead, expected) in [
        ("count = 5\n", "", "expected count = N"),
        (
            "cycles = 3",
            "cycles = 9",
            "at most 8 cycles of a take, found 9",
        ),
        (
            "[population]",
            "[population]\npeople = \"0..3\"",
            "found both",
        ),
        (
            "train = \"0..30\"\ntest = \"30..40\"",
            "",
            "expected people = \"0..100\"",
        ),
        (
            "[20, 30]",
            "[12, 30]",
            "an age of 12 years: expected 18.00 to 80.00",
        ),
        ("[20, 30]", "[30, 20]", "age_years"),
        (
            "[20, 30]",
            "[20, 30]\nreference = \"mars\"",
            "there is no population \"mars\": expected us-army, britain, china",
        ),
        (
            "[20, 30]",
            "[20, 61]\nreference = \"china\"",
            "an age of 61 years: expected 18.00 to 60.00, the range of the population \"china\"",
        ),
        (
            "[4, 5.5]",
            "[1, 5.5]",
            "a speed of 1 km/h: expected 3 to 12",
        ),
        (
            "[4, 5.5]",
            "[4, 15]",
            "a speed of 15 km/h: expected 3 to 12",
        ),
        ("[0, 360] }", "[0, 400] }", "azimuth 400"),
        ("[0, 15]", "[0, 95]", "95"),
        (
            "raster = \"rows\"",
            "distance_m = 5",
            "distance_m changes nothing",
        ),
        (
            "raster = \"rows\"",
            "template = [\"gei\", \"mhi\", \"gei\"]",
            "expected templates by name, each once",
        ),
        (
            "raster = \"rows\"",
            "template = [\"gei\", \"gie\"]",
            "expected the name of a template, or a list of names",
        ),
        (
            "raster = \"rows\"",
            "fps = 25\nframes_per_cycle = 32",
            "expected fps or frames_per_cycle, found both",
        ),
        ("raster = \"rows\"", "fps = 0", "expected fps above 0"),
        (
            "raster = \"rows\"",
            "raster = \"columns\"\nframing = \"camera\"\njoints = true",
            "joints",
        ),
        (
            "raster = \"rows\"",
            "frames_per_cycle = 0",
            "from 1 to 4096, found 0",
        ),
    ] {
        let text = TWENTY.replace(written, instead);
        assert_ne!(text, TWENTY);
        let error = parsed(&text).expect_err(instead).to_string();
        assert!(error.contains(expected), "{instead}: {error}");
        let line = error
            .strip_prefix("d.toml:")
            .and_then(|rest| rest.split(':').next());
        assert!(
            line.is_some_and(|line| line.parse::<usize>().is_ok()),
            "{error}"
        );
    }
    // By default people are dressed for good.
    let text = TWENTY.replace("dressed = \"per-take\"\n", "");
    let dressed = parsed(&text).expect("a design").population.dressed;
    assert_eq!(dressed, Some(Dressing::ForGood));
    let error = Design::named("casia-c").expect_err("no design").to_string();
    assert!(
        error.contains("casia-b-like, domain-random or a .toml file"),
        "{error}"
    );
}
