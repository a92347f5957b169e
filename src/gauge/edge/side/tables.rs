//! Scoring tables kept from frame to frame: one serves all blurs near its own.

use crate::gauge::edge::estimation::scoring_table::{ScoringTableLimits, Table, Tabulation};
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::limit::limits;

limits! {
    /// Memory of the scoring tables that a side keeps, and which blurs share one.
    TableLimits = "tables";
    /// Memory of the tables kept, bytes, at least. Within these bounds there is one for each pixel
    /// of the frame, since steep edges need many tables.
    least_bytes: usize = 1 << 20;
    /// Memory of the tables kept, bytes, at most: both sides' stay within the last cache of a small
    /// computer.
    most_bytes: usize = 4 << 20;
    /// Relative difference of blurs that share a table: weights that are off by so little cost
    /// nothing in u (it is stationary in them) and move no edge, whose score is odd about it.
    same_blur: f64 = 0.004;
    /// The same under rings, where blur scales the pattern and moves an edge by 12 px of itself:
    /// 0.001 px.
    same_rings: f64 = 1e-4;
}

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
        Self {
            shape: EdgeSpreadFunction::Gaussian,
            tables: Vec::new(),
            most_bytes: TableLimits::get().least_bytes,
        }
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
        let limits = TableLimits::get();
        self.most_bytes = pixels.clamp(limits.least_bytes, limits.most_bytes);
    }

    /// The table for a key, built where it is missing.
    pub(crate) fn find(&mut self, key: TableKey) -> &Table {
        let TableKey { sigma, kappa, width, free_levels } = key;
        let limits = TableLimits::get();
        let same = if self.shape.is_ringed() { limits.same_rings } else { limits.same_blur };
        let near = |t: &Table| {
            t.width == width && (t.sigma / sigma).ln().abs() < same && (t.kappa - kappa).abs() < 0.08
        };
        if let Some(found) = self.tables.iter().position(near) {
            return &self.tables[found];
        }
        let per_px = ScoringTableLimits::get().fine;
        let table = Table::new(&self.shape, Tabulation { sigma, kappa, width, free_levels, per_px });
        let held: usize = self.tables.iter().map(Table::bytes).sum();
        if held + table.bytes() > self.most_bytes {
            self.tables.clear();
        }
        self.tables.push(table);
        &self.tables[self.tables.len() - 1]
    }
}
