//! The edge-spread function of a job's own optics, for the gauge that looks through them:
//! `[gauge.esf.optics]`.

use crate::gauge::{EsfModel, EsfSamples};
use crate::render::RenderError;
use crate::render::optics::edge_spread::EdgeSpread;
use crate::render::optics::esf_table::{EsfTable, Extent, TablePlace};
use crate::render::settings::Optics;

/// Samples in the standard deviation of the sharpest detail: a cubic between them errs by
/// (1/16)⁴/384·max|F⁗| = 2e-8.
const STEPS_PER_SHARP: f64 = 16.0;
/// Most steps of a table; the diffraction rings of a laser extend far.
const MOST_STEPS: f64 = 20_000.0;
/// Relative light above which a table contains the rings of coherent light without a lens; the
/// gauge uses the same value.
const RINGED: f64 = 1.25;

/// Sampling of a table for the gauge: step, distance from which ripples fade out, farthest
/// distance, px.
#[derive(Clone, Copy, Debug)]
struct Sampling {
    step_px: f64,
    fade_px: f64,
    reach_px: f64,
}

/// Windows are 72 px long.
const PLAIN: Sampling = Sampling { step_px: 0.05, fade_px: 44.0, reach_px: 60.0 };
/// Windows over rings are 256 px long, and a pattern may be an eighth narrower than its nominal
/// one; the finest ring in them is 4 px wide.
const RINGS: Sampling = Sampling { step_px: 0.1, fade_px: 152.0, reach_px: 192.0 };

/// An edge-spread function, light over distance, of the nominal optics, without random deviations.
pub(crate) struct NominalEdge {
    table: EsfTable,
    place: TablePlace,
    pixel_um: f64,
}

impl NominalEdge {
    /// The edge of a cylinder of `radius_mm` whose axis lies `axis_y_mm` in front of the plane of
    /// focus, at a nominal `pixel_mm` on the object.
    ///
    /// # Errors
    /// Optics whose table cannot be computed.
    pub(crate) fn new(
        optics: &Optics,
        pixel_mm: f64,
        radius_mm: f64,
        axis_y_mm: f64,
    ) -> Result<Self, RenderError> {
        let extent = Extent { pixel_mm, depth_mm: axis_y_mm.abs(), radius_mm: (radius_mm, radius_mm) };
        let table = EsfTable::new(&optics.esf, optics, &extent)?;
        Ok(Self { place: table.place(axis_y_mm, radius_mm, 0.0), table, pixel_um: 1e3 * pixel_mm })
    }

    /// Light at a distance from the geometric edge into the light, µm on the object.
    pub(crate) fn light(&self, distance_um: f64) -> f64 {
        self.table.light(&self.place, distance_um / self.pixel_um)
    }

    /// Range in which it differs from shadow and light, µm on the object.
    pub(crate) fn range_um(&self) -> (f64, f64) {
        let stretched = self.place.scale_px / self.table.scale_px;
        let all = self.table.sources().iter().map(EdgeSpread::range_um);
        let (low, high) = all.fold((0.0_f64, 0.0_f64), |(l, h), (a, b)| (l.min(a), h.max(b)));
        if low < high {
            return (low * stretched, high * stretched);
        }
        let reach = f64::from(self.table.reach) * self.place.scale_px * self.pixel_um;
        (-reach, reach)
    }

    /// Standard deviation of a Gaussian as sharp as its finest detail, µm on the object.
    fn sharp_um(&self) -> f64 {
        self.table.sharp_px * self.pixel_um * self.place.scale_px / self.table.scale_px
    }

    /// Distances and light, even steps with the geometric edge on one of them.
    pub(crate) fn samples(&self) -> (Vec<f64>, Vec<f64>) {
        let (low, high) = self.range_um();
        let step = (self.sharp_um() / STEPS_PER_SHARP).max((high - low) / MOST_STEPS);
        let (from, to) = ((low / step).floor() as i64, (high / step).ceil() as i64);
        let distance_um: Vec<f64> = (from..=to).map(|k| k as f64 * step).collect();
        let light = distance_um.iter().map(|d| self.light(*d)).collect();
        (distance_um, light)
    }

    /// The model that a gauge fits, at a scale.
    pub(crate) fn model(&self, um_per_px: f64) -> EsfModel {
        let (from, to) = self.range_um();
        sampled_edge(from / um_per_px, to / um_per_px, |d_px| self.light(d_px * um_per_px))
    }
}

/// Samples over a range of an edge in px, widened by a pixel so that the ends are flat. Ripples
/// that extend beyond the largest table (a laser's) fade out beyond the windows.
pub(crate) fn sampled_edge(from_px: f64, to_px: f64, light: impl Fn(f64) -> f64) -> EsfModel {
    let sample = |sampling: Sampling| {
        let Sampling { step_px, fade_px, reach_px } = sampling;
        let fade = |d_px: f64| {
            let t = ((d_px - fade_px) / (reach_px - fade_px)).clamp(0.0, 1.0);
            0.5 + 0.5 * (std::f64::consts::PI * t).cos()
        };
        let end = |d: f64| ((d.abs() + 1.0).min(reach_px) / step_px).ceil() as i32;
        let distance_px: Vec<f64> = (-end(from_px)..=end(to_px)).map(|k| step_px * f64::from(k)).collect();
        let light: Vec<f64> = distance_px.iter().map(|d| 1.0 + (light(*d) - 1.0) * fade(*d)).collect();
        EsfSamples { distance_px, light }
    };
    let rings = sample(RINGS);
    let is_ringed = rings.light.iter().any(|light| *light > RINGED);
    EsfModel::Table(if is_ringed { rings } else { sample(PLAIN) })
}
