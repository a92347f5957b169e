//! A fixed pin of known diameter beside the part, in every frame: it corrects the scale.
//!
//! ```text
//! D = D_read·D₀/D_m,   u² = D²·[u²(D_m)/D_m² + u²(D₀)/D₀²] + [ε·(D − D₀)]²/3,   ε = D_m/D₀ − 1
//! ```
//!
//! D₀ what the pin is stated to be, D_m what the frame shows of it. One pin does not show whether
//! the scale has changed or the edges have moved: the first is taken, which is the larger effect of
//! heat, and what the second would have made of the part instead is the limit of a uniform
//! distribution, zero for a part of the pin's diameter. The pin's noise is random from frame to
//! frame. A pin that is gone, shows fewer columns than before, has columns refused, or reads apart
//! from its last readings by more than noise and heat explain, corrects nothing: its frame has no
//! diameter.

use std::collections::VecDeque;
use std::fmt;
use std::str::FromStr;

use crate::frame::{FrameMeta, FrameView};
use crate::gauge::calibration::Conditions;
use crate::gauge::{Calibration, ColumnDiameters, EdgeStream, FrameEdges, Gauge};
use crate::numerics::robust::median_of;
use crate::profile::{Reading, Reason};

/// Fewest columns of a pin, and of the part beside it: noise of .02 px a column is .0025 px in
/// their mean, 50 nm at 20 µm/px.
const LEAST_COLUMNS: usize = 64;
/// Share of a pin's columns at either end that are left out: diffraction at its end face bends the
/// edge there.
const END_SHARE: f64 = 0.1;
/// Share of columns that may be refused, or missing against the most that were seen: more is
/// contamination or a pin that moved.
const MOST_MISSING: f64 = 0.1;
/// Largest drift that is corrected, relative: 20 K at the 23 ppm/K of aluminium. More is a lens
/// that was touched.
const MOST_DRIFT: f64 = 5e-4;
/// Departure from the median of the last readings that heat may explain, relative: one kelvin
/// between two frames. A particle of a micrometre on a pin of 10 mm is a hundred ppm.
const MOST_STEP: f64 = 2e-5;
/// Standard uncertainties by which noise may depart, beside it: one frame in two million.
const NOISE: f64 = 5.0;
/// Readings whose median is compared with: more would lag behind a drift, one alone has its noise.
const COMPARED: usize = 3;
/// Expanded uncertainty of a diameter that is stated without one, µm: the limits of a pin gauge of
/// a micrometre's class.
const UNSTATED_UM: f64 = 1.0;
/// Coverage factor of the stated expanded uncertainty.
const K: f64 = 2.0;

/// A fixed pin in the field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferencePin {
    /// First column of the field that it has to itself, and the one after the last, its axis along
    /// the columns.
    pub columns: [usize; 2],
    /// Its diameter as it stands in the field, mm.
    pub diameter_mm: f64,
    /// Expanded uncertainty of that (k = 2), mm.
    pub expanded_u_mm: f64,
}

impl FromStr for ReferencePin {
    type Err = String;

    /// Reads `FROM-TO,DIAMETER_MM[,U_UM]`: columns with both ends, expanded uncertainty in µm.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            "columns and a diameter in mm are needed, and where it is known its U in µm: 0-199,10.0003,0.3"
                .to_owned()
        };
        let parts: Vec<&str> = text.split(',').map(str::trim).collect();
        let (columns, diameter, u) = match parts[..] {
            [columns, diameter] => (columns, diameter, None),
            [columns, diameter, u] => (columns, diameter, Some(u)),
            _ => return Err(wrong()),
        };
        let (from, to) = columns.split_once('-').ok_or_else(wrong)?;
        let column = |text: &str| text.trim().parse::<usize>().map_err(|_| wrong());
        let number = |text: &str| text.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(wrong);
        let (from, last) = (column(from)?, column(to)?);
        let (diameter_mm, u_um) = (number(diameter)?, u.map_or(Ok(UNSTATED_UM), number)?);
        if !(diameter_mm > 0.0 && (0.0..=1e3).contains(&u_um)) {
            return Err(wrong());
        }
        if last < from || last - from + 1 < LEAST_COLUMNS {
            return Err(format!("a pin of {LEAST_COLUMNS} columns at least is needed, for instance 0-199"));
        }
        Ok(Self { columns: [from, last + 1], diameter_mm, expanded_u_mm: 1e-3 * u_um })
    }
}

/// What a pin makes of the diameters of its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PinCorrection {
    /// Stated over measured diameter.
    pub ratio: f64,
    /// Relative standard uncertainty of the frame's reading.
    pub u_reading: f64,
    /// Relative standard uncertainty of the stated diameter.
    pub u_stated: f64,
    diameter_mm: f64,
}

impl PinCorrection {
    /// Relative drift that it takes off.
    pub(super) fn drift(&self) -> f64 {
        1.0 / self.ratio - 1.0
    }

    /// Standard uncertainty of a diameter by not knowing whether scale or edges drifted, mm.
    pub(super) fn u_kind_mm(&self, d_mm: f64) -> f64 {
        (self.drift() * (d_mm - self.diameter_mm)).abs() / 3.0_f64.sqrt()
    }

    /// Corrects the diameters of columns.
    pub(super) fn correct(&self, diameters: &mut ColumnDiameters) {
        for column in &mut diameters.columns {
            let Reading::Value(value) = &mut column.reading else { continue };
            value.d_mm *= self.ratio;
            let random_mm = value.d_mm * self.u_reading;
            // one reading of the pin for all columns of the frame
            column.shared_mm = column.shared_mm.hypot(random_mm);
            value.u_random_mm = value.u_random_mm.hypot(random_mm);
            let common_mm = (value.d_mm * self.u_stated).hypot(self.u_kind_mm(value.d_mm));
            value.u_common_mm = value.u_common_mm.hypot(common_mm);
        }
    }
}

impl fmt::Display for PinCorrection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.5} mm, {:+.1} ppm", self.diameter_mm, 1e6 * self.drift())
    }
}

/// Reads the pin frame by frame.
pub(super) struct PinReader {
    pin: ReferencePin,
    calibration: Calibration,
    edge_stream: EdgeStream,
    edges: FrameEdges,
    diameters: ColumnDiameters,
    /// Relative drifts of the last good readings.
    past: VecDeque<f64>,
    /// Most columns that were seen.
    most: usize,
    /// The calibration of whole frames, until the part's columns are known.
    whole: Option<Calibration>,
}

impl PinReader {
    /// A pin that is measured with this gauge and calibration.
    pub(super) fn new(pin: ReferencePin, gauge: &Gauge, calibration: &Calibration) -> Self {
        Self {
            calibration: from_column(calibration, pin.columns[0]),
            edge_stream: gauge.stream(),
            edges: FrameEdges::default(),
            diameters: ColumnDiameters::default(),
            past: VecDeque::new(),
            most: 0,
            whole: Some(calibration.clone()),
            pin,
        }
    }

    /// Columns of the part beside the pin: those of its wider side.
    ///
    /// # Errors
    /// A pin that leaves no part, or is not in the field.
    pub(super) fn part_columns(&self, columns: usize) -> Result<[usize; 2], String> {
        let [from, to] = self.pin.columns;
        if to > columns {
            return Err(format!("the reference pin ends at column {}, the frame has {columns}", to - 1));
        }
        let part = if from > columns - to { [0, from] } else { [to, columns] };
        match part[1] - part[0] >= LEAST_COLUMNS {
            true => Ok(part),
            false => Err(format!("the reference pin leaves the part fewer than {LEAST_COLUMNS} columns")),
        }
    }

    /// The calibration of the part's columns, the first time that they are known.
    pub(super) fn part_place(&mut self, from: usize) -> Option<Calibration> {
        self.whole.take().map(|whole| from_column(&whole, from))
    }

    /// The correction by a frame whose shaft lies level.
    ///
    /// # Errors
    /// A pin by which nothing can be corrected, and why.
    pub(super) fn read(&mut self, view: &FrameView<'_>) -> Result<PinCorrection, String> {
        let read = self.correction(view);
        // what a covered pin leaves behind is no place to look for the next frame's
        read.inspect_err(|_| self.edge_stream.restart())
    }

    fn correction(&mut self, view: &FrameView<'_>) -> Result<PinCorrection, String> {
        let [from, to] = self.pin.columns;
        let own = view.columns_between(from, to).ok_or("it is not in the field")?;
        self.edge_stream.measure(&own, &mut self.edges).map_err(|refused| refused.to_string())?;
        self.calibration.diameters_into(&self.edges, &Conditions::default(), &mut self.diameters);
        let columns = self.seen()?;
        let Reading::Value(mean) = self.diameters.mean(columns) else {
            return Err("it has no diameter".to_owned());
        };
        let stated_mm = self.pin.diameter_mm;
        let (drift, u_reading) = (mean.d_mm / stated_mm - 1.0, mean.u_random_mm / stated_mm);
        let u_stated = self.pin.expanded_u_mm / K / stated_mm;
        self.check_drift(drift, u_reading, u_stated)?;
        self.past.push_back(drift);
        if self.past.len() > COMPARED {
            self.past.pop_front();
        }
        Ok(PinCorrection { ratio: stated_mm / mean.d_mm, u_reading, u_stated, diameter_mm: stated_mm })
    }

    /// The columns that are taken: those with a diameter, less its ends.
    ///
    /// # Errors
    /// Columns that are refused, or fewer than were seen before.
    fn seen(&mut self) -> Result<std::ops::Range<usize>, String> {
        let columns = &self.diameters.columns;
        let is_seen = |k: &usize| columns[*k].reading.value().is_some();
        let all = 0..columns.len();
        let ends = all.clone().find(is_seen).zip(all.clone().rev().find(is_seen));
        let (first, last) =
            ends.filter(|(a, b)| b - a + 1 >= LEAST_COLUMNS / 2).ok_or("it shows too few columns")?;
        let trimmed = ((last - first + 1) as f64 * END_SHARE).ceil() as usize;
        let taken = first + trimmed..last + 1 - trimmed;
        let seen = taken.clone().filter(is_seen).count();
        let refused = all.filter(|k| {
            matches!(
                columns[*k].reading,
                Reading::Gap(Reason::Contaminated | Reason::Residual | Reason::Outlier)
            )
        });
        let refused = refused.count();
        let limit = MOST_MISSING * taken.len() as f64;
        let missing = (taken.len() - seen).max(self.most.saturating_sub(seen));
        if refused as f64 > limit || missing as f64 > limit {
            return Err(format!(
                "{seen} of {} columns of it have a diameter, {refused} are refused: it is contaminated or has moved",
                self.most.max(taken.len())
            ));
        }
        self.most = self.most.max(seen);
        Ok(taken)
    }

    fn check_drift(&self, drift: f64, u_reading: f64, u_stated: f64) -> Result<(), String> {
        if !(drift.abs() <= MOST_DRIFT + K * u_stated) {
            return Err(format!(
                "it reads {:+.0} ppm off its diameter, {:.0} ppm at most: another pin, a lens that was touched, or contamination",
                1e6 * drift,
                1e6 * MOST_DRIFT
            ));
        }
        if self.past.is_empty() {
            return Ok(());
        }
        let usual = median_of(self.past.iter().copied().collect());
        let limit = MOST_STEP + NOISE * u_reading;
        if (drift - usual).abs() > limit {
            return Err(format!(
                "it reads {:+.0} ppm apart from its last readings, {:.0} ppm at most: contamination; clean it",
                1e6 * (drift - usual),
                1e6 * limit
            ));
        }
        Ok(())
    }
}

/// The calibration for frames that begin at a column of the calibrated ones: exact, because a lens
/// is a function of the distance from its centre.
pub(super) fn from_column(calibration: &Calibration, from: usize) -> Calibration {
    let mut own = calibration.clone();
    if let Some(setup) = &mut own.setup {
        setup.lens.centre_column_px -= from as f64;
    }
    own
}

/// The metadata of some columns of a frame: its z is that of their middle.
pub(super) fn meta_of(meta: &FrameMeta, [from, to]: [usize; 2], columns: usize, pitch_mm: f64) -> FrameMeta {
    let off = 0.5 * (from + to) as f64 - 0.5 * columns as f64;
    FrameMeta { z_mm: meta.z_mm + off * pitch_mm, ..meta.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pin_is_stated_by_columns_diameter_and_uncertainty() {
        let pin: ReferencePin = "20-219, 10.0003, 0.3".parse().unwrap();
        assert_eq!((pin.columns, pin.diameter_mm), ([20, 220], 10.0003));
        assert!((pin.expanded_u_mm - 3e-4).abs() < 1e-12);
        assert!(("0-63,1".parse::<ReferencePin>().unwrap().expanded_u_mm - 1e-3).abs() < 1e-12);
        for text in ["", "10", "0-99", "0-99,x", "0-99,-1", "0-99,10,-1", "99-0,10", "0-62,10", "0-99,10,1,1"]
        {
            assert!(text.parse::<ReferencePin>().is_err(), "{text}");
        }
    }

    #[test]
    fn the_correction_has_the_pins_noise_once_and_what_a_drift_of_edges_would_have_made() {
        let correction =
            PinCorrection { ratio: 1.0 / 1.00005, u_reading: 2e-6, u_stated: 1e-5, diameter_mm: 10.0 };
        assert!((correction.drift() - 5e-5).abs() < 1e-12);
        // half a µm of both edges of 10 mm is a µm of 20 mm by the scale: half a µm between them
        assert!((correction.u_kind_mm(20.0) - 5e-4 / 3.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(correction.u_kind_mm(10.0), 0.0);
        let middle = meta_of(&FrameMeta { z_mm: 7.0, ..FrameMeta::default() }, [300, 512], 512, 0.01);
        // columns 300 to 511 have their middle at 405.5, the frame at 255.5
        assert!((middle.z_mm - (7.0 + 150.0 * 0.01)).abs() < 1e-12);
    }
}
