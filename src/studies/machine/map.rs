//! The errors over the working space: exact, to first order, and what no sum f(x) + g(z) can hold.

use serde::Serialize;

use super::prepared::Prepared;
use crate::machine::{Chain, first_order};

/// Tool relative to part at a position of both slides, µm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Displacement {
    /// Along X (radial).
    pub e_x_um: f64,
    /// Along Y.
    pub e_y_um: f64,
    /// Along Z (the spindle).
    pub e_z_um: f64,
}

/// A point of the map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct MapPoint {
    /// Position of X, mm.
    pub x_mm: f64,
    /// Position of Z, mm.
    pub z_mm: f64,
    /// Error along X (radial), µm.
    pub e_x_um: f64,
    /// Error along Y, µm.
    pub e_y_um: f64,
    /// Error along Z, µm.
    pub e_z_um: f64,
    /// The same to first order.
    pub first_order: Displacement,
}

/// Where a component lies over the map, µm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Extent {
    /// Lowest.
    pub min_um: f64,
    /// Highest.
    pub max_um: f64,
    /// Peak to valley.
    pub range_um: f64,
    /// Rms of what is left of it after the best f(x) + g(z).
    pub not_separable_um: f64,
}

/// The map in figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct MapFigures {
    /// Positions of X.
    pub x_points: usize,
    /// Positions of Z.
    pub z_points: usize,
    /// Error along X.
    pub e_x: Extent,
    /// Error along Y.
    pub e_y: Extent,
    /// Error along Z.
    pub e_z: Extent,
    /// Largest difference between the exact chain and its first order, nm.
    pub first_order_off_nm: f64,
}

/// The errors at a position of both slides.
pub(crate) fn point(machine: &Prepared, x_mm: f64, z_mm: f64) -> MapPoint {
    let station = machine.settings.tool(x_mm, z_mm);
    let values = machine.motion.values(x_mm, z_mm, &machine.state);
    let topology = machine.settings.chain;
    let exact = 1e3 * Chain { topology, values }.pose(&station).shift_mm;
    let linear = 1e3 * first_order::pose(topology, &station, &values).shift_mm;
    MapPoint {
        x_mm,
        z_mm,
        e_x_um: exact.x,
        e_y_um: exact.y,
        e_z_um: exact.z,
        first_order: Displacement { e_x_um: linear.x, e_y_um: linear.y, e_z_um: linear.z },
    }
}

/// The map, z running fastest.
pub(crate) fn map(machine: &Prepared) -> Vec<MapPoint> {
    let along = |x: &f64| machine.z_mm.iter().map(|z| point(machine, *x, *z)).collect::<Vec<_>>();
    machine.x_mm.iter().flat_map(along).collect()
}

/// The map's figures.
pub(crate) fn figures(machine: &Prepared, map: &[MapPoint]) -> MapFigures {
    let (x_points, z_points) = (machine.x_mm.len(), machine.z_mm.len());
    let extent = |component: fn(&MapPoint) -> f64| {
        let values: Vec<f64> = map.iter().map(component).collect();
        let (min_um, max_um) = range(values.iter().copied());
        Extent {
            min_um,
            max_um,
            range_um: max_um - min_um,
            not_separable_um: not_separable(&values, z_points),
        }
    };
    let off = |p: &MapPoint| {
        let f = p.first_order;
        let parts = [p.e_x_um - f.e_x_um, p.e_y_um - f.e_y_um, p.e_z_um - f.e_z_um];
        parts.into_iter().map(f64::abs).fold(0.0, f64::max)
    };
    MapFigures {
        x_points,
        z_points,
        e_x: extent(|p| p.e_x_um),
        e_y: extent(|p| p.e_y_um),
        e_z: extent(|p| p.e_z_um),
        first_order_off_nm: 1e3 * map.iter().map(off).fold(0.0, f64::max),
    }
}

/// Lowest and highest of values.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// Rms of a raster (rows of `columns`) after the least-squares f(row) + g(column): the interaction
/// of a two-way layout, value − mean of row − mean of column + mean.
pub(crate) fn not_separable(values: &[f64], columns: usize) -> f64 {
    let rows = values.len() / columns;
    let mean = |values: &mut dyn Iterator<Item = f64>, count: usize| values.sum::<f64>() / count as f64;
    let all = mean(&mut values.iter().copied(), values.len());
    let of_row: Vec<f64> =
        values.chunks(columns).map(|row| mean(&mut row.iter().copied(), columns)).collect();
    let of_column: Vec<f64> =
        (0..columns).map(|k| mean(&mut values.iter().skip(k).step_by(columns).copied(), rows)).collect();
    let rest = values.iter().enumerate().map(|(k, v)| v - of_row[k / columns] - of_column[k % columns] + all);
    (rest.map(|r| r * r).sum::<f64>() / values.len() as f64).sqrt()
}
