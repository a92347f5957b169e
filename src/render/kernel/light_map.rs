//! Uneven light for the kernel.
//!
//! A pixel's mean grey value is `shadow + contrast · light · field · clear`: `light` the share past
//! the edges, `field` the vignetting and the gradient of the backlight
//! ([`FieldLight`](crate::render::lens::FieldLight)), `clear` the transmission of the
//! contamination. Stray light in the shadow is uniform over the field and not affected.
//!
//! Contamination is stored as 16-bit factors, two per 32-bit word, 2¹⁵ for clear light, with an
//! error of 1.5e-5 of the light. Clean cells of 32 pixels of a row are flagged, written once and
//! never read.

/// The 16-bit factor of clear light.
pub(crate) const CLEAR: f32 = 32_768.0;

/// Two factors of clear light.
const CLEAR_WORD: u32 = 0x8000_8000;

/// Pixels of a row that share a flag.
pub(crate) const CELL: usize = 32;

/// Words of a cell.
const CELL_WORDS: usize = CELL / 2;

/// 16-bit factors of a window and the mask of what dims them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightMap {
    /// Two factors per word, rows padded to whole words.
    pub words: Vec<u32>,
    /// Bits of [`crate::render::contamination::mask`], row-major; empty where not requested.
    pub mask: Vec<u8>,
    /// Whether a factor of a cell of [`CELL`] pixels differs from clear light, row-major.
    pub touched: Vec<bool>,
    /// Pixels per row.
    pub columns: usize,
}

/// Several whole rows of a map.
pub(crate) struct Lines<'a> {
    pub words: &'a mut [u32],
    pub touched: &'a mut [bool],
    pub columns: usize,
}

impl LightMap {
    /// This map with the rows of another of the same width beneath it.
    #[must_use]
    pub(crate) fn followed_by(mut self, other: &Self) -> Self {
        self.words.extend_from_slice(&other.words);
        self.mask.extend_from_slice(&other.mask);
        self.touched.extend_from_slice(&other.touched);
        self
    }

    /// Resizes to a window, keeping the allocations; the contents of a map of the same size stay
    /// valid.
    pub(crate) fn prepare(&mut self, rows: usize, columns: usize, with_mask: bool) {
        let (words, cells) = (rows * columns.div_ceil(2), rows * columns.div_ceil(CELL));
        if (self.words.len(), self.touched.len(), self.columns) != (words, cells, columns) {
            self.columns = columns;
            self.words.resize(words, CLEAR_WORD);
            self.touched.clear();
            self.touched.resize(cells, true);
        }
        self.mask.clear();
        self.mask.resize(if with_mask { rows * columns } else { 0 }, 0);
    }

    /// Whether a pixel of the cell that begins at `column` is dimmed.
    #[inline(always)]
    pub(crate) fn is_touched(&self, row: usize, column: usize) -> bool {
        self.touched[row * self.columns.div_ceil(CELL) + column / CELL]
    }
}

impl Lines<'_> {
    /// Packs the factors of these rows; `dimmed` states for every cell of a row whether it contains
    /// factors other than 1.
    #[inline(always)]
    pub(crate) fn pack(&mut self, values: &[f32], dimmed: &[bool]) {
        let lines = self.words.chunks_exact_mut(self.columns.div_ceil(2));
        let lines = lines.zip(self.touched.chunks_exact_mut(dimmed.len()));
        for ((words, touched), values) in lines.zip(values.chunks_exact(self.columns)) {
            let cells = words.chunks_mut(CELL_WORDS).zip(values.chunks(CELL));
            for (((words, values), touched), dimmed) in cells.zip(touched).zip(dimmed) {
                if *dimmed {
                    pack_cell(words, values);
                } else if *touched {
                    words.fill(CLEAR_WORD);
                }
                *touched = *dimmed;
            }
        }
    }
}

#[inline(always)]
fn pack_cell(words: &mut [u32], values: &[f32]) {
    let (pairs, rest) = values.as_chunks::<2>();
    for (word, [low, high]) in words.iter_mut().zip(pairs) {
        *word = factor(*low) | factor(*high) << 16;
    }
    if let (Some(word), [last]) = (words.last_mut(), rest) {
        *word = factor(*last);
    }
}

/// A factor in 2⁻¹⁵, rounded, at most 2.
#[inline(always)]
fn factor(value: f32) -> u32 {
    floor_to_u32((value * CLEAR + 0.5).clamp(0.0, 65_535.0))
}

/// Integer part of a number from 0 to 2²²: adding 2²³ rounds it, which vectorises, unlike a
/// saturating conversion.
#[inline(always)]
pub(crate) fn floor_to_u32(x: f32) -> u32 {
    let rounded = x + 8_388_608.0;
    let over = u32::from(rounded - 8_388_608.0 > x);
    (rounded.to_bits() & 0x007f_ffff) - over
}
