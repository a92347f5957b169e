//! The midline of the frames as readings for `calibrate machine`: the file of `--midline`.
//!
//! In: of every frame the commanded z, the spindle angle, height and slope of its midline. Out: a
//! CSV file as `[[readings]]` with `instrument = "midline"` takes it. A run is a sweep of z in one
//! direction; frames at one z follow each other, angle after angle.

use crate::frame::FrameMeta;
use crate::gauge::FieldMidline;

/// Closer than this two frames stand at one place, mm.
const SAME_MM: f64 = 1e-6;

/// A frame's midline.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MidlineRow {
    z_mm: f64,
    angle_deg: f64,
    midline: FieldMidline,
}

/// The midlines of all frames, in their order.
#[derive(Clone, Debug, Default)]
pub(crate) struct MidlineRows(Vec<MidlineRow>);

/// A sweep of z in one direction.
#[derive(Clone, Copy, Debug)]
struct Sweep {
    is_forward: bool,
    run: u32,
}

impl MidlineRows {
    /// Adds a frame's midline; a frame without one is left out.
    pub(crate) fn add(&mut self, meta: &FrameMeta, midline: Option<FieldMidline>) {
        let row = |midline| MidlineRow { z_mm: meta.z_mm, angle_deg: meta.angle_deg, midline };
        self.0.extend(midline.map(row));
    }

    /// Whether no frame had one.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The file.
    ///
    /// # Errors
    /// Frames that are all at one place: nothing is read along it.
    pub(crate) fn text(&self) -> Result<String, String> {
        let mut places: Vec<f64> = self.0.iter().map(|row| row.z_mm).collect();
        places.dedup_by(|a, b| (*a - *b).abs() <= SAME_MM);
        if places.len() < 2 {
            return Err(
                "needs frames at several z: z_mm and angle_deg of every frame stand in frames.csv beside them".to_owned()
            );
        }
        let sweeps = sweeps(&places);
        let mut text = "axis,position_mm,direction,run,error,value,unit,angle_deg\n".to_owned();
        for (error, unit) in [("midline", "um"), ("slope", "urad")] {
            let mut stop = 0;
            for row in &self.0 {
                if (row.z_mm - places[stop]).abs() > SAME_MM {
                    stop += 1;
                }
                let value = match unit {
                    "um" => 1e3 * (row.midline.height_mm - self.0[0].midline.height_mm),
                    _ => 1e6 * row.midline.slope_rad,
                };
                let Sweep { is_forward, run } = sweeps[stop];
                let direction = if is_forward { "forward" } else { "backward" };
                let (z, angle) = (row.z_mm, row.angle_deg);
                text += &format!("Z,{z},{direction},{run},{error},{value:.6},{unit},{angle}\n");
            }
        }
        Ok(text)
    }
}

/// The sweep of every place: where the direction turns, the next one begins.
fn sweeps(places: &[f64]) -> Vec<Sweep> {
    let is_up = |k: usize| places[k] > places[k - 1];
    let (mut runs, mut sweeps) = ([0, 0], Vec::with_capacity(places.len()));
    let mut current = None;
    for k in 0..places.len() {
        let is_forward = is_up(k.max(1));
        if current != Some(is_forward) {
            runs[usize::from(is_forward)] += 1;
            current = Some(is_forward);
        }
        sweeps.push(Sweep { is_forward, run: runs[usize::from(is_forward)] });
    }
    sweeps
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(places: &[(f64, f64, f64)]) -> Result<String, String> {
        let mut rows = MidlineRows::default();
        for (z_mm, angle_deg, height_mm) in places {
            let meta = FrameMeta { z_mm: *z_mm, angle_deg: *angle_deg, ..FrameMeta::default() };
            rows.add(&meta, Some(FieldMidline { height_mm: *height_mm, slope_rad: 2e-6 }));
            rows.add(&meta, None);
        }
        rows.text()
    }

    #[test]
    fn a_scan_there_and_back_has_a_run_each_way() {
        let there = [(0.0, 0.0, 1.0), (0.0, 180.0, 1.001), (5.0, 0.0, 1.002), (5.0, 180.0, 1.003)];
        let back = [(2.0, 0.0, 1.0), (2.0, 180.0, 1.0)];
        let text = text(&[&there[..], &back[..]].concat()).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 1 + 2 * 6);
        assert_eq!(lines[1], "Z,0,forward,1,midline,0.000000,um,0");
        assert_eq!(lines[2], "Z,0,forward,1,midline,1.000000,um,180");
        assert_eq!(lines[4], "Z,5,forward,1,midline,3.000000,um,180");
        assert_eq!(lines[5], "Z,2,backward,1,midline,0.000000,um,0");
        assert_eq!(lines[7], "Z,0,forward,1,slope,2.000000,urad,0");
    }

    #[test]
    fn frames_without_a_place_are_refused() {
        assert!(text(&[(0.0, 0.0, 1.0), (0.0, 180.0, 1.0)]).unwrap_err().contains("frames.csv"));
    }
}
