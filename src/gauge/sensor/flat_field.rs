//! Dark and flat field: defective pixels, and the light's slow fall-off over the field.
//!
//! ```text
//! m' = black + (m − black)·l_min/l(u, v)   l: quadratic surface of the flat field, maximum 1
//! ```
//!
//! so that no pixel is pushed beyond full scale; a saturated pixel stays saturated. A defective
//! pixel is interpolated from its nearest good neighbours along the shaft (see
//! `defect_correction`), where the picture hardly changes. Pixel-to-pixel response (PRNU) is
//! reported, not divided out: at .5 % it adds as much as the shot noise of 40 000 electrons, once
//! per edge, and averages over columns as noise does, while a map of it would carry the noise of
//! the flats that it was made from.

use crate::numerics::robust::{MEDIAN_TO_SD, upper_median};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::defect_correction::{Grey, ShaftRuns, interpolate_defects};
use super::response::Response;
use crate::frame::{Frame, FrameView, PixelsMut};
use crate::gauge::limit::limits;

limits! {
    /// When pixels are defective and light is even.
    FlatFieldLimits = "flat_field";
    /// Departure from the others, in robust standard deviations, above which a pixel is defective:
    /// 10⁻¹⁵ of a normal distribution.
    defect_sigmas: f64 = 8.0;
    /// Fall-off up to which the light is not corrected: its gradient moves an edge by σ²·l'/l, well
    /// below 1e-3 px.
    even: f64 = 0.01;
    /// Least light that still shows a part, of the brightest: noise over contrast is 1.8 to 3.3
    /// times as large there. Named in what is refused.
    darkest: f64 = 0.3;
    /// Rounding of a surface that was scaled to 1 at its brightest: of f64 it is below 1e-12, of a
    /// file with seven digits below 1e-6.
    light_rounding: f64 = 1e-6;
    /// Share of the pixels, above which they are no defects but a wrong picture. Named in what is
    /// refused. Tuned: see study limits.
    most_defects: f64 = 0.01;
    /// Pixels that the surface is fitted to, along either side: 16 384 for six coefficients, which
    /// noise then moves by √6/128 of its own, a fiftieth.
    grid: usize = 128;
}

/// Corrections of a sensor and its light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FlatField {
    /// Rows of the frames.
    pub rows: usize,
    /// Columns of the frames.
    pub columns: usize,
    /// Grey value without light, counts.
    pub black_counts: f64,
    /// Light over the field relative to its brightest: 1, u, v, u², uv, v² with u, v from −1 to 1.
    pub light: [f64; 6],
    /// Brightest minus darkest of that surface.
    pub fall_off: f64,
    /// Defective pixels, (row, column), sorted.
    pub defects: Vec<[u32; 2]>,
    /// Pixel-to-pixel response PRNU, relative standard deviation, light's surface taken off.
    pub prnu_rel: f64,
    /// Pixel-to-pixel dark signal DSNU, counts.
    pub dsnu_counts: f64,
    /// A response that is not linear, undone before all else; black, light and defects are those of
    /// linearised frames.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub response: Option<Response>,
}

/// Why there is no flat field.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub(crate) enum FlatFieldError {
    /// Nothing to make it from.
    #[error(
        "{what}: no frame; at least 2 are needed, so that their noise can be told from the pixels' own pattern"
    )]
    TooFew {
        /// `dark` or `flat`.
        what: &'static str,
    },
    /// Frames of different sizes.
    #[error(
        "{what} frame {index} has {rows} rows x {columns} columns, the first {first_rows} x {first_columns}"
    )]
    Size {
        /// `dark` or `flat`.
        what: &'static str,
        /// Its index.
        index: usize,
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// Rows of the first.
        first_rows: usize,
        /// Columns of the first.
        first_columns: usize,
    },
    /// The flat field is not flat.
    #[error("the flat field falls to {darkest:.2} of its brightest: something stands in the light")]
    NotFlat {
        /// Darkest over brightest.
        darkest: f64,
    },
    /// The flat field is clipped or dark.
    #[error(
        "the flat field stands {signal:.1} counts above dark, {clipped:.4} of its pixels at full scale; expose it between 30 and 90 % of full scale"
    )]
    Exposure {
        /// Its signal.
        signal: f64,
        /// Clipped share.
        clipped: f64,
    },
    /// Too many defects.
    #[error(
        "{found} of {pixels} pixels would be defective: these are no dark and flat fields of this sensor"
    )]
    Defects {
        /// Pixels found.
        found: usize,
        /// Pixels there are.
        pixels: usize,
    },
}

/// Mean frame of several of one size.
struct Mean {
    rows: usize,
    columns: usize,
    values: Vec<f32>,
    /// Temporal variance of the mean, counts².
    variance: f64,
    /// Share of the frames' pixels at full scale: in their mean a pixel that is clipped now and
    /// then lies below it.
    clipped: f64,
}

impl Mean {
    fn of(frames: &[FrameView<'_>], what: &'static str) -> Result<Self, FlatFieldError> {
        let [first, _, ..] = frames else { return Err(FlatFieldError::TooFew { what }) };
        let (rows, columns) = (first.rows(), first.columns());
        let mut sum = vec![0.0_f32; rows * columns];
        let (mut squares, mut clipped) = (0.0, 0_usize);
        for (index, frame) in frames.iter().enumerate() {
            if (frame.rows(), frame.columns()) != (rows, columns) {
                return Err(FlatFieldError::Size {
                    what,
                    index,
                    rows: frame.rows(),
                    columns: frame.columns(),
                    first_rows: rows,
                    first_columns: columns,
                });
            }
            let full = frame.full_scale().unwrap_or(f32::INFINITY);
            for (i, s) in sum.iter_mut().enumerate() {
                let value = frame.get(i / columns, i % columns).unwrap_or(0.0);
                // Differences from the first frame carry the noise of both.
                let before = first.get(i / columns, i % columns).unwrap_or(0.0);
                squares += f64::from(value - before).powi(2);
                clipped += usize::from(value >= full);
                *s += value;
            }
        }
        let n = frames.len() as f32;
        sum.iter_mut().for_each(|s| *s /= n);
        let pixels = (rows * columns) as f64;
        let variance = squares / (2.0 * pixels * f64::from(n - 1.0)) / f64::from(n);
        let clipped = clipped as f64 / (pixels * f64::from(n));
        Ok(Self { rows, columns, values: sum, variance, clipped })
    }
}

fn median(values: &mut [f32]) -> f64 {
    upper_median(values, f32::total_cmp).map_or(0.0, f64::from)
}

/// Median and robust standard deviation.
fn spread(values: &[f32]) -> (f64, f64) {
    let mut work = values.to_vec();
    let middle = median(&mut work);
    work.iter_mut().for_each(|v| *v = (*v - middle as f32).abs());
    (middle, MEDIAN_TO_SD * median(&mut work))
}

fn basis(u: f64, v: f64) -> [f64; 6] {
    [1.0, u, v, u * u, u * v, v * v]
}

/// Coordinate from −1 to 1.
pub(super) fn unit(index: usize, n: usize) -> f64 {
    if n > 1 { 2.0 * index as f64 / (n - 1) as f64 - 1.0 } else { 0.0 }
}

impl FlatField {
    /// From two or more dark frames and two or more flat ones at one exposure.
    ///
    /// # Errors
    /// Too few frames, sizes that differ, a flat field that is clipped, dark or not flat, a sensor
    /// with defects everywhere.
    pub(crate) fn new(dark: &[FrameView<'_>], flat: &[FrameView<'_>]) -> Result<Self, FlatFieldError> {
        let limits = FlatFieldLimits::get();
        let darks = Mean::of(dark, "dark")?;
        let flats = Mean::of(flat, "flat")?;
        if (darks.rows, darks.columns) != (flats.rows, flats.columns) {
            return Err(FlatFieldError::Size {
                what: "flat",
                index: 0,
                rows: flats.rows,
                columns: flats.columns,
                first_rows: darks.rows,
                first_columns: darks.columns,
            });
        }
        let (black_counts, dark_spread) = spread(&darks.values);
        let (rows, columns) = (darks.rows, darks.columns);
        let clipped = flats.clipped;
        let (level, _) = spread(&flats.values);
        let signal = level - black_counts;
        if !(signal > 10.0 * dark_spread.max(0.5)) || clipped > 0.01 {
            return Err(FlatFieldError::Exposure { signal, clipped });
        }
        let mut light = surface(&flats, black_counts);
        let at = |light: &[f64; 6], r: usize, c: usize| value(light, unit(c, columns), unit(r, rows));
        let (low, high) = extremes(&light);
        light.iter_mut().for_each(|l| *l /= high);
        if low / high < limits.darkest {
            return Err(FlatFieldError::NotFlat { darkest: low / high });
        }
        let response: Vec<f32> = flats
            .values
            .iter()
            .enumerate()
            .map(|(i, m)| {
                ((f64::from(*m) - black_counts) / (high * at(&light, i / columns, i % columns)) - 1.0) as f32
            })
            .collect();
        let (_, prnu) = spread(&response);
        let defects = defects(&darks, &response, (black_counts, dark_spread), prnu)?;
        let noise = (flats.variance + darks.variance).sqrt() / signal;
        Ok(Self {
            rows,
            columns,
            black_counts,
            light,
            fall_off: 1.0 - low / high,
            defects,
            prnu_rel: (prnu * prnu - noise * noise).max(0.0).sqrt(),
            dsnu_counts: (dark_spread * dark_spread - darks.variance).max(0.0).sqrt(),
            response: None,
        })
    }

    /// Keeps the response that the frames it was made from were linearised by.
    #[must_use]
    pub(crate) fn with_response(self, response: Option<Response>) -> Self {
        Self { response, ..self }
    }

    /// Names a surface of light that would divide by 0 or contradicts its own fall-off: (key,
    /// value, what would be right).
    pub(crate) fn impossible_light(&self) -> Option<(&'static str, f64, &'static str)> {
        let limits = FlatFieldLimits::get();
        let (low, high) = extremes(&self.light);
        let wrong = [low, high]
            .into_iter()
            .find(|l| !(limits.darkest - limits.light_rounding..=1.0 + limits.light_rounding).contains(l));
        if let Some(value) = wrong {
            return Some(("bench.flat_field.light", value, "a surface from 0.3 to 1 all over the field"));
        }
        let fall_off = 1.0 - low / high;
        let off = (self.fall_off - fall_off).abs();
        (!(off <= limits.light_rounding)).then_some((
            "bench.flat_field.fall_off",
            self.fall_off,
            "what `light` falls by, 0 to 0.7",
        ))
    }

    /// Names a defective pixel that is none of the frame's, or is out of order.
    pub(crate) fn impossible_defects(&self) -> Option<(&'static str, f64, &'static str)> {
        let key = "bench.flat_field.defects";
        let most = FlatFieldLimits::get().most_defects * self.rows as f64 * self.columns as f64;
        if self.defects.len() as f64 > most {
            return Some((key, self.defects.len() as f64, "at most 1 % of the pixels"));
        }
        let outside = self.defects.iter().find_map(|[r, c]| {
            let row = (*r as usize >= self.rows).then_some(*r);
            row.or_else(|| (*c as usize >= self.columns).then_some(*c))
        });
        if let Some(value) = outside {
            return Some((key, f64::from(value), "rows and columns of the frame"));
        }
        let unsorted = self.defects.windows(2).find(|pair| pair[0] >= pair[1]);
        unsorted.map(|pair| (key, f64::from(pair[1][0]), "every pixel once, by row and column"))
    }

    /// Whether the light is uneven enough to be corrected.
    pub(crate) fn corrects_light(&self) -> bool {
        self.fall_off > FlatFieldLimits::get().even
    }

    /// Corrects a frame of the size calibrated whose shaft lies level, in its own format; other
    /// sizes stay as they are.
    #[must_use]
    pub(crate) fn corrected(&self, frame: Frame) -> Frame {
        self.corrected_along(frame, ShaftRuns::AlongRows)
    }

    /// As [`Self::corrected`], of a shaft that runs so.
    #[must_use]
    pub(crate) fn corrected_along(&self, frame: Frame, shaft: ShaftRuns) -> Frame {
        let view = frame.view();
        if (view.rows(), view.columns()) != (self.rows, self.columns) {
            return frame;
        }
        let mut frame = match &self.response {
            Some(response) => response.linearised(frame),
            None => frame,
        };
        let view = frame.view();
        let full = view.full_scale().unwrap_or(f32::INFINITY);
        match frame.pixels_mut() {
            PixelsMut::U8(p) => self.correct(p, full, shaft),
            PixelsMut::U16(p) => self.correct(p, full, shaft),
            PixelsMut::F32(p) => self.correct(p, full, shaft),
        }
        frame
    }

    fn correct<T: Grey>(&self, pixels: &mut [T], full: f32, shaft: ShaftRuns) {
        interpolate_defects(pixels, self.columns, &self.defects, shaft);
        if !self.corrects_light() {
            return;
        }
        let darkest = 1.0 - self.fall_off;
        let black = self.black_counts as f32;
        for (r, row) in pixels.chunks_exact_mut(self.columns).enumerate() {
            let v = unit(r, self.rows);
            let l = &self.light;
            // Along a row the surface is a parabola in u.
            let (c0, c1, c2) = (l[0] + l[2] * v + l[5] * v * v, l[1] + l[4] * v, l[3]);
            for (c, pixel) in row.iter_mut().enumerate() {
                let m = pixel.grey();
                if m < full {
                    let u = unit(c, self.columns);
                    let gain = (darkest / (c0 + u * (c1 + u * c2))) as f32;
                    *pixel = T::of(black + (m - black) * gain);
                }
            }
        }
    }
}

fn value(light: &[f64; 6], u: f64, v: f64) -> f64 {
    basis(u, v).iter().zip(light).map(|(b, l)| b * l).sum()
}

/// Least and greatest value of the surface over the field.
pub(super) fn extremes(light: &[f64; 6]) -> (f64, f64) {
    let at = |i: usize| unit(i, 33);
    (0..33 * 33)
        .map(|i| value(light, at(i % 33), at(i / 33)))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)))
}

/// Least-squares surface through a thinned frame above black; medians of small tiles keep dust and
/// defects out.
fn surface(flats: &Mean, black: f64) -> [f64; 6] {
    let limits = FlatFieldLimits::get();
    let (tile_rows, tile_columns) = (flats.rows.div_ceil(limits.grid), flats.columns.div_ceil(limits.grid));
    let mut normal = DMatrix::<f64>::zeros(6, 6);
    let mut right = DVector::<f64>::zeros(6);
    let mut pool = Vec::new();
    for r in (0..flats.rows).step_by(tile_rows) {
        for c in (0..flats.columns).step_by(tile_columns) {
            pool.clear();
            let (to_row, to_column) =
                ((r + tile_rows).min(flats.rows), (c + tile_columns).min(flats.columns));
            for row in r..to_row {
                pool.extend_from_slice(
                    &flats.values[row * flats.columns + c..row * flats.columns + to_column],
                );
            }
            let middle = median(&mut pool) - black;
            let b = DVector::from_row_slice(&basis(
                unit((c + to_column - 1) / 2, flats.columns),
                unit((r + to_row - 1) / 2, flats.rows),
            ));
            right += &b * middle;
            normal += &b * b.transpose();
        }
    }
    normal.cholesky().map_or([right[0], 0.0, 0.0, 0.0, 0.0, 0.0], |n| {
        let x = n.solve(&right);
        std::array::from_fn(|i| x[i])
    })
}

fn defects(
    darks: &Mean,
    response: &[f32],
    (black, dark_spread): (f64, f64),
    prnu: f64,
) -> Result<Vec<[u32; 2]>, FlatFieldError> {
    let limits = FlatFieldLimits::get();
    let dark_limit = limits.defect_sigmas * dark_spread.max(0.25);
    let flat_limit = limits.defect_sigmas * prnu.max(1e-3);
    let defects: Vec<[u32; 2]> = darks
        .values
        .iter()
        .zip(response)
        .enumerate()
        .filter(|(_, (d, r))| {
            (f64::from(**d) - black).abs() > dark_limit || f64::from(**r).abs() > flat_limit
        })
        .map(|(i, _)| [(i / darks.columns) as u32, (i % darks.columns) as u32])
        .collect();
    let pixels = darks.values.len();
    if defects.len() as f64 > limits.most_defects * pixels as f64 {
        return Err(FlatFieldError::Defects { found: defects.len(), pixels });
    }
    Ok(defects)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::frame::{Buffer, FrameMeta, PixelFormat};

    const SIZE: (usize, usize) = (96, 160);

    fn frame(seed: u64, mean: impl Fn(usize, usize) -> f64) -> Frame {
        let mut rng = Pcg64::seed_from_u64(seed);
        let normal = Normal::new(0.0, 4.0).unwrap();
        let pixels = (0..SIZE.0 * SIZE.1)
            .map(|i| {
                (mean(i / SIZE.1, i % SIZE.1) + normal.sample(&mut rng)).round().clamp(0.0, 4095.0) as u16
            })
            .collect();
        Frame::new(Buffer::U16(pixels), PixelFormat::Mono12, SIZE.0, SIZE.1, FrameMeta::default()).unwrap()
    }

    fn light(r: usize, c: usize) -> f64 {
        let (u, v) = (unit(c, SIZE.1), unit(r, SIZE.0));
        1.0 - 0.06 * u - 0.09 * u * u - 0.05 * v * v
    }

    fn made() -> FlatField {
        let hot = |r: usize, c: usize| if (r, c) == (40, 70) { 300.0 } else { 0.0 };
        let dead = |r: usize, c: usize| if (r, c) == (7, 0) { 0.3 } else { 1.0 };
        let dark: Vec<Frame> = (0..6).map(|s| frame(s, |r, c| 64.0 + hot(r, c))).collect();
        let flat: Vec<Frame> =
            (10..16).map(|s| frame(s, |r, c| 64.0 + hot(r, c) + 2800.0 * dead(r, c) * light(r, c))).collect();
        let dark: Vec<FrameView<'_>> = dark.iter().map(Frame::view).collect();
        let flat: Vec<FrameView<'_>> = flat.iter().map(Frame::view).collect();
        FlatField::new(&dark, &flat).unwrap()
    }

    #[test]
    fn a_tilted_vignetted_field_becomes_even_and_defects_disappear() {
        let field = made();
        assert_eq!(field.defects, vec![[7, 0], [40, 70]]);
        assert!((field.black_counts - 64.0).abs() < 0.2 && field.prnu_rel < 5e-4, "{field:?}");
        let raw =
            frame(99, |r, c| 64.0 + 2000.0 * light(r, c) + if (r, c) == (40, 70) { 300.0 } else { 0.0 });
        let even = field.corrected(raw);
        let view = even.view();
        let all: Vec<f64> =
            (0..SIZE.0 * SIZE.1).filter_map(|i| view.get(i / SIZE.1, i % SIZE.1)).map(f64::from).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let worst = all.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max);
        // Noise of 4 counts: 4.6 standard deviations and the surface's own error.
        assert!(worst < 24.0, "{worst}");
    }

    #[test]
    fn saturated_pixels_stay_saturated() {
        let white = frame(5, |_, _| 9000.0);
        let view_is_full = |f: &Frame| f.view().get(3, 3) == Some(4095.0);
        assert!(view_is_full(&made().corrected(white)));
    }

    /// Light one standard deviation below full scale: 15.9 % of the pixels are clipped in every
    /// frame, hardly one in their mean.
    #[test]
    fn light_that_clips_now_and_then_is_refused_however_many_frames_there_are() {
        let dark: Vec<Frame> = (0..2).map(|s| frame(s, |_, _| 64.0)).collect();
        let dark: Vec<FrameView<'_>> = dark.iter().map(Frame::view).collect();
        for count in [2, 4, 8] {
            let flat: Vec<Frame> = (10..10 + count).map(|s| frame(s, |_, _| 4094.5 - 4.0)).collect();
            let flat: Vec<FrameView<'_>> = flat.iter().map(Frame::view).collect();
            match FlatField::new(&dark, &flat) {
                Err(FlatFieldError::Exposure { clipped, .. }) => {
                    assert!((clipped - 0.159).abs() < 0.01, "{count} frames: {clipped}");
                }
                other => panic!("{count} frames: {other:?}"),
            }
        }
    }

    #[test]
    fn what_is_no_flat_field_is_refused() {
        let dark: Vec<Frame> = (0..3).map(|s| frame(s, |_, _| 64.0)).collect();
        let shaded: Vec<Frame> =
            (3..6).map(|s| frame(s, |_, c| if c < 110 { 2000.0 } else { 100.0 })).collect();
        let dark: Vec<FrameView<'_>> = dark.iter().map(Frame::view).collect();
        let shaded: Vec<FrameView<'_>> = shaded.iter().map(Frame::view).collect();
        assert!(matches!(
            FlatField::new(&dark, &shaded),
            Err(FlatFieldError::NotFlat { .. } | FlatFieldError::Defects { .. })
        ));
        assert!(matches!(FlatField::new(&dark[..1], &shaded), Err(FlatFieldError::TooFew { what: "dark" })));
        assert!(matches!(FlatField::new(&dark, &dark), Err(FlatFieldError::Exposure { .. })));
    }
}
