//! A run on disk: written pass by pass, resumed after a kill, read by `report` and `nc`.
//!
//! A run that writes holds the folder's lock: a second one in it is refused. Every file is written
//! under a temporary name and renamed; the next run clears the remains of a killed one under such
//! names. `passes.csv` is written last for every pass, so that a pass listed there has all its
//! data; remains of a later pass are overwritten. `report.html` is written last of all: a folder
//! that contains it is finished and never changed again.
//!
//! In: rows of finished passes (`tables`, `axis_table`, `form_tables`, `parquet_file`) and the
//! input of the controller (`control`); out: the same rows, read back, and of a stepped shaft what
//! follows from them by section (`section_results`). `folder` holds the folder
//! itself. A new table is a file of its own with its row type, its name in the folder, and a method
//! of [`RunFolder`] to write and to read it.

mod axis_table;
mod control;
mod folder;
mod form_tables;
mod parquet_file;
mod section_results;
mod tables;

pub(crate) use axis_table::{AxisRow, axis_json};
pub(crate) use control::{ControlRecord, PassRecord};
pub(crate) use folder::{RunFolder, RunFolderError};
pub(crate) use form_tables::{FormRow, PartFormRow};
pub(crate) use parquet_file::{DiameterRow, TruthRow, read_diameters};
pub(crate) use section_results::{SectionResults, section_results};
pub(crate) use tables::{OffsetRow, PassRow, StationRow, TrueAxisRow, profile_of};
