//! What the paper would measure on a machine: four curves, a table of sums; and the working space
//! as it is.
//!
//! Column A(z): e_X at the part's radius, by a turned cylinder. B(x): EBX·tz, a laser's yaw times
//! the lever. Face C(x): e_Z at the end of Z, by a turned face with a laser. D(z): EBZ by a laser
//! times one lever (the paper's β(z)·TX), at the middle of X. The sums A + B and C + D over the
//! raster are the paper's table; the working space itself holds EBZ·x, which is in no sum.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::asked::ModelsAsked;
use crate::machine::{ErrorName, ErrorValues, Station, first_order};
use crate::studies::machine::map;
use crate::studies::machine::prepared::Prepared;

/// Stream of the samples' noise.
const STREAM: u64 = 0x7061_7065_725f_3031;
/// Lever by which an angle is read from a displacement, mm: two targets of a laser this far apart
/// turn the noise of a length into that of an angle.
pub(super) const BASE_MM: f64 = 100.0;

/// Samples at even positions, and the machine behind them.
pub(super) struct PaperSamples<'a> {
    machine: &'a Prepared,
    /// Positions of X, mm; of the tool's side.
    pub x_mm: Vec<f64>,
    /// Positions of Z, mm.
    pub z_mm: Vec<f64>,
    radius_mm: f64,
    noise_um: f64,
    seed: u64,
}

/// A curve of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Curve {
    A,
    B,
    C,
    D,
}

impl Curve {
    pub(super) const ALL: [Self; 4] = [Self::A, Self::B, Self::C, Self::D];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::A => "A: column, e_X over z",
            Self::B => "B: EBX by its lever, over x",
            Self::C => "C: face, e_Z over x",
            Self::D => "D: EBZ by one lever, over z",
        }
    }
}

impl<'a> PaperSamples<'a> {
    pub(super) fn of(machine: &'a Prepared, radius_mm: f64, asked: &ModelsAsked) -> Self {
        let [x_from, x_to] = machine.settings.x_travel_mm;
        let [z_from, z_to] = machine.settings.z_travel_mm;
        let even = |from: f64, to: f64| {
            let step = (to - from) / (asked.positions - 1) as f64;
            (0..asked.positions).map(|k| (from + step * k as f64).min(to)).collect::<Vec<f64>>()
        };
        Self {
            machine,
            x_mm: even(x_from.max(0.0), x_to),
            z_mm: even(z_from, z_to),
            radius_mm,
            noise_um: asked.noise_um,
            seed: asked.seed,
        }
    }

    /// Places between the samples, mm.
    pub(super) fn between(positions: &[f64]) -> Vec<f64> {
        positions.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect()
    }

    /// Positions of a curve, mm.
    pub(super) fn positions(&self, curve: Curve) -> &[f64] {
        match curve {
            Curve::A | Curve::D => &self.z_mm,
            Curve::B | Curve::C => &self.x_mm,
        }
    }

    fn middle_x_mm(&self) -> f64 {
        0.5 * (self.x_mm[0] + self.x_mm[self.x_mm.len() - 1])
    }

    /// A curve without noise, µm.
    pub(super) fn value_um(&self, curve: Curve, position_mm: f64) -> f64 {
        let end_z = self.z_mm[self.z_mm.len() - 1];
        match curve {
            Curve::A => map::point(self.machine, self.radius_mm, position_mm).e_x_um,
            Curve::C => map::point(self.machine, position_mm, end_z).e_z_um,
            Curve::B => self.alone_um(ErrorName::Ebx, position_mm, self.z_mm[0], 0),
            Curve::D => {
                let own = |z: f64| self.alone_um(ErrorName::Ebz, self.middle_x_mm(), z, 2);
                own(position_mm) - own(end_z)
            }
        }
    }

    /// What one error does on its own, to first order, along a direction, µm.
    fn alone_um(&self, name: ErrorName, x_mm: f64, z_mm: f64, direction: usize) -> f64 {
        let station: Station = self.machine.settings.tool(x_mm, z_mm);
        let value = self.machine.motion.value(name, [x_mm, z_mm], &self.machine.state);
        let by = first_order::contribution(self.machine.settings.chain, &station, name).shift_mm;
        1e3 * value * by[direction]
    }

    /// A curve as it is read, µm.
    pub(super) fn read_um(&self, curve: Curve) -> Vec<f64> {
        let mut random = self.random(curve as u64);
        let mut noisy = |p: &f64| self.value_um(curve, *p) + self.noise_um * draw(&mut random);
        self.positions(curve).iter().map(&mut noisy).collect()
    }

    /// Both components at a position, µm.
    pub(super) fn field_um(&self, x_mm: f64, z_mm: f64) -> [f64; 2] {
        let point = map::point(self.machine, x_mm, z_mm);
        [point.e_x_um, point.e_z_um]
    }

    /// Both components over the raster as they would be read, z running fastest, µm.
    pub(super) fn read_field_um(&self) -> Vec<[f64; 2]> {
        let mut random = self.random(11);
        let mut all = Vec::with_capacity(self.x_mm.len() * self.z_mm.len());
        for x in &self.x_mm {
            for z in &self.z_mm {
                let [e_x, e_z] = self.field_um(*x, *z);
                all.push([e_x, e_z].map(|value| value + self.noise_um * draw(&mut random)));
            }
        }
        all
    }

    /// Every error as an instrument of its own would read it over its slide, mm and rad; those that
    /// do not change over a slide at each position.
    pub(super) fn read_error(&self, name: ErrorName) -> Vec<f64> {
        let mut random = self.random(100 + name as u64);
        let u = if name.is_length() { 1e-3 * self.noise_um } else { 1e-3 * self.noise_um / BASE_MM };
        let (x, z) = (&self.x_mm, &self.z_mm);
        let at = |k: usize| self.machine.motion.value(name, [x[k], z[k]], &self.machine.state);
        (0..x.len()).map(|k| at(k) + u * draw(&mut random)).collect()
    }

    /// Both components to first order by values of the errors, µm.
    pub(super) fn first_order_um(&self, x_mm: f64, z_mm: f64, values: &ErrorValues) -> [f64; 2] {
        let station = self.machine.settings.tool(x_mm, z_mm);
        let shift = first_order::pose(self.machine.settings.chain, &station, values).shift_mm;
        [1e3 * shift.x, 1e3 * shift.z]
    }

    fn random(&self, stream: u64) -> Pcg64 {
        Pcg64::seed_from_u64(self.seed ^ STREAM ^ (stream << 40))
    }
}

fn draw(random: &mut Pcg64) -> f64 {
    StandardNormal.sample(random)
}
