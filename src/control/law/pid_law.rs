//! PID per station or per shape.

use super::proposal::{Feedforward, Law, Observation, Proposal, project};
use crate::control::error::ControlError;
use crate::control::pid::Pid;
use crate::control::settings::{OffsetForm, PidSettings, Spatial};
use crate::plan::StationLayout;
use nalgebra::{DMatrix, DVector};

/// PID per station or per shape.
#[derive(Clone, Debug)]
pub(crate) struct PidLaw {
    settings: PidSettings,
    channels: usize,
    pid: Pid,
    design: Option<DMatrix<f64>>,
}

impl PidLaw {
    pub(crate) fn new(settings: &PidSettings, stations: &StationLayout) -> Result<Self, ControlError> {
        let design = match settings.spatial {
            Spatial::Station => None,
            Spatial::Modal(shapes) => Some(shapes.of_sections(stations)?.design),
        };
        let channels = design.as_ref().map_or(stations.z_mm.len(), DMatrix::ncols);
        Ok(Self { settings: settings.clone(), channels, pid: Pid::new(settings, channels), design })
    }

    fn output(&mut self, seen: &Observation<'_>) -> Vec<f64> {
        let Some(design) = &self.design else {
            return self.pid.step(&seen.errors.e_mm());
        };
        let amplitudes = match project(design, seen.errors) {
            Some(fit) => fit.coefficients.iter().copied().collect(),
            None => vec![0.0; design.ncols()],
        };
        let output = DVector::from_vec(self.pid.step(&amplitudes));
        (design * output).iter().copied().collect()
    }
}

impl Law for PidLaw {
    fn begin(&mut self, _stock_mm: Option<Vec<f64>>) {
        self.pid = Pid::new(&self.settings, self.channels);
    }

    fn propose(&mut self, seen: &Observation<'_>) -> Proposal {
        let output = self.output(seen);
        match self.settings.form {
            OffsetForm::Absolute => output.into(),
            OffsetForm::Accumulated => {
                seen.in_force().iter().zip(&output).map(|(o, u)| o + u).collect::<Vec<_>>().into()
            }
        }
    }

    fn feedforward(&self) -> Feedforward {
        match self.settings.form {
            OffsetForm::Absolute => Feedforward::Whole,
            OffsetForm::Accumulated => Feedforward::Difference,
        }
    }
}
