//! Control laws: from the errors of one pass to the offsets of the next, without limits or guards.

use super::fit::{self, Fit};
use super::pid::Pid;
use super::readings::Errors;
use super::{ControlError, LsqSettings, OffsetForm, PidSettings, Shapes, Spatial};
use nalgebra::{DMatrix, DVector};

/// What a law sees of the pass measured.
pub(crate) struct Seen<'a> {
    /// Errors of the pass.
    pub errors: &'a Errors,
    /// Offsets in force in that pass, mm of diameter.
    pub offset_mm: &'a [f64],
}

/// A control law. It proposes; the compensator decides whether the proposal, and what the law learnt, is kept.
pub(crate) trait Law: Clone {
    /// Offsets of the next pass, mm of diameter.
    fn propose(&mut self, seen: &Seen<'_>) -> Vec<f64>;
}

/// Leaves the offsets as they are.
#[derive(Clone, Debug)]
pub(crate) struct Nothing;

impl Law for Nothing {
    fn propose(&mut self, seen: &Seen<'_>) -> Vec<f64> {
        seen.offset_mm.to_vec()
    }
}

/// PID per station or per shape.
#[derive(Clone, Debug)]
pub(crate) struct PidLaw {
    pid: Pid,
    form: OffsetForm,
    design: Option<DMatrix<f64>>,
}

impl PidLaw {
    pub(crate) fn new(settings: &PidSettings, station_z_mm: &[f64]) -> Result<Self, ControlError> {
        let design = match settings.spatial {
            Spatial::Station => None,
            Spatial::Modal(shapes) => Some(shapes.design(station_z_mm)?),
        };
        let channels = design.as_ref().map_or(station_z_mm.len(), DMatrix::ncols);
        Ok(Self { pid: Pid::new(settings, channels), form: settings.form, design })
    }
}

impl Law for PidLaw {
    fn propose(&mut self, seen: &Seen<'_>) -> Vec<f64> {
        let output = match &self.design {
            None => self.pid.step(&seen.errors.e_mm),
            Some(design) => {
                let channels = project(design, seen.errors).map_or(vec![0.0; design.ncols()], |fit| {
                    fit.coefficients.iter().copied().collect::<Vec<_>>()
                });
                let output = DVector::from_vec(self.pid.step(&channels));
                (design * output).iter().copied().collect()
            }
        };
        match self.form {
            OffsetForm::Absolute => output,
            OffsetForm::Accumulated => seen.offset_mm.iter().zip(&output).map(|(o, u)| o + u).collect(),
        }
    }
}

/// Least-squares shape, refitted every pass; the fitted error is added to the offsets in force.
#[derive(Clone, Debug)]
pub(crate) struct LsqLaw {
    design: DMatrix<f64>,
    weighted: bool,
    gain: f64,
}

impl LsqLaw {
    pub(crate) fn new(settings: &LsqSettings, station_z_mm: &[f64]) -> Result<Self, ControlError> {
        let design = settings.shapes.design(station_z_mm)?;
        Ok(Self { design, weighted: settings.weighted, gain: settings.gain })
    }
}

impl Law for LsqLaw {
    fn propose(&mut self, seen: &Seen<'_>) -> Vec<f64> {
        let fitted = if self.weighted {
            project(&self.design, seen.errors)
        } else {
            fit::weighted(&self.design, &y(seen.errors), &DVector::from_element(self.design.nrows(), 1.0))
        };
        let Some(fitted) = fitted else {
            return seen.offset_mm.to_vec();
        };
        let shape = &self.design * fitted.coefficients;
        seen.offset_mm.iter().zip(shape.iter()).map(|(o, e)| o + self.gain * e).collect()
    }
}

fn y(errors: &Errors) -> DVector<f64> {
    DVector::from_column_slice(&errors.e_mm)
}

/// Fits the shapes to the errors, weighted by what is independent from station to station.
fn project(design: &DMatrix<f64>, errors: &Errors) -> Option<Fit> {
    let independent = errors.u_random_mm.iter().all(|&u| u > 0.0);
    let u = if independent { &errors.u_random_mm } else { &errors.u_mm };
    fit::weighted(design, &y(errors), &DVector::from_column_slice(u))
}

impl Shapes {
    /// What the shapes are called in reports.
    pub fn describe(self) -> String {
        match self {
            Self::Line => "line".into(),
            Self::Quadratic => "quadratic".into(),
            Self::Polynomial { degree } => format!("polynomial of degree {degree}"),
        }
    }
}
