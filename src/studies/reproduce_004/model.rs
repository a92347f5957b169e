//! The paper's nose in the program's own model: e(a) of its registers, what the four ways leave of
//! a part with every kind of surface, and what the four workpieces should have shown.
//!
//! The paper gives two supports, R1 where X and Z are touched and r as a mean; between them the
//! nose is taken as worn by (R1 − r)·sin²(2a).

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use super::curves::{Curve, Curves, PartError};
use super::error::ReproductionError;
use super::inputs::{Inputs, PrintedPart};
use crate::nose::{Feed, NoseProfile, Support, TipDirection, ToolGeometry};
use crate::outline::{Outline, Side};
use crate::shaft::ContourPoint;
use crate::studies::reproduction::Row;
use crate::tool::{Compensator, Remainder, Setting, Stated, Tool, Way, changes, largest, measured};

/// Registers that controls take, mm.
const REGISTERS_MM: (f64, f64) = (0.001, 9.999);
/// Increment of a register, mm.
const INCREMENT_MM: f64 = 1e-4;
/// Half angle of the cone of the part, degrees: near to that of part 1 (c01.part1.theta).
const CONE_DEG: f64 = 24.0;
/// Rounding error of e(a), mm.
const ROUNDING_MM: f64 = 1e-12;

/// Noses and part of the rows.
pub(super) struct Model<'a> {
    inputs: &'a Inputs,
    geometry: ToolGeometry,
    /// The paper's nose.
    worn: NoseProfile,
    /// A round nose of the radius r.
    round: NoseProfile,
    /// A new nose.
    new: NoseProfile,
    /// Cylinders, concave arc, shoulder, cone, convex arc, end face.
    outline: Outline,
}

/// The paper's tool as the control takes it: towards axis and chuck.
pub(super) fn geometry(inputs: &Inputs) -> ToolGeometry {
    ToolGeometry {
        nose_radius_mm: inputs.nominal_mm,
        kappa_r_rad: inputs.kappa_r_deg.to_radians(),
        epsilon_r_rad: inputs.epsilon_r_deg.to_radians(),
        clearance_rad: 0.0,
        tip: TipDirection { x: -1, z: -1 },
        side: Side::External,
        feed: Feed::TowardsChuck,
    }
}

fn outline() -> Result<Outline, ReproductionError> {
    let run = 6.0 / CONE_DEG.to_radians().tan();
    let corner =
        |z_mm, diameter_mm, radius_mm| ContourPoint { z_mm, diameter_mm, chamfer_mm: 0.0, radius_mm };
    let corners = [
        corner(-40.0, 60.0, 0.0),
        corner(-32.0, 60.0, 0.0),
        corner(-32.0, 46.0, 4.0),
        corner(-22.0, 46.0, 0.0),
        corner(-22.0 + run, 34.0, 0.0),
        corner(0.0, 34.0, 5.0),
        corner(0.0, 10.0, 0.0),
    ];
    Ok(Outline::from_corners(&corners, Side::External)?)
}

impl<'a> Model<'a> {
    /// Noses and part.
    ///
    /// # Errors
    /// Radii that are no nose.
    pub(super) fn new(inputs: &'a Inputs) -> Result<Self, ReproductionError> {
        let geometry = geometry(inputs);
        let (low, high) = geometry.range_rad();
        // a degree apart
        let steps = (high - low).to_degrees().ceil().max(2.0) as usize;
        let nose = |h: &dyn Fn(f64) -> f64| {
            let at = |k: usize| low + (high - low) * k as f64 / steps as f64;
            let supports: Vec<Support> =
                (0..=steps).map(|k| Support { a_rad: at(k), h_mm: h(at(k)), u_mm: 0.0 }).collect();
            NoseProfile::new(&supports, None, 0.0)
        };
        let worn = |a: f64| {
            let share = if (0.0..FRAC_PI_2).contains(&a) { (2.0 * a).sin().powi(2) } else { 0.0 };
            inputs.set_radius_mm - inputs.d_mm() * share
        };
        let round = |radius_mm: f64| nose(&|_| radius_mm);
        Ok(Self {
            inputs,
            geometry,
            worn: nose(&worn)?,
            round: round(inputs.radius_mm)?,
            new: round(inputs.nominal_mm)?,
            outline: outline()?,
        })
    }

    fn set<'b>(&self, nose: &'b NoseProfile, extent_mm: f64) -> Result<Setting<'b>, ReproductionError> {
        let stated = Stated { x_mm: Some(extent_mm), z_mm: Some(extent_mm), u_mm: 0.0 };
        Ok(Setting::new(nose, &self.geometry, &stated)?)
    }

    /// A round nose of the radius r, set at R1.
    pub(super) fn round(&self) -> Result<Setting<'_>, ReproductionError> {
        self.set(&self.round, self.inputs.set_radius_mm)
    }

    /// The paper's nose set by touching.
    fn touched(&self) -> Result<Setting<'_>, ReproductionError> {
        Ok(Setting::new(&self.worn, &self.geometry, &Stated::default())?)
    }

    /// The paper's nose in the offsets of a new one.
    fn in_batch(&self) -> Result<Setting<'_>, ReproductionError> {
        self.set(&self.worn, self.inputs.nominal_mm)
    }

    /// Every row, and the curves.
    ///
    /// # Errors
    /// A nose that cannot be set.
    pub(super) fn rows(&self) -> Result<(Vec<Row>, Curves), ReproductionError> {
        let mut rows = self.closed_forms()?;
        let ways = self.ways()?;
        rows.extend(ways.iter().map(Tried::row));
        rows.extend(self.parts(&ways)?);
        let best = ways.iter().find(|t| t.way == Way::BestRegister);
        let mut curves = self.curves(best.map_or(self.inputs.nominal_mm, |t| t.register_mm))?;
        curves.e.extend(ways.iter().filter_map(Tried::curve));
        Ok((rows, curves))
    }

    /// The paper's formulas as special cases of e(a).
    fn closed_forms(&self) -> Result<Vec<Row>, ReproductionError> {
        let i = self.inputs;
        let (r0, r1, r) = (i.nominal_mm, i.set_radius_mm, i.radius_mm);
        let (low, high) = self.geometry.range_rad();
        let most = |of: &dyn Fn(f64) -> f64| {
            let at = |k: i32| low + (high - low) * f64::from(k) / 120.0;
            (0..=120).map(|k| of(at(k)).abs()).fold(0.0, f64::max)
        };
        let (single, batch, bare) = (self.round()?, self.set(&self.round, r0)?, self.set(&self.new, r0)?);
        let identity =
            |names: (&str, &str, &str), ours: f64, why: &str| Row::identity(names, ours, ROUNDING_MM, why);
        Ok(vec![
            identity(
                (
                    "model.single",
                    "e(a) of a round nose r set at R1 less d, R1 in the register, largest over −27° to 93°",
                    "mm",
                ),
                most(&|a| single.left_mm(a, r1) - i.d_mm()),
                "the paper's single setting",
            ),
            identity(
                (
                    "model.kept",
                    "e(a) less (R0 − r) − (R0 − R1)(cos a + sin a), R0 in the register, largest",
                    "mm",
                ),
                most(&|a| single.left_mm(a, r0) - (r0 - r) + (r0 - r1) * (a.cos() + a.sin())),
                "the same setting with the register as it was",
            ),
            identity(
                ("model.batch", "e(a) less R0 − r in the offsets of a new nose, largest", "mm"),
                most(&|a| batch.left_mm(a, r0) - (r0 - r)),
                "the paper's batch: dx = e(0)",
            ),
            Row::ours(
                ("model.bare", "e at 45° of a round nose R0 without G41 or G42", "mm"),
                bare.left_mm(FRAC_PI_4, 0.0),
                "R0(cos a + sin a − 1): what a control that does not compensate leaves of a new nose",
            ),
            Row::ours(
                ("model.R0.45", "e at 45° of the paper's nose, R0 in the register", "mm"),
                self.touched()?.left_mm(FRAC_PI_4, r0),
                "set by touching, support r at 45°",
            ),
            Row::ours(
                ("model.R1.45", "e at 45° of the paper's nose, R1 in the register", "mm"),
                self.touched()?.left_mm(FRAC_PI_4, r1),
                "d at 45°, less beside",
            ),
        ])
    }

    /// What the registers and the ways leave of the part.
    fn ways(&self) -> Result<Vec<Tried>, ReproductionError> {
        let (r0, r1) = (self.inputs.nominal_mm, self.inputs.set_radius_mm);
        let tool = Tool::new(&self.worn);
        let tried = [
            ("R0", r0, Way::Register),
            ("R1", r1, Way::Register),
            ("best", r0, Way::BestRegister),
            ("edited", r0, Way::EditedContour),
            ("path", r0, Way::Path),
        ];
        let mut found = Vec::new();
        for (name, register_mm, way) in tried {
            let compensator = Compensator {
                outline: &self.outline,
                setting: self.touched()?,
                register_mm,
                register_range_mm: REGISTERS_MM,
                increment_mm: INCREMENT_MM,
            };
            let (done, left) = measured(&compensator, &tool, way)?;
            found.push(Tried { name, way, register_mm: done.register_mm, left });
        }
        Ok(found)
    }

    /// What the workpieces should have shown before compensation.
    fn parts(&self, ways: &[Tried]) -> Result<Vec<Row>, ReproductionError> {
        let i = self.inputs;
        let (touched, batch) = (self.touched()?, self.in_batch()?);
        let [one, two] = [0, 1].map(|k| (i.cone_rad(k), touched.left_mm(i.cone_rad(k), i.set_radius_mm)));
        let with_r1 = ways.iter().find(|t| t.name == "R1").map(|t| changes(&self.outline, &t.left).0);
        let arc = with_r1
            .iter()
            .flatten()
            .find_map(|p| p.radius_um.filter(|_| p.diameter_mm[1] < p.diameter_mm[0]));
        let paper = |k: usize| PrintedPart::mean_mm(&i.parts[k].before_mm);
        let register = ("the radius in the control's register", false);
        let row = |k: usize, what: &str, ours: f64, why: &str| {
            let names = (format!("model.part{}", k + 1), what.to_owned());
            Row::predicted((&names.0, &names.1, "mm"), Some(paper(k)), ours, i.parts[k].accepts(), why)
        };
        Ok(vec![
            row(0, "part 1: axial error of the cone, R1 in the register", one.1 / one.0.sin(), "e(θ)/sin θ")
                .needs(&[i.theta(), register]),
            row(
                1,
                "part 2: error of the large diameter, R1 in the register",
                2.0 * two.1 / two.0.cos(),
                "2e(θ)/cos θ",
            )
            .needs(&[i.theta(), register]),
            row(
                2,
                "part 3: size of the change of a radius of 5 mm, R1 in the register",
                1e-3 * arc.unwrap_or(f64::NAN).abs(),
                "least-squares circle through what e(a) leaves of the convex arc, its centre free",
            )
            .needs(&[("the arc's radius", false), register]),
            row(
                3,
                "part 4: error of the diameter in a batch",
                2.0 * batch.left_mm(0.0, i.nominal_mm),
                "2e(0)",
            )
            .needs(&[("the reading of the nose of part 4, if it is another one", false)]),
        ])
    }

    fn curves(&self, best_mm: f64) -> Result<Curves, ReproductionError> {
        let i = self.inputs;
        let (touched, batch, round) = (self.touched()?, self.in_batch()?, self.round()?);
        let (low, high) = self.geometry.range_rad();
        let curve = |name: String, setting: &Setting<'_>, register_mm: f64| {
            let at = |k: i32| low + (high - low) * f64::from(k) / 240.0;
            let point = |a: f64| (a.to_degrees(), 1e3 * setting.left_mm(a, register_mm));
            Curve { name, points: (0..=240).map(|k| point(at(k))).collect() }
        };
        let e = vec![
            curve(format!("register R0 {:.4} mm", i.nominal_mm), &touched, i.nominal_mm),
            curve(format!("register R1 {:.4} mm", i.set_radius_mm), &touched, i.set_radius_mm),
            curve(format!("best register {best_mm:.4} mm"), &touched, best_mm),
            curve("batch, offsets of a new nose".to_owned(), &batch, i.nominal_mm),
            curve("the paper's d everywhere".to_owned(), &round, i.set_radius_mm),
        ];
        Ok(Curves { e, parts: self.part_errors(), d_um: 1e3 * i.d_mm() })
    }

    /// The parts' mean errors as distances along the normal.
    fn part_errors(&self) -> Vec<PartError> {
        let i = self.inputs;
        // radius and diameter: at 45° by itself, at 0° half
        let angles = [i.cone_rad(0), i.cone_rad(1), FRAC_PI_4, 0.0];
        let factors = [angles[0].sin(), 0.5 * angles[1].cos(), 1.0, 0.5];
        let of = |k: usize, readings: &[f64; 4]| 1e3 * factors[k] * PrintedPart::mean_mm(readings);
        let part = |k: usize| PartError {
            part: k + 1,
            a_deg: angles[k].to_degrees(),
            before_um: of(k, &i.parts[k].before_mm),
            after_um: of(k, &i.parts[k].after_mm),
        };
        (0..4).map(part).collect()
    }
}

/// A way with what it leaves.
struct Tried {
    name: &'static str,
    way: Way,
    register_mm: f64,
    left: Vec<Remainder>,
}

impl Tried {
    /// What an edited contour or a path leaves over the angle, where the tool touches.
    fn curve(&self) -> Option<Curve> {
        let name = match self.way {
            Way::EditedContour => "edited contour",
            Way::Path => "path of the nose",
            Way::Register | Way::BestRegister => return None,
        };
        let reached = self.left.iter().filter(|r| r.reached);
        let mut points: Vec<(f64, f64)> = reached.map(|r| (r.a_rad.to_degrees(), 1e3 * r.left_mm)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Some(Curve { name: name.to_owned(), points })
    }

    fn row(&self) -> Row {
        let left = largest(&self.left).map_or(f64::NAN, |r| 1e3 * r.left_mm.abs());
        let what = match self.way {
            Way::Register => format!("register {:.4} mm", self.register_mm),
            Way::BestRegister => format!("the best register, {:.4} mm", self.register_mm),
            Way::EditedContour => "the contour edited by e(a)".to_owned(),
            Way::Path => "the path of the nose itself".to_owned(),
        };
        Row::ours(
            (
                &format!("model.left.{}", self.name),
                &format!("largest error that {what} leaves of a part"),
                "µm",
            ),
            left,
            "the paper's nose along cylinders, a cone of 24°, a face, a convex arc of 5 mm and a concave one of 4 mm, measured on \
             the path",
        )
    }
}
