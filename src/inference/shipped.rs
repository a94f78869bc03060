//! The models that the program contains.

use super::{Contract, Model};
use crate::error::{Error, Result};
use std::path::Path;

/// A model that the program contains.
struct Shipped {
    name: &'static str,
    graph: &'static [u8],
    contract: &'static str,
}

macro_rules! shipped {
    ($name:literal) => {
        Shipped {
            name: $name,
            graph: include_bytes!(concat!("../../models/", $name, ".onnx")),
            contract: include_str!(concat!("../../models/", $name, ".toml")),
        }
    };
}

/// The shipped models; `models/README.md` has a card for each.
const SHIPPED: [Shipped; 6] = [
    shipped!("side"),
    shipped!("spread"),
    shipped!("gei-small"),
    shipped!("geinet"),
    shipped!("geinet-int8"),
    shipped!("gaitset-small"),
];
/// The number of linear models, which come first: results list these if no model is named.
const LINEAR: usize = 2;

/// Returns the names of all shipped models.
#[must_use]
pub fn names() -> [&'static str; 6] {
    SHIPPED.map(|shipped| shipped.name)
}

/// Returns the linear models, in the order in which results list them.
///
/// # Errors
/// Never, for the models shipped.
pub fn linear() -> Result<Vec<Model>> {
    SHIPPED.iter().take(LINEAR).map(model).collect()
}

/// Returns whether a path is the name of a shipped model, and no file has this name.
#[must_use]
pub fn is_name(path: &Path) -> bool {
    names().iter().any(|name| path == Path::new(name)) && !path.exists()
}

/// Checks that a path that looks like a shipped model's name is one, or exists.
///
/// # Errors
/// If it is neither; the error lists the names.
pub fn require_name(path: &Path) -> Result<()> {
    let is_bare = path.components().count() == 1 && path.extension().is_none();
    if !is_bare || path.exists() || is_name(path) {
        return Ok(());
    }
    Err(Error::input(
        path,
        format!(
            "expected a file or folder, or a shipped model's name ({}), found neither",
            names().join(", ")
        ),
    ))
}

/// Opens the model at `path`, or the shipped model of this name if no file has it.
///
/// # Errors
/// If the file or its contract cannot be used.
pub fn open(path: &Path) -> Result<Model> {
    let named = SHIPPED
        .iter()
        .find(|shipped| path == Path::new(shipped.name));
    match named.filter(|_| !path.exists()) {
        Some(shipped) => model(shipped),
        None => Model::open(path),
    }
}

fn model(shipped: &Shipped) -> Result<Model> {
    let Shipped {
        name,
        graph,
        contract,
    } = shipped;
    let path = format!("models/{name}.onnx");
    let contract = Contract::parse(Path::new(&format!("models/{name}.toml")), contract)?;
    Model::from_bytes(path, *graph, contract)
}

#[cfg(test)]
mod tests {
    use super::super::testing::ort_library;
    use super::super::{Outputs, Runtime};
    use super::*;
    use crate::draw::sweep::{Job, Settings, Views, sweep};
    use crate::people::cohort::{self, CohortOptions};
    use edgegait_core::pack::Pack;
    use std::sync::OnceLock;

    /// Renders GEIs of four people from the side, in the range that the models take.
    fn geis() -> Vec<f32> {
        let options = CohortOptions {
            people: 4,
            speeds_kmh: vec![5.0],
            ..CohortOptions::default()
        };
        let people = cohort::subjects(&options).expect("four people");
        let bytes = crate::encode::encode_subjects(&people, 5.0, &|| Ok(())).expect("a pack");
        let pack = Pack::parse(&bytes).expect("it was just encoded");
        let jobs: Vec<Job<'_>> = (0..4).map(|walk| Job::plain(walk, 1_000)).collect();
        let settings = Settings::default();
        let views = Views::side().expect("the side view").list;
        let mut geis = Vec::new();
        let keep = |_: Job<'_>, swept: crate::draw::sweep::Swept| Ok(swept.templates);
        sweep(&pack, &jobs, &views, settings, keep, |_, found| {
            geis.extend(found[0].iter().map(|&pixel| f32::from(pixel) / 255.0));
            Ok(())
        })
        .expect("four GEIs");
        geis
    }

    fn outputs(runtime: &Runtime, model: &Model) -> Outputs {
        static GEIS: OnceLock<Vec<f32>> = OnceLock::new();
        let recognizer = runtime.load(model).expect("a shipped model");
        let geis = GEIS.get_or_init(geis);
        recognizer.run(geis, 4).expect("four answers")
    }

    #[test]
    fn a_name_that_is_none_is_told_those_that_there_are() {
        for fine in ["geinet", "src", "no/such", "such.onnx", "Cargo.toml"] {
            assert!(require_name(Path::new(fine)).is_ok(), "{fine}");
        }
        let error = require_name(Path::new("geinett")).expect_err("no name");
        let text = error.to_string();
        assert!(
            text.starts_with("geinett: ") && text.contains("geinet, geinet-int8"),
            "{text}"
        );
    }

    #[test]
    fn the_shipped_contracts_are_written_as_they_are() {
        for Shipped {
            name,
            contract: text,
            ..
        } in SHIPPED
        {
            let contract = Contract::parse(Path::new(name), text).expect("a shipped contract");
            assert_eq!(contract.to_toml().expect("plain values"), text);
        }
    }

    #[test]
    fn the_linear_models_know_the_first_people_from_the_side() {
        for model in linear().expect("the shipped models") {
            assert_eq!(model.contract().classes[..4], ["F01", "M01", "F02", "M02"]);
            let outputs = outputs(&Runtime::rten(), &model);
            assert_eq!((outputs.embedding_dims, outputs.classes), (25, 26));
            let scores = outputs.scores.expect("class scores");
            let hits = scores.chunks(26).enumerate().filter(|(person, scores)| {
                let best = (0..26).max_by(|&a, &b| scores[a].total_cmp(&scores[b]));
                best == Some(*person)
            });
            // `side` is for this view and misses none; `spread` misses one in ten.
            let (name, hits) = (&model.contract().name, hits.count());
            assert!(
                hits == 4 || (name == "spread" && hits == 3),
                "{name}: {hits}"
            );
        }
    }

    mod with_ort {
        use super::*;

        #[test]
        #[ignore = "needs EDGEGAIT_ORT_LIB"]
        fn the_linear_models_compute_the_same_on_both_runtimes() {
            let ort = Runtime::ort(ort_library()).expect("an ONNX Runtime");
            for model in linear().expect("the shipped models") {
                let (ours, theirs) = (outputs(&Runtime::rten(), &model), outputs(&ort, &model));
                let largest = ours.embedding.iter().fold(0.0f32, |m, x| m.max(x.abs()));
                let difference = ours
                    .embedding
                    .iter()
                    .zip(&theirs.embedding)
                    .map(|(a, b)| (a - b).abs() / largest)
                    .fold(0.0, f32::max);
                eprintln!("{}: {difference:e} of the largest", model.contract().name);
                assert!(difference < 1e-5, "{difference}");
            }
        }
    }
}
