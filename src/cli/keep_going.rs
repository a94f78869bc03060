//! `--keep-going`: what cannot be used costs a warning, not the run.

use super::hints::WithFlags;
use crate::error::{Error, Result};

/// The flag.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct KeepGoing {
    /// Leave out what cannot be used, with a warning for each, and go on with the rest: `import`
    /// files, gait cycles and fields of --bodies, `score` sequences of a tree
    #[arg(long)]
    keep_going: bool,
}

impl KeepGoing {
    /// Whether it was given.
    #[must_use]
    pub(super) const fn is_given(self) -> bool {
        self.keep_going
    }

    /// The warnings of what is left out of so many things, called what they are and what they
    /// cannot be: `("files", "imported")`.
    ///
    /// # Errors
    /// Without the flag, and if none is left.
    pub(super) fn leave_out(
        self,
        mut refused: Vec<Error>,
        all: usize,
        (what, done): (&str, &str),
    ) -> Result<Vec<String>> {
        if refused.is_empty() || (self.keep_going && refused.len() < all) {
            return Ok(refused
                .iter()
                .map(|error| format!("left out: {}", WithFlags(error)))
                .collect());
        }
        if all == 1 {
            return Err(refused.swap_remove(0));
        }
        let hint = if self.keep_going {
            ""
        } else {
            " (--keep-going leaves them out)"
        };
        let list: Vec<String> = refused
            .iter()
            .map(|error| WithFlags(error).to_string())
            .collect();
        Err(Error::Failed(format!(
            "{} of {all} {what} cannot be {done}{hint}:\n{}",
            refused.len(),
            list.join("\n")
        )))
    }
}

/// An error that also says this, in brackets.
#[must_use]
pub(super) fn with_hint(error: Error, hint: &str) -> Error {
    match error {
        Error::Input {
            path,
            place,
            problem,
            remedy,
        } => Error::Input {
            path,
            place,
            problem: format!("{problem} ({hint})"),
            remedy,
        },
        Error::Io { path, source } => Error::input(path, format!("{source} ({hint})")),
        other => other,
    }
}
