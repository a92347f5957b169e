//! Whether a head can run a job: it has the features that a run commands, and its part, passes,
//! masters and frames are those of the job.

use thiserror::Error;

use crate::job::{LoopJob, ScanWhen};
use crate::setting::SettingError;
use crate::source::commanded::{CommandedHead, HeadError};

/// Features that a run commands or reads, besides those of every camera.
const FEATURES: [&str; 14] = [
    "CarriageZ",
    "FramesSent",
    "HeadFrame",
    "HeadMessage",
    "HeadObject",
    "MasterIndex",
    "PassNominalDiameter",
    "PassNumber",
    "PassOffset",
    "PassStation",
    "PassStationCount",
    "PassState",
    "SpindleAngle",
    "SpindleSpeed",
];

/// Largest difference of two lengths that are the same, mm: both sides compute them from the same
/// keys, so that only the last digits may differ.
const SAME_MM: f64 = 1e-9;

/// Why a head cannot run a job.
#[derive(Debug, Error)]
pub(crate) enum Unfit {
    /// The job, or the head that it names.
    #[error(transparent)]
    Job(#[from] SettingError),
    /// The head failed.
    #[error(transparent)]
    Head(#[from] HeadError),
}

/// Holds a head against a job; nothing is cut and no frame is taken.
///
/// # Errors
/// The key of the job that differs from the head, with what would be right; `source` for a head
/// that takes no passes; a head that is gone.
pub(crate) fn check(head: &mut dyn CommandedHead, job: &LoopJob) -> Result<(), Unfit> {
    check_job(job)?;
    check_features(head)?;
    check_camera(head, job)?;
    check_stations(head, job)?;
    check_passes(head, job)?;
    check_masters(head, job)
}

/// What no head on a wire can do.
fn check_job(job: &LoopJob) -> Result<(), SettingError> {
    if job.probe.is_some() {
        let right = "a head on the wire takes frames, and touches nothing: leave [probe] out";
        return Err(SettingError::at("probe", right));
    }
    if job.scan.when == ScanWhen::DuringCut {
        let right = "a head on the wire is looked at when the pass is cut: set \"after_pass\"";
        return Err(SettingError::at("scan.when", right));
    }
    if job.field.is_line {
        return Err(SettingError::at("camera.line", "the head has an area camera: leave it out"));
    }
    Ok(())
}

fn check_features(head: &dyn CommandedHead) -> Result<(), Unfit> {
    let missing: Vec<&str> = FEATURES.into_iter().filter(|name| head.value(name).is_none()).collect();
    if missing.is_empty() {
        return Ok(());
    }
    // a head that is gone has no feature either
    head.check()?;
    let (shown, more) = missing.split_at(missing.len().min(3));
    let more = if more.is_empty() { String::new() } else { format!(" and {} more", more.len()) };
    let names = format!("{}{more}", shown.join(", "));
    let right = "a run needs a head that cuts passes, as `shadowgauge publish CONFIG.toml` does; of a camera on a \
                 lathe give the folder with the frames of each pass, or look at it by `watch`";
    Err(SettingError::at("source", format!("this camera has no {names}: {right}")).into())
}

fn check_camera(head: &dyn CommandedHead, job: &LoopJob) -> Result<(), SettingError> {
    for (feature, key, own) in
        [("Width", "camera.columns", job.field.columns), ("Height", "camera.rows", job.field.rows)]
    {
        let found = head.number(feature).unwrap_or(f64::NAN);
        if found != f64::from(own) {
            let right = format!("{found}, the {feature} of the head; or set that to {own}");
            return Err(SettingError::of(key, own, right));
        }
    }
    let rpm = head.number("SpindleSpeed").unwrap_or(f64::NAN);
    if rpm != 0.0 {
        let right = "set it, motion.spindle_rpm of the published config, to 0";
        let why = format!("SpindleSpeed of the head is {rpm} rev/min, but frames are taken angle by angle");
        return Err(SettingError::at("source", format!("{why}: {right}")));
    }
    Ok(())
}

fn check_stations(head: &mut dyn CommandedHead, job: &LoopJob) -> Result<(), Unfit> {
    let own = job.station_z_mm();
    let found = head.number("PassStationCount").unwrap_or(f64::NAN);
    if found != own.len() as f64 {
        let why = format!("the job has {} stations, the head {found}", own.len());
        return Err(of_part("part.station_mm", &why).into());
    }
    for (station, z_mm) in own.iter().enumerate() {
        head.set("PassStation", &station.to_string())?;
        let found = head.number("PassStationZ").unwrap_or(f64::NAN);
        if !((found - z_mm).abs() <= SAME_MM) {
            let why = format!("station {} stands at z = {z_mm} mm, at the head at {found} mm", station + 1);
            return Err(of_part("part.station_mm", &why).into());
        }
    }
    Ok(())
}

fn check_passes(head: &mut dyn CommandedHead, job: &LoopJob) -> Result<(), Unfit> {
    const KEY: &str = "part.nominal_diameter_mm";
    for pass in 1..=job.passes() as u32 {
        let target_mm = job.part.target_mm(pass);
        match head.set("PassNumber", &pass.to_string()) {
            Err(HeadError::NotSet { .. }) => {
                let why = format!("the job has {} passes, the head has no pass {pass}", job.passes());
                return Err(of_part(KEY, &why).into());
            }
            set => set?,
        }
        let found = head.number("PassNominalDiameter").unwrap_or(f64::NAN);
        if !((found - target_mm).abs() <= SAME_MM) {
            let why = format!("pass {pass} aims at {target_mm} mm, at the head at {found} mm");
            return Err(of_part(KEY, &why).into());
        }
    }
    Ok(())
}

fn check_masters(head: &mut dyn CommandedHead, job: &LoopJob) -> Result<(), Unfit> {
    let Some(last) = job.masters.pins.len().checked_sub(1) else { return Ok(()) };
    match head.set("MasterIndex", &last.to_string()) {
        Err(HeadError::NotSet { .. }) => {
            let why = format!("the job has {} pins, the head has no pin {}", last + 1, last + 1);
            Err(of_part("masters.pins", &why).into())
        }
        set => Ok(set?),
    }
}

fn of_part(key: &str, why: &str) -> SettingError {
    SettingError::at(key, format!("{why}: publish the config that is run"))
}
