//! Photon transfer: the sensor's gain, noise, non-uniformity and linearity from pairs of frames
//! (EMVA 1288, release 4.0).
//!
//! Two frames a, b of the same exposure separate the temporal from the fixed part:
//!
//! ```text
//! temporal variance   σ² = ½·mean (a − b)² − ½·(μ_a − μ_b)²
//! fixed pattern       s² = mean (a − μ_a)(b − μ_b)           (covariance: noise is independent)
//! gain                K  = slope of σ² − σ²_dark over μ − μ_dark, up to 70 % of saturation
//! read noise          σ_d = √(σ²_dark − 1/12)/K              electrons, without quantisation
//! DSNU = s_dark/K     PRNU = √(s² − s²_dark)/(μ − μ_dark)
//!                     at the exposure next to half of saturation
//! ```
//!
//! Unlike the standard's common high-pass filter, slow non-uniformity (the light's own) is taken
//! off as a quadratic surface fitted to the mean image before s² is formed; σ² needs no such
//! correction. Frames of 8 to 16 bit or f32; quantisation counts as 1/12 count² for integer
//! formats, which holds for σ ≥ .5 count.

use thiserror::Error;

use crate::frame::{FrameView, Pixels};
use crate::gauge::limit::limits;

limits! {
    /// Which exposures differ.
    PhotonTransferLimits = "photon_transfer";
    /// Relative difference of exposures up to which they are one: what a lamp drifts by.
    same_exposure: f64 = 0.02;
}

/// Two frames of the same scene and exposure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FramePair<'a> {
    /// Exposure in any unit proportional to the photons: time at constant light, or photons per
    /// pixel.
    pub exposure: f64,
    /// First frame.
    pub first: FrameView<'a>,
    /// Second frame.
    pub second: FrameView<'a>,
}

/// Result of photon transfer.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PhotonTransfer {
    /// System gain K, counts per electron.
    pub gain_counts_per_electron: f64,
    /// Its relative standard uncertainty from the number of pixels.
    pub u_gain_relative: f64,
    /// Mean dark level, counts.
    pub black_counts: f64,
    /// Temporal noise in the dark σ_y.dark, counts, quantisation included.
    pub dark_noise_counts: f64,
    /// Read (dark temporal) noise σ_d, electrons, quantisation taken off; 0 if quantisation hides
    /// it.
    pub read_noise_electrons: f64,
    /// Dark signal non-uniformity DSNU, electrons.
    pub dsnu_electrons: f64,
    /// Photo-response non-uniformity PRNU, relative.
    pub prnu: f64,
    /// Linearity error LE: mean relative deviation from the line, 5-95 % of the range used.
    pub linearity_error: f64,
    /// Counts per unit of exposure.
    pub responsivity: f64,
    /// Saturation capacity as far as the frames reach, electrons: the largest mean whose noise
    /// still grows.
    pub saturation_electrons: f64,
    /// The points of the transfer curve, ascending.
    pub curve: Vec<TransferPoint>,
}

/// One exposure.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TransferPoint {
    /// Exposure as given.
    pub exposure: f64,
    /// Mean signal above dark, counts.
    pub signal_counts: f64,
    /// Temporal variance above dark, counts².
    pub variance_counts2: f64,
    /// Spatial variance of the fixed pattern, counts².
    pub pattern_counts2: f64,
    /// Share of pixels at either end of the scale.
    pub clipped: f64,
    /// Whether the point took part in the gain.
    pub used: bool,
}

/// Why there is no photon transfer.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub(crate) enum PhotonTransferError {
    /// Too few exposures.
    #[error(
        "{usable} of {given} flat pairs are usable (unclipped, brighter than dark, below 70 % of saturation); at least 3 exposures are needed"
    )]
    TooFewExposures {
        /// Pairs given.
        given: usize,
        /// Pairs usable.
        usable: usize,
    },
    /// Exposures that are one and the same, or nearly: no line goes through them.
    #[error(
        "{different} different exposures among the {given} flat pairs {place}; at least 3 are needed that differ by 2 % of the brightest of them"
    )]
    SameExposures {
        /// Pairs there.
        given: usize,
        /// How many of them differ.
        different: usize,
        /// Which part of the range they lie in.
        place: &'static str,
    },
    /// No dark pair.
    #[error("no dark pair given: read noise and black level need one")]
    NoDark,
    /// The dark noise is cut off at the bottom of the scale.
    #[error(
        "{share:.4} of the dark pixels stand at the bottom of the scale, which cuts their noise off: raise the black level"
    )]
    DarkClipped {
        /// Their share.
        share: f64,
    },
    /// Frames of different sizes or formats.
    #[error("pair {index}: {what}")]
    Mismatch {
        /// Its index, dark pairs first.
        index: usize,
        /// What differs.
        what: String,
    },
    /// The variance does not grow with the signal.
    #[error(
        "the temporal variance does not grow with the signal (slope {slope}): not a photon transfer series"
    )]
    NoGain {
        /// The slope found.
        slope: f64,
    },
}

/// First- and second-order statistics of a pair.
#[derive(Clone, Copy, Debug)]
struct PairStatistics {
    mean: f64,
    temporal: f64,
    pattern: f64,
    clipped: f64,
    pixels: f64,
}

/// Photon transfer from pairs of flat frames at three or more exposures and one or more dark pairs.
///
/// # Errors
/// Frames that do not match, too few usable or different exposures, no dark pair, no gain.
pub(crate) fn photon_transfer(
    flats: &[FramePair<'_>],
    darks: &[FramePair<'_>],
) -> Result<PhotonTransfer, PhotonTransferError> {
    check(flats, darks)?;
    let dark = mean_of(&darks.iter().map(statistics).collect::<Vec<_>>());
    // At 3 standard deviations above zero .13 % are cut off and the variance is still right to 1 %.
    if dark.clipped > 2e-3 {
        return Err(PhotonTransferError::DarkClipped { share: dark.clipped });
    }
    let mut pairs: Vec<(f64, PairStatistics)> = flats.iter().map(|p| (p.exposure, statistics(p))).collect();
    pairs.sort_by(|a, b| a.1.mean.total_cmp(&b.1.mean));
    let saturation = saturation_signal(&pairs, &dark);
    let curve: Vec<TransferPoint> =
        pairs.iter().map(|(e, s)| transfer_point(*e, s, &dark, saturation)).collect();
    let usable = curve.iter().filter(|p| p.used).count();
    if usable < 3 {
        return Err(PhotonTransferError::TooFewExposures { given: flats.len(), usable });
    }
    let used: Vec<f64> = curve.iter().filter(|p| p.used).map(|p| p.exposure).collect();
    check_different(&used, "below 70 % of saturation")?;
    let (gain, u_gain) = gain(&curve, &dark, darks.len() as f64);
    if gain.is_nan() || gain <= 0.0 {
        return Err(PhotonTransferError::NoGain { slope: gain });
    }
    let quantisation = match darks[0].first.pixels() {
        Pixels::F32(_) => 0.0,
        _ => 1.0 / 12.0,
    };
    let (responsivity, linearity_error) = linearity(&curve, saturation)?;
    Ok(PhotonTransfer {
        gain_counts_per_electron: gain,
        u_gain_relative: u_gain / gain,
        black_counts: dark.mean,
        dark_noise_counts: dark.temporal.max(0.0).sqrt(),
        read_noise_electrons: (dark.temporal - quantisation).max(0.0).sqrt() / gain,
        dsnu_electrons: dark.pattern.max(0.0).sqrt() / gain,
        prnu: prnu(&curve, &dark, saturation),
        linearity_error,
        responsivity,
        saturation_electrons: saturation / gain,
        curve,
    })
}

fn check(flats: &[FramePair<'_>], darks: &[FramePair<'_>]) -> Result<(), PhotonTransferError> {
    let first = darks.first().ok_or(PhotonTransferError::NoDark)?.first;
    for (index, pair) in darks.iter().chain(flats).enumerate() {
        for frame in [pair.first, pair.second] {
            if (frame.rows(), frame.columns(), frame.format())
                != (first.rows(), first.columns(), first.format())
            {
                let what = format!(
                    "{} x {} {:?} beside {} x {} {:?}",
                    frame.rows(),
                    frame.columns(),
                    frame.format(),
                    first.rows(),
                    first.columns(),
                    first.format()
                );
                return Err(PhotonTransferError::Mismatch { index, what });
            }
        }
        if !pair.exposure.is_finite() || pair.exposure < 0.0 {
            let what = format!("exposure {} is not a number of 0 or more", pair.exposure);
            return Err(PhotonTransferError::Mismatch { index, what });
        }
    }
    let pixels = first.rows() * first.columns();
    if pixels < 1024 {
        let what = format!("{pixels} pixels; a variance good to 5 % needs 1024");
        return Err(PhotonTransferError::Mismatch { index: 0, what });
    }
    Ok(())
}

fn mean_of(all: &[PairStatistics]) -> PairStatistics {
    let n = all.len().max(1) as f64;
    let mean = |f: fn(&PairStatistics) -> f64| all.iter().map(f).sum::<f64>() / n;
    PairStatistics {
        mean: mean(|s| s.mean),
        temporal: mean(|s| s.temporal),
        pattern: mean(|s| s.pattern),
        clipped: mean(|s| s.clipped),
        pixels: mean(|s| s.pixels),
    }
}

/// Statistics of a pair; sums over rows first, so that rounding does not grow with the frame.
fn statistics(pair: &FramePair<'_>) -> PairStatistics {
    let (rows, columns) = (pair.first.rows(), pair.first.columns());
    let n = (rows * columns) as f64;
    let full = pair.first.full_scale();
    let value = |view: &FrameView<'_>, r: usize, c: usize| f64::from(view.get(r, c).unwrap_or(0.0));
    let (mut sum_a, mut sum_b, mut clipped) = (0.0, 0.0, 0.0);
    for r in 0..rows {
        let (mut row_a, mut row_b) = (0.0, 0.0);
        for c in 0..columns {
            let (a, b) = (value(&pair.first, r, c), value(&pair.second, r, c));
            row_a += a;
            row_b += b;
            let at_end = |v: f64| full.is_some_and(|f| v >= f64::from(f)) || (full.is_some() && v <= 0.0);
            clipped += f64::from(u8::from(at_end(a)) + u8::from(at_end(b)));
        }
        sum_a += row_a;
        sum_b += row_b;
    }
    let (mean_a, mean_b) = (sum_a / n, sum_b / n);
    let surface = Surface::fit(rows, columns, |r, c| {
        0.5 * (value(&pair.first, r, c) + value(&pair.second, r, c)) - 0.5 * (mean_a + mean_b)
    });
    let (mut difference, mut product) = (0.0, 0.0);
    for r in 0..rows {
        let (mut row_d, mut row_p) = (0.0, 0.0);
        for c in 0..columns {
            let (a, b) = (value(&pair.first, r, c) - mean_a, value(&pair.second, r, c) - mean_b);
            let slow = surface.at(r, c);
            row_d += (a - b) * (a - b);
            row_p += (a - slow) * (b - slow);
        }
        difference += row_d;
        product += row_p;
    }
    PairStatistics {
        mean: 0.5 * (mean_a + mean_b),
        temporal: 0.5 * difference / (n - 1.0),
        pattern: product / (n - 6.0),
        clipped: clipped / (2.0 * n),
        pixels: n,
    }
}

/// A quadratic surface in orthogonal (discrete Legendre) polynomials of row and column.
struct Surface {
    coefficients: [f64; 6],
    rows: [f64; 2],
    columns: [f64; 2],
}

impl Surface {
    /// Mean square of the centred index, and its half length: P1 = x, P2 = x² − mean x².
    fn axis(n: usize) -> [f64; 2] {
        let n = n as f64;
        [(n - 1.0) / 2.0, (n * n - 1.0) / 12.0]
    }

    fn terms(&self, r: usize, c: usize) -> [f64; 6] {
        let (y, x) = (r as f64 - self.rows[0], c as f64 - self.columns[0]);
        [1.0, y, x, x * y, y * y - self.rows[1], x * x - self.columns[1]]
    }

    fn fit(rows: usize, columns: usize, value: impl Fn(usize, usize) -> f64) -> Self {
        let mut surface =
            Self { coefficients: [0.0; 6], rows: Self::axis(rows), columns: Self::axis(columns) };
        let (mut dot, mut norm) = ([0.0; 6], [0.0; 6]);
        for r in 0..rows {
            let mut row = [0.0; 6];
            for c in 0..columns {
                let v = value(r, c);
                for (k, t) in surface.terms(r, c).iter().enumerate() {
                    row[k] += t * v;
                    norm[k] += t * t;
                }
            }
            for k in 0..6 {
                dot[k] += row[k];
            }
        }
        for k in 0..6 {
            surface.coefficients[k] = if norm[k] > 0.0 { dot[k] / norm[k] } else { 0.0 };
        }
        surface
    }

    fn at(&self, r: usize, c: usize) -> f64 {
        self.terms(r, c).iter().zip(&self.coefficients).map(|(t, c)| t * c).sum()
    }
}

/// Signal at which the temporal variance is largest (EMVA 1288: saturation), in counts above dark.
fn saturation_signal(pairs: &[(f64, PairStatistics)], dark: &PairStatistics) -> f64 {
    pairs.iter().max_by(|a, b| a.1.temporal.total_cmp(&b.1.temporal)).map_or(0.0, |(_, s)| s.mean - dark.mean)
}

fn transfer_point(
    exposure: f64,
    s: &PairStatistics,
    dark: &PairStatistics,
    saturation: f64,
) -> TransferPoint {
    let signal_counts = s.mean - dark.mean;
    // Clipping in the dark frames is tested apart; light that clips is of no use for the gain.
    let used =
        signal_counts > 0.0 && signal_counts <= 0.7 * saturation.max(0.0) && s.clipped <= 1e-4 + dark.clipped;
    TransferPoint {
        exposure,
        signal_counts,
        variance_counts2: s.temporal - dark.temporal,
        pattern_counts2: s.pattern,
        clipped: s.clipped,
        used,
    }
}

/// Slope of variance over signal through the dark point, weighted by 1/(variance of a variance) =
/// n/2σ⁴, with its uncertainty.
fn gain(curve: &[TransferPoint], dark: &PairStatistics, dark_pairs: f64) -> (f64, f64) {
    let (mut xy, mut xx) = (0.0, 0.0);
    let scatter = |p: &TransferPoint| {
        let here = (p.variance_counts2 + dark.temporal).max(1e-12);
        2.0 * (here * here + dark.temporal.powi(2) / dark_pairs) / dark.pixels
    };
    for p in curve.iter().filter(|p| p.used) {
        xy += p.signal_counts * p.variance_counts2 / scatter(p);
        xx += p.signal_counts * p.signal_counts / scatter(p);
    }
    (xy / xx, xx.sqrt().recip())
}

/// PRNU at the usable exposure next to half of saturation.
fn prnu(curve: &[TransferPoint], dark: &PairStatistics, saturation: f64) -> f64 {
    let nearest = curve.iter().filter(|p| p.used).min_by(|a, b| {
        let off = |p: &TransferPoint| (p.signal_counts - 0.5 * saturation).abs();
        off(a).total_cmp(&off(b))
    });
    nearest.map_or(0.0, |p| (p.pattern_counts2 - dark.pattern).max(0.0).sqrt() / p.signal_counts)
}

/// Line through the signal over exposure with an offset, least squares of relative deviations over
/// 5-95 % of saturation; gives slope and mean relative deviation.
fn linearity(curve: &[TransferPoint], saturation: f64) -> Result<(f64, f64), PhotonTransferError> {
    let points: Vec<(f64, f64)> = curve
        .iter()
        .filter(|p| (0.05 * saturation..=0.95 * saturation).contains(&p.signal_counts) && p.clipped <= 1e-4)
        .map(|p| (p.exposure, p.signal_counts))
        .collect();
    let exposures: Vec<f64> = points.iter().map(|p| p.0).collect();
    check_different(&exposures, "between 5 and 95 % of saturation")?;
    let weight: f64 = points.iter().map(|(_, y)| y.powi(-2)).sum();
    let mean =
        |f: &dyn Fn(f64, f64) -> f64| points.iter().map(|(x, y)| f(*x, *y) / (y * y)).sum::<f64>() / weight;
    let (mx, my) = (mean(&|x, _| x), mean(&|_, y| y));
    let slope = mean(&|x, y| (x - mx) * (y - my)) / mean(&|x, _| (x - mx).powi(2));
    let deviation = |(x, y): &(f64, f64)| ((y - my - slope * (x - mx)) / y).abs();
    Ok((slope, points.iter().map(deviation).sum::<f64>() / points.len().max(1) as f64))
}

/// Refuses fewer than three exposures that differ: a line through what is one point has the slope
/// of its rounding.
fn check_different(exposures: &[f64], place: &'static str) -> Result<(), PhotonTransferError> {
    let mut sorted = exposures.to_vec();
    sorted.sort_by(f64::total_cmp);
    let least = PhotonTransferLimits::get().same_exposure * sorted.last().copied().unwrap_or(0.0);
    let mut last = f64::NEG_INFINITY;
    let different = sorted.iter().filter(|e| {
        let differs = **e > last + least;
        if differs {
            last = **e;
        }
        differs
    });
    let different = different.count();
    if different >= 3 {
        return Ok(());
    }
    Err(PhotonTransferError::SameExposures { given: exposures.len(), different, place })
}
