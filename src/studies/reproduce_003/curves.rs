//! Figs 7 to 9 and 11 as curves over z, and the choice of cutting data over generations and passes.

use super::deflection::Model;
use super::inputs::{Figure, Force};
use crate::process::fit::ForcePoint;
use crate::studies::optimize::PassTime;
use crate::studies::optimize::genetic::Generation;

/// A curve (x, y) and the paper's printed point on it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Curve {
    /// Its name in the legend.
    pub name: String,
    /// Points.
    pub points: Vec<(f64, f64)>,
    /// The paper's printed point; absent where it prints none.
    pub printed: Option<(f64, f64)>,
}

/// All curves.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Curves {
    /// Size error over the tool's position (mm, µm of diameter), one curve per depth of cut.
    pub fig_7: Vec<Curve>,
    /// The same, one curve per cutting speed.
    pub fig_8: Vec<Curve>,
    /// The same, one curve per feed.
    pub fig_9: Vec<Curve>,
    /// Deflection line under a load that stays at node 71 (mm, µm of diameter), with row 1 of Table
    /// 1.
    pub fixed_load: Vec<Curve>,
    /// Fig. 11a: error over z (mm, µm of diameter) on the physical plant, one curve per pass,
    /// without control.
    pub fig_11_none: Vec<Curve>,
    /// Fig. 11b: the same under PID, offsets accumulated.
    pub fig_11_pid: Vec<Curve>,
    /// Fig. 11a through frames; empty where nothing was rendered.
    pub frames_none: Vec<Curve>,
    /// Fig. 11b through frames.
    pub frames_pid: Vec<Curve>,
    /// The genetic algorithm's best of every generation at the first seed.
    pub generations: Vec<Generation>,
    /// The shortest time, min; absent where nothing is feasible.
    pub optimum_min: Option<f64>,
    /// Time over the number of passes at the printed cutting data.
    pub passes: Vec<PassTime>,
    /// The printed time, min.
    pub printed_min: f64,
}

/// Points of a curve over z.
const POINTS: usize = 200;

impl Curves {
    /// Figs 7 to 9.
    pub(super) fn of_figures(model: &Model<'_>) -> Self {
        let inputs = model.inputs;
        let beam = &inputs.beam;
        let shape: Vec<(f64, f64)> = (0..=POINTS)
            .map(|i| beam.length_mm * i as f64 / POINTS as f64)
            .map(|z| (z, 2e3 * model.shaft.compliance_mm_per_n(z)))
            .collect();
        let curve = |name: String, force_n: f64, figure: &Figure| Curve {
            name,
            points: shape.iter().map(|(z, w)| (*z, w * force_n)).collect(),
            printed: Some((beam.position_mm, figure.error_um)),
        };
        let of_table = |figures: &[Figure], table: &[Force], name: fn(&ForcePoint) -> String| {
            figures
                .iter()
                .map(|f| (f, table[f.row - 1].meant()))
                .map(|(f, p)| curve(name(&p), p.force_n, f))
                .collect::<Vec<Curve>>()
        };
        let figures = &inputs.figures;
        let fixed = figures.fig_7.first().map(|f| (f, inputs.table_1[f.row - 1].meant()));
        Self {
            fig_7: of_table(&figures.fig_7, &inputs.table_1, |p| format!("a_p {:.2} mm", p.depth_mm)),
            fig_8: of_table(&figures.fig_8, &inputs.table_2, |p| format!("v {} m/min", p.speed_m_per_min)),
            fig_9: figures
                .fig_9
                .iter()
                .map(|f| {
                    curve(
                        format!("f {:.2} mm/r", f.feed_mm_per_rev),
                        model.fig_9_force_n(f.feed_mm_per_rev),
                        f,
                    )
                })
                .collect(),
            fixed_load: fixed
                .map(|(f, p)| Curve {
                    name: format!("load fixed at node {}, a_p {:.2} mm", beam.loaded_node, p.depth_mm),
                    points: model.fixed_load().iter().map(|(z, w)| (*z, w * p.force_n)).collect(),
                    printed: Some((beam.position_mm, f.error_um)),
                })
                .into_iter()
                .collect(),
            ..Self::default()
        }
    }
}

/// The error over z of every pass (mm, mm), in µm and with the paper's value at its position.
pub(super) fn of_passes(profiles: &[Vec<(f64, f64)>], printed_mm: &[f64], position_mm: f64) -> Vec<Curve> {
    let curve = |(k, profile): (usize, &Vec<(f64, f64)>)| Curve {
        name: format!("pass {}", k + 1),
        points: profile.iter().map(|(z, e)| (*z, 1e3 * e)).collect(),
        printed: printed_mm.get(k).map(|e| (position_mm, 1e3 * e)),
    };
    profiles.iter().enumerate().map(curve).collect()
}
