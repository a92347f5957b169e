//! The TOML of `shadowgauge calibrate`.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::gauge::calibration::{CertificateShare, Conditions, Date, LensLimits, Thermometer};
use crate::gauge::{EsfModel, GaugeSettings, MasterCertificate};
use crate::job::{Job, NominalEdge};
use crate::render::contamination::Contamination;
use crate::render::motion::Motion;
use crate::render::settings::{Camera, Light, Optics, Sensor, SetupDeviations, SetupSettings};
use crate::setting::{SettingError, positive};
use crate::source::Channel;

/// Frames of a pin at one place in the field.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Position {
    /// Folder or file with its frames, relative to the TOML file; none where frames are simulated
    /// or taken with a camera (`source`).
    pub frames: Option<PathBuf>,
    /// Distance of the pin's axis from the plane of the masters, towards the camera, mm: from the
    /// slide on which it lies.
    pub y_mm: f64,
    /// Height of the pin's axis in the field, mm, for a simulated pin; that of a recorded one is
    /// measured.
    pub height_mm: f64,
}

/// A pin with its certificate and its frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PinPlan {
    /// Name in budgets and reports.
    pub name: String,
    /// Certified diameter at 20 °C, mm.
    pub diameter_mm: f64,
    /// Expanded uncertainty U of the certificate, mm.
    pub expanded_u_mm: f64,
    /// Coverage factor k of U.
    #[serde(default = "crate::gauge::calibration::masters::two")]
    pub coverage_factor: f64,
    /// Laboratory, reference standard or instrument on which other pins' certificates depend as
    /// well: with `common_expanded_u_mm`.
    #[serde(default)]
    pub certified_by: Option<String>,
    /// Part of U that the certificates of one `certified_by` share, mm, at the same k: 0 where they
    /// are independent, U where one error is in all of them. A correlation coefficient r of
    /// certificates with one U is √r·U here.
    #[serde(default)]
    pub common_expanded_u_mm: Option<f64>,
    /// Positions at which it was recorded, one or more.
    pub positions: Vec<Position>,
}

impl PinPlan {
    /// Its certificate.
    pub(crate) fn certificate(&self) -> MasterCertificate {
        MasterCertificate {
            diameter_mm: self.diameter_mm,
            expanded_u_mm: self.expanded_u_mm,
            coverage_factor: self.coverage_factor,
        }
    }

    /// The part of its certificate that is common with others.
    pub(crate) fn common(&self) -> Option<CertificateShare> {
        let certified_by = self.certified_by.clone()?;
        self.common_expanded_u_mm.map(|u| CertificateShare { certified_by, u_mm: u / self.coverage_factor })
    }
}

/// A flat-field exposure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FlatPlan {
    /// Folder with its frames, two or more; none where frames are simulated or taken with a camera.
    #[serde(default)]
    pub frames: Option<PathBuf>,
    /// Exposure in any unit proportional to the light. A camera (`source`) takes the largest with
    /// its own exposure time, and the others with that share of it.
    pub exposure: f64,
}

/// Dark and flat fields.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Fields {
    /// Folder with dark frames, two or more.
    pub dark: Option<PathBuf>,
    /// Flat fields: one exposure determines defects and light, three or more also the sensor's gain
    /// and noise.
    pub flats: Vec<FlatPlan>,
}

/// An optical setup to be rendered in place of recorded frames: its true values are drawn by seed
/// about these. `render` of the same file draws the same optical setup.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct SimulatedPlan {
    /// Seed of everything drawn.
    pub seed: u64,
    /// Frames of each position and exposure.
    pub frames_each: usize,
    /// A job's config beside this file: its optical setup and seed, exactly as `render` and `run`
    /// draw them, in place of the tables below.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub config: Option<PathBuf>,
    /// Pins are laid obliquely in the image plane by up to this, mrad. 0 ..= 100.
    pub limit_tilt_mrad: f64,
    /// Pins are displaced from their heights by up to this, mm. 0 ..= 10.
    pub limit_height_mm: f64,
    /// Camera geometry.
    pub camera: Camera,
    /// Lens.
    pub optics: Optics,
    /// Backlight.
    pub light: Light,
    /// Sensor.
    pub sensor: Sensor,
    /// What moves during an exposure.
    pub motion: Motion,
    /// Contamination of window, air and shaft.
    pub contamination: Contamination,
    /// How far the true optical setup may lie from these values.
    pub departures: SetupDeviations,
    /// Whether the lens is exactly the config's, as for a job. Otherwise its distortion, keystone
    /// and telecentricity are drawn about it within the limits of the data sheet.
    #[serde(skip)]
    pub lens_as_configured: bool,
}

impl Default for SimulatedPlan {
    fn default() -> Self {
        Self {
            seed: 1,
            frames_each: 2,
            config: None,
            limit_tilt_mrad: 0.3,
            limit_height_mm: 0.02,
            camera: Camera::default(),
            optics: Optics::default(),
            light: Light::default(),
            sensor: Sensor::default(),
            motion: Motion::default(),
            contamination: Contamination::default(),
            departures: SetupDeviations::default(),
            lens_as_configured: false,
        }
    }
}

impl SimulatedPlan {
    /// The optical setup's settings.
    pub(crate) fn setup(&self) -> SetupSettings {
        SetupSettings {
            camera: self.camera.clone(),
            optics: self.optics.clone(),
            light: self.light.clone(),
            sensor: self.sensor.clone(),
            motion: self.motion.clone(),
            contamination: self.contamination.clone(),
            departures: self.departures.clone(),
        }
    }

    /// The optical setup and seed of a job in place of its own.
    #[must_use]
    pub(crate) fn before_setup_of(&self, job: &Job) -> Self {
        let SetupSettings { camera, optics, light, sensor, motion, contamination, departures } =
            job.setup_settings();
        Self {
            seed: job.seed,
            config: None,
            camera,
            optics,
            light,
            sensor,
            motion,
            contamination,
            departures,
            lens_as_configured: true,
            ..self.clone()
        }
    }

    /// Whether it has no tables for an optical setup of its own.
    pub(crate) fn has_no_setup(&self) -> bool {
        self.setup() == SetupSettings::default()
    }

    fn check(&self) -> Result<(), SettingError> {
        if let Some(config) = &self.config {
            let beside = "was not read: a calibration is loaded from a file to find the config it names";
            return Err(SettingError::at("simulate.config", format!("{}: {beside}", config.display())));
        }
        self.setup().check().map_err(|e| SettingError::at("simulate", e.to_string()))?;
        if !(1..=1000).contains(&self.frames_each) {
            return Err(SettingError::at("simulate.frames_each", "must be 1 to 1000"));
        }
        if !(0.0..=100.0).contains(&self.limit_tilt_mrad) {
            return Err(SettingError::at("simulate.limit_tilt_mrad", "must be 0 to 100 mrad"));
        }
        if !(0.0..=10.0).contains(&self.limit_height_mm) {
            return Err(SettingError::at("simulate.limit_height_mm", "must be 0 to 10 mm"));
        }
        Ok(())
    }
}

/// A calibration to be made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CalibrationPlan {
    /// Identity of camera, lens, light and their adjustment: frames of other optics are refused.
    pub optics_id: String,
    /// Channel of colour frames that is measured; without it red, green and blue must be equal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<Channel>,
    /// Camera that the frames are taken with, `gige:IP` or `gige:NAME` (serial number or
    /// user-defined name), in place of folders: each pin, dark and flat are asked for in turn, or
    /// the published head places them itself. The calibration is bound to the camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// Frames that a camera (`source`) takes of each position and field; 8 unless given. 2 ..=
    /// 1000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames_each: Option<usize>,
    /// Day of the recording, "YYYY-MM-DD".
    #[schemars(with = "String")]
    pub date: Date,
    /// Days the calibration is valid.
    #[serde(default = "a_year")]
    pub valid_days: u32,
    /// Limits of the lens by its data sheet.
    #[serde(default)]
    pub lens: LensLimits,
    /// Temperature of the masters.
    #[serde(default = "Thermometer::unstated")]
    pub thermometer: Thermometer,
    /// Conditions of use, stored in the calibration file.
    #[serde(default = "Conditions::unstated")]
    pub conditions: Conditions,
    /// Dark and flat fields.
    #[serde(default)]
    pub fields: Fields,
    /// Two masters of different diameter or more.
    pub masters: Vec<PinPlan>,
    /// A pin that is not part of the fit and verifies it.
    pub check: Option<PinPlan>,
    /// The gauge.
    #[serde(default)]
    pub gauge: GaugeSettings,
    /// Renders the pins in place of recorded frames.
    pub simulate: Option<SimulatedPlan>,
}

/// Frames of a position unless stated: their mean has a third of the noise of one.
const FRAMES_EACH: usize = 8;

/// Why a folder is refused where a camera takes the frames.
const BESIDE_SOURCE: &str = "names a folder beside `source`, which takes the frames: leave one of them out";

fn a_year() -> u32 {
    365
}

impl CalibrationPlan {
    /// The calibration of a job's own optical setup on its own master pins, each at three heights
    /// of the field.
    pub(crate) fn of_job(job: &Job, date: Date) -> Self {
        let pin = |(index, pin): (usize, &MasterCertificate)| {
            let room_mm = 0.3 * (0.97 * job.loop_job().field.height_mm() - pin.diameter_mm).max(0.0);
            PinPlan {
                name: format!("masters.pins[{index}], {} mm", pin.diameter_mm),
                diameter_mm: pin.diameter_mm,
                expanded_u_mm: pin.expanded_u_mm,
                coverage_factor: pin.coverage_factor,
                certified_by: None,
                common_expanded_u_mm: None,
                positions: [-room_mm, 0.0, room_mm]
                    .map(|height_mm| Position { height_mm, ..Position::default() })
                    .to_vec(),
            }
        };
        let frames_each = job.masters.frames_each;
        let simulate = SimulatedPlan { frames_each, ..SimulatedPlan::default() }.before_setup_of(job);
        Self {
            optics_id: job.name.clone(),
            channel: None,
            source: None,
            frames_each: None,
            date,
            valid_days: a_year(),
            lens: LensLimits::default(),
            thermometer: Thermometer::default(),
            conditions: Conditions::default(),
            fields: Fields::default(),
            masters: job.masters.pins.iter().enumerate().map(pin).collect(),
            check: None,
            gauge: job.gauge.clone(),
            simulate: Some(simulate),
        }
    }

    /// The plan with the truth of a rendered setup: temperature and finish are exact where
    /// `[simulate]` draws them and the plan does not state them.
    #[must_use]
    pub(crate) fn settled(&self) -> Self {
        if self.simulate.is_none() {
            return self.clone();
        }
        Self {
            thermometer: self.thermometer.known(),
            conditions: self.conditions.known(),
            gauge: self.gauge_of_optics(),
            ..self.clone()
        }
    }

    /// The gauge with the edge-spread function of `[simulate]`'s optics where it requests that;
    /// unchanged where the optics have none, which a gauge refuses.
    fn gauge_of_optics(&self) -> GaugeSettings {
        let setup = match &self.simulate {
            Some(simulate) if self.gauge.esf == (EsfModel::Optics {}) => simulate.setup(),
            _ => return self.gauge.clone(),
        };
        let radius_mm =
            self.masters.iter().map(|m| 0.5 * m.diameter_mm).sum::<f64>() / self.masters.len().max(1) as f64;
        let pixel_mm = setup.nominal_pixel_mm();
        let edge = NominalEdge::new(&setup.optics, pixel_mm, radius_mm, 0.0);
        edge.map_or_else(
            |_| self.gauge.clone(),
            |edge| GaugeSettings { esf: edge.model(1e3 * pixel_mm), ..self.gauge.clone() },
        )
    }

    /// Checks the keys and conditions across them.
    ///
    /// # Errors
    /// Names the key and what would be right.
    pub(crate) fn validate(&self) -> Result<(), SettingError> {
        self.lens.validate()?;
        self.thermometer.validate()?;
        self.conditions.validate()?;
        self.gauge.validate()?;
        if self.optics_id.trim().is_empty() {
            return Err(SettingError::at(
                "optics_id",
                "is empty; name camera, lens and light, so that no others pass for them",
            ));
        }
        if self.valid_days == 0 {
            return Err(SettingError::at("valid_days", "must be at least 1"));
        }
        if self.masters.len() < 2 {
            return Err(SettingError::at(
                "masters",
                "scale and edge offset need two pins of different diameter",
            ));
        }
        for (index, pin) in self.masters.iter().enumerate() {
            self.check_pin(&format!("masters[{index}]"), pin)?;
        }
        if let Some(pin) = &self.check {
            self.check_pin("check", pin)?;
        }
        let diameters = || self.masters.iter().map(|pin| pin.diameter_mm);
        let (least, most) = (diameters().fold(f64::INFINITY, f64::min), diameters().fold(0.0, f64::max));
        if most - least < 0.01 * most {
            return Err(SettingError::at(
                "masters",
                format!(
                    "{least} to {most} mm: must differ by 1 % in diameter to separate scale from edge offset"
                ),
            ));
        }
        self.check_source()?;
        if self.simulate.is_none() && self.source.is_none() {
            if self.fields.dark.is_none() && !self.fields.flats.is_empty() {
                return Err(SettingError::at(
                    "fields.dark",
                    "is missing; flat fields need dark frames beside them",
                ));
            }
            if let Some(index) = self.fields.flats.iter().position(|f| f.frames.is_none()) {
                return Err(SettingError::at(
                    format!("fields.flats[{index}].frames"),
                    "is missing; give the folder, or a [simulate] table",
                ));
            }
        }
        self.simulate.as_ref().map_or(Ok(()), SimulatedPlan::check)
    }

    /// The keys of a camera: no folder stands beside it.
    fn check_source(&self) -> Result<(), SettingError> {
        let Some(source) = &self.source else {
            return match self.frames_each {
                Some(_) => Err(SettingError::at(
                    "frames_each",
                    "is of a camera (source = \"gige:NAME\"): a folder has its frames, and [simulate] its own key",
                )),
                None => Ok(()),
            };
        };
        if source.strip_prefix("gige:").is_none_or(|name| name.trim().is_empty()) {
            let right = "\"gige:IP\" or \"gige:NAME\"; folders are named at the positions (frames)";
            return Err(SettingError::of("source", source, right));
        }
        if self.simulate.is_some() {
            let right = "stands beside [simulate]: frames are taken or rendered; leave one of them out";
            return Err(SettingError::at("source", right));
        }
        if !(2..=1000).contains(&self.frames_each()) {
            return Err(SettingError::of("frames_each", self.frames_each(), "2 to 1000"));
        }
        if self.fields.dark.is_some() {
            return Err(SettingError::at("fields.dark", BESIDE_SOURCE));
        }
        match self.fields.flats.iter().position(|flat| flat.frames.is_some()) {
            Some(index) => Err(SettingError::at(format!("fields.flats[{index}].frames"), BESIDE_SOURCE)),
            None => Ok(()),
        }
    }

    /// Frames that a camera takes of each position and field.
    pub(crate) fn frames_each(&self) -> usize {
        self.frames_each.unwrap_or(FRAMES_EACH)
    }

    fn check_pin(&self, key: &str, pin: &PinPlan) -> Result<(), SettingError> {
        let numbers = [
            ("diameter_mm", pin.diameter_mm),
            ("expanded_u_mm", pin.expanded_u_mm),
            ("coverage_factor", pin.coverage_factor),
        ];
        for (name, value) in numbers {
            positive(&format!("{key}.{name}"), value)?;
        }
        check_common(key, pin)?;
        if let Some(simulate) = &self.simulate {
            let setup = simulate.setup();
            let field_mm = f64::from(setup.camera.rows) * setup.nominal_pixel_mm();
            if pin.diameter_mm > 0.97 * field_mm {
                return Err(SettingError::at(
                    format!("{key}.diameter_mm"),
                    format!("a pin of {} mm does not fit the field of {field_mm:.2} mm", pin.diameter_mm),
                ));
            }
        }
        if pin.positions.is_empty() {
            return Err(SettingError::at(
                format!("{key}.positions"),
                "is empty; give one place in the field or more",
            ));
        }
        for (index, position) in pin.positions.iter().enumerate() {
            let at = format!("{key}.positions[{index}]");
            if !(position.y_mm.is_finite() && position.height_mm.is_finite()) {
                return Err(SettingError::at(at, "y_mm and height_mm must be finite"));
            }
            if self.source.is_some() && position.frames.is_some() {
                return Err(SettingError::at(format!("{at}.frames"), BESIDE_SOURCE));
            }
            if self.simulate.is_none() && self.source.is_none() && position.frames.is_none() {
                return Err(SettingError::at(
                    format!("{at}.frames"),
                    "is missing; give the folder of its frames, a camera (source = \"gige:NAME\"), or a [simulate] table to \
                     render them",
                ));
            }
        }
        Ok(())
    }
}

/// The common part of certificates needs both keys, and is at most U.
fn check_common(key: &str, pin: &PinPlan) -> Result<(), SettingError> {
    match (&pin.certified_by, pin.common_expanded_u_mm) {
        (None, None) => Ok(()),
        (Some(_), None) => Err(SettingError::at(
            format!("{key}.common_expanded_u_mm"),
            "is missing; say how much of U the certificates of one laboratory share (0 for none, U for all of it)",
        )),
        (None, Some(_)) => Err(SettingError::at(
            format!("{key}.certified_by"),
            "is missing; name the laboratory or standard that the certificates share",
        )),
        (Some(_), Some(u)) if (0.0..=pin.expanded_u_mm).contains(&u) => Ok(()),
        (Some(_), Some(u)) => Err(SettingError::at(
            format!("{key}.common_expanded_u_mm"),
            format!("{u} is not a part of expanded_u_mm = {}; right would be 0 to that", pin.expanded_u_mm),
        )),
    }
}
