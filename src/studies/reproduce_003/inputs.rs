//! The paper's printed values.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::ReproductionError;
use crate::process::fit::ForcePoint;

/// Everything the paper prints that a row needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Inputs {
    /// The finite-element model.
    pub beam: Beam,
    /// Exponents that the tables do not vary.
    pub handbook: Handbook,
    /// Table 1 (depth of cut).
    pub table_1: Vec<Force>,
    /// Table 2 (cutting speed).
    pub table_2: Vec<Force>,
    /// Figs 7 to 9.
    pub figures: Figures,
    /// The chosen cutting data.
    pub optimum: OptimumInput,
    /// The controller and Fig. 11.
    pub pid: PidInput,
    /// The shaft of Fig. 11 as it is taken here; the paper describes it by diameter and cutting
    /// data alone.
    #[serde(default)]
    pub plant: PlantInput,
}

/// The finite-element model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Beam {
    /// Length, mm.
    pub length_mm: f64,
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Young's modulus as meant, N/mm².
    pub youngs_modulus_n_per_mm2: f64,
    /// Young's modulus as printed, N/mm².
    pub youngs_modulus_printed_n_per_mm2: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Position that Figs 7 to 9 are read at, mm.
    pub position_mm: f64,
    /// Nodes of the finite-element model.
    #[serde(default = "nodes")]
    pub nodes: usize,
    /// Node, from 1 at the chuck, at which forces are said to be applied.
    #[serde(default = "loaded_node")]
    pub loaded_node: usize,
}

fn nodes() -> usize {
    100
}

fn loaded_node() -> usize {
    71
}

/// Exponents of the force law that a table does not vary.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Handbook {
    /// Depth.
    pub depth_exponent: f64,
    /// Feed.
    pub feed_exponent: f64,
    /// Speed.
    pub speed_exponent: f64,
    /// C of the radial force with a carbide tool of the handbook's reference geometry on steel of
    /// σ_b = 650 MPa, N (Ai Xing, Xiao Shigang, Qiexiao yongliang jianming shouce, 1994; exponents
    /// .9, .6 and -.3): Tables 1 and 2 are compared with it.
    #[serde(default = "passive_coefficient")]
    pub passive_coefficient_n: f64,
    /// Tangential over radial force, a rule of thumb.
    #[serde(default = "cutting_ratio")]
    pub cutting_ratio: f64,
}

fn passive_coefficient() -> f64 {
    1950.0
}

fn cutting_ratio() -> f64 {
    2.5
}

/// The shaft of Fig. 11 as it is taken here.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct PlantInput {
    /// Length, mm: twice the position at which Fig. 11 is read.
    pub length_mm: f64,
    /// Diameter after the last of the four passes, mm (printed).
    pub final_diameter_mm: f64,
    /// Radial stiffness of spindle and chuck, N/µm.
    pub chuck_n_per_um: f64,
    /// Radial stiffness of the tailstock, N/µm.
    pub tailstock_n_per_um: f64,
}

impl Default for PlantInput {
    fn default() -> Self {
        Self { length_mm: 500.0, final_diameter_mm: 25.0, chuck_n_per_um: 50.0, tailstock_n_per_um: 20.0 }
    }
}

/// A row of Table 1 or 2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Force {
    /// Depth of cut as printed, mm.
    #[serde(default = "depth")]
    pub depth_mm: f64,
    /// Cutting speed, m/min.
    #[serde(default = "speed")]
    pub speed_m_per_min: f64,
    /// Feed, mm/r.
    #[serde(default = "feed")]
    pub feed_mm_per_rev: f64,
    /// Radial force as printed, N.
    pub force_n: f64,
    /// Depth as meant, where it is misprinted.
    #[serde(default)]
    pub meant_depth_mm: Option<f64>,
    /// Force as meant, where it is misprinted.
    #[serde(default)]
    pub meant_force_n: Option<f64>,
}

fn depth() -> f64 {
    0.20
}

fn speed() -> f64 {
    40.0
}

fn feed() -> f64 {
    0.10
}

impl Force {
    /// The row as meant.
    pub(crate) fn meant(&self) -> ForcePoint {
        ForcePoint {
            depth_mm: self.meant_depth_mm.unwrap_or(self.depth_mm),
            speed_m_per_min: self.speed_m_per_min,
            feed_mm_per_rev: self.feed_mm_per_rev,
            force_n: self.meant_force_n.unwrap_or(self.force_n),
        }
    }
}

/// A size error read from a figure: of a row of the table, or at a feed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Figure {
    /// Row of the table, from 1.
    #[serde(default)]
    pub row: usize,
    /// Feed, mm/r.
    #[serde(default)]
    pub feed_mm_per_rev: f64,
    /// Size error, µm.
    pub error_um: f64,
}

/// Figs 7 to 9.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Figures {
    /// Over Table 1.
    pub fig_7: Vec<Figure>,
    /// Over Table 2.
    pub fig_8: Vec<Figure>,
    /// Over the feed.
    pub fig_9: Vec<Figure>,
    /// Depth of cut behind Fig. 9, mm.
    pub fig_9_depth_mm: f64,
    /// Cutting speed behind Fig. 9, m/min.
    pub fig_9_speed_m_per_min: f64,
}

/// The chosen cutting data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct OptimumInput {
    /// Cutting speed, m/min.
    pub speed_m_per_min: f64,
    /// Feed, mm/r.
    pub feed_mm_per_rev: f64,
    /// Depth of cut, mm.
    pub depth_mm: f64,
    /// Finishing time, min.
    pub time_min: f64,
    /// Roughness found, µm.
    pub roughness_um: f64,
    /// Size error found, mm.
    pub size_error_mm: f64,
    /// Size error allowed, mm.
    pub size_limit_mm: f64,
    /// Seeds of the genetic algorithm to run.
    pub seeds: u64,
    /// t_h, min, which the paper does not print; given, eq. 4 is determined by it.
    #[serde(default)]
    pub tool_change_min: Option<f64>,
    /// t_q, min, not printed.
    #[serde(default)]
    pub auxiliary_min: Option<f64>,
    /// n of eq. 5, not printed.
    #[serde(default)]
    pub passes: Option<u32>,
    /// C of the force law behind eq. 6, N, not printed: Tables 1 and 2 differ by nine times.
    #[serde(default)]
    pub force_coefficient_n: Option<f64>,
}

/// The controller and Fig. 11.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PidInput {
    /// Kp.
    pub kp: f64,
    /// Ki.
    pub ki: f64,
    /// Kd.
    pub kd: f64,
    /// Fig. 11a, mm.
    pub uncompensated_mm: Vec<f64>,
    /// Fig. 11b, mm.
    pub compensated_mm: Vec<f64>,
    /// α of the error-transfer plant e(k+1) = α·e(k) - g·u(k).
    pub transfer_alpha: f64,
    /// g of it.
    pub transfer_gain: f64,
    /// Position Fig. 11 is read at, mm.
    pub position_mm: f64,
    /// Change of the diameter over the change of the offset on the machine of Fig. 11, which the
    /// paper does not print.
    #[serde(default)]
    pub plant_gain: Option<f64>,
}

impl Inputs {
    pub(super) fn check(&self) -> Result<(), ReproductionError> {
        let beam = &self.beam;
        positive("beam.length_mm", beam.length_mm)?;
        positive("beam.diameter_mm", beam.diameter_mm)?;
        positive("beam.youngs_modulus_n_per_mm2", beam.youngs_modulus_n_per_mm2)?;
        positive("beam.youngs_modulus_printed_n_per_mm2", beam.youngs_modulus_printed_n_per_mm2)?;
        if !(2..=10_000).contains(&beam.nodes) || !(1..=beam.nodes).contains(&beam.loaded_node) {
            let problem = format!(
                "{} of {} nodes is not possible; it must be one of 2 to 10000 nodes",
                beam.loaded_node, beam.nodes
            );
            return Err(ReproductionError::Input { key: "beam.loaded_node".to_owned(), problem });
        }
        positive("handbook.passive_coefficient_n", self.handbook.passive_coefficient_n)?;
        positive("handbook.cutting_ratio", self.handbook.cutting_ratio)?;
        positive("plant.length_mm", self.plant.length_mm)?;
        positive("plant.final_diameter_mm", self.plant.final_diameter_mm)?;
        positive("plant.chuck_n_per_um", self.plant.chuck_n_per_um)?;
        positive("plant.tailstock_n_per_um", self.plant.tailstock_n_per_um)?;
        self.check_tables()?;
        let passes = [self.pid.uncompensated_mm.len(), self.pid.compensated_mm.len()];
        if passes != [4, 4] {
            let problem = format!("has {} and {} passes; Fig. 11 shows four of each", passes[0], passes[1]);
            return Err(ReproductionError::Input { key: "pid.compensated_mm".to_owned(), problem });
        }
        positive("pid.uncompensated_mm[0]", self.pid.uncompensated_mm[0])?;
        positive("pid.ki", self.pid.ki)?;
        positive("pid.kp", self.pid.kp)
    }

    fn check_tables(&self) -> Result<(), ReproductionError> {
        for (name, table) in [("table_1", &self.table_1), ("table_2", &self.table_2)] {
            for (index, row) in table.iter().enumerate() {
                let p = row.meant();
                for (key, value) in [
                    ("depth_mm", p.depth_mm),
                    ("speed_m_per_min", p.speed_m_per_min),
                    ("feed_mm_per_rev", p.feed_mm_per_rev),
                    ("force_n", p.force_n.min(row.force_n)),
                ] {
                    positive(&format!("{name}[{index}].{key}"), value)?;
                }
            }
        }
        for (name, figure, rows) in [
            ("fig_7", &self.figures.fig_7, self.table_1.len()),
            ("fig_8", &self.figures.fig_8, self.table_2.len()),
        ] {
            if let Some(index) = figure.iter().position(|f| f.row == 0 || f.row > rows) {
                let problem = format!("names row {} of a table of {rows}", figure[index].row);
                return Err(ReproductionError::Input {
                    key: format!("figures.{name}[{index}].row"),
                    problem,
                });
            }
        }
        Ok(())
    }
}

fn positive(key: &str, value: f64) -> Result<(), ReproductionError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    let problem = format!("{value} is not possible; it must be above 0");
    Err(ReproductionError::Input { key: key.to_owned(), problem })
}
