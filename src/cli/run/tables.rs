//! The tables of a run: read back from the folder of an unfinished one, a pass added at a time,
//! written into the folder.

use crate::cli::failure::{Failure, folder_failure};
use crate::closed_loop::{ClosedLoop, PassResult};
use crate::job::LoopJob;
use crate::plan::Decision;
use crate::process::bending::axis_at;
use crate::profile::{Diameter, Reading};
use crate::run_folder::{
    AxisRow, ControlRecord, DiameterRow, FormRow, OffsetRow, PartFormRow, PassRecord, PassRow, RunFolder,
    SectionResults, StationRow, TrueAxisRow, TruthRow, read_diameters, section_results,
};

/// Tables of the passes cut so far.
pub(super) struct RunTables {
    pub(super) passes: Vec<PassRow>,
    pub(super) stations: Vec<StationRow>,
    pub(super) offsets: Vec<OffsetRow>,
    diameters: Vec<DiameterRow>,
    pub(super) control: ControlRecord,
    sections: Vec<FormRow>,
    parts: Vec<PartFormRow>,
    pub(super) axis: Vec<AxisRow>,
    true_axis: Vec<TrueAxisRow>,
}

impl RunTables {
    /// What a folder holds of the passes that are finished; the offsets follow from the loop.
    ///
    /// # Errors
    /// Where a table cannot be read.
    pub(super) fn read(folder: &RunFolder) -> Result<Self, Failure> {
        let passes = folder.passes().map_err(folder_failure)?;
        let done = |pass: u32| passes.iter().any(|p| p.pass == pass);
        let mut stations = folder.stations().map_err(folder_failure)?;
        let mut diameters = read_diameters(folder).map_err(folder_failure)?;
        stations.retain(|s| done(s.pass));
        diameters.retain(|d| done(d.pass));
        let (mut sections, mut parts) = folder.form().map_err(folder_failure)?;
        sections.retain(|f| done(f.pass));
        parts.retain(|f| done(f.pass));
        let mut axis = folder.axis().map_err(folder_failure)?;
        axis.retain(|a| done(a.pass));
        let mut true_axis = folder.true_axis().map_err(folder_failure)?;
        true_axis.retain(|a| done(a.pass));
        let mut control = match passes.is_empty() {
            true => ControlRecord::default(),
            false => folder.control().map_err(folder_failure)?,
        };
        control.passes.retain(|p| done(p.pass));
        let offsets = Vec::new();
        Ok(Self { passes, stations, offsets, diameters, control, sections, parts, axis, true_axis })
    }

    /// Results of the last finished pass by section; none for a plain shaft.
    pub(super) fn sections(&self, order: &LoopJob) -> Option<SectionResults> {
        section_results(order, self.passes.last()?.pass, &self.stations, &self.diameters)
    }

    /// Adds the offsets that the loop has in force for the pass to come.
    pub(super) fn add_offsets(&mut self, chain: &ClosedLoop<'_>) {
        self.offsets.extend(offset_rows(chain));
    }

    /// Adds a finished pass.
    pub(super) fn add(&mut self, result: &PassResult, chain: &ClosedLoop<'_>) {
        let truth = result.truth_mm.as_deref();
        let pass = result.plan.pass;
        let stations = &result.profile.stations;
        let true_of = |index: usize| truth.and_then(|t| t.get(index).copied());
        let rows = stations.iter().enumerate().map(|(i, s)| StationRow::new(pass, s, true_of(i)));
        self.stations.extend(rows);
        self.diameters.extend(diameter_rows(result));
        self.sections.extend(result.form.sections.iter().map(|s| FormRow::new(pass, s, stations)));
        self.parts.push(PartFormRow::new(pass, &result.form));
        self.axis.extend(AxisRow::of(pass, &result.axis));
        self.true_axis.extend(true_axis_rows(result));
        self.passes.push(pass_row(result));
        self.control.stock = chain.stock().cloned();
        self.control.passes.push(pass_record(result));
    }

    /// Writes all tables, `passes.csv` last: a pass that stands there has all its data.
    ///
    /// # Errors
    /// Where the disk fails.
    pub(super) fn write(&self, folder: &RunFolder, run_id: &str) -> Result<(), Failure> {
        let truth = |s: &StationRow| Some(TruthRow { pass: s.pass, z_mm: s.z_mm, d_mm: s.true_d_mm? });
        let truth: Vec<TruthRow> = self.stations.iter().filter_map(truth).collect();
        folder
            .write_stations(&self.stations)
            .and_then(|()| folder.write_offsets(&self.offsets))
            .and_then(|()| folder.write_form(&self.sections, &self.parts))
            .and_then(|()| folder.write_axis(&self.axis))
            .and_then(|()| folder.write_diameters(run_id, &self.diameters))
            .and_then(|()| if truth.is_empty() { Ok(()) } else { folder.write_truth(run_id, &truth) })
            .and_then(|()| match self.true_axis[..] {
                [] => Ok(()),
                _ => folder.write_true_axis(&self.true_axis),
            })
            .and_then(|()| folder.write_control(&self.control))
            .and_then(|()| folder.write_passes(&self.passes))
            .map_err(folder_failure)
    }
}

fn pass_record(result: &PassResult) -> PassRecord {
    let reason = match &result.decision {
        Some(Decision::Held(reason)) => Some(reason.to_string()),
        _ => None,
    };
    PassRecord {
        pass: result.plan.pass,
        decision: decision_word(result).to_owned(),
        reason,
        alarm: result.alarm.clone(),
        notes: result.notes.clone(),
        evidence: result.evidence.clone(),
    }
}

fn decision_word(result: &PassResult) -> &'static str {
    match &result.decision {
        None => "last",
        Some(Decision::Offset(_)) => "released",
        Some(Decision::Held(_)) => "held",
    }
}

fn offset_rows(chain: &ClosedLoop<'_>) -> Vec<OffsetRow> {
    let plan = chain.plan();
    let commanded = plan.commanded_mm();
    let (status, reason) = match chain.held() {
        Some(reason) => ("held", reason.to_string()),
        None => ("released", String::new()),
    };
    plan.station_z_mm
        .iter()
        .zip(&plan.offset.o_mm)
        .zip(&chain.asked().o_mm)
        .zip(commanded)
        .map(|(((&z_mm, &offset_mm), &asked_mm), commanded_mm)| OffsetRow {
            pass: plan.pass,
            z_mm,
            offset_mm,
            asked_mm: Some(asked_mm),
            commanded_mm,
            status: status.to_owned(),
            reason: reason.clone(),
        })
        .collect()
}

fn diameter_rows(result: &PassResult) -> impl Iterator<Item = DiameterRow> + '_ {
    result.readings.iter().map(|r| {
        let value = r.reading.value();
        let number = |f: &dyn Fn(Diameter) -> f64| value.map_or(f64::NAN, f);
        DiameterRow {
            pass: result.plan.pass,
            frame_id: r.frame_id,
            t_ns: r.t_ns,
            z_mm: r.z_mm,
            angle_deg: r.angle_deg,
            d_mm: number(&|d| d.d_mm),
            u_random_mm: number(&|d| d.u_random_mm),
            u_common_mm: number(&|d| d.u_common_mm),
            flag: match r.reading {
                Reading::Gap(reason) => reason.to_string(),
                Reading::Value(_) => String::new(),
            },
        }
    })
}

/// Figures of a pass that compare with the truth.
#[derive(Default)]
struct AgainstTruth {
    true_max_abs_error_mm: Option<f64>,
    worst_measured_minus_true_mm: Option<f64>,
    rms_error_over_u: Option<f64>,
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, f64::max)
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(s, n), v| (s + v * v, n + 1));
    (sum / count.max(1) as f64).sqrt()
}

impl AgainstTruth {
    fn of(result: &PassResult) -> Self {
        let Some(truth) = &result.truth_mm else { return Self::default() };
        let measured: Vec<(Diameter, f64)> = result
            .profile
            .stations
            .iter()
            .zip(truth)
            .filter_map(|(s, &t)| Some((s.reading.value()?, t)))
            .collect();
        Self {
            true_max_abs_error_mm: Some(largest(
                truth.iter().zip(result.plan.station_nominal_mm()).map(|(t, r)| t - r),
            )),
            worst_measured_minus_true_mm: Some(largest(measured.iter().map(|(d, t)| d.d_mm - t))),
            rms_error_over_u: Some(rms(measured.iter().map(|(d, t)| (d.d_mm - t) / d.u_mm()))),
        }
    }
}

fn pass_row(result: &PassResult) -> PassRow {
    let nominal_mm = result.plan.nominal_mm;
    let nominal = result.plan.station_nominal_mm();
    let read = result.profile.stations.iter().zip(nominal);
    let errors: Vec<f64> = read.filter_map(|(s, r)| Some(s.reading.value()?.d_mm - r)).collect();
    let against = AgainstTruth::of(result);
    PassRow {
        pass: result.plan.pass,
        nominal_mm,
        max_abs_error_mm: largest(errors.iter().copied()),
        rms_error_mm: rms(errors.iter().copied()),
        true_max_abs_error_mm: against.true_max_abs_error_mm,
        worst_measured_minus_true_mm: against.worst_measured_minus_true_mm,
        rms_error_over_u: against.rms_error_over_u,
        stations_measured: errors.len(),
        frames: result.frames,
        decision: decision_word(result).to_owned(),
        radial_force_n: result.cut.as_ref().map(|c| c.max_force_n),
        tangential_force_n: result.cut.as_ref().map(|c| c.max_cutting_n),
        feed_force_n: result.cut.as_ref().map(|c| c.max_feed_n),
        deflection_um: result.cut.as_ref().map(|c| 1e3 * c.max_deflection_mm),
        tangential_error_um: result.cut.as_ref().map(|c| c.tangential_error_um),
        feed_mark_um: result.cut.as_ref().map(|c| c.feed_mark_um),
    }
}

fn true_axis_rows(result: &PassResult) -> impl Iterator<Item = TrueAxisRow> + '_ {
    result.true_axis.iter().flat_map(|axis| {
        result.plan.station_z_mm.iter().map(|&z_mm| {
            let [still_x_mm, still_y_mm] = axis_at(&axis.still, z_mm);
            let [turning_x_mm, turning_y_mm] = axis_at(&axis.turning, z_mm);
            TrueAxisRow { pass: result.plan.pass, z_mm, still_x_mm, still_y_mm, turning_x_mm, turning_y_mm }
        })
    })
}
