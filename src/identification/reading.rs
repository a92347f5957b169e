//! Readings of a machine, checked.

use crate::machine::conditions::Direction;

use super::instrument::Quantity;

/// How an artefact stood.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Setup {
    /// As it lies.
    #[default]
    Normal,
    /// Turned over, with the probe on its other side.
    Reversed,
}

/// A reading: mm or rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading {
    /// What it is of.
    pub quantity: Quantity,
    /// Position: of the slide; of a midline the place on the part, mm.
    pub position_mm: f64,
    /// From which side the position was reached.
    pub direction: Direction,
    /// Run, from 1.
    pub run: u32,
    /// How the artefact stood.
    pub setup: Setup,
    /// Value, mm or rad.
    pub value: f64,
    /// Of how many rows it is the mean.
    pub rows: u32,
    /// Line in the file.
    pub line: u64,
}

/// A row before midlines are averaged.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// The reading.
    pub reading: Reading,
    /// Spindle angle, degrees, where the file has one.
    pub angle_deg: Option<f64>,
}
