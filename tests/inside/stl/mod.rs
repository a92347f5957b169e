//! Models of turned parts: what is read of good ones, and how bad ones are refused.

mod accuracy;
mod body;
mod faults;
mod hostile;
#[path = "../../../fuzz/model.rs"]
mod model;
mod program;
