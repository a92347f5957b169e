#!/usr/bin/env python3
"""Networks of a few hundred bytes whose answer is known in closed form, for the tests of the feature `onnx`.

    python3 -m venv venv && venv/bin/pip install onnx==1.23.2 && venv/bin/python make.py

threshold   probability sigmoid(8 (v - 0.5)) of a pixel with the normalised grey value v
logit       the same as log-odds, with its errors and multiple = 32 in the metadata
lopsided    threshold by the mean of a pixel and its right neighbour: differs from its mirror image
bare        threshold without metadata
unet        the operators of a small U-Net, random weights; unet.csv has what ONNX's own reference evaluator gives for
            the input v(row, column) = sin(0.3 row) cos(0.2 column) of 32 x 48 pixels
The others are wrong each in the one way that its name says.
"""

from pathlib import Path

import numpy
from onnx import TensorProto, checker, helper, numpy_helper
from onnx.reference import ReferenceEvaluator

HERE = Path(__file__).parent
FREE = [1, 1, "rows", "columns"]
ERRORS = {"vb_error_um": "5", "vb_max_error_um": "12"}


def constant(name, values, shape):
    return numpy_helper.from_array(numpy.array(values, dtype=numpy.float32).reshape(shape), name)


def convolved(weights, bias, sigmoid):
    """A convolution of a row of weights, whose size stays, and a sigmoid."""
    width = len(weights)
    nodes = [
        helper.make_node("Conv", ["strip", "w", "b"], ["odds"], kernel_shape=[1, width],
                         pads=[0, (width - 1) // 2, 0, (width - 1) // 2]),
        helper.make_node("Sigmoid" if sigmoid else "Identity", ["odds"], ["land"]),
    ]
    return nodes, [constant("w", weights, [1, 1, 1, width]), constant("b", [bias], [1])]


def write(name, nodes, constants, metadata, inputs=None, outputs=None):
    value = helper.make_tensor_value_info
    inputs = inputs or [value("strip", TensorProto.FLOAT, FREE)]
    outputs = outputs or [value("land", TensorProto.FLOAT, FREE)]
    graph = helper.make_graph(nodes, "land", inputs, outputs, constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    helper.set_model_props(model, metadata)
    checker.check_model(model)
    (HERE / f"{name}.onnx").write_bytes(model.SerializeToString(deterministic=True))


def unet():
    """One halving, back by a transposed convolution and by resizing, a skip, a batch normalisation."""
    draw = numpy.random.default_rng(20)
    sizes = {"w1": [4, 1, 3, 3], "b1": [4], "w2": [8, 4, 3, 3], "b2": [8], "w3": [8, 4, 2, 2], "b3": [4],
             "w4": [1, 16, 1, 1], "b4": [1], "gain": [4], "shift": [4], "middle": [4]}
    constants = [constant(k, draw.normal(0.0, 0.8, shape).round(3), shape) for k, shape in sizes.items()]
    constants += [constant("spread", draw.uniform(0.5, 2.0, 4).round(3), [4]), constant("twice", [1, 1, 2, 2], [4])]
    around = {"kernel_shape": [3, 3], "pads": [1, 1, 1, 1]}
    nodes = [
        helper.make_node("Conv", ["strip", "w1", "b1"], ["c1"], **around),
        helper.make_node("BatchNormalization", ["c1", "gain", "shift", "middle", "spread"], ["n1"], epsilon=1e-5),
        helper.make_node("Relu", ["n1"], ["r1"]),
        helper.make_node("MaxPool", ["r1"], ["p1"], kernel_shape=[2, 2], strides=[2, 2]),
        helper.make_node("Conv", ["p1", "w2", "b2"], ["c2"], **around),
        helper.make_node("LeakyRelu", ["c2"], ["r2"], alpha=0.1),
        helper.make_node("ConvTranspose", ["r2", "w3", "b3"], ["u2"], kernel_shape=[2, 2], strides=[2, 2]),
        helper.make_node("Resize", ["r2", "", "twice"], ["z2"], mode="nearest",
                         coordinate_transformation_mode="asymmetric", nearest_mode="floor"),
        helper.make_node("Concat", ["r1", "u2", "z2"], ["all"], axis=1),
        helper.make_node("Conv", ["all", "w4", "b4"], ["odds"], kernel_shape=[1, 1]),
        helper.make_node("Sigmoid", ["odds"], ["land"]),
    ]
    write("unet", nodes, constants, ERRORS | {"multiple": "2"})
    row, column = numpy.mgrid[0:32, 0:48]
    strip = (numpy.sin(0.3 * row) * numpy.cos(0.2 * column)).astype(numpy.float32)[None, None]
    land = ReferenceEvaluator(str(HERE / "unet.onnx")).run(None, {"strip": strip})[0]
    lines = [f"{r},{c},{land[0, 0, r, c]:.6f}" for r, c in [(0, 0), (0, 47), (31, 0), (31, 47), (15, 16), (16, 15),
             (7, 31), (8, 32), (20, 5), (21, 6), (30, 40), (1, 24)]]
    (HERE / "unet.csv").write_text("row,column,probability\n" + "\n".join(lines) + "\n")


def main():
    unet()
    value, float32 = helper.make_tensor_value_info, TensorProto.FLOAT
    threshold = convolved([8.0], -4.0, True)
    log_odds = convolved([8.0], -4.0, False)
    write("threshold", *threshold, ERRORS)
    write("bare", *threshold, {})
    write("logit", *log_odds, ERRORS | {"output": "logit", "multiple": "32"})
    write("lopsided", *convolved([0.0, 4.0, 4.0], -4.0, True), ERRORS)

    write("log_odds_unstated", *log_odds, ERRORS)
    write("one_error", *threshold, {"vb_error_um": "5"})
    write("multiple_0", *threshold, ERRORS | {"multiple": "0"})
    write("fixed_size", *threshold, ERRORS, [value("strip", float32, [1, 1, 256, 256])])
    write("three_channels", [helper.make_node("ReduceMean", ["strip"], ["land"], axes=[1])], [], ERRORS,
          [value("strip", float32, [1, 3, "rows", "columns"])])
    flat = ["rows", "columns"]
    write("rank_2", [helper.make_node("Sigmoid", ["strip"], ["land"])], [], ERRORS,
          [value("strip", float32, flat)], [value("land", float32, flat)])
    write("two_inputs", [helper.make_node("Mul", ["strip", "other"], ["land"])], [], ERRORS,
          [value("strip", float32, FREE), value("other", float32, FREE)])
    write("two_outputs", threshold[0], threshold[1], ERRORS, None,
          [value("land", float32, FREE), value("odds", float32, FREE)])
    write("half_size", [helper.make_node("AveragePool", ["strip"], ["land"], kernel_shape=[2, 2], strides=[2, 2])],
          [], ERRORS, None, [value("land", float32, [1, 1, "r", "c"])])
    write("not_a_number", [helper.make_node("Div", ["strip", "strip"], ["land"])], [], ERRORS)


if __name__ == "__main__":
    main()
