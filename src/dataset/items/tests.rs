use super::*;
use crate::draw::confounders::Doses;
use crate::draw::confounders::dose;
use crate::draw::sweep::{DrawingRequest, Raster, Views, sweep_each};
use crate::draw::template::Template;
use edgegait_core::raster::Rasterizer;
use std::collections::BTreeSet;
use std::path::Path;

const DESIGN: &str = r#"
seed = 5
conditions = "casia-b"
[walks]
speeds_kmh = { uniform = [4, 6], walks = 2 }
takes = 2
[views]
azimuth_deg = { uniform = [0, 360] }
elevation_deg = [0, 15]
count = 3
[images]
raster = "rows"
[splits]
train = "4..7"
test = "10..11"
"#;

fn design() -> Design {
    Design::parse(Path::new("design.toml"), DESIGN).expect("a design")
}

fn packs_of(items: &Items, numbers: &[usize]) -> BTreeMap<usize, PackBytes> {
    let people = items.people_of(numbers).into_iter();
    people
        .map(|person| (person, items.make(person).expect("a person")))
        .collect()
}

/// Returns each item's arrays, one after another.
fn drawn(items: &Items, numbers: &[usize], pass: u32) -> Vec<Vec<u8>> {
    let packs = packs_of(items, numbers);
    let mut drawn = items
        .draw(numbers, pass, &packs, &mut Vec::new(), &|| Ok(()))
        .expect("items that can be drawn");
    let places = drawn.places(&items.arrays());
    places.iter().map(|place| place.0.concat()).collect()
}

/// Returns the images of a sweep of all people in one pack.
fn swept(design: &Design, people: Range<usize>) -> Vec<Vec<u8>> {
    let make = |number| design.subject(number);
    let bytes =
        encode_population(people, &make, MAX_ERROR_MM, Effort::Quick, &|| Ok(())).expect("people");
    let pack = Pack::parse(&bytes).expect("a pack");
    let request = DrawingRequest {
        settings: design.settings,
        wanted: &design.images.wanted,
    };
    let mut all = Vec::new();
    sweep_each(
        &pack,
        &design.jobs(&pack),
        |job| design.views_of(&pack, job),
        request,
        |_, _, swept| Ok(swept.templates),
        |_, templates| {
            all.extend(templates);
            Ok(())
        },
    )
    .expect("a sweep");
    all
}

fn of_takes() -> Items {
    let takes: &[u8] = include_bytes!("../../../tests/data/golden/v1-take.egp");
    let items = PackItems {
        bytes: takes.into(),
        walks: vec![0],
        conditions: Vec::new(),
        variations: 0..1,
        views: Views::grid("side", [90.0], [0.0]).expect("views").list,
    };
    let settings = Settings {
        rasterizer: Raster::Each(Rasterizer::Rows),
        ..Settings::default()
    };
    Items::of_pack(items, settings, Wanted::one(Template::Silhouettes)).expect("items")
}

fn of_pack(conditions: Vec<Condition>, variations: Range<u32>) -> Items {
    let source = crate::dataset::sequences::built_in(&["walk-5kmh".into()]);
    let bytes = crate::dataset::sequences::stored(&source).expect("the built-in cohort");
    let items = PackItems {
        bytes: bytes.into(),
        walks: vec![3, 0, 25],
        conditions,
        variations,
        views: Views::grid("some", [0.0, 45.0, 90.0], [0.0, 30.0])
            .expect("views")
            .list,
    };
    let settings = Settings {
        rasterizer: Raster::Each(Rasterizer::Rows),
        ..Settings::default()
    };
    Items::of_pack(items, settings, Wanted::one(Template::Gei)).expect("items")
}

#[test]
fn items_of_a_design_are_those_of_a_sweep_of_its_people() {
    let items = Items::of_design(design(), Some("train"), None).expect("items");
    // 3 people, 2 speeds, 2 takes, 3 conditions, 3 viewpoints.
    assert_eq!(items.len(), 3 * 2 * 2 * 3 * 3);
    let all: Vec<usize> = (0..items.len()).collect();
    let expected = swept(&design(), 4..7);
    let found = drawn(&items, &all, 0);
    assert!(found == expected);
    assert_eq!(items.subjects(), ["5-F03", "5-M03", "5-F04"]);
    let labels: Vec<usize> = all.iter().map(|&item| items.label(item)).collect();
    let by_person: Vec<usize> = (0..3).flat_map(|person| [person; 36]).collect();
    assert_eq!(labels, by_person);
}

#[test]
fn an_item_is_the_same_alone_and_among_others() {
    let items = Items::of_design(design(), Some("train"), None).expect("items");
    let numbers = [107, 3, 3, 4, 40, 72, 5, 0];
    let together = drawn(&items, &numbers, 0);
    for (&number, one) in numbers.iter().zip(&together) {
        assert_eq!(drawn(&items, &[number], 0)[0], *one);
    }
    let packs = packs_of(&items, &numbers);
    let rows = items.rows(&numbers, 0, &packs).expect("rows");
    assert_eq!(rows[1], rows[2]);
    assert_eq!(rows[0].subject, "5-F04");
    assert_eq!(
        (rows[7].condition.as_str(), rows[0].condition.as_str()),
        ("NM", "CL")
    );
    let views = |row: &IndexRow| (row.azimuth_deg, row.elevation_deg);
    assert_ne!(views(&rows[1]), views(&rows[3]));
}

#[test]
fn items_of_a_pack_are_in_the_order_of_a_sweep() {
    let condition = |text| Condition::from_doses(Doses::new(dose(text).ok()));
    let items = of_pack(vec![condition("hat=1"), condition("backpack=1")], 2..4);
    assert_eq!(items.len(), 2 * 3 * 2 * 6);
    let all: Vec<usize> = (0..items.len()).collect();
    let rows = items.rows(&all, 0, &BTreeMap::new()).expect("rows");
    let cycles: Vec<String> = rows
        .iter()
        .step_by(6)
        .map(|row| format!("{} {} {}", row.condition, row.subject, row.variation))
        .collect();
    let expected = [
        "hat=1 M02 2",
        "hat=1 M02 3",
        "hat=1 F01 2",
        "hat=1 F01 3",
        "hat=1 M13 2",
        "hat=1 M13 3",
    ];
    assert_eq!(cycles[..6], expected);
    assert_eq!(cycles[6], "backpack=1 M02 2");
    assert_eq!(items.subjects(), ["M02", "F01", "M13"]);
    let labels: Vec<usize> = all
        .iter()
        .step_by(6)
        .map(|&item| items.label(item))
        .collect();
    assert_eq!(labels, [0, 0, 1, 1, 2, 2, 0, 0, 1, 1, 2, 2]);
}

#[test]
fn passes_have_variations_that_no_command_can_name() {
    let items = of_pack(Vec::new(), 0..2);
    let variations = |pass| -> Vec<u32> {
        let rows = items
            .rows(&[0, 6, 12], pass, &BTreeMap::new())
            .expect("rows");
        rows.iter().map(|row| row.variation).collect()
    };
    assert_eq!(variations(0), [0, 1, 0]);
    assert_eq!(variations(1), [1_048_576, 1_048_577, 1_048_576]);
    // A take has eight.
    assert_eq!(variations(2), [1_048_584, 1_048_585, 1_048_584]);
    const { assert!(FIRST_OF_PASSES > crate::evaluate::protocol::MAX_VARIATION + 1_000) };
    assert_eq!(FIRST_OF_PASSES % CYCLES_OF_A_TAKE, 0);
    let images = [0, 1, 2].map(|pass| drawn(&items, &[6], pass).concat());
    assert!(images[0] != images[1] && images[1] != images[2]);
    // Pass 1 is shifted by FIRST_OF_PASSES alone, so one more pass fits.
    let last = (u32::MAX - FIRST_OF_PASSES - 2) / 8 + 1;
    assert!(items.rows(&[0], last, &BTreeMap::new()).is_ok());
    let said = items.rows(&[0], last + 1, &BTreeMap::new());
    let said = said.expect_err("no variations").to_string();
    assert_eq!(
        said,
        format!("there are no variations left for pass {}", last + 1)
    );
}

#[test]
fn late_variations_have_as_many_passes_as_early_ones_and_no_take_in_two() {
    let variations = |items: &Items, pass| -> Vec<u32> {
        let all: Vec<usize> = (0..items.len()).step_by(18).collect();
        let rows = items.rows(&all, pass, &BTreeMap::new()).expect("rows");
        rows.iter().map(|row| row.variation).collect()
    };
    let late = of_pack(Vec::new(), 1_000_004..1_000_010);
    let takes: Vec<BTreeSet<u32>> = [1, 2, 100_000_000]
        .iter()
        .map(|&pass| {
            let found = variations(&late, pass);
            found.iter().map(|item| item / CYCLES_OF_A_TAKE).collect()
        })
        .collect();
    assert!(takes[0].is_disjoint(&takes[1]) && takes[1].is_disjoint(&takes[2]));
    let last = (u32::MAX - FIRST_OF_PASSES - 1_000_010) / 16 + 1;
    assert!(late.rows(&[0], last, &BTreeMap::new()).is_ok());
    assert!(late.rows(&[0], last + 1, &BTreeMap::new()).is_err());
}

#[test]
fn takes_are_the_same_in_each_pass() {
    let items = of_takes();
    let [first, second] = [0, 1].map(|pass| drawn(&items, &[0], pass));
    assert!(first[0].len() > items.bytes(1) && first == second);
    let rows = items.rows(&[0], 7, &BTreeMap::new()).expect("rows");
    assert_eq!(rows[0].variation, 0);
}

#[test]
fn as_many_are_drawn_at_once_as_there_is_room_for() {
    // GEIs of 1,500 bytes, in 2 GiB.
    assert_eq!(of_pack(Vec::new(), 0..1).most_at_once(), 1_431_655);
    // Frames count in uncut motions.
    let takes = of_takes();
    let bytes = drawn(&takes, &[0], 0)[0].len();
    let most = (1 << 31) / bytes;
    let said = takes.draw(
        &vec![0; most + 1],
        0,
        &BTreeMap::new(),
        &mut Vec::new(),
        &|| Ok(()),
    );
    assert_eq!(
        said.expect_err("too much").to_string(),
        format!(
            "expected at most 2147483648 bytes at once, found {} of {} items: ask for fewer",
            bytes * (most + 1),
            most + 1
        )
    );
    assert!(
        takes
            .frames(
                &vec![0; most],
                0,
                &takes.shelf(&BTreeMap::new()).expect("a pack")
            )
            .is_ok()
    );
    let items = Items::of_design(design(), Some("train"), None).expect("items");
    assert_eq!(items.most_at_once(), 1_431_655);
}

#[test]
fn a_split_that_is_not_there_is_refused() {
    let refusal = |split| {
        let refused = Items::of_design(design(), split, None);
        refused.expect_err("no such split").to_string()
    };
    assert_eq!(
        refusal(None),
        "no split is named, expected one of test, train"
    );
    assert_eq!(
        refusal(Some("valid")),
        "there is no split \"valid\", expected one of test, train"
    );
    let few = Items::of_design(design(), Some("train"), Some(1)).expect("items");
    assert_eq!(few.len(), 36);
}

#[test]
fn work_ends_where_it_is_told_to() {
    let items = of_pack(Vec::new(), 0..4);
    let all: Vec<usize> = (0..items.len()).collect();
    let tell = || Err(Error::Missing("patience"));
    let ended = items.draw(&all, 0, &BTreeMap::new(), &mut Vec::new(), &tell);
    assert_eq!(
        ended.expect_err("an end").to_string(),
        "expected patience, found none"
    );
}
