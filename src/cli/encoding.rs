//! How closely walks are encoded, or in how many bytes.

use super::args::{Common, gei_rmse, stated_choice};
use super::progress::Progress;
use crate::dataset::Header;
use crate::encode::{
    BUDGET_TRIES, MAX_ERROR_MM, body_error_mm, check_walks, encode_subjects, encode_within,
};
use crate::error::{Error, Result};
use crate::frontier::choose::{self, Choice};
use crate::frontier::configuration::Encoding;
use crate::scene::Subject;
use crate::scene::thin::with_thinner_bodies;
use edgegait_core::pack::Pack;

/// Greatest error by default where a body was fitted to a mesh, mm: 5 mm would cost 0.002 of its
/// Jaccard index, which is what a third of its points is worth.
const FITTED_ERROR_MM: f64 = 1.0;

/// The flags.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct EncodingArgs {
    /// Greatest encoding error of a walk in mm; a body has two fifths of it, up to 4 mm [default: 5;
    /// 1 with a body that is fitted to a mesh]
    #[arg(long, value_name = "E")]
    max_error_mm: Option<f64>,
    /// Most bytes of the pack: the smallest error that fits is found, from 0.1 mm on
    #[arg(long, value_name = "N", conflicts_with = "max_error_mm")]
    budget_bytes: Option<usize>,
    /// Most points of all hulls of a body together, 64 to 768: those are kept that reach farthest; a body that is fitted to a mesh is fitted with so many, 96 to 512 [default: all; 384]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(64..=768))]
    pub hull_points: Option<u16>,
    /// Choose the error and the hull points of fewest bytes whose GEIs are this close to those of the
    /// finest encoding, root mean square of 255, on a sample of these walks over 20 viewpoints
    #[arg(long, value_name = "X", value_parser = gei_rmse, conflicts_with_all = ["max_error_mm", "budget_bytes", "hull_points"])]
    max_gei_rmse: Option<f64>,
}

/// A pack and the error that its walks were to have at most, mm.
pub struct Encoded {
    pub bytes: Vec<u8>,
    pub max_error_mm: f64,
    hull_points: Option<usize>,
    choice: Option<Choice<Encoding>>,
}

impl EncodingArgs {
    /// Refuses errors that make no sense, before any work is done.
    ///
    /// # Errors
    /// For a negative one, and one that is not a number.
    pub fn check(&self) -> Result<()> {
        match self.max_error_mm {
            Some(error) if !(0.0..=1e6).contains(&error) => Err(Error::Usage(format!(
                "--max-error-mm {error}: expected 0 to 1,000,000"
            ))),
            _ => Ok(()),
        }
    }

    /// Encodes people with a progress bar called `what`.
    ///
    /// # Errors
    /// As [`encode_subjects`] and [`encode_within`].
    pub fn encode(&self, what: &'static str, people: &[Subject]) -> Result<Encoded> {
        check_walks(people)?;
        let choice = match self.max_gei_rmse {
            Some(most) => Some(choose::encoding(people, most)?),
            None => None,
        };
        let chosen = choice.as_ref().map(|choice| choice.chosen);
        let hull_points = chosen
            .map(|encoding| encoding.hull_points)
            .or(self.hull_points.map(usize::from));
        let people = match hull_points {
            Some(most) => &with_thinner_bodies(people, most)?,
            None => people,
        };
        let walks: usize = people.iter().map(|subject| subject.walks.len()).sum();
        let (bytes, max_error_mm) = if let Some(budget) = self.budget_bytes {
            let progress = Progress::new(what, walks * BUDGET_TRIES);
            encode_within(people, budget, &|| progress.step())?
        } else {
            let progress = Progress::new(what, walks);
            let chosen = chosen.map(|encoding| encoding.track_error_mm);
            let is_fitted = people.iter().any(|subject| subject.body.fit.is_some());
            let usual = if is_fitted {
                FITTED_ERROR_MM
            } else {
                MAX_ERROR_MM
            };
            let max_error_mm = chosen.or(self.max_error_mm).unwrap_or(usual);
            let bytes = encode_subjects(people, max_error_mm, &|| progress.step())?;
            (bytes, max_error_mm)
        };
        Ok(Encoded {
            bytes,
            max_error_mm,
            hull_points,
            choice,
        })
    }

    /// A result's header with how people were encoded, by the names of the flags.
    #[must_use]
    pub fn stated(&self, header: Header, encoded: &Encoded) -> Header {
        let header = header
            .with("max_error_mm", encoded.max_error_mm)
            .with("budget_bytes", self.budget_bytes)
            .with("hull_points", encoded.hull_points);
        match &encoded.choice {
            Some(choice) => stated_choice(header, self.max_gei_rmse, choice),
            None => header,
        }
    }
}

impl Encoded {
    /// Prints what `--max-gei-rmse` chose, and why.
    pub fn say_choice(&self, common: &Common) {
        if let Some(choice) = &self.choice {
            common.say(format_args!("chosen: {choice}"));
        }
    }

    /// Warnings if walks or bodies miss the error that was asked for.
    ///
    /// # Errors
    /// When the bytes are no pack.
    pub fn missed_errors(&self) -> Result<Vec<String>> {
        let pack = Pack::parse(&self.bytes)?;
        let clips = (0..pack.clip_count()).filter_map(|index| pack.clip(index));
        let clips: Vec<f32> = clips.map(|clip| clip.max_error_mm()).collect();
        let avatars = (0..pack.avatar_count()).filter_map(|index| pack.avatar(index));
        let avatars: Vec<f32> = avatars.map(|avatar| avatar.max_error_mm()).collect();
        let kinds = [
            ("walks", clips, self.max_error_mm),
            ("bodies", avatars, body_error_mm(self.max_error_mm)),
        ];
        Ok(kinds
            .into_iter()
            .filter_map(|(what, errors, asked_mm)| missed(what, &errors, asked_mm))
            .collect())
    }
}

/// A warning if some of these errors are above what was asked for.
fn missed(what: &str, errors: &[f32], asked_mm: f64) -> Option<String> {
    let errors = errors.iter().map(|&error| f64::from(error));
    let (all, most) = (errors.len(), errors.clone().fold(0.0, f64::max));
    // Stored errors are rounded up to 0.01 mm.
    let missed = errors.filter(|&error| error > asked_mm + 0.011).count();
    (missed > 0).then(|| {
        format!(
            "{missed} of {all} {what} miss the error of {asked_mm:.2} mm, by up to {:.2} mm: the format is not finer for them",
            most - asked_mm
        )
    })
}
