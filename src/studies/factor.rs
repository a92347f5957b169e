//! `study factor`: one cutting variable at a time against the size error (Tables 1-2 and Figs 7-9
//! of the slender-shaft paper).
//!
//! The size error at a position of the tool is 2·w(z)·F, w the compliance of the supported shaft
//! there; the paper plots the largest of them over z. Forces are those given with a series,
//! otherwise the force law's.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::deflection::{BeamPart, DeflectionConfig, DeflectionError};
use crate::numerics::line::Line;
use crate::process::fit::{Estimate, FitError, ForcePoint, fit_power_law};
use crate::process::stepped::SteppedShaft;
use crate::process::{PowerLaw, ProcessSettings, geometry};

/// The variable of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Factor {
    /// Depth of cut, mm.
    DepthMm,
    /// Cutting speed, m/min.
    SpeedMPerMin,
    /// Feed, mm/r.
    FeedMmPerRev,
}

impl Factor {
    /// Label of an axis.
    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::DepthMm => "depth of cut / mm",
            Self::SpeedMPerMin => "cutting speed / (m/min)",
            Self::FeedMmPerRev => "feed / (mm/r)",
        }
    }
}

/// A study of single factors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FactorConfig {
    /// Name, for reports.
    #[serde(default)]
    pub name: String,
    /// The shaft.
    pub part: BeamPart,
    /// Force law, material and supports.
    #[serde(default)]
    pub process: ProcessSettings,
    /// Confidence of the intervals of fitted constants.
    #[serde(default = "default_confidence")]
    pub confidence: f64,
    /// The series.
    pub series: Vec<SeriesConfig>,
}

fn default_confidence() -> f64 {
    0.95
}

/// One series: a factor varies, the others are constant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SeriesConfig {
    /// Name, for tables and plots.
    pub name: String,
    /// What varies.
    pub factor: Factor,
    /// Its values.
    pub values: Vec<f64>,
    /// Depth of cut where it does not vary, mm.
    #[serde(default = "default_depth")]
    pub depth_mm: f64,
    /// Cutting speed where it does not vary, m/min.
    #[serde(default = "default_speed")]
    pub speed_m_per_min: f64,
    /// Feed where it does not vary, mm/r.
    #[serde(default = "default_feed")]
    pub feed_mm_per_rev: f64,
    /// Measured or printed radial forces, N, one a value; the force law's where it is left out.
    #[serde(default)]
    pub force_n: Vec<f64>,
    /// Size errors to compare with, µm, one a value; `nan` where there is none.
    #[serde(default)]
    pub reference_error_um: Vec<f64>,
}

fn default_depth() -> f64 {
    0.2
}

fn default_speed() -> f64 {
    40.0
}

fn default_feed() -> f64 {
    0.1
}

/// Why a study is refused.
#[derive(Debug, Error)]
#[non_exhaustive]
pub(crate) enum FactorError {
    /// The shaft.
    #[error(transparent)]
    Beam(#[from] DeflectionError),
    /// The forces.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A series.
    #[error("series[{index}].{key}: {problem}")]
    Series {
        /// Number of the series, from 0.
        index: usize,
        /// Key.
        key: &'static str,
        /// What is wrong, and the valid values.
        problem: String,
    },
    /// No series, or a confidence out of range.
    #[error("{0}")]
    Config(String),
}

/// One value of a factor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FactorRow {
    /// Value of the factor.
    pub value: f64,
    /// Radial force used, N.
    pub force_n: f64,
    /// Radial force of the series' fitted law, N.
    pub fitted_force_n: Option<f64>,
    /// Largest size error over the positions of the tool, µm of diameter.
    pub max_error_um: f64,
    /// Size error with the tool in the middle of the shaft, µm of diameter.
    pub middle_error_um: f64,
    /// Reference value, µm.
    pub reference_error_um: Option<f64>,
    /// Largest error over the reference less one, relative.
    pub deviation: Option<f64>,
    /// Where the force law was used outside its data.
    pub notes: Vec<String>,
}

/// A finished series.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FactorSeries {
    /// Name.
    pub name: String,
    /// What varies.
    pub factor: Factor,
    /// Values in order.
    pub rows: Vec<FactorRow>,
    /// Constants of the force law fitted to the series' own forces.
    pub fit: Option<Vec<Estimate>>,
    /// Elasticity: slope of ln(error) over ln(factor).
    pub elasticity: f64,
    /// Size error over the position of the tool: for every value, (z in mm, error in µm).
    #[serde(skip)]
    pub curves: Vec<Vec<(f64, f64)>>,
}

/// A finished study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FactorStudy {
    /// Name.
    pub name: String,
    /// Where the largest error lies, mm from the chuck face.
    pub z_of_max_mm: f64,
    /// Largest size error over radial force, µm/N.
    pub error_per_force_um_per_n: f64,
    /// The series.
    pub series: Vec<FactorSeries>,
}

/// Points of a curve over z.
const CURVE_POINTS: usize = 200;

impl FactorConfig {
    /// Runs the study.
    ///
    /// # Errors
    /// A shaft or a series that is refused.
    pub(crate) fn run(&self) -> Result<FactorStudy, FactorError> {
        if self.series.is_empty() {
            return Err(FactorError::Config(
                "series: there is none; give one [[series]] at least".to_owned(),
            ));
        }
        if !(0.5..1.0).contains(&self.confidence) {
            let text = format!(
                "confidence = {} is not possible; it must be at least 0.5 and below 1",
                self.confidence
            );
            return Err(FactorError::Config(text));
        }
        let beam = DeflectionConfig {
            name: self.name.clone(),
            part: self.part.clone(),
            process: self.process.clone(),
        };
        let shaft = beam.shaft()?;
        let softest = shaft.softest();
        let series: Result<Vec<FactorSeries>, FactorError> =
            self.series.iter().enumerate().map(|(index, series)| self.one(index, series, &shaft)).collect();
        Ok(FactorStudy {
            name: self.name.clone(),
            z_of_max_mm: softest.z_mm,
            error_per_force_um_per_n: 1e3 * geometry::radial_error_mm(softest.compliance_mm_per_n),
            series: series?,
        })
    }

    fn one(
        &self,
        index: usize,
        series: &SeriesConfig,
        shaft: &SteppedShaft,
    ) -> Result<FactorSeries, FactorError> {
        series.check(index)?;
        let material = self.process.material.resolve().map_err(DeflectionError::from)?;
        let law_force = |p: &ForcePoint| {
            self.process.force.at(&p.cutting(), &self.process.tool, &material).force_n(p.depth_mm)
        };
        let points: Vec<ForcePoint> = series.points(law_force);
        let given = !series.force_n.is_empty();
        let own = if let crate::process::ForceLaw::Power(law) = &self.process.force {
            *law
        } else {
            PowerLaw::default()
        };
        let fit =
            (given && points.len() > 2).then(|| fit_power_law(&points, &own, self.confidence)).transpose()?;
        let softest = 2e3 * shaft.softest().compliance_mm_per_n;
        let middle = 2e3 * shaft.compliance_mm_per_n(0.5 * shaft.length_mm());
        let row = |(i, p): (usize, &ForcePoint)| {
            let reference = series.reference_error_um.get(i).copied().filter(|r| r.is_finite());
            let max_error_um = softest * p.force_n;
            FactorRow {
                value: series.values[i],
                force_n: p.force_n,
                fitted_force_n: fit.as_ref().map(|f| f.law.force_n(p.depth_mm, &p.cutting())),
                max_error_um,
                middle_error_um: middle * p.force_n,
                reference_error_um: reference,
                deviation: reference.map(|r| max_error_um / r - 1.0),
                notes: if given {
                    Vec::new()
                } else {
                    self.process.force.extrapolation(&p.cutting(), [p.depth_mm; 2], &self.process.tool)
                },
            }
        };
        let rows: Vec<FactorRow> = points.iter().enumerate().map(row).collect();
        Ok(FactorSeries {
            name: series.name.clone(),
            factor: series.factor,
            elasticity: Line::through(rows.iter().map(|r| (r.value.ln(), r.max_error_um.ln()))).slope(),
            curves: points.iter().map(|p| curve(shaft, p.force_n)).collect(),
            fit: fit.map(|f| f.estimates),
            rows,
        })
    }
}

/// Size error over the position of the tool, (mm, µm).
fn curve(shaft: &SteppedShaft, force_n: f64) -> Vec<(f64, f64)> {
    (0..=CURVE_POINTS)
        .map(|i| shaft.length_mm() * i as f64 / CURVE_POINTS as f64)
        .map(|z| (z, 2e3 * shaft.compliance_mm_per_n(z) * force_n))
        .collect()
}

impl SeriesConfig {
    fn check(&self, index: usize) -> Result<(), FactorError> {
        let refuse = |key, problem: String| Err(FactorError::Series { index, key, problem });
        if self.values.is_empty() {
            return refuse("values", "is empty; give at least one".to_owned());
        }
        let bad = |v: &f64| !v.is_finite() || *v <= 0.0;
        for (key, values) in [("values", &self.values), ("force_n", &self.force_n)] {
            if let Some(value) = values.iter().find(|v| bad(v)) {
                return refuse(key, format!("{value} is not possible; it must be above 0"));
            }
        }
        for (key, value) in [
            ("depth_mm", self.depth_mm),
            ("speed_m_per_min", self.speed_m_per_min),
            ("feed_mm_per_rev", self.feed_mm_per_rev),
        ] {
            if bad(&value) {
                return refuse(key, format!("{value} is not possible; it must be above 0"));
            }
        }
        for (key, values) in [("force_n", &self.force_n), ("reference_error_um", &self.reference_error_um)] {
            if !values.is_empty() && values.len() != self.values.len() {
                let (found, expected) = (values.len(), self.values.len());
                return refuse(
                    key,
                    format!("has {found} entries for {expected} values; there must be one each"),
                );
            }
        }
        Ok(())
    }

    fn points(&self, law: impl Fn(&ForcePoint) -> f64) -> Vec<ForcePoint> {
        let base = ForcePoint {
            depth_mm: self.depth_mm,
            speed_m_per_min: self.speed_m_per_min,
            feed_mm_per_rev: self.feed_mm_per_rev,
            force_n: 0.0,
        };
        let at = |(i, &value): (usize, &f64)| {
            let point = match self.factor {
                Factor::DepthMm => ForcePoint { depth_mm: value, ..base },
                Factor::SpeedMPerMin => ForcePoint { speed_m_per_min: value, ..base },
                Factor::FeedMmPerRev => ForcePoint { feed_mm_per_rev: value, ..base },
            };
            let force_n = self.force_n.get(i).copied().unwrap_or_else(|| law(&point));
            ForcePoint { force_n, ..point }
        };
        self.values.iter().enumerate().map(at).collect()
    }
}
