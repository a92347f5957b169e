//! The loop from part to part: the ideal offsets of every pass, carried to the next part.
//!
//! Per station and pass, Holt's level and trend of the ideal offset i = o + e/g over the parts. A
//! new insert or a cold start sets the level back to what the first part after the last such event
//! needed; the trend (wear per part, warming per part) stays. The loop from pass to pass then
//! corrects the remainder.

use super::context::PartEvent;
use super::settings::PartsSettings;

/// Ideal offset of a station, mm.
#[derive(Clone, Copy, Debug)]
struct IdealOffset {
    level: f64,
    /// Change from part to part.
    trend: f64,
    /// That of the first part after each kind of event.
    after_insert: f64,
    after_cold: f64,
}

/// The pass of one number, across the parts.
#[derive(Clone, Debug, Default)]
struct PassMemory {
    stations: Vec<IdealOffset>,
}

impl PassMemory {
    fn forecast(&self) -> Vec<f64> {
        self.stations.iter().map(|s| s.level + s.trend).collect()
    }

    fn restart(&mut self, event: PartEvent) {
        for station in &mut self.stations {
            let first = match event {
                PartEvent::Continued => return,
                PartEvent::InsertChanged => station.after_insert,
                PartEvent::ColdStart => station.after_cold,
            };
            station.level = first - station.trend;
        }
    }

    fn record(&mut self, ideal: &[f64], event: PartEvent, settings: &PartsSettings) {
        if self.stations.is_empty() {
            // the very first part stands for both events until one occurs
            let first = |&i: &f64| IdealOffset { level: i, trend: 0.0, after_insert: i, after_cold: i };
            self.stations = ideal.iter().map(first).collect();
            return;
        }
        // the step at an event is no evidence of a trend
        let trend_weight = if event == PartEvent::Continued { settings.trend_weight } else { 0.0 };
        for (IdealOffset { level, trend, after_insert, after_cold }, i) in self.stations.iter_mut().zip(ideal)
        {
            match event {
                PartEvent::Continued => {}
                PartEvent::InsertChanged => *after_insert = *i,
                PartEvent::ColdStart => *after_cold = *i,
            }
            let forecast = *level + *trend;
            let next = forecast + settings.level_weight * (i - forecast);
            *trend += trend_weight * (next - *level - *trend);
            *level = next;
        }
    }
}

/// State of all passes across the parts.
#[derive(Clone, Debug)]
pub(crate) struct PartLoop {
    settings: PartsSettings,
    passes: Vec<PassMemory>,
    /// Forecast for the current part, by pass.
    forecast: Vec<Vec<f64>>,
    event: PartEvent,
}

impl PartLoop {
    pub(crate) fn new(settings: &PartsSettings) -> Self {
        Self {
            settings: settings.clone(),
            passes: Vec::new(),
            forecast: Vec::new(),
            event: PartEvent::default(),
        }
    }

    /// A new part begins; forecasts its passes.
    pub(crate) fn begin(&mut self, event: PartEvent) {
        self.event = event;
        if self.settings.enabled {
            self.passes.iter_mut().for_each(|p| p.restart(event));
            self.forecast = self.passes.iter().map(PassMemory::forecast).collect();
        }
    }

    /// Offsets forecast for a pass (from 1), where earlier parts had it.
    pub(crate) fn forecast(&self, pass: u32) -> Option<&[f64]> {
        let index = (pass as usize).checked_sub(1)?;
        self.forecast.get(index).filter(|f| !f.is_empty()).map(Vec::as_slice)
    }

    /// Stores the offset that a pass should have had.
    pub(crate) fn record(&mut self, pass: u32, in_force: &[f64], errors: &[f64], gain: f64) {
        let Some(index) = (pass as usize).checked_sub(1).filter(|_| self.settings.enabled) else {
            return;
        };
        if self.passes.len() <= index {
            self.passes.resize_with(index + 1, PassMemory::default);
        }
        let ideal: Vec<f64> = in_force.iter().zip(errors).map(|(o, e)| o + e / gain).collect();
        self.passes[index].record(&ideal, self.event, &self.settings);
    }
}
