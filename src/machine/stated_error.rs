//! The numbers of an error as a config states them, checked, as a function in mm and rad.

use std::f64::consts::TAU;

use super::error_function::{Drift, ErrorFunction, Wave};
use super::table::Table;
use crate::setting::{SettingError, require, within};

/// Largest value of an error, µm or µrad. Acceptance tests of lathes allow tens of µm and µrad; a
/// value beyond a thousand is one in another unit (nm for µm; an arc second is 4.85 µrad).
const LARGEST: f64 = 1000.0;
/// Widest gap between angles of a spindle's table, degrees: a line across more than a quarter of a
/// turn no longer follows even the second order.
const WIDEST_GAP_DEG: f64 = 90.0;
/// How far a table may stop short of the travel's end, mm: rounding of positions in a file.
const SHORT_MM: f64 = 1e-6;

/// Unit of an error's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unit {
    /// Micrometres.
    Um,
    /// Microradians.
    Urad,
}

impl Unit {
    /// As it ends the names of keys and columns.
    pub(crate) fn suffix(self) -> &'static str {
        match self {
            Self::Um => "um",
            Self::Urad => "urad",
        }
    }

    fn symbol(self) -> &'static str {
        match self {
            Self::Um => "µm",
            Self::Urad => "µrad",
        }
    }
}

/// Over what an error is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Domain {
    /// The travel of a slide, from and to, mm.
    Travel(f64, f64),
    /// A turn of the spindle.
    Turn,
}

/// A cosine: its wavelength in mm, or its waves a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StatedWave {
    pub period: f64,
    pub amplitude: f64,
    pub phase_deg: f64,
}

/// A table: positions in mm or degrees; no backward values where they were not measured apart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StatedTable {
    pub position: Vec<f64>,
    pub forward: Vec<f64>,
    pub backward: Vec<f64>,
}

/// Drift: a kelvin, a metre and kelvin, warm, with its time constant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct StatedDrift {
    pub per_k: f64,
    pub per_m_k: f64,
    pub warm_up: f64,
    pub time_constant_min: f64,
}

/// An error, in µm or µrad.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StatedError {
    pub unit: Unit,
    pub waves: Vec<StatedWave>,
    pub polynomial: Option<Vec<f64>>,
    pub table: Option<StatedTable>,
    pub reversal: f64,
    pub drift: StatedDrift,
}

impl StatedError {
    /// The function in mm or rad; `key` names the error's table in the config.
    ///
    /// # Errors
    /// The first number that cannot be right, with its key and what would be.
    pub(crate) fn function(&self, key: &str, domain: Domain) -> Result<ErrorFunction, SettingError> {
        let suffix = self.unit.suffix();
        let (from, to) = match domain {
            Domain::Travel(from, to) => (from, to),
            Domain::Turn => (0.0, 0.0),
        };
        self.plausible(&format!("{key}.reversal_{suffix}"), self.reversal, "")?;
        let has_both = self.table.as_ref().is_some_and(|table| !table.backward.is_empty());
        let right = "0: the table holds both directions, so that the reversal is in it";
        require(
            !has_both || self.reversal == 0.0,
            &format!("{key}.reversal_{suffix}"),
            self.reversal,
            right,
        )?;
        Ok(ErrorFunction {
            waves: self.waves(key, domain)?,
            polynomial: self.polynomial(&format!("{key}.polynomial.coefficients_{suffix}"))?,
            middle: 0.5 * (from + to),
            half: 0.5 * (to - from),
            table: self.table(&format!("{key}.table"), domain)?,
            reversal: self.scale() * self.reversal,
            drift: self.drift(&format!("{key}.drift"))?,
        })
    }

    /// From the unit to mm or rad.
    fn scale(&self) -> f64 {
        match self.unit {
            Unit::Um => 1e-3,
            Unit::Urad => 1e-6,
        }
    }

    /// Refuses values that are not finite, or a thousand times a machine's.
    fn plausible(&self, key: &str, value: f64, per: &str) -> Result<(), SettingError> {
        let (unit, smaller) = (self.unit.symbol(), if self.unit == Unit::Um { "nm" } else { "nrad" });
        let right = format!(
            "within ±{LARGEST} {unit}{per}; more is a thousand times what a machine has: is the number in {smaller}?"
        );
        require(value.is_finite() && value.abs() <= LARGEST, key, value, &right)
    }

    fn waves(&self, key: &str, domain: Domain) -> Result<Vec<Wave>, SettingError> {
        let wave = |(k, wave): (usize, &StatedWave)| {
            let key = |name: &str| format!("{key}.fourier[{k}].{name}");
            let frequency = match domain {
                Domain::Travel(..) => {
                    let right = "between 0.001 and 100000 mm";
                    within(&key("wavelength_mm"), wave.period, 1e-3, 1e5, right)?;
                    TAU / wave.period
                }
                Domain::Turn => {
                    let right = "between 1 and 10000 waves a turn";
                    within(&key("order"), wave.period, 1.0, 1e4, right)?;
                    wave.period
                }
            };
            self.plausible(&key(&format!("amplitude_{}", self.unit.suffix())), wave.amplitude, "")?;
            within(&key("phase_deg"), wave.phase_deg, -3600.0, 3600.0, "an angle in degrees")?;
            let phase = wave.phase_deg.to_radians();
            Ok(Wave { frequency, amplitude: self.scale() * wave.amplitude, phase })
        };
        self.waves.iter().enumerate().map(wave).collect()
    }

    fn polynomial(&self, key: &str) -> Result<Vec<f64>, SettingError> {
        let Some(coefficients) = &self.polynomial else { return Ok(Vec::new()) };
        let count = coefficients.len();
        require((1..=30).contains(&count), key, format!("{count} numbers"), "1 to 30 numbers")?;
        self.all_plausible(key, coefficients)?;
        Ok(coefficients.iter().map(|c| self.scale() * c).collect())
    }

    fn all_plausible(&self, key: &str, values: &[f64]) -> Result<(), SettingError> {
        values.iter().enumerate().try_for_each(|(k, v)| self.plausible(&format!("{key}[{k}]"), *v, ""))
    }

    fn drift(&self, key: &str) -> Result<Drift, SettingError> {
        let StatedDrift { per_k, per_m_k, warm_up, time_constant_min } = self.drift;
        let suffix = self.unit.suffix();
        self.plausible(&format!("{key}.offset_{suffix}_per_k"), per_k, " a kelvin")?;
        self.plausible(&format!("{key}.slope_{suffix}_per_m_k"), per_m_k, " a metre and kelvin")?;
        self.plausible(&format!("{key}.warm_up_{suffix}"), warm_up, "")?;
        let key = format!("{key}.time_constant_min");
        within(&key, time_constant_min, 0.0, 1e4, "above 0 and at most 10000 minutes")?;
        let right = &format!("above 0 where warm_up_{suffix} is not 0");
        require(time_constant_min > 0.0 || warm_up == 0.0, &key, time_constant_min, right)?;
        let scale = self.scale();
        Ok(Drift {
            per_k: scale * per_k,
            slope_per_k: 1e-3 * scale * per_m_k,
            warm_up: scale * warm_up,
            time_constant_min,
        })
    }

    fn table(&self, key: &str, domain: Domain) -> Result<Option<Table>, SettingError> {
        let Some(table) = &self.table else { return Ok(None) };
        let suffix = self.unit.suffix();
        let position = match domain {
            Domain::Travel(..) => format!("{key}.position_mm"),
            Domain::Turn => format!("{key}.angle_deg"),
        };
        let (value, backward) = (format!("{key}.value_{suffix}"), format!("{key}.backward_{suffix}"));
        let count = table.position.len();
        require(count >= 2, &position, format!("{count} positions"), "at least 2")?;
        same_length(&value, table.forward.len(), count)?;
        if !table.backward.is_empty() {
            same_length(&backward, table.backward.len(), count)?;
        }
        ascending(&position, &table.position, &backward)?;
        covers(&position, &table.position, domain)?;
        self.all_plausible(&value, &table.forward)?;
        self.all_plausible(&backward, &table.backward)?;
        let is_turn = domain == Domain::Turn;
        let scaled = |values: &[f64]| values.iter().map(|v| self.scale() * v).collect::<Vec<f64>>();
        let back = if table.backward.is_empty() { &table.forward } else { &table.backward };
        Ok(Some(Table {
            position: table.position.iter().map(|p| if is_turn { p.to_radians() } else { *p }).collect(),
            forward: scaled(&table.forward),
            backward: scaled(back),
            is_periodic: is_turn,
        }))
    }
}

fn same_length(key: &str, found: usize, count: usize) -> Result<(), SettingError> {
    require(found == count, key, format!("{found} values"), &format!("one a position, {count}"))
}

/// Refuses positions that do not ascend: those of both directions in one column, and others.
fn ascending(key: &str, positions: &[f64], backward: &str) -> Result<(), SettingError> {
    if let Some(k) = positions.iter().position(|p| !p.is_finite()) {
        return Err(SettingError::of(format!("{key}[{k}]"), positions[k], "a finite number"));
    }
    let is_up = |pair: &[f64]| pair[1] > pair[0];
    let Some(k) = positions.windows(2).position(|pair| !is_up(pair)) else { return Ok(()) };
    let (before, here) = (positions[k], positions[k + 1]);
    let way_back = &positions[k..];
    let turns = k > 0 && way_back.len() > 2 && way_back.windows(2).all(|pair| !is_up(pair));
    let right = if turns {
        let backward = backward.rsplit('.').next().unwrap_or_default();
        format!(
            "above {before}: the way back stands in the same column; give each position once, with the values of the way back in {backward}"
        )
    } else {
        format!("above {before}: positions ascend and stand once each")
    };
    Err(SettingError::of(format!("{key}[{}]", k + 1), here, right))
}

/// Refuses a table that leaves a part of the travel, or of the turn, without values.
fn covers(key: &str, positions: &[f64], domain: Domain) -> Result<(), SettingError> {
    let (first, last) = (positions[0], positions[positions.len() - 1]);
    match domain {
        Domain::Travel(from, to) => {
            let found = format!("{first} to {last} mm");
            let right = format!(
                "from {from} to {to} mm or beyond, the travel of the axis: outside of a table no error is known; measure on or shorten the travel"
            );
            require(first <= from + SHORT_MM && last >= to - SHORT_MM, key, found, &right)
        }
        Domain::Turn => {
            let right = "less than 360 degrees from first to last: the first angle closes the turn";
            require(last - first < 360.0, key, format!("{first} to {last} degrees"), right)?;
            let closing = 360.0 - (last - first);
            let widest = positions.windows(2).map(|pair| pair[1] - pair[0]).fold(closing, f64::max);
            let right = format!("angles at most {WIDEST_GAP_DEG} degrees apart all the way round");
            require(widest <= WIDEST_GAP_DEG, key, format!("a gap of {widest} degrees"), &right)
        }
    }
}
