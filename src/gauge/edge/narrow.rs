//! Frames of fewer than sixteen columns: readings of a line camera, whose levels, noise and blur
//! are pooled over the readings of a stream.
//!
//! One column shows both edges, and no more of levels, noise and blur than its own pixels. The last
//! readings of a stream, side by side, are a picture with all that an area camera's columns show:
//! differences of neighbouring readings carry temporal noise alone (a pixel's own response is the
//! same in both), levels and blur are shared by all of them. A reading is therefore measured within
//! the picture of itself and those before it. Neighbours there are neighbours in time, not along
//! the part: an edge may lie anywhere from one reading to the next, so that neither slopes nor
//! departures from neighbours are looked for. Before sixteen readings have come, those there are
//! stand in the picture more than once, and the noise is that of neighbouring pixels of the light
//! and of the shadow.

use super::refusals::explain::refused;
use super::stream::{AreaStream, StreamLimits};
use super::stream_settings::ColumnKind;
use crate::frame::{FrameView, PixelFormat, Pixels};
use crate::gauge::edge::estimation::model_bias::ResidualAccumulator;
use crate::gauge::edges::{FrameEdges, FrameRefused};
use crate::gauge::limit::limits;
use crate::gauge::settings::{GaugeSettings, Noise, Polarity, Rejection};
use crate::numerics::robust::MEDIAN_TO_SD;
use crate::profile::Reason;

limits! {
    /// How readings of a line camera are pooled.
    NarrowLimits = "narrow";
    /// Readings that are pooled: their levels are then known to a fifth of one reading's, and the
    /// noise to 3 % from ten flat pixels each.
    pooled: usize = 32;
    /// Share of the pixels of the light, or of the shadow, at one grey value from which on it is
    /// clipped or shows no noise to show by: of Gaussian noise of one count's standard deviation,
    /// two fifths stand at one value.
    piled: f64 = 0.6;
    /// Range, counts, beyond which the other half of the line is noisy: two grey steps are
    /// rounding's.
    noisy: f64 = 2.0;
}

/// Readings one after the other, in the container they came in.
#[derive(Clone, Debug)]
enum Lines {
    U8(Vec<u8>),
    U16(Vec<u16>),
    F32(Vec<f32>),
}

/// What a stream of narrow frames keeps.
#[derive(Clone, Debug)]
pub(crate) struct Narrow {
    settings: GaugeSettings,
    pooled: Box<AreaStream>,
    lines: Lines,
    format: PixelFormat,
    rows: usize,
    /// Readings kept.
    count: usize,
    /// Readings kept that no accumulator has seen.
    untaught: usize,
    edges: FrameEdges,
}

impl Lines {
    fn of(pixels: &Pixels<'_>) -> Self {
        match pixels {
            Pixels::U8(_) => Self::U8(Vec::new()),
            Pixels::U16(_) => Self::U16(Vec::new()),
            Pixels::F32(_) => Self::F32(Vec::new()),
        }
    }

    fn pixels(&self) -> Pixels<'_> {
        match self {
            Self::U8(lines) => Pixels::U8(lines),
            Self::U16(lines) => Pixels::U16(lines),
            Self::F32(lines) => Pixels::F32(lines),
        }
    }

    /// Appends the columns of a view; false for another container.
    fn push(&mut self, view: &FrameView<'_>) -> bool {
        match (self, view.pixels()) {
            (Self::U8(lines), Pixels::U8(pixels)) => append(lines, pixels, view),
            (Self::U16(lines), Pixels::U16(pixels)) => append(lines, pixels, view),
            (Self::F32(lines), Pixels::F32(pixels)) => append(lines, pixels, view),
            _ => return false,
        }
        true
    }

    /// Appends values that stand there already, or takes them off the front.
    fn repeat(&mut self, from: usize, length: usize) {
        match self {
            Self::U8(lines) => lines.extend_from_within(from..from + length),
            Self::U16(lines) => lines.extend_from_within(from..from + length),
            Self::F32(lines) => lines.extend_from_within(from..from + length),
        }
    }

    fn drop_front(&mut self, length: usize) {
        match self {
            Self::U8(lines) => drop(lines.drain(..length)),
            Self::U16(lines) => drop(lines.drain(..length)),
            Self::F32(lines) => drop(lines.drain(..length)),
        }
    }

    fn truncate(&mut self, length: usize) {
        match self {
            Self::U8(lines) => lines.truncate(length),
            Self::U16(lines) => lines.truncate(length),
            Self::F32(lines) => lines.truncate(length),
        }
    }
}

fn append<T: Copy>(lines: &mut Vec<T>, pixels: &[T], view: &FrameView<'_>) {
    for column in 0..view.columns() {
        let first = column * view.column_stride();
        lines.extend(pixels[first..].iter().step_by(view.row_stride()).take(view.rows()));
    }
}

/// The largest grey value, or the smallest, where most pixels of its half stand at it while the
/// other half is noisy.
fn piled_up(values: &[f64]) -> Option<f64> {
    let limits = NarrowLimits::get();
    let (least, most) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (l.min(*v), m.max(*v)));
    let middle = 0.5 * (least + most);
    let share = |light: bool, end: f64| {
        let (mut at, mut all) = (0.0, 0.0_f64);
        for value in values.iter().filter(|v| (**v > middle) == light) {
            at += f64::from(u8::from(*value == end));
            all += 1.0;
        }
        at / all.max(1.0)
    };
    let range = |light: bool| {
        let half = values.iter().filter(|v| (**v > middle) == light && **v != least && **v != most);
        let quarter = half.copied().map(|v| (v - if light { most } else { least }).abs());
        quarter.filter(|d| *d < 0.2 * (most - least)).fold(0.0, f64::max)
    };
    if share(true, most) > limits.piled && range(false) > limits.noisy {
        return Some(most);
    }
    (share(false, least) > limits.piled && range(true) > limits.noisy).then_some(least)
}

impl Narrow {
    /// Settings under which neighbours are independent of each other.
    fn pooled_settings(settings: &GaugeSettings) -> GaugeSettings {
        let rejection = if settings.rejection == Rejection::Off { Rejection::Off } else { Rejection::ByEdge };
        GaugeSettings { rejection, outlier_px: 1e4, ..settings.clone() }
    }

    pub(crate) fn new(stream: &AreaStream, view: &FrameView<'_>) -> Self {
        let settings = stream.settings().clone();
        let pooled = of_readings(stream, Self::pooled_settings(&settings));
        Self {
            settings,
            pooled: Box::new(pooled),
            lines: Lines::of(&view.pixels()),
            format: view.format(),
            rows: view.rows(),
            count: 0,
            untaught: 0,
            edges: FrameEdges::default(),
        }
    }

    /// Whether the picture has no room for another frame of `columns`.
    pub(crate) fn is_full_for(&self, columns: usize) -> bool {
        self.count + columns > NarrowLimits::get().pooled
    }

    /// Measures the picture anew, from the search on; false where it does not hold just `columns`
    /// readings, or is refused.
    pub(crate) fn settle(&mut self, columns: usize) -> bool {
        if columns == 0 || columns != self.count {
            return false;
        }
        self.pooled.restart();
        self.measure_picture().is_ok()
    }

    fn measure_picture(&mut self) -> Result<(), FrameRefused> {
        if self.count < StreamLimits::get().least_columns { self.few() } else { self.many() }
    }

    /// Whether a view is of the camera whose readings are kept.
    pub(crate) fn fits(&self, view: &FrameView<'_>) -> bool {
        (self.rows, self.format) == (view.rows(), view.format())
    }

    /// Measures a frame's columns among the readings before them.
    pub(crate) fn measure(&mut self, view: &FrameView<'_>, out: &mut FrameEdges) -> Result<(), FrameRefused> {
        let limits = NarrowLimits::get();
        let columns = view.columns();
        if self.count + columns > limits.pooled {
            let gone = self.count + columns - limits.pooled;
            self.lines.drop_front(gone * self.rows);
            self.count -= gone;
        }
        if !self.lines.push(view) {
            *self = Self::new(&of_readings(&self.pooled, self.settings.clone()), view);
            self.lines.push(view);
        }
        self.count += columns;
        let measured = self.measure_picture();
        if measured.is_err() {
            // A reading that cannot be measured does not spoil those after it.
            self.count -= columns;
            self.lines.truncate(self.count * self.rows);
        }
        measured?;
        self.untaught += columns;
        self.give(self.count - columns..self.count, out);
        Ok(())
    }

    /// Takes the noise as given; whether the picture holds copies of readings.
    fn set_noise(&mut self, noise: Noise, copies: bool) {
        self.pooled.set_noise(noise, ColumnKind { level_lines: true, copies });
    }

    fn many(&mut self) -> Result<(), FrameRefused> {
        self.set_noise(self.settings.noise, false);
        self.measure_lines(self.count)
    }

    /// Measures fewer readings than a picture needs: repeated, with the noise of neighbouring
    /// pixels.
    fn few(&mut self) -> Result<(), FrameRefused> {
        let (values, least) = (self.values(), StreamLimits::get().least_columns);
        if let Some(level) = piled_up(&values) {
            return Err(refused(
                Reason::Saturated,
                format!(
                    "the light or the shadow of a reading by itself stands at {level} counts in most of its pixels, as what is clipped does; {least} readings of a stream tell, or expose less"
                ),
            ));
        }
        let noise = match self.settings.noise {
            Noise::Estimated {} => self.noise_of_pixels(&values),
            given => given,
        };
        self.set_noise(noise, true);
        for copy in self.count..least {
            self.lines.repeat((copy - self.count) * self.rows, self.rows);
        }
        let measured = self.measure_lines(least);
        self.lines.truncate(self.count * self.rows);
        measured?;
        // Levels are known from the readings that there are, not from their copies.
        let copies = (least as f32 / self.count as f32).sqrt();
        let edges = self.edges.top.iter_mut().chain(&mut self.edges.bottom);
        edges.for_each(|edge| edge.u_shared_px *= copies);
        Ok(())
    }

    fn measure_lines(&mut self, count: usize) -> Result<(), FrameRefused> {
        let view = FrameView::new(self.lines.pixels(), self.format, count, self.rows, self.rows);
        match view {
            Ok(view) => self.pooled.measure(&view.transposed(), &mut self.edges),
            Err(error) => Err(refused(Reason::Unreadable, error.to_string())),
        }
    }

    /// All grey values kept, reading after reading.
    fn values(&self) -> Vec<f64> {
        match &self.lines {
            Lines::U8(lines) => lines.iter().map(|v| f64::from(*v)).collect(),
            Lines::U16(lines) => lines.iter().map(|v| f64::from(*v)).collect(),
            Lines::F32(lines) => lines.iter().map(|v| f64::from(*v)).collect(),
        }
    }

    /// Noise of neighbouring pixels, in the darker and in the lighter half of the grey values.
    fn noise_of_pixels(&self, values: &[f64]) -> Noise {
        let (least, most) =
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (l.min(*v), m.max(*v)));
        let middle = 0.5 * (least + most);
        let half = |light: bool| {
            let (mut differences, mut sum) = (Vec::new(), 0.0);
            for line in values.chunks_exact(self.rows) {
                for pair in line.windows(2).filter(|p| p.iter().all(|v| (*v > middle) == light)) {
                    differences.push((pair[1] - pair[0]).abs());
                    sum += pair[0];
                }
            }
            let (count, place) = (differences.len(), differences.len() / 2);
            if count == 0 {
                return (if light { most } else { least }, 1.0 / 12.0);
            }
            let (_, median, _) = differences.select_nth_unstable_by(place, f64::total_cmp);
            (sum / count as f64, 0.5 * (MEDIAN_TO_SD * *median).powi(2).max(1.0 / 6.0))
        };
        let (dark, light) = (half(false), half(true));
        let gain = ((light.1 - dark.1) / (light.0 - dark.0).max(1e-9)).abs().max(1e-9);
        let sign = if self.settings.polarity == Polarity::DarkOnBright { dark } else { light };
        Noise::PhotonTransfer {
            gain_counts_per_electron: gain,
            read_noise_counts: dark.1.min(light.1).sqrt(),
            black_counts: sign.0.min(light.0),
        }
    }

    /// Columns of the picture.
    pub(crate) fn give(&self, columns: std::ops::Range<usize>, out: &mut FrameEdges) {
        out.clone_from(&self.edges);
        for (line, all) in [(&mut out.top, &self.edges.top), (&mut out.bottom, &self.edges.bottom)] {
            line.clear();
            line.extend_from_slice(&all[columns.clone()]);
        }
    }

    /// Adds what the readings just measured leave of the edge model, where none has been added
    /// before.
    pub(crate) fn accumulate(&mut self, residuals: &mut ResidualAccumulator) {
        if self.untaught >= self.count && self.count >= StreamLimits::get().least_columns {
            self.untaught = 0;
            self.pooled.accumulate(residuals, &self.edges);
        }
    }
}

/// A stream of pictures made of readings, whose columns are neighbours in time.
fn of_readings(stream: &AreaStream, settings: GaugeSettings) -> AreaStream {
    stream.with_settings(settings, ColumnKind { level_lines: true, copies: false })
}
