//! The frames of the study of contamination by their numbers, so that it can be split into shards.

use serde::{Deserialize, Serialize};

use super::contamination::{ContaminationStudy, Outcome, Pair, StudyError, few, points, result};
use super::dirty_frames::{Contaminant, Piece};
use super::sharding::{Cell, ColumnKind, Columns, SceneStudy};
use crate::gauge::GaugeSettings;

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ContaminationPlan {
    /// Frames of each kind of contamination; a twentieth for each point of the curves.
    pub frames: usize,
    /// Clean frames.
    pub clean: usize,
    /// Seed of the first frame.
    pub seed: u64,
}

/// What a frame is drawn for.
enum Place {
    /// A kind of contamination, by its place in their list, and the frame's index.
    Kind(usize, u64),
    /// A clean frame.
    Clean(u64),
    /// A point of the curves, by its place in their list, and the frame's index.
    Point(usize, u64),
}

impl ContaminationPlan {
    fn place(&self, number: u64) -> Place {
        let of_kinds = (self.frames * Contaminant::KINDS.len()) as u64;
        let clean = self.clean as u64;
        let part = |number: u64, each: usize| {
            let each = each.max(1) as u64;
            (usize::try_from(number / each).unwrap_or(usize::MAX), number % each)
        };
        match number.checked_sub(of_kinds) {
            None => {
                let (kind, index) = part(number, self.frames);
                Place::Kind(kind, index)
            }
            Some(index) if index < clean => Place::Clean(index),
            Some(beyond) => {
                let (point, index) = part(beyond - clean, few(self.frames));
                Place::Point(point, index)
            }
        }
    }

    /// The study of all frames' outcomes in their order.
    pub(crate) fn result(&self, outcomes: &[Outcome]) -> ContaminationStudy {
        result(outcomes, self.frames, self.clean, self.seed)
    }
}

impl SceneStudy for ContaminationPlan {
    const NAME: &'static str = "contamination";
    const COLUMNS: Columns = &[
        ("harmful", ColumnKind::Bool),
        ("misled", ColumnKind::Bool),
        ("stations_kept", ColumnKind::Int),
        ("stations_lost", ColumnKind::Int),
        ("worst_um", ColumnKind::Double),
        ("squared_error_um2", ColumnKind::Double),
        ("squared_error_unrejected_um2", ColumnKind::Double),
        ("columns_refused_share", ColumnKind::Double),
    ];
    type Outcome = Outcome;
    type Bench = Pair;
    type Error = StudyError;

    fn seed(&self) -> u64 {
        self.seed
    }

    fn scenes(&self) -> u64 {
        (self.frames * Contaminant::KINDS.len() + self.clean + few(self.frames) * points().len()) as u64
    }

    fn bench(&self) -> Result<Pair, StudyError> {
        Ok(Pair::new(&GaugeSettings::default())?)
    }

    fn scene(&self, number: u64, pair: &Pair) -> Result<Outcome, StudyError> {
        match self.place(number) {
            Place::Kind(kind, index) => {
                let contaminant = Contaminant::KINDS.get(kind).copied().unwrap_or(Contaminant::All);
                let piece = Piece::draw(self.seed + ((kind as u64) << 32) + index);
                Ok(pair.judge(&piece.frame(None)?, &piece.dirty(contaminant)?))
            }
            Place::Clean(index) => Ok(pair.look_at_clean(self.seed + (100 << 32) + index)?),
            Place::Point(point, index) => {
                let points = points();
                let Some(point) = points.get(point) else { return Ok(Outcome::default()) };
                let piece = Piece::draw(self.seed + point.stream + index);
                let bump = point.bump(index.is_multiple_of(2));
                Ok(pair.judge(&piece.frame(None)?, &piece.with_bumps(&[bump]).frame(None)?))
            }
        }
    }

    fn row(outcome: &Outcome) -> Vec<Cell> {
        vec![
            Cell::Bool(outcome.harmful),
            Cell::Bool(outcome.misled),
            Cell::Int(outcome.kept as i64),
            Cell::Int(outcome.gaps as i64),
            Cell::Double(Some(outcome.worst_um)),
            Cell::Double(Some(outcome.square)),
            Cell::Double(Some(outcome.square_off)),
            Cell::Double(Some(outcome.refused_share)),
        ]
    }

    fn outcome(row: &[Cell]) -> Option<Outcome> {
        let [
            Cell::Bool(harmful),
            Cell::Bool(misled),
            Cell::Int(kept),
            Cell::Int(gaps),
            Cell::Double(Some(worst_um)),
            Cell::Double(Some(square)),
            Cell::Double(Some(square_off)),
            Cell::Double(Some(refused_share)),
        ] = row
        else {
            return None;
        };
        Some(Outcome {
            harmful: *harmful,
            misled: *misled,
            kept: usize::try_from(*kept).ok()?,
            gaps: usize::try_from(*gaps).ok()?,
            worst_um: *worst_um,
            square: *square,
            square_off: *square_off,
            refused_share: *refused_share,
        })
    }
}
