//! The uncertainty budget of a diameter (GUM clause 8 and annex H): one row a source, random and
//! common apart.

use std::fmt::{Arguments, Write as _};
use std::ops::Range;

use serde::Serialize;

pub(crate) use super::budget_conditions::OF_CONDITIONS;
use super::budget_conditions::{self, Row};
pub(crate) use super::form_scatter::Scatter;
use super::stated::stated;
pub(crate) use super::texts::Texts;
use crate::gauge::calibration::gauge_calibration::Calibration;
use crate::gauge::calibration::{ColumnSpread, Conditions, CovariancePart, LensModel, ReadWidth};
use crate::gauge::edges::{FrameEdges, FrameFigures};
use crate::gauge::width::axis_slope::AxisSlope;
use crate::gauge::width::blur_sensitivity::u_blur_px;
use crate::gauge::width::column_means::ColumnMeans;

/// Whether a source's errors differ from reading to reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Share {
    /// Decreases with averaging.
    Random,
    /// The same in all readings of one calibration and set-up.
    Common,
}

/// Shape of a source's distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Normal.
    Normal,
    /// Rectangular: only limits are known.
    Rectangular,
    /// Product of a factor that is known to a normal standard uncertainty and an error of which
    /// only limits are known.
    Product {
        /// The factor's estimate over its root mean square, 0 to 1.
        known: f64,
    },
}

impl Shape {
    /// Its name in tables and files.
    pub(crate) fn as_str(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Rectangular => "rectangular",
            Self::Product { .. } => "product",
        }
    }
}

impl Serialize for Shape {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

/// One row.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contribution {
    /// The source.
    pub source: String,
    /// Estimate or limits of the input, with its unit.
    pub input: String,
    /// Shape of its distribution.
    pub shape: Shape,
    /// Whether it averages.
    pub share: Share,
    /// Degrees of freedom; none for an evaluation of type B.
    pub freedom: Option<f64>,
    /// Standard uncertainty it gives the diameter, mm.
    pub u_mm: f64,
}

/// The budget of one diameter.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Budget {
    /// The diameter, mm.
    pub diameter_mm: f64,
    /// Its rows.
    pub contributions: Vec<Contribution>,
}

/// Probability of the intervals where no coverage factor is given: that of k = 2 for a normal
/// distribution.
pub(crate) const PROBABILITY: f64 = 0.954_499_736_103_641_6;

/// Draws of [`Budget::half_width_mm`]: the quantile is then known to 1 %.
pub(crate) const DRAWS: usize = 20_000;

impl Budget {
    fn sum(&self, wanted: impl Fn(&Contribution) -> bool) -> f64 {
        // From +0: an empty sum of floats is −0.
        self.contributions.iter().filter(|c| wanted(c)).fold(0.0, |sum, c| sum + c.u_mm * c.u_mm).sqrt()
    }

    /// Random standard uncertainty, mm.
    pub(crate) fn u_random_mm(&self) -> f64 {
        self.sum(|c| c.share == Share::Random)
    }

    /// Common standard uncertainty, mm.
    pub(crate) fn u_common_mm(&self) -> f64 {
        self.sum(|c| c.share == Share::Common)
    }

    /// Combined standard uncertainty, mm.
    pub(crate) fn u_mm(&self) -> f64 {
        self.sum(|_| true)
    }

    /// Effective degrees of freedom (Welch-Satterthwaite, GUM G.4.1); infinite where nothing is of
    /// type A.
    pub(crate) fn effective_freedom(&self) -> f64 {
        let fourth: f64 =
            self.contributions.iter().filter_map(|c| c.freedom.map(|n| c.u_mm.powi(4) / n.max(1.0))).sum();
        if fourth > 0.0 { self.u_mm().powi(4) / fourth } else { f64::INFINITY }
    }

    /// Adds a row, unless it is zero. NaN is kept: the sum is then NaN too, where leaving it out
    /// would state a certainty.
    pub(crate) fn push(&mut self, contribution: Contribution) {
        if contribution.u_mm != 0.0 {
            self.contributions.push(contribution);
        }
    }

    /// The rows as a table: largest first, percentages of the variance. U is k·u for a coverage
    /// factor given, else for that of [`Self::factor_or`].
    pub(crate) fn to_table(&self, given: Option<f64>) -> String {
        let k = self.factor_or(given);
        let freedom = match self.effective_freedom() {
            n if n < 1e4 => format!("{n:.1}"),
            _ => "many".to_owned(),
        };
        let covers = match given {
            Some(_) => format!("; {:.3} covers", self.coverage_factor(PROBABILITY)),
            None => " covers".to_owned(),
        };
        let mut rows: Vec<&Contribution> = self.contributions.iter().collect();
        rows.sort_by(|a, b| b.u_mm.total_cmp(&a.u_mm));
        let total = self.u_mm().powi(2);
        let mut text = format!(
            "{:<48} {:<34} {:<12} {:<7} {:>9} {:>7}\n",
            "source", "input", "distribution", "share", "u / um", "% of u2"
        );
        for row in rows {
            let _ = writeln!(
                text,
                "{:<48} {:<34} {:<12} {:<7} {:>9.4} {:>7.2}",
                row.source,
                row.input,
                row.shape.as_str(),
                format!("{:?}", row.share).to_lowercase(),
                1e3 * row.u_mm,
                100.0 * row.u_mm * row.u_mm / total
            );
        }
        let expanded_mm = k * self.u_mm();
        let u = |u_mm: f64| stated(0.0, 1e3 * u_mm)[1].clone();
        let _ = writeln!(
            text,
            "D = {} mm   u random {} um, common {} um, combined {} um   U = {} um (k = {}{covers} 95.45 % at {freedom} effective degrees of freedom)",
            stated(self.diameter_mm, expanded_mm)[0],
            u(self.u_random_mm()),
            u(self.u_common_mm()),
            u(self.u_mm()),
            u(expanded_mm),
            // Up to three digits, none of them for zero.
            (1e3 * k).round() / 1e3
        );
        text
    }
}

/// Standard uncertainties of a width by what the edges of its frame are uncertain by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct EdgesUncertainty {
    /// By noise alone, px.
    pub noise_px: f64,
    /// Share of quantisation in that noise' variance: (1/12)/σ_n².
    pub quantisation_share: f64,
    /// By the levels of light and shadow, px.
    pub levels_px: f64,
    /// By the edge model, beyond the systematic residual of the calibration's masters, px.
    pub misfit_px: f64,
    /// By light or shadow beyond the end of the grey scale, px.
    pub clipped_px: f64,
    /// By rounding that repeats in neighbouring columns and in every frame, px.
    pub rounding_px: f64,
    /// By the blur's uncertainty, px.
    pub blur_px: f64,
    /// Standard uncertainty of the blur itself, px.
    pub sigma_px: f64,
}

/// A width in the image, input of a diameter's budget.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WidthReading {
    /// Column where it stands (the middle of those averaged), px.
    pub column_px: f64,
    /// Variance of the columns averaged, px².
    pub column_variance_px2: f64,
    /// Mean rows of the two edges, px.
    pub rows_px: (f64, f64),
    /// Chord factor of the axis' tilt.
    pub chord: f64,
    /// What the frame's edges are uncertain by.
    pub u: EdgesUncertainty,
    /// The frame's figures, for the ambiguity of its edge-spread function.
    pub figures: FrameFigures,
    /// Form, texture and sampling: scatter of the widths averaged.
    pub form: Scatter,
}

impl WidthReading {
    /// Mean width over columns of a frame; `None` where fewer than 8 of them have both edges.
    pub(crate) fn of_frame(edges: &FrameEdges, columns: Range<usize>) -> Option<Self> {
        let over = ColumnMeans::over(edges, columns)?;
        let chord = AxisSlope::of(edges).factor(over.column_px as usize);
        let clipped = edges.clipped_variance().min(over.u_shared_px.powi(2));
        let rounding = edges.figures.rounding_variance();
        let levels = over.u_shared_px.powi(2) - over.u_misfit_px.powi(2) - clipped - rounding;
        let (blur_px, sigma_px) = u_blur_px(edges, &over.used);
        Some(Self {
            column_px: over.column_px,
            column_variance_px2: over.column_variance_px2,
            rows_px: over.rows_px,
            chord,
            u: EdgesUncertainty {
                noise_px: over.own_variance_px2.sqrt(),
                quantisation_share: quantisation_share(edges),
                levels_px: levels.max(0.0).sqrt(),
                misfit_px: over.u_misfit_px,
                clipped_px: clipped.sqrt(),
                rounding_px: rounding.sqrt(),
                blur_px,
                sigma_px,
            },
            figures: edges.figures,
            form: Scatter::of_blocks(edges, &over),
        })
    }

    /// The diameter at 20 °C and its budget.
    pub(crate) fn budget(&self, calibration: &Calibration, conditions: &Conditions) -> Budget {
        let mut budget = Budget::default();
        self.budget_into(calibration, conditions, Texts::Written, &mut budget);
        budget
    }

    /// As [`Self::budget`], in the memory of an earlier one.
    pub(crate) fn budget_into(
        &self,
        calibration: &Calibration,
        conditions: &Conditions,
        texts: Texts,
        budget: &mut Budget,
    ) {
        budget.contributions.clear();
        let scale = calibration.scale_mm_per_px;
        let (width_px, by) = match &calibration.setup {
            Some(setup) => {
                let columns =
                    ColumnSpread { mean_px: self.column_px, variance_px2: self.column_variance_px2 };
                let (rows_px, chord, axis_y_mm) = (self.rows_px, self.chord, conditions.axis_in_frame_mm());
                let by = setup.diameter_by(scale, &ReadWidth { columns, rows_px, chord, axis_y_mm });
                (by[0], Some(by))
            }
            None => ((self.rows_px.1 - self.rows_px.0) * self.chord, None),
        };
        let at_t = calibration.diameter_mm(width_px);
        budget.diameter_mm = conditions.part_mm(at_t) * conditions.to_reference();
        self.add_edges(budget, scale * self.chord, calibration.setup.as_ref().map(|b| &b.lens), texts);
        budget.push(self.place(calibration, texts));
        match (&calibration.setup, by) {
            (Some(setup), Some(by)) => {
                for part in &setup.parts {
                    budget.push(common(part, &by, texts));
                }
            }
            _ => add_scale_and_offset(budget, calibration, width_px, texts),
        }
        add_conditions(budget, calibration, conditions, at_t, texts);
    }

    /// The row of edges with ambiguous position, because their edge-spread function was estimated
    /// from the frame and the masters' was not, or the other way round.
    fn place(&self, calibration: &Calibration, texts: Texts) -> Contribution {
        let limit = self.figures.position_ambiguity_px[0] + self.figures.position_ambiguity_px[1];
        let (source, input) = if calibration.is_learnt() {
            let limit = self.figures.unlearnt_position_px();
            (
                "place of edges not learnt, as the masters' were",
                texts.of(format_args!("± {limit:.3} px of width")),
            )
        } else {
            ("place of learnt edges, no masters", texts.of(format_args!("0 to {limit:.3} px of width less")))
        };
        Contribution {
            source: texts.of(format_args!("{source}")),
            input,
            shape: Shape::Rectangular,
            share: Share::Common,
            freedom: None,
            u_mm: calibration.scale_mm_per_px * self.chord * calibration.u_position_px(&self.figures),
        }
    }

    fn add_edges(&self, budget: &mut Budget, mm_per_px: f64, lens: Option<&LensModel>, texts: Texts) {
        let u = &self.u;
        let (u_form_px, form_freedom) = self.form.u_px(lens, u.noise_px);
        let share = u.quantisation_share.clamp(0.0, 1.0);
        let width = |u_px: f64| texts.of(format_args!("{u_px:.5} px of width"));
        let mut random = |source: &str, input: String, u_px: f64, freedom: Option<f64>| {
            budget.push(Contribution {
                source: texts.of(format_args!("{source}")),
                input,
                shape: Shape::Normal,
                share: Share::Random,
                freedom,
                u_mm: mm_per_px * u_px,
            });
        };
        let (noise, quantisation) = (u.noise_px * (1.0 - share).sqrt(), u.noise_px * share.sqrt());
        random("noise of the edges", width(noise), noise, None);
        random("quantisation", width(quantisation), quantisation, None);
        random("levels of light and shadow", width(u.levels_px), u.levels_px, None);
        random("form, texture and sampling", width(u_form_px), u_form_px, Some(form_freedom));
        // All columns share the frame's blur; a stream estimates it from every frame anew.
        let blur = texts.of(format_args!("{:.5} px of blur", u.sigma_px));
        random("blur", blur, u.blur_px, None);
        // The same light falls on every frame: it does not average.
        let misfit = texts.of(format_args!("{:.5} px beyond the masters'", u.misfit_px));
        for (source, input, u_px) in [
            ("misfit of the edge model", misfit, u.misfit_px),
            ("light beyond the end of the grey scale", width(u.clipped_px), u.clipped_px),
            ("quantisation that repeats", width(u.rounding_px), u.rounding_px),
        ] {
            budget.push(Contribution {
                source: texts.of(format_args!("{source}")),
                input,
                shape: Shape::Normal,
                share: Share::Common,
                freedom: None,
                u_mm: mm_per_px * u_px,
            });
        }
    }
}

/// Share of quantisation, 1/12 count², in the noise variance at mid-edge.
pub(super) fn quantisation_share(edges: &FrameEdges) -> f64 {
    let [dark, light] = edges.figures.noise;
    let mid = 0.5 * (dark * dark + light * light);
    if edges.figures.quantised && mid > 0.0 { (1.0 / 12.0 / mid).min(1.0) } else { 0.0 }
}

/// Whether a source of the calibration is known by limits alone.
pub(crate) fn is_rectangular(source: &str) -> bool {
    ["temperature", "expansion", "distortion", "telecentricity"].iter().any(|word| source.starts_with(word))
}

/// The row of one source of the calibration, by the diameter's derivatives.
pub(crate) fn common(part: &CovariancePart, by: &[f64; 6], texts: Texts) -> Contribution {
    let rectangular = is_rectangular(&part.source);
    Contribution {
        source: texts.of(format_args!("{}", part.source)),
        input: texts.of(format_args!("calibration")),
        shape: if rectangular { Shape::Rectangular } else { Shape::Normal },
        share: Share::Common,
        freedom: None,
        u_mm: part.variance(by).sqrt(),
    }
}

/// Without an optical setup only scale and offset are known, with their covariance.
fn add_scale_and_offset(budget: &mut Budget, calibration: &Calibration, width_px: f64, texts: Texts) {
    let row = |source: Arguments<'_>, input: Arguments<'_>, u_mm: f64| Contribution {
        source: texts.of(source),
        input: texts.of(input),
        shape: Shape::Normal,
        share: Share::Common,
        freedom: None,
        u_mm,
    };
    let together = calibration.u_common_mm(width_px);
    if let [a, b] = &calibration.masters[..] {
        // Two masters: the line runs through both, so each one's share is its lever.
        let (one, two) = (a.width_px, b.width_px);
        for (master, lever) in [(a, (width_px - two) / (one - two)), (b, (width_px - one) / (two - one))] {
            let (d_mm, u) = (master.certificate.diameter_mm, master.certificate.u_mm());
            budget.push(row(
                format_args!("certificate of the master of {d_mm} mm"),
                format_args!("U/k = {:.3} um", 1e3 * u),
                lever.abs() * u,
            ));
            let u = calibration.scale_mm_per_px * master.u_width_px;
            budget.push(row(
                format_args!("edges of the master of {d_mm} mm"),
                format_args!("{:.5} px", master.u_width_px),
                lever.abs() * u,
            ));
        }
        return;
    }
    budget.push(row(format_args!("scale and edge offset"), format_args!("calibration"), together));
}

/// The rows of the conditions of use; `at_t` is the diameter at the part's temperature, mm.
pub(crate) fn add_conditions(
    budget: &mut Budget,
    calibration: &Calibration,
    conditions: &Conditions,
    at_t: f64,
    texts: Texts,
) {
    for Row { source, input, factor, u_mm } in budget_conditions::rows(calibration, conditions, at_t, texts) {
        let source = texts.of(format_args!("{source}"));
        let shape = factor.map_or(Shape::Rectangular, |known| Shape::Product { known });
        budget.push(Contribution { source, input, shape, share: Share::Common, freedom: None, u_mm });
    }
    if let Some(Row { source, input, u_mm, .. }) =
        budget_conditions::machine_row(calibration, conditions, at_t, texts)
    {
        let source = texts.of(format_args!("{source}"));
        let (shape, share) = (Shape::Normal, Share::Common);
        budget.push(Contribution { source, input, shape, share, freedom: None, u_mm });
    }
    let (t_per_mm, _) = budget_conditions::telecentricity(calibration);
    for row in conditions.limb_rows(at_t, t_per_mm).iter().flatten() {
        budget.push(Contribution {
            source: texts.of(format_args!("{}", row.source)),
            input: texts.of(format_args!("{:.3} ± {:.3} um an edge", row.shift_um, row.limit_um)),
            shape: Shape::Rectangular,
            share: Share::Common,
            freedom: None,
            u_mm: row.u_mm(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauge::calibration::{MasterCertificate, MasterFigure};

    fn row(u_mm: f64, share: Share, freedom: Option<f64>) -> Contribution {
        Contribution { source: "x".into(), input: String::new(), shape: Shape::Normal, share, freedom, u_mm }
    }

    /// GUM H.1.6: the end-gauge comparison has u_c = 32 nm, 16 effective degrees of freedom, t₉₉ =
    /// 2.92.
    #[test]
    fn effective_freedom_is_that_of_the_end_gauge_example() {
        let mut budget = Budget { diameter_mm: 50.0, contributions: Vec::new() };
        for (u, freedom) in [(25.0, 18.0), (9.7, 25.6), (2.9, 50.0), (16.6, 2.0)] {
            budget.push(row(u * 1e-6, Share::Common, Some(freedom)));
        }
        assert!((budget.u_mm() * 1e6 - 31.7).abs() < 0.5, "{}", budget.u_mm());
        assert_eq!(budget.effective_freedom().floor(), 16.0);
        assert!((budget.coverage_factor(0.99) - 2.92).abs() < 0.02, "{}", budget.coverage_factor(0.99));
    }

    /// A row that is NaN makes the sum NaN: left out, the diameter would seem certain.
    #[test]
    fn what_is_no_number_does_not_vanish() {
        let mut budget = Budget { diameter_mm: 50.0, contributions: Vec::new() };
        budget.push(row(1e-4, Share::Random, None));
        budget.push(row(0.0, Share::Random, None));
        budget.push(row(f64::NAN, Share::Common, None));
        assert!(budget.contributions.len() == 2 && budget.u_mm().is_nan() && budget.u_common_mm().is_nan());
        assert!(budget.to_table(Some(2.0)).contains("NaN"));
    }

    #[test]
    fn two_masters_shares_are_the_covariance_of_scale_and_offset() {
        let master = |diameter_mm, width_px| MasterFigure {
            certificate: MasterCertificate { diameter_mm, expanded_u_mm: 2e-4, coverage_factor: 2.0 },
            width_px,
            u_width_px: 0.003,
        };
        let calibration = Calibration::fit_figures(&[master(20.0, 1300.0), master(28.0, 1820.0)]).unwrap();
        let reading = WidthReading {
            figures: FrameFigures::default(),
            column_px: 0.0,
            column_variance_px2: 0.0,
            rows_px: (10.0, 1410.0),
            chord: 1.0,
            u: EdgesUncertainty { noise_px: 0.01, quantisation_share: 0.25, ..EdgesUncertainty::default() },
            form: Scatter::Known { u_px: 0.0, freedom: 1.0 },
        };
        let budget = reading.budget(&calibration, &Conditions::default());
        assert!((budget.u_common_mm() / calibration.u_common_mm(1400.0) - 1.0).abs() < 1e-6);
        assert!((budget.u_random_mm() - 0.01 * calibration.scale_mm_per_px).abs() < 1e-12);
        assert!(budget.to_table(Some(2.0)).contains("quantisation"));
        assert!(!budget.to_table(Some(2.0)).contains("misfit"));
        let u = EdgesUncertainty { misfit_px: 0.02, ..reading.u };
        let misfitting = WidthReading { u, ..reading }.budget(&calibration, &Conditions::default());
        let misfit_mm = 0.02 * calibration.scale_mm_per_px;
        assert!((misfitting.u_common_mm() / budget.u_common_mm().hypot(misfit_mm) - 1.0).abs() < 1e-9);
        assert!(misfitting.to_table(Some(2.0)).contains("misfit of the edge model"));
        assert!(budget.coverage_factor(0.95) > 1.9599 && budget.coverage_factor(0.95) < 1.9601);
    }
}
