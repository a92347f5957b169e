//! The checks that an offset must pass before it is released. A refusal names the guard, its limit,
//! the place and the value found.

use super::context::{NextPass, PassContext};
use super::readings::Errors;
use super::settings::GuardSettings;
use crate::numerics::line::Line;
use crate::numerics::robust::{MAD_TO_SIGMA, median_of};
use crate::plan::{HeldReason, PassPlan};
use crate::profile::DiameterProfile;

/// Variance of a second difference of independent readings: 1 + 4 + 1.
const SECOND_DIFFERENCE: f64 = 6.0;
/// An outlier lies this many standard deviations from the prediction of its neighbours, and beyond
/// the limit in mm: about one in 10⁶ by chance.
const OUTLIER_SCATTERS: f64 = 5.0;

/// The data of a pass that the guards of the next one use.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GuardState {
    pub pass: u32,
    pub stations: Vec<ErrorAndOffset>,
}

/// A station's error, and the offset that it was cut with, mm of diameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ErrorAndOffset {
    pub e_mm: f64,
    pub o_mm: f64,
}

impl GuardState {
    pub(crate) fn new(plan: &PassPlan, errors: &Errors) -> Self {
        let pairs = errors.stations.iter().zip(&plan.offset.o_mm);
        let stations = pairs.map(|(s, o_mm)| ErrorAndOffset { e_mm: s.e_mm, o_mm: *o_mm });
        Self { pass: plan.pass, stations: stations.collect() }
    }
}

/// A refusal, and whether the cell must stop for it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Refusal {
    pub reason: HeldReason,
    /// The measurement contradicts the command: no further pass is safe before an inspection.
    pub stop: bool,
}

impl From<HeldReason> for Refusal {
    fn from(reason: HeldReason) -> Self {
        Self { reason, stop: false }
    }
}

fn guard(text: String) -> Refusal {
    Refusal { reason: HeldReason::Guard(text), stop: false }
}

/// The input of the guards.
pub(crate) struct Guarded<'a> {
    pub limits: &'a GuardSettings,
    pub plan: &'a PassPlan,
    pub context: &'a PassContext<'a>,
    pub errors: &'a Errors,
    /// Passes of this part whose measurements passed [`check_origin`], oldest first.
    pub history: &'a [GuardState],
    pub plant_gain: f64,
}

/// Checks that the measurement belongs to this pass: part, tool, pass, age, not used before,
/// master.
///
/// # Errors
/// The reason to hold.
pub(crate) fn check_origin(
    limits: &GuardSettings,
    plan: &PassPlan,
    measured: &DiameterProfile,
    context: &PassContext<'_>,
    used: Option<u64>,
) -> Result<(), Refusal> {
    if measured.pass != plan.pass {
        return Err(guard(format!("pass: pass {} was measured, pass {} was cut", measured.pass, plan.pass)));
    }
    let Some(origin) = context.origin else {
        return Ok(());
    };
    if let Some(here) = context.in_machine {
        if origin.of.part != here.part {
            let text = format!("part: {:?} was measured, {:?} is in the machine", origin.of.part, here.part);
            return Err(guard(text));
        }
        if origin.of.tool != here.tool {
            let text = format!("tool: measured after {:?}, {:?} cuts next", origin.of.tool, here.tool);
            return Err(guard(text));
        }
    }
    if used.is_some_and(|last| origin.scan <= last) {
        return Err(guard(format!("used once: scan {} was used before", origin.scan)));
    }
    if !(origin.since_cut_s >= 0.0) {
        let text = format!("fresh: the scan began {:.1} s before the pass was cut", -origin.since_cut_s);
        return Err(guard(text));
    }
    if !within(origin.age_s, limits.age_limit_s) {
        let text = format!("fresh: the scan is {:.0} s old, limit {} s", origin.age_s, limits.age_limit_s);
        return Err(guard(text));
    }
    match origin.master_deviation_mm {
        Some(d) if !within(d, limits.master_limit_mm) => Err(guard(format!(
            "master: read {:.2} µm off its diameter, limit {:.2} µm: calibrate the gauge",
            d * 1e3,
            limits.master_limit_mm * 1e3
        ))),
        _ => Ok(()),
    }
}

/// Guards on the measured values, before any law uses them.
///
/// # Errors
/// The reason to hold.
pub(crate) fn check_measured(g: &Guarded<'_>) -> Result<(), Refusal> {
    check_plausible(g)?;
    check_scatter(g)?;
    check_response(g)
}

fn check_plausible(g: &Guarded<'_>) -> Result<(), Refusal> {
    let (z, limits) = (&g.plan.station_z_mm, g.limits);
    if let Some((i, e)) = first_above(g.errors.stations.iter().map(|s| s.e_mm), limits.plausible_error_mm) {
        return Err(guard(format!(
            "plausible reading: the diameter at z = {} mm is {e:.4} mm off the nominal {} mm, limit {} mm",
            z[i],
            g.plan.nominal_at_mm(z[i]),
            limits.plausible_error_mm
        )));
    }
    if let Some((i, u)) = first_above(g.errors.stations.iter().map(|s| s.u_mm), limits.uncertainty_limit_mm) {
        return Err(guard(format!(
            "uncertainty: the reading at z = {} mm has a standard uncertainty of {u:.5} mm, limit {} mm",
            z[i], limits.uncertainty_limit_mm
        )));
    }
    Ok(())
}

fn check_scatter(g: &Guarded<'_>) -> Result<(), Refusal> {
    let (z, e, limits) = (&g.plan.station_z_mm, &g.errors.e_mm(), g.limits);
    let sections = g.plan.sections();
    let bends: Vec<f64> =
        sections.iter().flat_map(|s| second_differences(&z[s.clone()], &e[s.clone()])).collect();
    let scatter = robust_scatter(&bends);
    if scatter > limits.scatter_limit_mm {
        return Err(guard(format!(
            "scatter: {:.2} µm from station to station, limit {:.2} µm",
            scatter * 1e3,
            limits.scatter_limit_mm * 1e3
        )));
    }
    let limit = limits.outlier_limit_mm.max(OUTLIER_SCATTERS * scatter);
    let off = sections.iter().flat_map(|s| {
        let own = (&z[s.clone()], &e[s.clone()]);
        s.clone().map(move |i| (i, off_neighbours(own.0, own.1, i - s.start)))
    });
    match off.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).filter(|(_, off)| !within(*off, limit)) {
        Some((i, off)) => Err(guard(format!(
            "outlier: the reading at z = {} mm is {:.2} µm off what its neighbours say, limit {:.2} µm",
            z[i],
            off * 1e3,
            limit * 1e3
        ))),
        None => Ok(()),
    }
}

/// Guard on the ratio of observed to commanded change, which is about g. Taking a radius for a
/// diameter gives 2 g or ½ g, a wrong sign −g, an offset written to another register 0.
fn check_response(g: &Guarded<'_>) -> Result<(), Refusal> {
    let alike = |m: &&GuardState| m.pass + 1 == g.plan.pass && m.stations.len() == g.errors.stations.len();
    let Some(last) = g.history.last().filter(alike) else {
        return Ok(());
    };
    let commanded: Vec<f64> =
        g.plan.offset.o_mm.iter().zip(&last.stations).map(|(o, p)| o - p.o_mm).collect();
    let observed: Vec<f64> =
        g.errors.stations.iter().zip(&last.stations).map(|(s, p)| p.e_mm - s.e_mm).collect();
    let Some((ratio, varying)) = response(&commanded, &observed, g.limits.response_from_mm) else {
        return Ok(());
    };
    let (low, high) = (g.limits.response_min, g.limits.response_max);
    if (low..=high).contains(&ratio) || (low..=high).contains(&varying) {
        return Ok(());
    }
    let reason = HeldReason::Guard(format!(
        "response: the diameter changed by {ratio:.2} of what was commanded, limits {low}-{high}: radius for diameter, \
         a sign, or an offset that went elsewhere"
    ));
    Err(Refusal { reason, stop: true })
}

/// Slopes of the observed over the commanded changes along the stations: through zero, and with the
/// change common to all stations (wear, drift) taken out, where the command varies enough along z
/// for that; `None` for commands too small to judge by. A disturbance besides the offset changes
/// one of them, a wrong response both.
fn response(commanded: &[f64], observed: &[f64], from_mm: f64) -> Option<(f64, f64)> {
    let n = commanded.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / n;
    let slope = |c0: f64, o0: f64, least_rms: f64| {
        let square: f64 = commanded.iter().map(|c| (c - c0).powi(2)).sum();
        let product: f64 = commanded.iter().zip(observed).map(|(c, o)| (c - c0) * (o - o0)).sum();
        (square >= least_rms * least_rms * n && square > 0.0).then(|| product / square)
    };
    let plain = slope(0.0, 0.0, from_mm)?;
    Some((plain, slope(mean(commanded), mean(observed), 0.5 * from_mm).unwrap_or(plain)))
}

/// Guards on the proposal of a law.
///
/// # Errors
/// The reason to hold.
pub(crate) fn check_proposed(g: &Guarded<'_>, proposed_mm: &[f64]) -> Result<(), Refusal> {
    let limits = g.limits;
    let steps: Vec<f64> = proposed_mm.iter().zip(&g.plan.offset.o_mm).map(|(new, old)| new - old).collect();
    let step = largest(&steps);
    if !within(step, limits.step_limit_mm) {
        return Err(HeldReason::StepLimit { step_mm: step, limit_mm: limits.step_limit_mm }.into());
    }
    if let Some((i, o)) = first_above(proposed_mm.iter().copied(), limits.cumulative_limit_mm) {
        return Err(guard(format!(
            "cumulative limit: the offset at z = {} mm would be {o:.4} mm, limit {} mm",
            g.plan.station_z_mm[i], limits.cumulative_limit_mm
        )));
    }
    if step > limits.confirm_above_mm {
        check_repeat(g, step)?;
    }
    match &g.context.next {
        Some(next) => {
            check_cutting(g, next)?;
            check_depth(g, next, proposed_mm)?;
            check_undersize(g, next, proposed_mm)
        }
        None => Ok(()),
    }
}

fn check_repeat(g: &Guarded<'_>, step: f64) -> Result<(), Refusal> {
    let (from, limit) = (g.limits.confirm_above_mm, g.limits.agreement_limit_mm);
    let Some(repeat) = g.context.repeat else {
        let text =
            format!("two scans: a step of {step:.4} mm (above {from} mm) needs a second scan of the pass");
        return Err(guard(text));
    };
    let again: Vec<Option<f64>> = repeat.stations.iter().map(|s| s.reading.value().map(|d| d.d_mm)).collect();
    let same = repeat.pass == g.plan.pass && again.len() == g.errors.stations.len();
    let pairs = again.iter().zip(&g.errors.stations);
    let nominal = g.plan.station_nominal_mm();
    let apart = pairs.zip(nominal).map(|((again, s), r)| again.map_or(f64::NAN, |d| d - r - s.e_mm));
    let worst = if same { largest(&apart.collect::<Vec<_>>()) } else { f64::NAN };
    if within(worst, limit) {
        return Ok(());
    }
    let text = format!(
        "two scans: before a step of {step:.4} mm the scans differ by {worst:.4} mm, limit {limit} mm"
    );
    Err(guard(text))
}

/// A measurement applies to the next pass only if feed and speed are the same (NIST,
/// process-intermittent gauging).
fn check_cutting(g: &Guarded<'_>, next: &NextPass) -> Result<(), Refusal> {
    let differs = |a: f64, b: f64| !within(a - b, g.limits.cutting_tolerance * a.abs());
    let (was, is) = (g.plan.cutting, next.cutting);
    if differs(was.speed_m_per_min, is.speed_m_per_min) || differs(was.feed_mm_per_rev, is.feed_mm_per_rev) {
        return Err(guard(format!(
            "cutting data: measured at v {} m/min, f {} mm/r; the next pass has v {} m/min, f {} mm/r",
            was.speed_m_per_min, was.feed_mm_per_rev, is.speed_m_per_min, is.feed_mm_per_rev
        )));
    }
    Ok(())
}

fn check_depth(g: &Guarded<'_>, next: &NextPass, proposed_mm: &[f64]) -> Result<(), Refusal> {
    let (least, most) = (g.limits.min_depth_mm, g.limits.max_depth_mm);
    for (i, (s, o)) in g.errors.stations.iter().zip(proposed_mm).enumerate() {
        let diameter = g.context.blank_mm.unwrap_or(g.plan.nominal_mm + s.e_mm);
        let cut = 0.5 * (diameter - next.nominal_mm);
        let set = 0.5 * (diameter - (next.nominal_mm - o));
        let z = g.plan.station_z_mm[i];
        if cut.is_nan() || cut < least {
            let text =
                format!("minimum chip: {cut:.4} mm would be cut at z = {z} mm, least depth {least} mm");
            return Err(guard(text));
        }
        if set > most {
            return Err(guard(format!(
                "depth of cut: {set:.4} mm would be set at z = {z} mm, limit {most} mm"
            )));
        }
    }
    Ok(())
}

/// Undersize is scrap: the predicted diameter must stay above the lower limit by `coverage`
/// standard uncertainties.
fn check_undersize(g: &Guarded<'_>, next: &NextPass, offsets_mm: &[f64]) -> Result<(), Refusal> {
    let kept = g.limits.coverage;
    let predicted = predicted_mm(g, next, offsets_mm);
    // Room above the limit of the section that the station belongs to.
    let room = predicted.iter().zip(&g.errors.stations).enumerate().filter_map(|(i, (d, s))| {
        let limit = lower_limit_mm(g, g.plan.station_z_mm[i])?;
        Some((i, d - kept * s.u_mm, limit))
    });
    match room.min_by(|a, b| (a.1 - a.2).total_cmp(&(b.1 - b.2))) {
        Some((i, d, limit)) if d.is_nan() || d < limit => Err(guard(format!(
            "undersize: {:.4} mm is predicted at z = {} mm less {kept} u = {d:.4} mm, lower limit {limit} mm",
            predicted[i], g.plan.station_z_mm[i]
        ))),
        _ => Ok(()),
    }
}

/// Lower limit of size at a station, mm: its section's; of a plain shaft that of the settings.
fn lower_limit_mm(g: &Guarded<'_>, z_mm: f64) -> Option<f64> {
    match g.plan.form.contour() {
        Some(contour) => contour.section_at(z_mm)?.limits_mm.map(|limits| limits.0),
        None => g.limits.lower_limit_mm,
    }
}

/// Predicted diameter after the next pass, mm: r + e with e = (1 − g) e(k) − g o(k+1) + w. The
/// disturbance besides offset and copying, w(k) = e(k) − (1 − g) e(k−1) + g o(k), is extrapolated
/// by its growth since the pass before. From another blank nothing is copied: e = e(k) − g Δo.
fn predicted_mm(g: &Guarded<'_>, next: &NextPass, offsets_mm: &[f64]) -> Vec<f64> {
    let (e, o, gain) = (g.errors.e_mm(), &g.plan.offset.o_mm, g.plant_gain);
    // The form is that of this pass.
    let to_next_mm = next.nominal_mm - g.plan.nominal_mm;
    let nominal: Vec<f64> = g.plan.station_nominal_mm().map(|r| r + to_next_mm).collect();
    if g.context.blank_mm.is_some() {
        let steps = offsets_mm.iter().zip(o).map(|(new, old)| gain * (new - old));
        return nominal.iter().zip(e).zip(steps).map(|((r, e), step)| r + e - step).collect();
    }
    let before = |passes: u32| {
        let pass = g.plan.pass.checked_sub(passes)?;
        g.history.iter().find(|m| m.pass == pass && m.stations.len() == e.len())
    };
    let besides = |e: f64, copied: f64, o: f64| e - (1.0 - gain) * copied + gain * o;
    (0..offsets_mm.len())
        .map(|i| {
            let e1 = before(1).map_or(0.0, |m| m.stations[i].e_mm);
            let w = if before(1).is_some() { besides(e[i], e1, o[i]) } else { gain * (e[i] + o[i]) };
            let grew = match (before(1), before(2)) {
                (Some(m1), Some(m2)) => {
                    let ErrorAndOffset { e_mm, o_mm } = m1.stations[i];
                    w - besides(e_mm, m2.stations[i].e_mm, o_mm)
                }
                (Some(m1), None) if m1.pass == 1 => {
                    w - besides(m1.stations[i].e_mm, 0.0, m1.stations[i].o_mm)
                }
                _ => 0.0,
            };
            nominal[i] + (1.0 - gain) * e[i] - gain * offsets_mm[i] + w + grew
        })
        .collect()
}

/// Why the offsets in force may not be held for the next pass, if they are predicted to cut
/// undersize.
pub(crate) fn held_undersize(g: &Guarded<'_>) -> Option<String> {
    let next = g.context.next?;
    check_undersize(g, &next, &g.plan.offset.o_mm).err().map(|refusal| refusal.reason.to_string())
}

/// Deviation of each inner station from the line through its neighbours, scaled so that the scatter
/// of one reading has the weight as in e₀ − 2e₁ + e₂ of even stations.
fn second_differences(z: &[f64], e: &[f64]) -> Vec<f64> {
    let bend = |(z, e): (&[f64], &[f64])| {
        let share = (z[1] - z[0]) / (z[2] - z[0]);
        let weights = [1.0 - share, -1.0, share];
        let square: f64 = weights.iter().map(|w| w * w).sum();
        let off: f64 = weights.iter().zip(e).map(|(w, e)| w * e).sum();
        off * (SECOND_DIFFERENCE / square).sqrt()
    };
    z.windows(3).zip(e.windows(3)).map(bend).collect()
}

/// Standard deviation of one reading from the median magnitude of second differences, in which
/// slopes cancel.
fn robust_scatter(second_differences: &[f64]) -> f64 {
    MAD_TO_SIGMA * median_of(second_differences.iter().map(|d| d.abs()).collect()) / SECOND_DIFFERENCE.sqrt()
}

/// Difference of a station from the prediction of its neighbours: inside, the median of the four
/// lines through two of them; next to an end, the parabola through three; at an end, the line
/// fitted to four.
fn off_neighbours(z: &[f64], e: &[f64], i: usize) -> f64 {
    let n = e.len();
    if n < 5 {
        return 0.0;
    }
    let line = |a: usize, b: usize| e[a] + (e[b] - e[a]) * (z[i] - z[a]) / (z[b] - z[a]);
    let predicted = match i {
        0 => fitted_line(&z[1..5], &e[1..5], z[i]),
        1 => parabola([0, 2, 3].map(|k| (z[k], e[k])), z[i]),
        _ if i + 1 == n => fitted_line(&z[n - 5..n - 1], &e[n - 5..n - 1], z[i]),
        _ if i + 2 == n => parabola([n - 1, n - 3, n - 4].map(|k| (z[k], e[k])), z[i]),
        _ => {
            let mut lines = [line(i - 1, i - 2), line(i + 1, i + 2), line(i - 1, i + 1), line(i - 2, i + 2)];
            lines.sort_by(f64::total_cmp);
            0.5 * (lines[1] + lines[2])
        }
    };
    e[i] - predicted
}

/// Least-squares line through points, at `at`.
fn fitted_line(z: &[f64], e: &[f64], at: f64) -> f64 {
    Line::through(z.iter().copied().zip(e.iter().copied())).at(at)
}

/// Parabola through three points, at `at` (Lagrange).
fn parabola(points: [(f64, f64); 3], at: f64) -> f64 {
    let share = |k: usize| {
        let others = (0..3).filter(|j| *j != k);
        others.map(|j| (at - points[j].0) / (points[k].0 - points[j].0)).product::<f64>()
    };
    (0..3).map(|k| points[k].1 * share(k)).sum()
}

/// Index and value of the first element whose magnitude is not within the limit.
fn first_above(values: impl Iterator<Item = f64>, limit: f64) -> Option<(usize, f64)> {
    values.enumerate().find(|(_, v)| !within(*v, limit))
}

/// |value| ≤ limit; false for NaN.
fn within(value: f64, limit: f64) -> bool {
    value.abs() <= limit
}

/// Largest magnitude; NaN if any is.
fn largest(values: &[f64]) -> f64 {
    values.iter().map(|v| v.abs()).fold(0.0, |most, v| if v > most || v.is_nan() { v } else { most })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uneven stations are predicted from their neighbours as well as even ones.
    #[test]
    fn uneven_stations_have_no_outlier_on_a_line_or_at_an_end_parabola() {
        let z = [3.0, 11.0, 30.5, 40.0, 57.0, 58.0, 90.0];
        let line: Vec<f64> = z.iter().map(|z| 0.2 - 0.003 * z).collect();
        assert!((0..7).all(|i| off_neighbours(&z, &line, i).abs() < 1e-12));
        assert!(second_differences(&z, &line).iter().all(|d| d.abs() < 1e-12));
        let square: Vec<f64> = z.iter().map(|z| 1e-4 * z * z).collect();
        assert!(off_neighbours(&z, &square, 1).abs() < 1e-12 && off_neighbours(&z, &square, 5).abs() < 1e-12);
        let even = [0.0, 5.0, 10.0, 15.0, 20.0];
        let e = [0.01, 0.02, 0.05, -0.01, 0.0];
        let wanted = [0.01 - 2.0 * 0.02 + 0.05, 0.02 - 2.0 * 0.05 - 0.01, 0.05 + 2.0 * 0.01];
        let found = second_differences(&even, &e);
        assert!(found.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        // a + (b − d)/2 at an end, a/3 + b − c/3 beside it
        assert!((off_neighbours(&even, &e, 0) - (e[0] - (e[1] + 0.5 * (e[2] - e[4])))).abs() < 1e-12);
        assert!((off_neighbours(&even, &e, 1) - (e[1] - (e[0] / 3.0 + e[2] - e[3] / 3.0))).abs() < 1e-12);
    }
}
