//! Parameters of a frame for the kernel: the same bytes for the shader and for its CPU twin.

use super::noise::frame_key;
use crate::frame::PixelFormat;

/// Rows that an invocation of the kernel `fill` writes, as in the shader.
pub(crate) const FILL_ROWS: u32 = 16;

/// Most counts: far beyond any full scale, and f32 counts below it are exact to a quarter.
pub(crate) const MOST_COUNTS: f64 = 4.0e6;

/// Uniforms of `shaders/shadowgraph.wgsl`, which names the same bytes one by one: the groups are in
/// the order of its members (`tests/inside/render_shaders.rs` compares every offset).
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Params {
    /// Size of the frame, and nodes of the quadrature.
    pub size: SizeParams,
    /// Where the frame lies on the sensor.
    pub place: PlaceParams,
    /// Keys of noise and pattern.
    pub keys: KeyParams,
    /// Edge-spread table and bands.
    pub edge: EdgeParams,
    /// Grey values, and noise of the signal.
    pub signal: SignalParams,
    /// Variation of the light.
    pub light: LightParams,
    /// Noise of pixels far from the edges.
    pub flat: FlatParams,
    /// Conversion of a pixel's signal to counts.
    pub pixels: PixelParams,
    /// Light over the field.
    pub field: FieldParams,
    /// Rows in the shadow over all columns.
    pub dark: DarkParams,
    /// Counts per electron.
    pub counts_per_electron: f32,
    /// Pads to 16 bytes.
    pub padding: u32,
}

/// Size of the frame, and nodes of the quadrature.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SizeParams {
    /// Rows of the frame.
    pub rows: u32,
    /// Columns of the frame.
    pub columns: u32,
    /// 32-bit words per row.
    pub words: u32,
    /// Nodes of the quadrature over a pixel.
    pub nodes: u32,
}

/// Where the frame lies on the sensor.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct PlaceParams {
    /// Sensor row of the frame's row 0.
    pub row0: u32,
    /// Sensor column of the frame's column 0.
    pub column0: u32,
    /// Row of the frame at which a second window of the sensor begins.
    pub split: u32,
    /// Sensor rows left out between the two windows.
    pub skip: u32,
}

/// Keys of noise and pattern.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct KeyParams {
    /// Keys of the frame's noise.
    pub noise: [u32; 2],
    /// Keys of the sensor's fixed pattern.
    pub pattern: [u32; 2],
}

/// Edge-spread table and bands.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct EdgeParams {
    /// Rows of a band.
    pub band_rows: u32,
    /// Segments of the edge-spread table.
    pub segments: u32,
    /// Reach of the edge-spread table in its own units.
    pub reach: f32,
    /// Segments of the edge-spread table per unit.
    pub per_unit: f32,
}

/// Grey values, and noise of the signal.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SignalParams {
    /// Grey value of the shadow, counts.
    pub shadow: f32,
    /// Bright field less shadow, counts.
    pub contrast: f32,
    /// Grey value without electrons, counts.
    pub black: f32,
    /// Electrons per count.
    pub electrons_per_count: f32,
    /// Variance of the read noise, electrons².
    pub read_variance: f32,
    /// 1 with noise, 0 without.
    pub noise: f32,
}

/// Variation of the light.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct LightParams {
    /// 0 where the light is even, 1 where it varies over the field, 2 where contamination dims it
    /// as well.
    pub kind: u32,
    /// 32-bit words per row of the contamination's factors.
    pub words: u32,
}

/// Noise of pixels far from the edges.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct FlatParams {
    /// Noise polynomial of the bright field.
    pub bright: [f32; 4],
    /// Noise polynomial of the shadow.
    pub shadow: [f32; 4],
}

/// Conversion of a pixel's signal to counts.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct PixelParams {
    /// Largest count, the format's full scale.
    pub most: i32,
    /// 1 where a pixel may be affected by both edges.
    pub overlap: u32,
    /// 1 where the sensor has a fixed pattern.
    pub pattern: u32,
    /// Hot pixels as a share of 2^32.
    pub hot_share: u32,
    /// Relative standard deviation of the pixels' gain.
    pub prnu: f32,
    /// Standard deviation of the pixels' offset, counts.
    pub dsnu: f32,
    /// Extra signal of a hot pixel, counts.
    pub hot: f32,
    /// Counts at which the full well clips.
    pub ceiling: f32,
}

/// Light over the field.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct FieldParams {
    /// Vignetting of second and fourth order, gain of the backlight along columns and down rows.
    pub polynomial: [f32; 4],
    /// Loss of the backlight half a diagonal from the axis.
    pub sag: f32,
    /// Half diagonals of the sensor per pixel.
    pub half_diagonals: f32,
    /// Sensor column and row of the optical axis.
    pub axis: [f32; 2],
}

/// Rows in the shadow over all columns.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct DarkParams {
    /// First of the steps of 16 rows that lie in the shadow over all columns.
    pub from: u32,
    /// Number of these steps.
    pub steps: u32,
}

/// Levels and noise of a sensor, in counts of one format.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GreyLevels {
    /// Grey value of the shadow, counts.
    pub shadow: f64,
    /// Grey value of the bright field, counts.
    pub bright: f64,
    /// Grey value without electrons, counts.
    pub black: f64,
    /// Electrons per count.
    pub electrons_per_count: f64,
    /// Temporal dark noise, electrons.
    pub read_noise_e: f64,
    /// Saturation capacity, electrons.
    pub full_well_e: f64,
    /// Relative standard deviation of the pixels' gain.
    pub prnu: f64,
    /// Standard deviation of the pixels' offset, electrons.
    pub dsnu_e: f64,
    /// Hot pixels per million.
    pub hot_ppm: f64,
    /// Extra signal of a hot pixel, electrons.
    pub hot_pixel_e: f64,
}

impl GreyLevels {
    /// The same light and sensor read out with another number of bits.
    #[must_use]
    pub(crate) fn in_format(self, from: PixelFormat, to: PixelFormat) -> Self {
        let (Some(from), Some(to)) = (from.full_scale(), to.full_scale()) else { return self };
        let ratio = (f64::from(to) + 1.0) / (f64::from(from) + 1.0);
        Self {
            shadow: self.shadow * ratio,
            bright: self.bright * ratio,
            black: self.black * ratio,
            electrons_per_count: self.electrons_per_count / ratio,
            ..self
        }
    }
}

/// Pixels in a 32-bit word of a format.
pub(crate) fn pixels_per_word(format: PixelFormat) -> u32 {
    match format {
        PixelFormat::Mono8 => 4,
        PixelFormat::Mono10 | PixelFormat::Mono12 | PixelFormat::Mono14 | PixelFormat::Mono16 => 2,
        PixelFormat::F32 => 1,
    }
}

/// Window of the sensor that a frame shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    /// First sensor row.
    pub row: u32,
    /// First sensor column.
    pub column: u32,
    /// Rows.
    pub rows: u32,
    /// Columns.
    pub columns: u32,
}

/// The windows of a frame: one, or two with the same columns, the rows of the second below those of
/// the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Windows {
    /// The upper one.
    pub first: Window,
    /// The lower one.
    pub second: Option<Window>,
}

impl Windows {
    /// The frame's size, at the place of the first window.
    pub(crate) fn frame(&self) -> Window {
        Window { rows: self.first.rows + self.second.map_or(0, |w| w.rows), ..self.first }
    }

    /// The rows from the upper window's first to the lower one's last.
    pub(crate) fn span(&self) -> Window {
        Window { rows: self.frame().rows + self.skip(), ..self.first }
    }

    /// Sensor rows between the two.
    pub(crate) fn skip(&self) -> u32 {
        self.second.map_or(0, |w| w.row - self.first.row - self.first.rows)
    }

    /// Both, the upper one first.
    pub(crate) fn parts(&self) -> impl Iterator<Item = Window> {
        [Some(self.first), self.second].into_iter().flatten()
    }
}

/// Keys of a frame's noise and of its sensor's pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FrameKeys {
    /// Seed of the temporal noise.
    pub seed: u64,
    /// The frame's number.
    pub frame_id: u64,
    /// Seed of the sensor's fixed pattern.
    pub pattern_seed: u64,
}

impl Params {
    /// Uniforms of a frame with even light; bands, quadrature, light and the noise of flat pixels
    /// are filled in from their tables.
    pub(crate) fn new(
        windows: Windows,
        format: PixelFormat,
        levels: &GreyLevels,
        noise: bool,
        keys: FrameKeys,
    ) -> Self {
        let window = windows.frame();
        let ceiling = levels.black + levels.full_well_e / levels.electrons_per_count;
        let ceiling = ceiling.min(MOST_COUNTS);
        Self {
            size: SizeParams {
                rows: window.rows,
                columns: window.columns,
                words: window.columns.div_ceil(pixels_per_word(format)),
                nodes: 0,
            },
            place: PlaceParams {
                row0: window.row,
                column0: window.column,
                split: windows.first.rows,
                skip: windows.skip(),
            },
            keys: KeyParams {
                noise: frame_key(keys.seed, keys.frame_id),
                pattern: frame_key(keys.pattern_seed, u64::MAX),
            },
            signal: SignalParams {
                shadow: levels.shadow as f32,
                contrast: (levels.bright - levels.shadow) as f32,
                black: levels.black as f32,
                electrons_per_count: levels.electrons_per_count as f32,
                read_variance: (levels.read_noise_e * levels.read_noise_e) as f32,
                noise: f32::from(u8::from(noise)),
            },
            light: LightParams { kind: 0, words: window.columns.div_ceil(2) },
            pixels: PixelParams {
                most: format.full_scale().map_or(i32::from(i16::MAX), i32::from),
                overlap: 0,
                pattern: u32::from(levels.prnu > 0.0 || levels.dsnu_e > 0.0 || levels.hot_ppm > 0.0),
                hot_share: (levels.hot_ppm * 1e-6 * 2f64.powi(32)) as u32,
                prnu: levels.prnu as f32,
                dsnu: (levels.dsnu_e / levels.electrons_per_count) as f32,
                hot: (levels.hot_pixel_e / levels.electrons_per_count) as f32,
                ceiling: ceiling as f32,
            },
            counts_per_electron: (1.0 / levels.electrons_per_count) as f32,
            ..bytemuck::Zeroable::zeroed()
        }
    }

    /// Assigns whole steps of rows in the shadow to a separate kernel, where the others would
    /// compute light.
    pub(crate) fn set_dark(&mut self, rows: &std::ops::Range<i32>) {
        let step = |row: i32| row.clamp(0, self.size.rows as i32) as u32;
        let (from, to) = (step(rows.start).div_ceil(FILL_ROWS), step(rows.end) / FILL_ROWS);
        let steps = if self.light.kind != 0 { to.saturating_sub(from) } else { 0 };
        self.dark = DarkParams { from, steps };
    }
}
