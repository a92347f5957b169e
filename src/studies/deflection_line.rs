//! `study deflection --line`: the axis of a shaft in the machine, by cause, in both planes.

use serde::Serialize;

use crate::plan::{CuttingData, DiameterOffset, PassPlan, PlannedForm};
use crate::process::bending::axis_at;
use crate::process::{
    BaseForm, Components, Contributions, ProcessError, ProcessSettings, Stock, TurningProcess,
};
use crate::shaft::AxisKnot;

/// Depth of the cut where the config is a beam without passes, mm: the first pass of the preset.
const DEPTH_MM: f64 = 0.25;
/// Stations of the table.
const STATIONS: usize = 20;

/// A shaft before its first pass.
#[derive(Clone, Debug)]
pub(crate) struct LineCase {
    /// The process.
    pub process: ProcessSettings,
    /// The blank.
    pub stock: Stock,
    /// Bow and eccentricity that stay with the part.
    pub form: BaseForm,
    /// Diameter that the pass aims at, mm; the stock less twice `DEPTH_MM` where there is none.
    pub nominal_mm: Option<f64>,
    /// Cutting data.
    pub cutting: CuttingData,
    /// Seed of the process.
    pub seed: u64,
}

/// The axis at a station, µm along x (up in the image) and y (towards the camera).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct LineRow {
    /// Machine z, mm.
    pub z_mm: f64,
    /// Self weight.
    pub weight_x_um: f64,
    /// Self weight.
    pub weight_y_um: f64,
    /// Offset of the tailstock.
    pub tailstock_x_um: f64,
    /// Offset of the tailstock.
    pub tailstock_y_um: f64,
    /// Cutting force.
    pub force_x_um: f64,
    /// Cutting force.
    pub force_y_um: f64,
    /// All components at rest.
    pub still_x_um: f64,
    /// All components at rest.
    pub still_y_um: f64,
    /// Eccentricity in the chuck and that of the body: turns with the part (body's 0°).
    pub chuck_x_um: f64,
    /// The same at the body's 90°.
    pub chuck_y_um: f64,
    /// Bow with its growth under the thrust: turns with the part.
    pub bow_x_um: f64,
    /// The same at the body's 90°.
    pub bow_y_um: f64,
    /// Run-out of the axis, µm: twice the distance of the turning line from the axis of rotation.
    pub run_out_um: f64,
}

/// The lines with the tool at a place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct LineStudy {
    /// Machine z of the tool, mm; `None` with the tool clear.
    pub tool_z_mm: Option<f64>,
    /// Force there, N.
    pub force: Components,
    /// Growth of the diameter by the heat of the cut there, µm.
    pub thermal_growth_um: f64,
    /// Rows along z.
    pub rows: Vec<LineRow>,
    /// The same at every node, for the chart.
    #[serde(skip)]
    pub nodes: Vec<LineRow>,
}

impl LineCase {
    /// The lines with the tool at `tool_z_mm` in the first pass, or clear after it.
    ///
    /// # Errors
    /// Where the process refuses its settings or the pass.
    pub(crate) fn run(&self, tool_z_mm: Option<f64>) -> Result<LineStudy, ProcessError> {
        let process = TurningProcess::new(&self.process, self.stock, &self.form, self.seed)?;
        let plan = PassPlan {
            pass: 1,
            nominal_mm: self.nominal_mm.unwrap_or(self.stock.diameter_mm - 2.0 * DEPTH_MM),
            cutting: self.cutting,
            station_z_mm: vec![0.5 * self.stock.length_mm],
            offset: DiameterOffset::zero(1),
            form: self.form.contour.clone().map_or(PlannedForm::PLAIN, PlannedForm::stepped),
        };
        let pass = process.followed(&plan)?;
        let lines = pass.contributions(tool_z_mm);
        let row = |z_mm: f64| self.row(&lines, z_mm);
        let length = self.stock.length_mm;
        let warm = tool_z_mm.map_or_else(
            || {
                process.as_scanned(&process.blank()).profile[0].radius_mm
                    - process.blank().profile[0].radius_mm
            },
            |z| pass.warm_radius_mm(z),
        );
        Ok(LineStudy {
            tool_z_mm,
            force: tool_z_mm.map_or_else(Components::default, |z| pass.force(z)),
            thermal_growth_um: 2e3 * warm,
            rows: (0..=STATIONS).map(|i| row(length * i as f64 / STATIONS as f64)).collect(),
            nodes: process.node_z_mm().map(row).collect(),
        })
    }

    fn row(&self, lines: &Contributions, z_mm: f64) -> LineRow {
        let um = |knots: &[AxisKnot]| axis_at(knots, z_mm).map(|mm| 1e3 * mm);
        let ([wx, wy], [tx, ty], [fx, fy]) = (um(&lines.weight), um(&lines.tailstock), um(&lines.force));
        let ([mut cx, mut cy], [bx, by]) = (um(&lines.chuck), um(&lines.bow));
        let offset = &self.form.eccentricity;
        let (sin, cos) = offset.phase_deg.to_radians().sin_cos();
        cx += 1e3 * offset.amplitude_mm * cos;
        cy += 1e3 * offset.amplitude_mm * sin;
        LineRow {
            z_mm,
            weight_x_um: wx,
            weight_y_um: wy,
            tailstock_x_um: tx,
            tailstock_y_um: ty,
            force_x_um: fx,
            force_y_um: fy,
            still_x_um: wx + tx + fx,
            still_y_um: wy + ty + fy,
            chuck_x_um: cx,
            chuck_y_um: cy,
            bow_x_um: bx,
            bow_y_um: by,
            run_out_um: 2.0 * (cx + bx).hypot(cy + by),
        }
    }
}
