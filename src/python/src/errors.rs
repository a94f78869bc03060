//! Converts errors of the library to Python exceptions, with the command's messages.

use edgegait::cli::embed::text_of;
use pyo3::exceptions::{
    PyException, PyFileNotFoundError, PyOSError, PyPermissionError, PyValueError,
};
use pyo3::prelude::*;
use std::io::ErrorKind;

pyo3::create_exception!(
    edgegait,
    Error,
    PyException,
    "A problem with a file or with data; the message gives advice."
);

/// Returns the exception for an error: `ValueError` for invalid arguments, `OSError` and its
/// subclasses if the system refused, [`Error`] otherwise.
pub(crate) fn exception(error: &edgegait::Error) -> PyErr {
    let text = text_of(error);
    match error {
        edgegait::Error::Io { source, .. } => match source.kind() {
            ErrorKind::NotFound => PyFileNotFoundError::new_err(text),
            ErrorKind::PermissionDenied => PyPermissionError::new_err(text),
            _ => PyOSError::new_err(text),
        },
        _ if error.exit_code() == 2 => PyValueError::new_err(text),
        _ => Error::new_err(text),
    }
}
