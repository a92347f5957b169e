//! Of a response that is not linear.

use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;

use super::*;
use crate::frame::{FrameMeta, PixelFormat};

const SIZE: (usize, usize) = (64, 96);
const BLACK: f64 = 64.0;

/// A 12-bit frame of light falling off by 30 % through a response, with noise of 3 counts.
fn frame(seed: u64, exposure: f64, response: &dyn Fn(f64) -> f64) -> Frame {
    let mut rng = Pcg64::seed_from_u64(seed);
    let normal = Normal::new(0.0, 3.0).unwrap();
    let pixels = (0..SIZE.0 * SIZE.1).map(|i| {
        let light = exposure * (1.0 - 0.3 * (i % SIZE.1) as f64 / SIZE.1 as f64);
        (BLACK + 4031.0 * response(light) + normal.sample(&mut rng)).round().clamp(0.0, 4095.0) as u16
    });
    Frame::new(Buffer::U16(pixels.collect()), PixelFormat::Mono12, SIZE.0, SIZE.1, FrameMeta::default())
        .unwrap()
}

fn found(exposures: &[f64], of: &dyn Fn(f64) -> f64) -> Result<Option<Response>, NoResponse> {
    found_by(&exposures.iter().map(|e| (*e, *e)).collect::<Vec<_>>(), of)
}

/// From exposures as stated and as they were.
fn found_by(exposures: &[(f64, f64)], of: &dyn Fn(f64) -> f64) -> Result<Option<Response>, NoResponse> {
    let dark: Vec<Frame> = (0..2).map(|s| frame(s, 0.0, &|_| 0.0)).collect();
    let flats: Vec<(f64, Vec<Frame>)> = exposures
        .iter()
        .enumerate()
        .map(|(k, (stated, e))| (*stated, (0..2).map(|s| frame(10 + 2 * k as u64 + s, *e, of)).collect()))
        .collect();
    let views: Vec<(f64, Vec<FrameView<'_>>)> =
        flats.iter().map(|(e, f)| (*e, f.iter().map(Frame::view).collect())).collect();
    response(&dark.iter().map(Frame::view).collect::<Vec<_>>(), &views)
}

#[test]
fn a_linear_sensor_has_no_response_to_undo() {
    assert_eq!(found(&[0.2, 0.4, 0.8], &|l| l), Ok(None));
    assert_eq!(found(&[0.4, 0.8], &|l| l), Ok(None));
    // A lamp that drifts by 1 % between two exposures is none, either.
    assert_eq!(found(&[0.4, 0.6], &|l| if l > 0.41 { 1.01 * l } else { l }), Ok(None));
    // One exposure, and two that are nearly one, show nothing.
    assert_eq!(found(&[0.5], &|l| l.powf(0.45)), Ok(None));
    assert_eq!(found(&[0.5, 0.6], &|l| l.powf(0.45)), Ok(None));
}

/// Closed form: the light that was put in comes back.
#[test]
fn the_light_comes_back() {
    type Curve = fn(f64) -> f64;
    let gamma: Curve = |l| l.powf(0.4545);
    let soft: Curve = |l| l / (1.0 + 0.15 * l) * 1.15;
    for (exposures, curve, tolerance) in [
        (vec![0.2, 0.8], gamma, 0.004),
        (vec![0.1, 0.2, 0.4, 0.8], gamma, 0.004),
        (vec![0.1, 0.2, 0.4, 0.6, 0.9], soft, 0.006),
    ] {
        let response = found(&exposures, &curve).unwrap().unwrap();
        // Up to a common factor, which moves no edge.
        let of = |light: f64| {
            let signal = curve(light);
            response.light(signal)
        };
        let factor = of(0.6) / 0.6;
        for light in [0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9] {
            let back = of(light) / factor;
            assert!((back - light).abs() < tolerance, "{exposures:?}: {back} for {light}: {response:?}");
        }
    }
}

#[test]
fn a_frame_is_linearised_between_black_and_clip() {
    let response = found(&[0.2, 0.4, 0.8], &|l| l.powf(0.7)).unwrap().unwrap();
    assert!((response.exponent - 1.0 / 0.7).abs() < 0.02, "{response:?}");
    let raw = frame(99, 0.8, &|l| l.powf(0.7));
    let light = response.linearised(raw);
    assert_eq!(light.view().full_scale(), Some(4095.0));
    for column in [3, 50, 90] {
        let mean = (0..SIZE.0).filter_map(|r| light.view().get(r, column)).map(f64::from).sum::<f64>()
            / SIZE.0 as f64;
        let right = BLACK + 4031.0 * 0.8 * (1.0 - 0.3 * column as f64 / SIZE.1 as f64);
        assert!((mean / right - 1.0).abs() < 0.01, "column {column}: {mean}, {right}");
    }
    let clipped =
        Frame::new(Buffer::U16(vec![4095; 4]), PixelFormat::Mono12, 2, 2, FrameMeta::default()).unwrap();
    assert_eq!(response.linearised(clipped).view().get(0, 0), Some(4095.0));
}

#[test]
fn exposures_that_are_wrong_are_refused() {
    // The second exposure is stated as half of what it was.
    let refused = found(&[0.1, 0.2, 0.4, 0.8], &|l| if (0.21..0.41).contains(&l) { 1.6 * l } else { l });
    assert!(refused.is_err(), "{refused:?}");
}

/// A response y = l + 4d·l(1 − l) departs from a line by d; its inverse is y·exp(4d(y − 1)) to
/// first order, a curvature of 4d.
#[test]
fn a_response_within_a_hundredth_of_a_line_is_linear() {
    let of = |d: f64| found(&[0.1, 0.2, 0.4, 0.6, 0.9], &|l| l + 4.0 * d * l * (1.0 - l));
    assert_eq!(of(0.007), Ok(None));
    let response = of(0.014).unwrap().unwrap();
    assert!((response.departure - 0.014).abs() < 2e-3, "{response:?}");
}

/// Stray light of a hundredth of the scale in the dimmest flats, which a dark frame does not show:
/// those of 4 % of the brightest light and less are left out, those of 9 % contradict the others.
#[test]
fn dim_tiles_say_nothing_of_the_response() {
    let stray = |l: f64| if l < 0.1 { l + 0.01 } else { l };
    assert_eq!(found(&[0.022, 0.4, 0.8], &stray), Ok(None));
    assert_ne!(found(&[0.07, 0.4, 0.8], &stray), Ok(None));
}

/// Flats that are clipped at 98 % of full scale are left out; where a camera clips at 96 %, its
/// response bends there.
#[test]
fn flats_near_full_scale_are_left_out() {
    let clipped_at = |share: f64| {
        let end = (share * 4095.0 - BLACK) / 4031.0;
        found(&[0.3, 0.6, 1.2], &|l| l.min(end))
    };
    assert_eq!(clipped_at(0.98), Ok(None));
    assert_ne!(clipped_at(0.96), Ok(None));
}

/// Exposures stated wrongly by some per cent, in the pattern that no exponent and no curvature
/// follows: (ln e, ln y, y) of four exposures leave one direction. Lamp and shutter may be off by 2
/// %, not by 4 %.
#[test]
fn exposures_may_be_off_by_what_lamp_and_shutter_are_good_to() {
    let free = [-0.551, 1.440, -1.228, 0.339];
    let off_by = |rms: f64| {
        let exposures = [0.1_f64, 0.2, 0.4, 0.8].iter().zip(free).map(|(e, f)| (e * (rms * f).exp(), *e));
        found_by(&exposures.collect::<Vec<_>>(), &|l| l.powf(0.7))
    };
    assert!(off_by(0.021).is_ok_and(|found| found.is_some()), "{:?}", off_by(0.021));
    assert!(off_by(0.042).is_err(), "{:?}", off_by(0.042));
}

/// Exposures 1.4 % apart are one, that a lamp drifts between: two then show an exponent alone.
/// Three show a curvature, too.
#[test]
fn a_curvature_needs_three_exposures_that_differ() {
    let curvature = |third: f64| found(&[0.4, 0.8, third], &|l| l.powf(0.7)).unwrap().unwrap().curvature;
    assert_eq!(curvature(0.8 * 1.014), 0.0);
    assert_ne!(curvature(0.8 * 1.028), 0.0);
}

/// A frame of eight by eight tiles shows their 64 levels, each once.
#[test]
fn every_tile_has_the_median_of_its_own_pixels() {
    let values = (0..SIZE.0 * SIZE.1).map(|i| (8 * (i / SIZE.1 / 8) + i % SIZE.1 / 12) as u16).collect();
    let frame =
        Frame::new(Buffer::U16(values), PixelFormat::Mono12, SIZE.0, SIZE.1, FrameMeta::default()).unwrap();
    assert_eq!(tiles(&[frame.view()]), (0..64).map(f64::from).collect::<Vec<_>>());
}
