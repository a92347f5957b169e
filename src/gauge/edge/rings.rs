//! Clipped rings: the shadow of an edge in coherent light without a lens, exposed beyond the end of
//! the grey scale.
//!
//! Past an edge in a laser's light the grey values rise to 1.37 times the bright field, fall to
//! 0.78 of it, rise to 1.20 and so on (Fresnel's half plane; Born & Wolf, 8.7.3). Where the crests
//! are clipped, a window shorter than a crest shows a level that is none, and an edge placed by it
//! lies tens of micrometres off with a small uncertainty. Two signs of it: a crest cut flat inside
//! the windows of a pattern that is known, and, beside light that is clipped, light that falls and
//! rises again.

use super::image::window_layout::half;
use super::refusals::explain::refused;
use crate::gauge::edge::estimation::censored::Ends;
use crate::gauge::edge::image::plane::{Plane, Sample};
use crate::gauge::edge::image::scan_windows::{Side, Windows};
use crate::gauge::edge::model::edge_spread::EdgeSpreadFunction;
use crate::gauge::edges::FrameRefused;
use crate::gauge::limit::limits;
use crate::profile::Reason;

limits! {
    /// When the rings of coherent light are clipped.
    RingLimits = "rings";
    /// Columns looked at: a share of three quarters is known to 5 % from 64.
    looked_at: usize = 64;
    /// Pixels beyond the windows in which rings are looked for: the first three of a pattern whose
    /// unit √(λz/2) is 100 px.
    beyond_px: usize = 384;
    /// Share of the clipped contrast by which the light must fall and rise again: the first valley
    /// lies 0.59 of the bright field below the first crest and 0.42 below the second; light that a
    /// lamp leaves uneven does not rise again, and what a lens in partially coherent light leaves
    /// of rings is less.
    swing: f64 = 0.1;
    /// Light below this share of the clipped contrast is no valley between rings but another
    /// shadow: the first valley has 0.78 of the bright field, 0.57 of a scale that ends at the
    /// crest.
    deepest: f64 = 0.35;
    /// Pixels in a row at the same largest grey value that make a crest cut flat: rounding leaves
    /// two equal. Tuned: see study limits.
    cut: usize = 3;
    /// Share of the columns that must show one: a single clipped column is a hot pixel beside a
    /// crest. Tuned: see study limits.
    most_columns: f64 = 0.75;
    /// Relative difference of widths of a ringed pattern below which windows serve both: a fifth of
    /// a radian at its farthest ring.
    same_width: f64 = 2e-3;
    /// Factor of the contrast by which a row among rings must depart from its neighbours to be a
    /// stuck one, over that in even light: a narrow valley lies 0.6 of the contrast below its
    /// crests.
    ring_to_ring: f32 = 4.0;
}

/// Whether windows laid out for one width of a pattern do not serve another: flat ends that see
/// rings see others then.
pub(crate) fn differ(shape: &EdgeSpreadFunction, one: f64, other: f64) -> bool {
    shape.is_ringed() && (one / other).ln().abs() > RingLimits::get().same_width
}

/// The contrast by which stuck rows are found.
pub(crate) fn stuck_contrast(shape: &EdgeSpreadFunction, contrast: f32) -> f32 {
    if shape.is_ringed() { RingLimits::get().ring_to_ring * contrast } else { contrast }
}

/// A side whose rings are checked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RingedSide<'a> {
    pub(crate) windows: &'a Windows,
    /// Whether the edge-spread function fitted has rings.
    pub(crate) is_ringed: bool,
    pub(crate) ends: Option<Ends>,
}

/// Checks that no ring is clipped: without the crests the position of the edge is not determined.
///
/// # Errors
/// Refuses a frame whose crests are cut, known pattern or not.
pub(crate) fn check<T: Sample>(plane: &Plane<'_, T>, sides: [RingedSide<'_>; 2]) -> Result<(), FrameRefused> {
    for RingedSide { windows, is_ringed, ends } in sides {
        let level = if is_ringed {
            clipped_crest(windows).or(ends.map(|e| if e.high.is_finite() { e.high } else { e.low } as f32))
        } else {
            rings_beyond(plane, windows, ends)
        };
        if let Some(level) = level {
            return Err(refused(
                Reason::Saturated,
                format!(
                    "the rings beside an edge in coherent light are clipped at {} counts, and what is missing of them hides where it lies; the first one has 1.37 times the light of the bright field: expose less, to 0.7 of the scale or below",
                    plane.sign * level
                ),
            ));
        }
    }
    Ok(())
}

/// Columns with a window, thinned.
fn looked_at(windows: &Windows) -> impl Iterator<Item = usize> + '_ {
    let step = windows.centre.len().div_ceil(RingLimits::get().looked_at).max(1);
    (0..windows.centre.len()).step_by(step).filter(|c| windows.centre[*c].is_ok())
}

/// The grey value at which crests inside the windows are cut flat; `None` where they are whole.
fn clipped_crest(windows: &Windows) -> Option<f32> {
    let limits = RingLimits::get();
    let used = windows.width.checked_sub(1)?;
    let most = |column: usize| windows.of(column)[..used].iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let level = looked_at(windows).map(most).fold(f32::NEG_INFINITY, f32::max);
    let (mut cut, mut all) = (0_usize, 0_usize);
    for column in looked_at(windows) {
        let longest = windows.of(column)[..used].chunk_by(|a, b| a == b).filter(|run| run[0] == level);
        cut += usize::from(longest.map(<[f32]>::len).max().unwrap_or(0) >= limits.cut);
        all += 1;
    }
    (all > 0 && cut as f64 >= limits.most_columns * all as f64).then_some(level)
}

/// The grey value at which light beside the edges is clipped, where that light falls and rises
/// again farther out.
fn rings_beyond<T: Sample>(plane: &Plane<'_, T>, windows: &Windows, ends: Option<Ends>) -> Option<f32> {
    let limits = RingLimits::get();
    let high = ends.filter(|e| e.high.is_finite())?.high;
    let profile = mean_profile(plane, windows);
    let (mut dark, mut count) = (0.0, 0.0);
    for column in looked_at(windows) {
        (dark, count) = (dark + f64::from(windows.dark[column]), count + 1.0);
    }
    let contrast = high - dark / f64::max(count, 1.0);
    let mut valley = f64::INFINITY;
    for value in profile {
        valley = valley.min(value);
        if high - valley > (1.0 - limits.deepest) * contrast {
            return None;
        }
        if high - valley > limits.swing * contrast && value - valley > limits.swing * contrast {
            return Some(high as f32);
        }
    }
    None
}

/// Mean grey values outwards from the edges' own windows over the columns looked at, to the border
/// of the field.
fn mean_profile<T: Sample>(plane: &Plane<'_, T>, windows: &Windows) -> Vec<f64> {
    let limits = RingLimits::get();
    let (down, sign) = (windows.side == Side::Bottom, windows.side.sign());
    let ahead = (windows.width - half(windows.width)) as i32;
    let room = |centre: i32| if down { plane.rows as i32 - 1 - centre } else { centre };
    let centres = looked_at(windows).filter_map(|c| windows.centre[c].ok());
    let length =
        centres.map(|centre| room(centre) - ahead).min().unwrap_or(0).clamp(0, limits.beyond_px as i32)
            as usize;
    let mut sums = vec![0.0; length];
    let mut line = vec![0.0_f32; length];
    let mut count = 0.0;
    for column in looked_at(windows) {
        let Ok(centre) = windows.centre[column] else { continue };
        if plane.gather((centre + sign * ahead) as isize, down, column, &mut line) {
            sums.iter_mut().zip(&line).for_each(|(sum, value)| *sum += f64::from(*value));
            count += 1.0;
        }
    }
    sums.iter_mut().for_each(|sum| *sum /= f64::max(count, 1.0));
    sums
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};
    use rand_pcg::Pcg64;

    use super::*;

    const COLUMNS: usize = 64;
    const WIDTH: usize = 48;

    /// Windows over the first crest and its valleys, 13 px apart, of 10 bits, in light of so many
    /// counts by column: 1.37 of it at the crest and 0.78 in the valleys.
    fn crests(light: impl Fn(usize) -> f64) -> Windows {
        let mut random = Pcg64::seed_from_u64(7);
        let noise = Normal::new(0.0, 3.0).unwrap();
        let mut windows = Windows::new(Side::Bottom);
        windows.width = WIDTH;
        windows.centre = vec![Ok(100); COLUMNS];
        for column in 0..COLUMNS {
            for row in 0..WIDTH {
                let phase = std::f64::consts::PI * (row as f64 - 24.0) / 13.0;
                let value = light(column) * (1.075 + 0.295 * phase.cos()) + noise.sample(&mut random);
                windows.pixels.push(value.round().min(1023.0) as f32);
            }
        }
        windows
    }

    /// A film over a fifth of the columns keeps their crests below the end of the scale: the
    /// others are clipped all the same.
    #[test]
    fn crests_cut_in_four_columns_of_five_are_clipped() {
        let filmed = |column: usize| if column < 13 { 640.0 } else { 800.0 };
        assert_eq!(clipped_crest(&crests(filmed)), Some(1023.0));
        assert_eq!(clipped_crest(&crests(|_| 700.0)), None);
    }
}
