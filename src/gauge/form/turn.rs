//! One revolution of silhouettes at one z: the heights of both edges at every spindle angle.
//!
//! With c(φ) the spindle's motion across the line of sight and h the section's support function,
//! top = c(φ) + h(φ) and bottom = c(φ) − h(φ+π). Their difference w(φ) = h(φ) + h(φ+π) holds the
//! even lobes of h, free of c; their mean m(φ) = c(φ) + ½[h(φ) − h(φ+π)] holds the odd lobes with
//! the odd part of c, and the even part of c by itself. So, with bars for the parts even and odd
//! under φ → φ + π,
//!
//! ```text
//! h(φ) = ½·w̄_even(φ) + m̄_odd(φ)      section, odd lobes with odd spindle motion (k = 1: offset)
//! s(φ) = m̄_even(φ)                   synchronous spindle motion of even order
//! ```
//!
//! Averaging several revolutions removes only asynchronous motion. φ is the spindle angle: a lobe
//! with its peak at φ_k stands at the body angle θ = −φ_k.

use super::error::FormError;

/// Edge heights over one revolution at even spindle angles, mm: as many of the top as of the
/// bottom, apart because harmonics are fitted to each as a slice.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Turn {
    first_angle_deg: f64,
    top_mm: Vec<f64>,
    bottom_mm: Vec<f64>,
}

impl Turn {
    /// A revolution of n readings at `first_angle_deg + i·360/n`; n even and at least 8.
    ///
    /// # Errors
    /// Refuses unpaired, odd, few or non-finite readings.
    pub(crate) fn even(
        first_angle_deg: f64,
        top_mm: Vec<f64>,
        bottom_mm: Vec<f64>,
    ) -> Result<Self, FormError> {
        let n = top_mm.len();
        if n != bottom_mm.len() {
            return Err(FormError::Unpaired { top: n, bottom: bottom_mm.len() });
        }
        if n < 8 {
            return Err(FormError::TooFew { feature: "turn", found: n, needed: 8 });
        }
        if n % 2 == 1 {
            let right = "even, so that every reading has its opposite";
            return Err(FormError::Argument { name: "readings of a turn", value: n as f64, right });
        }
        let finite = |v: &[f64]| v.iter().position(|x| !x.is_finite());
        match finite(&top_mm).or_else(|| finite(&bottom_mm)) {
            Some(index) => Err(FormError::NotFinite { index }),
            None => Ok(Self { first_angle_deg, top_mm, bottom_mm }),
        }
    }

    /// A revolution from readings (angle in degrees, top, bottom) in any order, their angles an
    /// even division of a revolution to 1e-3 of a division.
    ///
    /// # Errors
    /// As [`Turn::even`], and for uneven angles.
    pub(crate) fn from_readings(readings: &[[f64; 3]]) -> Result<Self, FormError> {
        if let Some(index) = readings.iter().position(|r| r.iter().any(|v| !v.is_finite())) {
            return Err(FormError::NotFinite { index });
        }
        let mut sorted = readings.to_vec();
        sorted.sort_by(|a, b| a[0].rem_euclid(360.0).total_cmp(&b[0].rem_euclid(360.0)));
        let first = sorted.first().map_or(0.0, |r| r[0].rem_euclid(360.0));
        let division = 360.0 / sorted.len().max(1) as f64;
        for (index, r) in sorted.iter().enumerate() {
            let expected_deg = first + division * index as f64;
            let angle_deg = r[0].rem_euclid(360.0);
            if (angle_deg - expected_deg).abs() > 1e-3 * division {
                return Err(FormError::UnevenAngles { index, angle_deg, expected_deg });
            }
        }
        let column = |k: usize| sorted.iter().map(|r| r[k]).collect();
        Self::even(first, column(1), column(2))
    }

    /// Readings in the revolution.
    pub(crate) fn len(&self) -> usize {
        self.top_mm.len()
    }

    /// Spindle angle of a reading, degrees.
    pub(crate) fn angle_deg(&self, index: usize) -> f64 {
        self.first_angle_deg + 360.0 * index as f64 / self.len() as f64
    }

    /// Top edges, mm.
    pub(crate) fn top_mm(&self) -> &[f64] {
        &self.top_mm
    }

    /// Caliper diameters w(φ), mm: half a revolution shows each twice.
    pub(crate) fn widths_mm(&self) -> Vec<f64> {
        self.top_mm.iter().zip(&self.bottom_mm).map(|(t, b)| t - b).collect()
    }

    /// Middle of the two edges m(φ), mm.
    pub(crate) fn midline_mm(&self) -> Vec<f64> {
        self.top_mm.iter().zip(&self.bottom_mm).map(|(t, b)| 0.5 * (t + b)).collect()
    }

    /// The section's support function h(φ) about the spindle axis, mm: even lobes free of spindle
    /// motion, odd ones with it. The mean of the midline (where the axis stands in the image) is
    /// not part of it.
    pub(crate) fn support_mm(&self) -> Vec<f64> {
        let (widths, midline) = (self.widths_mm(), self.midline_mm());
        let opposite = |i: usize| (i + self.len() / 2) % self.len();
        (0..self.len())
            .map(|i| {
                let j = opposite(i);
                0.25 * (widths[i] + widths[j]) + 0.5 * (midline[i] - midline[j])
            })
            .collect()
    }

    /// Synchronous spindle motion of even order s(φ), mm, its mean removed.
    pub(crate) fn even_spindle_motion_mm(&self) -> Vec<f64> {
        let midline = self.midline_mm();
        let mean = midline.iter().sum::<f64>() / self.len() as f64;
        (0..self.len())
            .map(|i| 0.5 * (midline[i] + midline[(i + self.len() / 2) % self.len()]) - mean)
            .collect()
    }
}
