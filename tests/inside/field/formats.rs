//! File formats of cameras and of other programs: depths, signs, stacks, channels.

use std::path::PathBuf;

use proptest::prelude::*;
use shadowgauge::frame::{FrameMeta, PixelFormat};
use shadowgauge::source::{Channel, DecodeError, Wanted, decode, decode_wanted};

use super::pictures::{Picture, Tiff, shaft};
use super::support::{collected, measured, shadowgauge};

fn values(bytes: &[u8]) -> Result<(Vec<f32>, PixelFormat, Option<f32>), DecodeError> {
    let frame = decode(bytes, None, FrameMeta::default())?;
    let view = frame.view();
    let all = (0..view.rows()).flat_map(|r| (0..view.columns()).map(move |c| (r, c)));
    Ok((all.filter_map(|(r, c)| view.get(r, c)).collect(), view.format(), view.full_scale()))
}

/// Samples packed without gaps, rows padded to whole bytes: by way of a string of binary digits.
fn packed(picture: &Picture) -> Vec<u8> {
    let bits = picture.bits as usize;
    let row = |row: &[u16]| {
        let mut digits: String = row.iter().map(|v| format!("{v:0bits$b}")).collect();
        digits.extend(std::iter::repeat_n('0', (8 - digits.len() % 8) % 8));
        let octets = (0..digits.len() / 8).map(|i| u8::from_str_radix(&digits[8 * i..8 * i + 8], 2).unwrap());
        octets.collect::<Vec<u8>>()
    };
    picture.values.chunks(picture.columns).flat_map(row).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Values of every depth, classic and BigTIFF, are unchanged.
    #[test]
    fn packed_tiffs_stand_as_they_are(
        bits in 1_u32..=15, columns in 1_usize..30, rows in 1_usize..9, big: bool, white_is_zero: bool, seed: u64,
    ) {
        let full = (1_u32 << bits) - 1;
        let value = |i: usize| ((seed.wrapping_mul(2 * i as u64 + 1) >> 33) as u32 & full) as u16;
        let picture = Picture { rows, columns, bits, values: (0..rows * columns).map(value).collect() };
        let mut file = Tiff::new(columns, rows, bits as u16, packed(&picture)).with_word(262, u16::from(!white_is_zero));
        file.big = big;
        let (found, _, scale) = values(&file.write()).unwrap();
        let right: Vec<f32> = picture.values.iter().map(|v| if white_is_zero { full as f32 - f32::from(*v) } else { f32::from(*v) }).collect();
        prop_assert_eq!(found, right);
        if bits != 8 {
            prop_assert_eq!(scale, Some(full as f32));
        }
    }

    /// Signs and floats, as exactly as f32 holds them.
    #[test]
    fn signed_and_floating_samples_stand_as_they_are(numbers in prop::collection::vec(-30_000_i16..30_000, 12), big: bool) {
        let right: Vec<f32> = numbers.iter().map(|v| f32::from(*v)).collect();
        type Bytes = fn(i16) -> Vec<u8>;
        let kinds: [(u16, u16, Bytes); 5] = [
            (16, 2, |v| v.to_le_bytes().to_vec()),
            (32, 2, |v| i32::from(v).to_le_bytes().to_vec()),
            (64, 2, |v| i64::from(v).to_le_bytes().to_vec()),
            (32, 3, |v| f32::from(v).to_le_bytes().to_vec()),
            (64, 3, |v| f64::from(v).to_le_bytes().to_vec()),
        ];
        for (bits, format, bytes) in kinds {
            let data = numbers.iter().flat_map(|v| bytes(*v)).collect();
            let mut file = Tiff::new(4, 3, bits, data).with_word(339, format);
            file.big = big;
            let (found, pixel_format, _) = values(&file.write()).unwrap();
            prop_assert_eq!(&found, &right, "{} bits, format {}", bits, format);
            prop_assert_eq!(pixel_format, PixelFormat::F32);
        }
    }

    /// A PGM's maxval is its full scale, whatever its value, and nothing is scaled to it.
    #[test]
    fn maxval_is_full_scale(maxval in 1_u32..=65_535, numbers in prop::collection::vec(0_u32..=65_535, 6), plain: bool) {
        let numbers: Vec<u32> = numbers.iter().map(|v| v % (maxval + 1)).collect();
        let mut bytes = format!("P{} # made here\n3 2\n{maxval}\n", if plain { 2 } else { 5 }).into_bytes();
        for v in &numbers {
            if plain {
                bytes.extend(format!("{v}\n").into_bytes());
            } else if maxval < 256 {
                bytes.push(*v as u8);
            } else {
                bytes.extend((*v as u16).to_be_bytes());
            }
        }
        let (found, _, full) = values(&bytes).unwrap();
        prop_assert_eq!(found, numbers.iter().map(|v| *v as f32).collect::<Vec<_>>());
        prop_assert_eq!(full, Some(maxval as f32));
    }
}

#[test]
fn half_floats_pam_and_pfm_are_read() {
    // 1.5, -2, 0.25, 1000 in binary16 (IEEE 754).
    let halves = [0x3e00_u16, 0xc000, 0x3400, 0x63d0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let (found, ..) = values(&Tiff::new(2, 2, 16, halves).with_word(339, 3).write()).unwrap();
    assert_eq!(found, [1.5, -2.0, 0.25, 1000.0]);
    let pam =
        b"P7\nWIDTH 2\nHEIGHT 1\nDEPTH 2\nMAXVAL 100\nTUPLTYPE GRAYSCALE_ALPHA\nENDHDR\n\x07\x64\x32\x64";
    assert_eq!(values(pam).unwrap(), (vec![7.0, 50.0], PixelFormat::Mono8, Some(100.0)));
    let clear =
        b"P7\nWIDTH 2\nHEIGHT 1\nDEPTH 2\nMAXVAL 100\nTUPLTYPE GRAYSCALE_ALPHA\nENDHDR\n\x07\x64\x32\x63";
    assert_eq!(values(clear).unwrap_err(), DecodeError::Transparent { row: 0, column: 1 });
    // The lowest row stands first.
    let mut pfm = b"Pf\n1 2\n-1.0\n".to_vec();
    pfm.extend([7.5_f32, -3.0].iter().flat_map(|v| v.to_le_bytes()));
    assert_eq!(values(&pfm).unwrap().0, [-3.0, 7.5]);
}

#[test]
fn what_does_not_fit_its_own_header_is_refused() {
    for (bytes, words) in [
        (b"P5\n2 2\n100\n\x01\x02\x03\x65".to_vec(), "a grey value of 101 above the file's maxval 100"),
        (b"P5\n2 2\n70000\n\x01\x02\x03\x04".to_vec(), "maxval 70000; it lies from 1 to 65535"),
        (b"P5\n2 2\n255\n\x01\x02\x03".to_vec(), "3 of 4 bytes of pixels"),
        (b"P2\n2 1\n9\n3 x\n".to_vec(), "no number for a pixel"),
        (Tiff::new(2, 2, 8, vec![1; 4]).with_word(262, 5).write(), "CMYK"),
        (Tiff::new(2, 2, 8, vec![1; 4]).with_word(259, 50_001).write(), "compressed by"),
        (Tiff::new(2, 2, 24, vec![1; 12]).with_word(339, 3).write(), "float samples of 24 bits"),
        (Tiff::new(2, 2, 16, vec![1; 8]).with_word(339, 2).with_word(262, 0).write(), "white is zero"),
        (Tiff::new(2, 2, 12, vec![1; 6]).with_word(317, 2).write(), "12 bits a sample with a predictor"),
    ] {
        let said = values(&bytes).unwrap_err().to_string();
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn significant_bits_of_a_png_are_its_full_scale() {
    let own = Picture { rows: 1, columns: 4, bits: 16, values: vec![5, 4095, 1234, 1235] };
    let sbit = |picture: &Picture| values(&picture.png(&[(*b"sBIT", vec![12])])).unwrap();
    let right = (vec![5.0, 4095.0, 1234.0, 1235.0], PixelFormat::Mono12, Some(4095.0));
    assert_eq!(sbit(&own), right);
    // As in the standard: shifted up, with the upper bits repeated below.
    let spread = Picture { values: own.values.iter().map(|v| v << 4 | v >> 8).collect(), ..own };
    assert_eq!(sbit(&spread), right);
}

#[test]
fn colours_are_grey_where_they_are_equal_or_one_is_chosen() {
    let pixels = [[9_u8, 9, 9], [200, 200, 200], [7, 8, 9], [1, 1, 1]];
    let tiff = |pixels: &[[u8; 3]]| {
        Tiff::new(2, pixels.len() / 2, 8, pixels.concat())
            .with_word(262, 2)
            .with_word(277, 3)
            .with_words(258, &[8; 3])
    };
    assert_eq!(values(&tiff(&pixels[..2]).write()).unwrap().0, [9.0, 200.0]);
    let coloured = tiff(&pixels).write();
    let refused = decode(&coloured, None, FrameMeta::default()).unwrap_err();
    assert_eq!(refused, DecodeError::Coloured { row: 1, column: 0, value: [7.0, 8.0, 9.0] });
    assert!(refused.to_string().contains("--channel r|g|b"), "{refused}");
    for (channel, right) in [(Channel::R, 7.0), (Channel::G, 8.0), (Channel::B, 9.0)] {
        let wanted = Wanted { channel: Some(channel), ..Wanted::default() };
        let decoded = decode_wanted(&coloured, &wanted, FrameMeta::default()).unwrap();
        assert_eq!(decoded.frame.view().get(1, 0), Some(right));
    }
    // A palette (all reds, all greens, all blues) of greys, and one of colours.
    let ramp: Vec<u16> = (0..256).map(|v| 257 * (255 - v)).collect();
    let palette = |green: &[u16]| {
        let map = [ramp.as_slice(), green, &ramp].concat();
        Tiff::new(3, 1, 8, vec![0, 1, 250]).with_word(262, 3).with_words(320, &map).write()
    };
    assert_eq!(values(&palette(&ramp)).unwrap().0, [255.0, 254.0, 5.0]);
    let shifted: Vec<u16> = ramp.iter().map(|v| v / 2).collect();
    assert!(matches!(values(&palette(&shifted)), Err(DecodeError::Coloured { .. })));
}

#[test]
fn stacks_thumbnails_and_channels_from_outside() {
    let folder = tempfile::tempdir().unwrap();
    let save = |name: &str, bytes: &[u8]| -> PathBuf {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let page = |width: f64| Picture::of(&shaft(100, 24, width, 1.2, width as u64), 100, 8, |l| l);
    let thumbnail = Tiff::new(2, 2, 8, vec![9; 4]).with_word(254, 1);
    let pages = page(40.4).tiff().and(&thumbnail).and(&page(42.4).tiff()).and(&page(44.4).tiff());
    let document = measured(&save("stack.tif", &pages.write()), &[]);
    let frames = document["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 3, "{document}");
    for (k, (frame, right)) in frames.iter().zip([40.4, 42.4, 44.4]).enumerate() {
        assert_eq!(frame["frame"], format!("stack#{k}"));
        let (found, u) = (frame["max_diameter_px"].as_f64().unwrap(), frame["u_max_px"].as_f64().unwrap());
        assert!((found - right).abs() < 5.0 * u + 0.02, "page {k}: {found} ± {u}");
    }
    // Red is dark everywhere, green shows the shaft.
    let shown = page(40.4);
    let pixels: Vec<u8> = shown.values.iter().flat_map(|v| [5, *v as u8, 90]).collect();
    let mut ppm = format!("P6\n{} {}\n255\n", shown.columns, shown.rows).into_bytes();
    ppm.extend(pixels);
    let colour = save("colour.ppm", &ppm);
    let document = measured(&colour, &["--channel", "g"]);
    assert!((document["frames"][0]["max_diameter_px"].as_f64().unwrap() - 40.4).abs() < 0.05, "{document}");
    let refused = shadowgauge(["measure".as_ref(), colour.as_os_str()]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(3));
    assert!(said.contains("--channel"), "{said}");
}

#[test]
fn the_collected_files_are_measured() {
    for name in ["pgm", "tiff"] {
        let Some(folder) = collected(name) else { return };
        let document = measured(&folder, &[]);
        let (found, u) = (
            document["frames"][0]["max_diameter_px"].as_f64().unwrap(),
            document["frames"][0]["u_max_px"].as_f64().unwrap(),
        );
        assert!((found - 60.4).abs() < 3.0 * u, "{name}: {found} ± {u}");
    }
}
