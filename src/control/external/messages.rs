//! The lines to a program.

use serde::Serialize;

use super::facts::PartFacts;
use crate::control::context::{NextPass, Origin, PartEvent};
use crate::control::settings::{ControlSettings, GapSettings, GuardSettings, ModelSettings};
use crate::plan::CuttingData;
use crate::profile::Station;

/// Name of the protocol, in every `begin`.
pub(crate) const PROTOCOL: &str = "shadowgauge-controller";

/// Version of the protocol, in every `begin`: raised where a program of before would decide
/// wrongly, not for a key that it may ignore.
pub(crate) const PROTOCOL_VERSION: u32 = 1;

/// Version of the protocol for a stepped shaft: a program that takes `nominal_mm` for the diameter
/// of every station would decide wrongly.
pub(crate) const STEPPED_VERSION: u32 = 2;

/// A line to a program.
#[derive(Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(super) enum Message<'a> {
    /// A new part.
    Begin(Begin<'a>),
    /// A pass was cut and measured: asks for a reply.
    Pass(Pass<'a>),
    /// No further line follows.
    End,
}

/// A new part: state of an earlier one is void.
#[derive(Serialize)]
pub(super) struct Begin<'a> {
    protocol: &'static str,
    version: u32,
    #[serde(flatten)]
    facts: &'a PartFacts,
    event: PartEvent,
    /// Readings of the stock, where it was scanned.
    stock: Option<&'a [Station]>,
    plant_gain: f64,
    gaps: &'a GapSettings,
    guards: &'a GuardSettings,
    /// What the model-based controller assumes of part, force and machine.
    model: &'a ModelSettings,
}

impl<'a> Begin<'a> {
    pub(super) fn new(
        facts: &'a PartFacts,
        settings: &'a ControlSettings,
        event: PartEvent,
        stock: Option<&'a [Station]>,
    ) -> Self {
        Self {
            protocol: PROTOCOL,
            version: if facts.station_relative_mm.is_empty() { PROTOCOL_VERSION } else { STEPPED_VERSION },
            facts,
            event,
            stock,
            plant_gain: settings.plant_gain,
            gaps: &settings.gaps,
            guards: &settings.guards,
            model: &settings.model,
        }
    }
}

/// A pass that was cut and measured.
#[derive(Serialize)]
pub(super) struct Pass<'a> {
    /// From 1.
    pub(super) pass: u32,
    pub(super) nominal_mm: f64,
    pub(super) cutting: CuttingData,
    /// Offsets with which the pass was cut, mm of diameter.
    pub(super) offsets_mm: &'a [f64],
    pub(super) stations: &'a [Station],
    pub(super) origin: Option<&'a Origin>,
    /// Why the reply to the pass before was not put in force; none where it was.
    pub(super) held: Option<&'a str>,
    /// The pass that the reply is for; none after the last one.
    pub(super) next: Option<NextPass>,
}
