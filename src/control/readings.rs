//! From a measured profile to one error per station: e = D - r with its uncertainty.

use super::settings::GapSettings;
use crate::plan::{HeldReason, PassPlan};
use crate::profile::{Diameter, DiameterProfile};

/// Largest deviation of a station from its place in the plan, mm.
const STATION_TOLERANCE_MM: f64 = 1e-6;

/// Error of one station in a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StationError {
    /// e = D - r, mm of diameter.
    pub e_mm: f64,
    /// Standard uncertainty of e that is independent from station to station, mm.
    pub u_random_mm: f64,
    /// Combined standard uncertainty of e, mm.
    pub u_mm: f64,
    /// Whether the value was interpolated between neighbours.
    pub interpolated: bool,
}

/// Errors of one pass.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Errors {
    /// One per station of the plan, none missing.
    pub stations: Vec<StationError>,
}

impl Errors {
    /// e of every station, mm of diameter.
    pub(crate) fn e_mm(&self) -> Vec<f64> {
        self.stations.iter().map(|s| s.e_mm).collect()
    }
}

/// Computes the errors of a pass, filling gaps where the settings allow it.
///
/// # Errors
/// The reason to hold: stations other than the plan's, NaN, or gaps that may not be filled.
pub(crate) fn errors(
    plan: &PassPlan,
    measured: &DiameterProfile,
    gaps: &GapSettings,
) -> Result<Errors, HeldReason> {
    check_stations(plan, measured)?;
    let mut values = diameters(measured);
    if let Some(index) = values.iter().position(|v| v.is_some_and(|d| !is_number(&d))) {
        return Err(HeldReason::Guard(format!(
            "the reading at z = {} mm is no number with a positive uncertainty",
            plan.station_z_mm[index]
        )));
    }
    check_share(&values, gaps)?;
    for section in plan.sections() {
        fill(&plan.station_z_mm[section.clone()], &mut values[section], gaps)
            .map_err(|()| gapped(&diameters(measured)))?;
    }
    let read = values.into_iter().flatten().zip(&measured.stations).zip(plan.station_nominal_mm());
    let stations = read.map(|((d, read), nominal_mm)| StationError {
        e_mm: d.d_mm - nominal_mm,
        u_random_mm: d.u_random_mm,
        u_mm: d.u_mm(),
        interpolated: read.reading.value().is_none(),
    });
    Ok(Errors { stations: stations.collect() })
}

fn is_number(d: &Diameter) -> bool {
    d.d_mm.is_finite()
        && d.u_mm().is_finite()
        && d.u_random_mm >= 0.0
        && d.u_common_mm >= 0.0
        && d.u_mm() > 0.0
}

fn check_stations(plan: &PassPlan, measured: &DiameterProfile) -> Result<(), HeldReason> {
    let (planned, seen) = (plan.station_z_mm.len(), measured.stations.len());
    if planned != seen || plan.offset.o_mm.len() != planned {
        let offsets = plan.offset.o_mm.len();
        let text = format!("{seen} stations were measured, {planned} planned with {offsets} offsets");
        return Err(HeldReason::Guard(text));
    }
    let in_place = |z: f64, seen: f64| (z - seen).abs() <= STATION_TOLERANCE_MM;
    let moved = plan.station_z_mm.iter().zip(&measured.stations).find(|(z, s)| !in_place(**z, s.z_mm));
    match moved {
        Some((z, s)) => {
            Err(HeldReason::Guard(format!("a station measured at z = {} mm is planned at {z} mm", s.z_mm)))
        }
        None => Ok(()),
    }
}

/// Why stations without a reading hold the offsets.
fn gapped(values: &[Option<Diameter>]) -> HeldReason {
    HeldReason::Gaps { missing: values.iter().filter(|v| v.is_none()).count(), of: values.len() }
}

fn diameters(measured: &DiameterProfile) -> Vec<Option<Diameter>> {
    measured.stations.iter().map(|s| s.reading.value()).collect()
}

/// Refuses more gaps than may be filled.
fn check_share(values: &[Option<Diameter>], gaps: &GapSettings) -> Result<(), HeldReason> {
    let missing = values.iter().filter(|v| v.is_none()).count();
    let too_many = missing as f64 > gaps.interpolate_share * values.len() as f64;
    if too_many && missing > 0 { Err(gapped(values)) } else { Ok(()) }
}

/// Interpolates linearly in z inside runs of gaps of a section that are short enough.
fn fill(z: &[f64], values: &mut [Option<Diameter>], gaps: &GapSettings) -> Result<(), ()> {
    if values.iter().all(Option::is_some) {
        return Ok(());
    }
    let measured: Vec<(usize, Diameter)> =
        values.iter().enumerate().filter_map(|(i, v)| v.map(|d| (i, d))).collect();
    for pair in measured.windows(2) {
        let ((left, a), (right, b)) = (pair[0], pair[1]);
        if right - left - 1 > gaps.interpolate_run {
            return Err(());
        }
        for i in left + 1..right {
            values[i] = Some(between(a, b, (z[i] - z[left]) / (z[right] - z[left])));
        }
    }
    let ends_measured =
        values.first().is_some_and(Option::is_some) && values.last().is_some_and(Option::is_some);
    if ends_measured { Ok(()) } else { Err(()) }
}

/// Linear interpolation with the uncertainty propagated (GUM 5.1.2; the common part is common).
fn between(a: Diameter, b: Diameter, share: f64) -> Diameter {
    let mix = |x: f64, y: f64| x * (1.0 - share) + y * share;
    Diameter {
        d_mm: mix(a.d_mm, b.d_mm),
        u_random_mm: (a.u_random_mm * (1.0 - share)).hypot(b.u_random_mm * share),
        u_common_mm: mix(a.u_common_mm, b.u_common_mm),
    }
}
