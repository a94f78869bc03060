//! Contests with walks of a pack, which are rendered.

use super::{Contest, Entrant, training_views};
use crate::dataset::sequences::{PackWalks, SequenceSource};
use crate::draw::confounders::Condition;
use crate::draw::sweep::{View, Views};
use crate::error::{ChoiceError, EvaluateError, Result};
use crate::evaluate::protocol::{Decision, GalleryViews, Protocol};
use crate::inference::Contract;
use edgegait_core::pack::Pack;

/// Options of a contest with the walks of a pack.
#[derive(Clone, Debug, Default)]
pub struct ContestOptions<'a> {
    /// The protocol. By default `closed-set` where every recognizer has a class for every person,
    /// else `first-take`.
    pub protocol: Option<Protocol>,
    /// Cycles of each take that the protocol makes from a walk.
    pub cycles: Option<u32>,
    /// Viewpoints of the probes. By default the protocol's, or those of [`Views::paper`].
    pub views: Option<Views>,
    /// The conditions named by the takes in the protocol's `made`, if they name any. Otherwise,
    /// probes are seen under each of these conditions, or unchanged if the list is empty.
    pub conditions: &'a [Condition],
}

/// A contest with the walks of a pack, which are rendered.
pub struct DrawnContest<'a> {
    /// The contest.
    pub contest: Contest<'a>,
    /// Viewpoints of the probes.
    pub views: Views,
    /// Which cycles the probes are, for results.
    pub probes: String,
    /// Caveats for its results.
    pub warnings: Vec<String>,
}

impl<'a> DrawnContest<'a> {
    /// Returns whether the probes of the default protocol are seeded variations, so that there can
    /// be any number of them.
    ///
    /// # Errors
    /// If one of the walks is an uncut motion.
    pub fn is_made(pack: &Pack<'_>, walks: &[usize], entrants: &[Entrant]) -> Result<bool> {
        let cycles = PackWalks::recorded(pack, walks)?;
        let protocol = usual(entrants, &cycles.sequences().subjects)?;
        Ok(protocol.decision == Decision::ClassScore || cycles.are_of_one_take())
    }

    /// Creates a contest with the walks of these numbers. Where class scores decide, or no person
    /// has more than one take, takes are made from the walks as the protocol specifies.
    ///
    /// # Errors
    /// If the protocol does not suit the walks or the recognizers.
    pub fn new(
        pack: &'a Pack<'a>,
        walks: &[usize],
        entrants: &[Entrant],
        options: ContestOptions<'a>,
    ) -> Result<Self> {
        let mut cycles = PackWalks::recorded(pack, walks)?;
        let mut warnings = Vec::new();
        let mut protocol = match options.protocol {
            Some(protocol) => protocol,
            None => {
                let people = cycles.sequences().subjects;
                warnings.extend(unlike_protocols(entrants, &people));
                usual(entrants, &people)?
            }
        };
        let mut probes = "recorded cycles".to_owned();
        if protocol.decision == Decision::ClassScore || cycles.are_of_one_take() {
            let made = protocol.made(options.cycles.unwrap_or(1))?;
            let variations = made.iter().map(|take| take.variation).filter(|it| *it > 0);
            let (Some(first), Some(last)) = (variations.clone().min(), variations.max()) else {
                return Err(EvaluateError::NothingMade(protocol.name).into());
            };
            probes = format!("variations {first} to {last}");
            if protocol.decision == Decision::NearestEmbedding {
                warnings.push(
                    "every person has one take: more are generated from it, as seeded variations of its cycle".into(),
                );
            }
            cycles = PackWalks::made(pack, walks, &made, options.conditions)?;
        } else if options.cycles.is_some() {
            return Err(ChoiceError::CyclesAreRecorded(protocol.name).into());
        }
        let views = match (options.views, &protocol.views) {
            (Some(views), _) => views,
            (None, Some(grid)) => {
                let (azimuths, elevations) = (grid.azimuth_deg.clone(), grid.elevation_deg.clone());
                Views::grid(protocol.name.as_str(), azimuths, elevations)?
            }
            (None, None) => {
                let (views, warning) = usual_views(entrants)?;
                warnings.extend(warning);
                views
            }
        };
        let mut roles = protocol.roles(&cycles.sequences().takes)?;
        if protocol.conditions.is_none() && !options.conditions.is_empty() {
            let (known, probed) = (
                |take: usize| roles.gallery[take],
                |take| roles.is_probed(take),
            );
            let plain = cycles.sequences().takes;
            cycles = cycles.under(options.conditions, known, probed);
            roles = roles.under(options.conditions, &plain, &cycles.sequences().takes);
            protocol = protocol.under(options.conditions);
        }
        let mut gallery = Vec::new();
        if protocol.gallery_views == GalleryViews::Training {
            for entrant in entrants {
                add(&mut gallery, training_views(entrant.recognizer.contract())?);
            }
        } else {
            add(&mut gallery, views.list.iter().copied());
        }
        let seed = entrants.first().map_or(0, |entrant| entrant.settings.seed);
        let walks = cycles.seen(&views.list, seed, |take| {
            let mut seen = Vec::new();
            if roles.gallery[take] {
                seen.extend(gallery.iter().copied());
            }
            if roles.is_probed(take) {
                add(&mut seen, views.list.iter().copied());
            }
            seen
        });
        Ok(Self {
            contest: Contest::with_roles(SequenceSource::Walks(walks), protocol, roles),
            views,
            probes,
            warnings,
        })
    }
}

/// Returns the default viewpoints: the training viewpoints that all recognizers that take a
/// viewpoint as input have in common, or else those of [`Views::paper`]. Also returns a warning if
/// other recognizers would have more of them alone.
fn usual_views(entrants: &[Entrant]) -> Result<(Views, Option<String>)> {
    let contracts = entrants.iter().map(|entrant| entrant.recognizer.contract());
    let is_bound = |contract: &&Contract| {
        contract.view_input.is_some() && !contract.training.viewpoints.is_empty()
    };
    let bound: Vec<&Contract> = contracts.filter(is_bound).collect();
    let Some(first) = bound.first() else {
        return Ok((Views::paper()?, None));
    };
    let is_common = |view: &View| {
        let at = Some(view.angles_deg());
        bound.iter().all(|other| other.view_number(at).is_some())
    };
    let mut list = training_views(first)?;
    list.retain(is_common);
    let names: Vec<&str> = bound
        .iter()
        .map(|contract| contract.name.as_str())
        .collect();
    let names = names.join(", ");
    let learnt = entrants.iter();
    let learnt = learnt.filter(|entrant| !entrant.recognizer.is_baseline());
    let warning = (learnt.count() > bound.len()).then(|| {
        format!("all probes are seen from viewpoints of {names}, which takes no other viewpoints")
    });
    let name = format!("viewpoints of {names}");
    Ok((Views { name, list }, warning))
}

/// Adds views that are not in the list yet.
fn add(views: &mut Vec<View>, more: impl IntoIterator<Item = View>) {
    for view in more {
        if !views.contains(&view) {
            views.push(view);
        }
    }
}

/// Returns the default protocol for these people.
///
/// # Errors
/// Never.
pub fn usual(entrants: &[Entrant], subjects: &[String]) -> Result<Protocol> {
    let is_known = entrants.iter().all(|entrant| knows(entrant, subjects));
    Protocol::named(if is_known { "closed-set" } else { "first-take" })
}

/// Returns a warning if some recognizers have classes for all people, and others have not: then
/// [`usual`] compares all of them by embeddings, and would not compare the first alone so.
pub(crate) fn unlike_protocols(entrants: &[Entrant], subjects: &[String]) -> Option<String> {
    let learnt = entrants.iter();
    let learnt = learnt.filter(|entrant| !entrant.recognizer.is_baseline());
    let (known, unknown): (Vec<&Entrant>, Vec<&Entrant>) =
        learnt.partition(|entrant| knows(entrant, subjects));
    if known.is_empty() || unknown.is_empty() {
        return None;
    }
    let names = |entrants: &[&Entrant]| {
        let names = entrants.iter().map(|entrant| entrant.recognizer.name());
        names.collect::<Vec<_>>().join(", ")
    };
    Some(format!(
        "the protocol is first-take, since these have no classes for all people: {}; without them it is closed-set for {}",
        names(&unknown),
        names(&known)
    ))
}

/// Returns whether a recognizer has a class for each of these people.
fn knows(entrant: &Entrant, subjects: &[String]) -> bool {
    let classes = &entrant.recognizer.contract().classes;
    subjects.iter().all(|subject| classes.contains(subject))
}
