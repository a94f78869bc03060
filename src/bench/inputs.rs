//! The inputs of models, drawn from a pack.

use crate::draw::sweep::{Job, Moments, Settings, Shot, Swept, View, Views, silhouettes, sweep};
use crate::draw::template::Template;
use crate::error::Result;
use crate::inference::Contract;
use edgegait_core::pack::Pack;

/// The walks that are drawn for a model, and how.
pub(crate) struct DrawnInputs<'a> {
    /// The pack.
    pub pack: &'a Pack<'a>,
    /// The numbers of the walks that are shown; at least one.
    pub walks: &'a [usize],
    /// The viewpoints from which accuracy is measured.
    pub views: &'a Views,
    /// The settings for drawing figures, as the model's contract specifies.
    pub settings: Settings,
}

impl DrawnInputs<'_> {
    /// Draws one input for a model with this contract and appends it to `input`. It shows the
    /// stored cycle of the walk at index `at` of the list (modulo its length) from the usual view
    /// ([`Contract::usual_views`]), as the model's template or as silhouettes, as many as the
    /// contract states (or else the settings). Includes decoding, posing and projection. Runs on
    /// the thread pool of the caller.
    ///
    /// # Errors
    /// If a figure cannot be drawn.
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

    /// Draws `frames` silhouettes of the first walk from the usual view: its stored cycle, then its
    /// seeded variations in turn, as in a tree of long recordings; the last one is cut. The
    /// settings give the number of frames in a cycle.
    ///
    /// # Errors
    /// If a figure cannot be drawn.
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

    /// Returns `count` inputs (at least one), which show the walks in turn.
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

/// Returns the viewpoint from which a model with this contract is shown walks.
fn usual_view(contract: &Contract) -> Result<Vec<View>> {
    Ok(vec![View::at(contract.usual_views()[0].into())?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::sweep::jobs;
    use crate::encode::encode_subjects;
    use crate::inference::InputLayout;
    use crate::people::cohort::{self, CohortOptions};

    #[test]
    fn a_models_input_is_its_walks_gei_or_its_silhouettes() {
        let options = CohortOptions {
            people: 2,
            speeds_kmh: vec![5.0],
            ..CohortOptions::default()
        };
        let people = cohort::subjects(&options).expect("two people");
        let bytes = encode_subjects(&people, 5.0, &|| Ok(())).expect("a pack");
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
        // A longer one begins with the cycle and continues with another cycle of the same person.
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
        // Their mean is the GEI, except for the rounding to bytes.
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
