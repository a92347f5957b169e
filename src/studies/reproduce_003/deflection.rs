//! Equations 1 to 3, Tables 1 and 2, Figs 7 to 9: forces and the deflection they cause.

use super::error::ReproductionError;
use super::inputs::{Figure, Force, Inputs};
use crate::plan::CuttingData;
use crate::process::fit::{ForcePoint, PowerFit, fit_power_law};
use crate::process::stepped::{Piece, SteppedShaft};
use crate::process::tool_factors::ToolFactors;
use crate::process::{MaterialSettings, PowerLaw, Section, SupportSettings, ToolSettings, geometry};
use crate::studies::reproduction::{Accept, Row};

/// Confidence of the fits; only their values are used here.
const CONFIDENCE: f64 = 0.95;
/// Scatter of handbook forces, relative.
const HANDBOOK: f64 = 0.20;

fn shaft(inputs: &Inputs) -> Result<(SteppedShaft, Section), ReproductionError> {
    let material = MaterialSettings {
        youngs_modulus_n_per_mm2: Some(inputs.beam.youngs_modulus_n_per_mm2),
        poisson_ratio: Some(inputs.beam.poisson_ratio),
        ..MaterialSettings::default()
    }
    .resolve()
    .map_err(crate::process::ProcessError::from)?;
    let section = Section::circular(inputs.beam.diameter_mm, &material);
    let rigid = SupportSettings {
        chuck_n_per_um: f64::INFINITY,
        tailstock_n_per_um: f64::INFINITY,
        ..SupportSettings::default()
    };
    let piece = Piece { length_mm: inputs.beam.length_mm, ahead: section, behind: section };
    Ok((SteppedShaft { pieces: vec![piece], supports: rigid.supports() }, section))
}

fn fit(inputs: &Inputs, table: &[Force]) -> Result<PowerFit, ReproductionError> {
    let given = PowerLaw {
        depth_exponent: inputs.handbook.depth_exponent,
        feed_exponent: inputs.handbook.feed_exponent,
        speed_exponent: inputs.handbook.speed_exponent,
        ..PowerLaw::default()
    };
    let points: Vec<ForcePoint> = table.iter().map(Force::meant).collect();
    Ok(fit_power_law(&points, &given, CONFIDENCE)?)
}

/// Forces and shaft of the paper's finite-element study.
pub(super) struct Model<'a> {
    pub inputs: &'a Inputs,
    pub shaft: SteppedShaft,
    section: Section,
    pub law_1: PowerLaw,
    pub law_2: PowerLaw,
    /// The paper's insert, section 3.3.
    tool: ToolSettings,
}

impl<'a> Model<'a> {
    /// # Errors
    /// Inputs that determine no law or no shaft.
    pub(super) fn new(inputs: &'a Inputs, tool: &ToolSettings) -> Result<Self, ReproductionError> {
        let (shaft, section) = shaft(inputs)?;
        Ok(Self {
            inputs,
            shaft,
            section,
            law_1: fit(inputs, &inputs.table_1)?.law,
            law_2: fit(inputs, &inputs.table_2)?.law,
            tool: *tool,
        })
    }

    pub(super) fn rows(&self) -> Vec<Row> {
        let mut rows = self.equations();
        rows.extend(self.beam());
        rows.extend(self.table_1());
        rows.extend(self.table_2());
        rows.extend(self.handbook());
        rows.extend(self.figures());
        rows.extend(self.trends());
        rows
    }

    /// Largest size error over the tool's positions per newton, µm/N.
    pub(super) fn error_per_force(&self) -> f64 {
        2e3 * self.shaft.softest().compliance_mm_per_n
    }

    /// Size error over z under one newton at the loaded node, (mm, µm): the paper's own nodes,
    /// halved so that each element has a middle. Two-node elements are exact at their nodes.
    pub(super) fn fixed_load(&self) -> Vec<(f64, f64)> {
        let beam = &self.inputs.beam;
        let elements = 2 * (beam.nodes - 1);
        let step = beam.length_mm / elements as f64;
        let load = [(2 * (beam.loaded_node - 1), 1.0)];
        let sections = vec![self.section; elements];
        let line = crate::process::fem::deflection_line_mm(step, &sections, &self.shaft.supports, &load);
        line.unwrap_or_default().iter().enumerate().map(|(i, w)| (step * i as f64, 2e3 * w)).collect()
    }

    fn equations(&self) -> Vec<Row> {
        let beam = &self.inputs.beam;
        let force = self.inputs.table_1.first().map_or(0.0, |row| row.force_n);
        let radial = self.shaft.softest().compliance_mm_per_n * force;
        // The paper gives no tangential force.
        let tangential = self.inputs.handbook.cutting_ratio * radial;
        let d = beam.diameter_mm;
        let whole = geometry::diameter_after_mm(d, radial, tangential) - d;
        let (by_radial, by_tangential) =
            (geometry::radial_error_mm(radial), geometry::tangential_error_mm(d + 2.0 * radial, tangential));
        vec![
            Row::identity(
                ("eq1", "eq. 1 less (eq. 2 + eq. 3) at Table 1 row 1", "µm"),
                1e3 * (whole - by_radial - by_tangential),
                1e-6,
                "the two errors add up to the diameter of eq. 1",
            ),
            Row::identity(
                ("eq2", "eq. 2: 2·√((D/2 + u)²) - D less 2u", "µm"),
                1e3 * (2.0 * (0.5 * d + radial).abs() - d - by_radial),
                1e-6,
                "equal",
            ),
            Row::predicted(
                ("eq3", "eq. 3 over eq. 2: tangential over radial error", ""),
                None,
                by_tangential / by_radial,
                // "Much greater": by ten times at least.
                Accept::Range(0.0, 0.1),
                format!(
                    "the radial force is the main factor, as the paper says; tangential force taken as {} times the radial",
                    self.inputs.handbook.cutting_ratio
                ),
            ),
        ]
    }

    fn beam(&self) -> Vec<Row> {
        let figures = self.inputs.figures.fig_7.iter();
        let fig_7: Vec<f64> =
            figures.map(|f| f.error_um / self.inputs.table_1[f.row - 1].meant().force_n).collect();
        let paper = fig_7.iter().sum::<f64>() / fig_7.len().max(1) as f64;
        let mut rows = self.travelling_load(paper);
        rows.extend(self.load_at_node_71(paper));
        let (softest, length) = (self.shaft.softest(), self.inputs.beam.length_mm);
        rows.push(Row::predicted(
            ("fig7.maximum", "position of the largest error", "mm"),
            None,
            softest.z_mm,
            Accept::Range(0.5 * length, 0.75 * length),
            "\"in the middle part of the shaft, against the flexible top\": between middle and tailstock",
        ));
        rows
    }

    /// Difference of an error over force from the largest over z, %.
    fn below_largest(&self, value: f64) -> f64 {
        100.0 * (1.0 - value / self.error_per_force())
    }

    /// Fig. 7's size error over force, µm/N, with the load at the tool.
    fn travelling_load(&self, paper: f64) -> Vec<Row> {
        let position_mm = self.inputs.beam.position_mm;
        let at = 2e3 * self.shaft.compliance_mm_per_n(position_mm);
        vec![
            Row::predicted(
                (
                    "fig7.compliance",
                    "size error over force, Fig. 7 over Table 1, against the largest over z",
                    "µm/N",
                ),
                Some(paper),
                self.error_per_force(),
                Accept::Relative(0.02),
                "Timoshenko beam, clamped and rigidly supported, the load travelling with the tool",
            ),
            Row::predicted(
                ("fig7.position", "size error over force at the printed position", "µm/N"),
                Some(paper),
                at,
                Accept::Relative(0.02),
                format!(
                    "at {} mm the error is {:.1} % below the largest, which lies at {:.1} mm",
                    position_mm,
                    self.below_largest(at),
                    self.shaft.softest().z_mm
                ),
            ),
        ]
    }

    /// The same with the load at node 71 wherever the tool is.
    fn load_at_node_71(&self, paper: f64) -> Vec<Row> {
        let beam = &self.inputs.beam;
        let line = self.fixed_load();
        let fixed = at_position(&line, beam.position_mm);
        vec![
            Row::predicted(
                (
                    "fig7.node71",
                    "size error over force at the printed position, the load fixed at node 71",
                    "µm/N",
                ),
                Some(paper),
                fixed,
                Accept::Relative(0.02),
                format!(
                    "node {} of {} lies at {:.1} mm; with the load there the error at {} mm is {:.1} % below the largest under a \
                     travelling load",
                    beam.loaded_node,
                    beam.nodes,
                    beam.length_mm * (beam.loaded_node - 1) as f64 / (beam.nodes - 1) as f64,
                    beam.position_mm,
                    self.below_largest(fixed)
                ),
            ),
            Row::ours(
                (
                    "fig7.node71.most",
                    "largest size error over force anywhere, the load fixed at node 71",
                    "µm/N",
                ),
                line.iter().map(|p| p.1).fold(0.0, f64::max),
                "below the printed errors: no point of this line is what Fig. 7 shows",
            ),
        ]
    }

    fn table_1(&self) -> Vec<Row> {
        let law = &self.law_1;
        let sound = self.inputs.table_1.iter().enumerate().filter(|(_, row)| row.meant_depth_mm.is_none());
        let mut rows: Vec<Row> = sound.map(|(index, row)| fitted("table1", index, row, law, 0.005)).collect();
        rows.push(Row::ours(
            ("table1.exponent", "exponent of the depth of cut", ""),
            law.depth_exponent,
            "not printed; handbooks give 0.9",
        ));
        rows.push(Row::ours(
            ("table1.coefficient", "coefficient C of the force law", "N"),
            law.coefficient_n,
            "not printed; with handbook exponents of feed and speed; over a_p .10-.38 mm at f .10 mm/r and v 40 m/min",
        ));
        rows
    }

    fn table_2(&self) -> Vec<Row> {
        let law = &self.law_2;
        let sound = self.inputs.table_2.iter().enumerate().filter(|(_, row)| row.meant_force_n.is_none());
        let mut rows: Vec<Row> = sound.map(|(index, row)| fitted("table2", index, row, law, 0.01)).collect();
        rows.push(Row::ours(
            ("table2.exponent", "exponent of the cutting speed", ""),
            law.speed_exponent,
            "not printed; handbooks give -0.3",
        ));
        rows.push(Row::ours(
            ("table2.coefficient", "coefficient C of the force law", "N"),
            law.coefficient_n,
            "not printed; with handbook exponents of depth and feed; over v 30-100 m/min at a_p .20 mm and f .10 mm/r alone",
        ));
        rows
    }

    /// The handbook's force with the factors of the paper's tool, against both tables.
    fn handbook(&self) -> Vec<Row> {
        let handbook = &self.inputs.handbook;
        let factor = ToolFactors::of(&self.tool).passive;
        let law = PowerLaw {
            coefficient_n: handbook.passive_coefficient_n * factor,
            depth_exponent: handbook.depth_exponent,
            feed_exponent: handbook.feed_exponent,
            speed_exponent: handbook.speed_exponent,
            ..PowerLaw::default()
        };
        let row = |table: &str, row: Option<&Force>| {
            let meant = row?.meant();
            let ours = law.force_n(meant.depth_mm, &meant.cutting());
            let id = format!("{table}.handbook");
            let reason = format!(
                "C = {} N times {factor:.3} for rake {}°, lead {}°, inclination {}°, nose radius {} mm (relief and minor cutting \
                 edge have no factor); a_p {} mm, v {} m/min",
                handbook.passive_coefficient_n,
                self.tool.rake_deg,
                self.tool.lead_angle_deg,
                self.tool.inclination_deg,
                self.tool.nose_radius_mm,
                meant.depth_mm,
                meant.speed_m_per_min
            );
            let names = (id.as_str(), "radial force by the handbook's law with the tool's angles", "N");
            Some(Row::predicted(names, Some(meant.force_n), ours, Accept::Relative(HANDBOOK), reason))
        };
        [row("table1", self.inputs.table_1.first()), row("table2", self.inputs.table_2.first())]
            .into_iter()
            .flatten()
            .collect()
    }

    fn figures(&self) -> Vec<Row> {
        let per_force = self.error_per_force();
        let of_table = |figure: &str, f: &Figure, table: &[Force], limit: f64| {
            let force = table[f.row - 1].meant().force_n;
            let id = format!("{figure}.row{}", f.row);
            let names = (id.as_str(), "largest size error", "µm");
            let ours = per_force * force;
            Row::predicted(
                names,
                Some(f.error_um),
                ours,
                Accept::Relative(limit),
                deviation(ours, f.error_um, "from the printed force"),
            )
        };
        let figures = &self.inputs.figures;
        let seven = figures.fig_7.iter().map(|f| of_table("fig7", f, &self.inputs.table_1, 0.02));
        let eight = figures.fig_8.iter().map(|f| of_table("fig8", f, &self.inputs.table_2, 0.08));
        let nine = figures.fig_9.iter().map(|f| {
            let ours = per_force * self.fig_9_force_n(f.feed_mm_per_rev);
            let id = format!("fig9.f{}", f.feed_mm_per_rev);
            let reason = format!(
                "Table 1's law at a_p = {} mm, v = {} m/min, which are not printed but chosen to agree",
                figures.fig_9_depth_mm, figures.fig_9_speed_m_per_min
            );
            let names = (id.as_str(), "largest size error", "µm");
            let reason = deviation(ours, f.error_um, &reason);
            Row::in_sample(names, Some(f.error_um), ours, Accept::Relative(0.05), reason)
        });
        seven.chain(eight).chain(nine).collect()
    }

    /// Force behind Fig. 9 at a feed, N.
    pub(super) fn fig_9_force_n(&self, feed_mm_per_rev: f64) -> f64 {
        let figures = &self.inputs.figures;
        let cutting = CuttingData { speed_m_per_min: figures.fig_9_speed_m_per_min, feed_mm_per_rev };
        self.law_1.force_n(figures.fig_9_depth_mm, &cutting)
    }

    /// "The error increases with depth and feed and decreases with the speed": direction and
    /// elasticity.
    fn trends(&self) -> Vec<Row> {
        let figures = &self.inputs.figures;
        let of_table = |table: &[Force], law: &PowerLaw, factor: fn(&ForcePoint) -> f64| -> Vec<(f64, f64)> {
            table
                .iter()
                .map(Force::meant)
                .map(|p| (factor(&p), law.force_n(p.depth_mm, &p.cutting())))
                .collect()
        };
        let printed = |errors: &[Figure], of: &dyn Fn(&Figure) -> f64| -> Vec<(f64, f64)> {
            errors.iter().map(|f| (of(f), f.error_um)).collect()
        };
        let depths = of_table(&self.inputs.table_1, &self.law_1, |p| p.depth_mm);
        let speeds = of_table(&self.inputs.table_2, &self.law_2, |p| p.speed_m_per_min);
        let feeds: Vec<(f64, f64)> = figures
            .fig_9
            .iter()
            .map(|f| (f.feed_mm_per_rev, self.fig_9_force_n(f.feed_mm_per_rev)))
            .collect();
        let depth_of = |f: &Figure| self.inputs.table_1[f.row - 1].meant().depth_mm;
        let speed_of = |f: &Figure| self.inputs.table_2[f.row - 1].meant().speed_m_per_min;
        [
            ("depth", "depth of cut", 1.0, depths, printed(&figures.fig_7, &depth_of)),
            ("feed", "feed", 1.0, feeds, printed(&figures.fig_9, &|f| f.feed_mm_per_rev)),
            ("speed", "cutting speed", -1.0, speeds, printed(&figures.fig_8, &speed_of)),
        ]
        .into_iter()
        .flat_map(|(name, word, sign, forces, errors)| trend((name, word), sign, &forces, &errors))
        .collect()
    }
}

/// A row of a table computed with the law fitted to it.
fn fitted(table: &str, index: usize, row: &Force, law: &PowerLaw, limit: f64) -> Row {
    let (id, meant) = (format!("{table}.row{}", index + 1), row.meant());
    let ours = law.force_n(meant.depth_mm, &meant.cutting());
    let reason = deviation(ours, row.force_n, "law fitted to the table");
    Row::in_sample((&id, "radial force", "N"), Some(row.force_n), ours, Accept::Relative(limit), reason)
}

/// Direction and elasticity of the error over a factor; errors are proportional to the forces.
fn trend((name, word): (&str, &str), sign: f64, forces: &[(f64, f64)], errors: &[(f64, f64)]) -> [Row; 2] {
    let right = forces.windows(2).filter(|w| sign * (w[1].1 - w[0].1) * (w[1].0 - w[0].0) > 0.0).count();
    let share = right as f64 / forces.len().saturating_sub(1).max(1) as f64;
    let direction = if sign > 0.0 { "worse" } else { "better" };
    [
        Row::predicted(
            (
                &format!("trend.{name}"),
                &format!("share of steps of more {word} at which the error gets {direction}"),
                "",
            ),
            None,
            share,
            Accept::Range(1.0, 1.0),
            format!("the paper: {direction} with the {word}"),
        ),
        Row::predicted(
            (&format!("trend.{name}.elasticity"), &format!("slope of ln(error) over ln({word})"), ""),
            Some(elasticity(errors)),
            elasticity(forces),
            Accept::Absolute(0.05),
            "the figure's printed errors against the force law on a linear beam",
        ),
    ]
}

/// Least-squares slope in logarithms.
fn elasticity(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (mx, my) = (mean(|p| p.0.ln()), mean(|p| p.1.ln()));
    let sum =
        |of: &dyn Fn(f64, f64) -> f64| points.iter().map(|p| of(p.0.ln() - mx, p.1.ln() - my)).sum::<f64>();
    sum(&|x, y| x * y) / sum(&|x, _| x * x)
}

/// Linear interpolation in a curve of ascending positions.
pub(super) fn at_position(curve: &[(f64, f64)], z_mm: f64) -> f64 {
    let pair = curve.windows(2).find(|w| w[1].0 >= z_mm);
    pair.map_or(f64::NAN, |w| w[0].1 + (z_mm - w[0].0) / (w[1].0 - w[0].0) * (w[1].1 - w[0].1))
}

fn deviation(ours: f64, paper: f64, reason: &str) -> String {
    format!("{:+.2} %; {reason}", 100.0 * (ours / paper - 1.0))
}
