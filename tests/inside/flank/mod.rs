//! Flank wear: the renderer's truth, the measurement against it, refusals, and real flanks
//! (`SHADOWGAUGE_FLANKS`).

#[cfg(feature = "onnx")]
mod by_network;
mod by_paper;
mod drawn;
mod edges;
mod feature;
mod found;
mod parts;
mod real;
mod refused;
mod studied;
mod trained;
