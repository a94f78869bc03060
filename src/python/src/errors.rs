//! Errors of the library as Python exceptions, with the command's texts.

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
    "What is wrong with a file or data, and what to do about it."
);

/// The exception of an error: `ValueError` for arguments that make no sense, `OSError` and its kinds
/// where the system refused, [`Error`] for all else.
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
