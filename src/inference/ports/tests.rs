use super::*;
use crate::inference::Model;
use crate::inference::testing::{bytes_with, small_model};

fn refusal(bytes: Vec<u8>, contract: Contract) -> String {
    Model::from_bytes("m.onnx", bytes, contract)
        .expect_err("does not agree")
        .to_string()
}

#[test]
fn our_own_model_agrees_with_the_default_contract() {
    let model = small_model();
    assert_eq!(model.contract().name, "small");
    let ports = Ports {
        input: "gei".into(),
        view: None,
        embedding: "embedding".into(),
        scores: Some("scores".into()),
        batching: Batching::Any,
        element: Element::F32,
    };
    assert_eq!(model.ports(), &ports);
}

/// Returns a refusal's text without the file.
fn refused(bytes: Vec<u8>, contract: Contract) -> String {
    refusal(bytes, contract).replace("m.onnx: ", "")
}

fn gei(layout: InputLayout) -> Contract {
    Contract {
        layout,
        ..Contract::default()
    }
}

fn silhouettes(layout: InputLayout, frames: Option<usize>) -> Contract {
    Contract {
        template: Template::Silhouettes,
        layout,
        frames,
        ..Contract::default()
    }
}

const IMAGE: [Option<u16>; 4] = [None, Some(1), Some(50), Some(30)];

#[test]
fn inputs_that_do_not_fit_are_refused_with_both_shapes() {
    let any = None;
    let (one, h, w) = (Some(1), Some(50), Some(30));
    let no_size = "silhouettes are drawn as 50x30, 64x44, 64x64: export the model for one of these";
    let would_fit = |template: &str, layout: &str| {
        format!("in its .toml: template = {template:?}, layout = {layout:?}")
    };
    for (contract, element, found, expected, listed, way_out) in [
        (
            gei(InputLayout::Nchw),
            1,
            vec![any, one, Some(64), Some(44)],
            "[N, 1, 50, 30]",
            "f32 [N, 1, 64, 44]",
            would_fit("gei", "NCHW") + ", rows = 64, columns = 44",
        ),
        (
            gei(InputLayout::Nchw),
            1,
            vec![any, Some(1501)],
            "[N, 1, 50, 30]",
            "f32 [N, 1501]",
            no_size.to_owned(),
        ),
        (
            gei(InputLayout::Nchw),
            1,
            vec![any, Some(1500)],
            "[N, 1, 50, 30]",
            "f32 [N, 1500]",
            would_fit("gei", "ND"),
        ),
        (
            gei(InputLayout::Nchw),
            7,
            IMAGE.to_vec(),
            "[N, 1, 50, 30]",
            "i64 [N, 1, 50, 30]",
            "export it with an input of f32; f64 and u8 work too".to_owned(),
        ),
        (
            gei(InputLayout::Nchw),
            1,
            vec![any, one, Some(128), Some(88)],
            "[N, 1, 50, 30]",
            "f32 [N, 1, 128, 88]",
            no_size.to_owned(),
        ),
        (
            gei(InputLayout::Nchw),
            1,
            vec![any, Some(3), h, w],
            "[N, 1, 50, 30]",
            "f32 [N, 3, 50, 30]",
            would_fit("gei", "NCHW") + ", channels = 3",
        ),
        (
            gei(InputLayout::Nchw),
            1,
            vec![any, h, w, one],
            "[N, 1, 50, 30]",
            "f32 [N, 50, 30, 1]",
            would_fit("gei", "NHWC"),
        ),
        (
            gei(InputLayout::Nhwc),
            1,
            IMAGE.to_vec(),
            "[N, 50, 30, 1]",
            "f32 [N, 1, 50, 30]",
            would_fit("gei", "NCHW"),
        ),
        (
            gei(InputLayout::Nhw),
            1,
            vec![any, w, h],
            "[N, 50, 30]",
            "f32 [N, 30, 50]",
            no_size.to_owned(),
        ),
        (
            silhouettes(InputLayout::Nthw, None),
            1,
            vec![any, any, one, h, w],
            "[N, T, 50, 30]",
            "f32 [N, T, 1, 50, 30]",
            would_fit("silhouettes", "NTCHW"),
        ),
        (
            silhouettes(InputLayout::Ntchw, None),
            1,
            vec![any, any, h, w],
            "[N, T, 1, 50, 30]",
            "f32 [N, T, 50, 30]",
            would_fit("silhouettes", "NTHW"),
        ),
        (
            silhouettes(InputLayout::Ntchw, Some(30)),
            1,
            vec![any, one, Some(30), h, w],
            "[N, 30, 1, 50, 30]",
            "f32 [N, 1, 30, 50, 30]",
            would_fit("silhouettes", "NCTHW"),
        ),
        (
            gei(InputLayout::Nchw),
            1,
            vec![any, Some(60)],
            "[N, 1, 50, 30]",
            "f32 [N, 60]",
            would_fit("kfd", "ND"),
        ),
        (
            Contract {
                template: Template::Frequency,
                ..Contract::default()
            },
            1,
            IMAGE.to_vec(),
            "[N, 3, 50, 30]",
            "f32 [N, 1, 50, 30]",
            would_fit("gei", "NCHW"),
        ),
        (
            silhouettes(InputLayout::Nthw, Some(30)),
            1,
            vec![any, Some(20), h, w],
            "[N, 30, 50, 30]",
            "f32 [N, 20, 50, 30]",
            "in its .toml: frames = 20, or no such key".to_owned(),
        ),
    ] {
        let expected =
            format!("expected the input as f32 {expected}, found \"gei\" {listed} ({way_out})");
        assert_eq!(
            refused(bytes_with(element, &found, 1, 2), contract),
            expected
        );
    }
    let text = refused(
        bytes_with(1, &[Some(8), one, h, w], 1, 2),
        Contract::default(),
    );
    assert!(
        text.contains("expected a free batch axis or one of 1, found 8"),
        "{text}"
    );
}

#[test]
fn bytes_are_taken_as_they_are_and_other_numbers_in_their_ranges() {
    let of = |element, contract: Contract| {
        let model = Model::from_bytes("m.onnx", bytes_with(element, &IMAGE, 1, 2), contract);
        model.map(|model| model.ports().element)
    };
    let bytes = || Contract {
        input_range: InputRange::Byte,
        ..Contract::default()
    };
    assert_eq!(of(2, bytes()).ok(), Some(Element::U8));
    assert_eq!(of(11, Contract::default()).ok(), Some(Element::F64));
    let shifted = Contract {
        mean: vec![1.0],
        ..bytes()
    };
    for (contract, words) in [
        (
            Contract::default(),
            "found input_range \"0..1\" (in its .toml",
        ),
        (shifted, "found input_range \"0..255\" with mean or std"),
    ] {
        let said = of(2, contract).expect_err(words).to_string();
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn two_inputs_are_refused_and_listed() {
    // GraphProto.input { name "mask" } after a whole model.
    let mut bytes = bytes_with(1, &IMAGE, 1, 2);
    bytes.extend(b"\x3A\x08\x5A\x06\x0A\x04mask");
    let text = refused(bytes, Contract::default());
    assert_eq!(
        text,
        "expected one input of f32 [N, 1, 50, 30], found \"gei\" f32 [N, 1, 50, 30], \"mask\" unknown of any shape (export a graph that takes images only; if it also takes viewpoints, name their input in its .toml: view_input = \"NAME\")"
    );
}

#[test]
fn every_layout_fits_its_own_shape() {
    let (one, h, w) = (Some(1), Some(50), Some(30));
    for (layout, shape) in [
        (InputLayout::Nchw, vec![None, one, h, w]),
        (InputLayout::Nhwc, vec![None, h, w, one]),
        (InputLayout::Nhw, vec![None, h, w]),
        (InputLayout::Nthw, vec![None, None, h, w]),
        (InputLayout::Ntchw, vec![None, None, one, h, w]),
        (InputLayout::Ncthw, vec![None, one, None, h, w]),
    ] {
        let contract = if layout.holds(Template::Gei) {
            gei(layout)
        } else {
            silhouettes(layout, None)
        };
        let bytes = bytes_with(1, &shape, 1, 2);
        let model = Model::from_bytes("m.onnx", bytes, contract).expect("its own shape");
        assert_eq!(
            (model.contract().frames, model.batching()),
            (None, Batching::Any)
        );
    }
}

#[test]
fn outputs_that_do_not_fit_are_refused_with_both_shapes() {
    let text = refused(bytes_with(1, &IMAGE, 7, 2), Contract::default());
    assert!(text.contains("found \"out\" i64 [N, 4]"), "{text}");
    let text = refused(bytes_with(1, &IMAGE, 1, 4), Contract::default());
    let expected = "expected the embedding as f32 [N, numbers] or [N, numbers, parts], found \"out\" f32 [N, 4, 4, 4]";
    assert!(text.starts_with(expected), "{text}");
    assert!(Model::from_bytes("m.onnx", bytes_with(1, &IMAGE, 1, 3), Contract::default()).is_ok());

    assert!(text.ends_with("(end the model with Flatten, or name another output in its .toml: outputs.embedding = \"NAME\")"), "{text}");

    let mut contract = Contract {
        classes: ["a", "b", "c", "d"].map(String::from).to_vec(),
        ..Contract::default()
    };
    let text = refused(bytes_with(1, &IMAGE, 1, 3), contract.clone());
    let expected = "expected an output \"scores\" for the 4 classes in the contract, found \"out\" f32 [N, 4, 4]";
    assert!(text.starts_with(expected), "{text}");
    contract.outputs.scores = Some("out".into());
    let text = refused(bytes_with(1, &IMAGE, 1, 3), contract);
    let expected = "expected the scores as f32 [N, classes], found \"out\" f32 [N, 4, 4]";
    assert!(text.starts_with(expected), "{text}");
}

#[test]
fn a_batch_of_one_and_a_single_output_of_any_name_will_do() {
    let bytes = bytes_with(1, &[Some(1), Some(1), Some(50), Some(30)], 1, 2);
    let model = Model::from_bytes("m.onnx", bytes, Contract::default()).expect("usable");
    assert_eq!(model.batching(), Batching::FixedOne);
    assert_eq!(
        (model.ports().embedding.as_str(), &model.ports().scores),
        ("out", &None)
    );
}

#[test]
fn names_and_classes_of_the_contract_are_compared() {
    let classes = ["a", "b", "c"].map(String::from).to_vec();
    let mut contract = Contract {
        classes,
        ..Contract::default()
    };
    let text = refusal(small_model().bytes().to_vec(), contract.clone());
    assert!(
        text.contains("each of the 3 classes in the contract, found \"scores\" f32 [N, 2]"),
        "{text}"
    );
    contract.outputs.embedding = Some("features".into());
    let text = refusal(small_model().bytes().to_vec(), contract);
    assert!(
        text.contains("expected an output \"features\" as the contract says, found \"embedding\""),
        "{text}"
    );
}
