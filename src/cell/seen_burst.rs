//! The axis during a followed pass: in each burst of frames the shaft is bent by the force at those
//! instants.

use super::turning_cell::{SeenStation, TrueAxis};
use crate::process::bending::{axis_at, sum_of_lines};
use crate::shaft::{AxisKnot, Shaft};

/// Step along z of an axis composed from fields, mm: well below the length of a station.
const STEP_MM: f64 = 0.5;

/// The frames of a burst.
#[derive(Clone, Debug, Default)]
pub(super) struct SeenBurst {
    frames: Vec<SeenFrame>,
}

/// Field centre of a frame, mm, with the axis in it; `None` where the tool was clear.
#[derive(Clone, Debug)]
struct SeenFrame {
    field_z_mm: f64,
    axis: Option<TrueAxis>,
}

/// The axis of a shaft: what stands still of it, and what turns with it.
pub(super) fn axis_of(shaft: &Shaft) -> TrueAxis {
    let (sin, cos) = shaft.eccentricity.phase_deg.to_radians().sin_cos();
    let offset = shaft.eccentricity.amplitude_mm;
    let whole = [AxisKnot { z_mm: 0.0, x_mm: offset * cos, y_mm: offset * sin }];
    TrueAxis {
        still: shaft.deflection.clone(),
        turning: sum_of_lines(&whole[..usize::from(offset != 0.0)], &shaft.bow),
    }
}

impl SeenBurst {
    pub(super) fn clear(field_z_mm: f64) -> Self {
        Self { frames: vec![SeenFrame { field_z_mm, axis: None }] }
    }

    /// Adds a frame: its field centre, mm, and the shaft in it.
    pub(super) fn add(&mut self, field_z_mm: f64, shaft: &Shaft) {
        self.frames.push(SeenFrame { field_z_mm, axis: Some(axis_of(shaft)) });
    }

    fn distance_mm(&self, z_mm: f64) -> f64 {
        let sum = self.frames.iter().map(|f| f.field_z_mm).sum::<f64>();
        (sum / self.frames.len() as f64 - z_mm).abs()
    }

    /// Mean over the frames at z, as the tool goes on between them: what stands still, what turns.
    fn at(&self, z_mm: f64, clear: &TrueAxis) -> [[f64; 2]; 2] {
        let axes = || self.frames.iter().map(|f| f.axis.as_ref().unwrap_or(clear));
        let mean = |of: &dyn Fn(&TrueAxis) -> [f64; 2]| {
            let sum = axes().map(of).fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
            sum.map(|s| s / self.frames.len() as f64)
        };
        [mean(&|a| axis_at(&a.still, z_mm)), mean(&|a| axis_at(&a.turning, z_mm))]
    }
}

/// The axis as it was seen: a whole station by the burst that the gauge took it from, so that it
/// steps only between stations; what lies in none by the nearest burst. `clear` where the tool was,
/// or where nothing was followed.
pub(super) fn axis_seen(
    followed: &[SeenBurst],
    clear: TrueAxis,
    length_mm: f64,
    stations: &[SeenStation],
) -> TrueAxis {
    if followed.is_empty() {
        return clear;
    }
    let mut seen = TrueAxis { still: Vec::new(), turning: Vec::new() };
    let mut add = |z_mm: f64, field_z_mm: f64| {
        let off = |b: &SeenBurst| b.distance_mm(field_z_mm);
        let Some(burst) = followed.iter().min_by(|a, b| off(a).total_cmp(&off(b))) else { return };
        let knot = |[x_mm, y_mm]: [f64; 2]| AxisKnot { z_mm, x_mm, y_mm };
        let [still, turning] = burst.at(z_mm, &clear).map(knot);
        seen.still.push(still);
        seen.turning.push(turning);
    };
    let mut reached = 0.0;
    for s in stations {
        places(reached, s.from_mm).for_each(|z_mm| add(z_mm, z_mm));
        places(s.from_mm, s.to_mm).for_each(|z_mm| add(z_mm, s.field_z_mm));
        reached = s.to_mm;
    }
    places(reached, length_mm).for_each(|z_mm| add(z_mm, z_mm));
    seen
}

/// Equal steps from one end to the other, both ends in them; none where nothing lies between.
fn places(from_mm: f64, to_mm: f64) -> impl Iterator<Item = f64> {
    let steps = ((to_mm - from_mm) / STEP_MM).ceil().max(0.0) as u32;
    let count = if steps == 0 { 0 } else { steps + 1 };
    (0..count).map(move |k| from_mm + (to_mm - from_mm) * f64::from(k) / f64::from(steps))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bent(x_mm: f64) -> Shaft {
        Shaft { deflection: vec![AxisKnot { z_mm: 0.0, x_mm, y_mm: 0.0 }], ..Shaft::cylinder(8.0) }
    }

    /// Two bursts that saw the axis at 1 and 2 mm: a station between both is that of its burst
    /// throughout, and only its ends are steps.
    #[test]
    fn a_station_is_that_of_one_burst() {
        let mut bursts = [SeenBurst::default(), SeenBurst::default()];
        bursts[0].add(10.0, &bent(1.0));
        bursts[1].add(20.0, &bent(1.9));
        bursts[1].add(20.2, &bent(2.1));
        let station =
            |from_mm: f64, field_z_mm: f64| SeenStation { from_mm, to_mm: from_mm + 4.0, field_z_mm };
        let seen = axis_seen(&bursts, axis_of(&bent(0.0)), 30.0, &[station(13.0, 10.0), station(17.0, 20.1)]);
        let x = |z_mm: f64| axis_at(&seen.still, z_mm)[0];
        for (z_mm, wanted) in [(2.0, 1.0), (13.1, 1.0), (16.99, 1.0), (17.01, 2.0), (20.9, 2.0), (30.0, 2.0)]
        {
            assert!((x(z_mm) - wanted).abs() < 1e-12, "{z_mm}: {}", x(z_mm));
        }
        assert!(seen.still.windows(2).all(|k| k[0].z_mm <= k[1].z_mm));
        let none = axis_seen(&[], axis_of(&bent(0.3)), 30.0, &[]);
        assert_eq!(none, axis_of(&bent(0.3)));
    }
}
