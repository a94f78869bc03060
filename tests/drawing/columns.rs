//! Drawing by columns compared with drawing each viewpoint: sweeps of people of the cohort.

use edgegait::draw::sweep::{
    Aim, FramingMode, Jitter, Job, Moments, Raster, Sensor, Settings, Shot, Swept, View, Views,
    silhouettes, sweep,
};
use edgegait::encode::{MAX_ERROR_MM, encode_subjects};
use edgegait::people::cohort::{CohortOptions, subjects};
use edgegait_core::pack::Pack;
use edgegait_core::raster::Rasterizer;
use edgegait_core::silhouette::{AnySilhouette, Size};
use edgegait_core::template::GeiBuilder;
use glam::Vec3;

/// Returns a pack of two people of the cohort, each walking at 5 km/h and running at 9.
fn pack() -> Vec<u8> {
    let options = CohortOptions {
        people: 2,
        speeds_kmh: vec![5.0, 9.0],
        ..CohortOptions::default()
    };
    let people = subjects(&options).expect("speeds within the norms");
    encode_subjects(&people, MAX_ERROR_MM, &|| Ok(())).expect("two people fit a pack")
}

fn settings(raster: impl Into<Raster>, framing: FramingMode) -> Settings {
    Settings {
        rasterizer: raster.into(),
        framing,
        frames_per_cycle: 8,
        ..Settings::default()
    }
}

fn frames(
    pack: &Pack<'_>,
    walk: usize,
    views: &[View],
    settings: Settings,
) -> Vec<Vec<AnySilhouette>> {
    let shot = Shot {
        job: Job::plain(walk, 0),
        moments: Moments::Cycle,
        views,
    };
    silhouettes(pack, shot, settings).expect("a walker can be drawn")
}

/// Returns the GEIs and the clipped share of each walk.
fn swept(pack: &Pack<'_>, views: &[View], settings: Settings) -> Vec<Swept> {
    let jobs: Vec<Job<'_>> = (0..pack.walks().len())
        .map(|walk| Job::plain(walk, 0))
        .collect();
    let mut all = Vec::new();
    let sink = |_, swept| {
        all.push(swept);
        Ok(())
    };
    sweep(pack, &jobs, views, settings, |_, swept| Ok(swept), sink).expect("walkers can be drawn");
    all
}

fn geis(pack: &Pack<'_>, views: &[View], settings: Settings) -> Vec<Vec<Vec<u8>>> {
    let all = swept(pack, views, settings).into_iter();
    all.map(|swept| swept.templates).collect()
}

#[test]
fn columns_and_rows_draw_the_same_pixels_from_703_viewpoints() {
    let bytes = pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let views = Views::paper().expect("the grid").list;
    let (mut wrong, mut pixels) = (0, 0);
    for walk in 0..pack.walks().len() {
        let [columns, rows] = [Raster::Columns, Rasterizer::Rows.into()].map(|raster: Raster| {
            frames(&pack, walk, &views, settings(raster, FramingMode::Cycle))
        });
        for (columns, rows) in columns.iter().flatten().zip(rows.iter().flatten()) {
            let (columns, rows) = (columns.silhouette(), rows.silhouette());
            assert!(rows.area() > 50);
            for (a, b) in columns.rows().iter().zip(rows.rows()) {
                wrong += u64::from((a ^ b).count_ones());
            }
            pixels += columns.size().pixels() as u64;
        }
    }
    println!("{wrong} of {pixels} pixels differ");
    assert!(
        pixels >= 33_000_000 && wrong * 1_000_000 < 5 * pixels,
        "{wrong} of {pixels}"
    );
}

#[test]
fn a_sweep_by_columns_is_the_same_on_1_and_2_threads_and_whatever_views_are_asked_for_together() {
    let bytes = pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let views = Views::grid(
        "some",
        [0.0, 35.0, 90.0, 360.0],
        [0.0, 30.0, 85.0, 90.0, -20.0],
    );
    let views = views.expect("viewpoints").list;
    let mut settings = settings(Raster::Columns, FramingMode::Cycle);
    settings.jitter = Jitter::R2;
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads")
            .install(|| geis(&pack, &views, settings))
    };
    let together = on(1);
    assert_eq!(on(2), together);
    let backwards: Vec<View> = views.iter().rev().copied().collect();
    for (geis, reversed) in together.iter().zip(geis(&pack, &backwards, settings)) {
        assert!(geis.iter().eq(reversed.iter().rev()));
    }
    for (at, view) in views.iter().enumerate() {
        for (geis, alone) in together.iter().zip(geis(&pack, &[*view], settings)) {
            assert_eq!(geis[at], alone[0], "{view:?}");
        }
    }
}

#[test]
fn a_sweeps_geis_are_the_means_of_the_frames_that_are_rendered() {
    let bytes = pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let views = Views::grid(
        "some",
        [20.0, 90.0],
        (0..19u8).map(|step| 5.0 * f32::from(step)),
    );
    let views = views.expect("viewpoints").list;
    for size in Size::ALL {
        for framing in [FramingMode::Cycle, FramingMode::Camera] {
            let mut settings = settings(Raster::Columns, framing);
            (settings.size, settings.jitter) = (size, Jitter::R2);
            let geis = &geis(&pack, &views, settings)[1];
            for (gei, frames) in geis.iter().zip(frames(&pack, 1, &views, settings)) {
                let mut builder = GeiBuilder::new(size);
                for frame in frames {
                    builder.add(&frame).expect("room");
                }
                assert_eq!(builder.gei().pixels(), *gei, "{size} {framing:?}");
                assert!(gei.iter().any(|&mean| mean > 0));
            }
        }
    }
}

#[test]
fn columns_and_rows_clip_the_same_share_at_a_sensors_border() {
    let bytes = pack();
    let pack = Pack::parse(&bytes).expect("our own pack");
    let views = Views::grid("some", [0.0, 50.0], [0.0, 45.0, 90.0])
        .expect("viewpoints")
        .list;
    for (distance_m, aim, is_cut) in [
        (4.0, Aim::Pelvis, false),
        (1.0, Aim::Pelvis, true),
        (4.0, Aim::Point(Vec3::new(1.2, 0.9, 0.3)), true),
    ] {
        let [columns, rows] = [Raster::Columns, Rasterizer::Rows.into()].map(|raster: Raster| {
            let mut settings = settings(raster, FramingMode::Camera);
            settings.sensor = Sensor {
                distance_m,
                aim,
                ..Sensor::default()
            };
            swept(&pack, &views, settings)
        });
        for (columns, rows) in columns.iter().zip(&rows) {
            assert_eq!(columns.clipped, rows.clipped);
            assert_eq!(columns.clipped > 0.0, is_cut);
            for (a, b) in columns.templates.iter().zip(&rows.templates) {
                let differing = a.iter().zip(b).filter(|(a, b)| a != b);
                assert!(differing.count() <= 1);
            }
        }
    }
}
