//! `skia` compared with tiny-skia itself, pixel by pixel: people with and without clothes, under
//! every confounder, from everywhere, with every framing, lens and size.

use edgegait::draw::confounders::{CATALOGUE, Condition, Dose, Doses};
use edgegait::draw::sweep::{
    FramingMode, Jitter, Job, Lens, Raster, Settings, Swept, View, Views, sweep,
};
use edgegait::draw::template::Template;
use edgegait::encode::{MAX_ERROR_MM, encode_subjects};
use edgegait::error::Result;
use edgegait::people::cohort::{CohortOptions, Dressing, subjects};
use edgegait_core::pack::Pack;
use edgegait_core::raster::Rasterizer;
use edgegait_core::silhouette::Size;

/// Returns packs of people without and with clothes.
fn packs(people: usize, speeds_kmh: &[f64]) -> [Vec<u8>; 2] {
    [None, Some(Dressing::ForGood)].map(|dressed| {
        let options = CohortOptions {
            people,
            speeds_kmh: speeds_kmh.to_vec(),
            dressed,
            ..CohortOptions::default()
        };
        let people = subjects(&options).expect("speeds within the norms");
        encode_subjects(&people, MAX_ERROR_MM, &|| Ok(())).expect("a pack")
    })
}

/// Returns the silhouettes of two walks from four viewpoints, a byte each pixel, and the shares of
/// them that are cut off.
fn silhouettes(
    pack: &Pack<'_>,
    turn: usize,
    condition: Option<&Condition>,
    views: &[View],
    settings: Settings,
) -> Result<Vec<(Vec<Vec<u8>>, u64)>> {
    let walks = pack.walks().len();
    let jobs = [0, 1].map(|job| Job {
        condition,
        ..Job::plain((2 * turn + job) % walks, turn as u32 % 7)
    });
    let mut all = Vec::new();
    let keep = |_: Job<'_>, swept: Swept| Ok((swept.templates, swept.clipped.to_bits()));
    let sink = |_: Job<'_>, drawn| {
        all.push(drawn);
        Ok(())
    };
    sweep(pack, &jobs, views, settings, keep, sink)?;
    Ok(all)
}

/// Compares at least this many pixels.
fn compare(packs: &[Vec<u8>], pixels: u64) {
    let packs: Vec<Pack<'_>> = { packs.iter() }
        .map(|bytes| Pack::parse(bytes).expect("it was just made"))
        .collect();
    let views = Views::paper().expect("703 viewpoints").list;
    let framings = [
        FramingMode::Height,
        FramingMode::Box,
        FramingMode::Cycle,
        FramingMode::Camera,
    ];
    let (mut compared, mut on, mut refused) = (0, 0, 0);
    for turn in 0.. {
        if compared >= pixels {
            break;
        }
        // Numbers without common divisors, so that all meet all.
        let condition = CATALOGUE
            .get(turn % (CATALOGUE.len() + 1))
            .map(|confounder| {
                let dose = Dose {
                    kind: confounder.kind,
                    strength: [1.0, 0.4][turn / 2 % 2],
                };
                Condition::from_doses(Doses::new([dose]))
            });
        let views = [0, 1, 2, 3].map(|view| views[(turn * 4 + view) * 89 % views.len()]);
        let settings = Settings {
            size: Size::ALL[turn % 3],
            framing: framings[turn / 3 % 4],
            lens: [Lens::Ortho, Lens::Persp][turn / 12 % 2],
            jitter: [Jitter::None, Jitter::R2][turn / 24 % 2],
            frames_per_cycle: 8,
            template: Template::Silhouettes,
            ..Settings::default()
        };
        let pack = &packs[turn / 48 % packs.len()];
        let [found, expected] = [Rasterizer::Skia, Rasterizer::TinySkia].map(|rasterizer| {
            let rasterizer = Raster::Each(rasterizer);
            let settings = Settings {
                rasterizer,
                ..settings
            };
            silhouettes(pack, turn, condition.as_ref(), &views, settings)
        });
        match (found, expected) {
            (Ok(found), Ok(expected)) => {
                for (found, expected) in found.iter().zip(&expected) {
                    assert!(found == expected, "turn {turn}: {condition:?} {settings:?}");
                    for silhouettes in &found.0 {
                        compared += silhouettes.len() as u64;
                        on += silhouettes.iter().filter(|&&pixel| pixel > 0).count();
                    }
                }
            }
            (Err(found), Err(expected)) => {
                refused += 1;
                assert_eq!(found.to_string(), expected.to_string());
            }
            (found, expected) => panic!("turn {turn}: {:?} {:?}", found.is_ok(), expected.is_ok()),
        }
        if turn % 200 == 199 {
            println!(
                "{compared} pixels, {on} of them on: none differ; {refused} of {turn} refused"
            );
        }
    }
    println!("{compared} pixels, {on} of them on: none differ; {refused} settings refused");
    assert!(on as u64 > compared / 20, "{on} of {compared}");
}

#[test]
fn five_million_pixels_are_those_of_tiny_skia() {
    compare(&packs(2, &[5.0]), 5_000_000);
}

#[test]
#[ignore = "a minute"]
fn five_hundred_million_pixels_are_those_of_tiny_skia() {
    compare(&packs(13, &[4.0, 9.0]), 500_000_000);
}
