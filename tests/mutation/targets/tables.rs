//! Tables (CSV), designs, protocols and limits (TOML), partitions and results (JSON).

use super::{Target, below, command, command_begun, contents, target};
use crate::chance::Chance;
use crate::data::fixtures;
use crate::mutators::{structure, text};
use edgegait::dataset::Partition;
use edgegait::dataset::design::Design;
use edgegait::people::recorded::Renamings;
use edgegait::{Protocol, Views, dose};
use std::fs;
use std::path::{Path, PathBuf};

const LIMITS: &str = r#"judge = "interval"

[[limit]]
name = "the baseline works"
figure = "recognizers[pixels].rank1"
at_least = 0.1
at_most = 1.0

[[limit]]
figure = "recognizers[*].rank1"
not_worse = true

[[limit]]
figure = "recognizers[pixels].rank1_low"
per = "recognizers[pixels].rank1"
ratio_at_most = 1.5
difference_at_least = -0.5
"#;

pub fn targets(folder: &Path, made: &Path) -> Vec<Target> {
    let toml = |place: &str| contents(below(Path::new(place), &["toml"], 1 << 14));
    let at = |name: &str| crate::run::fresh(&folder.join(name));
    let file = |folder: PathBuf, name: &str| folder.join(name);
    let design = |bytes: &[u8], _: &mut Chance| {
        let design = Design::parse(Path::new("d.toml"), std::str::from_utf8(bytes)?)?;
        let _ = (design.people(), design.cycles());
        let person = design.subject(0)?;
        assert!(
            person.stature_m.is_finite() && person.mass_kg.is_finite(),
            "a person"
        );
        Ok(())
    };
    let protocol = |bytes: &[u8], _: &mut Chance| {
        let protocol = Protocol::parse(Path::new("p.toml"), std::str::from_utf8(bytes)?)?;
        let _ = protocol.made(2);
        Ok(())
    };
    let doses = |bytes: &[u8], _: &mut Chance| {
        let dose = dose(std::str::from_utf8(bytes)?)?;
        assert!(dose.strength.is_finite(), "a strength");
        Ok(())
    };
    let dose_seeds = [
        "backpack=0.5",
        "roll=1deg",
        "pace=1.2",
        "light=0.3",
        "coat=1",
    ];
    let views = file(at("views"), "v.csv");
    let read_views = move |bytes: &[u8], _: &mut Chance| {
        fs::write(&views, bytes)?;
        let views = Views::named(views.to_str().expect("UTF-8"))?;
        let is_finite = |view: &edgegait::View| {
            let (azimuth, elevation) = view.angles_deg();
            azimuth.is_finite() && elevation.is_finite()
        };
        assert!(views.list.iter().all(is_finite), "a viewpoint");
        Ok(())
    };
    let renamings = file(at("joints"), "j.csv");
    let read_renamings = move |bytes: &[u8], _: &mut Chance| {
        fs::write(&renamings, bytes)?;
        Renamings::read(&renamings)?;
        Ok(())
    };
    let partition = file(at("partition"), "p.json");
    let read_partition = move |bytes: &[u8], _: &mut Chance| {
        fs::write(&partition, bytes)?;
        Partition::read(&partition)?;
        Ok(())
    };
    let (bodies, walk) = (file(at("bodies"), "b.csv"), made.join("walk.bvh"));
    let read_bodies = move |bytes: &[u8], chance: &mut Chance| {
        fs::write(&bodies, bytes)?;
        let words = "import @ --bodies @ --threads 1 --overwrite --out";
        let words = format!(
            "{words} {}",
            if chance.is(50) {
                "o.egp --keep-going"
            } else {
                "o.egp"
            }
        );
        command_begun(&words, &[&walk, &bodies])
    };
    let study = at("study");
    copy_people(&study);
    let read_manifest = move |bytes: &[u8], _: &mut Chance| {
        fs::write(study.join("m.csv"), bytes)?;
        let folders = [
            study.join("people"),
            fixtures().join("mocap"),
            fixtures().join("study"),
        ];
        let paths = [&folders[0], &folders[1], &folders[2], &study.join("m.csv")];
        let paths = paths.map(PathBuf::as_path);
        command_begun(
            "study @ @ @ --manifest @ --threads 1 --views 090 --out o",
            &paths,
        )
    };
    let score = made.join("score.json");
    let words = "score pixels no_std_core/tests/golden/cohort.egp --views side --threads 2";
    make_json(words, &score);
    let (gated, results) = (at("gate"), fs::read(&score).expect("results"));
    let (limits_at, results_at) = (gated.join("l.toml"), gated.join("r.json"));
    let limits = {
        let (limits_at, score) = (limits_at.clone(), score.clone());
        move |bytes: &[u8], _: &mut Chance| {
            fs::write(&limits_at, bytes)?;
            command("gate @ @ @", &[&limits_at, &score, &score])
        }
    };
    let read_results = move |bytes: &[u8], chance: &mut Chance| {
        fs::write(&results_at, bytes)?;
        fs::write(&limits_at, LIMITS)?;
        if chance.is(20) {
            return command("gate --init @", &[&results_at]);
        }
        command("gate @ @ @", &[&limits_at, &results_at, &score])
    };
    let bodies_csv = ["study/bodies.csv", "study/bodies_dressed.csv"].map(|it| fixtures().join(it));
    let mut own = b"subject,sex,stature_m,mass_kg,hip_breadth_mm\nwalk,F,1.65,60,350\n".to_vec();
    own.extend(b"b,male,1.8,,\n");
    let manifest = fs::read_to_string(fixtures().join("study/manifest.csv")).expect("a manifest");
    // The header, and the takes that are there.
    let takes = ["101,nm-01,", "102,nm-01,", "102,nm-02,"];
    let is_there =
        |line: &str| takes.iter().any(|take| line.starts_with(take)) && line.contains("090");
    let lines = manifest
        .lines()
        .enumerate()
        .filter(|(at, line)| *at == 0 || is_there(line));
    let manifest = lines
        .map(|(_, line)| format!("{line}\n"))
        .collect::<String>()
        .into_bytes();
    vec![
        target(
            "design",
            20,
            toml("src/dataset/design/built_in"),
            &text::ALL,
            &[],
            design,
        ),
        target(
            "protocol",
            40,
            toml("src/evaluate/protocols"),
            &text::ALL,
            &[],
            protocol,
        ),
        target(
            "dose",
            40,
            dose_seeds.map(|it| it.as_bytes().to_vec()).to_vec(),
            &text::ALL,
            &[],
            doses,
        ),
        target(
            "views",
            40,
            vec![b"azimuth_deg,elevation_deg\n90,0\n0,45\n-30,10\n".to_vec()],
            &text::TABLE,
            &[],
            read_views,
        ),
        target(
            "joints",
            40,
            vec![b"name,known\nhip_l,LeftUpLeg\nfoot,RightFoot\nm1,LASI\n".to_vec()],
            &text::TABLE,
            &[],
            read_renamings,
        ),
        target(
            "partition",
            40,
            vec![br#"{"TRAIN_SET": ["001", "002"], "TEST_SET": ["003"]}"#.to_vec()],
            &[structure::json],
            &text::ALL,
            read_partition,
        ),
        target(
            "bodies",
            4,
            [contents(bodies_csv), vec![own]].concat(),
            &text::TABLE,
            &[],
            read_bodies,
        ),
        target(
            "study manifest",
            3,
            vec![manifest],
            &text::TABLE,
            &[],
            read_manifest,
        ),
        target("limits", 4, vec![LIMITS.into()], &text::ALL, &[], limits),
        target(
            "results",
            4,
            vec![results],
            &[structure::json],
            &text::ALL[..8],
            read_results,
        ),
    ]
}

/// Silhouettes of people for a study.
fn copy_people(folder: &Path) {
    for picture in below(&fixtures().join("people"), &["png"], 1 << 14) {
        let place = picture
            .strip_prefix(fixtures().join("people"))
            .expect("below");
        let place = folder.join(place);
        fs::create_dir_all(place.parent().expect("a folder")).expect("a folder");
        fs::copy(picture, place).expect("a copy");
    }
}

fn make_json(words: &str, path: &Path) {
    let words: Vec<std::ffi::OsString> = words.split(' ').map(Into::into).collect();
    let held = edgegait::cli::embed::EmbeddedInputs::default();
    let json = edgegait::cli::embed::results(&words, held).expect("results");
    fs::write(path, json).expect("a file");
}
