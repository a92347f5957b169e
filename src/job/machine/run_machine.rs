//! The lathe of `[machine]` in a job, and what it must agree with.

use super::lathe::{Lathe, Ways};
use super::reading_correction::check_known;
use super::run_settings::RunMachine;
use crate::job::loop_job::LoopJob;
use crate::job::scan::ScanWhen;
use crate::machine::conditions::Direction;
use crate::machine::{Conditions, MachineSettings};
use crate::plan::FeedDirection;
use crate::process::ProcessSettings;
use crate::setting::{SettingError, require};
use crate::shaft::SpindleMotion;

/// What of a job a machine must agree with.
pub(crate) struct OnMachine<'a> {
    /// The loop's half.
    pub part: &'a LoopJob,
    /// The process.
    pub process: &'a ProcessSettings,
    /// `[shaft.spindle]`.
    pub spindle: &'a SpindleMotion,
    /// Whether the frames of the run are recorded.
    pub is_recorded: bool,
}

impl RunMachine {
    /// The machine under a job.
    ///
    /// # Errors
    /// A machine that is missing or cannot be right, settings of the job that describe the same
    /// error once more, a part beyond its travels.
    pub(crate) fn lathe(&self, on: &OnMachine<'_>) -> Result<Lathe, SettingError> {
        let settings = self.needed()?;
        let motion = settings.motion().map_err(in_stated)?;
        let state = self.state()?;
        check_beside(on)?;
        check_travels(settings, on.part)?;
        let followed = on.part.scan.when == ScanWhen::DuringCut;
        let cut = match on.part.feed_direction {
            FeedDirection::TowardsChuck => Direction::Backward,
            FeedDirection::TowardsTailstock => Direction::Forward,
        };
        // fields of a scan ascend along z; a followed pass is looked at while it is cut
        let ways = Ways { cut, scan: if followed { cut } else { Direction::Forward } };
        let mut lathe = Lathe::new(settings, motion, &state, ways)?;
        if let Some(table) = self.table_of(settings, on.part)?.filter(|_| self.compensate) {
            let table = Lathe::new(table, table.motion().map_err(in_table)?, &Conditions::default(), ways);
            lathe = lathe.compensated_by(table.map_err(in_table)?);
        }
        self.check_head()?;
        if let Some(probe) = &self.probe {
            probe.check(&lathe, radii_mm(on.part))?;
        }
        if lathe.spindle_errs() && !on.spindle.synchronous.is_empty() {
            let why = "stands beside the errors of C in [machine], which move the part in the same way: one of them";
            return Err(SettingError::at("shaft.spindle.synchronous", why));
        }
        Ok(lathe)
    }

    fn needed(&self) -> Result<&MachineSettings, SettingError> {
        let unread = [("machine.file", &self.file), ("machine.table", &self.table)];
        if let Some((key, _)) = unread.into_iter().find(|(_, name)| name.is_some()) {
            let why =
                "a file beside a config is read with the config's own file; text alone needs machine.stated";
            return Err(SettingError::at(key, why));
        }
        let why = "names the file of a machine; or [machine.stated] has its chain, levers and errors";
        self.stated.as_ref().ok_or_else(|| SettingError::at("machine.file", why))
    }

    /// The machine of which the control's table is made; none where it does not compensate.
    fn table_of<'a>(
        &'a self,
        own: &'a MachineSettings,
        part: &LoopJob,
    ) -> Result<Option<&'a MachineSettings>, SettingError> {
        let uses = self.compensate || self.correct_readings;
        let table = match (&self.table_stated, uses) {
            (None, false) => return Ok(None),
            (None, true) => return Ok(Some(own)),
            (Some(_), false) => {
                let why = "is not used where the control does not compensate: machine.compensate = true (or correct_readings = true)";
                return Err(SettingError::at("machine.table", why));
            }
            (Some(table), true) => table,
        };
        let right = format!("{}, the machine's: the table is that of another one", own.chain.notation());
        require(table.chain == own.chain, "machine.table", table.chain.notation(), &right)?;
        let beyond = |e: SettingError| SettingError {
            problem: format!("{}; there the errors of machine.table end, none is extrapolated", e.problem),
            ..e
        };
        check_travels(table, part).map_err(beyond)?;
        Ok(Some(table))
    }

    fn state(&self) -> Result<Conditions, SettingError> {
        let usual = Conditions::default();
        let state = Conditions {
            temperature_c: self.temperature_c.unwrap_or(usual.temperature_c),
            minutes: self.minutes.unwrap_or(usual.minutes),
            ..usual
        };
        let own = |e: SettingError| SettingError { key: e.key.replace("conditions.", "machine."), ..e };
        state.validate().map_err(own)?;
        Ok(state)
    }
}

/// An error of `[machine]` where a job states it.
fn in_stated(error: SettingError) -> SettingError {
    let key = error.key.strip_prefix("machine.").map(|key| format!("machine.stated.{key}"));
    SettingError { key: key.unwrap_or_else(|| error.key.clone()), ..error }
}

/// The same of the control's table.
fn in_table(error: SettingError) -> SettingError {
    let key =
        error.key.replacen("machine.stated.", "machine.", 1).replacen("machine.", "machine.table_stated.", 1);
    SettingError { key, ..error }
}

/// Settings of the job that state what the machine states, and parts of a cell on which its errors
/// do not act yet.
fn check_beside(on: &OnMachine<'_>) -> Result<(), SettingError> {
    let disturbance = &on.process.disturbance;
    let twice = [
        (!disturbance.guideway.is_empty(), "process.disturbance.guideway", "EXZ, the straightness of Z"),
        (
            !disturbance.spindle_lobes.is_empty(),
            "process.disturbance.spindle_lobes",
            "EXC, the spindle's error motion",
        ),
    ];
    if let Some((_, key, name)) = twice.into_iter().find(|(set, ..)| *set) {
        let why = format!("stands beside [machine], which has it as {name}: leave one of them out");
        return Err(SettingError::at(key, why));
    }
    if on.is_recorded {
        let why =
            "frames are recorded (source): a simulated machine would change nothing; leave one of them out";
        return Err(SettingError::at("machine.file", why));
    }
    if on.part.probe.is_some() {
        let why = "a touch probe rides on the machine, too, and its errors do not reach the probe's touches yet: leave [machine] or [probe] out";
        return Err(SettingError::at("probe", why));
    }
    let tool_deg = on.process.bending.tool_deg;
    let right = "0 beside [machine]: its X points from the axis to the tool, and the head looks along its Y";
    require(tool_deg == 0.0, "process.bending.tool_deg", tool_deg, right)
}

/// Least and largest radius of a part, mm.
fn radii_mm(part: &LoopJob) -> [f64; 2] {
    let stock = part.part.stock_diameter_mm;
    let drawn = part.contour.iter().map(|p| p.diameter_mm);
    let least = drawn.chain(part.part.nominal_diameter_mm.iter().copied()).fold(stock, f64::min);
    [0.5 * least, 0.5 * stock]
}

/// Refuses a part that the tool does not reach in the travels: beyond them no error is given.
fn check_travels(machine: &MachineSettings, part: &LoopJob) -> Result<(), SettingError> {
    let [from, to] = machine.z_travel_mm;
    let length = part.part.length_mm;
    let right = format!(
        "within {from} to {to} mm with its chuck face at 0, the travel of Z (z_travel_mm of the machine): beyond it no error is given"
    );
    require(from <= 0.0 && length <= to, "part.length_mm", length, &right)?;
    let [from, to] = machine.x_travel_mm;
    let right = format!(
        "such that its radius lies in {from} to {to} mm, the travel of X (x_travel_mm of the machine)"
    );
    let [least, stock] = radii_mm(part).map(|radius| 2.0 * radius);
    require((from..=to).contains(&(0.5 * stock)), "part.stock_diameter_mm", stock, &right)?;
    require((from..=to).contains(&(0.5 * least)), "part.nominal_diameter_mm", least, &right)?;
    let tip = machine.tip_above_axis_mm;
    let right = format!("closer to the axis than half the part's least radius, {} mm", 0.5 * least);
    require(tip.abs() <= 0.25 * least, "machine.stated.tip_above_axis_mm", tip, &right)
}

impl RunMachine {
    /// Whether the head reaches every field of the scan within the travel of Z.
    ///
    /// # Errors
    /// Names the field.
    pub(crate) fn check_fields(&self, part: &LoopJob) -> Result<(), SettingError> {
        let machine = self.needed()?;
        let beside = machine.head_beside_tool_mm();
        let [from, to] = machine.z_travel_mm;
        check_known(part)?;
        let out = |z: &f64| !(from..=to).contains(&(z - beside));
        let Some(z_mm) = part.scan_plan().field_z_mm.into_iter().find(out) else { return Ok(()) };
        let why = format!(
            "the field at z = {z_mm:.3} mm needs Z at {:.3} mm, outside its travel from {from} to {to} mm: the head stands {beside} mm beside the tool (head_mm less tool_mm along z)",
            z_mm - beside
        );
        Err(SettingError::at("machine.stated.z_travel_mm", why))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_of_a_stated_machine_names_its_place_in_the_job() {
        let error = in_stated(SettingError::of("machine.tool_mm[0]", 1e9, "less"));
        assert_eq!(error.to_string(), "machine.stated.tool_mm[0] = 1000000000: must be less");
        let other = SettingError::at("part.length_mm", "no");
        assert_eq!(in_stated(other.clone()), other);
    }
}
