//! The gait cycles of real people, from the silhouettes of a tree.

use super::example::{Example, SIZE, gei};
use super::likeness::mean;
use super::manifest::Pairing;
use super::masks::{Masks, jaccard};
use crate::dataset::gait_cycles::{CycleFinder, LowerBody};
use crate::dataset::{Tree, framed};
use crate::draw::sweep::FramingMode;
use crate::error::Result;
use rayon::prelude::*;

/// A take of a person seen from one viewpoint.
#[derive(Clone, Debug)]
pub(crate) struct ShownTake {
    /// The row of the manifest.
    pub pairing: Pairing,
    /// The number of the sequence in the tree.
    pub sequence: usize,
    /// The number of the person.
    pub person: usize,
    /// The number of the take among the takes of all people.
    pub take: usize,
}

/// The gait cycles from one viewpoint with one kind of masks, in each framing.
#[derive(Clone, Debug, Default)]
pub(crate) struct RealCycles {
    /// The cycles in each of the requested framings.
    pub by_framing: Vec<Vec<Example>>,
    /// The takes without a cycle, and the reasons.
    pub without: Vec<String>,
    /// The mean Jaccard index of each take's masks with the stored masks of the tree.
    pub mask_jaccards: Vec<f64>,
}

/// Reads takes with one kind of masks, on all cores. `progress` is called once per take.
///
/// # Errors
/// If a file is broken.
pub(crate) fn read(
    tree: &Tree,
    takes: &[&ShownTake],
    masks: Masks,
    seed: u64,
    framings: &[FramingMode],
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<RealCycles> {
    let one = |shown: &&ShownTake| {
        let found = take(tree, shown, masks, seed, framings);
        progress()?;
        Ok(found)
    };
    let found: Vec<Result<_>> = takes.par_iter().map(one).collect::<Result<_>>()?;
    let mut real = RealCycles {
        by_framing: vec![Vec::new(); framings.len()],
        ..RealCycles::default()
    };
    for found in found {
        match found? {
            Ok(take) => {
                real.mask_jaccards.push(take.mask_jaccard);
                for (all, own) in real.by_framing.iter_mut().zip(take.by_framing) {
                    all.extend(own);
                }
            }
            Err(reason) => real.without.push(reason),
        }
    }
    Ok(real)
}

/// What a take shows.
struct RealTake {
    /// Its cycles, by framing.
    by_framing: Vec<Vec<Example>>,
    /// The Jaccard index of its masks with the tree's.
    mask_jaccard: f64,
}

/// Reads a take; without a cycle, returns the reason.
fn take(
    tree: &Tree,
    shown: &ShownTake,
    masks: Masks,
    seed: u64,
    framings: &[FramingMode],
) -> Result<std::result::Result<RealTake, String>> {
    let Pairing {
        person,
        take,
        view,
        fps,
        offset,
        contacts,
        ..
    } = &shown.pairing;
    let name = format!("{person}/{take}/{view}");
    let (mut frames, mut columns) = (Vec::new(), 1);
    tree.show(shown.sequence, |pixels, wide| {
        frames.push(pixels.to_vec());
        columns = wide;
        Ok(())
    })?;
    let spans = match &shown.pairing.cycles {
        Some(spans) => spans.clone(),
        None => {
            let legs = frames
                .iter()
                .map(|frame| LowerBody::of_pixels(frame, columns));
            #[expect(clippy::cast_possible_truncation, reason = "frames a second")]
            match CycleFinder::new(*fps as f32)?.find(legs) {
                Ok(found) => {
                    let spans = found.cycles.iter();
                    spans.map(|cycle| (cycle.start, cycle.end)).collect()
                }
                Err(reason) => return Ok(Err(format!("{name}: {reason}"))),
            }
        }
    };
    let seen = masks.apply(frames.clone(), columns, &name, seed);
    let alike: Vec<f64> = seen
        .iter()
        .zip(&frames)
        .map(|(a, b)| jaccard(a, b))
        .collect();
    let mut by_framing = Vec::new();
    for &framing in framings {
        let mut examples = Vec::new();
        for &(from, to) in &spans {
            // The frames in [from, to).
            let mut framed_frames = Vec::new();
            let numbers = from.ceil() as usize..to.ceil() as usize;
            for (number, pixels) in seen
                .iter()
                .enumerate()
                .filter(|(at, _)| numbers.contains(at))
            {
                if let Some(silhouette) = framed(pixels, columns, SIZE, framing)? {
                    let phase = phase(number as f64, (from, to), contacts);
                    framed_frames.push((phase, silhouette));
                }
            }
            if framed_frames.is_empty() {
                continue;
            }
            examples.push(Example {
                person: shown.person,
                take: shown.take,
                position: examples.len(),
                span_s: ((from + offset) / fps, (to + offset) / fps),
                gei: gei(framed_frames.iter().map(|(_, frame)| frame)),
                frames: framed_frames,
            });
        }
        if examples.is_empty() {
            return Ok(Err(format!(
                "{name}: no frame of its cycles shows a person"
            )));
        }
        by_framing.push(examples);
    }
    Ok(Ok(RealTake {
        by_framing,
        mask_jaccard: mean(&alike),
    }))
}

/// Returns the phase of a frame, 0..1: 0 at a left contact, and linear between contacts and beyond.
/// Without contacts it is 0 at the beginning of the cycle.
fn phase(frame: f64, (from, to): (f64, f64), contacts: &[f64]) -> f64 {
    let period = to - from;
    let behind = contacts.iter().rposition(|contact| *contact <= frame);
    let share = match (behind, contacts.first()) {
        (Some(at), _) => {
            let next = contacts
                .get(at + 1)
                .map_or(period, |next| next - contacts[at]);
            (frame - contacts[at]) / next
        }
        (None, Some(first)) => (frame - first) / period,
        (None, None) => (frame - from) / period,
    };
    share.rem_euclid(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_begin_at_left_contacts_and_go_on_beyond_them() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        let cycle = (0.0, 32.0);
        near(phase(26.0, cycle, &[10.0, 42.0]), 0.5);
        near(phase(10.0, cycle, &[10.0, 42.0]), 0.0);
        // A quarter of the period before the first contact, and after the last.
        near(phase(2.0, cycle, &[10.0, 42.0]), 0.75);
        near(phase(50.0, cycle, &[10.0, 42.0]), 0.25);
        near(phase(8.0, cycle, &[]), 0.25);
    }
}
