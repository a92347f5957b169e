//! What the model-based controller takes from its own job: the part's length and diameter, its
//! material, the stiffness of its supports and the cutting force expected for that material.
//!
//! Only data from the drawing, the machine's data sheet and handbooks are passed on (the controller
//! takes the stiffnesses as known to a factor of 2): the nominal sizes, the material's
//! table row and the specific cutting force k_c = kc1.1·h^(−mc) (see `process::material`). Where
//! the process cuts by Kienzle's law, the controller's power law is its tangent, in logarithms, at
//! the first pass' depth; otherwise Table 1 of the slender-shaft paper (45 steel) is multiplied by
//! the ratio of the two materials' k_c at the first pass' mean chip.

use super::part::Part;
use crate::control::Workpiece;
use crate::plan::CuttingData;
use crate::process::kienzle::KienzleLaw;
use crate::process::material::{self, Material};
use crate::process::tool_factors::ToolFactors;
use crate::process::{FITTED_TO, ForceLaw, ProcessSettings, ToolSettings};

/// Standard uncertainty of ln C where the material has no specific cutting force: handbooks' kc1.1
/// of metals run from about 500 (aluminium) to 3500 N/mm² (nickel alloys), a factor of 4 below and
/// 1.6 above the steel that is assumed; .7 is a factor of 2.
const U_LN_UNKNOWN: f64 = 0.7;

/// Least exponent of the depth: with a lead angle of 90° the radial force stops growing once the
/// nose is engaged, and a law without slope would predict no error copying at all.
const LEAST_EXPONENT: f64 = 0.05;

/// The part of a job as its controller assumes it, and a warning where the force could not be
/// adapted to the material.
pub(super) fn workpiece(
    part: &Part,
    process: &ProcessSettings,
    cutting: &CuttingData,
) -> (Workpiece, Option<String>) {
    let paper = Workpiece {
        length_mm: part.length_mm,
        chuck_n_per_um: process.support.chuck_n_per_um,
        tailstock_n_per_um: process.support.tailstock_n_per_um,
        ..Workpiece::default()
    };
    let stock_diameter_mm = part.stock_diameter_mm;
    let Ok(material) = process.material.resolve() else {
        // `check` refuses it by its key.
        return (Workpiece { stock_diameter_mm, ..paper }, None);
    };
    let w =
        Workpiece { stock_diameter_mm, youngs_modulus_n_per_mm2: material.youngs_modulus_n_per_mm2, ..paper };
    let first = part.nominal_diameter_mm.first().copied().unwrap_or(stock_diameter_mm);
    let cut = Cut {
        depth_mm: (0.5 * (stock_diameter_mm - first)).max(1e-3),
        feed_mm: cutting.feed_mm_per_rev,
        tool: &process.tool,
    };
    let followed = match &process.force {
        ForceLaw::Kienzle(law) => by_kienzle(w, law, &cut, &material),
        ForceLaw::Power(_) => by_ratio(w, &cut, &material),
    };
    match followed {
        Some(w) => (w, None),
        None => (Workpiece { u_ln_coefficient: U_LN_UNKNOWN, ..w }, Some(unfollowed(&material))),
    }
}

fn unfollowed(material: &Material) -> String {
    format!(
        "control.model: no specific cutting force is tabulated for {}: the force assumed is that of {FITTED_TO}, known to a \
         factor of 2; set control.model.coefficient_n",
        material.name
    )
}

/// The first pass.
struct Cut<'a> {
    depth_mm: f64,
    feed_mm: f64,
    tool: &'a ToolSettings,
}

/// The paper's law with the ratio of the materials' specific cutting forces and the handbook's
/// factors of another tool than the paper's.
fn by_ratio(w: Workpiece, cut: &Cut<'_>, material: &Material) -> Option<Workpiece> {
    let chip_mm = KienzleLaw::mean_chip_mm(cut.feed_mm, cut.depth_mm, cut.tool);
    let specific = |m: &Material| m.kienzle.map(|k| k.kc11_n_per_mm2 * chip_mm.powf(-k.mc));
    let ratio = specific(material)? / specific(material::find(FITTED_TO)?)?;
    let tool = ToolFactors::of(cut.tool).over(&ToolFactors::of(&ToolSettings::default()));
    Some(Workpiece { coefficient_n: w.coefficient_n * ratio * tool.passive, ..w })
}

/// The tangent of Kienzle's law; wear, rake and the ratio of the normal force keep their handbook
/// values.
fn by_kienzle(w: Workpiece, law: &KienzleLaw, cut: &Cut<'_>, material: &Material) -> Option<Workpiece> {
    let handbook = KienzleLaw { kc11_n_per_mm2: law.kc11_n_per_mm2, mc: law.mc, ..KienzleLaw::default() };
    let edge = handbook.at(cut.feed_mm, cut.tool, material)?;
    let feed_exponent = 1.0 - law.mc.or(material.kienzle.map(|k| k.mc))?;
    let force = edge.passive_n(cut.depth_mm);
    let exponent = cut.depth_mm * edge.passive_slope_n_per_mm(cut.depth_mm) / force;
    let depth_exponent = exponent.clamp(LEAST_EXPONENT, 2.0);
    Some(Workpiece {
        coefficient_n: force / (cut.depth_mm.powf(depth_exponent) * cut.feed_mm.powf(feed_exponent)),
        depth_exponent,
        feed_exponent,
        speed_exponent: 0.0,
        ..w
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::ModelSettings;
    use crate::process::MaterialSettings;

    /// The inputs of a workpiece from a job.
    #[derive(Default)]
    struct Job {
        part: Part,
        process: ProcessSettings,
    }

    /// The cut of a job's defaults.
    const CUTTING: CuttingData = CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 };

    fn job(material: &str) -> Job {
        let mut job = Job::default();
        job.process.material = MaterialSettings { name: material.to_owned(), ..MaterialSettings::default() };
        job
    }

    fn of(job: &Job) -> (Workpiece, Option<String>) {
        workpiece(&job.part, &job.process, &CUTTING)
    }

    #[test]
    fn the_preset_is_what_it_was() {
        assert_eq!(of(&job("C45")), (Workpiece::default(), None));
    }

    #[test]
    fn length_diameter_and_material_are_the_jobs_own() {
        let mut small = job("EN-GJL-250");
        small.part.length_mm = 120.0;
        small.part.stock_diameter_mm = 12.5;
        small.part.nominal_diameter_mm = vec![12.0];
        small.process.support.chuck_n_per_um = 200.0;
        small.process.support.tailstock_n_per_um = 5.0;
        let (w, word) = of(&small);
        assert_eq!((w.length_mm, w.stock_diameter_mm, w.youngs_modulus_n_per_mm2), (120.0, 12.5, 1.1e5));
        assert_eq!((w.chuck_n_per_um, w.tailstock_n_per_um), (200.0, 5.0));
        // Grey iron: 1160 against 2220 N/mm² at 1 mm, .26 against .14 of slope, at a chip of
        // f·a/(r·acos(1 − a/r)).
        let chip = 0.1 * 0.25 / (0.4 * (1.0_f64 - 0.25 / 0.4).acos());
        let ratio = 1160.0 / 2220.0 * chip.powf(0.14 - 0.26);
        assert!((w.coefficient_n / 4764.2 / ratio - 1.0).abs() < 1e-12 && word.is_none(), "{w:?}");
        // A key set in the table is kept.
        let table =
            ModelSettings { coefficient_n: Some(900.0), length_mm: Some(80.0), ..ModelSettings::default() };
        let seen = table.for_workpiece(&w).workpiece();
        assert_eq!((seen.coefficient_n, seen.length_mm, seen.stock_diameter_mm), (900.0, 80.0, 12.5));
    }

    #[test]
    fn a_material_without_cutting_force_is_said() {
        let (w, word) = of(&job("EN AW-6082"));
        assert_eq!((w.coefficient_n, w.u_ln_coefficient, w.youngs_modulus_n_per_mm2), (4764.2, 0.7, 7.0e4));
        assert!(word.is_some_and(|w| w.contains("EN AW-6082") && w.contains("control.model.coefficient_n")));
    }

    /// The tangent agrees with Kienzle's law and its slope at the first pass.
    #[test]
    fn kienzles_law_is_met_at_the_first_pass() {
        let mut job = job("42CrMo4");
        job.process.force = ForceLaw::Kienzle(KienzleLaw::default());
        let (w, word) = of(&job);
        let material = job.process.material.resolve().unwrap();
        let law = job.process.force.at(&CUTTING, &job.process.tool, &material);
        let force = |a: f64| w.coefficient_n * a.powf(w.depth_exponent) * 0.1_f64.powf(w.feed_exponent);
        assert!((force(0.25) / law.force_n(0.25) - 1.0).abs() < 1e-9 && word.is_none());
        let slope = (force(0.2501) - force(0.2499)) / 2e-4;
        assert!((slope / law.slope_n_per_mm(0.25) - 1.0).abs() < 1e-5);
    }
}
