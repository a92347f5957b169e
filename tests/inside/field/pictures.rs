//! Images of a shaft, and files written byte by byte as by other programs.
#![allow(dead_code, reason = "not every module writes every file")]

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Light of a level shaft of `width` px in the middle of `rows`, 0.05 to 0.8 of full scale, its
/// edges blurred by `sigma` px; row by row.
pub(crate) fn shaft(rows: usize, columns: usize, width: f64, sigma: f64, seed: u64) -> Vec<f64> {
    let mut rng = Pcg64::seed_from_u64(seed);
    let middle = (rows as f64 - 1.0) / 2.0;
    let mut light = Vec::with_capacity(rows * columns);
    for row in 0..rows {
        let outside = (row as f64 - middle).abs() - width / 2.0;
        let share = 0.5 * (1.0 + libm::erf(outside / (sigma * std::f64::consts::SQRT_2)));
        // The sum of four uniform values is nearly normal, 0.004 of full scale.
        let mut noise = || (0..4).map(|_| rng.random_range(-1.0..1.0)).sum::<f64>() * 0.0035;
        light.extend((0..columns).map(|_| (0.05 + 0.75 * share + noise()).clamp(0.0, 1.0)));
    }
    light
}

/// Grey values of some bits, row by row.
#[derive(Clone)]
pub(crate) struct Picture {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) bits: u32,
    pub(crate) values: Vec<u16>,
}

impl Picture {
    /// An image of light, through an encoding of shares of full scale.
    pub(crate) fn of(light: &[f64], rows: usize, bits: u32, encode: impl Fn(f64) -> f64) -> Self {
        let full = f64::from((1_u32 << bits) - 1);
        let values = light.iter().map(|l| (full * encode(*l)).round() as u16).collect();
        Self { rows, columns: light.len() / rows, bits, values }
    }

    /// Values as bytes: one up to 8 bits, otherwise two.
    fn bytes(&self, big_endian: bool) -> Vec<u8> {
        let two = |v: &u16| if big_endian { v.to_be_bytes() } else { v.to_le_bytes() };
        if self.bits <= 8 {
            self.values.iter().map(|v| *v as u8).collect()
        } else {
            self.values.iter().flat_map(two).collect()
        }
    }

    /// A grey PNG of 8 or 16 bits with further chunks before its pixels.
    pub(crate) fn png(&self, chunks: &[([u8; 4], Vec<u8>)]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.columns as u32, self.rows as u32);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(if self.bits > 8 { png::BitDepth::Sixteen } else { png::BitDepth::Eight });
        let mut writer = encoder.write_header().unwrap();
        for (name, data) in chunks {
            writer.write_chunk(png::chunk::ChunkType(*name), data).unwrap();
        }
        writer.write_image_data(&self.bytes(true)).unwrap();
        writer.finish().unwrap();
        bytes
    }

    /// A raw PGM of this full scale.
    pub(crate) fn pgm(&self, maxval: u32) -> Vec<u8> {
        let mut bytes = format!("P5\n# of a camera\n{} {}\n{maxval}\n", self.columns, self.rows).into_bytes();
        bytes.extend(self.bytes(true));
        bytes
    }

    /// A TIFF of this picture in whole bytes.
    pub(crate) fn tiff(&self) -> Tiff {
        Tiff::new(self.columns, self.rows, if self.bits > 8 { 16 } else { 8 }, self.bytes(false))
    }
}

/// A TIFF or BigTIFF with one strip per page, little-endian.
#[derive(Clone)]
pub(crate) struct Tiff {
    pub(crate) big: bool,
    pub(crate) pages: Vec<Page>,
}

#[derive(Clone)]
pub(crate) struct Page {
    pub(crate) data: Vec<u8>,
    /// Tag, type, count, and the values' bytes.
    pub(crate) tags: Vec<(u16, u16, u64, Vec<u8>)>,
}

impl Tiff {
    pub(crate) fn new(columns: usize, rows: usize, bits: u16, data: Vec<u8>) -> Self {
        Self { big: false, pages: vec![Page { data, tags: Vec::new() }] }
            .with_word(256, columns as u16)
            .with_word(257, rows as u16)
            .with_word(258, bits)
            .with_word(259, 1)
            .with_word(262, 1)
            .with_word(277, 1)
            .with_word(278, rows as u16)
    }

    /// Sets a tag of 16-bit numbers.
    pub(crate) fn with_words(mut self, tag: u16, words: &[u16]) -> Self {
        let bytes = words.iter().flat_map(|w| w.to_le_bytes()).collect();
        for page in &mut self.pages {
            page.tags.retain(|t| t.0 != tag);
            page.tags.push((tag, 3, words.len() as u64, Vec::clone(&bytes)));
        }
        self
    }

    pub(crate) fn with_word(self, tag: u16, word: u16) -> Self {
        self.with_words(tag, &[word])
    }

    /// Sets a tag of one ratio.
    pub(crate) fn with_ratio(mut self, tag: u16, above: u32, below: u32) -> Self {
        let bytes = [above.to_le_bytes(), below.to_le_bytes()].concat();
        self.pages.iter_mut().for_each(|p| p.tags.push((tag, 5, 1, bytes.clone())));
        self
    }

    /// Appends the pages of another file.
    pub(crate) fn and(mut self, other: &Self) -> Self {
        self.pages.extend(other.pages.clone());
        self
    }

    /// The file.
    pub(crate) fn write(&self) -> Vec<u8> {
        let size = if self.big { 8 } else { 4 };
        let number = |value: u64, size: usize| value.to_le_bytes()[..size].to_vec();
        let mut file = if self.big { b"II\x2b\0\x08\0\0\0".to_vec() } else { b"II\x2a\0".to_vec() };
        // Position at which the offset of the next directory is written.
        let mut link = file.len();
        file.extend(vec![0; size]);
        for page in &self.pages {
            let data_at = file.len() as u64;
            file.extend(&page.data);
            let mut tags = page.tags.clone();
            tags.push((273, 4, 1, number(data_at, 4)));
            tags.push((279, 4, 1, number(page.data.len() as u64, 4)));
            tags.sort_by_key(|t| t.0);
            let mut fields = Vec::new();
            for (_, _, _, bytes) in &tags {
                let mut field = bytes.clone();
                if bytes.len() > size {
                    field = number(file.len() as u64, size);
                    file.extend(bytes);
                }
                field.resize(size, 0);
                fields.push(field);
            }
            let at = number(file.len() as u64, size);
            file[link..link + size].copy_from_slice(&at);
            file.extend(number(tags.len() as u64, if self.big { 8 } else { 2 }));
            for ((tag, kind, count, _), field) in tags.iter().zip(&fields) {
                file.extend(number((*tag).into(), 2));
                file.extend(number((*kind).into(), 2));
                file.extend(number(*count, size));
                file.extend(field);
            }
            link = file.len();
            file.extend(vec![0; size]);
        }
        file
    }
}
