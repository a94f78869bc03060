//! The printed report of recorded walkers.

use super::features::Features;
use super::statistics::mean_and_sd;
use super::walkers::ManifestTake;
use crate::people::cohort::norms::Angle;
use edgegait_core::skeleton::Joint;
use std::collections::BTreeMap;

/// A number of a cycle, and its name.
type NamedNumber = (String, Box<dyn Fn(&Features) -> f64>);

fn columns() -> Vec<NamedNumber> {
    let mut columns: Vec<NamedNumber> = Vec::new();
    for (index, angle) in Angle::ALL.into_iter().enumerate() {
        let mut add = |name: &str, of: fn(&super::features::AngleFeatures) -> f64| {
            columns.push((
                format!("{angle:?} {name}"),
                Box::new(move |features| of(&features.angles[index])),
            ));
        };
        add("offset, degrees", |angle| angle.offset_deg);
        add("amplitude, log", |angle| angle.log_amplitude);
        add("delay, cycles", |angle| angle.delay);
        add("likeness", |angle| angle.likeness);
        add("asymmetry, degrees", |angle| angle.asymmetry_deg);
        add("range, degrees", |angle| angle.range_deg);
    }
    let mut add = |name: &str, of: fn(&super::features::StepFeatures) -> f64| {
        columns.push((name.into(), Box::new(move |features| of(&features.steps))));
    };
    add("speed, m/s", |steps| steps.speed_mps);
    add("stride time, s", |steps| steps.stride_s);
    add("stature, m", |steps| steps.stature_m);
    add("step width in double support, m", |steps| {
        steps.step_width_m
    });
    add("step width, mid-stances, m", |steps| steps.track_width_m);
    add("step length, m", |steps| steps.step_length_m);
    add("walk ratio, log", |steps| steps.log_walk_ratio);
    add("toe-out, degrees", |steps| steps.toe_out_deg);
    add("bob, m", |steps| steps.bob_m);
    add("sway, m", |steps| steps.sway_m);
    add("clearance, m", |steps| steps.clearance_m);
    add("arm's delay, cycles", |steps| steps.arm_delay);
    add("share of stance", |steps| steps.duty);
    add("neck and head, degrees", |steps| steps.neck_deg);
    add("head, degrees", |steps| steps.head_deg);
    add("elbow's plane inwards, degrees", |steps| {
        steps.upper_arm_turn_deg
    });
    add("pronation, degrees", |steps| steps.pronation_deg);
    add("wrist ahead of the hip, m", |steps| steps.wrist_ahead_m);
    add("wrist beside the hip, m", |steps| steps.wrist_out_m);
    add("step asymmetry", |steps| steps.step_asymmetry);
    columns
}

fn clip_mean(clip: &ManifestTake, of: &dyn Fn(&Features) -> f64) -> f64 {
    clip.cycles.iter().map(of).sum::<f64>() / clip.cycles.len() as f64
}

/// Returns the mean of each person's takes, by data set.
fn by_dataset(clips: &[ManifestTake], of: &dyn Fn(&Features) -> f64) -> BTreeMap<String, Vec<f64>> {
    let mut people: BTreeMap<(&str, &str), Vec<f64>> = BTreeMap::new();
    for clip in clips {
        people
            .entry((&clip.dataset, &clip.subject))
            .or_default()
            .push(clip_mean(clip, of));
    }
    let mut sets: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for ((dataset, _), takes) in people {
        let mean = takes.iter().sum::<f64>() / takes.len() as f64;
        sets.entry(dataset.into()).or_default().push(mean);
    }
    sets
}

fn print_columns(title: &str, clips: &[ManifestTake]) {
    println!("\n{title}: mean (standard deviation) over people");
    for (name, of) in columns() {
        print!("{name:34}");
        for (dataset, values) in by_dataset(clips, &*of) {
            let (mean, sd) = mean_and_sd(&values);
            print!(" {dataset} {}: {mean:.3} ({sd:.3});", values.len());
        }
        println!();
    }
}

/// Prints every take, the data sets' means and spreads, and the joints' mean rotations.
pub(super) fn print(walks: &[ManifestTake], runs: &[ManifestTake]) {
    for clip in walks.iter().chain(runs) {
        let of = |of: &dyn Fn(&Features) -> f64| clip_mean(clip, of);
        println!(
            "{} {} {}: {} cycles, {:.2} m/s, stature {:.2}, width {:.3} {:.3}, bob {:.3}, sway {:.3}, duty {:.3}, cadence {:.0}",
            clip.dataset,
            clip.subject,
            clip.name,
            clip.cycles.len(),
            of(&|f| f.steps.speed_mps),
            of(&|f| f.steps.stature_m),
            of(&|f| f.steps.step_width_m),
            of(&|f| f.steps.track_width_m),
            of(&|f| f.steps.bob_m),
            of(&|f| f.steps.sway_m),
            of(&|f| f.steps.duty),
            of(&|f| 120.0 / f.steps.stride_s),
        );
    }
    print_columns("walking", walks);
    print_columns("running", runs);
    println!("\nmean rotation vector of each joint, degrees (left side), and range about X");
    for joint in Joint::ALL {
        if joint != joint.mirrored() && !joint.is_left() {
            continue;
        }
        for axis in 0..3 {
            print!("{joint:?} {} ", ["x", "y", "z"][axis]);
            for (dataset, values) in by_dataset(walks, &|f| f.joints[joint.index()].0[axis]) {
                let (mean, sd) = mean_and_sd(&values);
                print!(" {dataset}: {mean:.1} ({sd:.1});");
            }
            println!();
        }
    }
}
