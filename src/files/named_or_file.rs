//! TOML texts that are built in under a name, or read from a user's file.

use crate::error::{Error, Result};
use std::borrow::Cow;
use std::path::Path;

/// The maximum number of bytes in a file.
const MAX_BYTES: u64 = 1 << 20;

/// Returns the TOML that is built in under `name`, or reads it from a `.toml` file. Messages use
/// `what`, the kind of text (such as `protocol`), and `names`, the names of the `built_in` texts.
///
/// # Errors
/// If the name is unknown, or the file cannot be read.
pub(crate) fn toml_of(
    name: &str,
    what: &str,
    names: &[&str],
    built_in: &[&'static str],
) -> Result<Cow<'static, str>> {
    let known = names
        .iter()
        .zip(built_in)
        .find(|(known, _)| **known == name);
    if let Some((_, text)) = known {
        return Ok(Cow::Borrowed(text));
    }
    let path = Path::new(name);
    if path.extension().is_none_or(|extension| extension != "toml") {
        return Err(Error::Usage(format!(
            "there is no {what} {name:?}: expected {} or a .toml file",
            names.join(", ")
        )));
    }
    let io = |error| Error::io(path, error);
    let length = std::fs::metadata(path).map_err(io)?.len();
    if length > MAX_BYTES {
        return Err(Error::input(
            path,
            format!("expected a {what} of at most {MAX_BYTES} bytes, found {length}"),
        ));
    }
    super::read_to_string(path).map(Cow::Owned)
}
