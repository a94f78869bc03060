//! `edgegait score --protocol leave-one-take-out`: every take is looked for among all others.

use super::progress::Progress;
use super::score::{angles_of, shown as samples_of, walk_names};
use crate::dataset::Header;
use crate::error::{Error, Result};
use crate::evaluate::contest::run;
use crate::evaluate::leave_out::{Shown, leave_one_take_out, tallies};
use crate::evaluate::rank::Tally;
use crate::evaluate::results::{Contestant, Protocol, RecognizerResult, ScoreResults};
use crate::report::Sample;
use crate::score::Recognizer;
use crate::sweep::{Settings, Views, jobs, sweep};
use edgegait_core::pack::{Pack, Walk};
use edgegait_core::template::Gei;

/// Viewpoints whose GEIs are kept at once.
const VIEWS_AT_ONCE: usize = 37;

/// What one recognizer has achieved so far.
struct Score {
    by_viewpoint: Vec<((f64, f64), Tally)>,
    by_person: Vec<Tally>,
}

/// The walks that are scored, and from where.
pub struct Probes<'a> {
    pub pack: &'a Pack<'a>,
    /// Numbers of the walks.
    pub walks: &'a [usize],
    pub views: &'a Views,
    pub settings: Settings,
}

/// Scores recognizers on recorded cycles; how many of the first people's GEIs the report may show
/// is `samples`.
pub fn score(
    probes: &Probes<'_>,
    recognizers: &[Box<dyn Recognizer>],
    header: Header,
    samples: usize,
) -> Result<(ScoreResults, Vec<Sample>)> {
    let Probes {
        pack,
        walks,
        views,
        settings,
    } = *probes;
    let all: Vec<Walk<'_>> = pack.walks().collect();
    let names: Vec<&str> = pack.subjects().map(|subject| subject.name).collect();
    let jobs = jobs(pack, walks, 0..1)?;
    let shown = takes(walks.iter().map(|&walk| &all[walk]));
    let has_mate = |one: &Shown| {
        let of_person = |other: &Shown| other.person == one.person && other.take != one.take;
        shown.iter().any(of_person)
    };
    if !shown.iter().any(has_mate) {
        return Err(Error::Failed(
            "every person has one take: expected another to find it by".into(),
        ));
    }
    let mut scores: Vec<Score> = recognizers
        .iter()
        .map(|_| Score {
            by_viewpoint: Vec::new(),
            by_person: vec![Tally::default(); names.len()],
        })
        .collect();
    let (mut shots, mut clipped) = (Vec::new(), 0.0);
    let progress = Progress::new("viewpoints", views.list.len());
    for list in views.list.chunks(VIEWS_AT_ONCE) {
        let mut seen: Vec<Vec<Gei>> = vec![Vec::new(); list.len()];
        let keep = |_, swept| Ok(swept);
        sweep(pack, &jobs, list, settings, keep, |job, swept| {
            clipped += swept.clipped;
            if shots.len() < samples {
                shots.extend(samples_of(names[all[job.walk].subject], list, &swept.geis));
            }
            for (view, gei) in seen.iter_mut().zip(swept.geis) {
                view.push(gei);
            }
            Ok(())
        })?;
        for (view, geis) in list.iter().zip(&seen) {
            let pixels: Vec<&[u8]> = geis.iter().map(Gei::pixels).collect();
            for (score, recognizer) in scores.iter_mut().zip(recognizers) {
                let outputs = run(recognizer.as_ref(), &pixels)?;
                let outcomes =
                    leave_one_take_out(&outputs.embedding, outputs.embedding_dims, &shown)?;
                let (tally, people) = tallies(&outcomes, &shown, names.len());
                score.by_viewpoint.push((angles_of(view), tally));
                for (sum, tally) in score.by_person.iter_mut().zip(people) {
                    *sum += tally;
                }
            }
            progress.step();
        }
    }
    drop(progress);
    let geis = (jobs.len() * views.list.len()) as u64;
    let silhouettes = geis * u64::from(settings.frames_per_cycle);
    let people = shown_people(&shown);
    let seed = settings.seed;
    let results = scores.iter().zip(recognizers).map(|(score, recognizer)| {
        let contestant = Contestant {
            name: recognizer.name().to_owned(),
            runtime: recognizer.runtime().clone(),
            protocol: Protocol::LeaveOneTakeOut,
            classes: people,
            trained_at: Vec::new(),
        };
        let probed = score.by_person.iter().copied().filter(|one| one.probes > 0);
        let probed: Vec<Tally> = probed.collect();
        RecognizerResult::new(contestant, &score.by_viewpoint).with_subjects(&probed, seed)
    });
    let results = ScoreResults {
        silhouettes,
        geis,
        clipped_share: Some(clipped / silhouettes as f64),
        recognizers: results.collect(),
        time: None,
        header: header
            .with("walks", walk_names(walks, &all))
            .with("takes", shown.iter().map(|one| one.take + 1).max())
            .with(
                "probes",
                "recorded cycles of each take, gallery: all other takes at the same viewpoint",
            ),
    };
    Ok((results, shots))
}

/// Who and which take each walk is: cycles of one name of one person are one take.
fn takes<'p>(walks: impl Iterator<Item = &'p Walk<'p>>) -> Vec<Shown> {
    let mut known: Vec<(usize, &str)> = Vec::new();
    walks
        .map(|walk| {
            let key = (walk.subject, walk.name);
            let at = known.iter().position(|other| *other == key);
            let take = at.unwrap_or_else(|| {
                known.push(key);
                known.len() - 1
            });
            Shown {
                person: walk.subject,
                take,
            }
        })
        .collect()
}

/// How many people there are.
fn shown_people(shown: &[Shown]) -> usize {
    let mut people: Vec<usize> = shown.iter().map(|one| one.person).collect();
    people.sort_unstable();
    people.dedup();
    people.len()
}
