//! Studies over the stages: single factors, deflection, choice of cutting data, reproductions of papers.

pub mod deflection;
pub mod optimize;
pub mod stability;
