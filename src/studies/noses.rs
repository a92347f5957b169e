//! Noses of rendered inserts, measured: errors beside their stated uncertainties, by kind of wear.

use rand::{RngExt as _, SeedableRng as _};
use serde::Serialize;

use crate::frame::Frame;
use crate::gauge::nose::{NoseMeasurement, NoseSettings, SupportValue, measure_nose};
use crate::render::RenderError;
use crate::render::insert::{InsertBlur, InsertSettings, Truth, Wear, render_insert_through};

/// 97.5 % of the normal distribution, for intervals of 95 %.
const K95: f64 = 1.96;

/// The kinds of wear, and how far each goes: depths of tenths of the limit of a worn nose, over
/// parts of it.
const KINDS: [&str; 5] = ["new", "round", "flat", "dent", "chip"];

/// What one kind of wear gave.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct NoseRow {
    /// Kind of wear; `all` of them.
    pub wear: &'static str,
    /// Noses measured.
    pub noses: usize,
    /// Noses refused.
    pub refused: usize,
    /// Largest error of the included angle, degrees, and rms of error over u.
    pub angle: Errors,
    /// As `angle` of the centre, px; u is that of its worst axis.
    pub centre: Errors,
    /// As `angle` of the mean radius, px.
    pub mean_radius: Errors,
    /// Errors of the radii of 1°, px.
    pub sectors: Covered,
    /// Errors of the support about the measured centre, px.
    pub support: Covered,
    /// Error of e(a) between two touches as far apart as the nose allows, rms and largest, µm.
    pub e_um: [f64; 2],
}

/// Largest error, and rms of error over stated u.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Errors {
    /// Largest error.
    pub largest: f64,
    /// √(mean of (error/u)²).
    pub over_u: f64,
}

/// Root mean square of errors, and the share of them within 95 %.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Covered {
    /// Root mean square, px.
    pub rms_px: f64,
    /// Share within 1.96 u.
    pub within: f64,
}

/// Sums of one kind.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    noses: usize,
    refused: usize,
    /// Largest and sum of squares over u: angle, centre, mean radius.
    errors: [(f64, f64); 3],
    /// Sum of squares, number within, number: sectors, support.
    covered: [(f64, usize, usize); 2],
    /// Sum of squares, largest, number, µm.
    e_um: (f64, f64, usize),
}

impl Sums {
    fn error(&mut self, k: usize, error: f64, over_u: f64) {
        self.errors[k].0 = self.errors[k].0.max(error.abs());
        self.errors[k].1 += over_u * over_u;
    }

    fn covered(&mut self, k: usize, error: f64, u: f64) {
        let of = &mut self.covered[k];
        *of = (of.0 + error * error, of.1 + usize::from(error.abs() <= K95 * u), of.2 + 1);
    }

    fn e(&mut self, error_um: f64) {
        let of = self.e_um;
        self.e_um = (of.0 + error_um * error_um, of.1.max(error_um.abs()), of.2 + 1);
    }

    fn and(mut self, other: &Self) -> Self {
        self.noses += other.noses;
        self.refused += other.refused;
        for (a, b) in self.errors.iter_mut().zip(other.errors) {
            *a = (a.0.max(b.0), a.1 + b.1);
        }
        for (a, b) in self.covered.iter_mut().zip(other.covered) {
            *a = (a.0 + b.0, a.1 + b.1, a.2 + b.2);
        }
        let (a, b) = (self.e_um, other.e_um);
        self.e_um = (a.0 + b.0, a.1.max(b.1), a.2 + b.2);
        self
    }

    fn row(&self, wear: &'static str) -> NoseRow {
        let errors = |k: usize| Errors {
            largest: self.errors[k].0,
            over_u: (self.errors[k].1 / self.noses.max(1) as f64).sqrt(),
        };
        let covered = |k: usize| {
            let (squares, within, n) = self.covered[k];
            let n = n.max(1) as f64;
            Covered { rms_px: (squares / n).sqrt(), within: within as f64 / n }
        };
        NoseRow {
            wear,
            noses: self.noses,
            refused: self.refused,
            angle: errors(0),
            centre: errors(1),
            mean_radius: errors(2),
            sectors: covered(0),
            support: covered(1),
            e_um: [(self.e_um.0 / self.e_um.2.max(1) as f64).sqrt(), self.e_um.1],
        }
    }
}

/// Renders and measures `count` noses in any direction and place of the field, of every kind of
/// wear in turn, and compares them with the truth. `step` is given the frame and the truth of each.
///
/// # Errors
/// Settings that the renderer refuses.
pub(crate) fn run(
    settings: &InsertSettings,
    count: usize,
    seed: u64,
    step: &mut dyn FnMut(&Frame, &Truth),
) -> Result<Vec<NoseRow>, RenderError> {
    let blur = InsertBlur::new(settings)?;
    let mut random = rand_pcg::Pcg64::seed_from_u64(seed);
    let mut sums = [Sums::default(); KINDS.len()];
    for k in 0..count {
        let posed = posed(settings, k % KINDS.len(), &mut || random.random());
        let (frame, truth) = render_insert_through(&posed, &blur, (seed, k as u64), true)?;
        let known = NoseSettings {
            nominal_radius_px: Some(truth.nominal_radius_px),
            um_per_px: posed.camera.um_per_px,
            expected: None,
        };
        let sums = &mut sums[k % KINDS.len()];
        match measure_nose(&frame.view(), &known) {
            Ok(measured) => compare(sums, &measured, &truth, posed.camera.um_per_px),
            Err(_) => sums.refused += 1,
        }
        step(&frame, &truth);
    }
    let all = sums.iter().fold(Sums::default(), Sums::and);
    let rows = KINDS.iter().zip(&sums).map(|(kind, s)| s.row(kind));
    Ok(rows.chain([all.row("all")]).collect())
}

/// An insert in a drawn direction whose nose lies about a fifth of the field's height from its
/// middle, worn by one kind (0 to 4 as [`KINDS`], 5 a built-up edge); `draw` gives numbers of 0 to
/// 1.
pub(super) fn posed(of: &InsertSettings, kind: usize, draw: &mut dyn FnMut() -> f64) -> InsertSettings {
    let mut s = of.clone();
    s.nose.direction_deg = 360.0 * draw();
    let towards = s.nose.direction_deg.to_radians();
    let (columns, rows) = (f64::from(s.camera.columns), f64::from(s.camera.rows));
    s.nose.centre_px = [
        0.5 * columns + 0.2 * rows * towards.cos() + draw(),
        0.5 * rows - 0.2 * rows * towards.sin() + draw(),
    ];
    let direction_deg = s.nose.direction_deg + 60.0 * (draw() - 0.5);
    let (a, b) = (draw(), draw());
    let wear = match kind {
        0 => None,
        1 => Some(Wear::Round { depth_um: 5.0 + 25.0 * a }),
        2 => Some(Wear::Flat { direction_deg, depth_um: 3.0 + 12.0 * a }),
        3 => Some(Wear::Dent { direction_deg, width_deg: 15.0 + 30.0 * a, depth_um: 5.0 + 10.0 * b }),
        4 => Some(Wear::Chip { direction_deg, width_deg: 8.0 + 10.0 * a, depth_um: 5.0 + 10.0 * b }),
        _ => Some(Wear::BuiltUpEdge { direction_deg, width_deg: 8.0 + 22.0 * a, height_um: 3.0 + 12.0 * b }),
    };
    s.wear.extend(wear);
    s
}

/// A value of a table of (degrees, value) in even steps, straight between them.
pub(super) fn at(table: &[[f64; 2]], deg: f64) -> f64 {
    let (from, last) = (table[0][0], table.len() - 1);
    let place = (deg - from).rem_euclid(360.0) / (table[last][0] - from) * last as f64;
    let k = (place as usize).min(last - 1);
    table[k][1] + (place - k as f64) * (table[k + 1][1] - table[k][1])
}

fn compare(sums: &mut Sums, m: &NoseMeasurement, truth: &Truth, um_per_px: f64) {
    sums.noses += 1;
    let angle = m.angle_deg - truth.angle_deg;
    sums.error(0, angle, angle / m.u_angle_deg);
    let centre = [m.centre.x - truth.centre_px[0], m.centre.y + truth.centre_px[1]];
    let off = centre[0].hypot(centre[1]);
    sums.error(1, off, off / (2f64.sqrt() * m.u_centre_px));
    let mean = m.mean_radius_px - truth.mean_radius_px;
    sums.error(2, mean, mean / m.u_mean_radius_px);
    for s in &m.sectors {
        sums.covered(0, s.radius_px - at(&truth.radii, s.direction_deg), s.u_px);
    }
    let off = support_errors(m, truth);
    for (a, error, u) in &off {
        // h counts from the measured centre
        sums.covered(1, error + centre[0] * a.cos() + centre[1] * a.sin(), *u);
    }
    e_errors(&off).for_each(|(error_px, _)| sums.e(um_per_px * error_px));
}

/// Directions (rad), errors of the support and their u (px), away from the ends of the nose, where
/// e(a) has its touches.
pub(super) fn support_errors(m: &NoseMeasurement, truth: &Truth) -> Vec<(f64, f64, f64)> {
    let inner = m.support.len() / 8..m.support.len() - m.support.len() / 8;
    let error = |v: &SupportValue| {
        (v.direction_deg.to_radians(), v.h_px - at(&truth.support, v.direction_deg), v.u_px)
    };
    m.support[inner].iter().map(error).collect()
}

/// Errors of e(a) between the first and the last direction, px, and what an error that all edges
/// share adds to each, a share of it. e(a) does not depend on the tool's point: its error is that
/// of h less those of both touches.
pub(super) fn e_errors(off: &[(f64, f64, f64)]) -> impl Iterator<Item = (f64, f64)> + '_ {
    let (first, last) = (off[0], off[off.len() - 1]);
    let whole = last.0 - first.0;
    off.iter().map(move |(a, error, _)| {
        let by = [(last.0 - a).sin() / whole.sin(), (a - first.0).sin() / whole.sin()];
        (error - by[0] * first.1 - by[1] * last.1, 1.0 - by[0] - by[1])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_add_up_and_noses_are_measured_within_their_uncertainty() {
        let mut s = InsertSettings::default();
        (s.camera.columns, s.camera.rows) = (640, 512);
        s.nose.radius_mm = 0.2;
        let rows = run(&s, 5, 3, &mut |_, _| ()).unwrap();
        let (all, kinds) = rows.split_last().unwrap();
        assert_eq!((kinds.iter().map(|r| r.noses).sum::<usize>(), all.refused), (5, 0));
        let largest = kinds.iter().map(|r| r.centre.largest).fold(0.0, f64::max);
        assert!((all.centre.largest - largest).abs() < 1e-15);
        assert!(all.sectors.within > 0.9 && all.sectors.rms_px < 0.03, "{all:?}");
        assert_eq!(run(&s, 5, 3, &mut |_, _| ()).unwrap(), rows);
    }
}
