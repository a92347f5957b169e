//! Least-squares shapes (paper 000, eqs 4-6), refitted every pass; the fitted error is added to the
//! offsets in force. Sections of a stepped shaft are fitted apart.

use super::proposal::{Law, Observation, Proposal, independent_u, y};
use crate::control::error::ControlError;
use crate::control::fit::{self, Fit};
use crate::control::settings::{ApplyTo, Estimator, LsqSettings};
use crate::control::shapes::SectionShapes;
use crate::plan::StationLayout;
use nalgebra::DVector;

/// Least-squares law.
#[derive(Clone, Debug)]
pub(crate) struct LsqLaw {
    settings: LsqSettings,
    shapes: SectionShapes,
}

impl LsqLaw {
    pub(crate) fn new(settings: &LsqSettings, stations: &StationLayout) -> Result<Self, ControlError> {
        Ok(Self { settings: settings.clone(), shapes: settings.shapes.of_sections(stations)? })
    }

    fn fit(&self, seen: &Observation<'_>) -> Option<Fit> {
        let u = if self.settings.weighted {
            independent_u(seen.errors)
        } else {
            let mean = independent_u(seen.errors).mean();
            DVector::from_element(self.shapes.design.nrows(), mean)
        };
        match self.settings.estimator {
            Estimator::LeastSquares => fit::weighted(&self.shapes.design, &y(seen.errors), &u),
            Estimator::Huber => fit::huber(&self.shapes.design, &y(seen.errors), &u),
        }
    }

    fn note(&self, fit: &Fit) -> String {
        let terms: Vec<String> = self
            .shapes
            .names
            .iter()
            .zip(fit.coefficients.iter())
            .zip(fit.covariance.diagonal().iter())
            .map(|((name, c), v)| format!("{name} {:.2} ± {:.2} µm", c * 1e3, v.sqrt() * 1e3))
            .collect();
        let largest = fit.residuals.amax() * 1e3;
        format!("fitted {}; largest residual {largest:.2} µm", terms.join(", "))
    }
}

impl Law for LsqLaw {
    fn begin(&mut self, _stock_mm: Option<Vec<f64>>) {}

    fn propose(&mut self, seen: &Observation<'_>) -> Proposal {
        let waits =
            self.settings.apply_to == ApplyTo::FinishingPass && !seen.next.is_some_and(|n| n.finishing);
        if waits {
            let notes = vec!["the finishing pass alone is compensated".to_owned()];
            return Proposal::with_notes(seen.in_force().to_vec(), notes);
        }
        let Some(fit) = self.fit(seen) else {
            let notes = vec!["no fit: the shapes are not independent at these stations".to_owned()];
            return Proposal::with_notes(seen.in_force().to_vec(), notes);
        };
        let shape = &self.shapes.design * &fit.coefficients;
        let corrected = seen.in_force().iter().zip(shape.iter()).map(|(o, e)| o + self.settings.gain * e);
        Proposal::with_notes(corrected.collect(), vec![self.note(&fit)])
    }
}
