//! The inner loop of a side: from windows and levels to edges, four neighbouring columns at a time.
//!
//! Four columns with valid windows and levels are scored together, so that the computations of a
//! column (levels, noise, uncertainty) fill a vector register; any other column is scored by
//! itself. Both paths do the same operations in the same order, so that the edge of a column
//! depends neither on its neighbours nor on the machine's instruction set.

use wide::f32x4;

use super::levels::LevelCurve;
use super::noise::NoiseModel;
use super::scoring::{FourWindows, Place, locate, locate_core, locate_four, normalise};
use super::scoring_table::{CorePhase, Cores, Table};
use crate::gauge::edge::image::scan_windows::Windows;
use crate::gauge::edges::{Edge, EdgeState};
use crate::gauge::limit::limits;
use crate::profile::Reason;

limits! {
    /// What makes a column's shadow another than the part's.
    ColumnFitLimits = "column_fit";
    /// Level of a column's shadow above the part's own, as a share of the contrast, from which it
    /// is not that of the part but light dimmed by mist. Tuned: see study limits.
    lit_shadow: f32 = 0.25;
}

/// Columns scored together.
const FOUR: usize = 4;

/// Columns that share a table.
pub(crate) struct ColumnJob<'a> {
    pub(crate) windows: &'a Windows,
    pub(crate) dark: &'a LevelCurve,
    pub(crate) light: &'a LevelCurve,
    pub(crate) noise: &'a NoiseModel,
    pub(crate) table: &'a Table,
    /// Blur of the columns less the table's, px.
    pub(crate) blur_shift: f32,
    pub(crate) min_snr: f32,
    pub(crate) reject: bool,
    /// Level of the part's own shadow and contrast of the frame, counts; minus infinity where they
    /// are not known.
    pub(crate) shadow: f32,
    pub(crate) contrast: f32,
}

/// Scores columns and appends their edges to `line`.
pub(crate) fn score_columns(
    job: &ColumnJob<'_>,
    columns: std::ops::Range<usize>,
    normalised: &mut [f32],
    line: &mut Vec<Edge>,
) {
    match job.table.cores() {
        Cores::Two(phases) => score_run(job, phases, columns, normalised, line),
        Cores::Three(phases) => score_run(job, phases, columns, normalised, line),
        Cores::Whole => {
            let lit_shadow = ColumnFitLimits::get().lit_shadow;
            line.extend(columns.map(|c| fit_column::<1>(job, &[], c, normalised, lit_shadow)));
        }
    }
}

fn score_run<const C: usize>(
    job: &ColumnJob<'_>,
    phases: &[CorePhase<C>],
    columns: std::ops::Range<usize>,
    normalised: &mut [f32],
    line: &mut Vec<Edge>,
) {
    let lit_shadow = ColumnFitLimits::get().lit_shadow;
    let mut first = columns.start;
    while first < columns.end {
        let count = FOUR.min(columns.end - first);
        let four = if count == FOUR { fit_four(job, phases, first, lit_shadow) } else { None };
        match four {
            Some(edges) => line.extend_from_slice(&edges),
            None => line
                .extend((first..first + count).map(|c| fit_column(job, phases, c, normalised, lit_shadow))),
        }
        first += count;
    }
}

/// Four columns from `first` on; `None` unless all of them are sound and settle at once.
#[inline(always)]
fn fit_four<const C: usize>(
    job: &ColumnJob<'_>,
    phases: &[CorePhase<C>],
    first: usize,
    lit_shadow: f32,
) -> Option<[Edge; FOUR]> {
    let four = |values: &[f32]| values.get(first..)?.first_chunk::<FOUR>().map(|v| f32x4::from(*v));
    let centre = job.windows.centre.get(first..)?.first_chunk::<FOUR>()?;
    let (dark, light) = (four(&job.dark.level)?, four(&job.light.level)?);
    let (own_dark, own_light) = (four(&job.windows.dark)?, four(&job.windows.light)?);
    let contrast = light - dark;
    let middle = (f32x4::splat(0.5) * (dark + light)).to_array();
    let mut variance = [0.0_f32; FOUR];
    for (variance, level) in variance.iter_mut().zip(middle) {
        *variance = job.noise.variance(f64::from(level)) as f32;
    }
    let variance = f32x4::from(variance);
    let mut sound = contrast.simd_ge(f32x4::splat(job.min_snr) * variance.sqrt());
    if job.reject {
        let own = own_light - own_dark;
        let most = f32x4::splat(lit_shadow) * contrast.fast_max(f32x4::splat(job.contrast));
        let dark_enough = (own_dark - f32x4::splat(job.shadow)).simd_le(most);
        let half = own.simd_gt(f32x4::splat(0.5) * contrast);
        sound = sound & dark_enough & half & own.simd_lt(f32x4::splat(2.0) * contrast);
    }
    if !sound.all() {
        return None;
    }
    let (skip, width) = (job.table.core().0, job.windows.width);
    let cores = job.windows.pixels.get(first * width..)?;
    let four_windows = FourWindows { pixels: cores, skip, width, dark, contrast };
    let found = locate_four(&four_windows, job.table, phases)?;
    let [a, b, c, d] = found.phases;
    let (a, b, c, d) = (&a.scalars, &b.scalars, &c.scalars, &d.scalars);
    // ∂x/∂light = Σ w E/contrast and ∂x/∂dark = (Σ w − Σ w E)/contrast.
    let offset = f32x4::from([a.offset, b.offset, c.offset, d.offset]);
    let sum = f32x4::from([a.weight_sum, b.weight_sum, c.weight_sum, d.weight_sum]);
    let unit = [a.unit_uncertainty, b.unit_uncertainty, c.unit_uncertainty, d.unit_uncertainty];
    let by_light = offset / contrast * four(&job.light.uncertainty)?;
    let by_dark = (sum - offset) / contrast * four(&job.dark.uncertainty)?;
    let shared = (by_light * by_light + by_dark * by_dark).sqrt().to_array();
    let relative = variance / (contrast * contrast);
    let own = (f32x4::from(unit) * relative.sqrt()).to_array();
    let freedom = f32x4::from([a.freedom, b.freedom, c.freedom, d.freedom]);
    let chi2 = (found.residual / (relative * freedom)).to_array();
    let lever = f32x4::from([a.lever, b.lever, c.lever, d.lever]);
    let x = found.x - lever * f32x4::splat(job.blur_shift);
    let (sign, x) = (f64::from(job.windows.side.sign()), x.to_array());
    let mut edges = [Edge::gap(Reason::NoEdge); FOUR];
    for (k, edge) in edges.iter_mut().enumerate() {
        *edge = Edge {
            row_px: f64::from(centre[k].ok()?) + sign * f64::from(x[k]),
            u_own_px: own[k],
            u_shared_px: shared[k],
            chi2: chi2[k],
            state: EdgeState::Good,
        };
    }
    Some(edges)
}

#[inline(always)]
fn fit_column<const C: usize>(
    job: &ColumnJob<'_>,
    phases: &[CorePhase<C>],
    column: usize,
    normalised: &mut [f32],
    lit_shadow: f32,
) -> Edge {
    let windows = job.windows;
    if let Err(reason) = windows.centre[column] {
        return Edge::gap(reason);
    }
    let (dark, light) = (job.dark.level[column], job.light.level[column]);
    let contrast = light - dark;
    let variance = job.noise.variance(f64::from(0.5 * (dark + light))) as f32;
    if !(contrast >= job.min_snr * variance.sqrt()) {
        return Edge::gap(Reason::LowContrast);
    }
    let own = windows.light[column] - windows.dark[column];
    let is_lit = windows.dark[column] - job.shadow > lit_shadow * contrast.max(job.contrast);
    if job.reject && (is_lit || !(own > 0.5 * contrast && own < 2.0 * contrast)) {
        return Edge::gap(Reason::Contaminated);
    }
    let window = windows.of(column);
    let found = locate_core(&window[job.table.core().0..], dark, contrast, job.table, phases);
    let Some(found) = found.or_else(|| locate_in_whole(job, window, dark, contrast, normalised)) else {
        return Edge::gap(Reason::Residual);
    };
    let relative = variance / (contrast * contrast);
    let scalars = job.table.scalars(found.index);
    let by_light = scalars.offset / contrast * job.light.uncertainty[column];
    let by_dark = (scalars.weight_sum - scalars.offset) / contrast * job.dark.uncertainty[column];
    Edge {
        row_px: windows.row(column, found.x - scalars.lever * job.blur_shift),
        u_own_px: scalars.unit_uncertainty * relative.sqrt(),
        u_shared_px: (by_light * by_light + by_dark * by_dark).sqrt(),
        chi2: found.residual / (relative * scalars.freedom),
        state: EdgeState::Good,
    }
}

/// An edge outside the middle of its window, located with all of its pixels.
#[cold]
fn locate_in_whole(
    job: &ColumnJob<'_>,
    window: &[f32],
    dark: f32,
    contrast: f32,
    normalised: &mut [f32],
) -> Option<Place> {
    let start = normalise(window, dark, contrast, normalised) - job.table.centroid;
    let found = locate(normalised, job.table, start)?;
    Some(Place { x: found.x, residual: found.residual, index: job.table.index(found.phase.scalars.phase) })
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal, Uniform};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::gauge::edge::estimation::scoring_table::Tabulation;
    use crate::gauge::edge::image::scan_windows::Side;
    use crate::gauge::edge::image::window_layout::{half, window_width};
    use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
    use crate::gauge::edge::model::gaussian::EdgeSample;
    use crate::gauge::settings::Noise;

    const COLUMNS: usize = 256;

    /// Windows of noisy edges anywhere between 0.7 px either side of their centres, dark 100 and
    /// light 1100 counts.
    fn scene(sigma: f64, noise: f64, seed: u64) -> Windows {
        let mut rng = Pcg64::seed_from_u64(seed);
        let (normal, place) = (Normal::new(0.0, noise).unwrap(), Uniform::new(-0.7, 0.7).unwrap());
        let shape = EdgeSpreadFunction::Gaussian;
        let mut windows = Windows::new(Side::Bottom);
        windows.prepare(&shape, sigma, window_width(&shape, sigma), COLUMNS);
        windows.centre = vec![Ok(500); COLUMNS];
        windows.dark = vec![100.0; COLUMNS];
        windows.light = vec![1100.0; COLUMNS];
        let width = windows.width;
        for window in windows.pixels.chunks_exact_mut(width) {
            let mut samples = vec![EdgeSample::default(); width];
            shape.samples(-(half(width) as f64), place.sample(&mut rng), sigma, &mut samples);
            for (pixel, sample) in window.iter_mut().zip(&samples) {
                *pixel = (100.0 + 1000.0 * sample.value + normal.sample(&mut rng)).round() as f32;
            }
        }
        windows
    }

    /// The same by definition: one pixel after the other, in f64.
    fn in_scalars(window: &[f32], table: &Table) -> f64 {
        let (first, length) = table.core();
        let grey = |k: usize| (f64::from(window[k]) - 100.0) / 1000.0;
        let area: f64 = (first..first + length).map(grey).sum();
        let mut x = (first + length) as f64 - half(table.width) as f64 - 0.5 - area;
        for count in 0..10 {
            let phase = table.phase(x as f32);
            let weighted: f64 = (first..first + length).map(|k| f64::from(phase.weights[k]) * grey(k)).sum();
            let step = weighted - f64::from(phase.scalars.offset);
            x = f64::from(phase.scalars.phase) + step;
            if count > 0 && step.abs() * f64::from(table.per_px) <= 0.75 {
                break;
            }
        }
        x
    }

    #[test]
    fn four_at_a_time_one_by_one_and_in_scalars_agree() {
        let level = |value: f32| LevelCurve {
            level: vec![value; COLUMNS],
            uncertainty: vec![0.5; COLUMNS],
            length: 100.0,
            mean: f64::from(value),
        };
        let (mut largest, mut compared) = (0.0_f64, 0);
        for (seed, (sigma, sd)) in
            [(0.6, 5.0), (1.0, 50.0), (1.0, 10.0), (1.6, 20.0), (2.2, 50.0)].into_iter().enumerate()
        {
            let windows = scene(sigma, sd, seed as u64);
            let of = Tabulation { sigma, kappa: 0.0, width: windows.width, free_levels: false, per_px: 64 };
            let table = Table::new(&EdgeSpreadFunction::Gaussian, of);
            let noise = Noise::PhotonTransfer {
                gain_counts_per_electron: 0.0,
                read_noise_counts: sd,
                black_counts: 0.0,
            };
            let noise = NoiseModel::given(noise, 1.0, 1e-3).unwrap();
            let (dark, light) = (level(100.0), level(1100.0));
            let job = ColumnJob {
                windows: &windows,
                dark: &dark,
                light: &light,
                noise: &noise,
                table: &table,
                blur_shift: 0.0,
                min_snr: 5.0,
                reject: true,
                shadow: 100.0,
                contrast: 1000.0,
            };
            let mut normalised = vec![0.0; windows.width];
            let (mut together, mut alone) = (Vec::new(), Vec::new());
            score_columns(&job, 0..COLUMNS, &mut normalised, &mut together);
            // Runs of three never fill a vector.
            for first in (0..COLUMNS).step_by(3) {
                score_columns(&job, first..(first + 3).min(COLUMNS), &mut normalised, &mut alone);
            }
            assert_eq!(together, alone);
            for (column, edge) in together.iter().enumerate().filter(|(_, e)| e.is_usable()) {
                let x = in_scalars(windows.of(column), &table);
                // An edge that rounding moves to the next phase is no test of the arithmetic.
                let departure = (edge.row_px - 500.0 - x).abs();
                if departure < 2e-5 {
                    largest = largest.max(departure);
                    compared += 1;
                }
            }
        }
        assert!(compared >= 5 * COLUMNS - 20, "{compared}");
        assert!(largest < 1e-6, "{largest}");
    }
}
