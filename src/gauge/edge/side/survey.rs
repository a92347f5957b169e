//! What the windows of one side state of levels, noise and the ends of the grey scale, before the
//! other side is known.

use super::scan::ScanWindows;
use crate::gauge::edge::estimation::censored::Ends;
use crate::gauge::edge::estimation::grey_ends::{self, Elsewhere};
use crate::gauge::edge::estimation::noise::Spread;
use crate::gauge::edge::estimation::side_survey::{GreyScaleLimits, SideSurvey};
use crate::gauge::edge::estimation::soft_knee;
use crate::gauge::edge::image::scan_windows::{LevelSums, Windows};
use crate::gauge::limit::limits;

limits! {
    /// What a side of the silhouette samples.
    SideSampleLimits = "side_samples";
    /// Differences looked at per level for the noise: its variance is then known to 3 %.
    noise: usize = 4096;
}

/// What is asked of a survey.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurveyRequest {
    pub(crate) scale: GreyScaleLimits,
    /// Whether the noise is that of the frame itself.
    pub(crate) estimates_noise: bool,
    /// Whether columns are copies of one another, whose grey values pile up wherever they lie.
    pub(crate) copies: bool,
    /// Whether grey values have their signs turned: a lit part before a dark ground.
    pub(crate) turned: bool,
}

/// Buffers of a survey.
#[derive(Clone, Debug, Default)]
pub(crate) struct SurveyBuffers {
    pub(crate) floats: Vec<f32>,
    differences: Vec<f32>,
}

/// Surveys a side; light that falls off plainly beside its edges is levelled in the windows.
pub(crate) fn survey(
    scan: &mut ScanWindows,
    request: SurveyRequest,
    buffers: &mut SurveyBuffers,
) -> SideSurvey {
    let windows = &scan.windows;
    let levels = windows.level_sums();
    let mut spread = [Spread::default(); 2];
    let least = request.scale.least((levels.light - levels.dark) / levels.count.max(1.0));
    if request.estimates_noise && levels.count > 0.0 {
        spread =
            [false, true].map(|in_light| self::spread(windows, in_light, least, &mut buffers.differences));
    }
    let ends = if levels.count > 0.0 && !request.copies {
        let (step, turned) = (request.scale.step(), request.turned);
        let search = EndSearch { windows, step, turned, levels, spread, least };
        search.ends(buffers)
    } else {
        None
    };
    // Clipped light states nothing of how it falls off; a clipped shadow leaves it as it is.
    if ends.is_none_or(|ends| !scan.gradient.is_clipped(ends.low, ends.high)) {
        let low = ends.map_or(f32::NEG_INFINITY, |ends| ends.low as f32);
        scan.gradient.level(&mut scan.windows, low);
    }
    match ends {
        // What is clipped does not scatter as it would.
        Some(Ends { high, .. }) if high.is_finite() => spread[1] = Spread::default(),
        Some(_) => spread[0] = Spread::default(),
        None => {}
    }
    SideSurvey { levels, ends, spread }
}

fn spread(windows: &Windows, in_light: bool, least: f32, differences: &mut Vec<f32>) -> Spread {
    collect_differences(windows, in_light, differences);
    Spread::of(differences, least)
}

/// Differences of neighbouring columns' flat pixels, thinned to about half of `side_samples.noise`.
fn collect_differences(windows: &Windows, in_light: bool, out: &mut Vec<f32>) {
    let (columns, flat, width) = (windows.centre.len(), windows.flat, windows.width);
    let first = if in_light { width - 1 - flat } else { 0 };
    let step = (columns * flat).div_ceil(SideSampleLimits::get().noise / 2).max(2);
    out.resize(columns.div_ceil(step) * flat, 0.0);
    let mut places = out.chunks_exact_mut(flat);
    let mut taken = 0;
    for column in (0..columns.saturating_sub(1)).step_by(step) {
        if windows.centre[column].is_err() || windows.centre[column + 1].is_err() {
            continue;
        }
        let (a, b) = windows.pixels[column * width..(column + 2) * width].split_at(width);
        let Some(place) = places.next() else { break };
        for ((difference, a), b) in place.iter_mut().zip(&a[first..]).zip(&b[first..]) {
            *difference = a - b;
        }
        taken += flat;
    }
    out.truncate(taken);
}

/// A side whose ends of the grey scale are looked for.
struct EndSearch<'a> {
    windows: &'a Windows,
    /// Step of the grey scale, counts.
    step: f64,
    turned: bool,
    levels: LevelSums,
    spread: [Spread; 2],
    /// Smallest scale of differences, counts.
    least: f32,
}

impl EndSearch<'_> {
    /// Where the grey values of the side are clipped.
    fn ends(&self, buffers: &mut SurveyBuffers) -> Option<Ends> {
        use grey_ends::Level::{Dark, Light};
        let SurveyBuffers { floats, differences } = buffers;
        let clear = |level, pool: &mut Vec<f32>| !grey_ends::may_end(self.windows, level, pool);
        // Compressed light scatters less than the dark; a glance, for most frames.
        let bends = matches!(self.spread.map(Spread::variance), [Some(dark), Some(light)] if light < dark);
        if clear(Light, floats) & clear(Dark, floats) && !bends {
            return None;
        }
        let noise = [false, true].map(|in_light| {
            let known = self.spread[usize::from(in_light)].variance();
            let own = || spread(self.windows, in_light, self.least, differences).variance();
            known.or_else(own).map_or(f64::NAN, f64::sqrt)
        });
        let mean = [self.levels.dark, self.levels.light].map(|sum| sum / self.levels.count);
        let elsewhere = Elsewhere { noise, levels: mean, step: self.step, turned: self.turned };
        let squares = differences;
        let mut find =
            |level| grey_ends::find_end(self.windows, level, &elsewhere, (&mut *floats, &mut *squares));
        let (low, high) = (find(Dark), find(Light));
        let knee = soft_knee::find(self.windows, high.map(|(end, _)| end), &elsewhere, squares);
        Ends::of(low, knee.or(high))
    }
}
