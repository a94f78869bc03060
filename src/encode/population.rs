//! Encoding of large populations: each person alone, with a code that the library contains.
//!
//! [`encode_subjects`](super::encode_subjects) fits joint frames, mean walks and Rice parameters to
//! the walks of one pack, so that a walk's bytes depend on all others. Populations use those of
//! `population.json`, which were fitted once to other people: a person's bytes are the same in any
//! pack, and people are encoded as they are generated.

use super::MAX_ERROR_MM;
use super::codebook::{Code, ErrorsOfAll, StoredCode};
use super::cycle::{Quantised, quantise, quickly, rounded_at};
use super::mean_walks::difference;
use super::motion_sections::{TIGHTER, TRIES};
use super::pack::{Bodies, PackBuilder, body_error_mm, refused};
use super::target::{EncodingTarget, JointErrors, worst};
use crate::error::{EncodeError, Error, Result};
use crate::people::{Subject, Track};
use edgegait_core::budget::{MAX_ENTRIES, MAX_PACK_BYTES};
use edgegait_core::codebook::Codebook;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::LazyLock;

/// The code of populations: fitted to the 40 people of seed 0 at the ten built-in speeds, within
/// 5 mm, with as many groups of coefficients as the format holds.
static CODE: LazyLock<Code> = LazyLock::new(|| {
    let stored: StoredCode = serde_json::from_str(include_str!("population.json"))
        .expect("the library's own file, which a test reads");
    stored.code().expect("as many joints and channels")
});

/// The number of people that are encoded before their bytes are assembled: enough for all cores,
/// and 20 MB.
const AT_ONCE: usize = 256;

/// The effort of the search for few bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// The coarsest steps at which changes of single numbers reach the error.
    #[default]
    Searched,
    /// Steps that plain rounding keeps within the error.
    Quick,
}

/// How much finer the first steps of [`Effort::Quick`] are than those of the nearest mean walk, in
/// eighths of an octave. Our choice: most walks need one try.
const FINER: u8 = 4;

/// The safety margin in the stated number of people who fit: one in this many is left out, since
/// others may be larger.
const MARGIN: usize = 50;

/// A person with the encoded bodies and walks.
struct EncodedPerson {
    subject: Subject,
    bodies: Bodies,
    clips: Vec<(Vec<u8>, JointErrors)>,
}

/// Reads the code of populations, as the first call of [`encode_population`] does. A process that
/// may fork while another thread makes that call needs it.
pub fn read_population_code() {
    LazyLock::force(&CODE);
}

/// Encodes the people with these numbers, which `make` generates, as one pack: walks within
/// `max_error_mm` and bodies within [`body_error_mm`], where the format allows it. Runs on all
/// cores, 80 ms a walk on one core, or 8 ms without a search. Memory holds the pack and 256 people.
/// `progress` is called once a walk.
///
/// The bytes of a person's body and walks do not depend on the other people in the pack. The code
/// is fitted to walks and runs of adults at an error of 5 mm: it holds any motion at any error, in
/// more bytes.
///
/// # Errors
/// The errors of `make` and `progress`; for uncut motions; for bodies and walks that the format does not hold; and
/// for more people than a pack holds, with the numbers that fit: before any is encoded if that is
/// certain, otherwise after the first 256.
pub fn encode_population(
    people: Range<usize>,
    make: &(dyn Fn(usize) -> Result<Subject> + Sync),
    max_error_mm: f64,
    effort: Effort,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<Vec<u8>> {
    let code = &*CODE;
    let mut sections = code.sections()?;
    let (mut builder, mut errors) = (PackBuilder::default(), ErrorsOfAll::default());
    if let Some(first) = people.clone().next() {
        let walks = make(first)?.walks.len();
        check_fits(&people, MAX_ENTRIES / walks.max(1))?;
    }
    {
        let parsed = sections.parsed()?;
        let numbers: Vec<usize> = people.clone().collect();
        let shared = builder.len_bytes(&sections);
        for numbers in numbers.chunks(AT_ONCE) {
            let encoded = numbers
                .par_iter()
                .map(|&number| one(code, &parsed, make(number)?, max_error_mm, effort, progress))
                .collect::<Result<Vec<_>>>()?;
            for person in encoded {
                let clips = person.clips.into_iter().map(|(bytes, own)| {
                    errors.add(&own);
                    bytes
                });
                builder.add(&person.subject, person.bodies, clips.collect())?;
            }
            // Assumes that the other people take as many bytes.
            let bytes = builder.len_bytes(&sections) - shared;
            let fit = (MAX_PACK_BYTES - shared) * builder.people() / bytes.max(1);
            check_fits(&people, fit)?;
        }
    }
    sections.state_joint_errors(&errors);
    builder.finish(sections)
}

/// Checks that the people fit into a pack.
fn check_fits(people: &Range<usize>, fit: usize) -> Result<()> {
    if people.len() <= fit {
        return Ok(());
    }
    Err(EncodeError::TooManyPeople {
        people: people.clone(),
        fit: people.start..people.start + fit - fit / MARGIN,
    }
    .into())
}

fn one(
    code: &Code,
    parsed: &Codebook<'_>,
    subject: Subject,
    max_error_mm: f64,
    effort: Effort,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<EncodedPerson> {
    let bodies = Bodies::encode(&subject, body_error_mm(max_error_mm))?;
    let skeleton = bodies.skeleton()?;
    let clips = subject.walks.iter().map(|walk| {
        let clip = match &walk.motion {
            Track::Loop(cycle) => EncodingTarget::new(cycle, skeleton.clone())
                .and_then(|target| encoded(code, parsed, &target, max_error_mm, effort)),
            Track::Uncut(_) => Err(EncodeError::UncutInPopulation.into()),
        };
        progress()?;
        clip.map_err(|error| Error::Refused(vec![refused(&subject, walk, &error)]))
    });
    let clips = clips.collect::<Result<_>>()?;
    Ok(EncodedPerson {
        bodies,
        clips,
        subject,
    })
}

/// Encodes a cycle, and returns its bytes and errors.
fn encoded(
    code: &Code,
    parsed: &Codebook<'_>,
    target: &EncodingTarget<'_>,
    max_error_mm: f64,
    effort: Effort,
) -> Result<(Vec<u8>, JointErrors)> {
    let template = nearest(code, target);
    let mean = template.map(|number| &code.templates[number].mean);
    let mut bound_mm = max_error_mm;
    let mut tries = 0;
    loop {
        let quantised = match effort {
            Effort::Searched => quantise(target, &code.frames, mean, bound_mm),
            Effort::Quick => {
                let scale = template.map_or(0, |number| code.templates[number].scale);
                let finer = 8.0 * libm::log2(MAX_ERROR_MM / bound_mm.max(1e-3));
                let from = f64::from(scale) - f64::from(FINER) - finer;
                quickly(target, &code.frames, mean, from, bound_mm)
            }
        };
        let quantised = quantised.ok_or(EncodeError::TurnsTooFar)?;
        let (bytes, errors) = code.entry(target, template, &quantised, parsed)?;
        let worst = worst(&errors);
        // An error within the bound in f64 may exceed it in the core's f32. Errors far beyond the
        // bound mean that the format has no finer steps.
        let is_near = worst > max_error_mm && worst < 1.05 * max_error_mm;
        if !is_near || tries == TRIES {
            return Ok((bytes, errors));
        }
        bound_mm *= TIGHTER;
        tries += 1;
    }
}

/// Returns the number of the mean walk relative to which a cycle takes the fewest bits, or `None`
/// if it takes fewer without one.
fn nearest(code: &Code, target: &EncodingTarget<'_>) -> Option<usize> {
    let scale = code.templates.first()?.scale;
    let numbers = rounded_at(target, &code.frames, scale)?;
    let sketch = Quantised { scale, numbers };
    let bits = |template: &Option<usize>| {
        let mean = template.map(|number| &code.templates[number].mean);
        code.parameters
            .clip_bits(&difference(&sketch, mean, &code.frames))
    };
    let all = (0..code.templates.len()).map(Some);
    all.chain([None]).min_by_key(bits).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::motion_sections::{EncodableMotion, settled};
    use crate::encode::{encode_avatar, encode_subjects};
    use crate::people::cohort::{CohortOptions, Dressing, subject, subjects};
    use edgegait_core::avatar::Avatar;
    use edgegait_core::pack::Pack;

    fn options(first: usize, people: usize) -> CohortOptions {
        CohortOptions {
            first,
            people,
            speeds_kmh: vec![5.0, 10.0],
            ..CohortOptions::default()
        }
    }

    fn pack(options: &CohortOptions, max_error_mm: f64, effort: Effort) -> Result<Vec<u8>> {
        let people = options.first..options.first + options.people;
        let make = |number| subject(options, number);
        encode_population(people, &make, max_error_mm, effort, &|| Ok(()))
    }

    #[test]
    fn a_person_has_the_same_bytes_in_any_pack_and_in_any_clothes() {
        for dressed in [None, Some(Dressing::ForGood), Some(Dressing::PerTake)] {
            let worn = |first, people| CohortOptions {
                dressed,
                ..options(first, people)
            };
            assert_same_bytes(&worn(5, 4), &worn(7, 2));
        }
    }

    fn assert_same_bytes(all: &CohortOptions, some: &CohortOptions) {
        let all = pack(all, 5.0, Effort::Searched).expect("a pack");
        let some = pack(some, 5.0, Effort::Searched).expect("a pack");
        let [all, some] = [&all, &some].map(|bytes| Pack::parse(bytes).expect("a pack"));
        let entries = |pack: &Pack<'_>, subject: usize| {
            let own = pack.subject(subject).expect("a person");
            let avatar = pack.avatar(own.avatar).expect("a body");
            let walks = || pack.walks().filter(|walk| walk.subject == subject);
            let worn = walks().filter_map(|walk| pack.avatar(walk.avatar));
            let points: Vec<_> = worn
                .map(|worn| {
                    (
                        worn.clothes(),
                        worn.hulls()
                            .flat_map(|hull| hull.points())
                            .collect::<Vec<_>>(),
                    )
                })
                .collect();
            let poses = walks().map(|walk| {
                let clip = pack.clip(walk.clip).expect("a clip");
                (clip.len_bytes(), clip.as_loop().expect("a loop").pose(0.3))
            });
            let poses = format!("{:?}", poses.collect::<Vec<_>>());
            (own.name.to_owned(), avatar.len_bytes(), points, poses)
        };
        for (at, number) in (7..9).enumerate() {
            assert_eq!(entries(&all, number - 5), entries(&some, at));
        }
    }

    #[test]
    fn the_stored_code_is_within_a_tenth_of_one_that_is_fitted_to_the_pack() {
        let options = options(100, 30);
        let people = subjects(&options).expect("people");
        let fitted = encode_subjects(&people, MAX_ERROR_MM, &|| Ok(())).expect("a pack");
        let stored = pack(&options, MAX_ERROR_MM, Effort::Searched).expect("a pack");
        let clips = |bytes: &[u8]| {
            let pack = Pack::parse(bytes).expect("a pack");
            let most = pack.walks().map(|walk| {
                let clip = pack.clip(walk.clip).expect("a clip");
                f64::from(clip.max_error_mm())
            });
            assert!(most.fold(0.0, f64::max) <= MAX_ERROR_MM);
            pack.section_bytes()[6] as f64
        };
        let (fitted, stored) = (clips(&fitted), clips(&stored));
        println!("{fitted} fitted, {stored} stored");
        assert!(stored < 1.1 * fitted, "{stored} {fitted}");
    }

    #[test]
    fn any_error_is_kept() {
        let efforts = [Effort::Searched, Effort::Quick];
        for (max_error_mm, effort) in [0.5, 1.0, 20.0].map(|mm| efforts.map(|e| (mm, e))).concat() {
            let bytes = pack(&options(3, 1), max_error_mm, effort).expect("a pack");
            let pack = Pack::parse(&bytes).expect("a pack");
            for clip in (0..pack.clip_count()).filter_map(|clip| pack.clip(clip)) {
                assert!(f64::from(clip.max_error_mm()) <= max_error_mm + 1e-3);
            }
        }
    }

    #[test]
    fn steps_that_are_too_coarse_are_made_finer_without_a_search() {
        let person = subject(&options(4, 1), 4).expect("a person");
        let body = encode_avatar(&person.body, 2.0).expect("a body");
        let skeleton = Avatar::parse(&body.bytes).expect("a body").skeleton();
        let Track::Loop(cycle) = &person.walks[0].motion else {
            panic!("a take");
        };
        let target = EncodingTarget::new(cycle, skeleton).expect("a walk");
        let sections = CODE.sections().expect("a code");
        let parsed = sections.parsed().expect("a code");
        for (from, most_mm) in [(140.0, 5.0), (60.0, 1.0), (140.0, 0.3)] {
            let found = quickly(&target, &CODE.frames, None, from, most_mm);
            let found = found.expect("a cycle");
            let (_, errors) = CODE.entry(&target, None, &found, &parsed).expect("a clip");
            let worst = worst(&errors);
            assert!((0.3 * most_mm..1.01 * most_mm).contains(&worst), "{worst}");
        }
    }

    #[test]
    fn more_people_than_fit_are_refused_before_they_are_made() {
        let made = std::sync::atomic::AtomicUsize::new(0);
        let options = options(0, 1);
        let make = |number| {
            made.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            subject(&options, number)
        };
        let error = encode_population(5..40_000, &make, 5.0, Effort::Searched, &|| Ok(()));
        let error = error.expect_err("80,000 walks").to_string();
        assert!(error.contains("5..32117"), "{error}");
        assert_eq!(made.into_inner(), 1);
    }

    /// `UPDATE_GOLDEN=1 cargo test --release --lib the_code_of_populations -- --ignored` refits the
    /// code, which changes the bytes of all populations.
    #[test]
    #[ignore = "a minute without optimisation"]
    fn the_code_of_populations_is_what_fitting_makes() {
        let options = CohortOptions {
            seed: 0,
            people: 40,
            ..CohortOptions::default()
        };
        let people = subjects(&options).expect("people");
        let bodies: Vec<_> = people
            .iter()
            .map(|person| encode_avatar(&person.body, body_error_mm(MAX_ERROR_MM)).expect("a body"))
            .collect();
        let motions = people.iter().zip(&bodies).flat_map(|(person, body)| {
            let skeleton = Avatar::parse(&body.bytes).expect("a body").skeleton();
            person.walks.iter().map(move |walk| match &walk.motion {
                Track::Loop(cycle) => EncodableMotion::Loop(Box::new(
                    EncodingTarget::new(cycle, skeleton.clone()).expect("a walk"),
                )),
                Track::Uncut(_) => panic!("a take"),
            })
        });
        let code = settled(&motions.collect::<Vec<_>>(), MAX_ERROR_MM);
        let made = serde_json::to_string(&StoredCode::from(&code)).expect("JSON") + "\n";
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/encode/population.json");
        if std::env::var_os("UPDATE_GOLDEN").is_some() {
            std::fs::write(path, made).expect("the code");
        } else {
            assert!(made == include_str!("population.json"), "another code");
        }
    }
}
