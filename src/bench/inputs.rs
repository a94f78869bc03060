//! What a model is given: from a pack to the numbers of its input.

use crate::error::Result;
use crate::score::Contract;
use crate::sweep::{Job, Moments, Settings, Shot, Swept, View, Views, silhouettes, sweep};
use crate::template::Template;
use edgegait_core::pack::Pack;

/// What is drawn for a model.
pub(crate) struct DrawnInputs<'a> {
    /// The pack.
    pub pack: &'a Pack<'a>,
    /// Walks that are shown, by number; at least one.
    pub walks: &'a [usize],
    /// From where accuracy is measured.
    pub views: &'a Views,
    /// How figures are drawn, as the model asks.
    pub settings: Settings,
}

impl DrawnInputs<'_> {
    /// The usual view ([`Contract::usual_views`]) of the stored cycle of the walk at this place of the list, which begins
    /// anew at its end, as one input of a model with this contract: the walk is decoded, posed,
    /// projected and drawn, and made into the model's template or kept as silhouettes, as many as the
    /// contract says (or the settings, if it leaves that free). It is appended to `input`. On
    /// the pool of threads that this is called in.
    ///
    /// # Errors
    /// When a figure cannot be drawn.
    pub(crate) fn append_input(
        &self,
        contract: &Contract,
        at: usize,
        input: &mut Vec<f32>,
    ) -> Result<()> {
        let job = Job::plain(self.walks[at % self.walks.len()], 0);
        let views = usual_view(contract)?;
        let settings = Settings {
            template: contract.template,
            ..self.settings
        };
        match contract.template {
            Template::Silhouettes => {
                let shot = Shot {
                    job,
                    moments: Moments::Cycle,
                    views: &views,
                };
                let mut pixels = Vec::new();
                for frame in silhouettes(self.pack, shot, settings)?.iter().flatten() {
                    pixels.extend_from_slice(frame.to_coverage().pixels());
                }
                contract.feed(&pixels, input);
                contract.feed_view(Some(views[0].angles_deg()), input)
            }
            _ => {
                let made = |_: Job, swept: Swept| Ok(swept.templates);
                sweep(self.pack, &[job], &views, settings, made, |_, made| {
                    for bytes in made {
                        contract.feed(&bytes, input);
                    }
                    contract.feed_view(Some(views[0].angles_deg()), input)
                })
            }
        }
    }

    /// The side view of so many frames of the first walk, as silhouettes: its stored cycle, then the
    /// seeded variations of it one after another, as a tree of long recordings has them, the last one
    /// cut. A cycle has as many frames as the settings say.
    ///
    /// # Errors
    /// When a figure cannot be drawn.
    pub(super) fn sequence(&self, contract: &Contract, frames: usize) -> Result<Vec<f32>> {
        let views = usual_view(contract)?;
        let settings = Settings {
            template: contract.template,
            ..self.settings
        };
        let numbers = frames * contract.numbers();
        let mut pixels = Vec::with_capacity(numbers);
        for variation in 0.. {
            if pixels.len() >= numbers {
                break;
            }
            let shot = Shot {
                job: Job::plain(self.walks[0], variation),
                moments: Moments::Cycle,
                views: &views,
            };
            for frame in silhouettes(self.pack, shot, settings)?.iter().flatten() {
                pixels.extend_from_slice(frame.to_coverage().pixels());
            }
        }
        pixels.truncate(numbers);
        let mut input = Vec::new();
        contract.feed(&pixels, &mut input);
        contract.feed_view(Some(views[0].angles_deg()), &mut input)?;
        Ok(input)
    }

    /// So many inputs (at least one), one after another, of one walk after the other.
    ///
    /// # Errors
    /// As [`Self::append_input`].
    pub(crate) fn inputs(&self, contract: &Contract, count: usize) -> Result<Vec<f32>> {
        let mut inputs = Vec::new();
        let drawn = count.min(self.walks.len());
        for at in 0..drawn {
            self.append_input(contract, at, &mut inputs)?;
        }
        let length = inputs.len() / drawn * count;
        let mut all = Vec::with_capacity(length);
        all.extend(inputs.iter().cycle().take(length));
        Ok(all)
    }
}

/// From where a model with this contract is shown walks.
fn usual_view(contract: &Contract) -> Result<Vec<View>> {
    Ok(vec![View::at(contract.usual_views()[0].into())?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::encode_subjects;
    use crate::people::cohort::{self, CohortOptions};
    use crate::score::InputLayout;
    use crate::sweep::jobs;

    #[test]
    fn a_models_input_is_its_walks_gei_or_its_silhouettes() {
        let options = CohortOptions {
            people: 2,
            speeds_kmh: vec![5.0],
            ..CohortOptions::default()
        };
        let people = cohort::subjects(&options).expect("two people");
        let bytes = encode_subjects(&people, 5.0, &|| {}).expect("a pack");
        let pack = Pack::parse(&bytes).expect("it was just encoded");
        let views = Views::side().expect("the side");
        let scene = DrawnInputs {
            pack: &pack,
            walks: &[0, 1],
            views: &views,
            settings: Settings::default(),
        };
        // Three inputs of two walks: the first, the second, the first.
        let geis = scene.inputs(&Contract::default(), 3).expect("drawn");
        let jobs = jobs(&pack, &[0, 1], 0..1).expect("cycles");
        let mut swept: Vec<Vec<Vec<u8>>> = Vec::new();
        let keep = |_: Job<'_>, swept: Swept| Ok(swept.templates);
        sweep(
            &pack,
            &jobs,
            &views.list,
            scene.settings,
            keep,
            |_, geis| {
                swept.push(geis);
                Ok(())
            },
        )
        .expect("drawn");
        for (found, walk) in geis.chunks(1500).zip([0, 1, 0]) {
            let bytes = swept[walk][0].iter();
            let expected: Vec<f32> = bytes.map(|&byte| f32::from(byte) / 255.0).collect();
            assert_eq!(found, expected);
        }
        assert_eq!(geis.len(), 3 * 1500);

        let sequences = Contract {
            template: Template::Silhouettes,
            layout: InputLayout::Nthw,
            ..Contract::default()
        };
        let frames = scene.inputs(&sequences, 1).expect("drawn");
        assert_eq!(frames.len(), 32 * 1500);
        // A longer one begins with the cycle, and goes on with another one of the same walker.
        let longer = scene.sequence(&sequences, 40).expect("drawn");
        assert_eq!(
            (longer.len(), &longer[..32 * 1500]),
            (40 * 1500, &frames[..])
        );
        let (again, more) = (&frames[..8 * 1500], &longer[32 * 1500..]);
        let other = again.iter().zip(more).filter(|(a, b)| a != b).count();
        assert!((1..8 * 1500 / 10).contains(&other), "{other}");
        let shorter = scene.sequence(&sequences, 5).expect("drawn");
        assert_eq!(shorter, frames[..5 * 1500]);
        // Their mean is the GEI, but for the rounding to bytes.
        for (pixel, gei) in geis[..1500].iter().enumerate() {
            let mean = (0..32)
                .map(|frame| frames[1500 * frame + pixel])
                .sum::<f32>()
                / 32.0;
            assert!(
                (mean - gei).abs() <= 0.5001 / 255.0,
                "{pixel}: {mean} {gei}"
            );
        }
    }
}
