//! Window and drift of a source that is watched: what its lines have of them, now and by the
//! minute.
//!
//! The window: light outside of the part against an even one once a second (against the calibrated
//! flat, where there is one: what has changed since the calibration), and the columns that frames
//! refuse as contaminated. The drift: its standard uncertainty by the time since the last zero, as
//! the frames have it (`watch --zero`).

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Mutex, PoisonError};

use serde::Serialize;
use serde_json::Value;
use utoipa::ToSchema;

use crate::store::Utc;

/// Minutes that are kept: those of a day.
const MINUTES: usize = 24 * 60;
const MINUTE_MS: i64 = 60_000;

/// Light over the window.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct WindowHealth {
    /// When it was looked at, ISO 8601.
    pub utc: String,
    /// Light of the darkest of 144 tiles against the median of those beside the part, %.
    pub darkest_percent: f64,
    /// Its middle in the frame: row and column, px.
    pub darkest_at_px: [u64; 2],
    /// Light of the brightest, %.
    pub brightest_percent: f64,
    /// Tiles that lie wholly in the light.
    pub tiles: u64,
    /// Whether it is light after the calibrated flat: what has changed since then. Without one the
    /// unevenness of the lamp is in it.
    pub of_flat: bool,
}

/// Drift since the gauge was last set to zero.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct ZeroDriftShown {
    /// Time since then, s.
    pub since_zero_s: f64,
    /// Change of the head's temperature since then, K; 0 where it is not asked for.
    pub head_k: f64,
    /// Standard uncertainty of a diameter by it, µm.
    pub u_drift_um: f64,
}

/// A minute of a source.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(super) struct Minute {
    /// When it began, ISO 8601.
    pub utc: String,
    /// Frames in it.
    pub frames: u64,
    /// Mean of the darkest tile, %; null without a look at the light.
    pub darkest_percent: Option<f64>,
    /// Share of all columns that were refused as contaminated, %; null without columns.
    pub contaminated_percent: Option<f64>,
    /// Standard uncertainty by the drift since the zero at its end, µm.
    pub u_drift_um: Option<f64>,
}

/// Window and drift.
#[derive(Clone, Debug, Default, PartialEq, Serialize, ToSchema)]
pub(super) struct GaugeHealth {
    /// Whether a source is watched and its last frame is one of now.
    pub is_now: bool,
    /// Light over the window; null where too little of the field is lit, or nothing is watched.
    pub window: Option<WindowHealth>,
    /// Drift since zero; null where the source states no zero, or frames are refused for it.
    pub drift: Option<ZeroDriftShown>,
    /// Why the last frame has no diameter.
    pub why: Option<String>,
    /// Frames of this minute that were refused, by reason.
    pub refused: BTreeMap<String, u64>,
    /// Minute by minute, the newest last: a day at most.
    pub minutes: Vec<Minute>,
}

/// Sums of a minute.
#[derive(Clone, Debug, Default)]
struct Sums {
    begun_ms: i64,
    frames: u64,
    columns: u64,
    contaminated: u64,
    darkest: f64,
    looks: u64,
    u_drift_um: Option<f64>,
    refused: BTreeMap<String, u64>,
}

impl Sums {
    fn shown(&self) -> Minute {
        let share = |part: f64, all: u64| (all > 0).then(|| part / all as f64);
        Minute {
            utc: Utc(self.begun_ms).to_string(),
            frames: self.frames,
            darkest_percent: share(self.darkest, self.looks),
            contaminated_percent: share(100.0 * self.contaminated as f64, self.columns),
            u_drift_um: self.u_drift_um,
        }
    }
}

#[derive(Debug, Default)]
struct Taken {
    window: Option<WindowHealth>,
    drift: Option<ZeroDriftShown>,
    why: Option<String>,
    minutes: VecDeque<Sums>,
}

/// Takes the lines of a source.
#[derive(Debug, Default)]
pub(super) struct Health(Mutex<Taken>);

impl Health {
    /// A line of `watch --json`; one that is none is left out.
    pub(super) fn take(&self, line: &str) {
        if let Ok(line) = serde_json::from_str::<Value>(line) {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).line(&line, Utc::now());
        }
    }

    /// What is known; of a source that is gone its past minutes alone.
    pub(super) fn shown(&self, is_now: bool) -> GaugeHealth {
        let taken = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let minutes = taken.minutes.iter().map(Sums::shown).collect();
        if !is_now {
            return GaugeHealth { minutes, ..GaugeHealth::default() };
        }
        GaugeHealth {
            is_now,
            window: taken.window.clone(),
            drift: taken.drift.clone(),
            why: taken.why.clone(),
            refused: taken.minutes.back().map(|sums| sums.refused.clone()).unwrap_or_default(),
            minutes,
        }
    }
}

impl Taken {
    fn line(&mut self, line: &Value, now: Utc) {
        match line["event"].as_str() {
            Some("setup") => self.look(&line["evenness"], now),
            Some(_) => {}
            None => self.frame(line, now),
        }
    }

    /// The sums of the minute of an instant.
    fn minute(&mut self, now: Utc) -> &mut Sums {
        let begun_ms = now.0 - now.0.rem_euclid(MINUTE_MS);
        if self.minutes.back().is_none_or(|sums| sums.begun_ms != begun_ms) {
            if self.minutes.len() == MINUTES {
                self.minutes.pop_front();
            }
            self.minutes.push_back(Sums { begun_ms, ..Sums::default() });
        }
        let last = self.minutes.len() - 1;
        &mut self.minutes[last]
    }

    fn look(&mut self, light: &Value, now: Utc) {
        self.window = window(light, now);
        if let Some(percent) = self.window.as_ref().map(|window| window.darkest_percent) {
            let minute = self.minute(now);
            (minute.darkest, minute.looks) = (minute.darkest + percent, minute.looks + 1);
        }
    }

    fn frame(&mut self, line: &Value, now: Utc) {
        self.drift = drift(line);
        let is_valid = line["valid"].as_bool().unwrap_or(false);
        self.why = (!is_valid).then(|| why(line)).flatten();
        let (u_drift_um, why) = (self.drift.as_ref().map(|d| d.u_drift_um), self.why.clone());
        let minute = self.minute(now);
        minute.frames += 1;
        minute.u_drift_um = u_drift_um;
        let flags = line["flags"].as_object();
        // all columns of a refused frame have its reason, which is none of the window
        if is_valid {
            minute.columns += line["columns"].as_u64().unwrap_or(0);
            let contaminated = flags.and_then(|flags| flags.get("contaminated")?.as_u64());
            minute.contaminated += contaminated.unwrap_or(0);
        } else {
            let reason = flags.and_then(|flags| flags.keys().next().cloned()).or(why);
            *minute.refused.entry(reason.unwrap_or_else(|| "not_settled".to_owned())).or_default() += 1;
        }
    }
}

fn window(light: &Value, now: Utc) -> Option<WindowHealth> {
    Some(WindowHealth {
        utc: now.to_string(),
        darkest_percent: 100.0 * light["lowest"].as_f64()?,
        darkest_at_px: [light["lowest_row"].as_u64()?, light["lowest_column"].as_u64()?],
        brightest_percent: 100.0 * light["highest"].as_f64()?,
        tiles: light["tiles"].as_u64()?,
        of_flat: light["of_flat"].as_bool()?,
    })
}

fn drift(line: &Value) -> Option<ZeroDriftShown> {
    Some(ZeroDriftShown {
        since_zero_s: line["since_zero_s"].as_f64()?,
        head_k: line["head_k"].as_f64()?,
        u_drift_um: 1e3 * line["u_drift_mm"].as_f64()?,
    })
}

/// Why a frame has no diameter: its first warning, or what it could not be read for.
fn why(line: &Value) -> Option<String> {
    let words = line["warnings"][0].as_str().or_else(|| line["error"].as_str());
    words.map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::{GaugeHealth, Health, MINUTE_MS, Taken};
    use crate::store::Utc;

    #[test]
    fn window_and_drift_are_those_of_the_last_lines_and_of_each_minute() {
        let mut taken = Taken::default();
        let light = |lowest: f64| {
            json!({ "event": "setup", "evenness": { "lowest": lowest, "lowest_row": 30, "lowest_column": 210,
                    "highest": 0.01, "tiles": 96, "of_flat": true } })
        };
        let frame = |contaminated: u64| {
            json!({ "valid": true, "columns": 200, "flags": { "contaminated": contaminated },
                    "since_zero_s": 3600.0, "head_k": 0.5, "u_drift_mm": 0.0007 })
        };
        taken.line(&light(-0.02), Utc(0));
        taken.line(&light(-0.04), Utc(1000));
        taken.line(&frame(10), Utc(1500));
        taken.line(&frame(0), Utc(MINUTE_MS));
        taken.line(&json!({ "event": "gap", "lost": 3 }), Utc(MINUTE_MS));
        let refused = json!({ "valid": false, "columns": 200, "flags": { "no_edge": 200 },
                              "warnings": ["no part in the field"] });
        taken.line(&refused, Utc(MINUTE_MS + 1));
        let health = Health(std::sync::Mutex::new(taken));
        let shown = health.shown(true);
        let window = shown.window.as_ref().unwrap();
        assert_eq!((window.darkest_percent, window.darkest_at_px, window.of_flat), (-4.0, [30, 210], true));
        assert_eq!(shown.minutes.len(), 2);
        assert_eq!(shown.minutes[0].darkest_percent, Some(-3.0));
        assert_eq!(shown.minutes[0].contaminated_percent, Some(5.0));
        assert_eq!((shown.minutes[1].contaminated_percent, shown.minutes[1].frames), (Some(0.0), 2));
        // a refused frame has no drift of its own
        assert_eq!((shown.drift.clone(), shown.why.as_deref()), (None, Some("no part in the field")));
        assert_eq!(shown.refused["no_edge"], 1);
        health.take(&frame(0).to_string());
        let drift = health.shown(true).drift.unwrap();
        assert!((drift.u_drift_um - 0.7).abs() < 1e-12 && drift.since_zero_s == 3600.0, "{drift:?}");
        // of a source that is gone nothing is a reading of now
        let gone = health.shown(false);
        assert!(gone.window.is_none() && gone.drift.is_none() && !gone.minutes.is_empty());
        health.take("no JSON at all");
        assert_eq!(Health::default().shown(true), GaugeHealth { is_now: true, ..GaugeHealth::default() });
    }

    #[test]
    fn a_day_of_minutes_is_kept_and_no_more() {
        let mut taken = Taken::default();
        for k in 0..2000 {
            taken.line(&json!({ "valid": true, "columns": 1 }), Utc(k * MINUTE_MS));
        }
        assert_eq!((taken.minutes.len(), taken.minutes[0].begun_ms), (1440, 560 * MINUTE_MS));
    }
}
