//! What of a machine is compensated, as identified and as it is.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::identification::head_geometry::of_identified;
use crate::identification::{Identification, IdentificationConfig};
use crate::machine::conditions::{Conditions, Direction};
use crate::machine::{Axis, Chain, ErrorName, MachineSettings, Motion, Station, first_order};
use crate::setting::SettingError;

/// Places of a figure along a slide.
const PLACES: usize = 9;

/// A compensated value against the truth, µm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Off {
    /// Which figure.
    pub figure: Cow<'static, str>,
    /// As compensated less as it is.
    pub off_um: f64,
    /// Its standard uncertainty.
    pub u_um: f64,
    /// As it is.
    pub uncompensated_um: f64,
}

/// The figures that the errors which are sought act on: the diameter along a cylinder and the face
/// along X, both against the place where the tool is set, and where the head stands.
///
/// # Errors
/// As [`of_identified`].
pub(super) fn compensated(
    config: &IdentificationConfig,
    found: &Identification,
    truth: &MachineSettings,
) -> Result<Vec<Off>, SettingError> {
    let of = Machine { config, found, truth, motion: truth.motion()? };
    let has = |axis: Axis| found.chosen.errors.iter().any(|name| name.axis() == axis);
    let mut all = Vec::new();
    if has(Axis::Z) {
        all.extend(of.diameters());
    }
    if has(Axis::X) {
        all.extend(of.face());
    }
    all.extend(of.head()?);
    Ok(all)
}

/// A figure of the tool: its scale by the tool's error along a direction (0, 2: X, Z).
struct Figure {
    name: &'static str,
    scale: f64,
    along: usize,
}

struct Machine<'a> {
    config: &'a IdentificationConfig,
    found: &'a Identification,
    truth: &'a MachineSettings,
    motion: Motion,
}

impl Machine<'_> {
    /// Where the exact chain of the truth puts what stands at a station, mm.
    fn true_shift(&self, station: &Station) -> [f64; 3] {
        let state = Conditions { temperature_c: self.config.temperature_c, ..Conditions::default() };
        let values = self.motion.values(station.x_mm, station.z_mm, &state);
        Chain { topology: self.truth.chain, values }.pose(station).shift_mm.into()
    }

    /// The tool's error at a place less that where the tool was set.
    fn tool(&self, figure: &Figure, set: [f64; 2], at: [f64; 2]) -> Off {
        let Figure { name, scale, along } = *figure;
        let machine = &self.found.file.machine;
        let own = self.found.chosen.tool_between(machine, [set, at], along, Direction::Forward);
        let true_at = |[x, z]: [f64; 2]| self.true_shift(&self.truth.tool(x, z))[along];
        let truth = true_at(at) - true_at(set);
        Off {
            figure: name.into(),
            off_um: 1e3 * scale * (own.value - truth),
            u_um: 1e3 * scale * own.u,
            uncompensated_um: 1e3 * scale * truth,
        }
    }

    fn diameters(&self) -> Vec<Off> {
        let [from, to] = self.found.file.machine.x_travel_mm;
        let stated = self.config.readings.iter().find_map(|set| set.radius_mm);
        let radius = stated.unwrap_or(0.5 * (from.max(0.0) + to));
        let range = self.found.file.machine.z_travel_mm;
        let set = [radius, middle(range)];
        let name = "diameter along a cylinder, to where the tool was set";
        let figure = Figure { name, scale: 2.0, along: 0 };
        places(range).map(|z| self.tool(&figure, set, [radius, z])).collect()
    }

    fn face(&self) -> Vec<Off> {
        let stated = self.config.readings.iter().find_map(|set| set.face_z_mm);
        let z = stated.unwrap_or(middle(self.found.file.machine.z_travel_mm));
        let range = self.found.file.machine.x_travel_mm;
        let set = [middle(range), z];
        let figure = Figure { name: "face along X, to where the tool was set", scale: 1.0, along: 2 };
        places(range).map(|x| self.tool(&figure, set, [x, z])).collect()
    }

    /// The head along Y; nothing where no error that is sought moves it there.
    fn head(&self) -> Result<Vec<Off>, SettingError> {
        let machine = &self.found.file.machine;
        let station = machine.head(middle(machine.z_travel_mm));
        let moves =
            |name: &ErrorName| first_order::contribution(machine.chain, &station, *name).shift_mm.y != 0.0;
        if !self.found.chosen.errors.iter().any(moves) {
            return Ok(Vec::new());
        }
        let geometry = of_identified(&self.found.file)?;
        let at = |z: f64| {
            let station = self.truth.head(z);
            let place = geometry.at(station.point_mm.z)?;
            let truth = -self.true_shift(&station)[1];
            Some(Off {
                figure: "head along Y".into(),
                off_um: 1e3 * (place.axis_y_mm - truth),
                u_um: 1e3 * place.u_axis_y_mm,
                uncompensated_um: 1e3 * truth,
            })
        };
        Ok(places(machine.z_travel_mm).filter_map(at).collect())
    }
}

fn middle([from, to]: [f64; 2]) -> f64 {
    0.5 * (from + to)
}

/// Places within a range, none of them its middle.
fn places([from, to]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..PLACES).map(move |k| from + (to - from) * (k as f64 + 0.3) / PLACES as f64)
}
