//! The axis during a followed pass: in each burst of frames the shaft is bent by the force at those
//! instants.

use crate::process::bending::axis_at;
use crate::shaft::AxisKnot;

/// Step along z of an axis composed from fields, mm: well below the length of a station.
const STEP_MM: f64 = 0.5;

/// Field centres of the frames of a burst with the axis in each; no axis where the tool was clear.
#[derive(Clone, Debug, Default)]
pub(super) struct SeenBurst {
    field_z_mm: Vec<f64>,
    still: Vec<Vec<AxisKnot>>,
}

impl SeenBurst {
    pub(super) fn clear(field_z_mm: f64) -> Self {
        Self { field_z_mm: vec![field_z_mm], still: Vec::new() }
    }

    /// Adds a frame: its field centre, mm, and the axis in it.
    pub(super) fn add(&mut self, field_z_mm: f64, still: &[AxisKnot]) {
        self.field_z_mm.push(field_z_mm);
        self.still.push(still.to_vec());
    }

    fn distance_mm(&self, z_mm: f64) -> f64 {
        (self.field_z_mm.iter().sum::<f64>() / self.field_z_mm.len() as f64 - z_mm).abs()
    }

    /// Mean over the frames, because the tool advances between them.
    fn at(&self, z_mm: f64, clear: &[AxisKnot]) -> [f64; 2] {
        if self.still.is_empty() {
            return axis_at(clear, z_mm);
        }
        let n = self.still.len() as f64;
        let each = self.still.iter().map(|still| axis_at(still, z_mm));
        each.fold([0.0; 2], |sum, p| [sum[0] + p[0] / n, sum[1] + p[1] / n])
    }
}

/// The axis at rest as the fields showed it, at every z from the nearest field; `clear` where the
/// tool was clear or no pass was followed.
pub(super) fn axis_seen(followed: &[SeenBurst], clear: &[AxisKnot], length_mm: f64) -> Vec<AxisKnot> {
    if followed.is_empty() {
        return clear.to_vec();
    }
    let steps = (length_mm / STEP_MM).ceil().max(1.0);
    let at = |k: u32| {
        let z_mm = length_mm * f64::from(k) / steps;
        let nearest = followed.iter().min_by(|a, b| a.distance_mm(z_mm).total_cmp(&b.distance_mm(z_mm)));
        let [x_mm, y_mm] = nearest.map_or_else(|| axis_at(clear, z_mm), |burst| burst.at(z_mm, clear));
        AxisKnot { z_mm, x_mm, y_mm }
    };
    (0..=steps as u32).map(at).collect()
}
