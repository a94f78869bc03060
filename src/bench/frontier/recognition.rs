//! The effect of a configuration on the shipped recognizers.

use crate::draw::sweep::{Job, Settings, Swept, sweep};
use crate::encode::within_error::reference::{ExactGeis, ReferenceSample};
use crate::error::Result;
use crate::evaluate::rank1::{Tally, closed_set};
use crate::inference::{Recognizer, Runtime, shipped};
use edgegait_core::pack::Pack;

/// The Rank-1 of a recognizer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rank1 {
    /// The name of the recognizer.
    pub name: String,
    /// The share of the probes that it recognizes, 0..=1.
    pub rank1: f64,
}

/// The loaded shipped recognizers, for people that are among their classes.
pub(super) struct ShippedRecognizers {
    recognizers: Vec<Box<dyn Recognizer>>,
}

impl ShippedRecognizers {
    /// Loads the shipped recognizers.
    ///
    /// # Errors
    /// Never, for the shipped models.
    pub(super) fn shipped() -> Result<Self> {
        let runtime = Runtime::rten();
        let models = shipped::linear()?;
        let recognizers = models.iter().map(|model| runtime.load(model));
        Ok(Self {
            recognizers: recognizers.collect::<Result<_>>()?,
        })
    }

    /// Returns the Rank-1 of each on a sample that is drawn with `settings`.
    ///
    /// # Errors
    /// If a figure cannot be drawn, or a recognizer fails.
    pub(super) fn of_drawn(
        &self,
        pack: &Pack<'_>,
        sample: &ReferenceSample,
        settings: Settings,
    ) -> Result<Vec<Rank1>> {
        let mut geis = Vec::with_capacity(sample.jobs.len());
        let pixels = |_: Job<'_>, swept: Swept| Ok(swept.templates);
        sweep(
            pack,
            &sample.jobs,
            &sample.views,
            settings,
            pixels,
            |_, found| {
                geis.push(found);
                Ok(())
            },
        )?;
        self.rank1(pack, sample, &geis)
    }

    /// Returns the Rank-1 of each on exact GEIs of a sample.
    ///
    /// # Errors
    /// If a recognizer fails.
    pub(super) fn of_exact(
        &self,
        pack: &Pack<'_>,
        sample: &ReferenceSample,
        geis: &ExactGeis,
    ) -> Result<Vec<Rank1>> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 255"
        )]
        let byte = |pixel: &f64| pixel.round() as u8;
        let bytes = |gei: &Vec<f64>| gei.iter().map(byte).collect();
        let geis = geis.iter().map(|geis| geis.iter().map(bytes).collect());
        self.rank1(pack, sample, &geis.collect::<Vec<_>>())
    }

    /// Returns the Rank-1 of each on GEIs in bytes, `[job][view][pixel]`, where the class with the
    /// highest score is the answer.
    fn rank1(
        &self,
        pack: &Pack<'_>,
        sample: &ReferenceSample,
        geis: &[Vec<Vec<u8>>],
    ) -> Result<Vec<Rank1>> {
        let subjects: Vec<&str> = pack.subjects().map(|subject| subject.name).collect();
        let walks: Vec<_> = pack.walks().collect();
        let of = |recognizer: &dyn Recognizer| {
            let contract = recognizer.contract();
            let mut tally = Tally::default();
            for (job, geis) in sample.jobs.iter().zip(geis) {
                let person = subjects[walks[job.walk].subject];
                let class = contract.classes.iter().position(|class| class == person);
                let mut input = Vec::new();
                for gei in geis {
                    contract.feed(gei, &mut input);
                    contract.feed_view(None, &mut input)?;
                }
                let outputs = recognizer.run(&input, geis.len())?;
                let scores = outputs.scores.unwrap_or_default();
                for scores in scores.chunks_exact(outputs.classes.max(1)) {
                    tally.add(closed_set(scores, class.unwrap_or(usize::MAX)));
                }
            }
            Ok(Rank1 {
                name: contract.name.clone(),
                rank1: tally.rank1().unwrap_or_default(),
            })
        };
        let recognizers = self.recognizers.iter().map(AsRef::as_ref);
        recognizers.map(of).collect()
    }
}
