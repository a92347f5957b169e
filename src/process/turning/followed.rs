//! The shaft at an instant: bent by its weight, the tailstock, the chuck, and by the force where
//! the tool stands.

use super::super::beam::Supports;
use super::super::bending::{BendingSettings, ForceAt, HeldShaft, axis_at, sum_of_lines};
use super::super::cut::CutNode;
use super::super::force::DepthLaw;
use super::super::force_components::Components;
use super::{ProcessError, TurningProcess};
use crate::plan::{FeedDirection, PassPlan};
use crate::shaft::{AxisKnot, ProfileKnot, Shaft};

/// Places of the tool at which the axis is solved for the half-cut shaft; between them the line is
/// interpolated linearly, with an error of 1/3200 of the sag.
const PLACES: usize = 20;

/// A pass in progress, evaluated with the tool anywhere; the workpiece itself is not cut.
#[derive(Clone, Debug)]
pub(crate) struct FollowedPass {
    process: TurningProcess,
    /// The shaft as the pass leaves it.
    surface: Shaft,
    nodes: Vec<CutNode>,
    law: DepthLaw,
}

/// The axis by cause, mm; the first three are at rest, the others turn with the part.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Contributions {
    /// Self weight.
    pub weight: Vec<AxisKnot>,
    /// Offset of the tailstock.
    pub tailstock: Vec<AxisKnot>,
    /// Radial and tangential force at the tool.
    pub force: Vec<AxisKnot>,
    /// Eccentricity in the chuck.
    pub chuck: Vec<AxisKnot>,
    /// Bow of the part, with its growth under the thrust.
    pub bow: Vec<AxisKnot>,
}

impl TurningProcess {
    /// Axis with the tool clear: the line at rest, and the line that turns with the part (bow
    /// included).
    pub(super) fn axis(&self) -> (Vec<AxisKnot>, Vec<AxisKnot>) {
        if self.settings.bending.is_straight() {
            return (Vec::new(), self.form.bow.clone());
        }
        let supports = self.settings.support.supports();
        let held = self.held(&supports, elements(&self.diameter_mm));
        let still = held.still_mm(None).unwrap_or_default();
        let turning = held.turning_mm(&self.form.bow).unwrap_or_default();
        (still, sum_of_lines(&turning, &self.form.bow))
    }

    fn held<'s>(&'s self, supports: &'s Supports, diameter_mm: Vec<f64>) -> HeldShaft<'s> {
        HeldShaft {
            element_mm: self.grid.element_mm().to_vec(),
            node_z_mm: self.grid.z_mm().to_vec(),
            diameter_mm,
            material: &self.material,
            supports,
            thrust_n: self.settings.support.tailstock_thrust_n,
            bending: &self.settings.bending,
        }
    }

    /// Axis at the tool, for every position of it, without its force: the shaft has the diameters
    /// `cut` (mm) behind the tool and its old ones ahead.
    pub(super) fn axis_at_tool(&self, cut: &[f64]) -> Vec<AxisKnot> {
        let supports = self.settings.support.supports();
        let (before, after) = (elements(&self.diameter_mm), elements(cut));
        let length = self.length_mm();
        (0..=PLACES)
            .map(|place| {
                let z_mm = length * place as f64 / PLACES as f64;
                let half_cut = self.half_cut(&before, &after, z_mm);
                let still = self.held(&supports, half_cut).still_mm(None).unwrap_or_default();
                let [x_mm, y_mm] = axis_at(&still, z_mm);
                AxisKnot { z_mm, x_mm, y_mm }
            })
            .collect()
    }

    /// Elements behind a tool at `tool_z_mm` from `after`, those ahead from `before`.
    fn half_cut(&self, before: &[f64], after: &[f64], tool_z_mm: f64) -> Vec<f64> {
        let z = self.grid.z_mm();
        let middle = |i: usize| 0.5 * (z[i] + z[i + 1]);
        let pick =
            |(i, (b, a)): (usize, (&f64, &f64))| if self.is_cut(middle(i), tool_z_mm) { *a } else { *b };
        before.iter().zip(after).enumerate().map(pick).collect()
    }

    fn is_cut(&self, z_mm: f64, tool_z_mm: f64) -> bool {
        match self.settings.pass.feed_direction {
            FeedDirection::TowardsChuck => z_mm >= tool_z_mm,
            FeedDirection::TowardsTailstock => z_mm <= tool_z_mm,
        }
    }

    /// Free length, mm.
    pub(crate) fn length_mm(&self) -> f64 {
        self.grid.length_mm()
    }

    /// A shaft of this process as it stands after a pass, grown by its temperature during the scan.
    #[must_use]
    pub(crate) fn as_scanned(&self, shaft: &Shaft) -> Shaft {
        grown(shaft.clone(), self.growth(self.settings.disturbance.heat_scan_k))
    }

    /// The pass as it would be cut, for evaluation in progress; [`Self::cut`] performs it.
    ///
    /// # Errors
    /// As [`Self::cut`].
    pub(crate) fn followed(&self, plan: &PassPlan) -> Result<FollowedPass, ProcessError> {
        let (passed, law) = self.passed(plan)?;
        let mut left = self.clone();
        left.diameter_mm = passed.nodes.iter().map(|n| n.after).collect();
        left.turned = true;
        Ok(FollowedPass { process: self.clone(), surface: left.shaft(plan), nodes: passed.nodes, law })
    }
}

impl FollowedPass {
    /// Thermal growth of the radius at the tool while it stands at `tool_z_mm`, mm.
    pub(crate) fn warm_radius_mm(&self, tool_z_mm: f64) -> f64 {
        let process = &self.process;
        let node = process.grid.place(tool_z_mm).clamp(0.0, (self.nodes.len() - 1) as f64) as usize;
        let share = process.share_cut(tool_z_mm.clamp(0.0, process.length_mm()));
        0.5 * self.nodes[node].after * (process.growth(process.rise_k(share)) - 1.0)
    }

    /// Components of the force with the tool at `tool_z_mm`, N; zero beyond the shaft.
    pub(crate) fn force(&self, tool_z_mm: f64) -> Components {
        let node = self.process.grid.place(tool_z_mm);
        let last = self.nodes.len() - 1;
        if !(0.0..=last as f64).contains(&node) {
            return Components::default();
        }
        let (a, b) = (self.nodes[node as usize].depth, self.nodes[(node as usize + 1).min(last)].depth);
        self.law.components(a + node.fract() * (b - a))
    }

    /// The shaft while the tool stands at `tool_z_mm`: cut behind it, bent by its force, at its
    /// temperature then.
    pub(crate) fn at(&self, tool_z_mm: f64) -> Shaft {
        let process = &self.process;
        let bending = &process.settings.bending;
        let supports = process.settings.support.supports();
        let (before, after) = (elements(&process.diameter_mm), elements(&self.after()));
        let held = process.held(&supports, process.half_cut(&before, &after, tool_z_mm));
        let force = ForceAt { z_mm: tool_z_mm, force: self.force(tool_z_mm) };
        let deflection = held.still_mm(Some(&force)).unwrap_or_default();
        let bow = if bending.is_straight() {
            process.form.bow.clone()
        } else {
            sum_of_lines(&held.turning_mm(&process.form.bow).unwrap_or_default(), &process.form.bow)
        };
        let shaft = Shaft { profile: self.profile(tool_z_mm), deflection, bow, ..self.surface.clone() };
        let share = process.share_cut(tool_z_mm.clamp(0.0, process.length_mm()));
        grown(shaft, process.growth(process.rise_k(share)))
    }

    /// The contribution of each cause to the axis, with the tool at `tool_z_mm`, or clear after the
    /// pass. Each is linear in its load at the common thrust, so that they add up to the axis.
    pub(crate) fn contributions(&self, tool_z_mm: Option<f64>) -> Contributions {
        let process = &self.process;
        let supports = process.settings.support.supports();
        let (before, after) = (elements(&process.diameter_mm), elements(&self.after()));
        let half_cut = tool_z_mm.map_or_else(|| after.clone(), |z| process.half_cut(&before, &after, z));
        let all = process.settings.bending;
        let none = BendingSettings {
            self_weight: false,
            tailstock_x_um: 0.0,
            tailstock_y_um: 0.0,
            chuck_eccentricity_um: 0.0,
            ..all
        };
        let held = |bending: &BendingSettings, force: Option<&ForceAt>| {
            let held = HeldShaft { bending, ..process.held(&supports, half_cut.clone()) };
            held.still_mm(force).unwrap_or_default()
        };
        let turning = |bending: &BendingSettings, bow: &[AxisKnot]| {
            let held = HeldShaft { bending, ..process.held(&supports, half_cut.clone()) };
            held.turning_mm(bow).unwrap_or_default()
        };
        let force = tool_z_mm.map(|z_mm| ForceAt { z_mm, force: self.force(z_mm) });
        let bow = &process.form.bow;
        Contributions {
            weight: held(&BendingSettings { self_weight: all.self_weight, ..none }, None),
            tailstock: held(&BendingSettings { self_weight: false, ..all }, None),
            force: held(&none, force.as_ref()),
            chuck: turning(
                &BendingSettings { chuck_eccentricity_um: all.chuck_eccentricity_um, ..none },
                &[],
            ),
            bow: sum_of_lines(&turning(&none, bow), bow),
        }
    }

    /// Diameter of every node after the pass, mm.
    fn after(&self) -> Vec<f64> {
        self.nodes.iter().map(|n| n.after).collect()
    }

    /// Radii with the shoulder under the tool.
    fn profile(&self, tool_z_mm: f64) -> Vec<ProfileKnot> {
        let (before, after) = (&self.process.diameter_mm, &self.after());
        let towards_chuck = self.process.settings.pass.feed_direction == FeedDirection::TowardsChuck;
        let (low, high) = if towards_chuck { (before, after) } else { (after, before) };
        let z = |node: usize| self.process.grid.z_mm()[node];
        let at_tool = |d: &[f64]| {
            let place = self.process.grid.place(tool_z_mm).clamp(0.0, (d.len() - 1) as f64);
            let next = d[(place as usize + 1).min(d.len() - 1)];
            d[place as usize] + place.fract() * (next - d[place as usize])
        };
        let mut knots = Vec::with_capacity(after.len() + 2);
        let mut shoulder = tool_z_mm > 0.0;
        for node in 0..after.len() {
            if shoulder && z(node) > tool_z_mm {
                let pair = [at_tool(low), at_tool(high)];
                knots.extend(pair.map(|d| ProfileKnot { z_mm: tool_z_mm, radius_mm: 0.5 * d }));
                shoulder = false;
            }
            let d = if z(node) > tool_z_mm { high[node] } else { low[node] };
            if !(z(node) == tool_z_mm && shoulder) {
                knots.push(ProfileKnot { z_mm: z(node), radius_mm: 0.5 * d });
            }
        }
        knots
    }
}

/// Diameters of elements between nodes.
fn elements(nodes: &[f64]) -> Vec<f64> {
    nodes.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect()
}

/// A shaft whose radii and lengths from the chuck face have grown by a factor.
fn grown(mut shaft: Shaft, factor: f64) -> Shaft {
    if factor != 1.0 {
        for knot in &mut shaft.profile {
            knot.radius_mm *= factor;
            knot.z_mm *= factor;
        }
        for knot in shaft.deflection.iter_mut().chain(&mut shaft.bow) {
            knot.z_mm *= factor;
        }
    }
    shaft
}
