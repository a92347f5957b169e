//! Offsets as NC programs for a lathe: one emitter, four dialects.
//!
//! X is a diameter, Z runs along the spindle from the chuck face, as in the rest of the crate. A
//! correction o(z) splits into its mean ō and its shape: on a control whose wear register can be
//! written from a program (Fanuc) the mean goes there, before the tool call that activates it, and
//! the shape goes into G01 knots; elsewhere the path holds both. No share of a correction is in
//! both the path and the register. The offsets after rounding are returned to the controller.
//!
//! Every program moves to its change position first, X alone and then Z, calls the tool only there,
//! comes down to the part in the air, enters and leaves the stock radially in feed and cuts the
//! part from end to end. Before it is returned it is run by `replay` from many start positions
//! among the solids that stand around the part.
//!
//! Verification: the tests run programs of the `linuxcnc` dialect through LinuxCNC's stand-alone
//! interpreter. `fanuc` is written for G-code system A with custom macro B, `gsk` for the GSK 980TD
//! family, both from common usage, not checked against the makers' manuals; neither has been run on
//! a control, and the user alarm G65 H99 of `gsk` is unverified. `sinumerik` is the 840D's own
//! language (not its ISO mode), as unverified as they are. Run such programs dry, above the part,
//! first.
//!
//! `settings`, `machine`, `probe_settings` and `stated` hold the machine's data; `route`, `path`
//! (`contour_path` of a stepped shaft) and `skeleton` plan, `dialect` writes the blocks
//! (`sinumerik` those that are not ISO), `turning`, `air_cut`, `macro_program`, `probing_program`,
//! `contour_program` (lines and arcs, with `bore`, `contour_entry` and `nose_words`; with
//! `roughing` in front of it `from_bar`) and `scan_program` (the gauge head along the part, by
//! `scan_settings`) are the programs, `surroundings` the solids. A new dialect is a variant of
//! `Dialect` with its words and its match arms in `replay`; a new program is a file beside
//! `turning`.

mod air_cut;
mod bore;
mod contour_entry;
mod contour_path;
mod contour_program;
mod dialect;
mod error;
mod from_bar;
mod header;
mod line;
mod machine;
mod macro_program;
mod nose_words;
mod path;
mod probe;
mod probe_settings;
mod probing_program;
mod qualification;
pub(crate) mod replay;
mod roughing;
mod route;
mod scan_program;
mod scan_settings;
mod settings;
mod sinumerik;
mod skeleton;
mod stated;
mod surroundings;
mod turning;

pub use self::{
    dialect::Dialect,
    machine::{
        BoringBar, Centre, ChangePosition, Chuck, GeometryOffset, Holder, Obstacle, Spindle,
        SpindleOrientation, Tailstock, Travel, WearX,
    },
    probe_settings::{NcProbe, ProbeReference},
    scan_settings::{MCode, NcScan, ScanHead},
    settings::{NcSettings, Remeasure},
};
pub(crate) use air_cut::AirCut;
pub(crate) use bore::Bore;
pub(crate) use contour_program::{ContourProgram, WrittenContour};
pub(crate) use error::NcError;
pub(crate) use from_bar::{FromBar, ToolMove};
pub(crate) use line::{LineFit, fit_line};
pub(crate) use machine::Direction;
pub(crate) use macro_program::{MacroProgram, MacroValues};
pub(crate) use nose_words::NoseRegister;
pub(crate) use path::{Path, dry_run};
pub(crate) use probing_program::ProbingProgram;
pub(crate) use qualification::Qualification;
pub(crate) use roughing::Roughing;
pub(crate) use route::Workpiece;
pub(crate) use scan_program::{ScanProgram, stop_list};
pub(crate) use turning::{TurningProgram, Written};
