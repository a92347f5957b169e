//! A grey picture that is drawn on in colours.

use glam::DVec2;

/// RGB, 8 bits.
pub(super) struct Canvas {
    pixels: Vec<u8>,
    rows: usize,
    columns: usize,
}

impl Canvas {
    /// Of the grey value of every (row, column).
    pub(super) fn new((rows, columns): (usize, usize), grey: impl Fn(usize, usize) -> u8) -> Self {
        let pixels = (0..rows * columns).flat_map(|k| [grey(k / columns, k % columns); 3]).collect();
        Self { pixels, rows, columns }
    }

    /// Colours the pixel at a place, (column, row); none outside of the picture.
    pub(super) fn dot(&mut self, place: DVec2, colour: [u8; 3]) {
        let p = place.round();
        if p.x >= 0.0 && p.y >= 0.0 && p.x < self.columns as f64 && p.y < self.rows as f64 {
            let at = 3 * (p.y as usize * self.columns + p.x as usize);
            self.pixels[at..at + 3].copy_from_slice(&colour);
        }
    }

    /// As PNG.
    ///
    /// # Errors
    /// Where the encoder refuses it, as text.
    pub(super) fn png(&self) -> Result<Vec<u8>, String> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.columns as u32, self.rows as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&self.pixels));
        written.map_err(|e| e.to_string())?;
        Ok(file)
    }
}
