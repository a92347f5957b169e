//! A head as it is studied: a plain cylinder of the asked diameter before the camera, optics, light
//! and sensor of a config.

use super::bound::GreyLevels;
use super::edge::EdgeOptics;
use super::error::HeadError;
use super::range::DiameterRange;
use super::settings::HeadSettings;
use crate::gauge::calibration::Conditions;
use crate::gauge::{EdgeRoom, EsfModel, GaugeSettings, MasterCertificate};
use crate::job::{Job, NominalEdge, ScanWhen};
use crate::render::contamination::Contamination;
use crate::render::motion::Motion;
use crate::render::settings::{Esf, Sensor};
use crate::setting::SettingError;
use crate::shaft::{Lobe, ShaftForm};

/// Columns that stand for a line camera's readings: a block of so many of a part that is at rest
/// is a frame whose columns are its readings.
const READINGS: u32 = 256;

/// Eccentricity of a part where its config has none, mm: half of the 20 µm of total run-out that
/// collets of good make are sold with.
const ECCENTRICITY_MM: f64 = 0.01;

/// Masters where the config names none: shares of the diameter, and U (k = 2), mm, of the
/// program's own default pins.
const MASTERS: [f64; 2] = [0.9, 1.1];

/// A pitch that differs by more from the sensor's own contradicts it: data sheets give it to 0.01
/// µm.
const SAME_PITCH: f64 = 0.005;

/// A head's config: its job, and what it is called in tables.
#[derive(Clone, Debug)]
pub(crate) struct HeadConfig {
    /// Name in tables.
    pub(crate) name: String,
    /// The file.
    pub(crate) file: String,
    /// Its job, as `render` takes it.
    pub(crate) job: Job,
}

impl HeadConfig {
    /// Diameter of its part, mm: the largest of its contour, otherwise the finished part's.
    pub(crate) fn diameter_mm(&self) -> f64 {
        let contour = self.job.shaft.contour.iter().map(|corner| corner.diameter_mm);
        contour.reduce(f64::max).unwrap_or_else(|| self.job.part.drawn_diameter_mm())
    }
}

/// How the part turns before the head.
#[derive(Clone, Debug)]
pub(super) struct Turning {
    /// Speed of the spindle in use, rev/min; 0 at rest.
    pub(super) rpm: f64,
    /// Offset of the part's axis from that of rotation, mm: half of its total run-out.
    pub(super) eccentricity_mm: f64,
    /// Feed along z, mm a revolution.
    pub(super) feed_mm_per_rev: f64,
    /// Time for which light is collected, µs.
    pub(super) exposure_us: f64,
    /// Lobes of the config's shaft.
    pub(super) lobes: Vec<Lobe>,
}

/// A head before a part.
pub(crate) struct HeadSetup {
    pub(super) config: HeadConfig,
    /// The job with the plain part, at rest, before a clean window.
    pub(super) job: Job,
    pub(super) diameter_mm: f64,
    /// The gauge with the edge of these optics.
    pub(super) gauge: GaugeSettings,
    pub(super) room: EdgeRoom,
    pub(super) levels: GreyLevels,
    pub(super) optics: EdgeOptics,
    pub(super) turning: Turning,
    pub(super) range: DiameterRange,
    pub(super) conditions: Conditions,
    /// What was assumed.
    pub(super) notes: Vec<String>,
}

impl HeadSetup {
    /// A head before a part of the settings' diameter, otherwise its config's.
    ///
    /// # Errors
    /// Settings that contradict each other, a part that the head cannot have in its field.
    pub(crate) fn new(config: &HeadConfig, settings: &HeadSettings) -> Result<Self, HeadError> {
        check_pitch(&config.job)?;
        let diameter_mm = settings.diameter_mm.unwrap_or_else(|| config.diameter_mm());
        let mut notes = Vec::new();
        let turning = turning(&config.job, settings, &mut notes);
        let mut job = at_rest(&config.job, diameter_mm, &mut notes);
        let gauge = own_gauge(&job, diameter_mm)?;
        let pixel_mm = job.setup_settings().nominal_pixel_mm();
        let room = EdgeRoom::of(&gauge, gaussian_px(&job));
        let range = DiameterRange::of(&job, &room, turning.eccentricity_mm);
        range.check(&job, diameter_mm)?;
        // A wire is measured where the settings allow it: here the diameter is asked for.
        job.gauge.min_diameter_px = job.gauge.min_diameter_px.min(0.8 * diameter_mm / pixel_mm);
        let gauge = GaugeSettings { min_diameter_px: job.gauge.min_diameter_px, ..gauge };
        gauge.validate()?;
        masters(&mut job, diameter_mm, &range, &mut notes);
        let conditions = conditions(&job, settings, turning.eccentricity_mm);
        if settings.conditions.is_none() && conditions.limit_temperature_k == 0.0 {
            notes.push(
                "the part's temperature and finish taken as exact: --conditions FILE states limits"
                    .to_owned(),
            );
        }
        let optics = EdgeOptics { optics: job.optics.clone(), pixel_mm, radius_mm: 0.5 * diameter_mm };
        let levels = GreyLevels::of(&job.setup_settings());
        let config = config.clone();
        Ok(Self { config, job, diameter_mm, gauge, room, levels, optics, turning, range, conditions, notes })
    }

    /// Diameter of the part, mm.
    pub(crate) fn diameter_mm(&self) -> f64 {
        self.diameter_mm
    }

    /// Diameters of the masters, mm.
    pub(crate) fn masters_mm(&self) -> Vec<f64> {
        self.job.masters.pins.iter().map(|pin| pin.diameter_mm).collect()
    }

    /// Nominal size of a pixel on the part, µm.
    pub(super) fn um_per_px(&self) -> f64 {
        1e3 * self.optics.pixel_mm
    }

    /// Pixels either side of an edge that its window holds.
    pub(super) fn half_px(&self) -> usize {
        self.room.beside_px as usize
    }

    /// The same of the longest window.
    pub(super) fn most_half_px(&self) -> usize {
        self.room.most_beside_px as usize
    }
}

/// Refuses a pitch that is not that of the sensor named beside it.
fn check_pitch(job: &Job) -> Result<(), SettingError> {
    let Some((preset, pitch_um)) = job.sensor.preset.map(|p| (p, p.pixel_um())) else { return Ok(()) };
    let stated_um = job.camera.pixel_um;
    if (stated_um / pitch_um - 1.0).abs() <= SAME_PITCH {
        return Ok(());
    }
    let name = serde_json::to_string(&preset).unwrap_or_default();
    Err(SettingError::at(
        "camera.pixel_um",
        format!(
            "{stated_um} µm contradicts sensor.preset = {name}, whose pixels are {pitch_um} µm: write pixel_um = {pitch_um}, or \
             give the sensor's own figures in place of the preset"
        ),
    ))
}

/// The part at rest, plain and clean, before an area camera.
fn at_rest(given: &Job, diameter_mm: f64, notes: &mut Vec<String>) -> Job {
    let mut job = given.clone();
    job.part.nominal_diameter_mm = vec![diameter_mm];
    job.part.stock_diameter_mm = diameter_mm;
    job.shaft = ShaftForm::default();
    job.contamination = Contamination::default();
    job.motion = Motion { strobe: given.motion.strobe, ..Motion::default() };
    if job.camera.line.take().is_some() {
        job.camera.columns = READINGS;
        notes.push(format!("a frame is {READINGS} readings of the line camera"));
    }
    job
}

/// The gauge of a job with the edge of its optics.
fn own_gauge(job: &Job, diameter_mm: f64) -> Result<GaugeSettings, HeadError> {
    let esf = match &job.optics.esf {
        Esf::Gaussian(_) if job.optics.reflection.is_none() => EsfModel::Gaussian {},
        _ => {
            let pixel_mm = job.setup_settings().nominal_pixel_mm();
            NominalEdge::new(&job.optics, pixel_mm, 0.5 * diameter_mm, 0.0)?.model(1e3 * pixel_mm)
        }
    };
    Ok(GaugeSettings { esf, ..job.gauge.clone() })
}

/// The blur of Gaussian optics, px; 1 for others, whose table has its own.
fn gaussian_px(job: &Job) -> f64 {
    match &job.optics.esf {
        Esf::Gaussian(g) => g.sigma_px,
        _ => 1.0,
    }
}

/// How the part turns: the settings' speed, otherwise the config's motion or, where it is scanned
/// during the cut, its cutting speed; otherwise at rest.
fn turning(job: &Job, settings: &HeadSettings, notes: &mut Vec<String>) -> Turning {
    let cut_rpm = match job.scan.when {
        ScanWhen::DuringCut => job.loop_job().spindle_rpm(job.part.passes() as u32),
        ScanWhen::AfterPass => 0.0,
    };
    let of_config = if job.motion.spindle_rpm == 0.0 { cut_rpm } else { job.motion.spindle_rpm.abs() };
    let synchronous = job.shaft.spindle.synchronous.iter().map(|h| 1e-3 * h.x_um.hypot(h.y_um)).sum::<f64>();
    let stated = job.shaft.eccentricity.amplitude_mm.abs() + job.shaft.bow.sagitta_mm.abs() + synchronous;
    let eccentricity_mm = settings.eccentricity_mm.unwrap_or_else(|| {
        if stated > 0.0 {
            return stated;
        }
        notes.push(format!("no run-out in the config: eccentricity of {ECCENTRICITY_MM} mm assumed"));
        ECCENTRICITY_MM
    });
    Turning {
        rpm: settings.rpm.unwrap_or(of_config),
        eccentricity_mm,
        feed_mm_per_rev: job.cutting.feed_mm_per_rev,
        exposure_us: job.motion.light_time(job.camera.exposure_us).length_us,
        lobes: job.shaft.lobes.clone(),
    }
}

/// Pins about the diameter, in the field, where the config names none.
fn masters(job: &mut Job, diameter_mm: f64, range: &DiameterRange, notes: &mut Vec<String>) {
    let default = Job::default().masters;
    if job.masters.pins != default.pins {
        return;
    }
    let u_mm = default.pins[0].expanded_u_mm;
    job.masters.pins = MASTERS
        .map(|share| MasterCertificate {
            diameter_mm: rounded((share * diameter_mm).clamp(range.smallest_mm, range.largest_mm)),
            expanded_u_mm: u_mm,
            coverage_factor: default.pins[0].coverage_factor,
        })
        .to_vec();
    let [small, large] = [0, 1].map(|k: usize| job.masters.pins[k].diameter_mm);
    notes.push(format!(
        "no masters in the config: pins of {small:.4} and {large:.4} mm with U = {} µm (k = 2) assumed",
        1e3 * u_mm
    ));
}

/// To a tenth of a µm: what a pin is ordered to.
fn rounded(mm: f64) -> f64 {
    (1e4 * mm).round() / 1e4
}

/// Conditions of the part: those given, otherwise the config's; where no limits of its distance
/// from the plane of focus are stated, the eccentricity, by which a turning part leaves it.
fn conditions(job: &Job, settings: &HeadSettings, eccentricity_mm: f64) -> Conditions {
    let of_part = job.loop_job().part_conditions();
    let mut conditions = settings.conditions.as_ref().map_or(of_part, |given| given.over(&of_part));
    if settings.conditions.as_ref().is_none_or(|given| given.limit_axis_y_mm.is_none()) {
        conditions.limit_axis_y_mm = eccentricity_mm;
    }
    conditions
}

/// Whether the bright field fills the well or the scale: its noise is no longer that of photons.
pub(super) fn clips(sensor: &Sensor, levels: &GreyLevels) -> bool {
    let full = f64::from(sensor.format.full_scale().unwrap_or(u16::MAX));
    let well = sensor.black_level_counts + sensor.full_well_e / sensor.electrons_per_count;
    levels.light >= full.min(well)
}
