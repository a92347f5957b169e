//! Light that is not even, as the kernel reads it.
//!
//! A pixel's mean grey value is `shadow + contrast · light · field · clear`: `light` what the edges let pass, `field` the
//! vignetting and the gradient of the backlight ([`super::lens::FieldLight`]), `clear` what contamination leaves. Stray light in the
//! shadow is a veil over the whole field and stays as it is.
//!
//! Contamination comes as 16-bit factors, two to a 32-bit word, 2¹⁵ for clear light: they err by 1.5e-5 of the light.

use rayon::prelude::*;

use super::contamination::TransmissionMap;

/// The 16-bit factor of clear light.
pub const CLEAR: f32 = 32_768.0;

/// 16-bit factors of a window and the mask of what dims them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightMap {
    /// Two factors a word, rows padded to whole words.
    pub words: Vec<u32>,
    /// Bits of [`super::contamination::mask`], row-major.
    pub mask: Vec<u8>,
}

impl LightMap {
    /// This map with the rows of another of the same width beneath it.
    #[must_use]
    pub fn followed_by(mut self, other: &Self) -> Self {
        self.words.extend_from_slice(&other.words);
        self.mask.extend_from_slice(&other.mask);
        self
    }

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
