//! Light that is not even, as the kernel reads it.
//!
//! A pixel's mean grey value is `shadow + contrast · light · field · clear`: `light` what the edges let pass, `field` the
//! vignetting and the gradient of the backlight ([`FieldLight`]), `clear` what contamination leaves. Stray light in the
//! shadow is a veil over the whole field and stays as it is.
//!
//! Along a row the field's factor is a polynomial of sixth order in the distance u from the axis. With v fixed,
//! `V = a + b u² + c u⁴` and `1 + gu u + gv v - s r² = d + gu u - s u²`, whose product has the coefficients below.
//! Contamination comes as 16-bit factors, two to a 32-bit word, 2¹⁵ for clear light: they err by 1.5e-5 of the light.

use rayon::prelude::*;

use super::contamination::TransmissionMap;
use super::lens::FieldLight;

/// The 16-bit factor of clear light.
pub const CLEAR: f32 = 32_768.0;

/// Coefficients of one row's field light over u, ascending.
pub fn row_light(light: &FieldLight, row: usize, sensor: [usize; 2]) -> [f32; 7] {
    let [rows, columns] = sensor.map(|n| n as f64);
    let v = (row as f64 - 0.5 * (rows - 1.0)) / (0.5 * rows.hypot(columns));
    let v2 = v * v;
    let (second, fourth) = (light.vignetting_2, light.vignetting_4);
    let (a, b, c) = (1.0 - v2 * (second + v2 * fourth), -(second + 2.0 * v2 * fourth), -fourth);
    let (gain, sag) = (light.gradient_along, light.sag);
    let d = 1.0 + light.gradient_down * v - sag * v2;
    [a * d, a * gain, b * d - a * sag, b * gain, c * d - b * sag, c * gain, -c * sag].map(|k| k as f32)
}

/// 16-bit factors of a window and the mask of what dims them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightMap {
    /// Two factors a word, rows padded to whole words.
    pub words: Vec<u32>,
    /// Bits of [`super::contamination::mask`], row-major.
    pub mask: Vec<u8>,
}

impl LightMap {
    /// Packs a transmission map into this one, keeping its allocations.
    pub fn pack(&mut self, map: &TransmissionMap) {
        let columns = map.columns();
        let words = columns.div_ceil(2);
        self.words.resize(map.rows() * words, 0);
        self.mask.clear();
        self.mask.extend_from_slice(map.mask());
        if columns == 0 {
            return;
        }
        let lines = self.words.par_chunks_mut(words).zip(map.values().par_chunks(columns));
        lines.with_min_len(64).for_each(|(line, values)| {
            let (pairs, rest) = values.as_chunks::<2>();
            for (word, [low, high]) in line.iter_mut().zip(pairs) {
                *word = factor(*low) | factor(*high) << 16;
            }
            if let (Some(word), [last]) = (line.last_mut(), rest) {
                *word = factor(*last);
            }
        });
    }
}

/// A factor in 2⁻¹⁵, rounded, at most 2.
fn factor(value: f32) -> u32 {
    (value * CLEAR + 0.5).clamp(0.0, 65_535.0) as u32
}
