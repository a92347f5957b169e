//! Scoring tables kept from frame to frame: one serves all blurs near its own.

use crate::gauge::edge::estimation::scoring_table::{FINE, Table, Tabulation};
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;

/// Memory of the tables kept, bytes: one for each pixel of the frame, in these bounds. Steep edges
/// need many tables.
const TABLE_BYTES: (usize, usize) = (1 << 20, 4 << 20);
/// Relative difference of blurs that share a table; under rings one moves an edge by 12 px of
/// itself.
pub(super) const SAME_BLUR: f64 = 0.004;
const SAME_RINGS: f64 = 1e-4;

/// The tables of one side.
#[derive(Clone, Debug)]
pub(crate) struct TableCache {
    /// The edge-spread function that all of them tabulate.
    shape: EdgeSpreadFunction,
    tables: Vec<Table>,
    /// Memory that they may take, bytes.
    most_bytes: usize,
}

/// What a table is wanted for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TableKey {
    /// Blur, px.
    pub(crate) sigma: f64,
    /// Noise slope.
    pub(crate) kappa: f64,
    /// Pixels of the windows.
    pub(crate) width: usize,
    /// Whether each column has levels of its own.
    pub(crate) free_levels: bool,
}

impl TableCache {
    pub(crate) fn new() -> Self {
        Self { shape: EdgeSpreadFunction::Gaussian, tables: Vec::new(), most_bytes: TABLE_BYTES.0 }
    }

    pub(crate) fn clear(&mut self) {
        self.tables.clear();
    }

    /// Drops the tables of any other edge-spread function.
    pub(crate) fn keep_for(&mut self, shape: &EdgeSpreadFunction) {
        if self.shape != *shape {
            self.shape = shape.clone();
            self.tables.clear();
        }
    }

    /// Limits their memory to what a frame of so many pixels has.
    pub(crate) fn limit(&mut self, pixels: usize) {
        self.most_bytes = pixels.clamp(TABLE_BYTES.0, TABLE_BYTES.1);
    }

    /// The table for a key, built where it is missing.
    pub(crate) fn find(&mut self, key: TableKey) -> &Table {
        let TableKey { sigma, kappa, width, free_levels } = key;
        let same = if self.shape.is_ringed() { SAME_RINGS } else { SAME_BLUR };
        let near = |t: &Table| {
            t.width == width && (t.sigma / sigma).ln().abs() < same && (t.kappa - kappa).abs() < 0.08
        };
        if let Some(found) = self.tables.iter().position(near) {
            return &self.tables[found];
        }
        let table = Table::new(&self.shape, Tabulation { sigma, kappa, width, free_levels, per_px: FINE });
        let held: usize = self.tables.iter().map(Table::bytes).sum();
        if held + table.bytes() > self.most_bytes {
            self.tables.clear();
        }
        self.tables.push(table);
        &self.tables[self.tables.len() - 1]
    }
}
