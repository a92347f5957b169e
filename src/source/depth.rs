//! Determines full scale: stated in `frames.csv` or by the file (`maxval`, `sBIT`, bits per
//! sample), otherwise derived from the largest value. Grey values are not changed, except where the
//! writer of the file has spread them over the container (left-aligned, or scaled to its full
//! range): there the camera's own values are restored.

use super::error::DecodeError;
use super::raster::Stated;
use crate::frame::{Buffer, PixelFormat};

/// A frame's buffer with its format and its full scale.
#[derive(Debug, PartialEq)]
pub(super) struct Depth {
    pub(super) buffer: Buffer,
    pub(super) format: PixelFormat,
    pub(super) full_scale: Option<f32>,
}

/// Determines format and full scale; `table_bits` are those of `frames.csv`.
///
/// # Errors
/// Refuses unsupported bit depths, and values beyond the one stated in the table.
pub(super) fn settle(buffer: Buffer, table_bits: Option<u8>, stated: &Stated) -> Result<Depth, DecodeError> {
    match buffer {
        Buffer::F32(values) => floats(values, table_bits, stated.full_scale),
        Buffer::U8(values) => Ok(octets(values, stated.significant_bits, stated.full_scale)),
        Buffer::U16(values) => words(values, table_bits, stated),
    }
}

fn floats(values: Vec<f32>, table_bits: Option<u8>, full_scale: Option<f32>) -> Result<Depth, DecodeError> {
    let bits = table_bits.filter(|bits| *bits < 32);
    let stated = match bits.map(format_of).transpose()? {
        Some(format) => {
            let full = full_of(format);
            let most = values.iter().copied().fold(0.0, f32::max);
            if most > full {
                return Err(DecodeError::BeyondDepth { found: most.to_string(), bits: format.bit_depth() });
            }
            Some(full)
        }
        None => full_scale,
    };
    Ok(Depth { buffer: Buffer::F32(values), format: PixelFormat::F32, full_scale: stated })
}

fn octets(mut values: Vec<u8>, significant: Option<u8>, full_scale: Option<f32>) -> Depth {
    let bits = significant.filter(|b| (1..8).contains(b));
    let mut full = full_scale;
    if let Some(bits) = bits {
        let wide = |v: &u8| u16::from(*v);
        match spread(&values.iter().map(wide), 8, bits) {
            Some(spread) => {
                values.iter_mut().for_each(|v| *v = spread.own(wide(v)) as u8);
                full = Some(largest(bits) as f32);
            }
            None if values.iter().all(|v| wide(v) <= largest(bits)) => full = Some(f32::from(largest(bits))),
            None => {}
        }
    }
    Depth { buffer: Buffer::U8(values), format: PixelFormat::Mono8, full_scale: full }
}

fn words(mut values: Vec<u16>, table_bits: Option<u8>, stated: &Stated) -> Result<Depth, DecodeError> {
    let (significant, full_scale) = (stated.significant_bits, stated.full_scale);
    let most = stated.most.unwrap_or_else(|| values.iter().copied().fold(0, u16::max));
    if let Some(bits) = table_bits {
        let format = format_of(bits)?;
        if most > largest(bits) {
            let all = values.iter().copied();
            let spread = spread(&all, 16, bits)
                .ok_or_else(|| DecodeError::BeyondDepth { found: most.to_string(), bits })?;
            values.iter_mut().for_each(|v| *v = spread.own(*v));
        }
        let full = full_scale.filter(|full| *full < full_of(format));
        return Ok(sized(values, format, full));
    }
    if let Some(full) = full_scale {
        return Ok(sized(values, holding(full as u16), Some(full)));
    }
    if let Some(bits) = significant.filter(|b| (8..16).contains(b)) {
        if let Some(spread) = spread(&values.iter().copied(), 16, bits) {
            values.iter_mut().for_each(|v| *v = spread.own(*v));
            return Ok(sized(values, holding(largest(bits)), Some(f32::from(largest(bits)))));
        }
        if most <= largest(bits) {
            return Ok(sized(values, holding(largest(bits)), Some(f32::from(largest(bits)))));
        }
    }
    let format = if most <= 4095 { PixelFormat::Mono12 } else { PixelFormat::Mono16 };
    Ok(sized(values, format, None))
}

/// The frame in a format, eight bits in an 8-bit container. A full scale equal to the format's own
/// is not stored.
fn sized(values: Vec<u16>, format: PixelFormat, full_scale: Option<f32>) -> Depth {
    let full_scale = full_scale.filter(|full| *full != full_of(format));
    let buffer = if format == PixelFormat::Mono8 {
        Buffer::U8(values.into_iter().map(|v| v as u8).collect())
    } else {
        Buffer::U16(values)
    };
    Depth { buffer, format, full_scale }
}

fn format_of(bits: u8) -> Result<PixelFormat, DecodeError> {
    match bits {
        8 => Ok(PixelFormat::Mono8),
        10 => Ok(PixelFormat::Mono10),
        12 => Ok(PixelFormat::Mono12),
        14 => Ok(PixelFormat::Mono14),
        16 => Ok(PixelFormat::Mono16),
        other => Err(DecodeError::Depth(other)),
    }
}

/// The smallest format of 16-bit containers that holds a value.
fn holding(full: u16) -> PixelFormat {
    match full {
        0..=1023 => PixelFormat::Mono10,
        1024..=4095 => PixelFormat::Mono12,
        4096..=16_383 => PixelFormat::Mono14,
        _ => PixelFormat::Mono16,
    }
}

fn full_of(format: PixelFormat) -> f32 {
    format.full_scale().map_or(f32::INFINITY, f32::from)
}

fn largest(bits: u8) -> u16 {
    ((1_u32 << bits) - 1) as u16
}

/// How a writer has spread values of `bits` bits over a container.
#[derive(Clone, Copy, Debug)]
struct Spread {
    how: How,
    container: u8,
    bits: u8,
}

#[derive(Clone, Copy, Debug)]
enum How {
    /// Shifted up, zeros below.
    Shifted,
    /// Shifted up, with the upper bits repeated below (PNG 13.12).
    Repeated,
    /// Multiplied so that full scale is the container's.
    Scaled,
}

impl Spread {
    fn container_largest(self) -> u32 {
        u32::from(largest(self.container))
    }

    /// The camera's own value.
    fn own(self, value: u16) -> u16 {
        match self.how {
            How::Shifted | How::Repeated => value >> (self.container - self.bits),
            How::Scaled => {
                let full = self.container_largest();
                ((u32::from(value) * u32::from(largest(self.bits)) + full / 2) / full) as u16
            }
        }
    }

    /// The container's value for the camera's own one.
    fn spread(self, own: u16) -> u16 {
        let (wide, shift) = (u32::from(own), self.container - self.bits);
        let value = match self.how {
            How::Shifted => wide << shift,
            How::Repeated if self.bits >= shift => wide << shift | wide >> (self.bits - shift),
            How::Repeated => wide << shift | wide << (shift - self.bits),
            How::Scaled => {
                let full = u32::from(largest(self.bits));
                (wide * self.container_largest() + full / 2) / full
            }
        };
        value as u16
    }
}

/// The spreading that fits every value; `None` where none does, or all are 0.
fn spread(values: &(impl Iterator<Item = u16> + Clone), container: u8, bits: u8) -> Option<Spread> {
    let ways = [How::Shifted, How::Repeated, How::Scaled].map(|how| Spread { how, container, bits });
    let some = values.clone().any(|v| v > 0);
    ways.into_iter().find(|way| some && values.clone().all(|v| way.spread(way.own(v)) == v))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settled(values: &[u16], table: Option<u8>, significant: Option<u8>, full: Option<f32>) -> Depth {
        let stated = Stated { significant_bits: significant, full_scale: full, ..Stated::default() };
        settle(Buffer::U16(values.to_vec()), table, &stated).unwrap()
    }

    #[test]
    fn values_stand_as_they_are_and_full_scale_is_what_is_stated() {
        let own = [3_u16, 700, 1023, 512];
        for (table, significant, full, format, scale) in [
            (Some(10), None, None, PixelFormat::Mono10, None),
            (None, Some(10), None, PixelFormat::Mono10, None),
            (None, None, Some(1023.0), PixelFormat::Mono10, None),
            (None, None, Some(4000.0), PixelFormat::Mono12, Some(4000.0)),
            (None, None, Some(65_535.0), PixelFormat::Mono16, None),
            (None, Some(11), None, PixelFormat::Mono12, Some(2047.0)),
            (None, None, None, PixelFormat::Mono12, None),
        ] {
            let found = settled(&own, table, significant, full);
            let right = Depth { buffer: Buffer::U16(own.to_vec()), format, full_scale: scale };
            assert_eq!(found, right, "{table:?} {significant:?} {full:?}");
        }
    }

    #[test]
    fn spread_values_come_back() {
        for bits in [8_u8, 10, 12, 14] {
            for how in [How::Shifted, How::Repeated, How::Scaled] {
                let way = Spread { how, container: 16, bits };
                let own: Vec<u16> = (0..=largest(bits)).step_by(7).chain([largest(bits)]).collect();
                let wide: Vec<u16> = own.iter().map(|v| way.spread(*v)).collect();
                for found in [settled(&wide, Some(bits), None, None), settled(&wide, None, Some(bits), None)]
                {
                    let values: Vec<u16> = match found.buffer {
                        Buffer::U8(v) => v.into_iter().map(u16::from).collect(),
                        Buffer::U16(v) => v,
                        Buffer::F32(_) => panic!("no floats"),
                    };
                    assert_eq!(values, own, "{bits} bits, {how:?}");
                }
            }
        }
        // One value that does not fit: nothing is restored.
        let odd = [0x1230_u16, 0x4560, 0x4561];
        assert_eq!(settled(&odd, None, Some(12), None).buffer, Buffer::U16(odd.to_vec()));
        let beyond = settle(Buffer::U16(odd.to_vec()), Some(12), &Stated::default()).unwrap_err();
        assert_eq!(beyond, DecodeError::BeyondDepth { found: "17761".to_owned(), bits: 12 });
    }
}
