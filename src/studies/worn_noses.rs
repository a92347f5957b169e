//! Worn noses through every edge-spread family of the renderer, contaminated or clean: the error of
//! e(a) over 90°, and whether what is wrong is flagged.
//!
//! An edge-spread function that is not symmetric moves all edges alike, by b towards the light. A
//! calibration measures b and takes it off; here it is the displacement of both edges of a new
//! insert of known place, drawn through the same family. What of b stays in e(a) is
//! (1 − w₀ − w₁)·b, w the weights of both touches, and is taken off with it.

use rand::{RngExt as _, SeedableRng as _};
use serde::Serialize;

use super::noses::{e_errors, posed, support_errors};
use crate::frame::Frame;
use crate::gauge::nose::{NoseMeasurement, NoseSettings, measure_nose};
use crate::render::RenderError;
use crate::render::esf_families::{CylinderEdge, LaserShadow, MeasuredEsf, PartiallyCoherentEdge};
use crate::render::insert::{Dirt, InsertBlur, InsertSettings, Truth, render_insert_through};
use crate::render::settings::{Esf, GaussianEsf};

/// What is asked of e(a): rms and largest error, µm.
pub(crate) const ASKED_UM: [f64; 2] = [0.1, 0.5];
/// The kinds of wear, of [`posed`]: worn round, flat, dented, chipped, with a built-up edge.
const WEAR: [&str; 5] = ["round", "flat", "dent", "chip", "built_up_edge"];
/// Flags that describe the wear of a nose that is well measured, or a profile whose displacement of
/// all edges is taken off here; the others limit its use.
const DESCRIBE: [&str; 5] = ["worn", "edge_worn", "chipped", "beyond_nominal", "edge_profile"];

/// What is drawn.
#[derive(Clone, Debug)]
pub(crate) struct WornSettings {
    /// Camera, nose, light and sensor.
    pub insert: InsertSettings,
    /// Families in turn.
    pub families: Vec<(&'static str, Esf)>,
    /// Noses.
    pub count: usize,
    /// Whether every second nose has one to three specks at its contour.
    pub contamination: bool,
    /// Seed of poses, wear, specks and noise.
    pub seed: u64,
}

/// A nose and how it came out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct WornNose {
    /// Edge-spread family.
    pub family: &'static str,
    /// Kind of wear.
    pub wear: &'static str,
    /// Specks at its contour.
    pub specks: usize,
    /// Flags, joined by a space; empty where refused.
    pub flags: String,
    /// Whether one of them limits the use of e(a).
    pub flagged: bool,
    /// Rms error of e(a), µm; none where refused.
    pub rms_um: Option<f64>,
    /// Largest error of e(a), µm; none where refused.
    pub worst_um: Option<f64>,
    /// Why it was refused; empty where measured.
    pub refused: String,
}

/// The noses of a family.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct WornRow {
    /// Edge-spread family; `all` of them.
    pub family: String,
    /// Noses drawn.
    pub noses: usize,
    /// Measured without a flag that limits them.
    pub measured: usize,
    /// Measured and flagged.
    pub flagged: usize,
    /// Refused.
    pub refused: usize,
    /// Displacement b of a straight edge by the family, µm; none of `all`, and where the new insert
    /// is refused.
    pub edge_offset_um: Option<f64>,
    /// Rms error of e(a) of those measured, µm.
    pub rms_um: f64,
    /// Largest error of them, µm.
    pub worst_um: f64,
    /// Largest error of those flagged, µm.
    pub flagged_worst_um: f64,
    /// Noses that are wrong by more than asked for and not flagged.
    pub wrong: usize,
}

/// Every family that draws inserts, with a blur of about a pixel of 2.4 µm.
pub(crate) fn families() -> Vec<(&'static str, Esf)> {
    let partial =
        PartiallyCoherentEdge { na: 0.06, coherence_ratio: 0.7, ..PartiallyCoherentEdge::default() };
    let cylinder = CylinderEdge { na: 0.06, coherence_ratio: 0.7, ..CylinderEdge::default() };
    // a contact shadow: the sensor 15 µm behind the edge, below which its pixels average the
    // fringes
    let laser = LaserShadow { distance_mm: 0.015, source_half_angle_mrad: 50.0, ..LaserShadow::default() };
    vec![
        ("gaussian", Esf::Gaussian(GaussianEsf { sigma_px: 1.2 })),
        ("partially_coherent", Esf::PartiallyCoherent(partial)),
        ("cylinder", Esf::Cylinder(cylinder)),
        ("fresnel", Esf::Fresnel(laser)),
        ("measured", Esf::Measured(with_halo())),
    ]
}

/// An edge as a lens with stray light shows it: nine tenths of the light within 2.6 µm (standard
/// deviation), the rest within 8 µm and displaced by 1 µm.
fn with_halo() -> MeasuredEsf {
    let cdf = crate::numerics::distributions::phi_cdf;
    let d_um: Vec<f64> = (-160..=160).map(|k| 0.25 * f64::from(k)).collect();
    let intensity = d_um.iter().map(|d| 0.9 * cdf(d / 2.6) + 0.1 * cdf((d - 1.0) / 8.0)).collect();
    MeasuredEsf { d_um, intensity, ..MeasuredEsf::default() }
}

/// Draws and measures the noses; `step` is called after each with its frame and truth.
///
/// # Errors
/// Settings that the renderer refuses.
pub(crate) fn run(
    of: &WornSettings,
    step: &mut dyn FnMut(&Frame, &Truth),
) -> Result<(Vec<WornNose>, Vec<WornRow>), RenderError> {
    let mut random = rand_pcg::Pcg64::seed_from_u64(of.seed);
    let blurs = blurs(of)?;
    let offsets = edge_offsets(of, &blurs)?;
    let mut noses = Vec::new();
    for k in 0..of.count {
        let (kind, family) = (k / of.families.len() % WEAR.len(), k % of.families.len());
        let mut draw = || random.random();
        let mut s = posed(&of.insert, kind + 1, &mut draw);
        s.esf = of.families[family].1.clone();
        // every second one of each pair of family and wear
        let specks = of.contamination && k / (of.families.len() * WEAR.len()) % 2 == 1;
        if specks {
            contaminate(&mut s, &mut draw);
        }
        let (frame, truth) = render_insert_through(&s, &blurs[family], (of.seed, k as u64), true)?;
        let measured = measure_nose(&frame.view(), &known(&s, &truth));
        let nose = WornNose {
            family: of.families[family].0,
            wear: WEAR[kind],
            specks: s.dirt.len(),
            flags: String::new(),
            flagged: false,
            rms_um: None,
            worst_um: None,
            refused: String::new(),
        };
        noses.push(match measured {
            Ok(m) => compared(nose, &m, &truth, s.camera.um_per_px, offsets[family].unwrap_or(0.0)),
            Err(error) => WornNose { refused: error.to_string(), ..nose },
        });
        step(&frame, &truth);
    }
    let um_per_px = of.insert.camera.um_per_px;
    let offset_um = |(family, b): (&(&'static str, Esf), &Option<f64>)| (family.0, b.map(|b| um_per_px * b));
    let offsets: Vec<_> = of.families.iter().zip(&offsets).map(offset_um).collect();
    let rows = rows(&noses, &offsets);
    Ok((noses, rows))
}

/// What each family does to an area.
fn blurs(of: &WornSettings) -> Result<Vec<InsertBlur>, RenderError> {
    let blur =
        |(_, esf): &(&str, Esf)| InsertBlur::new(&InsertSettings { esf: esf.clone(), ..of.insert.clone() });
    of.families.iter().map(blur).collect()
}

fn known(s: &InsertSettings, truth: &Truth) -> NoseSettings {
    let nominal_radius_px = Some(truth.nominal_radius_px);
    NoseSettings { nominal_radius_px, um_per_px: s.camera.um_per_px, expected: None }
}

/// Displacement of the edges by each family, px: of a new insert, both edges' mean.
fn edge_offsets(of: &WornSettings, blurs: &[InsertBlur]) -> Result<Vec<Option<f64>>, RenderError> {
    let mut offsets = Vec::new();
    for ((_, esf), blur) in of.families.iter().zip(blurs) {
        let s = InsertSettings { esf: esf.clone(), ..of.insert.clone() };
        let (frame, truth) = render_insert_through(&s, blur, (of.seed, u64::MAX), true)?;
        offsets.push(measure_nose(&frame.view(), &known(&s, &truth)).ok().map(|m| {
            let off = [m.centre.x - truth.centre_px[0], m.centre.y + truth.centre_px[1]];
            let along = |deg: f64| off[0] * deg.to_radians().cos() + off[1] * deg.to_radians().sin();
            0.5 * truth.edge_normals_deg.iter().map(|deg| along(*deg)).sum::<f64>()
        }));
    }
    Ok(offsets)
}

/// One to three specks of 4 to 40 µm radius that touch the contour or lie beside it.
fn contaminate(s: &mut InsertSettings, draw: &mut dyn FnMut() -> f64) {
    let (um, sweep) = (s.camera.um_per_px, 180.0 - s.nose.epsilon_deg);
    let radius_px = 1e3 * s.nose.radius_mm / um;
    let count = 1 + (3.0 * draw()) as usize;
    for _ in 0..count {
        let radius_um = 4.0 + 36.0 * draw().powi(2);
        let off = radius_px + (2.0 * draw() - 1.0) * (radius_um / um + 4.0);
        let (turn, along) = (draw() - 0.5, draw());
        let (deg, slide) = if draw() < 0.5 {
            (s.nose.direction_deg + sweep * turn, 0.0)
        } else {
            let side = turn.signum();
            (s.nose.direction_deg + 0.5 * sweep * side, side * 2.0 * radius_px * along)
        };
        let (sin, cos) = deg.to_radians().sin_cos();
        let [column, row] = s.nose.centre_px;
        let centre_px = [column + off * cos - slide * sin, row - off * sin - slide * cos];
        s.dirt.push(Dirt { centre_px, radius_um });
    }
}

/// A nose with the errors of e(a); `offset_px` is b.
fn compared(nose: WornNose, m: &NoseMeasurement, truth: &Truth, um: f64, offset_px: f64) -> WornNose {
    let off = support_errors(m, truth);
    let errors: Vec<f64> = e_errors(&off).map(|(error, share)| um * (error - share * offset_px)).collect();
    let square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64;
    WornNose {
        flags: m.flags.join(" "),
        flagged: m.flags.iter().any(|flag| !DESCRIBE.contains(flag)),
        rms_um: Some(square.sqrt()),
        worst_um: Some(errors.iter().fold(0.0, |most: f64, e| most.max(e.abs()))),
        ..nose
    }
}

impl WornNose {
    /// Whether it is wrong by more than asked for and not flagged.
    pub(crate) fn is_wrong(&self) -> bool {
        !self.flagged && self.worst_um.is_some_and(|worst| worst > ASKED_UM[1])
    }
}

/// Rows by family, and all.
fn rows(noses: &[WornNose], offsets_um: &[(&'static str, Option<f64>)]) -> Vec<WornRow> {
    let row = |family: &str, edge_offset_um: Option<f64>| {
        let own: Vec<&WornNose> = noses.iter().filter(|n| family == "all" || n.family == family).collect();
        let good: Vec<&&WornNose> = own.iter().filter(|n| n.rms_um.is_some() && !n.flagged).collect();
        let most = |of: &mut dyn Iterator<Item = f64>| of.fold(0.0_f64, f64::max);
        let square: f64 = good.iter().filter_map(|n| n.rms_um).map(|r| r * r).sum();
        WornRow {
            family: family.to_owned(),
            noses: own.len(),
            measured: good.len(),
            flagged: own.iter().filter(|n| n.flagged).count(),
            refused: own.iter().filter(|n| n.rms_um.is_none()).count(),
            edge_offset_um,
            rms_um: (square / good.len().max(1) as f64).sqrt(),
            worst_um: most(&mut good.iter().filter_map(|n| n.worst_um)),
            flagged_worst_um: most(&mut own.iter().filter(|n| n.flagged).filter_map(|n| n.worst_um)),
            wrong: own.iter().filter(|n| n.is_wrong()).count(),
        }
    };
    let families = offsets_um.iter().map(|(family, offset)| row(family, *offset));
    families.chain([row("all", None)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_count_what_is_measured_flagged_and_refused_and_name_what_is_wrong() {
        let nose = |worst_um: Option<f64>, flagged: bool| WornNose {
            family: "gaussian",
            wear: "round",
            specks: 0,
            flags: String::new(),
            flagged,
            rms_um: worst_um.map(|w| 0.5 * w),
            worst_um,
            refused: String::new(),
        };
        let noses =
            [nose(Some(0.2), false), nose(Some(0.7), false), nose(Some(9.0), true), nose(None, false)];
        let all = rows(&noses, &[("gaussian", Some(0.1)), ("cylinder", None)]);
        let [gaussian, cylinder, sum] = &all[..] else { panic!("{all:?}") };
        assert_eq!((gaussian.noses, gaussian.measured, gaussian.flagged, gaussian.refused), (4, 2, 1, 1));
        assert_eq!((gaussian.wrong, gaussian.worst_um, gaussian.flagged_worst_um), (1, 0.7, 9.0));
        assert!((gaussian.rms_um - f64::sqrt((0.01 + 0.1225) / 2.0)).abs() < 1e-12);
        assert_eq!((cylinder.noses, sum.noses, sum.wrong), (0, 4, 1));
    }

    #[test]
    fn worn_noses_of_a_small_field_are_right_or_flagged() {
        let mut insert = InsertSettings::default();
        (insert.camera.columns, insert.camera.rows) = (640, 512);
        insert.nose.radius_mm = 0.2;
        insert.nose.centre_px = [260.0, 310.0];
        let families = families().into_iter().filter(|f| ["gaussian", "measured"].contains(&f.0)).collect();
        let of = WornSettings { insert, families, count: 12, contamination: true, seed: 2 };
        let mut drawn = 0;
        let (noses, rows) = run(&of, &mut |_, _| drawn += 1).unwrap();
        assert_eq!((drawn, noses.len()), (12, 12));
        assert!(noses.iter().any(|n| n.specks > 0) && noses.iter().any(|n| n.specks == 0));
        let all = rows.last().unwrap();
        assert_eq!(all.wrong, 0, "{noses:?}");
        assert!(all.measured >= 4, "{rows:?}");
    }
}
