//! A displacement probe on the X slide, as a second head: what it indicates of the part that the
//! same slides have cut.
//!
//! In: its settings, true diameters at places. Out: readings of the diameter less its nominal, with
//! noise drawn by seed. A probe on the tool's side is carried by the errors that cut the part and
//! shows it straight; on the opposite side it shows them twice. The ball of radius r touches along
//! the normal: its centre runs at R + r, so that a displacement along Y counts by h/(R + r), and on
//! a taper it stands off by r/cos α. Not drawn: the spindle's error motion within a reading (the
//! mean over a turn stands), a stylus that bends, texture (readings are of means over a station).

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use super::lathe::Lathe;
use super::run_settings::{DisplacementProbe, ProbeSide};
use crate::machine::response::{Part, Side, probe_mm};
use crate::setting::{SettingError, require, within};

/// Stream of the probe's noise.
const STREAM: u64 = 0x6d61_6368_7072_6f62;

/// A place of a part: the middle of a station, its nominal and its true diameter, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TruePlace {
    /// Machine z, mm.
    pub z_mm: f64,
    /// Nominal diameter, mm.
    pub nominal_mm: f64,
    /// True diameter, mm.
    pub true_mm: f64,
}

/// A row of `machine_probe.csv`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ProbeRow {
    /// Pass, from 1.
    pub pass: u32,
    /// Machine z, mm.
    pub z_mm: f64,
    /// Diameter less its nominal as the probe indicates it, µm.
    pub indicated_um: f64,
    /// Standard uncertainty by the probe's noise, µm: of the diameter, twice that of a
    /// displacement.
    pub u_um: f64,
}

impl DisplacementProbe {
    /// Checks its values on a lathe, for a part of these radii, mm.
    ///
    /// # Errors
    /// The first value out of range; an opposite side that X does not reach.
    pub(super) fn check(&self, lathe: &Lathe, [least, most]: [f64; 2]) -> Result<(), SettingError> {
        within("machine.probe.tip_radius_mm", self.tip_radius_mm, 0.0, 50.0, "between 0 and 50 mm")?;
        within("machine.probe.noise_um", self.noise_um, 0.0, 100.0, "between 0 and 100 µm")?;
        for (k, value) in self.probe_mm.into_iter().flatten().enumerate() {
            let right = "within ±10000 mm: is the number in µm?";
            within(&format!("machine.probe.probe_mm[{k}]"), value, -1e4, 1e4, right)?;
        }
        let settings = lathe.settings();
        let (tip, [from, to]) = (self.above_axis_mm(lathe), settings.x_travel_mm);
        let right = format!(
            "such that the tip stands within a quarter of the least diameter of the axis, {} mm",
            0.5 * least
        );
        require(tip.abs() <= 0.5 * least, "machine.probe.probe_mm[1]", tip, &right)?;
        for radius in [least, most] {
            let x = self.slide_mm(lathe, radius);
            let right = format!(
                "such that X = {x} mm lies in its travel from {from} to {to} mm, with the tip on a radius of {radius} mm"
            );
            require((from..=to).contains(&x), "machine.probe.side", format!("{:?}", self.side), &right)?;
        }
        Ok(())
    }

    /// From the X slide's reference to the tip, mm: the tool's where none is stated.
    fn lever(&self, lathe: &Lathe) -> [f64; 3] {
        self.probe_mm.unwrap_or(lathe.settings().tool_mm)
    }

    /// Height of the tip above the axis, mm.
    fn above_axis_mm(&self, lathe: &Lathe) -> f64 {
        let settings = lathe.settings();
        settings.tip_above_axis_mm + self.lever(lathe)[1] - settings.tool_mm[1]
    }

    /// Position of X with the tip on a radius, mm.
    fn slide_mm(&self, lathe: &Lathe, radius_mm: f64) -> f64 {
        let at = match self.side {
            ProbeSide::Tool => radius_mm,
            ProbeSide::Opposite => -radius_mm,
        };
        at + lathe.settings().tool_mm[0] - self.lever(lathe)[0]
    }

    /// What the probe indicates of a pass at its stations; `seed` is the job's.
    pub(crate) fn rows(&self, lathe: &Lathe, pass: u32, places: &[TruePlace], seed: u64) -> Vec<ProbeRow> {
        let mut random = Pcg64::seed_from_u64(seed ^ STREAM ^ (u64::from(pass) << 40));
        // a diameter is twice a displacement
        let u_mm = 2e-3 * self.noise_um;
        let row = |k: usize| {
            let noise: f64 = StandardNormal.sample(&mut random);
            let place = &places[k];
            let indicated_mm = self.indicated_mm(lathe, place, taper(places, k)) + u_mm * noise;
            ProbeRow { pass, z_mm: place.z_mm, indicated_um: 1e3 * indicated_mm, u_um: 1e3 * u_mm }
        };
        (0..places.len()).map(row).collect()
    }

    /// The diameter less its nominal as the probe indicates it, without noise, mm.
    fn indicated_mm(&self, lathe: &Lathe, place: &TruePlace, taper: f64) -> f64 {
        let (side, lever) = (self.response_side(), self.lever(lathe));
        let x_mm = if self.side == ProbeSide::Tool { 0.5 } else { -0.5 } * place.nominal_mm;
        let station = lathe.settings().on_x_slide(lever, x_mm, place.z_mm);
        let pose = lathe.scan_pose(&station);
        // the ball's centre runs on a cylinder that is larger by its diameter
        let ball = Part { diameter_mm: place.nominal_mm + 2.0 * self.tip_radius_mm, taper };
        let off = 2.0 * self.tip_radius_mm * ((0.5 * taper).hypot(1.0) - 1.0);
        place.true_mm - place.nominal_mm + off + probe_mm(&ball, self.above_axis_mm(lathe), side, &pose)
    }

    fn response_side(&self) -> Side {
        match self.side {
            ProbeSide::Tool => Side::Tool,
            ProbeSide::Opposite => Side::Opposite,
        }
    }
}

/// Growth of the diameter with z at a place, by its neighbours.
fn taper(places: &[TruePlace], k: usize) -> f64 {
    let (a, b) = (&places[k.saturating_sub(1)], &places[(k + 1).min(places.len() - 1)]);
    let along = b.z_mm - a.z_mm;
    if along > 0.0 { (b.true_mm - a.true_mm) / along } else { 0.0 }
}
