//! Mean walks of groups of similar clips, where they save bytes.
//!
//! Clips are grouped by their coefficients (k-means, Lloyd 1982, started from the farthest clips,
//! without random numbers). Each group's mean is a mean walk ("template" in the pack format). The
//! number of groups is the one that makes the pack smallest.

use super::codebook::EncodedMeanWalk;
use super::coefficients::{CycleCoefficients, Mean, mean_of, trim};
use super::cycle::Quantised;
use super::frames::Frames;
use super::rice::RiceParameters;
use edgegait_core::format::CHANNELS;

/// The numbers of mean walks to try. More than 8 never saved bytes for the built-in cohort.
const TRIED: [usize; 4] = [1, 2, 4, 8];
/// The number of coefficients by which clips are grouped: seven harmonics.
const COMPARED: usize = 15;
/// The rounds of k-means, which converges in fewer.
const ROUNDS: usize = 12;
/// The fewest clips of a mean walk: a mean walk of one clip only moves the clip's bytes.
const MIN_MEMBERS: usize = 4;

/// The mean walks, and their assignment to clips.
#[derive(Clone, Debug, Default)]
pub(super) struct MeanWalks {
    pub(super) list: Vec<EncodedMeanWalk>,
    /// The number of each clip's mean walk, or `None` for all clips if mean walks save no bytes.
    pub(super) of: Vec<Option<usize>>,
}

impl MeanWalks {
    /// Returns the mean walks that make these clips shortest. The clips are rounded without any.
    pub(super) fn fit(sketches: &[Quantised], frames: &Frames) -> Self {
        let none = Self {
            of: vec![None; sketches.len()],
            ..Self::default()
        };
        let mut best = (none.total_bytes(sketches, frames), none);
        for count in TRIED {
            if sketches.len() < MIN_MEMBERS * count {
                break;
            }
            let templates = Self::of_groups(sketches, frames, count);
            let bytes = templates.total_bytes(sketches, frames);
            if bytes < best.0 {
                best = (bytes, templates);
            }
        }
        best.1
    }

    fn of_groups(sketches: &[Quantised], frames: &Frames, count: usize) -> Self {
        let points: Vec<Vec<f64>> = sketches
            .iter()
            .map(|sketch| point(sketch, frames))
            .collect();
        let groups = k_means(&points, count);
        let mut scales: Vec<u8> = sketches.iter().map(|sketch| sketch.scale).collect();
        scales.sort_unstable();
        let scale = scales.get(scales.len() / 2).copied().unwrap_or(0);
        let mut templates = Self::default();
        for group in 0..groups.iter().max().map_or(0, |most| most + 1) {
            let members: Vec<&Quantised> = sketches
                .iter()
                .zip(&groups)
                .filter_map(|(sketch, &own)| (own == group).then_some(sketch))
                .collect();
            let numbers = mean_walk(&members, frames, scale);
            templates
                .list
                .push(EncodedMeanWalk::new(scale, numbers, frames));
        }
        templates.of = groups.into_iter().map(Some).collect();
        templates
    }

    /// Returns the mean walk of a clip.
    pub(super) fn mean(&self, clip: usize) -> Option<&Mean> {
        self.of[clip].map(|group| &self.list[group].mean)
    }

    /// Estimates the bytes of clips, mean walks and Rice parameters.
    fn total_bytes(&self, sketches: &[Quantised], frames: &Frames) -> usize {
        let differences: Vec<CycleCoefficients> = sketches
            .iter()
            .enumerate()
            .map(|(clip, sketch)| difference(sketch, self.mean(clip), frames))
            .collect();
        let clips: Vec<&CycleCoefficients> = differences.iter().collect();
        let stored = self.list.iter().map(|template| template.numbers.clone());
        let stored: Vec<CycleCoefficients> = stored.collect();
        let parameters = RiceParameters::fit(&clips, &stored);
        let clip_bytes = clips.iter().map(|clip| parameters.write_clip(clip).len());
        let template_bytes = stored
            .iter()
            .map(|t| parameters.write_template(t).len() + 5);
        clip_bytes.sum::<usize>() + template_bytes.sum::<usize>() + parameters.to_bytes().len()
    }
}

/// Returns a clip's numbers relative to a mean walk.
pub(super) fn difference(
    sketch: &Quantised,
    mean: Option<&Mean>,
    frames: &Frames,
) -> CycleCoefficients {
    std::array::from_fn(|channel| {
        let own = &sketch.numbers[channel];
        let step = frames.step(channel, sketch.scale);
        let usual = mean.map_or(0, |mean| mean[channel].len());
        let mut numbers: Vec<i32> = (0..own.len().max(usual))
            .map(|index| {
                let number = own.get(index).copied().unwrap_or(0);
                #[expect(clippy::cast_possible_truncation, reason = "24 bits and a bit")]
                let usual = (mean_of(mean, channel, index) / step).round() as i32;
                number - usual
            })
            .collect();
        trim(&mut numbers);
        numbers
    })
}

/// Returns the mean of clips in steps.
fn mean_walk(members: &[&Quantised], frames: &Frames, scale: u8) -> CycleCoefficients {
    #[expect(clippy::cast_precision_loss, reason = "clips of a pack")]
    let count = members.len().max(1) as f64;
    std::array::from_fn(|channel| {
        let most = members.iter().map(|sketch| sketch.numbers[channel].len());
        let mut numbers: Vec<i32> = (0..most.max().unwrap_or(0))
            .map(|index| {
                let sum: f64 = members
                    .iter()
                    .map(|sketch| {
                        let number = sketch.numbers[channel].get(index).copied().unwrap_or(0);
                        f64::from(number) * frames.step(channel, sketch.scale)
                    })
                    .sum();
                #[expect(clippy::cast_possible_truncation, reason = "means of 24 bits")]
                let number = (sum / count / frames.step(channel, scale)).round() as i32;
                number
            })
            .collect();
        trim(&mut numbers);
        numbers
    })
}

/// Returns a clip as a point for k-means: coefficients in units of a step at one scale, so that
/// distances are those of poses.
fn point(sketch: &Quantised, frames: &Frames) -> Vec<f64> {
    let coordinates = (0..CHANNELS).flat_map(|channel| {
        let ratio = frames.step(channel, sketch.scale) / frames.step(channel, 0);
        (0..COMPARED).map(move |index| {
            let number = sketch.numbers[channel].get(index).copied().unwrap_or(0);
            f64::from(number) * ratio
        })
    });
    coordinates.collect()
}

/// Returns the group of each point.
fn k_means(points: &[Vec<f64>], count: usize) -> Vec<usize> {
    let distance =
        |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum() };
    let nearest = |centres: &[Vec<f64>], point: &[f64]| -> (usize, f64) {
        let distances = centres.iter().map(|centre| distance(centre, point));
        distances
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((0, 0.0))
    };
    let mut centres: Vec<Vec<f64>> = points.first().cloned().into_iter().collect();
    while centres.len() < count {
        let farthest = points
            .iter()
            .max_by(|a, b| nearest(&centres, a).1.total_cmp(&nearest(&centres, b).1));
        centres.extend(farthest.cloned());
    }
    for _ in 0..ROUNDS {
        let groups: Vec<usize> = points
            .iter()
            .map(|point| nearest(&centres, point).0)
            .collect();
        let members_of = |group: usize| -> Vec<&Vec<f64>> {
            let own = points.iter().zip(&groups);
            own.filter_map(|(point, &own): (_, &usize)| (own == group).then_some(point))
                .collect()
        };
        // Groups that are too small are removed, and their clips go to the nearest other group.
        centres = (0..centres.len())
            .map(members_of)
            .filter(|members| members.len() >= MIN_MEMBERS)
            .map(|members| centroid(&members))
            .collect();
    }
    points
        .iter()
        .map(|point| nearest(&centres, point).0)
        .collect()
}

fn centroid(members: &[&Vec<f64>]) -> Vec<f64> {
    #[expect(clippy::cast_precision_loss, reason = "clips of a pack")]
    let count = members.len().max(1) as f64;
    let coordinates = members.first().map_or(0, |member| member.len());
    (0..coordinates)
        .map(|index| members.iter().map(|member| member[index]).sum::<f64>() / count)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alike_points_are_one_group() {
        // Four about 0, four about 10, and one at 20, too few for a mean walk.
        let points: Vec<Vec<f64>> = [0.0, 10.0, 0.2, 9.9, 20.0, 0.1, 0.3, 10.1, 10.2]
            .iter()
            .map(|&x| vec![x, 1.0])
            .collect();
        let groups = k_means(&points, 3);
        assert_eq!([2, 5, 6].map(|clip| groups[clip]), [groups[0]; 3]);
        assert_eq!([3, 4, 7, 8].map(|clip| groups[clip]), [groups[1]; 4]);
        assert_ne!(groups[0], groups[1]);
    }
}
