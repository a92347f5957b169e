//! One turning pass: the commanded profile and the diameters that result.
//!
//! The tool is commanded to the diameter b(z) and travels along the shaft, which has its new
//! diameter behind it and its old one ahead. At every node the actual depth of cut a = (D_before -
//! D)/2 solves a + w·F(a) = (D_before - b)/2 with the compliance w of the half-cut shaft, and D =
//! b + 2·w·F(a). Errors of the diameter before are therefore copied into the diameter after (error
//! copying), reduced by w·F'/(1 + w·F'). Wear, drift and machine errors displace b. Diameters are
//! those of the unloaded shaft at 20 °C.

pub(super) mod followed;
mod on_machine;

use std::sync::Arc;

use thiserror::Error;

use super::bending;
use super::check::refuse;
use super::cut::{Cut, CutNode, Passed, UncutNode};
use super::force::DepthLaw;
use super::grid::Grid;
use super::material::Material;
use super::path_displacement::PathDisplacement;
use super::section::Section;
use super::settings::{BelowMinimumChip, ProcessSettings};
use super::texture;
use crate::plan::{Contour, CutSummary, FeedDirection, PassPlan, Side, value_at};
use crate::shaft::{AxisKnot, Eccentricity, Features, Lobe, Pose, ProfileKnot, Shaft, SpindleMotion};

/// Why a pass was not cut.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ProcessError {
    /// A setting outside its range.
    #[error(transparent)]
    Settings(#[from] crate::setting::SettingError),
    /// A blank without extent.
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
        "pass {pass} would cut only {depth_mm:.4} mm deep at z = {z_mm:.1} mm (set {set_mm:.4} mm deep, the rest is \
         deflection), below the minimum chip of {minimum_chip_mm} mm: leave more stock, support the shaft, or lower \
         process.pass.minimum_chip_mm"
    )]
    BelowMinimumChip {
        /// Number of the pass.
        pass: u32,
        /// Where, mm.
        z_mm: f64,
        /// Depth that would be cut, mm.
        depth_mm: f64,
        /// Depth that was set, mm.
        set_mm: f64,
        /// The limit, mm.
        minimum_chip_mm: f64,
    },
    /// Tailstock thrust and feed force exceed the buckling load of the shaft.
    #[error(
        "the shaft would buckle in pass {pass}: {axial_n:.0} N of tailstock thrust and feed force against {critical_n:.0} N \
         (Euler, clamped and hinged, Ø{diameter_mm:.3} mm); lower process.support.tailstock_thrust_n or turn it shorter"
    )]
    Buckling {
        /// Number of the pass.
        pass: u32,
        /// Axial load, N.
        axial_n: f64,
        /// Euler's load, N.
        critical_n: f64,
        /// The thinnest diameter, mm.
        diameter_mm: f64,
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
    /// Lobing that every pass leaves (three-jaw clamping).
    pub lobes: Vec<Lobe>,
    /// Offset of the body from the axis of rotation.
    pub eccentricity: Eccentricity,
    /// Bow of the body.
    pub bow: Vec<AxisKnot>,
    /// How the axis lies in the camera's field.
    pub pose: Pose,
    /// The contour of a stepped shaft: the blank has it with the allowance of all passes.
    pub(crate) contour: Option<Contour>,
    /// The same contour as a worn nose leaves it; every pass leaves this one. None where the tool
    /// leaves the contour itself.
    pub(crate) worn: Option<Contour>,
}

/// What a lathe keeps from blank to blank: its edge, its warmth, its errors.
#[derive(Clone, Debug, Default)]
struct LatheState {
    /// Passes cut.
    cuts: u32,
    /// Passes since the machine was cold.
    since_cold: u32,
    /// Recession of the edge when the next pass starts, mm (radial).
    wear_mm: f64,
    /// What displaces the tool's path; none where it stands as commanded.
    errors: Option<Arc<dyn PathDisplacement>>,
}

/// A workpiece in the machine, pass after pass.
#[derive(Clone, Debug)]
pub struct TurningProcess {
    settings: ProcessSettings,
    material: Material,
    form: BaseForm,
    seed: u64,
    grid: Grid,
    diameter_mm: Vec<f64>,
    force_factor: f64,
    /// Whether this blank has been cut.
    turned: bool,
    /// What the worn nose adds to the diameter at every node, mm.
    left_mm: Vec<f64>,
    last_cut: Option<CutSummary>,
    lathe: LatheState,
}

impl TurningProcess {
    /// Clamps a blank. `seed` alone (with the number of the pass) determines every random feature.
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
        for (index, rest) in settings.support.steady_rests.iter().enumerate() {
            if rest.z_mm >= length_mm {
                let key = format!("support.steady_rests[{index}].z_mm");
                return Err(refuse(&key, rest.z_mm, format!("below the length of {length_mm} mm")).into());
            }
        }
        let node_mm = settings.pass.node_mm;
        let grid = match &form.contour {
            Some(contour) => Grid::along(contour, length_mm, node_mm),
            None => Grid::even(length_mm, node_mm),
        };
        let (nodes, step_mm) = grid.like_even(node_mm);
        let form_mm = settings.disturbance.stock_form_mm(seed, nodes, step_mm);
        let blank = stock_diameters_mm(&grid, diameter_mm, (&form_mm, step_mm));
        Ok(Self {
            settings: settings.clone(),
            material: settings.material.resolve()?,
            form: form.clone(),
            seed,
            diameter_mm: blank,
            left_mm: left_by_nose_mm(&grid, form),
            grid,
            force_factor: settings.disturbance.force_factor(seed),
            turned: false,
            last_cut: None,
            lathe: LatheState::default(),
        })
    }

    /// Machine z of the nodes, mm, ascending from 0 to the length.
    pub(crate) fn node_z_mm(&self) -> impl Iterator<Item = f64> + '_ {
        self.grid.z_mm().iter().copied()
    }

    /// Mean diameter of the unloaded workpiece at every node, mm.
    pub(crate) fn diameter_mm(&self) -> &[f64] {
        &self.diameter_mm
    }

    /// The blank as it was clamped, with the surface of a drawn or rolled bar left out.
    pub(crate) fn blank(&self) -> Shaft {
        let (deflection, bow) = self.axis();
        Shaft {
            profile: self.profile(),
            lobes: self.form.lobes.clone(),
            texture: None,
            eccentricity: self.form.eccentricity,
            bow,
            deflection,
            pose: self.form.pose,
            features: Features::default(),
            spindle: SpindleMotion::default(),
        }
    }

    /// Radii along z: those of the nodes, on a stepped shaft with the contour's own points (fillets
    /// and chamfers are finer than the nodes) between them.
    fn profile(&self) -> Vec<ProfileKnot> {
        let knot = |(z_mm, diameter): (f64, &f64)| ProfileKnot { z_mm, radius_mm: 0.5 * diameter };
        let Some((contour, relative)) = self.surface() else {
            return self.node_z_mm().zip(&self.diameter_mm).map(knot).collect();
        };
        let over = |(z, (d, relative)): (f64, (&f64, f64))| (z, d - relative);
        let excess: Vec<(f64, f64)> =
            self.node_z_mm().zip(self.diameter_mm.iter().zip(relative)).map(over).collect();
        let mut places: Vec<(f64, Side)> = Vec::new();
        let own = contour.knots.iter().map(|k| k.z_mm);
        let mut z_mm: Vec<f64> = own.chain(self.node_z_mm()).collect();
        z_mm.sort_by(f64::total_cmp);
        z_mm.dedup();
        for z in z_mm {
            places.extend([(z, Side::Chuck), (z, Side::Tailstock)]);
        }
        let at = |(z_mm, side): (f64, Side)| {
            let diameter = contour.relative_mm(z_mm, side) + value_at(&excess, z_mm, side, |e| *e);
            ProfileKnot { z_mm, radius_mm: 0.5 * diameter }
        };
        let mut knots: Vec<ProfileKnot> = places.into_iter().map(at).collect();
        knots.dedup();
        knots
    }

    /// The contour that the surface has now, and its diameter at every node less the largest one,
    /// mm; none of a plain shaft.
    fn surface(&self) -> Option<(&Contour, Vec<f64>)> {
        let relative = self.grid.relative_mm();
        match &self.form.worn {
            Some(worn) if self.turned => {
                Some((worn, relative.iter().zip(&self.left_mm).map(|(r, left)| r + left).collect()))
            }
            _ => Some((self.form.contour.as_ref()?, relative.to_vec())),
        }
    }

    /// What the last pass cut.
    pub(crate) fn last_cut(&self) -> Option<&CutSummary> {
        self.last_cut.as_ref()
    }

    /// Puts a fresh edge into the holder.
    pub(crate) fn change_insert(&mut self) {
        self.lathe.wear_mm = 0.0;
    }

    /// Lets the machine cool down: drift and warming start again.
    pub(crate) fn cool_down(&mut self) {
        self.lathe.since_cold = 0;
    }

    /// Clamps the next blank of a batch: edge and machine stay as they are, the blank's form and
    /// force are drawn anew.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn next_blank(&self, stock: Stock, seed: u64) -> Result<Self, ProcessError> {
        let fresh = Self::new(&self.settings, stock, &self.form, seed)?;
        Ok(Self { lathe: self.lathe.clone(), ..fresh })
    }

    /// Cuts a pass and returns the shaft that remains. On an error the workpiece is unchanged.
    /// Models that the first pass used outside their range are logged as a warning.
    ///
    /// # Errors
    /// A plan that contradicts itself, a depth of cut below the minimum chip, a shaft that buckles.
    pub(crate) fn cut(&mut self, plan: &PassPlan) -> Result<Shaft, ProcessError> {
        let first = self.lathe.cuts == 0;
        let summary = self.cut_profile(plan)?;
        if first {
            summary.notes.iter().for_each(|note| tracing::warn!(pass = plan.pass, "{note}"));
        }
        Ok(self.shaft(plan))
    }

    /// As `Self::cut`, without generating the surface: `Self::diameter_mm` returns the result.
    ///
    /// # Errors
    /// As `Self::cut`.
    pub fn cut_profile(&mut self, plan: &PassPlan) -> Result<&CutSummary, ProcessError> {
        let Passed { nodes, summary } = self.passed(plan)?.0;
        self.diameter_mm = nodes.iter().map(|n| n.after).collect();
        self.lathe.wear_mm += 1e-3 * self.settings.disturbance.wear_um_per_pass;
        self.lathe.cuts += 1;
        self.turned = true;
        self.lathe.since_cold += 1;
        Ok(self.last_cut.insert(summary))
    }

    /// The pass as it would be cut, diameters at 20 °C, and the force law in it.
    fn passed(&self, plan: &PassPlan) -> Result<(Passed, DepthLaw), ProcessError> {
        check_plan(plan)?;
        let law = self.settings.force.at(&plan.cutting, &self.settings.tool, &self.material);
        let law = law.scaled(self.force_factor);
        let heat = self.heat_growth();
        let commanded = self.tool_path(plan);
        let warm = self.diameter_mm.iter().zip(&heat).map(|(d, h)| d * h);
        let uncut =
            warm.zip(commanded).map(|(before, commanded)| UncutNode { before, commanded, aside: 0.0 });
        let mut nodes: Vec<UncutNode> = uncut.collect();
        self.displace(&mut nodes);
        let cut = Cut {
            nodes: &nodes,
            law,
            grid: &self.grid,
            supports: self.settings.support.supports(),
            material: &self.material,
            tangential_error: self.settings.bending.tangential_error,
        };
        let mut passed = match self.settings.pass.feed_direction {
            FeedDirection::TowardsChuck => cut.towards_first(),
            FeedDirection::TowardsTailstock => cut.towards_last(),
        };
        let summary = &mut passed.summary;
        summary.notes.extend(self.check_chip(plan.pass, &nodes, &passed.nodes)?);
        self.check_buckling(plan.pass, &passed.nodes, law.components(summary.max_depth_mm).feed_n)?;
        passed.nodes.iter_mut().zip(&heat).for_each(|(n, h)| n.after /= h);
        summary.pass = plan.pass;
        summary.feed_mark_um =
            1e3 * plan.cutting.feed_mm_per_rev.powi(2) / (8.0 * self.settings.tool.nose_radius_mm);
        let depths = [summary.min_depth_mm, summary.max_depth_mm];
        summary.notes.extend(self.settings.force.extrapolation(&plan.cutting, depths, &self.settings.tool));
        summary.notes.extend(self.settings.force.of_another_material(&self.material));
        Ok((passed, law))
    }

    /// Displaces the tool's path by the displacement of the axis away from the tool without any
    /// cutting force (weight, tailstock), and puts its displacement across into the nodes.
    fn displace(&self, nodes: &mut [UncutNode]) {
        let bending = &self.settings.bending;
        let still = !bending.self_weight && bending.tailstock_x_um == 0.0 && bending.tailstock_y_um == 0.0;
        if still {
            return;
        }
        let commanded: Vec<f64> = nodes.iter().map(|n| n.commanded).collect();
        let at_tool = self.axis_at_tool(&commanded);
        let [x, y] = bending.towards_tool();
        for (node, uncut) in nodes.iter_mut().enumerate() {
            let [ux, uy] = bending::axis_at(&at_tool, self.grid.z_mm()[node]);
            uncut.commanded -= 2.0 * (ux * x + uy * y);
            // In the direction of the tangential force: against the surface's motion.
            uncut.aside = ux * y - uy * x;
        }
    }

    /// Share of the pass that is cut when the tool reaches z.
    fn share_cut(&self, z_mm: f64) -> f64 {
        let share = z_mm / self.grid.length_mm();
        match self.settings.pass.feed_direction {
            FeedDirection::TowardsChuck => 1.0 - share,
            FeedDirection::TowardsTailstock => share,
        }
    }

    /// Factor of thermal growth of the workpiece while it is cut, at every node.
    fn heat_growth(&self) -> Vec<f64> {
        self.node_z_mm().map(|z| self.growth(self.rise_k(self.share_cut(z)))).collect()
    }

    /// Temperature of the workpiece above 20 °C when a share of the pass is cut, K.
    fn rise_k(&self, share: f64) -> f64 {
        let d = &self.settings.disturbance;
        d.heat_start_k + (d.heat_end_k - d.heat_start_k) * share
    }

    /// Factor on every length at `rise_k` above 20 °C.
    fn growth(&self, rise_k: f64) -> f64 {
        1.0 + 1e-6 * self.material.expansion_um_per_m_k * rise_k
    }

    /// Diameter at which the edge stands, mm: the command, displaced by the machine, wear,
    /// guideway, drift and scatter.
    fn tool_path(&self, plan: &PassPlan) -> Vec<f64> {
        let d = &self.settings.disturbance;
        let common = d.common_mm(self.seed, plan.pass, self.lathe.since_cold);
        let compensated = self.compensated(plan);
        let path = self.displaced_by_machine(self.commanded(compensated.as_ref().unwrap_or(plan)));
        let displaced = |(z, at): (f64, f64)| {
            let wear = self.lathe.wear_mm + 1e-3 * d.wear_um_per_pass * self.share_cut(z);
            let away = wear + d.guideway_mm(z);
            at + common + 2.0 * away
        };
        self.node_z_mm().zip(path).map(displaced).collect()
    }

    /// The command at every node, mm: linear between station middles with the end pieces continued.
    fn commanded(&self, plan: &PassPlan) -> Vec<f64> {
        if let Some(path) = self.stepped_path(plan) {
            return path;
        }
        let stations: Vec<f64> = plan.commanded_mm().collect();
        let mut upper = 1;
        let at = |z: f64| {
            while upper + 1 < stations.len() && plan.station_z_mm[upper] < z {
                upper += 1;
            }
            linear(&plan.station_z_mm, &stations, upper, z)
        };
        self.node_z_mm().map(at).collect()
    }

    /// The command at every node of a stepped shaft, mm: the contour less the offsets, which step
    /// at a shoulder, as a program cuts it; none for a plain one.
    fn stepped_path(&self, plan: &PassPlan) -> Option<Vec<f64>> {
        let contour = plan.form.contour()?;
        let offsets = contour.offset_knots(&plan.station_z_mm, &plan.offset.o_mm);
        let z = self.grid.z_mm();
        let at = |node: usize| {
            let offset = value_at(&offsets, z[node], grid_side(z, node), |o| *o);
            plan.nominal_mm + self.grid.relative_mm()[node] + self.left_mm[node] - offset
        };
        Some((0..z.len()).map(at).collect())
    }

    /// Refuses a chip below the minimum, or adds a note where the force law is extrapolated.
    fn check_chip(
        &self,
        pass: u32,
        uncut: &[UncutNode],
        cut: &[CutNode],
    ) -> Result<Option<String>, ProcessError> {
        let minimum_chip_mm = self.settings.pass.minimum_chip_mm;
        let depth = |node: usize| 0.5 * (uncut[node].before - cut[node].after);
        let least = (0..cut.len()).min_by(|a, b| depth(*a).total_cmp(&depth(*b)));
        let Some(node) = least.filter(|node| depth(*node) < minimum_chip_mm) else {
            return Ok(None);
        };
        let (z_mm, depth_mm) = (self.grid.z_mm()[node], depth(node));
        if self.settings.pass.below_minimum_chip == BelowMinimumChip::Extrapolate {
            return Ok(Some(format!(
                "depth of cut down to {depth_mm:.4} mm at z = {z_mm:.1} mm, below the minimum chip of {minimum_chip_mm} mm: \
                 the edge may rub there"
            )));
        }
        let set_mm = 0.5 * (uncut[node].before - uncut[node].commanded);
        Err(ProcessError::BelowMinimumChip { pass, z_mm, depth_mm, set_mm, minimum_chip_mm })
    }

    /// Euler's load of the thinnest diameter over the whole length, clamped and hinged:
    /// 2.0457·π²·EI/L².
    fn check_buckling(&self, pass: u32, cut: &[CutNode], feed_n: f64) -> Result<(), ProcessError> {
        let support = &self.settings.support;
        if support.tailstock_n_per_um == 0.0 {
            return Ok(());
        }
        let diameter_mm = cut.iter().map(|n| n.after).fold(f64::INFINITY, f64::min);
        let length = self.grid.length_mm();
        let bending = Section::circular(diameter_mm, &self.material).bending_n_mm2;
        let critical_n = 2.0457 * std::f64::consts::PI.powi(2) * bending / (length * length);
        let axial_n = support.tailstock_thrust_n + feed_n;
        if axial_n < critical_n {
            return Ok(());
        }
        Err(ProcessError::Buckling { pass, axial_n, critical_n, diameter_mm })
    }

    /// The workpiece with the surface after the pass.
    fn shaft(&self, plan: &PassPlan) -> Shaft {
        let settings = &self.settings.texture;
        let length_mm = self.grid.length_mm();
        let mut lobes = self.form.lobes.clone();
        lobes.extend_from_slice(&self.settings.disturbance.spindle_lobes);
        lobes.extend(texture::small_lobes(settings, self.seed, plan.pass));
        let mut surface = texture::surface(settings, length_mm, self.seed, plan.pass);
        if settings.feed_marks {
            let (feed, nose) = (plan.cutting.feed_mm_per_rev, self.settings.tool.nose_radius_mm);
            surface = Some(texture::with_feed_marks(surface.as_ref(), length_mm, feed, nose));
        }
        Shaft { lobes, texture: surface, ..self.blank() }
    }
}

/// Diameter of the blank at every node, mm: the stock's with its form, which is drawn at even nodes
/// `step_mm` apart, and on a stepped shaft the contour.
fn stock_diameters_mm(grid: &Grid, diameter_mm: f64, (form_mm, step_mm): (&[f64], f64)) -> Vec<f64> {
    let even = grid.z_mm().len() == form_mm.len() && grid.relative_mm().iter().all(|r| *r == 0.0);
    if even {
        return form_mm.iter().map(|form| diameter_mm + form).collect();
    }
    let form = |z: f64| {
        let place = (z / step_mm).min((form_mm.len() - 1) as f64);
        let next = form_mm[(place as usize + 1).min(form_mm.len() - 1)];
        form_mm[place as usize] + place.fract() * (next - form_mm[place as usize])
    };
    grid.z_mm()
        .iter()
        .zip(grid.relative_mm())
        .map(|(z, relative)| diameter_mm + relative + form(*z))
        .collect()
}

/// What a worn nose adds to the diameter at every node, mm: in the middle of a section or taper it
/// is that of its whole surface, and over whatever lies between two of them it is taken linear. The
/// surface beside corners follows from the contour, not from the nodes.
fn left_by_nose_mm(grid: &Grid, form: &BaseForm) -> Vec<f64> {
    let (Some(drawn), Some(worn)) = (&form.contour, &form.worn) else {
        return vec![0.0; grid.z_mm().len()];
    };
    let sections = drawn.sections.iter().map(|s| (s.ends_mm, s.clear_mm));
    let mut left: Vec<(f64, f64)> = Vec::new();
    for (ends, clear) in sections.chain(drawn.tapers.iter().map(|t| (t.ends_mm, t.clear_mm))) {
        let z = 0.5 * (clear.0 + clear.1);
        let more = worn.relative_mm(z, Side::Chuck) - drawn.relative_mm(z, Side::Chuck);
        left.extend([(ends.0, more), (ends.1, more)]);
    }
    left.sort_by(|a, b| a.0.total_cmp(&b.0));
    let z = grid.z_mm();
    (0..z.len()).map(|node| value_at(&left, z[node], grid_side(z, node), |l| *l)).collect()
}

/// The side of a node: the first of two at a shoulder is the side of the chuck.
fn grid_side(z_mm: &[f64], node: usize) -> Side {
    if node > 0 && z_mm[node - 1] == z_mm[node] { Side::Tailstock } else { Side::Chuck }
}

/// Value at `z` on the line through knots `upper - 1` and `upper`; the only value where there is
/// one.
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
