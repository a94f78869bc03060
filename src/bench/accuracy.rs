//! The rank-1 of a recognizer, with the runtime and the settings that it was timed with.

use super::inputs::DrawnInputs;
use crate::draw::sweep::Views;
use crate::error::{Error, Result};
use crate::evaluate::contest::{ContestOptions, DrawnContest, Entrant};
use crate::evaluate::intervals::Rank1Intervals;
use crate::evaluate::paired_results::PersonResult;
use serde::{Deserialize, Serialize};

/// Rank-1 on walks that training has not seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Accuracy {
    /// The name of the protocol.
    pub protocol: String,
    /// The number of viewpoints from which each walk was seen.
    pub viewpoints: usize,
    /// The planned number of viewpoints; none in results of versions that do not state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub viewpoints_planned: Option<usize>,
    /// The number of probes.
    pub probes: u64,
    /// The share of hits, 0..1.
    pub rank1: f64,
    /// The 95 % intervals of rank-1.
    #[serde(flatten)]
    pub intervals: Rank1Intervals,
    /// The number of probes whose output was not finite; they count as misses.
    pub non_finite: u64,
    /// The hits by person; empty in results of versions that do not state them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by_person: Vec<PersonResult>,
    /// The caveats, which are among the model's warnings in results.
    #[serde(skip)]
    pub warnings: Vec<String>,
}

impl Accuracy {
    /// Returns the number of images that measuring rank-1 from these viewpoints takes.
    ///
    /// # Errors
    /// If the protocol does not fit the walks.
    pub(super) fn pictures(
        entrants: &[Entrant],
        scene: &DrawnInputs<'_>,
        views: &Views,
    ) -> Result<usize> {
        let drawn = drawn(entrants, scene, views)?;
        Ok(drawn.contest.source().sequences().list.len())
    }

    /// Measures rank-1 from the scene's viewpoints, under the default protocol of `edgegait score`.
    /// With `most`, uses only as many viewpoints, evenly spread, as make at most that many images;
    /// none if even one viewpoint makes more.
    ///
    /// # Errors
    /// If a figure cannot be drawn, or the recognizer fails.
    pub(super) fn within(
        entrants: &[Entrant],
        scene: &DrawnInputs<'_>,
        seed: u64,
        most: Option<usize>,
    ) -> Result<Option<Self>> {
        let views = match most {
            None => Some(scene.views.clone()),
            Some(most) => Self::views_within(entrants, scene, most)?,
        };
        let found = views.map(|views| Self::measure(entrants, scene, &views, seed));
        found.transpose()
    }

    /// Describes which part of this many viewpoints was left out; none if none was.
    #[must_use]
    pub(super) fn less(found: Option<&Self>, viewpoints: usize) -> Option<String> {
        match found.map(|found| found.viewpoints) {
            None => Some("no rank-1".to_owned()),
            Some(some) if some < viewpoints => {
                Some(format!("rank-1 from {some} of {viewpoints} viewpoints"))
            }
            Some(_) => None,
        }
    }

    /// Returns as many viewpoints, evenly spread, as make at most `most` images; none if even one
    /// makes more.
    fn views_within(
        entrants: &[Entrant],
        scene: &DrawnInputs<'_>,
        most: usize,
    ) -> Result<Option<Views>> {
        let all = &scene.views.list;
        let mut count = all.len();
        while count > 0 {
            // The middle of each of `count` equal parts of the list.
            let at = |part: usize| (2 * part + 1) * all.len() / (2 * count);
            let views = Views {
                name: scene.views.name.clone(),
                list: (0..count).map(|part| all[at(part)]).collect(),
            };
            let pictures = Self::pictures(entrants, scene, &views)?;
            if pictures <= most {
                return Ok(Some(views));
            }
            count = (count - 1).min(count * most / pictures);
        }
        Ok(None)
    }

    fn measure(
        entrants: &[Entrant],
        scene: &DrawnInputs<'_>,
        views: &Views,
        seed: u64,
    ) -> Result<Self> {
        let drawn = drawn(entrants, scene, views)?;
        let outcome = drawn
            .contest
            .run(entrants, seed, &mut |_| Ok(()), &mut |_| Ok(()))?;
        let result = outcome.results.into_iter().next();
        let result = result.ok_or(Error::Missing("the result of one recognizer"))?;
        let own = outcome.warnings.into_iter().map(|warning| warning.text);
        let warnings = drawn.warnings.into_iter().chain(own).collect();
        Ok(Self {
            protocol: result.protocol,
            viewpoints: views.list.len(),
            viewpoints_planned: Some(scene.views.list.len()),
            probes: result.probes,
            rank1: result.rank1,
            intervals: result.intervals,
            non_finite: result.non_finite,
            by_person: result.by_person,
            warnings,
        })
    }
}

fn drawn<'a>(
    entrants: &[Entrant],
    scene: &'a DrawnInputs<'_>,
    views: &Views,
) -> Result<DrawnContest<'a>> {
    let options = ContestOptions {
        views: Some(views.clone()),
        ..ContestOptions::default()
    };
    DrawnContest::new(scene.pack, scene.walks, entrants, options)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::sweep::{Settings, View};
    use crate::encode::encode_subjects;
    use crate::inference::Contract;
    use crate::inference::testing::MadeUp;
    use crate::people::cohort::{self, CohortOptions};
    use edgegait_core::pack::Pack;

    #[test]
    fn as_many_viewpoints_as_there_is_time_for_are_spread_over_all_of_them() {
        let options = CohortOptions {
            people: 2,
            speeds_kmh: vec![5.0],
            ..CohortOptions::default()
        };
        let people = cohort::subjects(&options).expect("two people");
        let bytes = encode_subjects(&people, 5.0, &|| Ok(())).expect("a pack");
        let pack = Pack::parse(&bytes).expect("it was just encoded");
        let azimuths = (0..9_u8).map(|step| 20.0 * f32::from(step));
        let views = Views::grid("nine", azimuths, [0.0]).expect("viewpoints");
        let scene = DrawnInputs {
            pack: &pack,
            walks: &[0, 1],
            views: &views,
            settings: Settings::default(),
        };
        let contract = Contract {
            classes: people.iter().map(|subject| subject.name.clone()).collect(),
            ..Contract::default()
        };
        let recognizer = MadeUp::new(contract, |_| vec![1.0, 0.0]);
        let entrants = [Entrant {
            recognizer: Box::new(recognizer),
            settings: Settings::default(),
            model_bytes: None,
        }];
        // Each viewpoint has two probes, one for each person.
        let all = Accuracy::pictures(&entrants, &scene, &views).expect("a contest");
        assert_eq!(all, 18);
        let found = |most| {
            let found = Accuracy::within(&entrants, &scene, 1, most).expect("measured");
            found.map(|it| (it.viewpoints, it.viewpoints_planned, it.probes))
        };
        assert_eq!(found(None), Some((9, Some(9), 18)));
        assert_eq!(found(Some(18)), Some((9, Some(9), 18)));
        assert_eq!(found(Some(7)), Some((3, Some(9), 6)));
        assert_eq!(found(Some(1)), None);
        let three = Accuracy::views_within(&entrants, &scene, 6).expect("three");
        // The second, fifth and eighth of the nine viewpoints.
        let expected = [20.0, 80.0, 140.0].map(|azimuth| View::new(azimuth, 0.0).expect("one"));
        assert_eq!(
            three.map(|views| views.list).as_deref(),
            Some(&expected[..])
        );
        assert_eq!(Accuracy::less(None, 9).as_deref(), Some("no rank-1"));
    }
}
