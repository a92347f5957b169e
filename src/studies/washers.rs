//! Rings of calibrated size: the gauge and a simple method on the same split, with one scale and
//! one edge offset for outline and bore.
//!
//! Scale s and offset o of D = s·d ± o (+ outline, − bore) are fitted by least squares to both
//! diameters of all parts except one and tested on that one. A tactile machine reports the outline
//! as traced by its ball (ISO 16610-41 closing, burrs included), so that the gauge's diameter is
//! that of the outline traced by a ball as well. The ball's size is not stated; the one used is the
//! largest that ISO 12181-2 allows at 50 upr, and common balls are listed beside it. Simple method:
//! level crossing along rays, least-squares circle.
//!
//! Whether one method is better is tested on halves that are split independently of the residuals
//! (every second part by its number): scale and offset from one half, residuals of the other, and
//! back. The difference of the two methods' spreads has an interval by bootstrap over the parts (95
//! % for the four figures together); where that contains zero, there is no difference.

use std::f64::consts::TAU;

use glam::DVec2;
use rand::{RngExt as _, SeedableRng as _};
use rayon::prelude::*;
use serde::Serialize;

use crate::frame::{Frame, FrameView};
use crate::gauge::form::{FormError, least_squares_circle};
use crate::gauge::ring::{EdgeCircle, RingError, RingMeasurement, RingSettings, measure_ring};
use crate::numerics::robust::{MEDIAN_TO_SD, central_median};

/// Outer and inner.
pub(crate) type Pair = [f64; 2];
/// Names of a pair.
pub(crate) const SIDES: [&str; 2] = ["outer", "inner"];
/// Grey value at which the simple method places the edge.
pub(crate) const LEVEL: f64 = 130.0;
/// Diameters of common styli, mm.
pub(crate) const BALLS_MM: [f64; 5] = [1.0, 2.0, 3.0, 4.0, 5.0];
const RAYS: usize = 3600;
/// Bootstrap samples: about 60 lie beyond either end of an interval, so that its tail probability
/// is accurate to an eighth (binomial).
const BOOTSTRAPS: usize = 10_000;
/// Share of the samples beyond either end: four figures are compared, and all four intervals
/// together hold at 95 % (Bonferroni).
const TAIL: f64 = 0.05 / 4.0 / 2.0;
/// Residuals beyond so many robust standard deviations from the median are listed.
const OUTLIER: f64 = 3.0;

/// A part: its image and its tactile diameters.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// File name.
    pub name: String,
    /// The image.
    pub frame: Frame,
    /// Diameters, mm.
    pub machine_mm: Pair,
}

/// Why the study cannot be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum WashersError {
    /// Too few parts to leave one out.
    #[error("{0} parts; at least 4 are needed to leave one out")]
    TooFew(usize),
    /// A part that is not measured.
    #[error("{name}: {cause}")]
    Ring {
        /// The file.
        name: String,
        /// Why.
        cause: RingError,
    },
    /// A disc.
    #[error("{0}: a disc without a bore")]
    NoBore(String),
    /// A part that the simple method, or a ball, cannot measure.
    #[error("{name}: {cause}")]
    Form {
        /// The file.
        name: String,
        /// Why.
        cause: FormError,
    },
}

/// One method on all parts.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct MethodFigures {
    /// The method and its quantity.
    pub name: String,
    /// Diameters, px.
    pub diameter_px: Vec<Pair>,
    /// Machine minus method of each part, scale and offset from the others, µm.
    pub residual_um: Vec<Pair>,
    /// Scale from all parts, µm/px.
    pub um_per_px: f64,
    /// Offset of one edge from all parts, px.
    pub edge_offset_px: f64,
    /// Standard deviation of the residuals, µm.
    pub sd_um: Pair,
    /// 1.4826 times their median departure from their median, µm.
    pub robust_sd_um: Pair,
}

/// A part that departs.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Outlier {
    /// Index of the part.
    pub part: usize,
    /// Its file.
    pub name: String,
    /// 0 outer, 1 inner.
    pub side: usize,
    /// Residual of the gauge and of the simple method, µm.
    pub residual_um: [f64; 2],
}

/// The bootstrap's verdict on the gauge and the simple method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Verdict {
    /// The interval of the difference contains zero.
    NoDifference,
    /// The gauge's spread is smaller.
    Better,
    /// The gauge's spread is larger.
    Worse,
}

impl Verdict {
    /// In words.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::NoDifference => "no difference",
            Self::Better => "ours is better",
            Self::Worse => "ours is worse",
        }
    }
}

/// A spread of the gauge beside the simple method's, on parts that were not used for the scale.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Comparison {
    /// 0 outer, 1 inner.
    pub side: usize,
    /// `sd` or `robust sd`.
    pub figure: &'static str,
    /// The gauge's, µm.
    pub ours_um: f64,
    /// The simple method's, µm.
    pub plain_um: f64,
    /// Interval of the difference gauge − simple method, µm: bootstrap over parts, both methods on
    /// the same sample; 95 % for all four comparisons together.
    pub difference_um: [f64; 2],
    /// Verdict from that interval.
    pub verdict: Verdict,
}

/// The study.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct WashersStudy {
    /// Files.
    pub names: Vec<String>,
    /// The gauge, with the outline as traced by the ball of ISO 12181-2.
    pub ours: MethodFigures,
    /// The gauge's optical edge, calipers with burrs refused.
    pub optical: MethodFigures,
    /// Level crossing and least-squares circle.
    pub level_crossing: MethodFigures,
    /// The gauge with balls of [`BALLS_MM`].
    pub balls: Vec<MethodFigures>,
    /// Parts whose tactile and optical values disagree.
    pub outliers: Vec<Outlier>,
    /// The gauge against the simple method on halves split by the parts' order.
    pub comparisons: Vec<Comparison>,
    /// The measured rings, for figures.
    #[serde(skip)]
    pub rings: Vec<RingMeasurement>,
}

impl WashersStudy {
    /// Figures in which the gauge is worse than the simple method by the bootstrap.
    pub(crate) fn misses(&self) -> Vec<String> {
        self.comparisons
            .iter()
            .filter(|c| c.verdict == Verdict::Worse)
            .map(|c| {
                format!(
                    "{} {} {:.2} um against {:.2} um, difference {:+.2} to {:+.2} um",
                    SIDES[c.side], c.figure, c.ours_um, c.plain_um, c.difference_um[0], c.difference_um[1]
                )
            })
            .collect()
    }
}

/// Runs the study; `done` is called after each part.
///
/// # Errors
/// Too few parts, or one that is not measured.
pub(crate) fn washers(parts: &[Part], done: &(dyn Fn() + Sync)) -> Result<WashersStudy, WashersError> {
    if parts.len() < 4 {
        return Err(WashersError::TooFew(parts.len()));
    }
    let measured: Vec<(RingMeasurement, Pair)> = parts
        .par_iter()
        .map(|part| measure(part).inspect(|_| done()))
        .collect::<Result<_, WashersError>>()?;
    let (rings, crossing): (Vec<RingMeasurement>, Vec<Pair>) = measured.into_iter().unzip();
    let machine: Vec<Pair> = parts.iter().map(|p| p.machine_mm).collect();
    let level_crossing =
        figures(format!("level crossing at {LEVEL}, least-squares circle"), crossing, &machine);
    let of = |name: String, pick: &dyn Fn(&EdgeCircle) -> Result<f64, FormError>| {
        let pairs: Result<Vec<Pair>, WashersError> =
            rings.iter().zip(parts).map(|(ring, part)| pair(ring, &part.name, pick)).collect();
        Ok::<MethodFigures, WashersError>(figures(name, pairs?, &machine))
    };
    let ours = of("ours, felt by a ball of radius d/15".to_owned(), &|e| Ok(e.stylus_diameter_px))?;
    let optical = of("ours, optical edge, burrs refused".to_owned(), &|e| Ok(e.diameter_px))?;
    let radius_px = |ball_mm: f64| 500.0 * ball_mm / level_crossing.um_per_px;
    let balls: Result<Vec<MethodFigures>, WashersError> = BALLS_MM
        .iter()
        .map(|ball| of(format!("ours, ball of {ball} mm"), &|e| e.outline.felt_diameter_px(radius_px(*ball))))
        .collect();
    let balls = balls?;
    let outliers = outliers(parts, &ours, &level_crossing);
    let comparisons = comparisons(&ours.diameter_px, &level_crossing.diameter_px, &machine);
    let names = parts.iter().map(|p| p.name.clone()).collect();
    Ok(WashersStudy { names, ours, optical, level_crossing, balls, outliers, comparisons, rings })
}

fn pair(
    ring: &RingMeasurement,
    name: &str,
    pick: &dyn Fn(&EdgeCircle) -> Result<f64, FormError>,
) -> Result<Pair, WashersError> {
    let inner = ring.inner.as_ref().ok_or_else(|| WashersError::NoBore(name.to_owned()))?;
    let form = |cause| WashersError::Form { name: name.to_owned(), cause };
    Ok([pick(&ring.outer).map_err(form)?, pick(inner).map_err(form)?])
}

fn measure(part: &Part) -> Result<(RingMeasurement, Pair), WashersError> {
    let name = || part.name.clone();
    let view = part.frame.view();
    let ring = measure_ring(&view, &RingSettings::default())
        .map_err(|cause| WashersError::Ring { name: name(), cause })?;
    let inner = ring.inner.as_ref().ok_or_else(|| WashersError::NoBore(name()))?;
    let plain = |edge: &EdgeCircle, outward| {
        level_crossing(&view, (DVec2::from(edge.centre_px), 0.5 * edge.diameter_px), outward)
            .map_err(|cause| WashersError::Form { name: name(), cause })
    };
    let crossing = [plain(&ring.outer, 1.0)?, plain(inner, -1.0)?];
    Ok((ring, crossing))
}

/// Diameter of the least-squares circle through the first crossings of [`LEVEL`] from the shadow
/// outwards, along bilinear rays in steps of a quarter of a pixel; twice, for the centre.
fn level_crossing(view: &FrameView<'_>, mut circle: (DVec2, f64), outward: f64) -> Result<f64, FormError> {
    let grey = |p: DVec2| {
        let (corner, part) = (p.floor(), p - p.floor());
        let at = |dc: f64, dr: f64| {
            let (c, r) = (corner.x + dc, corner.y + dr);
            if c < 0.0 || r < 0.0 {
                f64::NAN
            } else {
                view.get(r as usize, c as usize).map_or(f64::NAN, f64::from)
            }
        };
        (1.0 - part.y) * ((1.0 - part.x) * at(0.0, 0.0) + part.x * at(1.0, 0.0))
            + part.y * ((1.0 - part.x) * at(0.0, 1.0) + part.x * at(1.0, 1.0))
    };
    for _ in 0..2 {
        let points: Vec<DVec2> = (0..RAYS)
            .filter_map(|k| {
                let direction = DVec2::from_angle(TAU * k as f64 / RAYS as f64);
                let at = |i: f64| circle.0 + direction * (circle.1 + outward * 0.25 * i);
                let above = |i: i32| grey(at(f64::from(i))) - LEVEL;
                let i = (-32..32).find(|i| above(*i) <= 0.0 && above(i + 1) > 0.0)?;
                Some(at(f64::from(i) + above(i) / (above(i) - above(i + 1))))
            })
            .collect();
        let fit = least_squares_circle(&points)?.fit.circle;
        circle = (fit.centre, fit.radius);
    }
    Ok(2.0 * circle.1)
}

fn figures(name: String, diameter_px: Vec<Pair>, machine_mm: &[Pair]) -> MethodFigures {
    let all: Vec<(Pair, Pair)> = diameter_px.iter().copied().zip(machine_mm.iter().copied()).collect();
    let residual_um: Vec<Pair> = (0..all.len())
        .map(|left| {
            let others = all.iter().enumerate().filter(|(k, _)| *k != left).map(|(_, p)| p);
            residual_um(&all[left], scale_and_offset(others))
        })
        .collect();
    let (scale, offset) = scale_and_offset(all.iter());
    let spread = [0, 1].map(|side| spreads(&residual_um.iter().map(|r| r[side]).collect::<Vec<f64>>()));
    MethodFigures {
        name,
        diameter_px,
        residual_um,
        um_per_px: 1e3 * scale,
        edge_offset_px: 0.5 * offset / scale,
        sd_um: spread.map(|s| s[0]),
        robust_sd_um: spread.map(|s| s[1]),
    }
}

/// Residuals of both halves (every second part in the order given), each with the other half's
/// scale and offset, µm.
fn split_residuals(diameter_px: &[Pair], machine_mm: &[Pair]) -> Vec<Pair> {
    let all: Vec<(Pair, Pair)> = diameter_px.iter().copied().zip(machine_mm.iter().copied()).collect();
    let fits = [0, 1].map(|half| scale_and_offset(all.iter().skip(1 - half).step_by(2)));
    all.iter().enumerate().map(|(k, pair)| residual_um(pair, fits[k % 2])).collect()
}

fn residual_um((px, mm): &(Pair, Pair), (scale, offset): (f64, f64)) -> Pair {
    [1e3 * (mm[0] - scale * px[0] - offset), 1e3 * (mm[1] - scale * px[1] + offset)]
}

/// The gauge beside the simple method on split halves: both figures of both sides.
fn comparisons(ours_px: &[Pair], plain_px: &[Pair], machine_mm: &[Pair]) -> Vec<Comparison> {
    let (ours, plain) = (split_residuals(ours_px, machine_mm), split_residuals(plain_px, machine_mm));
    let of_side = |residuals: &[Pair], side: usize| residuals.iter().map(|r| r[side]).collect::<Vec<f64>>();
    let mut found = Vec::new();
    for side in 0..2 {
        let (ours, plain) = (of_side(&ours, side), of_side(&plain, side));
        for (index, figure) in ["sd", "robust sd"].into_iter().enumerate() {
            let difference_um = bootstrap(&ours, &plain, index);
            let verdict = match difference_um {
                [_, high] if high < 0.0 => Verdict::Better,
                [low, _] if low > 0.0 => Verdict::Worse,
                _ => Verdict::NoDifference,
            };
            let [ours_um, plain_um] = [&ours, &plain].map(|r| spreads(r)[index]);
            found.push(Comparison { side, figure, ours_um, plain_um, difference_um, verdict });
        }
    }
    found
}

/// Interval of the difference of a spread (index into [`spreads`]) between two methods on the same
/// parts: percentiles over samples of the parts with replacement (Efron, Tibshirani 1993, ch. 13).
/// The seed is fixed: equal inputs give equal intervals.
fn bootstrap(ours: &[f64], plain: &[f64], index: usize) -> [f64; 2] {
    let mut random = rand_pcg::Pcg64::seed_from_u64(0x7761_7368);
    let parts = ours.len();
    let mut differences: Vec<f64> = (0..BOOTSTRAPS)
        .map(|_| {
            let sample: Vec<usize> = (0..parts).map(|_| random.random_range(0..parts)).collect();
            let spread = |r: &[f64]| spreads(&sample.iter().map(|k| r[*k]).collect::<Vec<f64>>())[index];
            spread(ours) - spread(plain)
        })
        .collect();
    differences.sort_by(f64::total_cmp);
    [TAIL, 1.0 - TAIL].map(|p| differences[(p * (BOOTSTRAPS - 1) as f64).round() as usize])
}

/// Least squares of D = s·d ± o over both sides: (s, o), mm/px and mm.
fn scale_and_offset<'a>(pairs: impl Iterator<Item = &'a (Pair, Pair)>) -> (f64, f64) {
    let (mut dd, mut d1, mut n, mut dm, mut m1) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (px, mm) in pairs {
        for (k, side) in [(0, 1.0), (1, -1.0)] {
            dd += px[k] * px[k];
            d1 += px[k] * side;
            n += 1.0;
            dm += px[k] * mm[k];
            m1 += side * mm[k];
        }
    }
    let determinant = dd * n - d1 * d1;
    ((dm * n - m1 * d1) / determinant, (dd * m1 - d1 * dm) / determinant)
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    central_median(&mut values.collect::<Vec<f64>>()).unwrap_or(f64::NAN)
}

/// Standard deviation and robust standard deviation.
fn spreads(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let sd = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let middle = median(values.iter().copied());
    [sd, MEDIAN_TO_SD * median(values.iter().map(|v| (v - middle).abs()))]
}

fn outliers(parts: &[Part], ours: &MethodFigures, plain: &MethodFigures) -> Vec<Outlier> {
    let mut found = Vec::new();
    for side in 0..2 {
        let middle = median(ours.residual_um.iter().map(|r| r[side]));
        for (k, part) in parts.iter().enumerate() {
            let residual_um = [ours.residual_um[k][side], plain.residual_um[k][side]];
            if (residual_um[0] - middle).abs() > OUTLIER * ours.robust_sd_um[side] {
                found.push(Outlier { part: k, name: part.name.clone(), side, residual_um });
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaving_one_out_finds_scale_and_offset_and_the_part_that_departs() {
        let (scale, offset) = (0.0174, 0.015);
        let px: Vec<Pair> =
            (0..9).map(|k| [1360.0 + f64::from(k * k % 7), 1095.0 - f64::from(k % 4)]).collect();
        let mut mm: Vec<Pair> = px.iter().map(|p| [scale * p[0] + offset, scale * p[1] - offset]).collect();
        let exact = figures("x".into(), px.clone(), &mm);
        assert!(
            (exact.um_per_px - 17.4).abs() < 1e-9
                && (exact.edge_offset_px - 0.5 * offset / scale).abs() < 1e-7
        );
        assert!(exact.sd_um.iter().chain(&exact.robust_sd_um).all(|s| *s < 1e-7));
        mm[4][1] += 0.02;
        let one = figures("x".into(), px, &mm);
        // The residual of the altered part is exact, because the part was not used for its own
        // scale.
        assert!((one.residual_um[4][1] - 20.0).abs() < 1e-6 && one.residual_um[4][0].abs() < 1e-6);
        assert!(one.sd_um[1] > 5.0 && one.robust_sd_um[1] < 3.0);
        assert_eq!(spreads(&[1.0, 2.0, 3.0, 4.0])[1], 1.4826);
    }

    #[test]
    fn a_bootstrap_tells_a_difference_from_none() {
        // The same errors in another order differ by chance alone; three times the errors differ.
        let errors = [0.3, -1.2, 2.1, -0.4, 0.9, -1.8, 0.1, 1.3, -0.7, -0.2, 1.6, -1.1, 0.5, -0.6, 0.8];
        let px: Vec<Pair> =
            (0..15).map(|k| [1360.0 + f64::from(k * k % 11), 1095.0 - f64::from(k % 4)]).collect();
        let mm: Vec<Pair> = px.iter().map(|p| [0.0174 * p[0], 0.0174 * p[1]]).collect();
        let with = |factor: f64, turn: usize| -> Vec<Pair> {
            px.iter()
                .enumerate()
                .map(|(k, p)| p.map(|d| d + factor * errors[(k + turn) % 15] / 17.4))
                .collect()
        };
        let verdicts = |ours: &[Pair], plain: &[Pair]| -> Vec<Verdict> {
            comparisons(ours, plain, &mm).iter().map(|c| c.verdict).collect()
        };
        assert!(verdicts(&with(1.0, 0), &with(1.0, 4)).iter().all(|v| *v == Verdict::NoDifference));
        assert_eq!(verdicts(&with(3.0, 0), &with(1.0, 4))[0], Verdict::Worse);
        assert_eq!(verdicts(&with(1.0, 0), &with(3.0, 4))[0], Verdict::Better);
        // A part of one half does not change the other half's scale, with which it is tested.
        let split = split_residuals(&px, &mm);
        let mut moved = mm.clone();
        moved[4][0] += 0.02;
        let one = split_residuals(&px, &moved);
        assert!((one[4][0] - split[4][0] - 20.0).abs() < 1e-6);
    }
}
