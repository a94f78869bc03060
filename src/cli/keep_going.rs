//! `--keep-going`: leaves out unusable inputs with a warning, instead of an error.

use super::hints::WithFlags;
use crate::error::{Error, Result};

/// The flag `--keep-going`.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct KeepGoing {
    /// Leave out unusable inputs, with a warning for each: files, gait cycles and fields of
    /// --bodies for `import`, sequences of a tree for `score`
    #[arg(long)]
    keep_going: bool,
}

impl KeepGoing {
    /// Returns whether the flag was given.
    #[must_use]
    pub(super) const fn is_given(self) -> bool {
        self.keep_going
    }

    /// Returns a warning for each item that is left out of `all` items. The words name the items
    /// and what cannot be done with them: `("files", "imported")`.
    ///
    /// # Errors
    /// If an item cannot be used and the flag is not given, if no item is left, or if the work was
    /// ended.
    pub(super) fn leave_out(
        self,
        mut refused: Vec<Error>,
        all: usize,
        what: &str,
        done: &str,
    ) -> Result<Vec<String>> {
        if let Some(end) = refused
            .iter()
            .position(|error| matches!(error, Error::Cancelled))
        {
            return Err(refused.swap_remove(end));
        }
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

/// Appends a hint in brackets to an error.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_that_was_ended_is_not_a_file_to_leave_out() {
        let flag = KeepGoing { keep_going: true };
        let refused = vec![Error::input("a.bvh", "no joints"), Error::Cancelled];
        let found = flag.leave_out(refused, 3, "files", "imported");
        assert!(matches!(found, Err(Error::Cancelled)));
    }
}
