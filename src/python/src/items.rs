//! Items of datasets that are drawn on request.

use crate::attend::{attended, thread_count};
use crate::errors::exception;
use crate::pack::PyPack;
use edgegait::dataset::design::{self, Design};
use edgegait::dataset::{Array, IndexRow, PackBytes};
use edgegait::draw::sweep::Drawer;
use edgegait::files::grey_png;
use ndarray::{Array1, ArrayD};
use numpy::{IntoPyArray as _, PyReadonlyArray2};
use pyo3::exceptions::{PyIndexError, PyMemoryError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use rayon::prelude::*;
use std::collections::{BTreeMap, VecDeque};
use std::ffi::OsString;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// The maximum number of bytes of kept people: about 50,000 with one walk each. Our choice.
const MAX_KEPT_BYTES: usize = 1 << 27;

/// The items of a design or of a sweep.
#[pyclass(frozen, name = "Items", module = "edgegait._native")]
pub(crate) struct PyItems {
    items: edgegait::dataset::Items,
    /// People who were made. The lock is taken only under the interpreter's lock, and only for a
    /// look-up, so that it is free in a forked process.
    people: Mutex<MadePeople>,
    /// What drew items before; the lock is taken as that of `people`.
    drawers: Mutex<Vec<Drawer>>,
}

/// People who were made, and their order.
#[derive(Default)]
struct MadePeople {
    packs: BTreeMap<usize, PackBytes>,
    order: VecDeque<usize>,
    bytes: usize,
}

impl MadePeople {
    fn keep(&mut self, person: usize, pack: PackBytes) {
        self.bytes += pack.len();
        match self.packs.insert(person, pack) {
            // Another thread made the same person in the meantime.
            Some(former) => self.bytes -= former.len(),
            None => self.order.push_back(person),
        }
        while self.bytes > MAX_KEPT_BYTES {
            let Some(first) = self.order.pop_front() else {
                return;
            };
            self.bytes -= self.packs.remove(&first).map_or(0, |pack| pack.len());
        }
    }
}

impl PyItems {
    fn new(items: edgegait::dataset::Items) -> Self {
        Self {
            items,
            people: Mutex::default(),
            drawers: Mutex::default(),
        }
    }

    fn check(&self, numbers: &[usize]) -> PyResult<()> {
        let all = self.items.len();
        if let Some(beyond) = numbers.iter().find(|&&number| number >= all) {
            return Err(PyIndexError::new_err(format!(
                "item {beyond}: expected one of {all}"
            )));
        }
        self.check_count(numbers.len())
    }

    /// Checks that this number of items can be drawn in one call.
    fn check_count(&self, count: usize) -> PyResult<()> {
        let most = self.items.most_at_once();
        if count > most {
            return Err(PyValueError::new_err(format!(
                "expected at most {most} of these items at once, found {count}"
            )));
        }
        Ok(())
    }

    /// Returns the packs of people who were made already, and the numbers of the others.
    fn known(&self, people: Vec<usize>) -> (BTreeMap<usize, PackBytes>, Vec<usize>) {
        let kept = self.people.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut known, mut missing) = (BTreeMap::new(), Vec::new());
        for person in people {
            match kept.packs.get(&person) {
                Some(pack) => {
                    known.insert(person, pack.clone());
                }
                None => missing.push(person),
            }
        }
        (known, missing)
    }

    /// Returns the packs of the people in these items.
    fn packs(
        &self,
        py: Python<'_>,
        numbers: &[usize],
        threads: usize,
    ) -> PyResult<BTreeMap<usize, PackBytes>> {
        let (mut known, missing) = self.known(self.items.people_of(numbers));
        if missing.is_empty() {
            return Ok(known);
        }
        let made = attended(py, threads, |stop| {
            let make = |&person: &usize| {
                stop.check()?;
                self.items.make(person)
            };
            missing
                .par_iter()
                .map(make)
                .collect::<edgegait::Result<Vec<_>>>()
        })?;
        let made = made.map_err(|error| exception(&error))?;
        let mut kept = self.people.lock().unwrap_or_else(PoisonError::into_inner);
        for (person, pack) in missing.into_iter().zip(made) {
            kept.keep(person, pack.clone());
            known.insert(person, pack);
        }
        Ok(known)
    }
}

#[pymethods]
impl PyItems {
    /// Returns the items of a design.
    #[staticmethod]
    fn of_design(
        text: &str,
        name: &str,
        split: Option<&str>,
        people: Option<usize>,
    ) -> PyResult<Self> {
        let items = Design::parse(Path::new(name), text)
            .and_then(|design| edgegait::dataset::Items::of_design(design, split, people));
        Ok(Self::new(items.map_err(|error| exception(&error))?))
    }

    /// Returns the items of a sweep, from words of the command line.
    #[staticmethod]
    fn of_sweep(py: Python<'_>, words: Vec<OsString>, pack: Option<&PyPack>) -> PyResult<Self> {
        let pack = pack.map(PyPack::source);
        let items = py.detach(|| edgegait::cli::embed::swept(&words, pack));
        Ok(Self::new(items.map_err(|error| exception(&error))?))
    }

    fn __len__(&self) -> usize {
        self.items.len()
    }

    /// Returns the number of viewpoints of each cycle: this many consecutive items show one cycle.
    #[getter]
    fn views(&self) -> usize {
        self.items.views()
    }

    /// Returns the names of the people, in the order of labels.
    #[getter]
    fn subjects(&self) -> Vec<String> {
        self.items.subjects()
    }

    /// Returns the arrays of each item: name, bytes of an item or of each of its frames, and
    /// whether it has frames.
    #[getter]
    fn arrays(&self) -> Vec<(String, usize, bool)> {
        let array = |array: Array| (array.name.clone(), array.bytes(), array.is_of_frames);
        self.items.arrays().into_iter().map(array).collect()
    }

    /// Checks that this number of items can be drawn in one call.
    fn check_at_once(&self, count: usize) -> PyResult<()> {
        self.check_count(count)
    }

    /// Returns the label of each of these items, or of all items.
    #[pyo3(signature = (numbers = None))]
    fn labels<'py>(
        &self,
        py: Python<'py>,
        numbers: Option<Vec<usize>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let count = numbers.as_ref().map_or(self.items.len(), Vec::len);
        let mut labels: Vec<i64> = Vec::new();
        labels
            .try_reserve_exact(count)
            .map_err(|_| PyMemoryError::new_err(format!("no room for {count} labels")))?;
        let label = |number: usize| self.items.label(number) as i64;
        if let Some(numbers) = numbers {
            self.check(&numbers)?;
            labels.extend(numbers.into_iter().map(label));
        } else {
            py.detach(|| labels.extend((0..count).map(label)));
        }
        Ok(Array1::from(labels).into_pyarray(py).into_any())
    }

    /// Returns epochs and numbers of items in an endless stream, from its `start`-th item on.
    #[pyo3(signature = (seed, start, count, *, people_at_once, by_cycle))]
    fn order(
        &self,
        seed: u64,
        start: u64,
        count: usize,
        people_at_once: usize,
        by_cycle: bool,
    ) -> PyResult<Vec<(u32, usize)>> {
        self.check_count(count)?;
        let order = self.items.order(seed, people_at_once, by_cycle);
        let found = (start..start.saturating_add(count as u64)).map(|at| order.at(at));
        let found: Option<Vec<(u32, usize)>> = found.collect();
        found.ok_or_else(|| {
            PyIndexError::new_err(format!("item {start} of a stream: it does not exist"))
        })
    }

    /// Draws items, and returns all items of each array, by name, and the number of frames of each
    /// item.
    fn draw<'py>(
        &self,
        py: Python<'py>,
        numbers: Vec<usize>,
        epoch: u32,
        threads: usize,
    ) -> PyResult<(Bound<'py, PyDict>, Vec<u32>)> {
        self.check(&numbers)?;
        let packs = self.packs(py, &numbers, threads)?;
        // Another call may want the others.
        let most = match numbers.len() {
            1 => 1,
            _ => thread_count(py, threads)?,
        };
        let kept = || self.drawers.lock().unwrap_or_else(PoisonError::into_inner);
        let mut drawers = {
            let mut kept = kept();
            let left = kept.len().saturating_sub(most);
            kept.split_off(left)
        };
        let drawn = if numbers.len() == 1 {
            py.detach(|| {
                self.items
                    .draw(&numbers, epoch, &packs, &mut drawers, &|| Ok(()))
            })
        } else {
            attended(py, threads, |stop| {
                let tell = || stop.check();
                self.items
                    .draw(&numbers, epoch, &packs, &mut drawers, &tell)
            })?
        };
        kept().append(&mut drawers);
        let drawn = drawn.map_err(|error| exception(&error))?;
        let dict = PyDict::new(py);
        for (array, bytes) in self.items.arrays().iter().zip(drawn.arrays) {
            dict.set_item(&array.name, shaped(py, array, bytes)?)?;
        }
        Ok((dict, drawn.frames))
    }

    /// Returns the rows of an index for these items, by column.
    fn rows<'py>(
        &self,
        py: Python<'py>,
        numbers: Vec<usize>,
        epoch: u32,
        threads: usize,
    ) -> PyResult<Bound<'py, PyDict>> {
        self.check(&numbers)?;
        let packs = self.packs(py, &numbers, threads)?;
        let rows = py.detach(|| self.items.rows(&numbers, epoch, &packs));
        columns(py, &rows.map_err(|error| exception(&error))?)
    }
}

/// Returns the bytes of an array as an array of its shape.
fn shaped<'py>(py: Python<'py>, array: &Array, bytes: Vec<u8>) -> PyResult<Bound<'py, PyAny>> {
    let count = bytes.len() / array.bytes();
    let shape: Vec<usize> = std::iter::once(count)
        .chain(array.sides.iter().copied())
        .collect();
    let failed =
        |error: ndarray::ShapeError| exception(&edgegait::Error::Failed(error.to_string()));
    if array.is_float() {
        let (numbers, _) = bytes.as_chunks();
        let numbers: Vec<f32> = numbers
            .iter()
            .map(|&four| f32::from_le_bytes(four))
            .collect();
        let made = ArrayD::from_shape_vec(shape, numbers).map_err(failed)?;
        return Ok(made.into_pyarray(py).into_any());
    }
    let made = ArrayD::from_shape_vec(shape, bytes).map_err(failed)?;
    Ok(made.into_pyarray(py).into_any())
}

/// Converts rows of an index to columns.
fn columns<'py>(py: Python<'py>, rows: &[IndexRow]) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    macro_rules! columns {
        ($($name:ident),*) => {
            $(dict.set_item(
                stringify!($name),
                rows.iter().map(|row| row.$name.clone()).collect::<Vec<_>>(),
            )?;)*
        };
    }
    columns!(
        subject,
        walk,
        cycle,
        variation,
        speed_kmh,
        azimuth_deg,
        elevation_deg,
        condition,
        alternative,
        frames,
        seed
    );
    Ok(dict)
}

/// Returns the TOML of a design, from its name or file.
#[pyfunction]
pub(crate) fn design_text(name: &str) -> PyResult<String> {
    let text = design::text_of(name).map_err(|error| exception(&error))?;
    Design::parse(Path::new(name), &text).map_err(|error| exception(&error))?;
    Ok(text.into_owned())
}

/// Encodes pixels, 0 to 255, as a grey PNG.
#[pyfunction]
pub(crate) fn png<'py>(
    py: Python<'py>,
    pixels: PyReadonlyArray2<'py, u8>,
) -> PyResult<Bound<'py, PyBytes>> {
    let pixels = pixels.as_array();
    let columns = pixels.ncols();
    let all: Vec<u8> = pixels.iter().copied().collect();
    let bytes = grey_png(&all, columns).map_err(|error| exception(&error))?;
    Ok(PyBytes::new(py, &bytes))
}
