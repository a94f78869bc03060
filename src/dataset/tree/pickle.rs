//! Reads one NumPy array of masks, or a list of arrays, from a pickle, and rejects everything else.
//!
//! A pickle is a program, and Python's own reader runs it. This one knows the instructions that
//! NumPy writes for an array (protocols 2 to 5, `pickletools.dis` lists them), those of a list, and
//! the five names that they use. It compares names as text and never looks up or calls a function.

use super::MAX_FRAMES;
use crate::dataset::mask_numbers::{ByteArray, NumberType};
use std::borrow::Cow;
use std::rc::Rc;

/// Pickles an array of bytes in C order with protocol 3, as NumPy does. Every version of NumPy
/// reads the module names in it.
pub(in crate::dataset) fn pickled(shape: [usize; 3], bytes: &[u8]) -> Vec<u8> {
    let mut pickle = b"\x80\x03cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\n".to_vec();
    pickle.extend(b"K\x00\x85C\x01b\x87R(K\x01");
    for side in shape {
        match (u8::try_from(side), i32::try_from(side)) {
            (Ok(side), _) => pickle.extend([b'K', side]),
            (_, Ok(side)) => {
                pickle.push(b'J');
                pickle.extend(side.to_le_bytes());
            }
            // No sequence has two thousand million frames.
            _ => pickle.extend(b"K\x00"),
        }
    }
    pickle
        .extend(b"\x87cnumpy\ndtype\nX\x02\x00\x00\x00u1\x89\x88\x87R(K\x03X\x01\x00\x00\x00|NNN");
    pickle.extend(b"J\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tb\x89");
    pickle.push(b'B');
    let length = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
    pickle.extend(length.to_le_bytes());
    pickle.extend(bytes);
    pickle.extend(b"tb.");
    pickle
}

/// The maximum number of instructions, and so of values in the memo and on the stack. An array
/// takes about 50, 20 and 12.
const MAX_STEPS: usize = 256;
/// The further instructions for each array of a list. One takes about 25.
const STEPS_AN_ARRAY: usize = 64;

/// The place of an error in a pickle, and the reason.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct RefusedPickle {
    pub byte: usize,
    pub problem: String,
}

/// Reads the array in a pickle.
pub(super) fn read(pickle: &[u8]) -> Result<ByteArray<'_>, RefusedPickle> {
    let mut machine = PickleMachine {
        pickle,
        at: 0,
        stack: Vec::new(),
        memo: Vec::new(),
        arrays: 0,
    };
    let mut steps = 0;
    while steps < MAX_STEPS + STEPS_AN_ARRAY * machine.arrays {
        steps += 1;
        let start = machine.at;
        let step = machine.step().map_err(|problem| RefusedPickle {
            byte: start,
            problem,
        })?;
        if let Some(array) = step {
            return Ok(array);
        }
    }
    Err(RefusedPickle {
        byte: machine.at,
        problem: format!("expected one array, found more than {steps} instructions"),
    })
}

/// Reads the shape `[frames][rows][columns]` of an array from the beginning of its pickle, if the
/// shape comes before the array's bytes, as NumPy writes it.
pub(super) fn shape(start: &[u8]) -> Option<[usize; 3]> {
    let mut machine = PickleMachine {
        pickle: start,
        at: 0,
        stack: Vec::new(),
        memo: Vec::new(),
        arrays: 0,
    };
    for _ in 0..MAX_STEPS {
        if machine.step().is_err() {
            break;
        }
    }
    let size = |value: &PickleValue<'_>| match value {
        PickleValue::Int(size) => usize::try_from(*size).ok(),
        _ => None,
    };
    machine.stack.iter().rev().find_map(|value| match value {
        PickleValue::Tuple(sides) => match &**sides {
            [frames, rows, columns] => Some([size(frames)?, size(rows)?, size(columns)?]),
            _ => None,
        },
        _ => None,
    })
}

#[derive(Clone, Debug)]
enum PickleValue<'a> {
    Mark,
    None,
    Bool(bool),
    Int(i64),
    Text(&'a str),
    Bytes(&'a [u8]),
    /// Bytes that protocol 2 writes as characters.
    Latin1(&'a str),
    Tuple(Rc<[PickleValue<'a>]>),
    Name(Name),
    /// `dtype('u1')` and others.
    Type(NumberType),
    /// An array that awaits its state.
    Unbuilt,
    Array(PickledArray<'a>),
    List(Vec<PickledArray<'a>>),
}

/// An array as a pickle states it.
#[derive(Clone, Debug)]
struct PickledArray<'a> {
    shape: Rc<[PickleValue<'a>]>,
    numbers: NumberType,
    content: Box<PickleValue<'a>>,
}

/// The names that instructions may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Name {
    Reconstruct,
    FromBuffer,
    Ndarray,
    Dtype,
    Encode,
}

impl<'a> PickledArray<'a> {
    /// Returns the shape and the bytes, which are as many as the shape says.
    fn numbers_in_place(&self) -> PickleStep<(Vec<usize>, Cow<'a, [u8]>)> {
        let bytes = match &*self.content {
            PickleValue::Bytes(bytes) => Cow::Borrowed(*bytes),
            PickleValue::Latin1(text) => {
                let bytes = text.chars().map(|c| u8::try_from(c).ok());
                let bytes: Option<Vec<u8>> = bytes.collect();
                Cow::Owned(bytes.ok_or("expected bytes, found characters above 255")?)
            }
            _ => return Err("expected the array's bytes, found something else".into()),
        };
        let size = |value: &PickleValue<'_>| match value {
            PickleValue::Int(size) => usize::try_from(*size).ok(),
            _ => None,
        };
        let shape: Option<Vec<usize>> = self.shape.iter().map(size).collect();
        let shape = shape.ok_or("expected a shape of whole numbers")?;
        let numbers = shape
            .iter()
            .try_fold(self.numbers.bytes(), |n, &size| n.checked_mul(size));
        if numbers != Some(bytes.len()) {
            return Err(format!(
                "expected the bytes of an array of {shape:?}, found {}",
                bytes.len()
            ));
        }
        Ok((shape, bytes))
    }
}

type PickleStep<T> = Result<T, String>;

struct PickleMachine<'a> {
    pickle: &'a [u8],
    at: usize,
    stack: Vec<PickleValue<'a>>,
    memo: Vec<PickleValue<'a>>,
    /// Arrays so far.
    arrays: usize,
}

impl<'a> PickleMachine<'a> {
    /// Runs one instruction; the last one returns the array.
    fn step(&mut self) -> PickleStep<Option<ByteArray<'a>>> {
        let [code] = *self.take::<1>()?;
        match code {
            // PROTO, FRAME
            0x80 => match *self.take::<1>()? {
                [2..=5] => {}
                [other] => return Err(format!("expected protocol 2 to 5, found {other}")),
            },
            0x95 => {
                self.take::<8>()?;
            }
            b'(' => self.push(PickleValue::Mark),
            b'N' => self.push(PickleValue::None),
            0x88 => self.push(PickleValue::Bool(true)),
            0x89 => self.push(PickleValue::Bool(false)),
            // BININT1, BININT2, BININT
            b'K' => {
                let [number] = *self.take::<1>()?;
                self.push(PickleValue::Int(number.into()));
            }
            b'M' => {
                let number = u16::from_le_bytes(*self.take()?);
                self.push(PickleValue::Int(number.into()));
            }
            b'J' => {
                let number = i32::from_le_bytes(*self.take()?);
                self.push(PickleValue::Int(number.into()));
            }
            // BINUNICODE, SHORT_BINUNICODE
            b'X' => {
                let text = self.counted::<4>().and_then(utf8)?;
                self.push(PickleValue::Text(text));
            }
            0x8C => {
                let text = self.counted::<1>().and_then(utf8)?;
                self.push(PickleValue::Text(text));
            }
            // SHORT_BINBYTES, BINBYTES, BINBYTES8 and BYTEARRAY8
            b'C' => {
                let bytes = self.counted::<1>()?;
                self.push(PickleValue::Bytes(bytes));
            }
            b'B' => {
                let bytes = self.counted::<4>()?;
                self.push(PickleValue::Bytes(bytes));
            }
            0x8E | 0x96 => {
                let bytes = self.counted::<8>()?;
                self.push(PickleValue::Bytes(bytes));
            }
            // EMPTY_TUPLE, TUPLE1 to TUPLE3, TUPLE
            b')' => self.tuple(0)?,
            0x85..=0x87 => self.tuple(usize::from(code - 0x84))?,
            b't' => {
                let items = self.since_mark()?;
                self.push(PickleValue::Tuple(items.into()));
            }
            // EMPTY_LIST, APPEND, APPENDS
            b']' => self.push(PickleValue::List(Vec::new())),
            b'a' => {
                let item = self.pop()?;
                self.append(vec![item])?;
            }
            b'e' => {
                let items = self.since_mark()?;
                self.append(items)?;
            }
            // GLOBAL, STACK_GLOBAL
            b'c' => {
                let (module, attribute) = (self.line()?, self.line()?);
                self.push(PickleValue::Name(known(module, attribute)?));
            }
            0x93 => {
                let (attribute, module) = (self.pop()?, self.pop()?);
                let (PickleValue::Text(module), PickleValue::Text(attribute)) = (module, attribute)
                else {
                    return Err("expected the names of a module and of its attribute".into());
                };
                self.push(PickleValue::Name(known(module, attribute)?));
            }
            // BINPUT, LONG_BINPUT and MEMOIZE, all numbered consecutively
            b'q' => {
                let [index] = *self.take::<1>()?;
                self.memoize(index.into())?;
            }
            b'r' => {
                let index = u32::from_le_bytes(*self.take()?);
                self.memoize(index as usize)?;
            }
            0x94 => self.memoize(self.memo.len())?,
            // BINGET, LONG_BINGET
            b'h' => {
                let [index] = *self.take::<1>()?;
                self.recall(index.into())?;
            }
            b'j' => {
                let index = u32::from_le_bytes(*self.take()?);
                self.recall(index as usize)?;
            }
            b'R' => {
                let (arguments, name) = (self.pop()?, self.pop()?);
                let value = reduced(&name, &arguments)?;
                self.arrays += usize::from(matches!(value, PickleValue::Array(_)));
                self.push(value);
            }
            b'b' => {
                let (state, object) = (self.pop()?, self.pop()?);
                let value = built(&object, &state)?;
                self.arrays += usize::from(matches!(value, PickleValue::Array(_)));
                self.push(value);
            }
            b'.' => return self.array().map(Some),
            _ => {
                return Err(format!(
                    "expected one NumPy array, or a list of them, found the instruction {code:#04x}, which such a pickle does not have"
                ));
            }
        }
        Ok(None)
    }

    /// Returns the array, or the arrays of the list, on top of the stack.
    fn array(&mut self) -> PickleStep<ByteArray<'a>> {
        let arrays = match self.pop()? {
            PickleValue::Array(array) => {
                let (shape, bytes) = array.numbers_in_place()?;
                let bytes = array.numbers.grey(bytes)?;
                return Ok(ByteArray { shape, bytes });
            }
            PickleValue::List(arrays) => arrays,
            _ => return Err("expected an array at the end, found something else".into()),
        };
        let Some(first) = arrays.first() else {
            return Err("expected an array at the end, found an empty list".into());
        };
        let (frame, _) = first.numbers_in_place()?;
        if arrays.len() > MAX_FRAMES || frame.len() != 2 {
            return Err(format!(
                "expected a list of at most {MAX_FRAMES} frames, [rows][columns], found {} of {frame:?}",
                arrays.len()
            ));
        }
        let mut all = Vec::new();
        for array in &arrays {
            let (shape, bytes) = array.numbers_in_place()?;
            if (&shape, array.numbers) != (&frame, first.numbers) {
                return Err(format!(
                    "expected frames of {frame:?} and one type in a list, found one of {shape:?}"
                ));
            }
            // One array may stand in the list many times.
            if all.len() + bytes.len() > self.pickle.len() {
                return Err("expected each frame in the list once, found some again".into());
            }
            all.extend_from_slice(&bytes);
        }
        let bytes = first.numbers.grey(Cow::Owned(all))?;
        Ok(ByteArray {
            shape: vec![arrays.len(), frame[0], frame[1]],
            bytes,
        })
    }

    /// Takes the values since the last mark, and the mark.
    fn since_mark(&mut self) -> PickleStep<Vec<PickleValue<'a>>> {
        let is_mark = |value: &PickleValue<'_>| matches!(value, PickleValue::Mark);
        let mark = self.stack.iter().rposition(is_mark);
        let mark = mark.ok_or("expected the start of a tuple or list, found none")?;
        let items = self.stack.split_off(mark + 1);
        self.stack.pop();
        Ok(items)
    }

    /// Appends arrays to the list on top of the stack.
    fn append(&mut self, items: Vec<PickleValue<'a>>) -> PickleStep<()> {
        let Some(PickleValue::List(list)) = self.stack.last_mut() else {
            return Err("expected a list to append to, found something else".into());
        };
        for item in items {
            let PickleValue::Array(array) = item else {
                return Err("expected a list of NumPy arrays, found something else in it".into());
            };
            list.push(array);
        }
        Ok(())
    }

    fn push(&mut self, value: PickleValue<'a>) {
        self.stack.push(value);
    }

    fn pop(&mut self) -> PickleStep<PickleValue<'a>> {
        let value = self.stack.pop();
        value.ok_or_else(|| "expected a value, found an empty stack".into())
    }

    fn tuple(&mut self, length: usize) -> PickleStep<()> {
        let start = self.stack.len().checked_sub(length);
        let start = start.ok_or("expected a tuple's values, found too few")?;
        let items = self.stack.split_off(start);
        self.push(PickleValue::Tuple(items.into()));
        Ok(())
    }

    fn memoize(&mut self, index: usize) -> PickleStep<()> {
        let top = self
            .stack
            .last()
            .ok_or("expected a value, found an empty stack")?;
        if index != self.memo.len() {
            return Err(format!("expected memo {}, found {index}", self.memo.len()));
        }
        if matches!(top, PickleValue::List(list) if !list.is_empty()) {
            return Err("expected a list to be kept while it is empty".into());
        }
        self.memo.push(top.clone());
        Ok(())
    }

    fn recall(&mut self, index: usize) -> PickleStep<()> {
        let value = self.memo.get(index).cloned();
        self.push(value.ok_or_else(|| format!("found nothing as memo {index}"))?);
        Ok(())
    }

    fn take<const N: usize>(&mut self) -> PickleStep<&'a [u8; N]> {
        let rest = self.pickle.get(self.at..).unwrap_or_default();
        let (taken, _) = rest
            .split_first_chunk::<N>()
            .ok_or("the pickle is cut short")?;
        self.at += N;
        Ok(taken)
    }

    /// Takes bytes that follow a little-endian count of `N` bytes.
    fn counted<const N: usize>(&mut self) -> PickleStep<&'a [u8]> {
        let mut count = [0; 8];
        count[..N].copy_from_slice(self.take::<N>()?);
        let end = usize::try_from(u64::from_le_bytes(count)).ok();
        let end = end.and_then(|count| self.at.checked_add(count));
        let bytes = end.and_then(|end| self.pickle.get(self.at..end));
        let bytes = bytes.ok_or("the pickle is cut short")?;
        self.at += bytes.len();
        Ok(bytes)
    }

    fn line(&mut self) -> PickleStep<&'a str> {
        let rest = self.pickle.get(self.at..).unwrap_or_default();
        let end = rest.iter().position(|byte| *byte == b'\n');
        let line = &rest[..end.ok_or("the pickle is cut short")?];
        self.at += line.len() + 1;
        utf8(line)
    }
}

fn utf8(bytes: &[u8]) -> PickleStep<&str> {
    std::str::from_utf8(bytes).map_err(|_| "expected UTF-8".into())
}

fn known(module: &str, attribute: &str) -> PickleStep<Name> {
    Ok(match (module, attribute) {
        ("numpy.core.multiarray" | "numpy._core.multiarray", "_reconstruct") => Name::Reconstruct,
        ("numpy.core.numeric" | "numpy._core.numeric", "_frombuffer") => Name::FromBuffer,
        ("numpy", "ndarray") => Name::Ndarray,
        ("numpy", "dtype") => Name::Dtype,
        ("_codecs", "encode") => Name::Encode,
        _ => {
            return Err(format!(
                "expected one NumPy array, or a list of them, found {module:?} {attribute:?}, which is never run"
            ));
        }
    })
}

/// Returns the value of a call of a name.
fn reduced<'a>(name: &PickleValue<'a>, arguments: &PickleValue<'a>) -> PickleStep<PickleValue<'a>> {
    let (PickleValue::Name(name), PickleValue::Tuple(arguments)) = (name, arguments) else {
        return Err("expected a name and its arguments".into());
    };
    match (name, &**arguments) {
        (Name::Reconstruct, [PickleValue::Name(Name::Ndarray), _, _]) => Ok(PickleValue::Unbuilt),
        (Name::Dtype, [PickleValue::Text(text), ..]) => {
            let known = NumberType::parse(text).map(PickleValue::Type);
            known.ok_or_else(|| NumberType::expected(text))
        }
        (Name::Encode, [PickleValue::Text(text), PickleValue::Text("latin1")]) => {
            Ok(PickleValue::Latin1(text))
        }
        (
            Name::FromBuffer,
            [
                bytes,
                PickleValue::Type(numbers),
                PickleValue::Tuple(shape),
                PickleValue::Text("C"),
            ],
        ) => Ok(PickleValue::Array(PickledArray {
            shape: Rc::clone(shape),
            numbers: *numbers,
            content: Box::new(bytes.clone()),
        })),
        (Name::FromBuffer, [_, _, _, PickleValue::Text("F")]) => Err(NOT_C.into()),
        _ => Err(format!(
            "expected NumPy's arguments of {name:?}, found others"
        )),
    }
}

const NOT_C: &str =
    "expected an array in C order, found Fortran order (numpy.ascontiguousarray before pickling)";

/// Applies a state to an object.
fn built<'a>(object: &PickleValue<'a>, state: &PickleValue<'a>) -> PickleStep<PickleValue<'a>> {
    let PickleValue::Tuple(state) = state else {
        return Err("expected a state as NumPy writes it".into());
    };
    match (object, &**state) {
        (
            PickleValue::Type(numbers),
            [
                PickleValue::Int(_),
                PickleValue::Text("|" | "<"),
                PickleValue::None,
                ..,
            ],
        ) => Ok(PickleValue::Type(*numbers)),
        (
            PickleValue::Unbuilt,
            [
                PickleValue::Int(1),
                PickleValue::Tuple(shape),
                PickleValue::Type(numbers),
                PickleValue::Bool(false),
                bytes,
            ],
        ) => Ok(PickleValue::Array(PickledArray {
            shape: Rc::clone(shape),
            numbers: *numbers,
            content: Box::new(bytes.clone()),
        })),
        (PickleValue::Unbuilt, [_, _, _, PickleValue::Bool(true), _]) => Err(NOT_C.into()),
        _ => Err("expected NumPy's state of an array, found another".into()),
    }
}

#[cfg(test)]
mod tests;
