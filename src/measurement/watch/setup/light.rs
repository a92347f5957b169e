//! How a frame uses the grey scale, and the exposure that would use it well.

use crate::frame::FrameView;

/// Rows and columns that are looked at, at most: a quarter of a million pixels.
const MOST: usize = 512;
/// Share of the pixels that may be brighter than the level stated: contamination that glints and
/// defects are fewer.
const BRIGHTEST: f64 = 1e-3;
/// Share of full scale that the brightest light should have: up to 0.95 the response is tested to
/// be linear (EMVA 1288), and a light that ages or warms changes by some per cent until the next
/// look.
const GOOD: f64 = 0.8;

/// Use of the grey scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Light {
    /// Level that 0.1 % of the pixels exceed, counts.
    pub brightest: f64,
    /// The same as a share of full scale, where that is known.
    pub of_full_scale: Option<f64>,
    /// Share of the pixels at full scale.
    pub saturated_share: f64,
    /// Factor of the exposure that brings the brightest light to 0.8 of full scale; `None` where
    /// it is saturated, or nothing is lit.
    pub exposure_factor: Option<f64>,
}

impl Light {
    /// The use of a frame; `black` is the grey value without light.
    pub(super) fn of(view: &FrameView<'_>, black: f64) -> Self {
        let (by_row, by_column) = (view.rows().div_ceil(MOST), view.columns().div_ceil(MOST));
        let rows = (0..view.rows()).step_by(by_row);
        let places = rows.flat_map(|row| (0..view.columns()).step_by(by_column).map(move |c| (row, c)));
        let mut greys: Vec<f32> = places.filter_map(|(row, column)| view.get(row, column)).collect();
        let full = view.full_scale();
        let saturated = full.map_or(0, |full| greys.iter().filter(|grey| **grey >= full).count());
        let count = greys.len().max(1);
        let rank = ((1.0 - BRIGHTEST) * (count - 1) as f64) as usize;
        let brightest =
            if greys.is_empty() { 0.0 } else { *greys.select_nth_unstable_by(rank, f32::total_cmp).1 };
        let (brightest, full) = (f64::from(brightest), full.map(f64::from));
        let factor = |full: f64| (GOOD * full - black) / (brightest - black);
        let is_lit = |full: &f64| brightest < *full && brightest > black;
        Self {
            brightest,
            of_full_scale: full.map(|full| brightest / full),
            saturated_share: saturated as f64 / count as f64,
            exposure_factor: full.filter(is_lit).map(factor),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{PixelFormat, Pixels};

    #[test]
    fn light_is_counted_and_the_exposure_proportional() {
        // 2 of 10 000 pixels glint at full scale; the rest is 110, of which 10 is black.
        let mut pixels = vec![110_u8; 10_000];
        (pixels[17], pixels[5000]) = (255, 255);
        let view = FrameView::new(Pixels::U8(&pixels), PixelFormat::Mono8, 100, 100, 100).unwrap();
        let light = Light::of(&view, 10.0);
        assert_eq!((light.brightest, light.saturated_share), (110.0, 2e-4));
        // (204 − 10)/(110 − 10)
        assert!((light.exposure_factor.unwrap() - 1.94).abs() < 1e-12, "{light:?}");
        let white = vec![255_u8; 100];
        let view = FrameView::new(Pixels::U8(&white), PixelFormat::Mono8, 10, 10, 10).unwrap();
        let light = Light::of(&view, 10.0);
        assert_eq!((light.saturated_share, light.exposure_factor), (1.0, None));
        let dark = vec![10_u8; 100];
        let view = FrameView::new(Pixels::U8(&dark), PixelFormat::Mono8, 10, 10, 10).unwrap();
        assert_eq!(Light::of(&view, 10.0).exposure_factor, None);
    }
}
