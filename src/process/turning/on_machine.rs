//! A pass on a machine that displaces the tool's path, with and without the compensation of its
//! control.

use std::sync::Arc;

use super::super::path_displacement::{PathDisplacement, PathPlace};
use super::{LatheState, TurningProcess};
use crate::plan::PassPlan;

impl TurningProcess {
    /// The workpiece on a machine; without one the tool stands where it is commanded.
    #[must_use]
    pub(crate) fn on(self, machine: Option<Arc<dyn PathDisplacement>>) -> Self {
        Self { lathe: LatheState { errors: machine, ..self.lathe }, ..self }
    }

    /// The plan as the control's own compensation commands it: its table has a value a station,
    /// which is subtracted like an offset. None without a machine.
    pub(super) fn compensated(&self, plan: &PassPlan) -> Option<PassPlan> {
        let machine = self.lathe.errors.as_ref()?;
        let mut own = plan.clone();
        let places = plan.station_z_mm.iter().zip(plan.commanded_mm());
        for (offset, (z_mm, diameter_mm)) in own.offset.o_mm.iter_mut().zip(places) {
            *offset += machine.compensated_mm(&PathPlace { z_mm: *z_mm, diameter_mm, taper: 0.0 });
        }
        Some(own)
    }

    /// A path (mm of diameter at every node) as the machine's errors displace it. A shoulder stays
    /// where it is commanded.
    pub(super) fn displaced_by_machine(&self, path_mm: Vec<f64>) -> Vec<f64> {
        let Some(machine) = &self.lathe.errors else { return path_mm };
        let z_mm = self.grid.z_mm();
        let at = |(node, diameter_mm): (usize, &f64)| {
            let taper = taper_at(z_mm, &path_mm, node);
            let place = PathPlace { z_mm: z_mm[node], diameter_mm: *diameter_mm, taper };
            diameter_mm + machine.cut_mm(&place)
        };
        path_mm.iter().enumerate().map(at).collect()
    }
}

/// Slope of a path at a node: the mean of both sides, of which a shoulder has none.
fn taper_at(z_mm: &[f64], path_mm: &[f64], node: usize) -> f64 {
    let slope = |a: usize, b: usize| {
        let length = z_mm.get(b)? - z_mm.get(a)?;
        (length > 0.0).then(|| (path_mm[b] - path_mm[a]) / length)
    };
    let before = node.checked_sub(1).and_then(|before| slope(before, node));
    match (before, slope(node, node + 1)) {
        (Some(a), Some(b)) => 0.5 * (a + b),
        (Some(one), None) | (None, Some(one)) => one,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shoulder_has_no_slope() {
        let (z, path) = ([0.0, 1.0, 2.0, 2.0, 4.0], [10.0, 10.0, 10.5, 12.0, 11.0]);
        let wanted = [0.0, 0.25, 0.5, -0.5, -0.5];
        for (node, wanted) in wanted.into_iter().enumerate() {
            assert_eq!(taper_at(&z, &path, node), wanted, "node {node}");
        }
        assert_eq!(taper_at(&[3.0], &[10.0], 0), 0.0);
    }
}
