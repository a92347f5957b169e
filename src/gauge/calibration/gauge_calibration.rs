//! From pixels to millimetres: scale and edge offset from master pins of certified diameter.
//!
//! ```text
//! D = s·w + o
//! w  shadow width across the axis, px;  s  scale, mm/px;  o  offset of both edges together, mm
//! ```
//!
//! Weighted least squares over the masters with variances u_cert² + (s·u_w)²; the covariance of (s,
//! o) is kept with the result, so that u_common² = w²·var(s) + 2w·cov(s, o) + var(o) grows towards
//! diameters outside those of the masters.

use std::io::Read;

use serde::{Deserialize, Serialize};

use super::adjusted::Adjusted;
use super::axis_zero::AxisZero;
use super::conditions::Conditions;
use super::error::{CALIBRATION_VERSION, CalibrationError, CalibrationLimits};
use super::masters::{MasterFigure, MasterMeasurement};
use super::optical_setup::SetupCalibration;
use crate::frame::{CameraBinding, Encoding};
use crate::gauge::edge::model::edge_table::EdgeTable;
use crate::gauge::edge::model::systematic_residual::SystematicResidual;
use crate::gauge::edges::FrameFigures;
use crate::gauge::settings::EsfModel;

/// Scale and edge offset with their covariance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Version of the format.
    pub version: u32,
    /// What was calibrated: camera, lens, light and their setting.
    pub optics_id: String,
    /// Scale s, mm/px.
    pub scale_mm_per_px: f64,
    /// Offset o of both edges together, mm, added to s·w.
    pub offset_mm: f64,
    /// Covariance of (s, o): var(s), cov, var(o), in mm²/px², mm²/px, mm².
    pub covariance: [f64; 3],
    /// Edge-spread function that was fitted to the masters' edges (`EsfModel::name`): the offset
    /// holds for it alone. `None` where no master was seen, and in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge_model: Option<String>,
    /// How the files of its frames encoded light: the offset holds for it alone, since an encoding
    /// that is not quite what the file states moves the edges of masters and parts alike. `None`
    /// where no frame was seen, and in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub encoding: Option<Encoding>,
    /// The masters it was made from.
    pub masters: Vec<MasterFigure>,
    /// Lens, sensor, validity and every source's share, where `calibrate` made it.
    #[serde(rename = "bench", default, skip_serializing_if = "Option::is_none")]
    pub setup: Option<Box<SetupCalibration>>,
    /// What the masters' edges left of the edge model, where it was more than noise: its share of
    /// the edge offset is in `offset_mm`.
    #[serde(rename = "misfit", default, skip_serializing_if = "Option::is_none")]
    pub systematic_residual: Option<Box<SystematicResidual>>,
    /// The edge-spread function fitted, where it was given as a table (`edge_model` = "table").
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge_table: Option<Box<EdgeTable>>,
    /// Conditions of use that were known when it was made without an optical setup (a run's own);
    /// none where none were stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conditions: Option<Box<Conditions>>,
    /// The camera that its frames were taken with, as it was set; `None` where they came from
    /// files or a simulation, and in files of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<Box<CameraBinding>>,
}

/// The version of a file, whatever else is in it.
#[derive(Deserialize)]
struct StatedVersion {
    version: u32,
}

impl Calibration {
    /// Weighted least squares over two masters or more and all their frames.
    ///
    /// # Errors
    /// Refuses fewer than two masters, masters of one size or not seen, and impossible
    /// certificates.
    pub fn fit(masters: &[MasterMeasurement]) -> Result<Self, CalibrationError> {
        let figures: Result<Vec<MasterFigure>, CalibrationError> =
            masters.iter().map(|m| MasterFigure::from_edges(m.certificate, &m.frames)).collect();
        Self::fit_figures(&figures?)
    }

    /// As [`Self::fit`], from mean shadows.
    ///
    /// # Errors
    /// As [`Self::fit`].
    pub(crate) fn fit_figures(masters: &[MasterFigure]) -> Result<Self, CalibrationError> {
        if masters.len() < 2 {
            return Err(CalibrationError::TooFew { found: masters.len() });
        }
        for (index, master) in masters.iter().enumerate() {
            master.certificate.check(index)?;
        }
        check_spread(masters)?;
        let mut scale = masters[0].certificate.diameter_mm / masters[0].width_px;
        let mut fit = LineFit::default();
        // The weights depend on the scale by less than a per mille of themselves: two rounds are
        // enough.
        for _ in 0..3 {
            fit = LineFit::through(masters, scale);
            scale = fit.scale;
        }
        Ok(Self {
            scale_mm_per_px: fit.scale,
            offset_mm: fit.offset,
            covariance: fit.covariance,
            masters: masters.to_vec(),
            ..Self::from_scale(1.0)
        })
    }

    /// From an optical setup's adjustment.
    pub(crate) fn of_setup(adjusted: &Adjusted, masters: Vec<MasterFigure>, setup: SetupCalibration) -> Self {
        let sum = |i: usize, j: usize| setup.parts.iter().map(|p| p.matrix[i][j]).sum::<f64>();
        Self {
            scale_mm_per_px: adjusted.parameters[0],
            offset_mm: adjusted.parameters[1],
            covariance: [sum(0, 0), sum(0, 1), sum(1, 1)],
            masters,
            setup: Some(Box::new(setup)),
            ..Self::from_scale(1.0)
        }
    }

    /// Keeps the systematic residual of the masters' edges.
    #[must_use]
    pub(crate) fn with_systematic_residual(self, systematic_residual: Option<SystematicResidual>) -> Self {
        Self { systematic_residual: systematic_residual.map(Box::new), ..self }
    }

    /// What the masters' edges left of the edge model, for
    /// [`crate::gauge::Gauge::with_systematic_residual`].
    pub(crate) fn systematic_residual(&self) -> Option<&SystematicResidual> {
        self.systematic_residual.as_deref()
    }

    /// Keeps the edge-spread function that was fitted to the masters' edges.
    #[must_use]
    pub(crate) fn with_edge_model(self, esf: &EsfModel) -> Self {
        let table = |samples| Box::new(EdgeTable::from_samples(samples, 1e3 * self.scale_mm_per_px));
        let edge_table = if let EsfModel::Table(samples) = esf { Some(table(samples)) } else { None };
        Self { edge_model: Some(esf.name().to_owned()), edge_table, ..self }
    }

    /// The edge-spread function that was fitted to the masters' edges; `None` where the file does
    /// not contain it in full.
    pub fn edge_model(&self) -> Option<EsfModel> {
        match (self.edge_model.as_deref(), &self.edge_table) {
            (Some("gaussian"), _) => Some(EsfModel::Gaussian {}),
            (Some("learnt"), _) => Some(EsfModel::Learnt {}),
            (Some("table"), Some(table)) => Some(EsfModel::Table(table.samples(1e3 * self.scale_mm_per_px))),
            _ => None,
        }
    }

    /// Refuses another edge-spread function than the masters': each gives another edge position,
    /// and the offset holds for one.
    ///
    /// # Errors
    /// Where both are known and differ.
    pub(crate) fn check_edge_model(&self, esf: &EsfModel) -> Result<(), CalibrationError> {
        match &self.edge_model {
            Some(calibrated) if calibrated != esf.name() => {
                Err(CalibrationError::OtherEdgeModel { calibrated: calibrated.clone(), asked: esf.name() })
            }
            _ => match (&self.edge_table, esf) {
                (Some(table), EsfModel::Table(asked))
                    if !table
                        .is_of_the_same_edge(&EdgeTable::from_samples(asked, 1e3 * self.scale_mm_per_px)) =>
                {
                    Err(CalibrationError::OtherEdgeTable)
                }
                _ => Ok(()),
            },
        }
    }

    /// Keeps how the files of its frames encoded light.
    #[must_use]
    pub(crate) fn with_encoding(self, encoding: Encoding) -> Self {
        Self { encoding: Some(encoding), ..self }
    }

    /// Refuses a frame whose file encoded light otherwise than those of the calibration's frames. A
    /// calibration of an earlier version took encoded values as they stood: for linear frames alone
    /// it still holds. A bare scale holds for all.
    ///
    /// # Errors
    /// Where both are known and differ.
    pub(crate) fn check_encoding(&self, found: Encoding) -> Result<(), CalibrationError> {
        let calibrated = match &self.encoding {
            Some(own) if own.is_same(&found) => return Ok(()),
            None if found.is_linear() || (self.masters.is_empty() && self.setup.is_none()) => return Ok(()),
            Some(own) => format!("was {own}"),
            None => "is not known (a calibration of an earlier version)".to_owned(),
        };
        Err(CalibrationError::OtherEncoding { found, calibrated })
    }

    /// Standard uncertainty of a width by the unknown place of its edges, px: where they were
    /// learnt and the masters' were not, or the other way round.
    pub(crate) fn u_position_px(&self, figures: &FrameFigures) -> f64 {
        if self.is_learnt() {
            figures.unlearnt_position_px() / 3.0_f64.sqrt()
        } else {
            figures.u_position_px()
        }
    }

    /// Whether the masters' edges were fitted by an edge-spread function estimated from their own
    /// frames.
    pub(crate) fn is_learnt(&self) -> bool {
        self.edge_model.as_deref() == Some("learnt")
    }

    /// Names the optics it belongs to.
    #[must_use]
    pub(crate) fn with_optics_id(self, optics_id: &str) -> Self {
        Self { optics_id: optics_id.to_owned(), ..self }
    }

    /// A bare scale without offset and uncertainty, as `--um-per-px` gives it.
    pub fn from_scale(um_per_px: f64) -> Self {
        Self {
            version: CALIBRATION_VERSION,
            optics_id: String::new(),
            scale_mm_per_px: um_per_px * 1e-3,
            offset_mm: 0.0,
            covariance: [0.0; 3],
            masters: Vec::new(),
            setup: None,
            systematic_residual: None,
            edge_model: None,
            edge_table: None,
            conditions: None,
            encoding: None,
            camera: None,
        }
    }

    /// Reads and checks a calibration file.
    ///
    /// # Errors
    /// Refuses what is no JSON of this version and what has impossible values.
    pub fn read(from: impl Read) -> Result<Self, CalibrationError> {
        let mut bytes = Vec::new();
        from.take(16 << 20).read_to_end(&mut bytes).map_err(serde_json::Error::io)?;
        let calibration: Self = serde_json::from_slice(&bytes).map_err(|error| {
            // a file of another version need not have the keys of this one
            match serde_json::from_slice::<StatedVersion>(&bytes) {
                Ok(StatedVersion { version }) if version != CALIBRATION_VERSION => {
                    CalibrationError::Version { found: version }
                }
                _ => error.into(),
            }
        })?;
        if calibration.version != CALIBRATION_VERSION {
            return Err(CalibrationError::Version { found: calibration.version });
        }
        let positive = "a scale above 0 in mm/px, at most 1000";
        let scale = calibration.scale_mm_per_px;
        if !(scale > 0.0 && scale <= 1e3) {
            return Err(CalibrationError::Value { key: "scale_mm_per_px", value: scale, right: positive });
        }
        let offset = calibration.offset_mm;
        if !(offset.abs() <= 1e3) {
            return Err(CalibrationError::Value {
                key: "offset_mm",
                value: offset,
                right: "a length within ± 1000 mm",
            });
        }
        let [vs, c, vo] = calibration.covariance;
        if !(vs >= 0.0 && vo >= 0.0 && c * c <= vs * vo * (1.0 + 1e-9)) {
            return Err(CalibrationError::Value {
                key: "covariance",
                value: c,
                right: "a positive semidefinite matrix",
            });
        }
        if let Some(value) = calibration.encoding.and_then(|e| e.impossible()) {
            let right = "shares of light from 0 to 1 that grow";
            return Err(CalibrationError::Value { key: "encoding.light_at_quarters", value, right });
        }
        let systematic_residual = calibration.systematic_residual.as_ref().and_then(|m| m.impossible());
        let table = calibration.edge_table.as_ref().and_then(|t| t.impossible());
        if let Some((key, value, right)) = systematic_residual.or(table) {
            return Err(CalibrationError::Value { key, value, right });
        }
        calibration.check_masters()?;
        calibration.check_setup()?;
        Ok(calibration)
    }

    /// The budget takes certificates and levers from the masters: missing information must not
    /// count as certainty.
    fn check_masters(&self) -> Result<(), CalibrationError> {
        let impossible = |key, value, right| Err(CalibrationError::Value { key, value, right });
        for (index, master) in self.masters.iter().enumerate() {
            master.certificate.check(index)?;
            let (width, u) = (master.width_px, master.u_width_px);
            if !(width > 0.0 && width.is_finite()) {
                return impossible("masters.width_px", width, "a width above 0 px");
            }
            if !(u >= 0.0 && u.is_finite()) {
                return impossible("masters.u_width_px", u, "0 px or more");
            }
        }
        if self.masters.is_empty() { Ok(()) } else { check_spread(&self.masters) }
    }

    fn check_setup(&self) -> Result<(), CalibrationError> {
        if let Some((key, value, right)) = self.setup.as_ref().and_then(|b| b.impossible()) {
            return Err(CalibrationError::Value { key, value, right });
        }
        self.conditions().validate().map_err(|e| CalibrationError::Setting(e.to_string()))
    }

    /// Refuses frames of other optics.
    ///
    /// # Errors
    /// Where the ids differ.
    pub fn check_optics(&self, optics_id: &str) -> Result<(), CalibrationError> {
        if self.optics_id == optics_id {
            Ok(())
        } else {
            Err(CalibrationError::OtherOptics {
                found: self.optics_id.clone(),
                expected: optics_id.to_owned(),
            })
        }
    }

    /// The calibration of the same optical setup for frames read column by column (a vertical
    /// shaft).
    #[must_use]
    pub(crate) fn transposed(&self) -> Self {
        Self { setup: self.setup.as_ref().map(|setup| Box::new(setup.transposed())), ..self.clone() }
    }

    /// Diameter of a width across the axis, mm.
    pub(crate) fn diameter_mm(&self, width_px: f64) -> f64 {
        self.scale_mm_per_px * width_px + self.offset_mm
    }

    /// Standard uncertainty that every reading of this width shares, mm.
    pub(crate) fn u_common_mm(&self, width_px: f64) -> f64 {
        let [vs, c, vo] = self.covariance;
        (width_px * width_px * vs + 2.0 * width_px * c + vo).max(0.0).sqrt()
    }

    /// Standard uncertainty of a size that changes by `by_scale_px` with the scale (mm/px) and by
    /// `by_offset` with the edge offset (mm), mm; all sizes of the calibration share it.
    pub(crate) fn u_of_size_mm(&self, by_scale_px: f64, by_offset: f64) -> f64 {
        let [vs, c, vo] = self.covariance;
        let variance =
            by_scale_px * by_scale_px * vs + 2.0 * by_scale_px * by_offset * c + by_offset * by_offset * vo;
        variance.max(0.0).sqrt()
    }

    /// Zero of the heights of an axis: the middle between the first and the last of `rows` rows, or
    /// the axis of the lens.
    pub(crate) fn axis_zero(&self, rows: f64) -> AxisZero {
        let height_mm = match self.setup {
            Some(_) => 0.0,
            None => -0.5 * (rows - 1.0) * self.scale_mm_per_px,
        };
        AxisZero { height_mm, u_scale: self.covariance[0].sqrt() / self.scale_mm_per_px }
    }

    /// Conditions of use that the calibration itself assumes; exact ones where it states none.
    pub fn conditions(&self) -> Conditions {
        match (&self.setup, &self.conditions) {
            (Some(setup), _) => setup.conditions,
            (None, Some(known)) => **known,
            (None, None) => Conditions::default(),
        }
    }

    /// Keeps the conditions of use of a calibration without an optical setup.
    #[must_use]
    pub(crate) fn with_conditions(self, conditions: Conditions) -> Self {
        Self { conditions: Some(Box::new(conditions)), ..self }
    }

    /// Whether it was made on masters and states no conditions of use.
    pub(crate) fn leaves_conditions_open(&self) -> bool {
        self.setup.is_none() && self.conditions.is_none() && !self.masters.is_empty()
    }
}

/// Whether the masters' widths differ enough to separate scale and edge offset.
fn check_spread(masters: &[MasterFigure]) -> Result<(), CalibrationError> {
    let calibration_limits = CalibrationLimits::get();
    let widths = || masters.iter().map(|m| m.width_px);
    let spread_px = widths().fold(f64::NEG_INFINITY, f64::max) - widths().fold(f64::INFINITY, f64::min);
    if spread_px >= calibration_limits.least_spread_px {
        Ok(())
    } else {
        Err(CalibrationError::SameSize { spread_px })
    }
}

#[derive(Default)]
struct LineFit {
    scale: f64,
    offset: f64,
    covariance: [f64; 3],
}

impl LineFit {
    fn through(masters: &[MasterFigure], scale: f64) -> Self {
        let weight = |m: &MasterFigure| 1.0 / (m.certificate.u_mm().powi(2) + (scale * m.u_width_px).powi(2));
        let total: f64 = masters.iter().map(weight).sum();
        let mean_w = masters.iter().map(|m| weight(m) * m.width_px).sum::<f64>() / total;
        let mean_d = masters.iter().map(|m| weight(m) * m.certificate.diameter_mm).sum::<f64>() / total;
        let square: f64 = masters.iter().map(|m| weight(m) * (m.width_px - mean_w).powi(2)).sum();
        let cross: f64 = masters
            .iter()
            .map(|m| weight(m) * (m.width_px - mean_w) * (m.certificate.diameter_mm - mean_d))
            .sum();
        let scale = cross / square;
        let variance = 1.0 / square;
        Self {
            scale,
            offset: mean_d - scale * mean_w,
            covariance: [variance, -mean_w * variance, 1.0 / total + mean_w * mean_w * variance],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::calibration::masters::MasterCertificate;

    fn master(diameter_mm: f64, width_px: f64, u: f64) -> MasterFigure {
        let certificate = MasterCertificate { diameter_mm, expanded_u_mm: 2.0 * u, coverage_factor: 2.0 };
        MasterFigure { certificate, width_px, u_width_px: 0.0 }
    }

    #[test]
    fn two_masters_are_met_exactly_and_uncertainty_is_theirs() {
        let (a, b) = (master(20.0, 1000.5, 3e-4), master(30.0, 1500.3, 4e-4));
        let calibration = Calibration::fit_figures(&[a, b]).unwrap();
        assert!((calibration.diameter_mm(1000.5) - 20.0).abs() < 1e-12);
        assert!((calibration.u_common_mm(1000.5) - 3e-4).abs() < 1e-10);
        assert!((calibration.u_common_mm(1500.3) - 4e-4).abs() < 1e-10);
        // Half-way between two independent masters.
        let half = 0.5 * (1000.5 + 1500.3);
        assert!((calibration.u_common_mm(half) - 2.5e-4).abs() < 1e-10);
    }

    #[test]
    fn bad_calibrations_are_refused_by_name() {
        let a = master(20.0, 1000.0, 3e-4);
        assert!(matches!(Calibration::fit_figures(&[a]), Err(CalibrationError::TooFew { found: 1 })));
        assert!(matches!(Calibration::fit_figures(&[a, a]), Err(CalibrationError::SameSize { .. })));
        let b = master(30.0, 1500.0, f64::NAN);
        assert!(matches!(
            Calibration::fit_figures(&[a, b]),
            Err(CalibrationError::Certificate { master: 2 })
        ));
        let good = Calibration::fit_figures(&[a, master(30.0, 1500.0, 3e-4)]).unwrap();
        let text = serde_json::to_string(&good).unwrap();
        let read = Calibration::read(text.as_bytes()).unwrap();
        assert!((read.diameter_mm(1200.0) - good.diameter_mm(1200.0)).abs() < 1e-12);
        assert!((read.u_common_mm(1200.0) - good.u_common_mm(1200.0)).abs() < 1e-12);
        assert!(!text.contains("misfit") && read.systematic_residual().is_none());
        let left =
            SystematicResidual { step_px: 0.125, residual: [vec![0.01; 5], vec![-0.02; 5]], chi2: 2.3 };
        let with = serde_json::to_string(&good.clone().with_systematic_residual(Some(left.clone()))).unwrap();
        assert_eq!(Calibration::read(with.as_bytes()).unwrap().systematic_residual(), Some(&left));
        let loud = with.replace("-0.02", "-2.0");
        assert!(matches!(
            Calibration::read(loud.as_bytes()),
            Err(CalibrationError::Value { key: "misfit.residual", .. })
        ));
        // A certificate without U and k would be taken as certain, equal masters would give
        // unlimited levers.
        let refused =
            |from: &str, to: &str| Calibration::read(text.replace(from, to).as_bytes()).unwrap_err();
        let certain = refused(
            "\"expanded_u_mm\":0.0006,\"coverage_factor\":2.0",
            "\"expanded_u_mm\":0.0,\"coverage_factor\":0.0",
        );
        assert!(matches!(certain, CalibrationError::Certificate { master: 1 }), "{certain}");
        let twins = refused("\"width_px\":1500.0", "\"width_px\":1000.0");
        assert!(matches!(twins, CalibrationError::SameSize { .. }), "{twins}");
        let thin = refused("\"width_px\":1000.0", "\"width_px\":-1000.0");
        assert!(matches!(thin, CalibrationError::Value { key: "masters.width_px", .. }), "{thin}");
        let sure = refused("\"u_width_px\":0.0", "\"u_width_px\":-1.0");
        assert!(matches!(sure, CalibrationError::Value { key: "masters.u_width_px", .. }), "{sure}");
        let newer = text.replace("\"version\":1", "\"version\":9");
        assert!(matches!(Calibration::read(newer.as_bytes()), Err(CalibrationError::Version { found: 9 })));
        assert!(Calibration::read(&b"{"[..]).is_err());
        assert!(good.check_optics("y").is_err());
    }
}
