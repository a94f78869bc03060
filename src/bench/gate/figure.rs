//! Paths of values in results, such as `models[gei-small].p50_us`.
//!
//! A path consists of the keys of the JSON, with dots between them. Brackets choose an element of a
//! list by its name (`recognizers[mine]`) or by any of its keys
//! (`by_viewpoint[azimuth_deg=90,elevation_deg=0]`), or all elements (`probe_sets[*]`). A list of
//! one element needs none. Names with brackets, commas or `=`, and keys with dots, are in quotation
//! marks: `recognizers["a=b"]`.
//!
//! JSONPath (RFC 9535) would not replace this. It selects, but a limit also needs a path by which
//! the same element is found in other results, where its number differs, and an error that says
//! what is there instead.

use serde_json::{Map, Value};

/// Keys that identify elements of lists, the most distinctive first.
const IDENTITIES: [&str; 20] = [
    "name",
    "person",
    "recognizer",
    "other",
    "probe_set",
    "runtime",
    "threads",
    "operator",
    "provider",
    "arithmetic",
    "view",
    "side",
    "strength",
    "batch",
    "frames",
    "azimuth_deg",
    "elevation_deg",
    "from_deg",
    "to_deg",
    "far",
];
/// The maximum number of keys that a message lists.
const LISTED: usize = 24;
/// The maximum length of a list whose elements are identified by keys. Elements of longer lists are
/// identified by their numbers.
const TOLD_APART: usize = 1000;

/// A path to one or more values.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FigurePath {
    steps: Vec<PathStep>,
}

/// A key, and which element to choose if its value is a list.
#[derive(Clone, Debug, PartialEq)]
struct PathStep {
    key: String,
    chosen: ElementChoice,
}

#[derive(Clone, Debug, PartialEq)]
enum ElementChoice {
    /// The value itself, or the only element of a list.
    Only,
    /// Each element.
    Each,
    /// The element with this number, from 0: `[#3]`.
    At(usize),
    /// The only element with these values under these keys (without a key: under any of
    /// [`IDENTITIES`]).
    By(Vec<(Option<String>, String)>),
}

/// A value in results.
#[derive(Clone, Debug)]
pub(crate) struct ResultFigure<'a> {
    /// The path to this value only.
    pub path: String,
    /// The key of the value.
    pub key: String,
    /// The number.
    pub value: f64,
    /// The objects around the value, the outermost first; at least one.
    pub around: Vec<&'a Map<String, Value>>,
}

impl<'a> ResultFigure<'a> {
    /// Returns the innermost object around the value.
    pub(super) fn object(&self) -> Option<&'a Map<String, Value>> {
        self.around.last().copied()
    }

    /// Returns another number in the same object.
    pub(super) fn beside(&self, key: &str) -> Option<f64> {
        self.object()?.get(key)?.as_f64()
    }
}

impl FigurePath {
    /// Parses a path.
    ///
    /// # Errors
    /// A message with the position in the text.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let mut letters = Letters { text, at: 0 };
        let mut steps = Vec::new();
        loop {
            let key = letters.until(&['.', '[', ']']);
            if key.is_empty() {
                return Err(letters.expected("a key"));
            }
            let chosen = match letters.next_if('[') {
                false => ElementChoice::Only,
                true => letters.chosen()?,
            };
            steps.push(PathStep { key, chosen });
            if letters.is_over() {
                return Ok(Self { steps });
            }
            if !letters.next_if('.') {
                return Err(letters.expected("a dot or the end"));
            }
        }
    }

    /// Returns the values that the path names, at least one.
    ///
    /// # Errors
    /// A message, if there is no such value, or it is not a number.
    pub(crate) fn places<'a>(&self, root: &'a Value) -> Result<Vec<ResultFigure<'a>>, String> {
        let mut found = Vec::new();
        let Value::Object(object) = root else {
            return Err("expected an object".into());
        };
        self.walk(0, String::new(), vec![object], &mut found)?;
        Ok(found)
    }

    fn walk<'a>(
        &self,
        at: usize,
        path: String,
        around: Vec<&'a Map<String, Value>>,
        found: &mut Vec<ResultFigure<'a>>,
    ) -> Result<(), String> {
        let (Some(step), Some(object)) = (self.steps.get(at), around.last()) else {
            return Ok(());
        };
        let whole = |path: &str| match path {
            "" => "the results have".to_owned(),
            path => format!("{path} has"),
        };
        let Some(value) = object.get(&step.key) else {
            return Err(format!(
                "{} no {:?}: expected one of {}",
                whole(&path),
                step.key,
                listed(object.keys().map(String::as_str))
            ));
        };
        let dot = if path.is_empty() { "" } else { "." };
        let path = format!("{path}{dot}{}", written(&step.key));
        let is_last = at + 1 == self.steps.len();
        for (path, value) in step.chosen(path, value)? {
            match value {
                Value::Object(inner) if !is_last => {
                    let around = around.iter().copied().chain([inner]).collect();
                    self.walk(at + 1, path, around, found)?;
                }
                Value::Number(number) if is_last => found.push(ResultFigure {
                    path,
                    key: step.key.clone(),
                    value: number.as_f64().unwrap_or(f64::NAN),
                    around: around.clone(),
                }),
                Value::Null => return Err(format!("{path} was not measured: it is null")),
                Value::Object(inner) => {
                    return Err(format!(
                        "{path}: expected a number, found an object with {}",
                        listed(inner.keys().map(String::as_str))
                    ));
                }
                other if is_last => {
                    return Err(format!("{path}: expected a number, found {}", kind(other)));
                }
                other => {
                    return Err(format!(
                        "{path}: expected an object with {:?}, found {}",
                        self.steps[at + 1].key,
                        kind(other)
                    ));
                }
            }
        }
        Ok(())
    }
}

impl PathStep {
    /// Returns the chosen values, with the path to each.
    fn chosen<'a>(
        &self,
        path: String,
        value: &'a Value,
    ) -> Result<Vec<(String, &'a Value)>, String> {
        let Value::Array(list) = value else {
            return match self.chosen {
                ElementChoice::Only => Ok(vec![(path, value)]),
                _ => Err(format!("{path}: expected a list, found {}", kind(value))),
            };
        };
        let named = |element: &'a Value| (format!("{path}[{}]", identity(element, list)), element);
        let others = || {
            let all = list
                .iter()
                .take(LISTED)
                .map(|element| identity(element, list));
            let mut all: Vec<String> = all.collect();
            all.extend((list.len() > LISTED).then(|| format!("{} more", list.len() - LISTED)));
            all.join(", ")
        };
        match &self.chosen {
            ElementChoice::Only => match list.as_slice() {
                [] => Err(format!("{path} is empty")),
                [one] => Ok(vec![named(one)]),
                _ => Err(format!(
                    "{path}: expected a choice of one of {} elements, such as [{}], found none: there are {}",
                    list.len(),
                    list.first()
                        .map(|first| identity(first, list))
                        .unwrap_or_default(),
                    others()
                )),
            },
            ElementChoice::Each if list.is_empty() => Err(format!("{path} is empty")),
            ElementChoice::Each => Ok(list.iter().map(named).collect()),
            ElementChoice::At(number) => match list.get(*number) {
                Some(one) => Ok(vec![named(one)]),
                None => Err(format!(
                    "{path}: expected an element number below {}, found #{number}",
                    list.len()
                )),
            },
            ElementChoice::By(keys) => {
                let is_meant = |element: &&Value| keys.iter().all(|key| is_like(element, key));
                let meant: Vec<&Value> = list.iter().filter(is_meant).collect();
                match meant.as_slice() {
                    [one] => Ok(vec![named(one)]),
                    several => Err(format!(
                        "{path}: expected one element for [{}], found {} among {}",
                        words(keys),
                        several.len(),
                        others()
                    )),
                }
            }
        }
    }
}

/// Returns whether an element has this value, under this key or under any of [`IDENTITIES`].
fn is_like(element: &Value, (key, wanted): &(Option<String>, String)) -> bool {
    let has = |key: &str| element.get(key).is_some_and(|value| same(value, wanted));
    match key {
        Some(key) => has(key),
        None => IDENTITIES.iter().any(|key| has(key)),
    }
}

/// Returns whether a value matches a word. Numbers match by value, objects by their `name`.
fn same(value: &Value, wanted: &str) -> bool {
    match value {
        Value::String(text) => text == wanted,
        Value::Number(number) => {
            let wanted: Option<f64> = wanted.parse().ok();
            wanted.is_some_and(|wanted| number.as_f64() == Some(wanted))
        }
        Value::Null => wanted == "none",
        Value::Object(inner) => inner.get("name").is_some_and(|name| same(name, wanted)),
        _ => false,
    }
}

/// Returns the keys that identify an element in its list: its name, if that suffices.
fn identity(element: &Value, list: &[Value]) -> String {
    let number = || {
        let at = list.iter().position(|other| std::ptr::eq(other, element));
        format!("#{}", at.unwrap_or_default())
    };
    if list.len() > TOLD_APART {
        return number();
    }
    let alike = |keys: &[(Option<String>, String)]| {
        let is_like = |other: &&Value| keys.iter().all(|key| is_like(other, key));
        list.iter().filter(is_like).count()
    };
    let mut keys: Vec<(Option<String>, String)> = Vec::new();
    for key in IDENTITIES {
        let word = match element.get(key) {
            Some(Value::String(text)) => text.clone(),
            Some(Value::Number(number)) => number.to_string(),
            Some(Value::Null) => "none".into(),
            Some(Value::Object(inner)) => match inner.get("name") {
                Some(Value::String(name)) => name.clone(),
                _ => continue,
            },
            _ => continue,
        };
        // A name needs no key.
        let is_name = key == "name";
        let one = ((!is_name).then(|| key.to_owned()), word);
        let with = [&keys[..], &[one]].concat();
        // Keys that do not distinguish it from others are left out.
        if is_name || alike(&with) < alike(&keys) || list.len() == 1 && keys.is_empty() {
            keys = with;
        }
        if alike(&keys) == 1 {
            break;
        }
    }
    // The only element of a list may have no such key.
    if alike(&keys) == 1 && !keys.is_empty() {
        words(&keys)
    } else {
        number()
    }
}

/// Returns the text in the brackets.
fn words(keys: &[(Option<String>, String)]) -> String {
    let word = |(key, value): &(Option<String>, String)| match key {
        Some(key) => format!("{}={}", written(key), written(value)),
        None => written(value),
    };
    let words: Vec<String> = keys.iter().map(word).collect();
    words.join(",")
}

/// Returns a word as it is written in a path, in quotation marks if necessary.
pub(super) fn written(word: &str) -> String {
    let is_plain = !word.is_empty() && !word.contains(['.', '[', ']', ',', '=', '"', '*']);
    if is_plain || word.parse::<f64>().is_ok() {
        word.to_owned()
    } else {
        format!("\"{word}\"")
    }
}

fn listed<'a>(words: impl Iterator<Item = &'a str>) -> String {
    let all: Vec<&str> = words.collect();
    match all.len() {
        0 => "none".into(),
        count if count > LISTED => {
            format!("{} and {} more", all[..LISTED].join(", "), count - LISTED)
        }
        _ => all.join(", "),
    }
}

fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "nothing",
        Value::Bool(_) => "a truth value",
        Value::Number(_) => "a number",
        Value::String(_) => "text",
        Value::Array(_) => "a list",
        Value::Object(_) => "an object",
    }
}

/// A parser of the characters of a path.
struct Letters<'t> {
    text: &'t str,
    at: usize,
}

impl Letters<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn is_over(&self) -> bool {
        self.rest().is_empty()
    }

    fn next_if(&mut self, letter: char) -> bool {
        let is_next = self.rest().starts_with(letter);
        if is_next {
            self.at += letter.len_utf8();
        }
        is_next
    }

    /// Reads a word in quotation marks, or up to any of these characters.
    fn until(&mut self, ends: &[char]) -> String {
        let rest = self.rest();
        if let Some(quoted) = rest.strip_prefix('"')
            && let Some(end) = quoted.find('"')
        {
            let word = quoted[..end].to_owned();
            self.at += end + 2;
            return word;
        }
        let end = rest.find(ends).unwrap_or(rest.len());
        let word = rest[..end].trim().to_owned();
        self.at += end;
        word
    }

    /// Reads the text in brackets, after the opening one.
    fn chosen(&mut self) -> Result<ElementChoice, String> {
        let mut keys = Vec::new();
        loop {
            let is_quoted = self.rest().starts_with('"');
            let word = self.until(&[',', '=', ']', '[']);
            if word.is_empty() && !is_quoted {
                return Err(self.expected("a name, KEY=VALUE or *"));
            }
            let number = word
                .strip_prefix('#')
                .and_then(|number| number.parse().ok());
            if let Some(number) = number.filter(|_| !is_quoted && keys.is_empty())
                && self.next_if(']')
            {
                return Ok(ElementChoice::At(number));
            }
            if self.next_if('=') {
                let value = self.until(&[',', '=', ']', '[']);
                keys.push((Some(word), value));
            } else if word == "*" && !is_quoted && keys.is_empty() && self.next_if(']') {
                return Ok(ElementChoice::Each);
            } else {
                keys.push((None, word));
            }
            if self.next_if(']') {
                return Ok(ElementChoice::By(keys));
            }
            if !self.next_if(',') {
                return Err(self.expected("a comma or a closing bracket"));
            }
        }
    }

    fn expected(&self, what: &str) -> String {
        let found = match self.rest().chars().next() {
            Some(letter) => format!("{letter:?} at letter {}", 1 + self.at),
            None => "its end".into(),
        };
        format!("{:?}: expected {what}, found {found}", self.text)
    }
}

#[cfg(test)]
mod tests;
