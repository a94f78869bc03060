//! Packs of people, bodies and walks.

use crate::errors::exception;
use edgegait::dataset::sequences::PackSource;
use edgegait::dataset::{PackBytes, kmh};
use edgegait::error::ChoiceError;
use edgegait::files::{InputFile, sha256_of_bytes, write_bytes};
use edgegait_core::pack::Sex;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::{Path, PathBuf};

/// People, their bodies and their walks in one block of bytes.
#[pyclass(frozen, name = "Pack", module = "edgegait._native")]
pub(crate) struct PyPack {
    pub bytes: PackBytes,
    /// The pack's file; empty if it was made in memory.
    pub path: PathBuf,
}

impl PyPack {
    /// Returns the pack in the bytes, which were checked when they were read.
    fn opened(&self) -> PyResult<edgegait::Pack<'_>> {
        edgegait::Pack::reopen(&self.bytes).map_err(|error| exception(&error.into()))
    }

    /// Returns the pack as an input of commands.
    pub(crate) fn source(&self) -> PackSource {
        let name = self.path.display().to_string();
        PackSource {
            bytes: self.bytes.to_vec(),
            inputs: vec![InputFile {
                path: name.clone(),
                sha256: sha256_of_bytes(&self.bytes),
            }],
            name,
        }
    }
}

#[pymethods]
impl PyPack {
    /// Reads a pack from a file.
    #[new]
    #[pyo3(signature = (path, /))]
    fn new(path: PathBuf) -> PyResult<Self> {
        let source = PackSource::read(&path).map_err(|error| exception(&error))?;
        Ok(Self {
            bytes: source.bytes.into(),
            path,
        })
    }

    /// Reads a pack from bytes, which are checked; `name` is for messages and results.
    #[staticmethod]
    #[pyo3(signature = (data, name = PathBuf::new(), /))]
    fn from_bytes(data: &[u8], name: PathBuf) -> PyResult<Self> {
        edgegait::Pack::parse(data).map_err(|error| exception(&error.into()))?;
        Ok(Self {
            bytes: data.into(),
            path: name,
        })
    }

    /// Returns the pack's file; empty if it was made in memory.
    #[getter]
    fn path(&self) -> String {
        self.path.display().to_string()
    }

    /// Returns the people: name, sex, age in years, stature in metres, mass in kg; None if unknown.
    #[getter]
    fn subjects<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let known = |number: u16, unit: f64| (number > 0).then(|| f64::from(number) / unit);
        let one = |subject: edgegait_core::pack::SubjectEntry<'_>| {
            let dict = PyDict::new(py);
            dict.set_item("name", subject.name)?;
            dict.set_item("sex", subject.sex.map(Sex::name))?;
            dict.set_item("age_years", subject.age_years)?;
            dict.set_item("stature_m", known(subject.stature_mm, 1e3))?;
            dict.set_item("mass_kg", known(subject.mass_hg, 10.0))?;
            Ok(dict)
        };
        self.opened()?.subjects().map(one).collect()
    }

    /// Returns the walks: subject, name, number of the gait cycle, speed in km/h, duration in
    /// seconds, and whether it is an uncut motion.
    #[getter]
    fn walks<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let pack = self.opened()?;
        let one = |walk: edgegait_core::pack::WalkEntry<'_>| {
            let dict = PyDict::new(py);
            let clip = pack.clip(walk.clip);
            dict.set_item("subject", pack.subject(walk.subject).map(|it| it.name))?;
            dict.set_item("walk", walk.name)?;
            dict.set_item("cycle", walk.cycle)?;
            dict.set_item("speed_kmh", kmh(walk.speed_mm_per_s))?;
            dict.set_item(
                "duration_s",
                clip.as_ref().map(edgegait_core::clip::Clip::duration_s),
            )?;
            dict.set_item(
                "is_uncut",
                clip.is_some_and(|clip| clip.as_uncut().is_some()),
            )?;
            Ok(dict)
        };
        pack.walks().map(one).collect()
    }

    /// Writes the pack to a file; an existing file is replaced only with `overwrite`.
    #[pyo3(signature = (path, *, overwrite = false))]
    fn save(&self, path: PathBuf, overwrite: bool) -> PyResult<()> {
        let refuse = !overwrite && Path::new(&path).exists();
        let written = if refuse {
            Err(ChoiceError::IsThere(path).into())
        } else {
            write_bytes(&path, &self.bytes)
        };
        written.map_err(|error| exception(&error))
    }

    fn __bytes__<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.bytes)
    }

    /// Returns the number of walks.
    fn __len__(&self) -> PyResult<usize> {
        Ok(self.opened()?.walks().len())
    }

    fn __repr__(&self) -> PyResult<String> {
        let pack = self.opened()?;
        Ok(format!(
            "<Pack: {} people, {} walks, {} bytes>",
            pack.subjects().len(),
            pack.walks().len(),
            self.bytes.len()
        ))
    }
}
