//! Equations 1 to 3, Tables 1 and 2, Figs 7 to 9: forces and the deflection they cause.

use super::ReproductionError;
use super::inputs::{Figure, Force, Inputs};
use crate::plan::CuttingData;
use crate::process::fit::{ForcePoint, PowerFit, fit_power_law};
use crate::process::stepped::{Piece, SteppedShaft};
use crate::process::{MaterialSettings, PowerLaw, Section, SupportSettings, geometry};
use crate::studies::reproduction::{Row, Verdict};

/// Confidence of the fits; only their values are used here.
const CONFIDENCE: f64 = 0.95;

/// What the rows share.
struct Model<'a> {
    inputs: &'a Inputs,
    shaft: SteppedShaft,
    law_1: PowerLaw,
    law_2: PowerLaw,
}

pub(super) fn rows(inputs: &Inputs) -> Result<Vec<Row>, ReproductionError> {
    let model = Model {
        inputs,
        shaft: shaft(inputs, inputs.beam.youngs_modulus_n_per_mm2)?,
        law_1: fit(inputs, &inputs.table_1)?.law,
        law_2: fit(inputs, &inputs.table_2)?.law,
    };
    let mut rows = model.equations();
    rows.extend(model.beam());
    rows.extend(model.table_1());
    rows.extend(model.table_2());
    rows.extend(model.figures());
    Ok(rows)
}

fn shaft(inputs: &Inputs, youngs_modulus: f64) -> Result<SteppedShaft, ReproductionError> {
    let material = MaterialSettings {
        youngs_modulus_n_per_mm2: Some(youngs_modulus),
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
    Ok(SteppedShaft { pieces: vec![piece], supports: rigid.supports() })
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

impl Model<'_> {
    /// Largest size error over the tool's positions per newton, µm/N.
    fn error_per_force(&self) -> f64 {
        2e3 * self.shaft.softest().compliance_mm_per_n
    }

    fn equations(&self) -> Vec<Row> {
        let beam = &self.inputs.beam;
        let force = self.inputs.table_1.first().map_or(0.0, |row| row.force_n);
        let radial = self.shaft.softest().compliance_mm_per_n * force;
        // The paper gives no tangential force; 2.5 times the radial one is a rule of thumb.
        let tangential = 2.5 * radial;
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
            Row::judged(
                ("eq3", "eq. 3 over eq. 2: tangential over radial error", ""),
                None,
                by_tangential / by_radial,
                if by_tangential < 0.01 * by_radial { Verdict::Reproduced } else { Verdict::Contradiction },
                "the radial force is the main factor, as the paper says; tangential force taken as 2.5 times the radial",
            ),
        ]
    }

    fn beam(&self) -> Vec<Row> {
        let beam = &self.inputs.beam;
        let softest = self.shaft.softest();
        let at = 2e3 * self.shaft.compliance_mm_per_n(beam.position_mm);
        let fig_7: Vec<f64> = self
            .inputs
            .figures
            .fig_7
            .iter()
            .map(|f| f.error_um / self.inputs.table_1[f.row - 1].meant().force_n)
            .collect();
        let paper = fig_7.iter().sum::<f64>() / fig_7.len().max(1) as f64;
        let implied = beam.youngs_modulus_n_per_mm2 * self.error_per_force() / paper;
        vec![
            Row::judged(
                ("beam.E", "Young's modulus that Fig. 7 and Table 1 imply", "Pa"),
                Some(1e6 * beam.youngs_modulus_printed_n_per_mm2),
                1e6 * implied,
                Verdict::Contradiction,
                "printed as 2.1e6 Pa, which would make every error 1e5 times larger; 2.1e11 Pa is meant",
            ),
            Row::within(
                (
                    "fig7.compliance",
                    "size error over force, Fig. 7 over Table 1, against the largest over z",
                    "µm/N",
                ),
                paper,
                self.error_per_force(),
                0.02,
                "Timoshenko beam, clamped and rigidly supported",
            ),
            Row::judged(
                ("fig7.position", "size error over force at the printed position", "µm/N"),
                Some(paper),
                at,
                Verdict::Contradiction,
                format!(
                    "at {} mm the error is {:.1} % below the largest, which lies at {:.1} mm; the printed errors are the largest",
                    beam.position_mm,
                    100.0 * (1.0 - at / self.error_per_force()),
                    softest.z_mm
                ),
            ),
            Row::judged(
                ("fig7.maximum", "position of the largest error", "mm"),
                None,
                softest.z_mm,
                Verdict::Consistent,
                "\"in the middle part of the shaft, against the flexible top\": between middle and tailstock",
            ),
        ]
    }

    fn table_1(&self) -> Vec<Row> {
        let law = &self.law_1;
        let mut rows: Vec<Row> = Vec::new();
        for (index, row) in self.inputs.table_1.iter().enumerate() {
            let (id, number) = (format!("table1.row{}", index + 1), index + 1);
            let meant = row.meant();
            let cutting = meant.cutting();
            if row.meant_depth_mm.is_some() {
                let factor = law.force_n(1.0, &cutting);
                let depth = (row.force_n / factor).powf(1.0 / law.depth_exponent);
                let names = (id.as_str(), "depth of cut that the printed force belongs to", "mm");
                let reason = format!(
                    "row {number} prints {} mm with the force of {:.3} mm; the steps of the table say {} mm",
                    row.depth_mm, depth, meant.depth_mm
                );
                rows.push(Row::judged(names, Some(row.depth_mm), depth, Verdict::Contradiction, reason));
            } else {
                let names = (id.as_str(), "radial force", "N");
                let ours = law.force_n(meant.depth_mm, &cutting);
                rows.push(Row::within(names, row.force_n, ours, 0.005, "law fitted to the table"));
            }
        }
        rows.push(Row::judged(
            ("table1.exponent", "exponent of the depth of cut", ""),
            None,
            law.depth_exponent,
            Verdict::Consistent,
            "not printed; handbooks give 0.9",
        ));
        rows.push(Row::judged(
            ("table1.coefficient", "coefficient C of the force law", "N"),
            None,
            law.coefficient_n,
            Verdict::Consistent,
            "not printed; with handbook exponents of feed and speed; about 2.4 times the handbook force",
        ));
        rows
    }

    fn table_2(&self) -> Vec<Row> {
        let law = &self.law_2;
        let mut rows: Vec<Row> = Vec::new();
        for (index, row) in self.inputs.table_2.iter().enumerate() {
            let id = format!("table2.row{}", index + 1);
            let names = (id.as_str(), "radial force", "N");
            let meant = row.meant();
            let ours = law.force_n(meant.depth_mm, &meant.cutting());
            rows.push(match row.meant_force_n {
                None => Row::within(names, row.force_n, ours, 0.01, "law fitted to the table"),
                Some(value) => Row::judged(
                    names,
                    Some(row.force_n),
                    ours,
                    Verdict::Contradiction,
                    format!("the other rows' law gives {ours:.2} N; {value} N is meant"),
                ),
            });
        }
        rows.push(Row::judged(
            ("table2.exponent", "exponent of the cutting speed", ""),
            None,
            law.speed_exponent,
            Verdict::Consistent,
            "not printed; handbooks give -0.3",
        ));
        if let Some(row) = self.inputs.table_2.iter().find(|r| r.speed_m_per_min == 40.0) {
            let ours = self.law_1.force_n(row.depth_mm, &row.meant().cutting());
            rows.push(Row::judged(
                ("table2.against_table1", "radial force by Table 1's law at Table 2's v = 40 m/min", "N"),
                Some(row.force_n),
                ours,
                Verdict::Contradiction,
                format!(
                    "the tables differ by a factor of {:.2} at the same cutting data",
                    ours / row.force_n
                ),
            ));
        }
        rows
    }

    fn figures(&self) -> Vec<Row> {
        let of_table = |figure: &str, table: &[Force], limit: f64| {
            let (figure, table) = (figure.to_owned(), table.to_vec());
            move |f: &Figure, per_force: f64| {
                let force = table[f.row - 1].meant().force_n;
                let id = format!("{figure}.row{}", f.row);
                Row::within(
                    (&id, "largest size error", "µm"),
                    f.error_um,
                    per_force * force,
                    limit,
                    "from the printed force",
                )
            }
        };
        let per_force = self.error_per_force();
        let seven = of_table("fig7", &self.inputs.table_1, 0.02);
        let eight = of_table("fig8", &self.inputs.table_2, 0.08);
        let mut rows: Vec<Row> = self.inputs.figures.fig_7.iter().map(|f| seven(f, per_force)).collect();
        rows.extend(self.inputs.figures.fig_8.iter().map(|f| {
            let mut row = eight(f, per_force);
            if row.verdict == Verdict::Contradiction {
                row.reason += ": the printed errors fall faster with the speed than the printed forces do";
            }
            row
        }));
        rows.extend(self.inputs.figures.fig_9.iter().map(|f| {
            let cutting = CuttingData {
                speed_m_per_min: self.inputs.figures.fig_9_speed_m_per_min,
                feed_mm_per_rev: f.feed_mm_per_rev,
            };
            let force = self.law_1.force_n(self.inputs.figures.fig_9_depth_mm, &cutting);
            let id = format!("fig9.f{}", f.feed_mm_per_rev);
            let reason = format!(
                "Table 1's law at a_p = {} mm, v = {} m/min, which are not printed",
                self.inputs.figures.fig_9_depth_mm, cutting.speed_m_per_min
            );
            Row::within((&id, "largest size error", "µm"), f.error_um, per_force * force, 0.05, &reason)
                .by_assumption()
        }));
        rows
    }
}
