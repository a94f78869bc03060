use super::*;

const ALL: &str = r#"
name = "pca-lda-side"
input_range = "0..255"
rows = 64
columns = 44
layout = "NCHW"
framing = "cycle"
template = "gei"
classes = ["s01", "s02"]

[outputs]
embedding = "features"
scores = "logits"

[training]
description = "26 people, side view, seed 7"
viewpoints = [[90.0, 0.0], [270.0, 15.0]]
"#;

fn parse(text: &str) -> Result<Contract> {
    Contract::parse(Path::new("m.toml"), text)
}

#[test]
fn every_key_is_read() {
    let contract = parse(ALL).expect("all keys are known");
    assert_eq!(contract.name, "pca-lda-side");
    assert_eq!(contract.input_range, InputRange::Byte);
    assert_eq!(
        (contract.rows, contract.columns, contract.numbers()),
        (64, 44, 2816)
    );
    assert_eq!(contract.framing, FramingMode::Cycle);
    assert_eq!(contract.classes, ["s01", "s02"]);
    assert_eq!(contract.outputs.embedding.as_deref(), Some("features"));
    assert_eq!(contract.outputs.scores.as_deref(), Some("logits"));
    assert_eq!(contract.training.viewpoints, [[90.0, 0.0], [270.0, 15.0]]);
}

fn fed(contract: &Contract, bytes: &[u8]) -> Vec<f32> {
    let mut input = Vec::new();
    contract.feed(bytes, &mut input);
    input
}

#[test]
fn numbers_have_their_mean_taken_off_and_are_divided() {
    let contract = parse("mean = 0.5\nstd = [0.25]\n").expect("known keys");
    assert_eq!(fed(&contract, &[0, 255]), [-2.0, 2.0]);
    let signed = parse("input_range = \"-1..1\"\n").expect("known keys");
    assert_eq!(fed(&signed, &[0, 255]), [-1.0, 1.0]);
    assert_eq!(fed(&Contract::default(), &[0, 51, 255]), [0.0, 0.2, 1.0]);
}

#[test]
fn equal_channels_come_in_the_order_of_the_layout() {
    // Two frames of one row and two columns.
    let of = |layout: &str, template: &str| {
        let text = format!(
            "layout = {layout:?}\ntemplate = {template:?}\nrows = 1\ncolumns = 2\nchannels = 2\n\
             input_range = \"0..255\"\nmean = [0, 100]\n"
        );
        parse(&text).expect("known keys")
    };
    let gei = [1, 2];
    assert_eq!(fed(&of("NCHW", "gei"), &gei), [1.0, 2.0, -99.0, -98.0]);
    assert_eq!(fed(&of("NHWC", "gei"), &gei), [1.0, -99.0, 2.0, -98.0]);
    let frames = [1, 2, 3, 4];
    assert_eq!(
        fed(&of("NTCHW", "silhouettes"), &frames),
        [1.0, 2.0, -99.0, -98.0, 3.0, 4.0, -97.0, -96.0]
    );
    assert_eq!(
        fed(&of("NCTHW", "silhouettes"), &frames),
        [1.0, 2.0, 3.0, 4.0, -99.0, -98.0, -97.0, -96.0]
    );
    let contract = of("NTCHW", "silhouettes");
    assert_eq!((contract.numbers(), contract.input_numbers()), (2, 4));
    assert_eq!(contract.input_shape(3, 2), [3, 2, 2, 1, 2]);
    assert_eq!(contract.frames_in(8, 1).ok(), Some(2));
    let said = contract
        .frames_in(6, 1)
        .expect_err("one and a half")
        .to_string();
    assert!(said.contains("1 x 2 in 2 channels = 4 numbers"), "{said}");
}

#[test]
fn channels_and_their_numbers_that_do_not_fit_are_refused() {
    for (text, words) in [
        ("channels = 0", "channels: expected 1 to 16, found 0"),
        ("channels = 17", "channels: expected 1 to 16, found 17"),
        (
            "channels = 3\nlayout = \"ND\"",
            "channels: layout ND has none, found 3",
        ),
        (
            "channels = 3\ntemplate = \"frequency\"",
            "channels: template \"frequency\" has its own, found 3",
        ),
        (
            "mean = [1, 2]",
            "mean: expected one number, or one for each of 1 channels, found 2",
        ),
        ("std = 0", "std: expected numbers above 0, found 0"),
        ("mean = inf", "mean: expected finite numbers, found inf"),
        (
            "mean = \"half\"",
            "m.toml:1: expected a number, or a list of numbers",
        ),
    ] {
        let said = parse(text).expect_err(text).to_string();
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn a_written_contract_reads_back() {
    let contract = parse(ALL).expect("all keys are known");
    let text = contract.to_toml().expect("plain values");
    assert_eq!(parse(&text).expect("our own text"), contract);
    let defaults = Contract::default();
    assert_eq!(
        parse(&defaults.to_toml().expect("plain values")).expect("our own text"),
        defaults
    );
}

#[test]
fn geis_of_another_size_or_framing_are_refused() {
    let contract = parse(ALL).expect("all keys are known");
    let refusal = |size, framing| {
        let found = contract.require(size, framing, TemplateOrigin::Drawn);
        found.map_err(|error| error.to_string())
    };
    assert_eq!(refusal(Size::S64x44, Some(FramingMode::Cycle)), Ok(()));
    assert_eq!(refusal(Size::S64x44, None), Ok(()));
    assert_eq!(
        refusal(Size::S50x30, Some(FramingMode::Cycle)),
        Err("pca-lda-side: the model's contract asks for size 64x44, found 50x30".into())
    );
    assert_eq!(
        refusal(Size::S64x44, Some(FramingMode::Height)),
        Err("pca-lda-side: the model's contract asks for framing cycle, found height".into())
    );
    let odd = Contract {
        rows: 128,
        ..contract.clone()
    };
    let refused = odd
        .require(Size::S64x44, None, TemplateOrigin::Drawn)
        .map_err(|e| e.to_string());
    assert!(refused.is_err_and(|text| text.contains("size 128x44")));
}

#[test]
fn an_empty_contract_is_the_default() {
    let contract = parse("").expect("every key may be left out");
    assert_eq!(contract, Contract::default());
    let mut fed = vec![0.5];
    contract.feed(&[0, 255], &mut fed);
    assert_eq!(fed, [0.5, 0.0, 1.0]);
}

#[test]
fn a_sequence_model_states_its_layout_frames_and_distance() {
    let text =
        "template = \"silhouettes\"\nlayout = \"NTHW\"\nframes = 30\ndistance = \"cosine\"\n";
    let contract = parse(text).expect("all keys are known");
    assert_eq!(contract.template, Template::Silhouettes);
    assert_eq!(contract.frames, Some(30));
    assert_eq!(contract.distance, Distance::Cosine);
    assert_eq!(contract.input_shape(2, 30), [2, 30, 50, 30]);
    let written = contract.to_toml().expect("plain values");
    assert_eq!(parse(&written).expect("our own text"), contract);

    let refusal = |text: &str| parse(text).expect_err("a mistake").to_string();
    assert_eq!(
        refusal("template = \"silhouettes\""),
        "m.toml: layout: template \"silhouettes\" comes as NTHW, NTCHW, NCTHW, found NCHW (the default is NCHW)"
    );
    assert!(refusal("layout = \"NTHW\"").contains("template \"gei\" comes as NCHW, NHWC, NHW"));
    assert_eq!(
        refusal("frames = 30"),
        "m.toml: frames: template \"gei\" has none, found 30"
    );
    assert_eq!(
        refusal("template = \"silhouettes\"\nlayout = \"NTHW\"\nframes = 0"),
        "m.toml: frames: expected 1 to 4096, found 0"
    );
}

#[test]
fn a_template_has_the_shape_that_its_silhouettes_give_it() {
    let of = |template: &str, layout: &str| {
        let text = format!("template = {template:?}\nlayout = {layout:?}\n");
        let contract = parse(&text).expect("a template's layout");
        let written = contract.to_toml().expect("plain values");
        assert_eq!(parse(&written).expect("our own text"), contract);
        contract.input_shape(2, 1)
    };
    assert_eq!(of("mhi", "NCHW"), [2, 1, 50, 30]);
    assert_eq!(of("geni", "NHWC"), [2, 50, 30, 1]);
    assert_eq!(of("frequency", "NCHW"), [2, 3, 50, 30]);
    assert_eq!(of("row-width", "ND"), [2, 50]);
    assert_eq!(of("kfd", "NC"), [2, 60]);

    let refusal = |text: &str| parse(text).expect_err("a mistake").to_string();
    assert_eq!(
        refusal("template = \"frequency\"\nlayout = \"NHWC\""),
        "m.toml: layout: template \"frequency\" comes as NCHW, found NHWC (the default is NCHW)"
    );
    assert!(refusal("template = \"kfd\"").contains("comes as ND, found NCHW"));
    assert_eq!(of("gei", "ND"), [2, 1500]);
    assert!(refusal("layout = \"NTHW\"").contains("template \"gei\" comes as NCHW, NHWC, NHW, ND"));

    let wide = parse("template = \"frequency\"").expect("the usual layout");
    assert_eq!(wide.frames_in(2 * 4500, 2).ok(), Some(1));
    let error = wide.frames_in(1500, 1).expect_err("one plane").to_string();
    assert_eq!(
        error,
        ": expected 1 frequency images of 3 x 50 x 30 = 4500 numbers and at least one, found 1500 numbers"
    );
    let refused = wide.require_template(Template::Gei, TemplateOrigin::Dataset);
    assert_eq!(
        refused.expect_err("another").to_string(),
        ": the model's contract asks for template frequency, found gei"
    );
    assert!(
        wide.require_template(Template::Frequency, TemplateOrigin::Drawn)
            .is_ok()
    );
}

#[test]
fn frames_are_counted_from_the_numbers_given() {
    let gei = Contract::default();
    assert_eq!(gei.frames_in(3 * 1500, 3).ok(), Some(1));
    assert!(gei.frames_in(3 * 1500, 1).is_err());
    let any = Contract {
        name: "set".into(),
        template: Template::Silhouettes,
        layout: InputLayout::Nthw,
        ..Contract::default()
    };
    assert_eq!(any.frames_in(12 * 1500, 3).ok(), Some(4));
    let wrong = [(0, 1), (1500, 0), (1501, 1), (1500, 2), (1500, usize::MAX)];
    assert!(
        wrong
            .iter()
            .all(|&(numbers, batch)| any.frames_in(numbers, batch).is_err())
    );
    let thirty = Contract {
        frames: Some(30),
        ..any
    };
    assert_eq!(thirty.frames_in(60 * 1500, 2).ok(), Some(30));
    let error = thirty.frames_in(29 * 1500, 1).expect_err("29 of 30");
    assert_eq!(
        error.to_string(),
        "set: expected 1 sequences of 30 silhouettes of 50 x 30 = 1500 numbers and at least one, found 43500 numbers"
    );
}

#[test]
fn mistakes_are_named_with_their_line() {
    let refusal = |text: &str| parse(text).expect_err("a mistake").to_string();
    let text = refusal("name = \"x\"\ninput_rnage = \"0..1\"\n");
    assert!(
        text.starts_with("m.toml:2") && text.contains("input_rnage"),
        "{text}"
    );
    let text = refusal("input_range = \"-2..2\"\n");
    assert!(
        text.starts_with("m.toml:1") && text.contains("0..255"),
        "{text}"
    );
    assert!(refusal("layout = \"CHW\"").contains("`NCHW`"));
    let text = refusal("template = \"vtm\"");
    assert!(
        text.starts_with("m.toml:1") && text.contains("`gei`, `mei`, `mhi`"),
        "{text}"
    );
    assert!(refusal("distance = \"dtw\"").contains("one of `euclidean`, `cosine`, `votes`"));
    assert_eq!(
        refusal("rows = 0"),
        "m.toml: rows: expected 1 to 4096, found 0"
    );
    assert_eq!(
        refusal("classes = [\"a\", \"a\"]"),
        "m.toml: classes: \"a\" appears twice"
    );
    assert!(refusal("training = { viewpoints = [[nan, 0.0]] }").contains("found NaN"));
    assert!(refusal("rows = ").starts_with("m.toml:1"));
}

#[test]
fn the_contract_beside_a_model_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let model = folder.path().join("m.onnx");
    assert_eq!(Contract::stated_beside(&model).expect("none there"), None);
    std::fs::write(folder.path().join("m.toml"), "name = \"here\"").expect("written");
    let stated = Contract::stated_beside(&model).expect("one there");
    assert_eq!(stated.expect("stated").name, "here");
}
