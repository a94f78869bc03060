//! What the command adds to the library's errors, which know causes and no flags: the flag that
//! an error is about goes before it, and the flags that help after it.

use crate::error::{Error, EvaluateError};
use std::fmt;

/// An error as the command shows it.
pub struct Shown<'a>(pub &'a Error);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(error) = self;
        write!(f, "{error}")?;
        way_out(error).map_or(Ok(()), |way_out| write!(f, " ({way_out})"))
    }
}

/// What to do, in flags.
fn way_out(error: &Error) -> Option<String> {
    Some(match error {
        Error::Evaluate(error) => match error {
            EvaluateError::NoTake { .. } => {
                "rename takes, choose one walk of each person so that takes are made of it, or another --protocol".into()
            }
            EvaluateError::NoClass { .. } => "use --protocol first-take".into(),
            EvaluateError::TooManyViews { .. } => "choose fewer with --views".into(),
            _ => return None,
        },
        _ => return None,
    })
}
