//! The table: an edge-spread function over the signed distance into the light.
//!
//! Between equidistant knots F is the cubic that takes F and dF/dd from both ends; it errs by at
//! most h⁴/384·max|F''''|. Beyond the ends F is 0 and 1. With F1 = ∫F and F2 = ∬F, which are exact
//! for a piecewise cubic, the light on a square pixel of side p over a straight edge of slope tan β
//! is
//!
//! ```text
//! I(d) = [F2(d+a+b) - F2(d+a-b) - F2(d-a+b) + F2(d-a-b)] / 4ab,   a = p|cos β|/2,   b = p|sin β|/2
//! ```
//!
//! with d the perpendicular distance of its centre, since the pixel's projection on the normal is
//! the convolution of two boxes.

use rayon::prelude::*;

use super::shifts::Shifts;
use crate::render::error::RenderError;

/// Most knots of a table; 64 MB with its integrals.
const MOST_KNOTS: usize = 1 << 21;

/// Fewest intervals a table starts from before it is refined.
const FIRST_INTERVALS: usize = 256;

/// Share of the reach, at either end, over which a table fades to 0 and 1.
const FADE: f64 = 0.2;

/// Half width, in steps of the table, below which a box is replaced by a point, with the error
/// b²F''/6.
const NARROW_STEPS: f64 = 1e-3;

/// The function at one distance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Knot {
    /// F.
    value: f64,
    /// dF/dd, 1/µm.
    slope: f64,
    /// ∫F, µm.
    first: f64,
    /// ∬F, µm².
    second: f64,
}

/// An edge-spread function F(d): 0 in the shadow, 1 in the light.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct EdgeSpread {
    low_um: f64,
    step_um: f64,
    knots: Vec<Knot>,
    interpolation_error: f64,
    truncation: f64,
}

impl EdgeSpread {
    /// Tabulates a function that returns F and dF/dd (1/µm) over `low_um..=high_um`.
    ///
    /// The step is halved until the cubic differs from the function by at most `tolerance` in the
    /// middle of every interval. Over the outer fifth at either end the difference to 0 or 1 fades
    /// out, so that a family with long tails joins the flat field without a step; the largest
    /// difference is [`Self::truncation`].
    ///
    /// # Errors
    /// Refuses an empty range and a function that needs more than two million knots.
    pub(crate) fn tabulate(
        low_um: f64,
        high_um: f64,
        tolerance: f64,
        f: impl Fn(f64) -> (f64, f64) + Sync,
    ) -> Result<Self, RenderError> {
        if !(low_um < 0.0 && high_um > 0.0 && low_um.is_finite() && high_um.is_finite()) {
            let found = format!("{low_um} to {high_um} µm");
            return Err(RenderError::setting(
                "optics.esf",
                &found,
                "a table's range must hold the edge at 0",
            ));
        }
        let faded = |d: f64| fade(d, low_um, high_um, f(d));
        let mut intervals = FIRST_INTERVALS;
        let mut knots = sample(low_um, high_um, intervals, &faded);
        loop {
            let step = (high_um - low_um) / intervals as f64;
            let mut middles = sample(low_um + 0.5 * step, high_um - 0.5 * step, intervals - 1, &faded);
            let error = largest_error(&knots, &middles, step);
            if error <= tolerance {
                let truncation = [1.0 - f(high_um * (1.0 - FADE)).0, f(low_um * (1.0 - FADE)).0]
                    .iter()
                    .fold(0.0, |most: f64, t| most.max(t.abs()));
                return Ok(Self::from_knots(low_um, step, &knots, error, truncation));
            }
            intervals *= 2;
            if intervals > MOST_KNOTS {
                let found = format!("{low_um} to {high_um} µm");
                return Err(RenderError::setting(
                    "optics.esf",
                    &found,
                    format!("a table of {MOST_KNOTS} knots still errs by {error:.1e}: shorten its reach"),
                ));
            }
            middles.push((0.0, 0.0));
            knots = knots.into_iter().zip(middles).flat_map(|(k, m)| [k, m]).collect();
            knots.pop();
        }
    }

    /// A table from knots (F, dF/dd) at `low_um + i·step_um`.
    pub(super) fn from_knots(
        low_um: f64,
        step_um: f64,
        knots: &[(f64, f64)],
        interpolation_error: f64,
        truncation: f64,
    ) -> Self {
        let bare = knots.iter().map(|&(value, slope)| Knot { value, slope, ..Knot::default() });
        let mut with_integrals: Vec<Knot> = bare.collect();
        for i in 1..knots.len() {
            let c = hermite(knots[i - 1], knots[i], step_um);
            let Knot { first, second, .. } = with_integrals[i - 1];
            let inner = c[0] / 2.0 + c[1] / 6.0 + c[2] / 12.0 + c[3] / 20.0;
            with_integrals[i].first = first + step_um * (c[0] + c[1] / 2.0 + c[2] / 3.0 + c[3] / 4.0);
            with_integrals[i].second = second + step_um * (first + step_um * inner);
        }
        Self { low_um, step_um, knots: with_integrals, interpolation_error, truncation }
    }

    /// First and last distance of the table, µm; F is 0 before and 1 after.
    pub(crate) fn range_um(&self) -> (f64, f64) {
        (self.low_um, self.low_um + self.step_um * self.segments() as f64)
    }

    /// Distance of the knots, µm.
    pub(crate) fn step_um(&self) -> f64 {
        self.step_um
    }

    /// Largest difference between the table and its function, as a share of full intensity.
    #[cfg(test)]
    pub(crate) fn interpolation_error(&self) -> f64 {
        self.interpolation_error
    }

    /// Largest difference to 0 or 1 that was faded out at the ends, as a share of full intensity.
    #[cfg(test)]
    pub(crate) fn truncation(&self) -> f64 {
        self.truncation
    }

    /// F at a distance of `d_um` into the light.
    pub(crate) fn value(&self, d_um: f64) -> f64 {
        match self.place(d_um) {
            Place::Shadow => 0.0,
            Place::Light => 1.0,
            Place::Segment(i, t) => {
                let c = self.segment(i);
                c[0] + t * (c[1] + t * (c[2] + t * c[3]))
            }
        }
    }

    /// dF/dd, the line-spread function, 1/µm.
    pub(crate) fn slope(&self, d_um: f64) -> f64 {
        match self.place(d_um) {
            Place::Shadow | Place::Light => 0.0,
            Place::Segment(i, t) => {
                let c = self.segment(i);
                (c[1] + t * (2.0 * c[2] + t * 3.0 * c[3])) / self.step_um
            }
        }
    }

    /// ∫F from the shadow to `d_um`, µm.
    pub(crate) fn integral(&self, d_um: f64) -> f64 {
        match self.place(d_um) {
            Place::Shadow => 0.0,
            Place::Light => self.knots[self.segments()].first + d_um - self.range_um().1,
            Place::Segment(i, t) => {
                let c = self.segment(i);
                let part = t * (c[0] + t * (c[1] / 2.0 + t * (c[2] / 3.0 + t * c[3] / 4.0)));
                self.knots[i].first + self.step_um * part
            }
        }
    }

    /// ∬F from the shadow to `d_um`, µm².
    pub(crate) fn second_integral(&self, d_um: f64) -> f64 {
        match self.place(d_um) {
            Place::Shadow => 0.0,
            Place::Light => {
                let beyond = d_um - self.range_um().1;
                let last = self.knots[self.segments()];
                last.second + beyond * (last.first + 0.5 * beyond)
            }
            Place::Segment(i, t) => {
                let c = self.segment(i);
                let part = t * t * (c[0] / 2.0 + t * (c[1] / 6.0 + t * (c[2] / 12.0 + t * c[3] / 20.0)));
                self.knots[i].second + self.step_um * (self.knots[i].first * t + self.step_um * part)
            }
        }
    }

    /// Light on a square pixel of side `pixel_um` whose centre lies `d_um` into the light, measured
    /// across an edge that makes the angle `slope_rad` with the pixel's rows. Exact for the table.
    pub(crate) fn over_pixel(&self, d_um: f64, pixel_um: f64, slope_rad: f64) -> f64 {
        let (sin, cos) = slope_rad.sin_cos();
        let (x, y) = (0.5 * pixel_um * cos.abs(), 0.5 * pixel_um * sin.abs());
        let (wide, narrow) = if x > y { (x, y) } else { (y, x) };
        if wide < NARROW_STEPS * self.step_um {
            return self.value(d_um);
        }
        if narrow < NARROW_STEPS * self.step_um {
            return (self.integral(d_um + wide) - self.integral(d_um - wide)) / (2.0 * wide);
        }
        let outer = self.second_integral(d_um + wide + narrow) + self.second_integral(d_um - wide - narrow);
        let inner = self.second_integral(d_um + wide - narrow) + self.second_integral(d_um - wide + narrow);
        (outer - inner) / (4.0 * wide * narrow)
    }

    /// The table averaged over a box of full width `width_um`: a level edge convolved with the
    /// pixel's height.
    ///
    /// # Errors
    /// As [`Self::tabulate`].
    pub(crate) fn averaged(&self, width_um: f64, tolerance: f64) -> Result<Self, RenderError> {
        let half = 0.5 * width_um;
        let (low, high) = self.range_um();
        if half < NARROW_STEPS * self.step_um {
            return Ok(self.clone());
        }
        self.again(low - half, high + half, tolerance, |d| {
            let mean = (self.integral(d + half) - self.integral(d - half)) / width_um;
            (mean, (self.value(d + half) - self.value(d - half)) / width_um)
        })
    }

    /// The blend with another table of the same range, `share` of which is the other's.
    pub(super) fn blended(&self, other: &Self, share: f64) -> Self {
        let segments = self.segments().max(other.segments());
        let step_um = (self.range_um().1 - self.low_um) / segments as f64;
        let mean = |a: f64, b: f64| a + share * (b - a);
        let knot = |i: usize| {
            let d = self.low_um + i as f64 * step_um;
            // The last knot is full light, independent of its rounding.
            if i == segments {
                return (1.0, 0.0);
            }
            (mean(self.value(d), other.value(d)), mean(self.slope(d), other.slope(d)))
        };
        let knots: Vec<(f64, f64)> = (0..=segments).map(knot).collect();
        let error = self.interpolation_error.max(other.interpolation_error);
        Self::from_knots(self.low_um, step_um, &knots, error, self.truncation.max(other.truncation))
    }

    /// The weighted mean of the table over `shifts`: motion, reflections, an extended source.
    ///
    /// # Errors
    /// As [`Self::tabulate`].
    pub(crate) fn spread(&self, shifts: &Shifts, tolerance: f64) -> Result<Self, RenderError> {
        let (low, high) = self.range_um();
        let (nearest, farthest) = shifts.range_um();
        self.again(low + nearest.min(0.0), high + farthest.max(0.0), tolerance, |d| {
            shifts.iter().fold((0.0, 0.0), |(value, slope), (s, w)| {
                (value + w * self.value(d - s), slope + w * self.slope(d - s))
            })
        })
    }

    /// Tabulates a function derived from this table, which already ends in 0 and 1.
    fn again(
        &self,
        low_um: f64,
        high_um: f64,
        tolerance: f64,
        f: impl Fn(f64) -> (f64, f64) + Sync,
    ) -> Result<Self, RenderError> {
        // Widened by the fade, which then acts only on zeros and ones.
        let (low, high) = (low_um / (1.0 - FADE), high_um / (1.0 - FADE));
        let made = Self::tabulate(low, high, tolerance, f)?;
        let interpolation_error = made.interpolation_error + self.interpolation_error;
        Ok(Self { interpolation_error, truncation: self.truncation, ..made })
    }

    /// Smallest distance, µm, at which F reaches `level` (0 < level < 1); `None` where it never
    /// does.
    pub(crate) fn position_um(&self, level: f64) -> Option<f64> {
        let i = self.knots.windows(2).position(|k| k[0].value < level && k[1].value >= level)?;
        let (mut a, mut b) =
            (self.low_um + i as f64 * self.step_um, self.low_um + (i + 1) as f64 * self.step_um);
        for _ in 0..60 {
            let middle = 0.5 * (a + b);
            if self.value(middle) < level { a = middle } else { b = middle }
        }
        Some(0.5 * (a + b))
    }

    /// Distance from the first 10 % point to the first 90 % point, µm.
    pub(crate) fn width_10_90_um(&self) -> Option<f64> {
        Some(self.position_um(0.9)? - self.position_um(0.1)?)
    }

    /// Blur of a Gaussian edge of the same sharpness, the root of max|dF| over max|d³F|, µm: the
    /// scale that a quadrature over the pixel must resolve. Equals σ for the Gaussian; about a
    /// sixth of the finest period for rings.
    pub(crate) fn sharpness_um(&self) -> f64 {
        let steepest = self.knots.iter().fold(0.0, |m: f64, k| m.max(k.slope.abs()));
        let third = (0..self.segments()).map(|i| 6.0 * self.segment(i)[3].abs() / self.step_um.powi(3));
        (steepest / third.fold(f64::MIN_POSITIVE, f64::max)).sqrt()
    }

    /// Cubics over `segments` equal segments of -`reach_um`..=`reach_um`.
    pub(crate) fn cubics(&self, reach_um: f64, segments: usize) -> Vec<[f64; 4]> {
        let step = 2.0 * reach_um / segments as f64;
        let knot = |i: usize| {
            let d = -reach_um + i as f64 * step;
            // The last knot is full light, independent of its rounding.
            if i >= segments { (1.0, 0.0) } else { (self.value(d), self.slope(d)) }
        };
        (0..segments).map(|i| hermite(knot(i), knot(i + 1), step)).collect()
    }

    fn place(&self, d_um: f64) -> Place {
        let at = (d_um - self.low_um) / self.step_um;
        let segments = self.segments();
        if at.is_nan() || at < 0.0 {
            Place::Shadow
        } else if at >= segments as f64 {
            Place::Light
        } else {
            Place::Segment(at as usize, at.fract())
        }
    }

    /// Coefficients c0..c3 of segment `i` over its fraction 0..1.
    pub(crate) fn segment(&self, i: usize) -> [f64; 4] {
        let (a, b) = (&self.knots[i], &self.knots[i + 1]);
        hermite((a.value, a.slope), (b.value, b.slope), self.step_um)
    }

    /// Number of segments.
    pub(crate) fn segments(&self) -> usize {
        self.knots.len() - 1
    }
}

enum Place {
    Shadow,
    Light,
    Segment(usize, f64),
}

/// Cubic over 0..1 from values and slopes at both ends of a step.
fn hermite((a, da): (f64, f64), (b, db): (f64, f64), step: f64) -> [f64; 4] {
    let (da, db) = (da * step, db * step);
    [a, da, 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db]
}

/// `intervals + 1` equidistant samples; each computed independently, so that threads cannot change
/// the result.
fn sample(low: f64, high: f64, intervals: usize, f: &(impl Fn(f64) -> (f64, f64) + Sync)) -> Vec<(f64, f64)> {
    let step = (high - low) / intervals.max(1) as f64;
    (0..=intervals).into_par_iter().map(|i| f(low + i as f64 * step)).collect()
}

/// Largest difference in the middle of the intervals, where the cubic errs most; the slope is
/// checked as well, because an edge within one interval could be missed by symmetry.
fn largest_error(knots: &[(f64, f64)], middles: &[(f64, f64)], step: f64) -> f64 {
    knots
        .windows(2)
        .zip(middles)
        .map(|(k, m)| {
            let guess = 0.5 * (k[0].0 + k[1].0) + step * (k[0].1 - k[1].1) / 8.0;
            let slope = 1.5 * (k[1].0 - k[0].0) / step - 0.25 * (k[0].1 + k[1].1);
            (guess - m.0).abs().max(0.25 * step * (slope - m.1).abs())
        })
        .fold(0.0, f64::max)
}

/// Fades the difference to 0 or 1 over the outer fifth with a cubic step.
fn fade(d: f64, low: f64, high: f64, (value, slope): (f64, f64)) -> (f64, f64) {
    let (end, level) = if d < 0.0 { (low, 0.0) } else { (high, 1.0) };
    let t = (d / end - (1.0 - FADE)) / FADE;
    if t <= 0.0 {
        return (value, slope);
    }
    let t = t.min(1.0);
    let weight = 1.0 - t * t * (3.0 - 2.0 * t);
    let weight_slope = -6.0 * t * (1.0 - t) / (FADE * end);
    (level + weight * (value - level), weight * slope + weight_slope * (value - level))
}
