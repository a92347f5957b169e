//! What `calibrate` adds to scale and offset: the lens, every source's share, the sensor, validity
//! and the check.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::adjusted::{Adjusted, CovariancePart, Residual};
use super::conditions::Conditions;
use super::date::Date;
use super::imaging_model::{ColumnSpread, LensModel, PARAMETERS};
use super::verification::CheckResult;
use crate::gauge::limit::limits;
use crate::gauge::sensor::FlatField;
use crate::gauge::sensor::photon_transfer::PhotonTransfer;

limits! {
    /// When a frame is out of focus.
    SetupLimits = "optical_setup";
    /// Ratio of blurs, as a natural logarithm, beyond which a frame is out of focus: a quarter more
    /// or a fifth less. Tuned: see study limits.
    focus: f64 = 0.223;
}

/// When a calibration was made and how long it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Validity {
    /// Day of the calibration.
    pub date: Date,
    /// Days it is valid.
    pub valid_days: u32,
}

impl Validity {
    /// Last day on which it holds.
    pub(crate) fn expires(&self) -> Date {
        self.date.plus_days(self.valid_days)
    }
}

/// Why a calibration does not fit what it is used for.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum BenchError {
    /// Its time is over.
    #[error(
        "the calibration expired on {expired} ({days} days ago); calibrate anew, or consent with --accept-expired"
    )]
    Expired {
        /// Last valid day.
        expired: Date,
        /// Days since.
        days: i64,
    },
    /// It was made after the day it is used on.
    #[error(
        "the calibration is dated {date}, after the day it is used on, {today}; one of the clocks is wrong"
    )]
    FromTheFuture {
        /// Its date.
        date: Date,
        /// The day it is used on.
        today: Date,
    },
    /// Edges of another blur than the masters'.
    #[error(
        "the edges are blurred by {found_px:.2} px, those of the masters by {calibrated_px:.2} px: out of focus, moving, other optics, or an edge model that does not fit (--esf learnt, --esf FILE, as when the masters were measured)"
    )]
    OutOfFocus {
        /// Blur of the frame, px.
        found_px: f64,
        /// Blur of the masters, px.
        calibrated_px: f64,
    },
    /// Frames of another size.
    #[error(
        "the calibration is of frames of {rows} rows x {columns} columns, this frame has {found_rows} x {found_columns}; \
         take frames as calibrated or calibrate this window"
    )]
    OtherSize {
        /// Rows calibrated.
        rows: usize,
        /// Columns calibrated.
        columns: usize,
        /// Rows of the frame.
        found_rows: usize,
        /// Columns of the frame.
        found_columns: usize,
    },
}

/// The optical setup behind a calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetupCalibration {
    /// Rows of the frames calibrated.
    pub rows: usize,
    /// Columns of the frames calibrated.
    pub columns: usize,
    /// When it was made and how long it holds.
    pub validity: Validity,
    /// The lens.
    pub lens: LensModel,
    /// Covariance of s, o, a, q, g, t by source.
    pub parts: Vec<CovariancePart>,
    /// Blur of the masters' edges, px: what a part in focus shows.
    pub sigma_px: f64,
    /// Growth of the blur with the distance y from the masters' plane, σ² = σ₀² + (c·y)², px/mm; 0
    /// where all lay in it.
    #[serde(default)]
    pub defocus_px_per_mm: f64,
    /// √(χ²/ν) of the fit.
    pub birge_ratio: f64,
    /// What the fit left.
    pub residuals: Vec<Residual>,
    /// Conditions of use, unless a measurement states others.
    #[serde(default)]
    pub conditions: Conditions,
    /// Sensor by photon transfer, where flat fields were recorded.
    #[serde(default)]
    pub sensor: Option<PhotonTransfer>,
    /// Pixels and light to be corrected for, where flat fields were recorded.
    #[serde(default)]
    pub flat_field: Option<FlatField>,
    /// The check pin's verdict.
    #[serde(default)]
    pub check: Option<CheckResult>,
}

/// Where a width was read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReadWidth {
    /// Columns of the frame.
    pub columns: ColumnSpread,
    /// Mean rows of the upper and the lower edge.
    pub rows_px: (f64, f64),
    /// Chord factor χ: width square to the axis over the width along the rows.
    pub chord: f64,
    /// Place of the part's axis along the optical axis, mm.
    pub axis_y_mm: f64,
}

impl SetupCalibration {
    /// An optical setup from its adjustment.
    pub(crate) fn new(adjusted: &Adjusted, size: (usize, usize), validity: Validity, sigma_px: f64) -> Self {
        Self {
            rows: size.0,
            columns: size.1,
            validity,
            lens: adjusted.lens,
            parts: adjusted.parts.clone(),
            sigma_px,
            defocus_px_per_mm: 0.0,
            birge_ratio: adjusted.birge_ratio,
            residuals: adjusted.residuals.clone(),
            conditions: Conditions::default(),
            sensor: None,
            flat_field: None,
            check: None,
        }
    }

    /// The optical setup as it is seen by frames read column by column, for a vertical shaft: the
    /// lens transposed, the shares of q and g in each other's place. What a decentred lens does
    /// differs along the other direction by up to |q| + |g| (see [`LensModel::ideal_point`]): a
    /// share of its own. The flat field stays that of the sensor.
    #[must_use]
    pub(crate) fn transposed(&self) -> Self {
        let (q, g) = (3, 4);
        let mut turned =
            Self { rows: self.columns, columns: self.rows, lens: self.lens.transposed(), ..self.clone() };
        for part in &mut turned.parts {
            part.matrix.swap(q, g);
            part.matrix.iter_mut().for_each(|row| row.swap(q, g));
        }
        let limit = self.lens.keystone_across.abs() + self.lens.keystone_along.abs();
        let mut matrix = [[0.0; PARAMETERS]; PARAMETERS];
        (matrix[q][q], matrix[g][g]) = (limit * limit / 3.0, limit * limit / 3.0);
        turned
            .parts
            .push(CovariancePart { source: "distortion across the other direction".to_owned(), matrix });
        turned
    }

    /// Whether it holds on a day.
    ///
    /// # Errors
    /// Expired, or from the future.
    pub(crate) fn check_date(&self, today: Date) -> Result<(), BenchError> {
        let expired = self.validity.expires();
        if today > expired {
            return Err(BenchError::Expired { expired, days: today.days_since(expired) });
        }
        // A day's grace for the time zones.
        if self.validity.date > today.plus_days(1) {
            return Err(BenchError::FromTheFuture { date: self.validity.date, today });
        }
        Ok(())
    }

    /// Whether it is of frames of this size.
    ///
    /// # Errors
    /// Another size.
    pub(crate) fn check_size(&self, rows: usize, columns: usize) -> Result<(), BenchError> {
        if (rows, columns) == (self.rows, self.columns) {
            return Ok(());
        }
        Err(BenchError::OtherSize {
            rows: self.rows,
            columns: self.columns,
            found_rows: rows,
            found_columns: columns,
        })
    }

    /// Whether a frame is as sharp as the masters predict for a part in these conditions, within
    /// `optical_setup.focus`.
    ///
    /// # Errors
    /// The blur that is not the calibrated one.
    pub(crate) fn check_focus(&self, sigma_px: [f64; 2], conditions: &Conditions) -> Result<(), BenchError> {
        let limits = SetupLimits::get();
        let farthest = conditions.axis_in_frame_mm().abs() + conditions.limit_axis_y_mm;
        let (low, high) = (self.sigma_px, self.sigma_px.hypot(self.defocus_px_per_mm * farthest));
        let inside = |s: f64| (s / low).ln() >= -limits.focus && (s / high).ln() <= limits.focus;
        match sigma_px.into_iter().find(|s| !inside(*s)) {
            Some(found_px) => Err(BenchError::OutOfFocus { found_px, calibrated_px: self.sigma_px }),
            None => Ok(()),
        }
    }

    /// Derivatives of D_T by s, o, a, q, g, t at the scale s, mm/px.
    pub(crate) fn diameter_by(&self, scale: f64, read: &ReadWidth) -> [f64; PARAMETERS] {
        let ReadWidth { columns, rows_px, chord, axis_y_mm } = *read;
        let lens = &self.lens;
        let u = ColumnSpread { mean_px: columns.mean_px - lens.centre_column_px, ..columns };
        let (top, bottom) = (rows_px.0 - lens.centre_row_px, rows_px.1 - lens.centre_row_px);
        let near = 1.0 + lens.telecentricity_per_mm * axis_y_mm;
        let width = (lens.ideal_mean(u, bottom) - lens.ideal_mean(u, top)) * chord;
        let by = lens.width_by(u, top, bottom).map(|b| scale * near * chord * b);
        [near * width, 1.0, by[0], by[1], by[2], scale * axis_y_mm * width]
    }

    /// Standard uncertainty of the telecentricity t, 1/mm.
    pub(crate) fn u_telecentricity_per_mm(&self) -> f64 {
        self.parts.iter().map(|p| p.matrix[5][5]).sum::<f64>().max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use std::time::SystemTime;

    use super::*;

    fn setup(sigma_px: f64, defocus_px_per_mm: f64) -> SetupCalibration {
        SetupCalibration {
            rows: 200,
            columns: 400,
            validity: Validity { date: Date::of(SystemTime::UNIX_EPOCH), valid_days: 365 },
            lens: LensModel::perfect(200, 400),
            parts: Vec::new(),
            sigma_px,
            defocus_px_per_mm,
            birge_ratio: 1.0,
            residuals: Vec::new(),
            conditions: Conditions::default(),
            sensor: None,
            flat_field: None,
            check: None,
        }
    }

    /// A fifth more or a seventh less than the masters' blur is the same focus, a third more or
    /// less is another. A part that may stand off the masters' plane by y may be blurred by σ² =
    /// σ₀² + (c·y)².
    #[test]
    fn a_part_is_in_focus_within_a_quarter_of_the_masters_blur() {
        let conditions = Conditions::default();
        let of = |ratio: f64| setup(1.2, 0.0).check_focus([1.2, 1.2 * ratio], &conditions);
        for ratio in [0.85, 1.0, 1.2] {
            assert_eq!(of(ratio), Ok(()), "{ratio}");
        }
        for ratio in [0.67, 1.33] {
            assert!(matches!(of(ratio), Err(BenchError::OutOfFocus { .. })), "{ratio}");
        }
        let apart = Conditions { limit_axis_y_mm: 2.0, ..conditions };
        assert!(setup(1.2, 0.5).check_focus([1.2, 1.2 * 1.33], &apart).is_ok());
    }
}
