//! Multiply-accumulates of graphs whose counts are published or can be found by hand.

use super::super::written::{graph, integers, node, stated, weights};
use crate::inference::Graph;
use crate::inference::shipped;

/// Returns GEINet (Shiraga 2016) at 50x30 with 256 hidden numbers and 26 people, without its
/// normalisations; `flatten` goes from `p2` to `f`.
fn geinet(flatten: &[Vec<u8>]) -> Graph {
    let parts = [
        weights("w1", 1, &[18, 1, 7, 7]),
        weights("b1", 1, &[18]),
        node("Conv", "x w1 b1", "c1", &["kernel_shape=[7,7]"]),
        node("Relu", "c1", "r1", &[]),
        node(
            "MaxPool",
            "r1",
            "p1",
            &["kernel_shape=[2,2]", "strides=[2,2]"],
        ),
        weights("w2", 1, &[45, 18, 5, 5]),
        weights("b2", 1, &[45]),
        node("Conv", "p1 w2 b2", "c2", &[]),
        node("Relu", "c2", "r2", &[]),
        node(
            "MaxPool",
            "r2",
            "p2",
            &["kernel_shape=[3,3]", "strides=[2,2]"],
        ),
        flatten.concat(),
        weights("w3", 1, &[256, 1080]),
        weights("b3", 1, &[256]),
        node("Gemm", "f w3 b3", "h", &["transB=1"]),
        node("Relu", "h", "r3", &[]),
        weights("w4", 1, &[256, 26]),
        weights("b4", 1, &[26]),
        node("MatMul", "r3 w4", "m", &[]),
        node("Add", "m b4", "out", &[]),
        stated(12, "out", &[0, 26]),
    ];
    graph(&[0, 1, 50, 30], &parts)
}

#[test]
fn geinet_has_the_parameters_and_multiply_accumulates_of_its_description() {
    let found = geinet(&[node("Flatten", "p2", "f", &[])]);
    assert_eq!(found.parameters, 304_613);
    assert_eq!(found.macs(&[1, 1, 50, 30]), Ok(4_130_528));
    assert_eq!(found.macs(&[64, 1, 50, 30]), Ok(64 * 4_130_528));
}

#[test]
fn a_shape_that_the_graph_computes_is_followed() {
    let found = geinet(&[
        node("Shape", "p2", "s", &[]),
        integers("first", &[0]),
        node("Gather", "s first", "n", &[]),
        integers("rest", &[-1]),
        node("Concat", "n rest", "to", &["axis=0"]),
        node("Reshape", "p2 to", "f", &[]),
    ]);
    assert_eq!(found.macs(&[1, 1, 50, 30]), Ok(4_130_528));
}

#[test]
fn the_shipped_models_multiply_1500_by_25_and_25_by_26_numbers() {
    for model in shipped::linear().expect("the shipped models") {
        let graph = model.graph();
        assert_eq!(graph.macs(&[1, 1, 50, 30]), Ok(38_150));
        assert_eq!(graph.parameters, 38_150 + 25 + 26);
    }
}

#[test]
fn a_quantised_convolution_counts_as_much_as_a_plain_one() {
    let parts = [
        weights("scale", 1, &[]),
        weights("zero", 3, &[]),
        node("QuantizeLinear", "x scale zero", "xq", &[]),
        node("DequantizeLinear", "xq scale zero", "xd", &[]),
        weights("w", 3, &[4, 1, 3, 3]),
        node("DequantizeLinear", "w scale zero", "wd", &[]),
        weights("b", 6, &[4]),
        node("DequantizeLinear", "b scale", "bd", &[]),
        node("Conv", "xd wd bd", "y", &[]),
    ];
    let found = graph(&[0, 1, 50, 30], &parts);
    assert_eq!(found.macs(&[1, 1, 50, 30]), Ok(4 * 48 * 28 * 9));
    assert_eq!(found.parameters, 36 + 4 + 2); // weights, 32-bit biases, scale and zero point
}

/// Counts the multiply-accumulates of one convolution of 8 filters on `[1, 4, 50, 30]`.
fn of_convolution(depth: i64, kernel: i64, attributes: &[&str]) -> Result<u64, String> {
    let parts = [
        weights("w", 1, &[8, depth, kernel, kernel]),
        node("Conv", "x w", "y", attributes),
    ];
    graph(&[1, 4, 50, 30], &parts).macs(&[1, 4, 50, 30])
}

#[test]
fn strides_pads_dilations_groups_and_automatic_padding_shape_the_output() {
    // Rows: (50 + 1 + 1 - 3) / 2 + 1 = 25; columns: (30 + 2 - 3) / 2 + 1 = 15.
    let strided = of_convolution(4, 3, &["strides=[2,2]", "pads=[1,1,1,1]"]);
    assert_eq!(strided, Ok(8 * 25 * 15 * 4 * 9));
    // A reach of 2 x 2 + 1 = 5 leaves 46 and 26.
    assert_eq!(
        of_convolution(4, 3, &["dilations=[2,2]"]),
        Ok(8 * 46 * 26 * 4 * 9)
    );
    assert_eq!(of_convolution(1, 3, &["group=4"]), Ok(8 * 48 * 28 * 9));
    let same = of_convolution(4, 3, &["auto_pad=SAME_UPPER", "strides=[4,4]"]);
    assert_eq!(same, Ok(8 * 13 * 8 * 4 * 9));
    assert_eq!(
        of_convolution(4, 3, &["auto_pad=VALID"]),
        Ok(8 * 48 * 28 * 4 * 9)
    );
    let refused = of_convolution(2, 3, &[]).expect_err("4 channels in 1 group");
    assert_eq!(refused, "the output shape of Conv (\"y\") is not known");
}

#[test]
fn sets_of_silhouettes_are_followed_through_reductions_and_batched_products() {
    // As in GaitSet: the maximum over frames, strips, and a matrix for each strip.
    let parts = [
        node("Unsqueeze", "x one", "u", &[]),
        integers("one", &[2]),
        integers("frames", &[1]),
        node("ReduceMax", "u", "m", &["axes=[1]", "keepdims=0"]),
        integers("strips", &[0, 1, 16, -1]),
        node("Reshape", "m strips", "s", &[]),
        node("ReduceMean", "s", "mean", &["axes=[-1]", "keepdims=0"]),
        node("Transpose", "mean", "t", &["perm=[2,0,1]"]),
        weights("w", 1, &[16, 1, 256]),
        node("MatMul", "t w", "y", &[]),
        node("Transpose", "y", "z", &["perm=[1,0,2]"]),
        stated(12, "z", &[0, 16, 256]),
    ];
    let found = graph(&[0, 0, 64, 44], &parts);
    assert_eq!(found.macs(&[1, 30, 64, 44]), Ok(16 * 256));
}

#[test]
fn what_is_unknown_is_named_and_not_guessed() {
    let macs = |parts: &[Vec<u8>]| graph(&[0, 1, 50, 30], parts).macs(&[1, 1, 50, 30]);
    assert_eq!(
        macs(&[node("LSTM", "x", "y", &[])]),
        Err("LSTM (\"y\") is an unknown operator".into())
    );
    let turned = [
        weights("w", 1, &[1, 4, 3, 3]),
        node("ConvTranspose", "x w", "y", &[]),
    ];
    assert_eq!(
        macs(&turned),
        Err("ConvTranspose (\"y\") is an unknown operator".into())
    );
    let computed = [
        node("Relu", "x", "to", &[]),
        node("Reshape", "x to", "y", &[]),
    ];
    assert_eq!(
        macs(&computed),
        Err("the output shape of Reshape (\"y\") is not known".into())
    );
    // The same with an output shape that the file states.
    let product = [
        stated(13, "y", &[0, 1500]),
        weights("w", 1, &[1500, 2]),
        node("Gemm", "y w", "z", &[]),
    ];
    assert_eq!(macs(&[computed.concat(), product.concat()]), Ok(3000));
    let contradicted = [node("Flatten", "x", "y", &[]), stated(12, "y", &[0, 1499])];
    assert_eq!(
        macs(&contradicted),
        Err("\"y\" is stated as [N, 1499], but would be [1, 1500]".into())
    );
    assert_eq!(
        graph(&[0, 1, 50, 30], &[]).macs(&[1, 1, 64, 44]),
        Err("\"x\" is stated as [N, 1, 50, 30], but would be [1, 1, 64, 44]".into())
    );
}

#[test]
fn shapes_and_lists_that_double_with_each_operation_are_not_followed() {
    let doubling = |operator: &str, first: Vec<u8>| -> Graph {
        let step = |at: usize| {
            let (from, to) = (format!("v{at}"), format!("v{}", at + 1));
            node(operator, &format!("{from} {from}"), &to, &["axis=0"])
        };
        let steps: Vec<u8> = (0..60).flat_map(step).collect();
        graph(&[0, 1, 50, 30], &[first, steps])
    };
    let ranks = doubling("Gather", weights("v0", 1, &[2, 2]));
    let lists = doubling("Concat", integers("v0", &[1, 2]));
    assert_eq!(
        ranks.macs(&[1, 1, 50, 30]),
        Err("the output shape of Gather (\"v6\") is not known".into())
    );
    // A length of 2 x 2^60 is known, though the numbers are not.
    assert_eq!(lists.macs(&[1, 1, 50, 30]), Ok(0));
    assert!(ranks.windows().is_empty() && lists.windows().is_empty());
}

#[test]
fn nothing_split_into_no_parts_is_no_reason_to_panic() {
    let split = node("Split", "w", "", &["axis=0"]);
    let found = graph(&[0, 1, 50, 30], &[weights("w", 1, &[0, 4]), split]);
    assert_eq!(found.macs(&[1, 1, 50, 30]), Ok(0));
}

#[test]
fn axes_by_the_hundred_thousand_are_not_followed() {
    let axes: Vec<String> = (0..400_000).rev().map(|axis| axis.to_string()).collect();
    let axes = format!("axes=[{}]", axes.join(","));
    let found = graph(&[0, 1], &[node("Unsqueeze", "x", "y", &[&axes])]);
    assert_eq!(
        found.macs(&[1, 1]),
        Err("the output shape of Unsqueeze (\"y\") is not known".into())
    );
}

#[test]
fn parts_that_are_split_joined_padded_cut_and_repeated_are_followed() {
    let parts = [
        node("Split", "x", "a b", &["axis=1"]),
        node("Concat", "b a x", "joined", &["axis=1"]), // 2 + 2 + 4 channels
        integers("margins", &[0, 0, 1, 0, 0, 0, 1, 2]),
        node("Pad", "joined margins", "padded", &[]), // 52 rows, 32 columns
        integers("one", &[1]),
        integers("last", &[-1]),
        integers("columns", &[3]),
        node("Slice", "padded one last columns", "cut", &[]), // columns 1 to 30
        integers("thrice", &[3, 1, 1, 1]),
        node("Expand", "cut thrice", "wide", &[]),
        node("Flatten", "wide", "flat", &[]),
        weights("w", 1, &[8 * 52 * 30, 2]),
        node("Gemm", "flat w", "y", &[]),
    ];
    let found = graph(&[1, 4, 50, 30], &parts);
    assert_eq!(found.macs(&[1, 4, 50, 30]), Ok(3 * 2 * 8 * 52 * 30));
}
