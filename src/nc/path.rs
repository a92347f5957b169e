//! The path of a turning pass: knots along z, the offsets after rounding, and the list of a dry
//! run.

use super::contour_path;
use super::dialect::Dialect;
use super::error::NcError;
use super::machine::WearX;
use super::settings::NcSettings;
use crate::plan::{Contour, DiameterOffset, PassPlan};

/// A path over the stations; beyond the outer ones programs continue level to the ends of the cut.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Path {
    /// (Z, X) of every knot from the tailstock to the chuck, as they stand in the program, mm.
    pub knots: Vec<(f64, f64)>,
    /// Value that the wear register adds to X, mm of diameter (−ō, rounded; 0 without a register).
    pub wear_mm: f64,
    /// The offsets in force at the plan's stations, after rounding.
    pub in_force: DiameterOffset,
}

impl Path {
    /// Splits, samples and rounds the commanded diameters of a pass.
    ///
    /// # Errors
    /// Offsets for other stations, too large ones, or a path that leaves its range.
    pub(crate) fn new(plan: &PassPlan, settings: &NcSettings, dialect: Dialect) -> Result<Self, NcError> {
        settings.validate()?;
        check(plan, settings)?;
        let decimals = dialect.x_decimals();
        if let Some(contour) = plan.form.contour() {
            return Self::along(contour, plan, settings, decimals);
        }
        let wear_mm = if settings.uses_wear_register(dialect) {
            let mean = plan.offset.o_mm.iter().sum::<f64>() / plan.offset.o_mm.len() as f64;
            // a register in radius holds half of it: the remainder of its rounding goes into the
            // path
            let unit = settings.wear_x.map_or(1.0, WearX::diameter_per_unit);
            unit * round(-mean / unit, decimals)
        } else {
            0.0
        };
        let mut count = settings.least_knots;
        loop {
            // where even knots do not suffice (stations at uneven distances), those of the stations
            // are added
            let at_stations = count > 4 * plan.station_z_mm.len();
            let knots = sample(plan, wear_mm, count, decimals, at_stations);
            let path = Self { in_force: in_force(plan, &knots, wear_mm), knots, wear_mm };
            let rounding = 1.5 * 10f64.powi(-(decimals as i32));
            let close = path.largest_departure(plan) <= settings.knot_tolerance_mm + rounding;
            if close || at_stations {
                return path.checked(plan, settings);
            }
            count = 2 * count - 1;
        }
    }

    /// Along the contour of a stepped shaft: shoulders, tapers and fillets with the offsets of
    /// their sections. The path holds all of them, the wear register nothing.
    fn along(
        contour: &Contour,
        plan: &PassPlan,
        settings: &NcSettings,
        decimals: usize,
    ) -> Result<Self, NcError> {
        let exact = contour_path::path(plan, contour, settings)?;
        let mut knots: Vec<(f64, f64)> =
            exact.iter().rev().map(|(z, x)| (round(*z, 3), round(*x, decimals))).collect();
        knots.dedup();
        let (z, x): (Vec<f64>, Vec<f64>) = knots.iter().rev().copied().unzip();
        let cut = |z_mm: &f64| Ok(interpolate(&z, &x, contour_path::programmed_z(contour, settings, *z_mm)?));
        let cut: Result<Vec<f64>, NcError> = plan.station_z_mm.iter().map(cut).collect();
        let o_mm = plan.station_nominal_mm().zip(cut?).map(|(nominal, cut)| nominal - cut).collect();
        Self { knots, wear_mm: 0.0, in_force: DiameterOffset { o_mm } }.first_station_cut(plan, settings)
    }

    /// Largest difference between the offsets in force and those requested, mm of diameter.
    pub(crate) fn largest_departure(&self, plan: &PassPlan) -> f64 {
        let differences = self.in_force.o_mm.iter().zip(&plan.offset.o_mm).map(|(a, b)| (a - b).abs());
        differences.fold(0.0, f64::max)
    }

    fn checked(self, plan: &PassPlan, settings: &NcSettings) -> Result<Self, NcError> {
        let limit = settings.correction_limit_mm;
        let (low_mm, high_mm) = (plan.nominal_mm - limit, plan.nominal_mm + limit);
        for &(z_mm, x) in &self.knots {
            let x_mm = x + self.wear_mm;
            if !(low_mm..=high_mm).contains(&x_mm) {
                return Err(NcError::Range { x_mm, z_mm, low_mm, high_mm });
            }
        }
        self.first_station_cut(plan, settings)
    }

    fn first_station_cut(self, plan: &PassPlan, settings: &NcSettings) -> Result<Self, NcError> {
        if settings.least_z_mm > plan.station_z_mm[0] {
            return Err(NcError::Plan(format!(
                "nc.least_z_mm = {} lies beyond the first station at Z = {} mm: it would not be cut",
                settings.least_z_mm, plan.station_z_mm[0]
            )));
        }
        Ok(self)
    }
}

fn check(plan: &PassPlan, settings: &NcSettings) -> Result<(), NcError> {
    let (stations, offsets) = (plan.station_z_mm.len(), plan.offset.o_mm.len());
    if stations < 2 || stations != offsets {
        return Err(NcError::Plan(format!(
            "{offsets} offsets for {stations} stations; a path needs two or more"
        )));
    }
    if let Some(z) = plan.station_z_mm.windows(2).find(|w| w[0].is_nan() || w[1] <= w[0]) {
        return Err(NcError::Plan(format!("stations at {} and {} mm do not ascend", z[0], z[1])));
    }
    if let Some(o) =
        plan.offset.o_mm.iter().find(|o| !o.is_finite() || o.abs() > settings.correction_limit_mm)
    {
        return Err(NcError::Plan(format!(
            "range check: an offset of {o} mm exceeds nc.correction_limit_mm = {}",
            settings.correction_limit_mm
        )));
    }
    let finite = plan.nominal_mm > 0.0 && plan.nominal_mm.is_finite() && plan.cutting.feed_mm_per_rev > 0.0;
    if finite { Ok(()) } else { Err(NcError::Plan("nominal diameter and feed must be positive".into())) }
}

fn round(value: f64, decimals: usize) -> f64 {
    let scale = 10f64.powi(decimals as i32);
    (value * scale).round() / scale
}

/// Even knots from the last station to the first; with `at_stations`, also one at every station.
fn sample(plan: &PassPlan, wear: f64, count: usize, decimals: usize, at_stations: bool) -> Vec<(f64, f64)> {
    let z = &plan.station_z_mm;
    let (first, last) = (z[0], z[z.len() - 1]);
    let x = |at: f64| round(plan.nominal_mm - interpolate(z, &plan.offset.o_mm, at) - wear, decimals);
    let at = |i: usize| round(first + (last - first) * i as f64 / (count - 1) as f64, 3);
    let mut places: Vec<f64> = (0..count).map(at).collect();
    if at_stations {
        places.extend(z.iter().map(|z| round(*z, 3)));
        places.sort_by(f64::total_cmp);
    }
    let mut knots: Vec<(f64, f64)> = places.into_iter().rev().map(|at| (at, x(at))).collect();
    knots.dedup_by(|a, b| a.0 == b.0);
    knots
}

/// Linear in z, level beyond the ends.
pub(super) fn interpolate(z: &[f64], values: &[f64], at: f64) -> f64 {
    let right = z.partition_point(|&s| s < at);
    if right == 0 {
        return values[0];
    }
    if right == z.len() {
        return values[z.len() - 1];
    }
    let share = (at - z[right - 1]) / (z[right] - z[right - 1]);
    values[right - 1] * (1.0 - share) + values[right] * share
}

fn in_force(plan: &PassPlan, knots: &[(f64, f64)], wear: f64) -> DiameterOffset {
    let (z, x): (Vec<f64>, Vec<f64>) = knots.iter().rev().copied().unzip();
    let at = |s: &f64| plan.nominal_mm - (interpolate(&z, &x, *s) + wear);
    DiameterOffset { o_mm: plan.station_z_mm.iter().map(at).collect() }
}

/// The list of a dry run: every station's old and new offset, and the reason.
pub(crate) fn dry_run(old: &DiameterOffset, plan: &PassPlan, path: &Path, reason: &str) -> String {
    let mut text = format!(
        "pass {}: {} knots, wear register {:+.4} mm, largest departure from the offsets asked for {:.5} mm\n\
         reason: {reason}\n       z/mm     old/mm   asked/mm  program/mm  commanded/mm\n",
        plan.pass,
        path.knots.len(),
        path.wear_mm,
        path.largest_departure(plan),
    );
    for (i, z) in plan.station_z_mm.iter().enumerate() {
        let before = old.o_mm.get(i).copied().unwrap_or(0.0);
        let (asked, real) = (plan.offset.o_mm[i], path.in_force.o_mm[i]);
        let commanded = plan.nominal_at_mm(*z) - real;
        text += &format!("{z:11.3} {before:10.5} {asked:10.5}  {real:10.5}  {commanded:12.5}\n");
    }
    text
}
