//! The kinds of frames of [`super::uneven`]: uneven light, black frames, stuck lines, small discs
//! and wires, drawn by the textbook's pixel-integrated edge with another library's erf.

use rand_distr::{Distribution, Normal, Uniform};
use rand_pcg::Pcg64;
use shadowgauge::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use statrs::function::erf::erf;

/// The part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Part {
    /// A shaft of 40 to 70 px.
    Shaft,
    /// A wire from 6 px and from four blurs on to 22 px.
    Wire,
    /// A disc of 25 to 60 px.
    Disc,
    /// A ring of 60 to 90 px with a bore of 25 to 45 px.
    Ring,
}

/// Distribution of the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Light {
    Even,
    Along,
    Across,
    Diagonal,
    /// A spot round a point in the middle half of the field.
    Spot,
}

/// Further properties of the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Defect {
    None,
    /// A black margin, as of a round vignette or an undistorted image.
    BlackFrame,
    /// One to four stuck columns, or two adjacent ones.
    StuckColumns(u8),
    /// A stuck row, or two adjacent ones, clear of the part's edges by 16 px.
    StuckRows(u8),
    /// The shadow stands at or below the least grey value.
    Crushed,
    /// So little noise that rounding repeats.
    Quiet,
}

/// A kind of frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    pub(crate) part: Part,
    pub(crate) light: Light,
    pub(crate) defect: Defect,
    /// Whether the part stands upright.
    pub(crate) vertical: bool,
    /// Whether it is bright on a dark background.
    pub(crate) bright: bool,
    /// Most slope of its axis.
    pub(crate) tilt: f64,
}

const fn kind(name: &'static str, part: Part, light: Light, defect: Defect) -> Kind {
    Kind { name, part, light, defect, vertical: false, bright: false, tilt: 0.02 }
}

/// All kinds.
pub(crate) const KINDS: [Kind; 31] = [
    kind("even", Part::Shaft, Light::Even, Defect::None),
    kind("along", Part::Shaft, Light::Along, Defect::None),
    kind("across", Part::Shaft, Light::Across, Defect::None),
    kind("diagonal", Part::Shaft, Light::Diagonal, Defect::None),
    kind("spot", Part::Shaft, Light::Spot, Defect::None),
    kind("crushed", Part::Shaft, Light::Even, Defect::Crushed),
    kind("spot, crushed", Part::Shaft, Light::Spot, Defect::Crushed),
    kind("across, crushed", Part::Shaft, Light::Across, Defect::Crushed),
    kind("black frame", Part::Shaft, Light::Even, Defect::BlackFrame),
    kind("black frame, spot", Part::Shaft, Light::Spot, Defect::BlackFrame),
    kind("stuck columns", Part::Shaft, Light::Even, Defect::StuckColumns(1)),
    kind("two adjacent stuck columns", Part::Shaft, Light::Even, Defect::StuckColumns(2)),
    kind("stuck row", Part::Shaft, Light::Even, Defect::StuckRows(1)),
    kind("two adjacent stuck rows", Part::Shaft, Light::Even, Defect::StuckRows(2)),
    kind("wire", Part::Wire, Light::Even, Defect::None),
    Kind { tilt: 0.35, ..kind("tilted wire", Part::Wire, Light::Even, Defect::None) },
    kind("quiet", Part::Shaft, Light::Even, Defect::Quiet),
    Kind { tilt: 0.001, ..kind("wire, quiet", Part::Wire, Light::Even, Defect::Quiet) },
    kind("wire, along", Part::Wire, Light::Along, Defect::None),
    kind("wire, across", Part::Wire, Light::Across, Defect::None),
    kind("wire, spot", Part::Wire, Light::Spot, Defect::None),
    kind("wire, stuck columns", Part::Wire, Light::Even, Defect::StuckColumns(1)),
    Kind { tilt: 0.35, ..kind("tilted shaft", Part::Shaft, Light::Spot, Defect::None) },
    Kind { vertical: true, ..kind("upright, spot", Part::Shaft, Light::Spot, Defect::None) },
    Kind { bright: true, ..kind("lit", Part::Shaft, Light::Even, Defect::None) },
    Kind { bright: true, ..kind("lit, spot", Part::Shaft, Light::Spot, Defect::None) },
    Kind { bright: true, vertical: true, ..kind("lit wire, upright", Part::Wire, Light::Even, Defect::None) },
    kind("disc", Part::Disc, Light::Even, Defect::None),
    kind("disc, along", Part::Disc, Light::Along, Defect::None),
    kind("disc, spot", Part::Disc, Light::Spot, Defect::None),
    kind("ring, spot", Part::Ring, Light::Spot, Defect::None),
];

/// A frame drawn.
pub(crate) struct Drawn {
    pub(crate) frame: Frame,
    /// Width across the axis' rows, or diameter, px.
    pub(crate) size_px: f64,
    /// Diameter of the bore, px.
    pub(crate) bore_px: Option<f64>,
    /// Slope of its axis.
    slope: f64,
    /// What was drawn, for messages.
    pub(crate) words: String,
}

impl Drawn {
    /// Diameter across the axis, px.
    pub(crate) fn across_px(&self) -> f64 {
        self.size_px / (1.0 + self.slope * self.slope).sqrt()
    }
}

/// A generator of draws of one kind.
struct Draws(Pcg64);

impl Draws {
    fn from(&mut self, low: f64, high: f64) -> f64 {
        Uniform::new(low, high).unwrap().sample(&mut self.0)
    }

    fn heads(&mut self) -> bool {
        self.from(0.0, 1.0) < 0.5
    }
}

/// Light of the pixel at distance `d` px into the light: the blurred edge averaged over the pixel.
fn step(d: f64, sigma: f64) -> f64 {
    if d.abs() > 7.0 * sigma + 0.5 {
        return if d > 0.0 { 1.0 } else { 0.0 };
    }
    let g = |u: f64| {
        let t = u / sigma;
        u * 0.5 * (1.0 + erf(t / std::f64::consts::SQRT_2))
            + sigma * (-0.5 * t * t).exp() / (2.0 * std::f64::consts::PI).sqrt()
    };
    g(d + 0.5) - g(d - 0.5)
}

/// Light of a pixel at (dy, dx) from the centre of a disc: 4 x 4 points of its edge, blurred as a
/// straight edge; the 50 % contour of a blurred disc lies σ²/2R inside it (Laplacian of a curved
/// step).
fn outside(dy: f64, dx: f64, radius: f64, sigma: f64) -> f64 {
    if (dy.hypot(dx) - radius).abs() > 7.0 * sigma + 1.0 {
        return if dy.hypot(dx) > radius { 1.0 } else { 0.0 };
    }
    let mut sum = 0.0;
    for k in 0..64 {
        let (y, x) = ((f64::from(k / 8) + 0.5) / 8.0 - 0.5, (f64::from(k % 8) + 0.5) / 8.0 - 0.5);
        let d = (dy + y).hypot(dx + x) - radius + sigma * sigma / (2.0 * radius);
        sum += 0.5 * (1.0 + erf(d / sigma / std::f64::consts::SQRT_2));
    }
    sum / 64.0
}

/// Light over (row, column), both 0 to 1, as a share of its most.
fn light(kind: Light, draws: &mut Draws) -> (Box<dyn Fn(f64, f64) -> f64>, String) {
    let ratio = draws.from(1.5, 4.0);
    let fall = 1.0 - 1.0 / ratio;
    let (turned, bent) = (draws.heads(), draws.heads());
    let along = move |t: f64| {
        let t = if turned { 1.0 - t } else { t };
        if bent { ratio.powf(-t) } else { 1.0 - fall * t }
    };
    let words = format!("{kind:?} {ratio:.2}:1{}", if bent { " exponential" } else { "" });
    let (y, x) = (draws.from(0.25, 0.75), draws.from(0.25, 0.75));
    let far = [y, 1.0 - y]
        .map(|y| [x, 1.0 - x].map(|x| x * x + y * y))
        .as_flattened()
        .iter()
        .fold(0.0, |a: f64, b| a.max(*b));
    let field: Box<dyn Fn(f64, f64) -> f64> = match kind {
        Light::Even => Box::new(|_, _| 1.0),
        Light::Along => Box::new(move |_, c| along(c)),
        Light::Across => Box::new(move |r, _| along(r)),
        Light::Diagonal => Box::new(move |r, c| along(0.5 * (r + c))),
        Light::Spot => Box::new(move |r, c| ratio.powf(-((r - y).powi(2) + (c - x).powi(2)) / far)),
    };
    (field, words)
}

/// Whether a place, both coordinates 0 to 1, is black.
fn margin(draws: &mut Draws) -> Box<dyn Fn(f64, f64) -> bool> {
    let depth = draws.from(0.04, 0.1);
    if draws.heads() {
        return Box::new(move |r, c| (r - 0.5).hypot(c - 0.5) > 0.66 - depth);
    }
    Box::new(move |r, c| {
        let (x, y) = (2.0 * c - 1.0, 2.0 * r - 1.0);
        y.abs() > 1.0 - 2.0 * depth * (1.0 - 0.7 * x * x) || x.abs() > 1.0 - 2.0 * depth * (1.0 - 0.7 * y * y)
    })
}

impl Kind {
    /// Frame `number` of the kind.
    pub(crate) fn draw(&self, number: u64) -> Drawn {
        let seed = self
            .name
            .bytes()
            .fold(number, |h, b| h.wrapping_mul(1_099_511_628_211).wrapping_add(u64::from(b)));
        let mut draws = Draws(Pcg64::new(u128::from(seed), 0x0a02_bdbf_7bb3_c0a7_ac28_fa16_a64a_bf96));
        let round = matches!(self.part, Part::Disc | Part::Ring);
        let (rows, columns) = if round { (130, 140) } else { (140, 160) };
        let sigma = draws.from(0.6, 1.6);
        let (dark, full) = match self.defect {
            Defect::Crushed => (draws.from(-6.0, 2.0), draws.from(140.0, 230.0)),
            _ => (draws.from(8.0, 25.0), draws.from(140.0, 230.0)),
        };
        let quiet = self.defect == Defect::Quiet;
        let (read, gain) =
            if quiet { (draws.from(0.0, 0.3), 0.0) } else { (draws.from(0.5, 1.5), draws.from(0.0, 0.02)) };
        let (size_px, bore_px) = match self.part {
            Part::Shaft => (draws.from(40.0, 70.0), None),
            Part::Wire => (draws.from(f64::max(6.0, 4.0 * sigma), 22.0), None),
            Part::Disc => (draws.from(25.0, 60.0), None),
            Part::Ring => (draws.from(60.0, 90.0), Some(draws.from(25.0, 45.0))),
        };
        let (y, x) =
            (0.5 * rows as f64 + draws.from(-3.0, 3.0), 0.5 * columns as f64 + draws.from(-3.0, 3.0));
        let slope = draws.from(-self.tilt, self.tilt);
        let (field, lit) = light(self.light, &mut draws);
        let black = margin(&mut draws);
        let with_margin = self.defect == Defect::BlackFrame;
        // Across a tilted edge distances are shorter than along a column.
        let across = (1.0 + slope * slope).sqrt();
        let share = |row: f64, column: f64| match self.part {
            Part::Shaft | Part::Wire => {
                let middle = y + slope * (column - x);
                let from = |d: f64| step(d / across, sigma);
                from(middle - 0.5 * size_px - row) + from(row - middle - 0.5 * size_px)
            }
            Part::Disc | Part::Ring => {
                let hole = bore_px.map_or(0.0, |bore| 1.0 - outside(row - y, column - x, 0.5 * bore, sigma));
                outside(row - y, column - x, 0.5 * size_px, sigma) + hole
            }
        };
        let mut counts = vec![0.0_f64; rows * columns];
        for (k, value) in counts.iter_mut().enumerate() {
            let (row, column) = ((k / columns) as f64, (k % columns) as f64);
            let (r, c) = (row / rows as f64, column / columns as f64);
            let lit = if self.bright { 1.0 - share(row, column) } else { share(row, column) };
            *value = if with_margin && black(r, c) { 2.0 } else { dark + (full - dark) * field(r, c) * lit };
        }
        let normal = Normal::new(0.0, 1.0).unwrap();
        for value in &mut counts {
            *value += normal.sample(&mut draws.0) * (read * read + gain * value.max(0.0)).sqrt();
        }
        let stuck = self.stick(&mut counts, (rows, columns), y, &mut draws);
        let words = format!(
            "{}, frame {number}: {size_px:.2} px (bore {bore_px:?}), σ {sigma:.2}, {dark:.1} to {full:.1} counts, noise {read:.2} and {gain:.3}, slope {slope:.3}, {lit}, {stuck}",
            self.name
        );
        Drawn { frame: self.read_out(&counts, rows, columns), size_px, bore_px, slope, words }
    }

    /// The frame in 8 bits, turned where the part stands upright.
    fn read_out(&self, counts: &[f64], rows: usize, columns: usize) -> Frame {
        let mut pixels = vec![0_u8; rows * columns];
        for (k, value) in counts.iter().enumerate() {
            let (row, column) = (k / columns, k % columns);
            let place = if self.vertical { column * rows + row } else { k };
            pixels[place] = value.round().clamp(0.0, 255.0) as u8;
        }
        let (rows, columns) = if self.vertical { (columns, rows) } else { (rows, columns) };
        Frame::new(Buffer::U8(pixels), PixelFormat::Mono8, rows, columns, FrameMeta::default()).unwrap()
    }

    /// Sets stuck lines.
    fn stick(
        &self,
        counts: &mut [f64],
        (rows, columns): (usize, usize),
        middle: f64,
        draws: &mut Draws,
    ) -> String {
        let level = |draws: &mut Draws| [0.0, 255.0, draws.from(0.0, 255.0)][draws.from(0.0, 3.0) as usize];
        let mut words = String::new();
        match self.defect {
            Defect::StuckColumns(adjacent) => {
                let lines = if adjacent > 1 { 1 } else { draws.from(1.0, 5.0) as usize };
                for _ in 0..lines {
                    let first = draws.from(0.0, columns as f64 - 1.0) as usize;
                    for column in first..(first + usize::from(adjacent)).min(columns) {
                        let counts_there = level(draws);
                        words += &format!("column {column} at {counts_there:.0} ");
                        (0..rows).for_each(|row| counts[row * columns + column] = counts_there);
                    }
                }
            }
            Defect::StuckRows(adjacent) => {
                // In the middle of the part or far from it in the light.
                let first = match draws.from(0.0, 3.0) as usize {
                    0 => middle as usize,
                    1 => draws.from(0.0, 8.0) as usize,
                    _ => rows - 2 - draws.from(0.0, 8.0) as usize,
                };
                for row in first..first + usize::from(adjacent) {
                    let counts_there = level(draws);
                    words += &format!("row {row} at {counts_there:.0} ");
                    counts[row * columns..(row + 1) * columns].fill(counts_there);
                }
            }
            _ => {}
        }
        words
    }
}
