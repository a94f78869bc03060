//! The rows of recognizers in the JSON results of a command.

use crate::command::done;
use serde_json::{Map, Value};
use std::path::Path;

pub fn words(command: &str) -> Vec<&str> {
    command.split_whitespace().collect()
}

pub fn results(at: &Path, command: &str) -> Value {
    let printed = done(at, &words(&format!("{command} --json -")));
    serde_json::from_str(&printed).expect("JSON")
}

pub fn warnings(results: &Value) -> String {
    results["warnings"].to_string()
}

/// Returns the results of each recognizer without its name and its times.
pub fn rows(results: &Value) -> Vec<(String, Map<String, Value>)> {
    let all = results["recognizers"].as_array().expect("a list");
    let row = |result: &Value| {
        let mut row = result.as_object().expect("an object").clone();
        let name = row.remove("name").expect("a name");
        row.retain(|key, _| !key.ends_with("_us"));
        (name.as_str().expect("text").to_owned(), row)
    };
    all.iter().map(row).collect()
}

pub fn row(all: &[(String, Map<String, Value>)], name: &str) -> Map<String, Value> {
    let found = all.iter().find(|(other, _)| other == name);
    let names = || all.iter().map(|(name, _)| name).collect::<Vec<_>>();
    found
        .unwrap_or_else(|| panic!("{name} of {:?}", names()))
        .1
        .clone()
}
