//! A scene: one shaft in one optical setup, prepared for rendering at any field and angle.

use std::sync::Arc;

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::request::FrameRequest;
use super::true_optics::OpticalSetup;
use crate::render::error::RenderError;
use crate::render::kernel::column_edges::{ColumnEdges, RowBlur};
#[cfg(test)]
use crate::render::optics::edge_spread::EdgeSpread;
use crate::render::optics::edge_spread::LaserShadow;
use crate::render::optics::esf_table::{EsfTable, Extent};
use crate::render::optics::settings::Esf;
use crate::render::silhouette::{Outline, Turned, View};
use crate::shaft::Shaft;

/// Stream of the spindle's asynchronous error motion.
const ASYNCHRONOUS_STREAM: u64 = 0x6173_796e_6368;

/// Smallest distance between a pinhole and the shaft, mm.
const CLEARANCE_MM: f64 = 1.0;

/// One shaft in one optical setup.
#[derive(Clone, Debug)]
pub struct Scene {
    pub(super) setup: OpticalSetup,
    pub(super) outline: Outline,
    pub(super) esf: Arc<EsfTable>,
    pub(super) blur: RowBlur,
    /// One over the distance of the pinhole, 1/mm; 0 for a telecentric lens.
    pub(super) per_distance: f64,
    /// Largest distance of any axis from the plane of focus, mm.
    pub(super) depth_mm: f64,
    /// Standard deviation of the widest Gaussian, px.
    pub(super) largest_sigma_px: f64,
    /// Largest displacement of a corner along z by tilt, perspective and distortion, mm.
    pub(super) margin_mm: f64,
    pub(super) wiped: bool,
}

impl Scene {
    /// Prepares a shaft for the optical setup: bounds, tables.
    ///
    /// # Errors
    /// Refuses a shaft that cannot be drawn, or that exceeds the field everywhere; other cases are
    /// refused per frame.
    pub fn new(setup: &OpticalSetup, shaft: Shaft) -> Result<Self, RenderError> {
        let outline = Outline::new(shaft)?;
        let field_mm = setup.rows() as f64 * setup.pixel_mm;
        let smallest = 2.0 * outline.smallest_radius_mm();
        if smallest > field_mm {
            return Err(RenderError::Field {
                what: format!(
                    "the shaft's diameter of {smallest:.3} mm exceeds the field of {field_mm:.3} mm ({} rows of {:.3} µm): lower optics.magnification or take more rows",
                    setup.rows(),
                    setup.pixel_mm * 1e3
                ),
            });
        }
        let per_distance = per_distance(setup, &outline)?;
        let pose = outline.shaft().pose;
        let lean = (pose.tilt_to_camera_mrad * 1e-3).sin().abs();
        let half_mm = 0.5 * setup.columns() as f64 * setup.pixel_mm;
        let curved_mm = setup.nominal.optics.field_curvature.map_or(0.0, |c| c.largest_mm());
        let depth_mm = outline.largest_depth_mm() + half_mm * lean + curved_mm;
        let radius_mm = outline.mean_radii_mm();
        let esf = setup.tables.table(
            &setup.esf,
            &setup.nominal.optics,
            &Extent { pixel_mm: setup.pixel_mm, depth_mm, radius_mm },
        )?;
        let margin_mm = radius_mm.1 * ((pose.tilt_mrad * 1e-3).sin().abs() + lean)
            + (half_mm + radius_mm.1) * radius_mm.1 * per_distance.abs()
            + sideways_px(setup) * setup.pixel_mm;
        let widest = if esf.widens { esf.place(depth_mm, radius_mm.1, 0.0).scale_px } else { esf.blur_px };
        let blur = RowBlur::new(esf.blur_px);
        let (setup, largest_sigma_px) = (setup.clone(), widest);
        Ok(Self {
            setup,
            outline,
            esf,
            blur,
            per_distance,
            depth_mm,
            largest_sigma_px,
            margin_mm,
            wiped: false,
        })
    }

    /// The same scene without films on the shaft, whatever contaminates window and air.
    #[must_use]
    pub(crate) fn wiped(self) -> Self {
        Self { wiped: true, ..self }
    }

    /// The true optical setup.
    pub fn setup(&self) -> &OpticalSetup {
        &self.setup
    }

    /// The shaft's outline.
    #[cfg(test)]
    pub(crate) fn outline(&self) -> &Outline {
        &self.outline
    }

    /// The edge spreads of the scene in f64, µm on the object; none where it is the plain Gaussian.
    #[cfg(test)]
    pub(crate) fn edge_spreads(&self) -> &[EdgeSpread] {
        self.esf.sources()
    }

    /// The shaft at a spindle angle, with the asynchronous error motion of this frame.
    pub(crate) fn turned(&self, request: &FrameRequest, angle_deg: f64) -> Turned<'_> {
        let turned = self.outline.turned(angle_deg);
        let rms_um = self.outline.shaft().spindle.asynchronous_rms_um;
        if rms_um == 0.0 {
            return turned;
        }
        let key = request.seed ^ ASYNCHRONOUS_STREAM ^ request.frame_id.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut random = Pcg64::seed_from_u64(key);
        let mut draw = || {
            let z: f64 = StandardNormal.sample(&mut random);
            1e-3 * rms_um * z.clamp(-4.0, 4.0)
        };
        turned.shifted(draw(), draw())
    }

    /// Whether every slice projects independently.
    pub(crate) fn is_straight(&self) -> bool {
        self.view(0.0).is_straight(self.outline.shaft().pose.tilt_to_camera_mrad)
    }

    pub(super) fn view(&self, field_z_mm: f64) -> View {
        View { middle_z_mm: field_z_mm, per_distance: self.per_distance }
    }

    /// Exact edges at a fractional column, in rows of the full sensor.
    pub(crate) fn edges_at(&self, turned: &Turned<'_>, field_z_mm: f64, sensor_column: f64) -> ColumnEdges {
        let distortion = &self.setup.nominal.optics.distortion;
        let view = self.view(field_z_mm);
        if distortion.is_none() {
            let pair = turned.edges_seen(self.setup.column_z_mm(field_z_mm, sensor_column), &view);
            return ColumnEdges {
                top_px: self.setup.row_of_x(pair.top_mm),
                bottom_px: self.setup.row_of_x(pair.bottom_mm),
            };
        }
        let ideal = |upper: bool| {
            distortion.edge_row(sensor_column, self.setup.rows(), self.setup.columns(), |c| {
                self.setup.row_of_x(turned.edge_seen(self.setup.column_z_mm(field_z_mm, c), &view, upper))
            })
        };
        ColumnEdges { top_px: ideal(true), bottom_px: ideal(false) }
    }

    /// The laser, for outlines of level pieces between shoulders, where the amplitude at the
    /// corners has a closed form.
    pub(crate) fn laser_shoulders(&self) -> Option<&LaserShadow> {
        let Esf::Fresnel(laser) = &self.setup.esf else { return None };
        let optics = &self.setup.nominal.optics;
        let plain = self.is_straight() && optics.distortion.is_none() && optics.reflection.is_none();
        (plain && self.outline.is_stepped()).then_some(laser)
    }
}

/// One over the distance of the pinhole: that of an entocentric lens, or the one whose rays cross
/// the telecentric lens' residual angle at half the diagonal.
fn per_distance(setup: &OpticalSetup, outline: &Outline) -> Result<f64, RenderError> {
    let optics = &setup.nominal.optics;
    let half_mm = 0.5 * (setup.rows() as f64).hypot(setup.columns() as f64) * setup.pixel_mm;
    let per_distance = match optics.entocentric {
        Some(e) => 1.0 / e.distance_mm,
        None => (optics.telecentricity_mrad * 1e-3).tan() / half_mm,
    };
    let needed = outline.mean_radii_mm().1 + outline.largest_depth_mm() + CLEARANCE_MM;
    if per_distance.abs() * needed < 1.0 {
        return Ok(per_distance);
    }
    let right = format!("must leave the shaft in front of the lens: at least {needed:.3} mm");
    Err(RenderError::setting("optics.entocentric.distance_mm", &(1.0 / per_distance), right))
}

/// Largest displacement of a point of the sensor's border along the row by distortion, px.
fn sideways_px(setup: &OpticalSetup) -> f64 {
    let distortion = &setup.nominal.optics.distortion;
    if distortion.is_none() {
        return 0.0;
    }
    let (rows, columns) = (setup.rows(), setup.columns());
    let border = (0..=16).flat_map(|i| {
        let (r, c) = ((rows - 1) as f64 * f64::from(i) / 16.0, (columns - 1) as f64 * f64::from(i) / 16.0);
        [(r, 0.0), (r, (columns - 1) as f64), (0.0, c), ((rows - 1) as f64, c)]
    });
    border.map(|(r, c)| (distortion.distort_px(r, c, rows, columns).1 - c).abs()).fold(0.0, f64::max)
}
