//! A program as the store has it: what it was made from, what became of it, its files by digest.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::documents::Document;
use crate::store::EntryKind;

/// What a program does about the nose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum ProgramWay {
    /// Nothing: the drawing's contour, the register as it is.
    Register,
    /// The register radius that leaves least on this part.
    BestRegister,
    /// The contour, by what is left; the register as it is.
    EditedContour,
    /// The path of the measured nose, without the control's compensation.
    #[default]
    Path,
}

/// Whether the nose's wear is compensated for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum Mode {
    /// The drawing's contour with the register as it is.
    Plain,
    /// By a way, with the offsets that the tool's file states: those of touching with the measured
    /// nose, where it states none.
    Compensated,
    /// By a way, in one setting of a batch: the offsets stay those of the new insert, while its
    /// nose wears.
    Batch,
}

/// A program to make.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct NewProgram {
    /// Name of the product.
    pub product: String,
    /// Name of the tool.
    pub tool: String,
    /// Name of the machine.
    pub machine: String,
    /// Plain, compensated or of a batch.
    pub mode: Mode,
    /// How it is compensated for; of a plain program the register.
    #[serde(default)]
    pub way: ProgramWay,
}

/// What became of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum ProgramState {
    /// It waits or is being made.
    Running,
    /// It is there.
    Made,
    /// It was refused.
    Refused,
    /// The server ended before it was made.
    Interrupted,
}

/// A program with what it was made from.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
pub(super) struct Program {
    /// Its number.
    pub id: String,
    /// When it was asked for, ISO 8601.
    pub utc: String,
    /// What it was made from.
    #[serde(flatten)]
    pub of: NewProgram,
    /// What became of it.
    pub state: ProgramState,
    /// Why it was refused; of one that was made, what was noted.
    pub words: String,
    /// What the commands warned of.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// SHA-256 of its text, the table of its moves, the plain program and the compensation.
    pub nc: Option<String>,
    pub(super) moves: Option<String>,
    pub(super) plain: Option<String>,
    pub(super) compensation: Option<String>,
    /// Lines, from 1, that are not those of the plain program.
    pub changed_lines: Vec<usize>,
    /// The product's outline when it was made, Z and distance from the axis in mm.
    pub outline_mm: Vec<[f64; 2]>,
}

impl Document for Program {
    const KIND: EntryKind = EntryKind::Program;
    const WORD: &'static str = "program";

    fn name(&self) -> &str {
        &self.id
    }
}

impl ProgramWay {
    /// As the commands have it.
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Register => "register",
            Self::BestRegister => "best-register",
            Self::EditedContour => "edited-contour",
            Self::Path => "path",
        }
    }
}
