//! Compensation from measured diameters: the offsets of the next pass.
//!
//! Per station, in mm of diameter: error e(k) = D(k) − r(k) of pass k, offset o(k+1) of the next,
//! commanded diameter b(k+1) = r(k+1) − o(k+1). A *law* (`Pid`, least squares, …) proposes
//! offsets; the guards release them or hold the last ones with a reason. Stability of the loop from
//! pass to pass is judged in `stability`.
//!
//! In: the plan of a pass, its measured profile and a [`PassContext`]. Out: a
//! [`Decision`](crate::plan::Decision). `readings` turns a profile into errors, `law/` proposes,
//! `parts` adds the offsets forecast from earlier parts, `guards` release or hold, `compensator`
//! joins them behind the trait [`Controller`]; `build` makes one from `settings/`. A new law is a
//! file in `law/`, a table in `settings/`, a name in `controller_name` and an arm in `build`.
//! `external/` is a controller in another program.

mod build;
mod compensator;
mod context;
mod controller;
mod controller_name;
mod error;
pub(crate) mod external;
pub(crate) mod fit;
mod guards;
mod law;
mod parts;
mod pid;
mod readings;
mod settings;
mod shapes;
pub(crate) mod stability;
mod within_pass;

pub use self::{
    context::{NextPass, Origin, PartAndTool, PartEvent, PartStart, PassContext},
    controller::Controller,
    controller_name::ControllerName,
    error::ControlError,
    shapes::Shapes,
};
pub(crate) use build::{assess, build, describe, transfer};
pub(crate) use pid::Pid;
pub(crate) use settings::*;
pub(crate) use within_pass::WithinPass;
