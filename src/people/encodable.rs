//! Removal of walks that cannot be encoded from recordings.

use super::recorded::Recording;
use crate::error::{Error, RefusedWalk};

/// Removes refused walks from their recordings, and recordings without any walk left from the
/// list. Returns an error with its file for each walk, or for each recording of a refused person.
pub(crate) fn without(recordings: &mut Vec<Recording>, refused: &[RefusedWalk]) -> Vec<Error> {
    let mut errors = Vec::new();
    recordings.retain_mut(|recording| {
        let Recording {
            path,
            subject,
            name,
            cut,
            ..
        } = recording;
        let path = path.as_path();
        let own = || refused.iter().filter(|refusal| refusal.subject == *subject);
        if let Some(person) = own().find(|refusal| refusal.walk.is_none()) {
            errors.push(Error::input(path, person.to_string()));
            return false;
        }
        let problem = |number: usize| {
            let is_it =
                |(walk, cycle): &(String, u16)| walk == name && usize::from(*cycle) == number;
            let found = own().find(|refusal| refusal.walk.as_ref().is_some_and(is_it));
            found.map(|refusal| refusal.problem.as_str())
        };
        let Some(cut) = cut else {
            let problem = problem(0);
            errors.extend(problem.map(|problem| Error::input(path, problem)));
            return problem.is_none();
        };
        let all = cut.cycles.len();
        let mut numbers = 0..all;
        cut.cycles.retain(|refusal| {
            let problem = numbers.next().and_then(problem);
            errors.extend(problem.map(|problem| {
                Error::input(
                    path,
                    format!("the cycle at {:.2} s: {problem}", refusal.start_s),
                )
            }));
            problem.is_none()
        });
        cut.found -= all - cut.cycles.len();
        !cut.cycles.is_empty()
    });
    errors
}
