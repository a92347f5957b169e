//! Every kind of refused frame, from the command line: the message states the value found, the
//! limit, and a remedy.

use std::path::Path;

use super::support::{said, shadowgauge};

/// Grey values of a frame.
struct Picture {
    rows: usize,
    columns: usize,
    grey: Box<dyn Fn(f64, f64) -> f64>,
    /// Standard deviation of its noise, counts.
    noise: f64,
}

/// Light with edges blurred by `sigma` and a shadow between rows `from` and `to`.
fn shadow(from: f64, to: f64, sigma: f64) -> impl Fn(f64, f64) -> f64 + Copy {
    move |row, _| {
        let step = |d: f64| 0.5 * (1.0 + statrs::function::erf::erf(d / sigma / std::f64::consts::SQRT_2));
        step(from - row) + step(row - to)
    }
}

impl Picture {
    fn new(grey: impl Fn(f64, f64) -> f64 + 'static) -> Self {
        Self { rows: 140, columns: 200, grey: Box::new(grey), noise: 1.0 }
    }

    fn shadow(from: f64, to: f64) -> Self {
        let light = shadow(from, to, 1.0);
        Self::new(move |r, c| 15.0 + 165.0 * light(r, c))
    }

    /// Exchanges rows and columns.
    fn upright(self) -> Self {
        let Self { rows, columns, grey, noise } = self;
        Self { rows: columns, columns: rows, grey: Box::new(move |r, c| grey(c, r)), noise }
    }

    /// Exchanges light and shadow.
    fn lit(self) -> Self {
        Self { grey: Box::new(move |r, c| 195.0 - (self.grey)(r, c)), ..self }
    }

    fn pixels(&self) -> Vec<u8> {
        let places = (0..self.rows).flat_map(|r| (0..self.columns).map(move |c| (r, c)));
        let mut state = 1_u64;
        // The sum of twelve uniform values less six, of a multiplicative generator.
        let mut uniform = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        places
            .map(|(r, c)| {
                let normal = (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
                ((self.grey)(r as f64, c as f64) + self.noise * normal).round().clamp(0.0, 255.0) as u8
            })
            .collect()
    }

    fn write(&self, path: &Path) {
        let mut bytes = format!("P5\n{} {}\n255\n", self.columns, self.rows).into_bytes();
        bytes.extend(self.pixels());
        std::fs::write(path, bytes).unwrap();
    }
}

/// Name, image, options, and parts of the message: value found, limit, remedy.
type Case = (&'static str, Picture, &'static [&'static str], [&'static str; 3]);

fn views() -> Vec<Case> {
    let shaft = || Picture::shadow(40.3, 101.7);
    let wire = || Picture::shadow(62.3, 77.9);
    vec![
        ("upright", shaft().upright(), &[], ["about 62 px across", "24 px or more", "try --vertical"]),
        (
            "lit",
            shaft().lit(),
            &[],
            ["a lit part about 62 px", "both must lie inside", "try --bright-on-dark"],
        ),
        (
            "upright and lit",
            shaft().lit().upright(),
            &[],
            ["a lit part about 62 px", "24 px or more", "try --vertical --bright-on-dark"],
        ),
        (
            "turned too far",
            shaft(),
            &["--vertical"],
            ["about 62 px across", "24 px or more", "without --vertical"],
        ),
        (
            "no lit part",
            shaft(),
            &["--bright-on-dark"],
            ["a shadow about", "both must lie inside", "without --bright-on-dark"],
        ),
        ("a wire", wire(), &[], ["about 16 px across", "part is 24 px", "try --min-diameter-px 11"]),
        (
            "an upright wire",
            wire().upright(),
            &[],
            ["about 16 px across", "part is 24 px", "--vertical --min-diameter-px 11"],
        ),
        (
            "a lit wire",
            wire().lit(),
            &[],
            ["a lit part about 16 px", "part is 24 px", "--bright-on-dark --min-diameter-px 11"],
        ),
        (
            "an upright lit wire",
            wire().lit().upright(),
            &[],
            ["a lit part about 16 px", "part is 24 px", "--vertical --bright-on-dark --min-diameter-px 11"],
        ),
    ]
}

/// Every second row repeats the one above, its noise included.
fn doubled() -> Picture {
    let noisy = Picture::shadow(40.3, 101.7).pixels();
    let grey = move |r: f64, c: f64| f64::from(noisy[2 * (r as usize / 2) * 200 + c as usize]);
    Picture { noise: 0.0, ..Picture::new(grey) }
}

fn gauges() -> Vec<Case> {
    let mut cases = empty_frames();
    cases.extend(shafts());
    cases.extend(wires());
    cases
}

/// Nothing to measure, or not enough of it.
fn empty_frames() -> Vec<Case> {
    let few_rows = Picture { rows: 20, ..Picture::shadow(40.3, 101.7) };
    vec![
        (
            "no part",
            Picture::new(|_, _| 180.0),
            &[],
            ["one level and its noise", "12 times the noise", "put a part into the field"],
        ),
        (
            "no light",
            Picture { noise: 0.0, ..Picture::new(|_, _| 90.0) },
            &[],
            ["same value", "12 times the noise", "light it from behind"],
        ),
        ("few rows", few_rows, &[], ["20 rows x 200 columns", "at least 24 rows", "try --vertical"]),
    ]
}

fn shafts() -> Vec<Case> {
    let shaft = Picture::shadow(40.3, 101.7);
    let row = |at: f64| {
        move |r: f64, c: f64| if r == at { 250.0 } else { 15.0 + 165.0 * shadow(40.3, 101.7, 1.0)(r, c) }
    };
    let moved = |r: f64, _: f64| {
        let ramp = |d: f64| (0.5 + d / 16.0).clamp(0.0, 1.0);
        15.0 + 165.0 * (ramp(40.0 - r) + ramp(r - 101.0))
    };
    let two = |r: f64, c: f64| {
        15.0 + 165.0 * (shadow(15.3, 55.6, 1.0)(r, c) + shadow(75.4, 115.5, 1.0)(r, c) - 1.0)
    };
    vec![
        (
            "one edge",
            Picture::shadow(60.3, 400.0),
            &[],
            ["only one edge is seen", "both must lie inside", "move the part"],
        ),
        (
            "a stuck row",
            Picture::new(row(43.0)),
            &[],
            ["row 43 stands at 2", "px of an edge", "move the part by that"],
        ),
        (
            "faint",
            Picture::new(|r, c| 90.0 + 6.0 * shadow(40.3, 101.7, 1.0)(r, c)),
            &[],
            ["times the noise", "at least", "expose more"],
        ),
        ("motion", Picture::new(moved), &[], ["only 0 of 200 columns", "8 are needed", "--esf learnt"]),
        (
            "motion, by its other causes",
            Picture::new(moved),
            &[],
            ["another edge than the model's", "motion", "loss of focus"],
        ),
        ("doubled rows", doubled(), &[], ["are the same", "pairs", "as the sensor delivers them"]),
        ("two shadows", Picture::new(two), &[], ["two shadows", "with 20 px of light", "--which outermost"]),
        (
            "a third shadow",
            Picture::new(two),
            &["--which", "3"],
            ["no shadow 3", "2 of 24 px or more", "--which"],
        ),
        (
            "a shaft at the border",
            Picture { rows: 106, ..shaft },
            &[],
            ["too near the border", "px of light are needed", "move the part"],
        ),
    ]
}

fn wires() -> Vec<Case> {
    let wires: &[&str] = &["--min-diameter-px", "5"];
    vec![
        (
            "a blurred wire",
            Picture::new(|r, c| 15.0 + 165.0 * shadow(66.0, 74.0, 3.2)(r, c)),
            wires,
            ["blurred by", "times the blur are needed", "focus"],
        ),
        (
            "a clipped wire",
            Picture::new(|r, c| 15.0 + 300.0 * shadow(62.3, 77.9, 1.0)(r, c)),
            wires,
            ["of the pixels in the light stand at the largest grey value", "below 24 px", "expose less"],
        ),
        (
            "a wire at the border",
            Picture { rows: 40, ..Picture::shadow(24.3, 36.6) },
            wires,
            ["too near the border", "7 px of light", "move the part"],
        ),
    ]
}

fn rings() -> Vec<Case> {
    let ring: &[&str] = &["--shape", "ring"];
    let disc =
        |at: (f64, f64)| move |r: f64, c: f64| if (r - at.0).hypot(c - at.1) < 30.0 { 15.0 } else { 180.0 };
    vec![
        ("no ring", Picture::new(|_, _| 180.0), ring, ["differ by", "at least", "put a part into the field"]),
        (
            "a lit disc",
            Picture::new(disc((70.0, 100.0))).lit(),
            ring,
            ["the largest", "20 px", "--bright-on-dark"],
        ),
        (
            "a disc at the border",
            Picture::new(disc((10.0, 100.0))),
            ring,
            ["touches the border", "20 px", "move the part inside"],
        ),
        (
            "a small disc",
            Picture::new(|r, c| if (r - 70.0).hypot(c - 100.0) < 8.5 { 15.0 } else { 180.0 }),
            ring,
            ["as large as a disc of", "20 px", "--min-diameter-px"],
        ),
        (
            "a plate",
            Picture::new(
                |r, c| if (r - 70.0).abs() < 20.0 && (c - 100.0).abs() < 60.0 { 15.0 } else { 180.0 },
            ),
            ring,
            ["not round", "may differ by", "--shape shaft"],
        ),
    ]
}

#[test]
fn every_refusal_says_what_was_seen_the_limit_and_what_would_help() {
    let folder = tempfile::tempdir().unwrap();
    let mut wrong = Vec::new();
    for (name, picture, options, parts) in views().into_iter().chain(gauges()).chain(rings()) {
        let path = folder.path().join("frame.pgm");
        picture.write(&path);
        let mut arguments = vec!["measure".as_ref(), path.as_os_str(), "--um-per-px".as_ref(), "10".as_ref()];
        arguments.extend(options.iter().map(std::ffi::OsStr::new));
        let output = shadowgauge(arguments);
        let text = said(&output);
        let missing: Vec<&str> = parts.into_iter().filter(|part| !text.contains(part)).collect();
        if output.status.code() != Some(3) || !missing.is_empty() {
            wrong.push(format!("{name}: exit {:?}, without {missing:?}: {text}", output.status.code()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn files_that_are_no_frames_say_what_is_needed() {
    let folder = tempfile::tempdir().unwrap();
    let whole = {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let pixels = Picture::shadow(40.3, 101.7).pixels();
        image::write_buffer_with_format(
            &mut bytes,
            &pixels,
            200,
            140,
            image::ExtendedColorType::L8,
            image::ImageFormat::Png,
        )
        .unwrap();
        bytes.into_inner()
    };
    let colour = {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let pixels: Vec<u8> =
            Picture::shadow(40.3, 101.7).pixels().iter().flat_map(|v| [*v, v / 2, 9]).collect();
        image::write_buffer_with_format(
            &mut bytes,
            &pixels,
            200,
            140,
            image::ExtendedColorType::Rgb8,
            image::ImageFormat::Png,
        )
        .unwrap();
        bytes.into_inner()
    };
    let cases: [(&str, &[u8], [&str; 2]); 4] = [
        ("empty.png", &[], ["the file is empty", "is needed"]),
        ("text.png", b"no image", ["not an image", "is needed"]),
        ("half.png", &whole[..whole.len() / 2], ["damaged or truncated", "a whole file is needed"]),
        ("colour.png", &colour, ["a colour image: red", "--channel"]),
    ];
    for (name, bytes, parts) in cases {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let output =
            shadowgauge(["measure".as_ref(), path.as_os_str(), "--um-per-px".as_ref(), "10".as_ref()]);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(3), "{name}: {text}");
        parts.iter().for_each(|part| assert!(text.contains(part), "{name} without {part:?}: {text}"));
    }
}
