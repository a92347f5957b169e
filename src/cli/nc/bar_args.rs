//! How `nc` cuts a model of a part out of its bar.

use std::path::{Path, PathBuf};

use crate::cli::failure::Failure;
use crate::cli::run::model::ModelTool;
use crate::part_program::Cuts;

/// How a part is cut out of its bar.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "With a model of a part (.stl)")]
pub(crate) struct BarArgs {
    /// Depth of a rough cut on the radius, mm; 1 where it is not given.
    #[arg(long, value_name = "MM")]
    depth: Option<f64>,
    /// What roughing leaves for the finishing cut, mm along the normal; the depth of the tool's
    /// measured pass, or 0.2.
    #[arg(long, value_name = "MM")]
    allowance: Option<f64>,
    /// How far the bar stands beyond the part's end face, mm; 1 where it is not given.
    #[arg(long, value_name = "MM")]
    facing: Option<f64>,
    /// Z of the part's end at the chuck, mm from the face that clamps the bar; 0 where it is not
    /// given. What lies below `least_z_mm` of the machine's data is in the grip.
    #[arg(long, value_name = "MM")]
    pub(super) from_z: Option<f64>,
    /// Draw part, path and what is left into this file.
    #[arg(long, value_name = "FILE.svg")]
    pub(super) svg: Option<PathBuf>,
    /// Write its moves, as the text commands them, into this table.
    #[arg(long, value_name = "FILE.csv")]
    pub(super) moves: Option<PathBuf>,
}

/// Depth of rough cuts, allowance and facing where none is stated, mm: usual for steel with a nose
/// of 0.4 mm.
const DEPTH_MM: f64 = 1.0;
const ALLOWANCE_MM: f64 = 0.2;
const FACING_MM: f64 = 1.0;

impl BarArgs {
    /// Refuses them beside anything but a model.
    pub(super) fn only_for_models(&self, path: &Path) -> Result<(), Failure> {
        let given = [
            ("--depth", self.depth.is_some()),
            ("--allowance", self.allowance.is_some()),
            ("--facing", self.facing.is_some()),
            ("--from-z", self.from_z.is_some()),
            ("--svg", self.svg.is_some()),
            ("--moves", self.moves.is_some()),
        ];
        match given.iter().find(|(_, is_given)| *is_given) {
            None => Ok(()),
            Some((name, _)) => Err(Failure::refuse(format!(
                "{name} belongs to a model of a part, and {} is no .stl file: leave it out",
                path.display()
            ))),
        }
    }

    /// Depths of the cuts.
    pub(super) fn cuts(&self, tool: &ModelTool) -> Cuts {
        let measured = tool.tool.measured_pass.and_then(|pass| pass.depth_mm);
        Cuts {
            depth_mm: self.depth.unwrap_or(DEPTH_MM),
            allowance_mm: self.allowance.or(measured).unwrap_or(ALLOWANCE_MM),
            facing_mm: self.facing.unwrap_or(FACING_MM),
        }
    }
}
