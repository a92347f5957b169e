//! One turning pass: what the tool was told against what it left behind.
//!
//! The tool is commanded to the diameter b(z) and travels from tailstock to chuck, so that the shaft is already
//! thin behind it and still thick ahead. At every node the depth really cut a = (D_before - D)/2 solves
//! a + w·F(a) = (D_before - b)/2 with the compliance w of the half-cut shaft, and D = b + 2·w·F(a). Errors of the
//! diameter before therefore show again in the diameter after (error copying), reduced by 1/(1 + w·dF/da).
//! Diameters are those of the unloaded shaft.

use thiserror::Error;

use super::beam::{Part, Supports, compliance_at_joint, left_parts};
use super::force::DepthLaw;
use super::section::Section;
use super::settings::{ProcessSettings, SettingsError};
use super::texture;
use crate::plan::PassPlan;
use crate::shaft::{AxisKnot, Eccentricity, Lobe, Pose, ProfileKnot, Shaft};

/// Why a pass was not cut.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ProcessError {
    /// A setting outside its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A blank that cannot be turned.
    #[error(
        "a blank of diameter {diameter_mm} mm and length {length_mm} mm cannot be turned; both must be above 0"
    )]
    Stock {
        /// Diameter, mm.
        diameter_mm: f64,
        /// Length, mm.
        length_mm: f64,
    },
    /// A plan that cannot be followed.
    #[error("pass {pass} cannot be cut: {what}")]
    Plan {
        /// Number of the pass.
        pass: u32,
        /// What is wrong, and what would be right.
        what: String,
    },
    /// The edge would rub instead of cutting; the force law does not hold there.
    #[error(
        "pass {pass} would cut only {depth_mm:.4} mm deep at z = {z_mm:.1} mm, below the minimum chip of {minimum_chip_mm} mm: \
         leave more stock or lower process.pass.minimum_chip_mm"
    )]
    BelowMinimumChip {
        /// Number of the pass.
        pass: u32,
        /// Where, mm.
        z_mm: f64,
        /// Depth that would be cut, mm.
        depth_mm: f64,
        /// The limit, mm.
        minimum_chip_mm: f64,
    },
}

/// The blank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stock {
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Free length between chuck face and tailstock, mm.
    pub length_mm: f64,
}

/// Form that stays with the workpiece and its clamping through all passes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BaseForm {
    /// Lobing that every pass leaves (spindle error, three-jaw clamping).
    pub lobes: Vec<Lobe>,
    /// Offset of the body from the axis of rotation.
    pub eccentricity: Eccentricity,
    /// Bow of the body.
    pub bow: Vec<AxisKnot>,
    /// How the axis lies in the camera's field.
    pub pose: Pose,
}

/// What the cut of a pass looked like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutSummary {
    /// Number of the pass.
    pub pass: u32,
    /// Smallest depth really cut, mm.
    pub min_depth_mm: f64,
    /// Largest depth really cut, mm.
    pub max_depth_mm: f64,
    /// Largest radial force, N.
    pub max_force_n: f64,
    /// Largest radial deflection at the tool, mm.
    pub max_deflection_mm: f64,
}

/// A workpiece in the machine, pass after pass.
#[derive(Clone, Debug)]
pub struct TurningProcess {
    settings: ProcessSettings,
    form: BaseForm,
    seed: u64,
    step_mm: f64,
    diameter_mm: Vec<f64>,
    last_cut: Option<CutSummary>,
}

impl TurningProcess {
    /// Clamps a blank. `seed` alone (with the number of the pass) decides every random feature of the surface.
    ///
    /// # Errors
    /// Refuses settings out of range and a blank without extent.
    pub fn new(
        settings: &ProcessSettings,
        stock: Stock,
        form: &BaseForm,
        seed: u64,
    ) -> Result<Self, ProcessError> {
        settings.validate()?;
        let Stock { diameter_mm, length_mm } = stock;
        let extent = |value: f64| value > 0.0 && value.is_finite();
        if !extent(diameter_mm) || !extent(length_mm) {
            return Err(ProcessError::Stock { diameter_mm, length_mm });
        }
        let elements = (length_mm / settings.pass.node_mm).round().clamp(2.0, 1e6) as usize;
        Ok(Self {
            settings: settings.clone(),
            form: form.clone(),
            seed,
            step_mm: length_mm / elements as f64,
            diameter_mm: vec![diameter_mm; elements + 1],
            last_cut: None,
        })
    }

    /// Machine z of the nodes, mm, ascending from 0 to the length.
    pub fn node_z_mm(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.diameter_mm.len()).map(|node| node as f64 * self.step_mm)
    }

    /// Mean diameter of the unloaded workpiece at every node, mm.
    pub fn diameter_mm(&self) -> &[f64] {
        &self.diameter_mm
    }

    /// What the last pass cut.
    pub fn last_cut(&self) -> Option<&CutSummary> {
        self.last_cut.as_ref()
    }

    /// Cuts a pass and gives the shaft that remains. On an error the workpiece is as before.
    ///
    /// # Errors
    /// A plan that contradicts itself, and a depth of cut below the minimum chip.
    pub fn cut(&mut self, plan: &PassPlan) -> Result<Shaft, ProcessError> {
        check_plan(plan)?;
        let commanded = self.tool_path(plan);
        let law = self.settings.force.at(&plan.cutting);
        let cut = Cut {
            before: &self.diameter_mm,
            commanded: &commanded,
            law,
            step_mm: self.step_mm,
            settings: &self.settings,
        };
        let (diameter, summary) = cut.run(plan.pass);
        self.check_chip(plan.pass, &diameter)?;
        self.diameter_mm = diameter;
        self.last_cut = Some(summary);
        Ok(self.shaft(plan.pass))
    }

    /// Commanded diameter at every node: linear between station middles, the end pieces continued.
    fn tool_path(&self, plan: &PassPlan) -> Vec<f64> {
        let stations: Vec<f64> = plan.commanded_mm().collect();
        let mut upper = 1;
        self.node_z_mm()
            .map(|z| {
                while upper + 1 < stations.len() && plan.station_z_mm[upper] < z {
                    upper += 1;
                }
                linear(&plan.station_z_mm, &stations, upper, z)
            })
            .collect()
    }

    fn check_chip(&self, pass: u32, after: &[f64]) -> Result<(), ProcessError> {
        let minimum_chip_mm = self.settings.pass.minimum_chip_mm;
        let depths = self.diameter_mm.iter().zip(after).map(|(before, after)| 0.5 * (before - after));
        let least = self.node_z_mm().zip(depths).min_by(|a, b| a.1.total_cmp(&b.1));
        match least {
            Some((z_mm, depth_mm)) if depth_mm < minimum_chip_mm => {
                Err(ProcessError::BelowMinimumChip { pass, z_mm, depth_mm, minimum_chip_mm })
            }
            _ => Ok(()),
        }
    }

    /// The workpiece with the surface that pass `pass` leaves.
    fn shaft(&self, pass: u32) -> Shaft {
        let texture = &self.settings.texture;
        let length_mm = self.step_mm * (self.diameter_mm.len() - 1) as f64;
        let mut lobes = self.form.lobes.clone();
        lobes.extend(texture::small_lobes(texture, self.seed, pass));
        let knot = |(z_mm, diameter): (f64, &f64)| ProfileKnot { z_mm, radius_mm: 0.5 * diameter };
        Shaft {
            profile: self.node_z_mm().zip(&self.diameter_mm).map(knot).collect(),
            lobes,
            texture: texture::surface(texture, length_mm, self.seed, pass),
            eccentricity: self.form.eccentricity,
            bow: self.form.bow.clone(),
            deflection: Vec::new(),
            pose: self.form.pose,
        }
    }
}

/// Value at `z` on the line through knots `upper - 1` and `upper`; the only value where there is one.
fn linear(knots: &[f64], values: &[f64], upper: usize, z: f64) -> f64 {
    let (Some(&z1), Some(&v1)) = (knots.get(upper), values.get(upper)) else {
        return values[0];
    };
    let (z0, v0) = (knots[upper - 1], values[upper - 1]);
    v0 + (v1 - v0) * (z - z0) / (z1 - z0)
}

fn check_plan(plan: &PassPlan) -> Result<(), ProcessError> {
    let refuse = |what: String| Err(ProcessError::Plan { pass: plan.pass, what });
    let (stations, offsets) = (plan.station_z_mm.len(), plan.offset.o_mm.len());
    if stations == 0 || stations != offsets {
        return refuse(format!(
            "{offsets} offsets for {stations} stations; there must be one each, at least one"
        ));
    }
    if plan.station_z_mm.windows(2).any(|pair| pair[1] <= pair[0] || !pair[1].is_finite()) {
        return refuse("the stations' middles must ascend along z".to_owned());
    }
    if let Some(b) = plan.commanded_mm().find(|b| !b.is_finite() || *b <= 0.0) {
        return refuse(format!("a commanded diameter of {b} mm; it must be above 0"));
    }
    let data = [("speed", plan.cutting.speed_m_per_min), ("feed", plan.cutting.feed_mm_per_rev)];
    match data.iter().find(|(_, value)| !value.is_finite() || *value <= 0.0) {
        Some((name, value)) => refuse(format!("a {name} of {value}; it must be above 0")),
        None => Ok(()),
    }
}

/// Everything a pass needs; borrowed, so that an error leaves the workpiece alone.
struct Cut<'a> {
    before: &'a [f64],
    commanded: &'a [f64],
    law: DepthLaw,
    step_mm: f64,
    settings: &'a ProcessSettings,
}

impl Cut<'_> {
    /// Diameters after the pass.
    fn run(&self, pass: u32) -> (Vec<f64>, CutSummary) {
        let supports = self.settings.support.supports();
        let lefts = self.uncut_left_parts(&supports);
        let mut right = supports.tailstock;
        let mut after = self.before.to_vec();
        let mut summary = CutSummary {
            pass,
            min_depth_mm: f64::INFINITY,
            max_depth_mm: 0.0,
            max_force_n: 0.0,
            max_deflection_mm: 0.0,
        };
        for node in (0..after.len()).rev() {
            let behind = after.get(node + 1).copied();
            let probe = behind.map_or(right, |d| self.extended(right, d));
            let compliance = compliance_at_joint(&lefts[node], &probe);
            let depth = self.law.depth_mm(0.5 * (self.before[node] - self.commanded[node]), compliance);
            after[node] = self.before[node] - 2.0 * depth;
            summary.include(depth, self.law.force_n(depth), compliance);
            if let Some(behind) = behind {
                right = self.extended(right, 0.5 * (behind + after[node]));
            }
            supports.rests_at(node, self.step_mm).for_each(|rest| right.support(rest));
        }
        (after, summary)
    }

    fn extended(&self, mut part: Part, diameter_mm: f64) -> Part {
        part.extend(self.step_mm, &Section::circular(diameter_mm, &self.settings.material));
        part
    }

    fn uncut_left_parts(&self, supports: &Supports) -> Vec<Part> {
        let element = |pair: &[f64]| Section::circular(0.5 * (pair[0] + pair[1]), &self.settings.material);
        let sections: Vec<Section> = self.before.windows(2).map(element).collect();
        left_parts(self.step_mm, &sections, supports)
    }
}

impl CutSummary {
    fn include(&mut self, depth_mm: f64, force_n: f64, compliance_mm_per_n: f64) {
        self.min_depth_mm = self.min_depth_mm.min(depth_mm);
        self.max_depth_mm = self.max_depth_mm.max(depth_mm);
        self.max_force_n = self.max_force_n.max(force_n);
        self.max_deflection_mm = self.max_deflection_mm.max(force_n * compliance_mm_per_n);
    }
}
