//! `study machine`: the errors of a lathe over its working space, their budget, and what a probe
//! and two-sided heads make of them.

mod budget;
mod config;
mod form;
mod heads;
mod map;
pub(crate) mod models;
mod prepared;
mod separation;
mod speed;
mod spiral;
mod warm_up;

use serde::Serialize;
use thiserror::Error;

pub(crate) use budget::{Budget, BudgetRow};
pub(crate) use config::MachineStudyConfig;
pub(crate) use form::FormRow;
pub(crate) use heads::{Comparison, Reading, ReadingPoint, Sensitivity};
pub(crate) use map::{Extent, MapFigures, MapPoint};
pub(crate) use models::{Models, ModelsAsked};
pub(crate) use separation::SeparationRow;
pub(crate) use speed::Speed;
pub(crate) use spiral::{Alias, Spiral};
pub(crate) use warm_up::WarmUpPoint;

use crate::gauge::form::FormError;
use crate::setting::SettingError;
use prepared::Prepared;

/// Why a study is refused.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub(crate) enum MachineStudyError {
    /// A value of the config.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A form that its points do not determine.
    #[error("form of the part: {0}")]
    Form(#[from] FormError),
}

/// Result of the study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct MachineStudy {
    /// Name of the config.
    pub name: String,
    /// The kinematic chain.
    pub chain: &'static str,
    /// The map in figures.
    pub map: MapFigures,
    /// The map, z running fastest.
    #[serde(skip)]
    pub points: Vec<MapPoint>,
    /// What each error does.
    pub budget: Budget,
    /// Tool, probe and heads side by side.
    pub heads: Comparison,
    /// The form of the part, and what a probe on the machine indicates of it.
    pub form: Vec<FormRow>,
    /// What the spiral on a face shows of lobes.
    pub aliases: Vec<Alias>,
    /// Which separation of spindle and form would serve; empty where the spindle has no error
    /// motion.
    pub separation: Vec<SeparationRow>,
    /// The diameter cut while the machine warms up; empty where nothing drifts with time.
    pub warm_up: Vec<WarmUpPoint>,
}

impl MachineStudyConfig {
    /// Runs the study.
    ///
    /// # Errors
    /// The first value that cannot be right.
    pub(crate) fn run(&self) -> Result<MachineStudy, MachineStudyError> {
        let machine = Prepared::of(self)?;
        let points = map::map(&machine);
        Ok(MachineStudy {
            name: self.name.clone(),
            chain: self.machine.chain.notation(),
            map: map::figures(&machine, &points),
            budget: budget::budget(&machine, &self.part.part(), &points),
            heads: heads::compare(&machine, self),
            form: form::forms(&machine, self)?,
            separation: separation::separations(&machine, self),
            aliases: self.spiral(&machine).aliases()?,
            warm_up: warm_up::warm_up(&machine, &self.part.part()),
            points,
        })
    }

    /// The errors at positions [x, z] of both slides, mm.
    ///
    /// # Errors
    /// As [`Self::run`], and a position outside the travel.
    pub(crate) fn at(&self, positions: &[[f64; 2]]) -> Result<Vec<MapPoint>, SettingError> {
        let machine = Prepared::of(self)?;
        let point = |[x, z]: &[f64; 2]| {
            for (axis, value, [from, to]) in
                [("x", x, self.machine.x_travel_mm), ("z", z, self.machine.z_travel_mm)]
            {
                if !(from..=to).contains(value) {
                    let right = format!("in the travel from {from} to {to} mm (machine.{axis}_travel_mm)");
                    return Err(SettingError::of(format!("--at {x},{z}: {axis}"), value, right));
                }
            }
            Ok(map::point(&machine, *x, *z))
        };
        positions.iter().map(point).collect()
    }
}
