//! Small 8-bit frames of a short piece of shaft with and without contamination, the same noise in
//! both.
//!
//! Drawn here instead of by the renderer, so that a frame and its clean twin differ only in the
//! contamination, and thousands of frames take minutes: pixel-integrated Gaussian edges, a surface
//! with texture, an 8-bit sensor after EMVA 1288.

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use crate::frame::{Buffer, Frame, FrameError, FrameMeta, PixelFormat};
use crate::numerics::distributions::phi_cdf;
use crate::render::RenderError;
use crate::render::contamination::{
    AirDroplets, Chips, Contamination, ContaminationField, Dirt, FieldGeometry, Mist, Scratches,
    TransmissionMap, WindowDroplets,
};

/// Rows of a frame.
pub(crate) const ROWS: usize = 1024;
/// Columns of a frame.
pub(crate) const COLUMNS: usize = 512;
/// Pixel on the object, µm.
pub(crate) const PIXEL_UM: f64 = 15.0;
/// Columns of a station, 0.96 mm.
pub(crate) const STATION: usize = 64;
/// Blur, px.
const SIGMA_PX: f64 = 1.0;
/// Levels of shadow and light, counts; electrons per count and read noise.
const DARK: f64 = 12.0;
const LIGHT: f64 = 210.0;
const ELECTRONS: f64 = 50.0;
const READ_E: f64 = 10.0;
/// Surface texture of a turned part: standard deviation and correlation length, µm.
const TEXTURE_UM: (f64, f64) = (0.35, 1500.0);

/// Kinds of contamination.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Contaminant {
    /// Droplets on the protective window, which stay.
    WindowDroplets,
    /// Droplets in flight.
    AirDroplets,
    /// Chips in flight.
    Chips,
    /// Clouds of coolant.
    Mist,
    /// Specks on the window.
    Dirt,
    /// Scratches in the window.
    Scratches,
    /// Short films and chips that adhere to the shaft.
    Films,
    /// A mixture of all kinds.
    All,
}

impl Contaminant {
    /// All kinds.
    pub(crate) const KINDS: [Self; 8] = [
        Self::WindowDroplets,
        Self::AirDroplets,
        Self::Chips,
        Self::Mist,
        Self::Dirt,
        Self::Scratches,
        Self::Films,
        Self::All,
    ];

    /// Settings with which a large share of the frames is harmed.
    fn settings(self) -> Contamination {
        let clean =
            Contamination { beam_depth_mm: 30.0, window_distance_mm: 20.0, ..Contamination::default() };
        let windows = WindowDroplets { per_cm2: 20.0, ..WindowDroplets::default() };
        let air = AirDroplets { per_cm2: 60.0, ..AirDroplets::default() };
        let chips = Chips { per_cm2: 3.0, ..Chips::default() };
        let mist = Mist { clouds_per_cm2: 6.0, optical_depth: 0.5, ..Mist::default() };
        let dirt = Dirt { per_cm2: 40.0, ..Dirt::default() };
        let scratches = Scratches { per_cm2: 3.0, ..Scratches::default() };
        match self {
            Self::WindowDroplets => Contamination { window_droplets: windows, ..clean },
            Self::AirDroplets => Contamination { air_droplets: air, ..clean },
            Self::Chips => Contamination { chips, ..clean },
            Self::Mist => Contamination { mist, ..clean },
            Self::Dirt => Contamination { dirt, ..clean },
            Self::Scratches => Contamination { scratches, ..clean },
            Self::Films => clean,
            Self::All => Contamination {
                window_droplets: WindowDroplets { per_cm2: 5.0, ..windows },
                air_droplets: AirDroplets { per_cm2: 15.0, ..air },
                chips: Chips { per_cm2: 1.0, ..chips },
                mist: Mist { clouds_per_cm2: 2.0, optical_depth: 0.1, ..mist },
                dirt: Dirt { per_cm2: 10.0, ..dirt },
                scratches: Scratches { per_cm2: 0.5, ..scratches },
                ..clean
            },
        }
    }
}

/// A bump on one edge that turns with the shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bump {
    /// Column of its middle.
    pub column: f64,
    /// Half its length along the shaft, columns.
    pub half_length: f64,
    /// Height at its middle, px.
    pub height_px: f64,
    /// On the upper edge.
    pub upper: bool,
}

impl Bump {
    fn at(&self, column: usize) -> f64 {
        let u = (column as f64 - self.column) / self.half_length;
        if u.abs() < 1.0 { self.height_px * (std::f64::consts::FRAC_PI_2 * u).cos().powi(2) } else { 0.0 }
    }
}

/// A piece of shaft: the rows of its edges and the generator's state for the noise.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    top: Vec<f64>,
    bottom: Vec<f64>,
    seed: u64,
}

/// Why a frame could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub(crate) enum DrawError {
    /// The contamination's settings.
    Render(#[from] RenderError),
    /// The frame's size.
    Frame(#[from] FrameError),
}

impl Piece {
    /// Draws a piece: diameter, place, tilt, taper and texture by the seed.
    pub(crate) fn draw(seed: u64) -> Self {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut within = |low: f64, high: f64| -> f64 {
            // The ranges below are not empty.
            Uniform::new(low, high).map_or(low, |uniform| uniform.sample(&mut random))
        };
        let radius = within(280.0, 360.0);
        let centre = within(470.0, 550.0);
        let (tilt, taper, bow) = (within(-4e-3, 4e-3), within(-1e-3, 1e-3), within(-2e-7, 2e-7));
        let textures = [texture(&mut random), texture(&mut random)];
        let line = |sign: f64, texture: &[f64]| -> Vec<f64> {
            (0..COLUMNS)
                .map(|c| {
                    let x = c as f64 - COLUMNS as f64 / 2.0;
                    centre + tilt * x + bow * x * x + sign * (radius + taper * x + texture[c])
                })
                .collect()
        };
        Self { top: line(-1.0, &textures[0]), bottom: line(1.0, &textures[1]), seed }
    }

    /// The same piece with bumps on its edges.
    #[must_use]
    pub(crate) fn with_bumps(&self, bumps: &[Bump]) -> Self {
        let mut raised = self.clone();
        for bump in bumps {
            let line = if bump.upper { &mut raised.top } else { &mut raised.bottom };
            let outward = if bump.upper { -1.0 } else { 1.0 };
            line.iter_mut().enumerate().for_each(|(c, row)| *row += outward * bump.at(c));
        }
        raised
    }

    /// True edges of a column, rows.
    pub(crate) fn edges(&self, column: usize) -> (f64, f64) {
        (self.top[column], self.bottom[column])
    }

    /// The frame through a transmission map; `None` is clear.
    ///
    /// # Errors
    /// Where the frame is refused.
    pub(crate) fn frame(&self, map: Option<&TransmissionMap>) -> Result<Frame, DrawError> {
        let mut random = Pcg64::seed_from_u64(self.seed ^ 0x006e_6f69_7365);
        let mut pixels = vec![0_u8; ROWS * COLUMNS];
        for (row, line) in pixels.chunks_exact_mut(COLUMNS).enumerate() {
            let shade = map.map(|m| &m.values()[row * COLUMNS..(row + 1) * COLUMNS]);
            for (column, pixel) in line.iter_mut().enumerate() {
                let y = row as f64;
                let lit = step(self.top[column] - y, SIGMA_PX) + step(y - self.bottom[column], SIGMA_PX);
                let level = DARK + (LIGHT - DARK) * lit * shade.map_or(1.0, |s| f64::from(s[column]));
                let noise: f64 = StandardNormal.sample(&mut random);
                let electrons = ELECTRONS * level + noise * (ELECTRONS * level + READ_E * READ_E).sqrt();
                *pixel = (electrons / ELECTRONS).round().clamp(0.0, 255.0) as u8;
            }
        }
        Ok(Frame::new(Buffer::U8(pixels), PixelFormat::Mono8, ROWS, COLUMNS, FrameMeta::default())?)
    }

    /// The frame with contamination of one kind in front of the shaft or on it.
    ///
    /// # Errors
    /// Where the contamination cannot be drawn.
    pub(crate) fn dirty(&self, contaminant: Contaminant) -> Result<Frame, DrawError> {
        let settings = contaminant.settings();
        if contaminant == Contaminant::Films {
            return self.with_bumps(&self.short_films()).frame(None);
        }
        let geometry = FieldGeometry {
            rows: ROWS,
            columns: COLUMNS,
            pixel_um: PIXEL_UM,
            effective_na: 0.01,
            sigma_um: SIGMA_PX * PIXEL_UM,
        };
        let field = ContaminationField::new(&settings, geometry, self.seed ^ 0x0064_6972_7479)?;
        let map = field.frame(self.seed, [0, 0], [ROWS, COLUMNS])?;
        let bumps = if contaminant == Contaminant::All { self.short_films() } else { Vec::new() };
        self.with_bumps(&bumps).frame(Some(&map))
    }

    /// One or two films or smeared chips, 0.1-1 mm half length, lognormal thickness about 15 µm.
    fn short_films(&self) -> Vec<Bump> {
        let mut random = Pcg64::seed_from_u64(self.seed ^ 0x66_696c_6d73);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let count = 1 + (normal().abs() as usize).min(1);
        (0..count)
            .map(|_| Bump {
                column: COLUMNS as f64 * (0.5 + 0.29 * normal()).clamp(0.0, 1.0),
                half_length: (400.0 * (0.8 * normal()).exp()).clamp(100.0, 1000.0) / PIXEL_UM,
                height_px: (15.0 * (0.7 * normal()).exp()).clamp(3.0, 150.0) / PIXEL_UM,
                upper: normal() > 0.0,
            })
            .collect()
    }
}

/// Light on a pixel whose centre lies `d` px on the light side of a Gaussian edge of blur `sigma`,
/// integrated over the pixel.
pub(super) fn step(d: f64, sigma: f64) -> f64 {
    if d.abs() > 6.0 * sigma.max(SIGMA_PX) {
        return if d > 0.0 { 1.0 } else { 0.0 };
    }
    let g = |u: f64| {
        let t = u / sigma;
        u * phi_cdf(t) + sigma * (-0.5 * t * t).exp() / (2.0 * std::f64::consts::PI).sqrt()
    };
    g(d + 0.5) - g(d - 0.5)
}

/// A Gaussian first-order random field along the columns, px.
fn texture(random: &mut Pcg64) -> Vec<f64> {
    let (sd, length) = (TEXTURE_UM.0 / PIXEL_UM, TEXTURE_UM.1 / PIXEL_UM);
    let keep = (-1.0 / length).exp();
    let fresh = sd * (1.0 - keep * keep).sqrt();
    let first: f64 = StandardNormal.sample(random);
    let mut value = sd * first;
    (0..COLUMNS)
        .map(|_| {
            let z: f64 = StandardNormal.sample(random);
            value = keep * value + fresh * z;
            value
        })
        .collect()
}
