//! The end of the grey scale: light (or shadow) clipped wherever a camera clips it, hot pixels,
//! frames without noise. The frames are computed here, by the textbook's pixel-integrated edge with
//! another library's erf; discs by a separable blur of a finely sampled disc.

use rand_distr::{Distribution, Normal, Uniform};
use rand_pcg::Pcg64;
use shadowgauge::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use shadowgauge::gauge::ring::{RingSettings, measure_ring};
use shadowgauge::gauge::{EdgeState, FrameEdges, Gauge, GaugeSettings, Polarity, largest_caliper_over};
use shadowgauge::profile::Reason;
use statrs::function::erf::erf;

use super::support::{collected, measured};

const ROWS: usize = 120;
const COLUMNS: usize = 160;
const WIDTH: f64 = 60.4;
/// Slope of the shaft, rows per column: in one frame the edge passes through all positions within a
/// pixel, on which clipping depends.
const RISE: f64 = 0.0075;
const DISC: usize = 160;
const DIAMETER: f64 = 120.6;

/// A camera: its clip, container and noise.
#[derive(Clone, Copy, Debug)]
struct Camera {
    format: PixelFormat,
    /// Largest grey value.
    clip: f64,
    /// Grey values are multiples of this.
    step: f64,
    /// Smallest grey value.
    black: f64,
    /// Share of hot pixels.
    hot: f64,
    /// Share of dead pixels.
    dead: f64,
    /// Whether light and shadow are exchanged: a lit part.
    lit: bool,
    /// Noise at the clip as a share of it: read noise and photon noise.
    noise: (f64, f64),
    /// Share of the clip from which on the response bends towards it; none of a linear one.
    knee: Option<f64>,
}

const EIGHT: Camera = Camera {
    format: PixelFormat::Mono8,
    clip: 255.0,
    step: 1.0,
    black: 0.0,
    hot: 0.0,
    dead: 0.0,
    lit: false,
    noise: (0.004, 0.008),
    knee: None,
};

/// A scene: light as a multiple of the clip at both ends of the shaft, dark level as a share of the
/// clip, blur.
#[derive(Clone, Copy, Debug)]
struct Scene {
    light: (f64, f64),
    dark: f64,
    sigma: f64,
}

impl Scene {
    fn even(light: f64) -> Self {
        Self { light: (light, light), dark: 0.08, sigma: 1.0 }
    }

    /// Half of the shaft below the clip.
    fn half(light: f64) -> Self {
        Self { light: (light, 0.6 * light), ..Self::even(light) }
    }
}

/// Light on a pixel whose centre lies `d` px on the light side of an edge.
fn step(d: f64, sigma: f64) -> f64 {
    let cdf = |t: f64| 0.5 * (1.0 + erf(t / std::f64::consts::SQRT_2));
    let pdf = |t: f64| (-0.5 * t * t).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let g = |u: f64| u * cdf(u / sigma) + sigma * pdf(u / sigma);
    g(d + 0.5) - g(d - 0.5)
}

impl Camera {
    fn expose(&self, rows: usize, columns: usize, seed: u64, share: impl Fn(usize, usize) -> f64) -> Frame {
        let mut random = Pcg64::new(u128::from(seed), 0x0a02_bdbf_7bb3_c0a7_ac28_fa16_a64a_bf96);
        let (normal, even) = (Normal::new(0.0, 1.0).unwrap(), Uniform::new(0.0, 1.0).unwrap());
        let (read, photons) = (self.noise.0 * self.clip, self.noise.1.powi(2) * self.clip);
        let mut values = Vec::with_capacity(rows * columns);
        for row in 0..rows {
            for column in 0..columns {
                let share = if self.lit { 0.9 - share(row, column) } else { share(row, column) };
                let mean = self.clip * share;
                let s = (read * read + photons * mean.max(0.0)).sqrt();
                let place = even.sample(&mut random);
                let value = match (place < self.hot, place > 1.0 - self.dead) {
                    (true, _) => f64::INFINITY,
                    (_, true) => 0.0,
                    _ => mean + s * normal.sample(&mut random),
                };
                let value = self.bent(value);
                let whole = if self.step > 0.0 { (value / self.step).round() * self.step } else { value };
                values.push(whole.clamp(self.black, self.clip));
            }
        }
        let buffer = match self.format {
            PixelFormat::Mono8 => Buffer::U8(values.iter().map(|v| *v as u8).collect()),
            PixelFormat::F32 => Buffer::F32(values.iter().map(|v| *v as f32).collect()),
            _ => Buffer::U16(values.iter().map(|v| *v as u16).collect()),
        };
        Frame::new(buffer, self.format, rows, columns, FrameMeta::default()).unwrap()
    }

    /// A grey value after a soft knee, above which it approaches the clip exponentially.
    fn bent(&self, value: f64) -> f64 {
        let Some(knee) = self.knee.map(|share| share * self.clip).filter(|knee| value > *knee) else {
            return value;
        };
        let left = self.clip - knee;
        knee + left * (1.0 - (-(value - knee) / left).exp())
    }

    fn shaft(&self, scene: &Scene, seed: u64) -> Frame {
        self.shaft_of(WIDTH, scene, seed)
    }

    /// A shaft of a width, px.
    fn shaft_of(&self, width: f64, scene: &Scene, seed: u64) -> Frame {
        let phase = (seed % 17) as f64 / 17.0 - 0.5;
        let place = |column: usize| 29.3 + phase + RISE * column as f64;
        self.expose(ROWS, COLUMNS, seed, |row, column| {
            let t = column as f64 / (COLUMNS - 1) as f64;
            let light = scene.light.0 + (scene.light.1 - scene.light.0) * t;
            let d = place(column) - row as f64;
            // The width along a column of a shaft that rises; the blur along it is wider by the
            // same 1/cos, 3e-5.
            scene.dark
                + (light - scene.dark)
                    * (step(d, scene.sigma) + step(-d - width * 1.0_f64.hypot(RISE), scene.sigma))
        })
    }

    fn disc(&self, scene: &Scene, drawn: &[f64], seed: u64) -> Frame {
        self.expose(DISC, DISC, seed, |row, column| {
            scene.dark + (scene.light.0 - scene.dark) * drawn[row * DISC + column]
        })
    }
}

/// Share of light around a disc, blurred: sampled four times as finely, blurred along both axes,
/// averaged over the pixels.
fn drawn_disc(sigma: f64) -> Vec<f64> {
    const FINE: usize = 4;
    let n = DISC * FINE;
    let at = |k: usize| (k as f64 + 0.5) / FINE as f64 - 0.5;
    let mut fine: Vec<f64> = (0..n * n)
        .map(|i| {
            let r = (at(i % n) - 79.7).hypot(at(i / n) - 80.2) - 0.5 * DIAMETER;
            (0.5 + r * FINE as f64).clamp(0.0, 1.0)
        })
        .collect();
    let reach = (5.0 * sigma * FINE as f64) as isize;
    let kernel: Vec<f64> =
        (-reach..=reach).map(|k| (-0.5 * (k as f64 / (sigma * FINE as f64)).powi(2)).exp()).collect();
    let sum: f64 = kernel.iter().sum();
    for along in [1, n] {
        let source = fine.clone();
        for (i, value) in fine.iter_mut().enumerate() {
            let (here, first) = ((i / along) % n, i - ((i / along) % n) * along);
            *value = kernel
                .iter()
                .zip(-reach..)
                .map(|(k, j)| {
                    let at = (here as isize + j).clamp(0, n as isize - 1) as usize;
                    k * source[first + at * along]
                })
                .sum::<f64>()
                / sum;
        }
    }
    (0..DISC * DISC)
        .map(|i| {
            let (row, column) = (i / DISC * FINE, i % DISC * FINE);
            let block = (0..FINE * FINE).map(|k| fine[(row + k / FINE) * n + column + k % FINE]);
            block.sum::<f64>() / (FINE * FINE) as f64
        })
        .collect()
}

fn edges(frame: &Frame) -> Result<FrameEdges, Reason> {
    Gauge::new(GaugeSettings::default()).unwrap().edges(&frame.view()).map_err(|refused| refused.reason)
}

/// Error of the diameter and its u, px, or nothing where the frame was refused.
fn shaft_of(frame: &Frame) -> Option<(f64, f64)> {
    // Over 65 columns and more, so that u changes with the light, not with the length of the
    // largest stretch.
    let largest = largest_caliper_over(&edges(frame).ok()?, 65)?;
    Some((largest.diameter_px - WIDTH, largest.u_px))
}

fn disc_of(frame: &Frame) -> Option<(f64, f64)> {
    let measured = measure_ring(&frame.view(), &RingSettings::default()).ok()?;
    Some((measured.outer.diameter_px - DIAMETER, measured.outer.u_diameter_px))
}

/// Result of a step of the sweep.
#[derive(Debug, Default)]
struct Step {
    light: f64,
    frames: usize,
    refused: usize,
    /// Median of u, px: that of a single frame changes with the stretch that happens to be largest.
    u: f64,
    /// |error| over u.
    ratios: Vec<f64>,
}

fn sweep(lights: &[f64], frames: u64, measure: impl Fn(f64, u64) -> Option<(f64, f64)> + Sync) -> Vec<Step> {
    use rayon::prelude::*;
    lights
        .par_iter()
        .map(|light| {
            let seed = |k: u64| 1_000 * (light * 100.0).round() as u64 + k;
            let found: Vec<_> = (0..frames).map(|k| measure(*light, seed(k))).collect();
            let kept: Vec<(f64, f64)> = found.iter().flatten().copied().collect();
            let mut stated: Vec<f64> = kept.iter().map(|(_, u)| *u).collect();
            stated.sort_by(f64::total_cmp);
            Step {
                light: *light,
                frames: found.len(),
                refused: found.len() - kept.len(),
                u: stated.get(stated.len() / 2).copied().unwrap_or(0.0),
                ratios: kept.iter().map(|(e, u)| (e / u).abs()).collect(),
            }
        })
        .collect()
}

/// Light from half to three times the clip: 5 % steps, 1 % near it.
fn lights() -> Vec<f64> {
    let coarse = (10..=60).map(|k| 0.05 * f64::from(k));
    let near = (91..=109).filter(|k| k % 5 != 0).map(|k| 0.01 * f64::from(k));
    let mut all: Vec<f64> = coarse.chain(near).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// The limits that a sweep violates.
fn misses(name: &str, steps: &[Step]) -> Vec<String> {
    let mut misses = Vec::new();
    let mut miss = |what: String| misses.push(format!("{name}: {what}"));
    let base = steps[0].u;
    for step in steps {
        let over = |k: f64| step.ratios.iter().filter(|r| **r > k).count();
        println!(
            "{name} {:.2}: refused {}/{}, u {:.4}, worst {:.2} u, rms {:.2} u",
            step.light,
            step.refused,
            step.frames,
            step.u,
            step.ratios.iter().copied().fold(0.0, f64::max),
            (step.ratios.iter().map(|r| r * r).sum::<f64>() / step.ratios.len().max(1) as f64).sqrt()
        );
        if step.light < 0.995 && (step.refused > 0 || step.u > 1.2 * base) {
            miss(format!(
                "{:.2}: {} refused, u {:.4} px, {base:.4} at 0.5",
                step.light, step.refused, step.u
            ));
        }
        if step.light < 1.505 && (10 * step.refused > step.frames || step.u > 0.1) {
            miss(format!("{:.2}: {} refused, u {:.4} px", step.light, step.refused, step.u));
        }
        if over(5.0) > 0 {
            miss(format!("{:.2}: {} frames beyond 5 u", step.light, over(5.0)));
        }
    }
    let (all, beyond) = steps.iter().fold((0, 0), |(all, beyond), s| {
        (all + s.ratios.len(), beyond + s.ratios.iter().filter(|r| **r > 3.0).count())
    });
    if beyond as f64 > 0.005 * all as f64 {
        miss(format!("{beyond} of {all} frames beyond 3 u"));
    }
    for pair in steps.windows(2).filter(|p| p.iter().all(|s| 2 * s.refused < s.frames)) {
        let ratio = pair[1].u / pair[0].u;
        if !(1.0 / 1.5..=1.5).contains(&ratio) {
            miss(format!("u of {:.2} is {ratio:.2} times that of {:.2}", pair[1].light, pair[0].light));
        }
    }
    misses
}

/// The cameras of the sweep by name.
fn cameras() -> Vec<(&'static str, Camera)> {
    let hot = |hot| Camera { hot, ..EIGHT };
    vec![
        ("255", EIGHT),
        ("254", Camera { clip: 254.0, ..EIGHT }),
        ("235", Camera { clip: 235.0, ..EIGHT }),
        ("1023 in 16 bits", Camera { format: PixelFormat::Mono16, clip: 1023.0, ..EIGHT }),
        ("left-aligned 12 bits", Camera { format: PixelFormat::Mono16, clip: 65520.0, step: 16.0, ..EIGHT }),
        ("f32", Camera { format: PixelFormat::F32, clip: 1.0, step: 0.0, ..EIGHT }),
        ("hot 0.1 %", hot(0.001)),
        ("hot 0.5 %", hot(0.005)),
        ("hot 2 %", hot(0.02)),
    ]
}

#[test]
#[ignore = "the whole sweep: minutes"]
fn light_from_half_to_three_times_the_clip_whole_sweep() {
    let lights = lights();
    let drawn = drawn_disc(1.0);
    let mut missed = Vec::new();
    let frames = std::env::var("SWEEP_FRAMES").ok().and_then(|n| n.parse().ok()).unwrap_or(12);
    let wanted = std::env::var("SWEEP_ONLY").unwrap_or_default();
    for (name, camera) in cameras() {
        let all: [(String, Vec<Step>); 3] =
            [("shaft", 0), ("half shaft", 1), ("disc", 2)].map(|(kind, index)| {
                let name = format!("{kind}, {name}");
                if !name.contains(&wanted) {
                    return (name, Vec::new());
                }
                let steps = sweep(&lights, frames, |light, seed| match index {
                    0 => shaft_of(&camera.shaft(&Scene::even(light), seed)),
                    1 => shaft_of(&camera.shaft(&Scene::half(light), seed)),
                    _ => disc_of(&camera.disc(&Scene::even(light), &drawn, seed)),
                });
                (name, steps)
            });
        for (name, steps) in all.iter().filter(|(_, steps)| !steps.is_empty()) {
            missed.extend(misses(name, steps));
        }
    }
    missed.iter().for_each(|m| println!("MISSED {m}"));
    assert!(missed.is_empty(), "{} limits missed", missed.len());
}

/// The named cameras: each diameter within 3 u of the true width, or refused as saturated.
#[test]
fn frames_of_the_collection_are_within_their_uncertainty_or_refused() {
    for (name, shape, truth) in [
        ("clip/mono10_in_16_bit.tif", "shaft", 60.4),
        ("clip/clipped_at_254.png", "shaft", 60.4),
        ("clip/clipped_at_255.png", "shaft", 60.4),
        ("clip/disc_clipped_at_254.png", "ring", 120.6),
        ("clip/disc_clipped_at_255.png", "ring", 120.6),
    ] {
        let Some(path) = collected(name) else { continue };
        let document = measured(&path, if shape == "ring" { &["--shape", "ring"] } else { &[] });
        let frame = &document["frames"][0];
        let (d, u) = match shape {
            "ring" => ("outer_diameter_px", "u_outer_diameter_px"),
            _ => ("max_diameter_px", "u_max_px"),
        };
        let Some(value) = frame[d].as_f64() else {
            assert!(frame.to_string().contains("saturated"), "{name}: {frame}");
            continue;
        };
        let u = frame[u].as_f64().unwrap();
        println!("{name}: {value:.3} ± {u:.3}, {} u", (value - truth) / u);
        assert!((value - truth).abs() <= 3.0 * u && u < 1.0, "{name}: {value} ± {u}");
    }
}

/// A frame without noise is not taken for clipped, at any level of its light.
#[test]
fn a_frame_without_noise_is_not_clipped() {
    for clip in [255.0, 235.0] {
        let quiet = Camera { noise: (0.0, 0.0), clip, ..EIGHT };
        for light in [1.0, 0.8] {
            let found = edges(&quiet.shaft(&Scene::even(light), 3)).unwrap();
            assert!(found.top.iter().all(|e| e.state == EdgeState::Good), "{clip} {light}");
        }
    }
}

/// Clipping is detected from the light, whatever the container; hot pixels are not taken for
/// clipping.
#[test]
fn clipped_light_is_flagged_wherever_it_is_clipped_and_hot_pixels_are_not() {
    for (name, camera) in cameras() {
        let bright = edges(&camera.shaft(&Scene::even(1.3), 5)).unwrap();
        let flagged = bright.top.iter().filter(|e| e.reason() == Some(Reason::Clipped)).count();
        assert!(flagged > COLUMNS / 2, "{name}: {flagged}");
        let fine = edges(&camera.shaft(&Scene::even(0.78), 6)).unwrap();
        assert!(fine.top.iter().all(|e| e.reason() != Some(Reason::Clipped)), "{name}");
    }
}

/// A part of the whole sweep: below the clip, through it and far beyond, on a shaft, half a shaft
/// and a disc, with hot pixels and a clip below full scale. No frame beyond 5 u, few beyond 3, none
/// refused below 1.5 times the clip, u as asked for.
#[test]
fn light_through_the_clip_is_measured_within_its_uncertainty() {
    let lights = [0.5, 0.8, 0.95, 0.99, 1.0, 1.01, 1.02, 1.04, 1.08, 1.2, 1.35, 1.5, 2.0];
    let drawn = drawn_disc(1.0);
    let hot = Camera { hot: 0.005, ..EIGHT };
    let ten_bits = Camera { format: PixelFormat::Mono16, clip: 1023.0, ..EIGHT };
    // No step of the grey scale: what counts as noise is then a share of the contrast.
    let float = Camera { format: PixelFormat::F32, clip: 1.0, step: 0.0, ..EIGHT };
    let mut missed = Vec::new();
    for (name, steps) in [
        ("shaft, f32", sweep(&lights, 4, |light, seed| shaft_of(&float.shaft(&Scene::even(light), seed)))),
        ("shaft, hot", sweep(&lights, 4, |light, seed| shaft_of(&hot.shaft(&Scene::even(light), seed)))),
        ("half shaft", sweep(&lights, 4, |light, seed| shaft_of(&ten_bits.shaft(&Scene::half(light), seed)))),
        ("disc", sweep(&lights, 4, |light, seed| disc_of(&ten_bits.disc(&Scene::even(light), &drawn, seed)))),
    ] {
        missed.extend(misses(name, &steps).into_iter().filter(|miss| !miss.contains(" times that of ")));
    }
    assert!(missed.is_empty(), "{missed:?}");
}

/// Two hot pixels in a hundred and light that falls to three fifths along the shaft: half the
/// columns are lost, and the others are not misjudged in contour or light.
#[test]
fn two_hot_pixels_in_a_hundred_leave_a_falling_light_measurable() {
    let camera = Camera { hot: 0.02, ..EIGHT };
    let lights = [0.5, 0.6, 0.65, 1.2, 1.5, 1.6, 1.8];
    let steps = sweep(&lights, 8, |light, seed| shaft_of(&camera.shaft(&Scene::half(light), seed)));
    for step in &steps {
        let worst = step.ratios.iter().copied().fold(0.0, f64::max);
        println!("{:.2}: refused {}, u {:.4} px, worst {worst:.2} u", step.light, step.refused, step.u);
        assert!(step.refused == 0 || step.light > 1.505, "{step:?}");
        assert!(worst < 5.0 && step.u < 0.1, "{step:?}");
    }
    let beyond = steps.iter().flat_map(|step| &step.ratios).filter(|ratio| **ratio > 3.0).count();
    assert!(beyond <= 1, "{beyond} of 56 beyond 3 u");
}

/// Largest diameter over 65 columns and more against the width drawn, in u, its u, and the number
/// of edges flagged as clipped.
fn largest_of(frame: &Frame, settings: GaugeSettings, width: f64) -> Result<(f64, f64, usize), String> {
    let found = Gauge::new(settings).unwrap().edges(&frame.view()).map_err(|refused| refused.to_string())?;
    let lines = [&found.top, &found.bottom].into_iter().flatten();
    let clipped = lines.filter(|e| e.reason() == Some(Reason::Clipped)).count();
    let largest = largest_caliper_over(&found, 65).ok_or("no caliper")?;
    Ok(((largest.diameter_px - width) / largest.u_px, largest.u_px, clipped))
}

/// Levels quieter than a grey step, with and without hot and dead pixels: what a few defects show
/// is no scatter, and what rounds to one grey value is no end. Shafts under even and falling light,
/// wires, lit parts.
#[test]
fn quiet_levels_with_defects_are_not_clipped() {
    let (mut ratios, mut flagged, mut missed) = (Vec::new(), 0, Vec::new());
    for (read, photons) in [(0.0002, 0.004), (0.0005, 0.004), (0.001, 0.002), (0.0016, 0.0), (0.001, 0.008)] {
        for (hot, dead) in [(0.0, 0.0), (0.005, 0.0), (0.015, 0.0), (0.0, 0.005), (0.005, 0.005)] {
            let camera = Camera { hot, dead, noise: (read, photons), ..EIGHT };
            let even = Scene { dark: 0.06, ..Scene::even(0.8) };
            for (kind, light, lit, width) in [
                ("shaft", even, false, WIDTH),
                ("half", Scene::half(0.8), false, WIDTH),
                ("wire", even, false, 11.37),
                ("lit", even, true, WIDTH),
            ] {
                for seed in 0..2 {
                    let frame = Camera { lit, ..camera }.shaft_of(width, &light, seed);
                    let polarity = if lit { Polarity::BrightOnDark } else { Polarity::DarkOnBright };
                    let settings =
                        GaugeSettings { polarity, min_diameter_px: 6.0, ..GaugeSettings::default() };
                    match largest_of(&frame, settings, width) {
                        // A wire's rounding is stated for the worst phase of its columns.
                        Ok((ratio, u, clipped)) if ratio.abs() < 4.0 && u < 0.1 => {
                            flagged += usize::from(clipped > 0);
                            ratios.push(ratio);
                        }
                        other => {
                            missed.push(format!("{kind} {read} {photons} {hot} {dead} {seed}: {other:?}"));
                        }
                    }
                }
            }
        }
    }
    let beyond = ratios.iter().filter(|r| r.abs() > 3.0).count();
    println!("{} frames, {beyond} beyond 3 u, {flagged} flagged", ratios.len());
    assert!(missed.is_empty(), "{missed:#?}");
    assert!(beyond <= 1, "{beyond} of {} beyond 3 u", ratios.len());
    // Dead pixels beside the flank pass for its noise in one frame of two hundred.
    assert!(flagged <= 1, "{flagged} flagged");
}

/// A frame without noise in which a hot or dead pixel opens a row: that row is not a live one
/// beside a stuck one.
#[test]
fn a_defect_in_a_row_without_noise_makes_no_stuck_row_of_its_neighbour() {
    for (hot, dead) in [(0.015, 0.0), (0.0, 0.015)] {
        for seed in 0..24 {
            let camera = Camera { hot, dead, noise: (0.0002, 0.0), ..EIGHT };
            let frame = camera.shaft(&Scene { dark: 0.06, ..Scene::even(0.8) }, seed);
            let found = Gauge::new(GaugeSettings::default()).unwrap().edges(&frame.view());
            assert!(found.is_ok(), "hot {hot}, dead {dead}, seed {seed}: {}", found.unwrap_err());
        }
    }
}

/// Cameras whose response bends before it ends: found by the noise of the light, or by the shape of
/// the flank where none is left.
#[test]
fn light_above_a_soft_knee_is_clipped_light() {
    for knee in [0.85, 0.9, 0.95] {
        let camera = Camera { knee: Some(knee), ..EIGHT };
        for light in [0.75, 1.0, 1.1, 1.2, 1.4] {
            for seed in 0..3 {
                let frame = camera.shaft(&Scene::even(light), 40 + seed);
                let Some((error, u)) = shaft_of(&frame) else { panic!("{knee} {light} {seed}: refused") };
                let found = edges(&frame).unwrap();
                let clipped = found.top.iter().filter(|e| e.reason() == Some(Reason::Clipped)).count();
                println!("{knee} {light} {seed}: {error:.3} ± {u:.3}, {clipped} clipped");
                assert!(error.abs() <= 3.0 * u && u < 0.3, "{knee} {light} {seed}: {error} ± {u}");
                // At the clip itself a gentle bend may still be reported as a systematic residual
                // of the edge model.
                if light != 1.0 {
                    assert_eq!(clipped > COLUMNS / 2, light > 1.0, "{knee} {light} {seed}: {clipped}");
                }
            }
        }
    }
}

/// Shadow that is crushed at 0, a little or wholly: the same in both sides of the frame, with the
/// noise estimated from light and flank.
#[test]
fn crushed_shadow_is_measured_within_its_uncertainty() {
    for dark in [0.002, 0.0, -0.004, -0.008, -0.02, -0.04] {
        let ratios: Vec<f64> = (0..8)
            .map(|seed| {
                let scene = Scene { dark, ..Scene::even(0.7) };
                let (error, u) = shaft_of(&EIGHT.shaft(&scene, 70 + seed)).unwrap();
                assert!(error.abs() <= 3.5 * u && u < 0.2, "{dark} {seed}: {error} ± {u}");
                error / u
            })
            .collect();
        let rms = (ratios.iter().map(|r| r * r).sum::<f64>() / ratios.len() as f64).sqrt();
        println!("{dark}: rms {rms:.2} u");
        assert!(rms < 1.6, "{dark}: {rms} u");
    }
}
