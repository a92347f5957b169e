//! A run on disk: written pass by pass, resumed after a kill, read by `report` and `nc`.
//!
//! A run that writes holds the folder's lock: a second one in it is refused. Every file is written
//! under a temporary name and renamed; what a killed run left under such names is cleared by the
//! next. `passes.csv` is written last of a pass, so a pass that stands in it has all its data;
//! whatever a killed run left of a later pass is overwritten. `report.html` is written last of all:
//! a folder that has one is finished and never touched again.
//!
//! In: rows of finished passes (`tables`, `axis_table`, `form_tables`, `parquet_file`) and what
//! control was given (`control`); out: the same rows, read back. `folder` holds the folder itself.
//! A new table is a file of its own with its row type, its name in the folder, and a method of
//! [`RunFolder`] to write and to read it.

mod axis_table;
mod control;
mod folder;
mod form_tables;
mod parquet_file;
mod tables;

pub use axis_table::{AxisRow, axis_json};
pub use control::{ControlRecord, PassRecord};
pub use folder::{RunFolder, RunFolderError};
pub use form_tables::{FormRow, PartFormRow};
pub use parquet_file::{DiameterRow, TruthRow, read_diameters};
pub use tables::{OffsetRow, PassRow, StationRow, TrueAxisRow, offset_of, profile_of};
