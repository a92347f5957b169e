//! Readings of a simulated machine: what a laser, a probe, a head would read of it, as the CSV text
//! that `calibrate machine` takes of a user.
//!
//! Drawn by the exact chain with the truth of a machine, with its noise, a straightedge that is not
//! straight, a part that sags and turns askew and a tailstock that stands off the axis. The
//! identification gets the text alone.

use nalgebra::{Rotation3, Vector3};
use rand::SeedableRng as _;
use rand_distr::{Distribution as _, StandardNormal};
use rand_pcg::Pcg64;

use crate::identification::instrument::{Instrument, Quantity};
use crate::identification::reading_set::{ReadWhere, ReadingPlan, ReadingSet};
use crate::machine::conditions::Direction;
use crate::machine::error_name::Component;
use crate::machine::response::{Part, Side, cut_mm, probe_mm};
use crate::machine::{Chain, Conditions, MachineSettings, Motion, Pose, Station};
use crate::setting::SettingError;

/// Bow of the simulated straightedge, mm.
const STRAIGHTEDGE_MM: f64 = 2e-3;
/// Eccentricity of the part whose midline is read, mm: it turns, and the means are free of it.
const ECCENTRICITY_MM: f64 = 5e-3;

/// A machine with its truth, in a state.
#[derive(Clone, Debug)]
pub(crate) struct SimulatedMachine {
    settings: MachineSettings,
    motion: Motion,
    state: Conditions,
    seed: u64,
}

/// What a set's readings have besides the machine's errors, drawn once.
struct Drawn {
    sag: f64,
    tailstock_mm: f64,
}

impl SimulatedMachine {
    /// A machine by its settings, at a temperature.
    ///
    /// # Errors
    /// The first value that cannot be right.
    pub(crate) fn new(
        settings: MachineSettings,
        temperature_c: f64,
        seed: u64,
    ) -> Result<Self, SettingError> {
        let motion = settings.motion()?;
        let state = Conditions { temperature_c, ..Conditions::default() };
        Ok(Self { settings, motion, state, seed })
    }

    /// The text of the file of the set `k`; empty where it has no plan.
    ///
    /// # Errors
    /// A quantity that is none.
    pub(crate) fn text(&self, set: &ReadingSet, k: usize) -> Result<String, SettingError> {
        let Some(plan) = &set.plan else { return Ok(String::new()) };
        let mut random = Pcg64::seed_from_u64(self.seed.wrapping_add(k as u64));
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let part = set.part;
        let drawn = Drawn {
            sag: 1.0 + part.map_or(0.0, |part| part.sag_u_relative * draw()),
            tailstock_mm: part.map_or(0.0, |part| 1e-3 * part.tailstock_u_um * draw()),
        };
        let mut text = "axis,position_mm,direction,run,error,value,unit,angle_deg,setup\n".to_owned();
        for (i, word) in plan.quantities.iter().enumerate() {
            let right = "an error as \"ezz\", or radius, height, midline, slope";
            let quantity = Quantity::parse(word).ok_or_else(|| {
                SettingError::of(format!("readings[{k}].plan.quantities[{i}]"), word, right)
            })?;
            for (run, direction) in runs(plan) {
                for [setup, angle] in variants(set.instrument, quantity) {
                    let variant = Variant { set, quantity, direction, setup, angle };
                    let u = if quantity.is_length() { set.u_um } else { set.u_urad }.unwrap_or(0.0);
                    for p in places(plan, direction) {
                        let scale = if quantity.is_length() { 1e3 } else { 1e6 };
                        let value = scale * self.value(&variant, p, &drawn) + u * draw();
                        text += &variant.row(p, run, value);
                    }
                }
            }
        }
        Ok(text)
    }

    fn value(&self, of: &Variant<'_>, p: f64, drawn: &Drawn) -> f64 {
        match of.quantity {
            Quantity::Error(_) => self.direct(of, p),
            Quantity::Radius => self.radius(of, p),
            Quantity::Height => self.height(of, p),
            Quantity::Midline | Quantity::Slope => self.midline(of, p, drawn),
        }
    }

    fn pose(&self, station: &Station, direction: Direction) -> Pose {
        let state = Conditions { x_direction: direction, z_direction: direction, ..self.state };
        let values = self.motion.values(station.x_mm, station.z_mm, &state);
        Chain { topology: self.settings.chain, values }.pose(station)
    }

    /// A slide's own shift at a lever, or its turn.
    fn direct(&self, of: &Variant<'_>, p: f64) -> f64 {
        let Quantity::Error(name) = of.quantity else { return 0.0 };
        let state = Conditions { x_direction: of.direction, z_direction: of.direction, ..self.state };
        let values = self.motion.values(p, p, &state);
        let lever = Vector3::from(of.set.line_mm.unwrap_or_default());
        let [a, b, c] = values.about(name.axis());
        let turn = Rotation3::from_euler_angles(a, b, c);
        let shift = Vector3::from(values.along(name.axis())) + turn * lever - lever;
        match name.component() {
            Component::Along(k) if of.set.instrument == Instrument::Straightedge => {
                let middle = of.set.plan.as_ref().map_or(0.0, |plan| 0.5 * (plan.from_mm + plan.to_mm));
                let bow = STRAIGHTEDGE_MM * (0.02 * (p - middle)).cos();
                if of.setup == "reversed" { bow - shift[k] } else { bow + shift[k] }
            }
            Component::Along(k) => shift[k],
            _ => values.of(name),
        }
    }

    fn radius(&self, of: &Variant<'_>, z_mm: f64) -> f64 {
        let radius_mm = of.set.radius_mm.unwrap_or(1.0);
        let part = Part { diameter_mm: 2.0 * radius_mm, taper: 0.0 };
        let tool = self.pose(&self.settings.tool(radius_mm, z_mm), of.direction);
        let cut = cut_mm(&part, self.settings.tip_above_axis_mm, &tool);
        let own = match of.set.read.unwrap_or_default() {
            ReadWhere::Elsewhere => 0.0,
            ReadWhere::SameSide => probe_mm(&part, 0.0, Side::Tool, &tool),
            ReadWhere::OppositeSide => {
                let pose = self.pose(&self.settings.tool(-radius_mm, z_mm), of.direction);
                probe_mm(&part, 0.0, Side::Opposite, &pose)
            }
        };
        0.5 * (cut + own)
    }

    fn height(&self, of: &Variant<'_>, x_mm: f64) -> f64 {
        let z_mm = of.set.face_z_mm.unwrap_or(0.0);
        let at = |x: f64| self.pose(&self.settings.tool(x, z_mm), of.direction).shift_mm.z;
        match of.set.read.unwrap_or_default() {
            ReadWhere::Elsewhere => at(x_mm),
            ReadWhere::SameSide => 0.0,
            ReadWhere::OppositeSide => at(x_mm) - at(-x_mm),
        }
    }

    fn midline(&self, of: &Variant<'_>, z_mm: f64, drawn: &Drawn) -> f64 {
        let station = self.settings.head(z_mm - self.settings.head_beside_tool_mm());
        let pose = self.pose(&station, of.direction);
        let still = |z: f64| {
            let Some(part) = of.set.part else { return 0.0 };
            drawn.sag * part.gravity_x * part.sag_mm(z)
                + drawn.tailstock_mm * part.tailstock(z).unwrap_or(0.0)
        };
        if of.quantity == Quantity::Slope {
            return -pose.turn_rad.y + (still(z_mm + 0.01) - still(z_mm - 0.01)) / 0.02;
        }
        let angle: f64 = of.angle.parse().unwrap_or(0.0);
        -pose.shift_mm.x + still(z_mm) + ECCENTRICITY_MM * (1.0 + 0.01 * z_mm) * angle.to_radians().cos()
    }
}

/// One way in which a quantity is read.
struct Variant<'a> {
    set: &'a ReadingSet,
    quantity: Quantity,
    direction: Direction,
    setup: &'static str,
    angle: &'static str,
}

impl Variant<'_> {
    fn row(&self, p: f64, run: u32, value: f64) -> String {
        let axis = if self.quantity.axis() == crate::machine::Axis::X { "X" } else { "Z" };
        let direction = if self.direction == Direction::Forward { "forward" } else { "backward" };
        let unit = if self.quantity.is_length() { "um" } else { "urad" };
        let (word, setup, angle) = (self.quantity.word(), self.setup, self.angle);
        format!("{axis},{p},{direction},{run},{word},{value:.9},{unit},{angle},{setup}\n")
    }
}

/// Runs of a plan with their directions.
fn runs(plan: &ReadingPlan) -> Vec<(u32, Direction)> {
    let both = [Direction::Forward, Direction::Backward];
    let directions = if plan.both_directions { &both[..] } else { &both[..1] };
    (1..=plan.runs).flat_map(|run| directions.iter().map(move |direction| (run, *direction))).collect()
}

/// Set-ups of an artefact and angles of the spindle.
fn variants(instrument: Instrument, quantity: Quantity) -> Vec<[&'static str; 2]> {
    match (instrument, quantity) {
        (Instrument::Straightedge, _) => vec![["normal", ""], ["reversed", ""]],
        (_, Quantity::Midline) => vec![["", "0"], ["", "180"]],
        _ => vec![["", ""]],
    }
}

fn places(plan: &ReadingPlan, direction: Direction) -> Vec<f64> {
    let step = (plan.to_mm - plan.from_mm) / (plan.positions - 1) as f64;
    let mut places: Vec<f64> = (0..plan.positions).map(|k| plan.from_mm + step * k as f64).collect();
    if direction == Direction::Backward {
        places.reverse();
    }
    places
}
