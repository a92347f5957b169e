//! The consistency of the paper: its figures and equations by arithmetic and geometry alone,
//! without a constant of ours.
//!
//! Only these rows can end in a contradiction. Their only input is [`Printed`].

use super::inputs::{Figure, Force, Inputs};
use crate::studies::optimize::OptimizeConfig;
use crate::studies::reproduction::{Accept, Row};

/// Accuracy to which a printed table follows a power of its factor, relative: both do within 0.3 %
/// elsewhere.
const TABLE: f64 = 0.01;
/// Accuracy of a value read from a printed curve, relative.
const READING: f64 = 0.02;

/// The paper's printed values alone.
pub(super) struct Printed<'a> {
    /// The inputs, of which `meant_…` and the handbook's and the plant's values are not used here.
    inputs: &'a Inputs,
    /// Section 3.3: shaft, limits and tool of the choice of cutting data.
    problem: &'a OptimizeConfig,
}

/// Force at `x` on the power law through two rows.
fn between((x0, f0): (f64, f64), (x1, f1): (f64, f64), x: f64) -> f64 {
    f0 * (x / x0).powf((f1 / f0).ln() / (x1 / x0).ln())
}

impl<'a> Printed<'a> {
    pub(super) fn new(inputs: &'a Inputs, problem: &'a OptimizeConfig) -> Self {
        Self { inputs, problem }
    }

    pub(super) fn rows(&self) -> Vec<Row> {
        let mut rows = vec![self.modulus()];
        rows.extend(self.misprinted_depth());
        rows.extend(self.misprinted_force());
        rows.extend(self.tables());
        rows.extend(self.linear("fig7", &self.inputs.figures.fig_7, &self.inputs.table_1));
        rows.extend(self.linear("fig8", &self.inputs.figures.fig_8, &self.inputs.table_2));
        rows.extend(self.cutting_data());
        rows.extend(self.equations());
        rows
    }

    /// E of the clamped and rigidly supported beam that gives Fig. 7's errors from Table 1's
    /// forces.
    fn modulus(&self) -> Row {
        let beam = &self.inputs.beam;
        let (length, d) = (beam.length_mm, beam.diameter_mm);
        // w·EI = a³b²(3a + 4b)/(12 L³) under a load at a from the clamp, b from the support;
        // largest over a = L·x.
        let shape = |x: f64| x.powi(3) * (1.0 - x).powi(2) * (4.0 - x) / 12.0;
        let largest = (0..=10_000).map(|i| shape(f64::from(i) / 1e4)).fold(0.0, f64::max) * length.powi(3);
        let inertia = std::f64::consts::PI * d.powi(4) / 64.0;
        let per_force: Vec<f64> = self
            .inputs
            .figures
            .fig_7
            .iter()
            .map(|f| 1e-3 * f.error_um / self.inputs.table_1[f.row - 1].force_n)
            .collect();
        let mean = per_force.iter().sum::<f64>() / per_force.len().max(1) as f64;
        // N/mm² to Pa.
        let implied = 1e6 * 2.0 * largest / (inertia * mean);
        Row::printed(
            ("beam.E", "Young's modulus that Fig. 7 and Table 1 imply (Euler-Bernoulli beam)", "Pa"),
            Some(1e6 * beam.youngs_modulus_printed_n_per_mm2),
            implied,
            // Shear, neglected here, and the choice of the position do not change E by a factor of
            // two.
            Accept::Relative(1.0),
            "printed as 2.1e6 Pa, which would make every error 1e5 times larger; 2.1e11 Pa is meant",
        )
    }

    /// The rows of a table without a misprint, as (factor, force).
    fn sound(table: &[Force], factor: fn(&Force) -> f64) -> Vec<(f64, f64)> {
        let sound = |row: &&Force| row.meant_depth_mm.is_none() && row.meant_force_n.is_none();
        table.iter().filter(sound).map(|row| (factor(row), row.force_n)).collect()
    }

    /// The two rows around a value, or the outermost two beyond the table.
    fn around(rows: &[(f64, f64)], x: f64) -> Option<[(f64, f64); 2]> {
        let above = rows.iter().position(|row| row.0 >= x);
        match (above, rows) {
            (_, []) | (_, [_]) => None,
            (Some(above), _) => Some([rows[above.max(1) - 1], rows[above.max(1)]]),
            (None, _) => Some([rows[0], rows[rows.len() - 1]]),
        }
    }

    fn misprinted_depth(&self) -> Vec<Row> {
        let rows = Self::sound(&self.inputs.table_1, |row| row.depth_mm);
        let odd = self.inputs.table_1.iter().enumerate().filter(|(_, row)| row.meant_depth_mm.is_some());
        let row = |(index, row): (usize, &Force)| {
            let [low, high] = Self::around(&rows, row.depth_mm)?;
            let swap = |(x, force): (f64, f64)| (force, x);
            let depth = between(swap(low), swap(high), row.force_n);
            let reason = format!(
                "the printed force belongs to {depth:.3} mm on the power law through the rows beside it ({} and {} mm)",
                low.0, high.0
            );
            let (id, quantity) =
                (format!("table1.row{}", index + 1), "depth of cut that the printed force belongs to");
            Some(Row::printed(
                (&id, quantity, "mm"),
                Some(row.depth_mm),
                depth,
                Accept::Relative(TABLE),
                reason,
            ))
        };
        odd.filter_map(row).collect()
    }

    fn misprinted_force(&self) -> Vec<Row> {
        let rows = Self::sound(&self.inputs.table_2, |row| row.speed_m_per_min);
        let odd = self.inputs.table_2.iter().enumerate().filter(|(_, row)| row.meant_force_n.is_some());
        let row = |(index, row): (usize, &Force)| {
            let [low, high] = Self::around(&rows, row.speed_m_per_min)?;
            let force = between(low, high, row.speed_m_per_min);
            let reason = format!("the power law through {} and {} m/min gives {force:.2} N", low.0, high.0);
            let id = format!("table2.row{}", index + 1);
            let names = (id.as_str(), "radial force", "N");
            Some(Row::printed(names, Some(row.force_n), force, Accept::Relative(TABLE), reason))
        };
        odd.filter_map(row).collect()
    }

    /// Tables 1 and 2 share one set of cutting data.
    fn tables(&self) -> Option<Row> {
        let first = self.inputs.table_1.first()?;
        let common = |row: &&Force| {
            row.speed_m_per_min == first.speed_m_per_min && row.feed_mm_per_rev == first.feed_mm_per_rev
        };
        let second = self.inputs.table_2.iter().find(common)?;
        let rows = Self::sound(&self.inputs.table_1, |row| row.depth_mm);
        let [low, high] = Self::around(&rows, second.depth_mm)?;
        let force = between(low, high, second.depth_mm);
        Some(Row::printed(
            ("table2.against_table1", "radial force between Table 1's rows at Table 2's cutting data", "N"),
            Some(second.force_n),
            force,
            Accept::Relative(TABLE),
            format!(
                "the tables differ by a factor of {:.2} at the same cutting data",
                force / second.force_n
            ),
        ))
    }

    /// A linear static model has one error per force: each error of a figure from its first one and
    /// the table's forces.
    fn linear(&self, figure: &str, errors: &[Figure], table: &[Force]) -> Vec<Row> {
        let Some((first, others)) = errors.split_first() else { return Vec::new() };
        let force = |f: &Figure| table[f.row - 1].force_n;
        let row = |f: &Figure| {
            let ratio = force(f) / force(first);
            let ours = first.error_um * ratio;
            // Errors are printed to 0.1 µm.
            let limit = 0.05 * (1.0 + ratio) + READING * f.error_um;
            let id = format!("{figure}.linear.row{}", f.row);
            let quantity = format!(
                "error of row {} from row {}'s and the forces, which a static model divides by",
                f.row, first.row
            );
            let reason = format!(
                "error over force: {:.4} µm/N here, {:.4} µm/N in row {}",
                f.error_um / force(f),
                first.error_um / force(first),
                first.row
            );
            Row::printed((&id, &quantity, "µm"), Some(f.error_um), ours, Accept::Absolute(limit), reason)
        };
        others.iter().map(row).collect()
    }

    /// Section 3.3's result against equations 5, 7 and 8.
    fn cutting_data(&self) -> Vec<Row> {
        let (found, part, quality) = (&self.inputs.optimum, &self.problem.part, &self.problem.quality);
        let height = 1e3 * found.feed_mm_per_rev.powi(2) / (8.0 * self.problem.process.tool.nose_radius_mm);
        let as_error = std::f64::consts::PI * part.length_mm * (quality.size_error_mm - 2.0 * found.depth_mm)
            / (1000.0 * found.feed_mm_per_rev * found.speed_m_per_min);
        vec![
            Row::printed(
                ("eq5.D", "t_j with D read as the size error, as printed", "min"),
                None,
                as_error,
                Accept::Range(0.0, f64::INFINITY),
                "\"D is the DE\" makes the time negative; D is the diameter",
            ),
            Row::printed(
                ("eq6.limit", "size error found over size error allowed", ""),
                None,
                found.size_error_mm / found.size_limit_mm,
                Accept::Range(0.0, 1.0),
                format!(
                    "\"fluctuates around {} mm\" and \"meets the requirements\" of {} mm",
                    found.size_error_mm, found.size_limit_mm
                ),
            ),
            Row::printed(
                ("eq8.allowed", "feed marks f²/8r at the printed cutting data over R_a allowed", ""),
                None,
                height / quality.roughness_um,
                Accept::Range(0.0, 1.0),
                "eq. 8 holds",
            ),
            Row::printed(
                ("eq8.height", "height of the feed marks f²/8r, at least the R_a found", "µm"),
                Some(found.roughness_um),
                height,
                Accept::Range(found.roughness_um, f64::INFINITY),
                "the arithmetic mean of any profile lies below its height",
            ),
        ]
    }

    /// The sign of the error, and eq. 14's condition.
    fn equations(&self) -> Vec<Row> {
        let pid = &self.inputs.pid;
        // Any diameter and error: theoretical r, measured c = y.
        let (r, c) = (25.0, 25.0 + pid.uncompensated_mm[0]);
        let (twelve, eighteen) = (r - c, c - r);
        vec![
            Row::printed(
                ("eq12", "error of eq. 12 over error of eq. 18, of the same part", ""),
                Some(1.0),
                twelve / eighteen,
                Accept::Absolute(1e-9),
                "eq. 12 takes e = r - y, eq. 18 e = c - r with b = r - u: with eq. 12's sign the correction would enlarge the error",
            ),
            Row::printed(
                ("eq14", "|G_c| at s = i with T_d = 0, less K_p", ""),
                Some(0.0),
                pid.kp.hypot(pid.ki) - pid.kp,
                Accept::Absolute(1e-12),
                "\"when T_d = 0 then G_c = K_p\" also needs T_i = ∞; eq. 14 itself follows from eq. 13 with T_i = ∞",
            ),
        ]
    }
}
