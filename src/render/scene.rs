//! A scene: one shaft before one bench, ready to be drawn at any field and angle.

use rayon::prelude::*;

use super::bench::OpticalBench;
use super::columns::{ColumnEdges, RowBlur, bands, extremes, kernel_columns};
use super::error::RenderError;
use super::esf::{EsfTable, pixel_quadrature};
use super::light_map::LightMap;
use super::params::{FrameKeys, Job, Levels, Params, Window, Windows, pixels_per_word};
use super::silhouette::{Outline, Turned};
use super::veil;
use crate::frame::{FrameMeta, PixelFormat, Roi};
use crate::shaft::Shaft;

/// Columns of a task; the result does not depend on the number of threads.
const BLOCK: usize = 256;

/// Which frame of a scene to draw.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameRequest {
    /// Sequence number; keys the noise together with `seed`.
    pub frame_id: u64,
    /// Start of exposure, ns.
    pub t_ns: u64,
    /// Machine z of the sensor's central column, mm.
    pub z_mm: f64,
    /// Spindle angle φ, degrees.
    pub angle_deg: f64,
    /// Whether the sensor adds temporal noise.
    pub noise: bool,
    /// Window of the sensor; `None` reads all of it.
    pub roi: Option<Roi>,
    /// A second window of the same columns below the first, as cameras with several regions deliver it: its rows follow
    /// the first one's in the frame. Each window then holds one edge.
    pub second_roi: Option<Roi>,
    /// Seed of the noise.
    pub seed: u64,
    /// Pixel format, when it is not the sensor's own; levels are scaled to it.
    pub format: Option<PixelFormat>,
}

/// One shaft before one bench.
#[derive(Clone, Debug)]
pub struct Scene {
    bench: OpticalBench,
    outline: Outline,
    esf: EsfTable,
    blur: RowBlur,
    wiped: bool,
}

impl Scene {
    /// Prepares a shaft for the bench: bounds, tables.
    ///
    /// # Errors
    /// Refuses a shaft that cannot be drawn, or that exceeds the field everywhere; a frame refuses the rest.
    pub fn new(bench: &OpticalBench, shaft: Shaft) -> Result<Self, RenderError> {
        let outline = Outline::new(shaft)?;
        let field_mm = bench.rows() as f64 * bench.pixel_mm;
        let smallest = 2.0 * outline.smallest_radius_mm();
        if smallest > field_mm {
            return Err(RenderError::Field {
                what: format!(
                    "the shaft's diameter of {smallest:.3} mm exceeds the field of {field_mm:.3} mm ({} rows of {:.3} µm): lower optics.magnification or take more rows",
                    bench.rows(),
                    bench.pixel_mm * 1e3
                ),
            });
        }
        let esf = EsfTable::new(&bench.esf, bench.pixel_mm);
        let blur = RowBlur::new(esf.blur_px);
        Ok(Self { bench: bench.clone(), outline, esf, blur, wiped: false })
    }

    /// The same scene with its surface wiped: no films adhere to it, whatever soils window and air.
    #[must_use]
    pub fn wiped(self) -> Self {
        Self { wiped: true, ..self }
    }

    /// The true bench.
    pub fn bench(&self) -> &OpticalBench {
        &self.bench
    }

    /// The shaft's outline.
    pub fn outline(&self) -> &Outline {
        &self.outline
    }

    /// The window of the sensor that the request reads.
    ///
    /// # Errors
    /// Refuses a window that is empty or leaves the sensor.
    pub fn window(&self, request: &FrameRequest) -> Result<Window, RenderError> {
        self.window_of(request.roi, "roi")
    }

    /// Both windows that the request reads.
    ///
    /// # Errors
    /// As [`Self::window`], and refuses a second window that is not below the first or has other columns.
    pub fn windows(&self, request: &FrameRequest) -> Result<Windows, RenderError> {
        let first = self.window(request)?;
        let Some(roi) = request.second_roi else { return Ok(Windows { first, second: None }) };
        let second = self.window_of(Some(roi), "second_roi")?;
        if (second.column, second.columns) != (first.column, first.columns)
            || second.row < first.row + first.rows
        {
            return Err(RenderError::setting(
                "second_roi",
                &format!("{roi:?}"),
                "must have the columns of the first window and lie below it",
            ));
        }
        Ok(Windows { first, second: Some(second) })
    }

    fn window_of(&self, roi: Option<Roi>, key: &'static str) -> Result<Window, RenderError> {
        let (rows, columns) = (self.bench.nominal.camera.rows, self.bench.nominal.camera.columns);
        let Some(roi) = roi else { return Ok(Window { row: 0, column: 0, rows, columns }) };
        let inside = |start: u32, length: u32, all: u32| {
            length > 0 && start.checked_add(length).is_some_and(|end| end <= all)
        };
        if inside(roi.row, roi.rows, rows) && inside(roi.column, roi.columns, columns) {
            return Ok(Window { row: roi.row, column: roi.column, rows: roi.rows, columns: roi.columns });
        }
        Err(RenderError::setting(
            key,
            &format!("{roi:?}"),
            format!("must hold a pixel and lie within {rows} rows x {columns} columns"),
        ))
    }

    /// Exact edges of the silhouette at every column, in rows of the frame asked for.
    ///
    /// # Errors
    /// Refuses a window outside the sensor and a shaft that leaves the field.
    pub fn geometric_edges(&self, request: &FrameRequest) -> Result<Vec<ColumnEdges>, RenderError> {
        let windows = self.windows(request)?;
        let mut edges = self.edges_over(request, windows.first, 0)?;
        stack(&mut edges, windows)?;
        Ok(edges)
    }

    /// Exact edges at a fractional column, in rows of the full sensor.
    pub fn edges_at(&self, turned: &Turned<'_>, field_z_mm: f64, sensor_column: f64) -> ColumnEdges {
        let pair = turned.edges(self.bench.column_z_mm(field_z_mm, sensor_column));
        ColumnEdges {
            top_px: self.bench.row_of_x(pair.top_mm),
            bottom_px: self.bench.row_of_x(pair.bottom_mm),
        }
    }

    fn edges_over(
        &self,
        request: &FrameRequest,
        window: Window,
        halo: usize,
    ) -> Result<Vec<ColumnEdges>, RenderError> {
        let turned = self.outline.turned(request.angle_deg);
        let count = window.columns as usize + 2 * halo;
        let mut edges = vec![ColumnEdges { top_px: 0.0, bottom_px: 0.0 }; count];
        edges.par_chunks_mut(BLOCK).enumerate().for_each(|(block, chunk)| {
            for (i, e) in chunk.iter_mut().enumerate() {
                let column = f64::from(window.column) + (block * BLOCK + i) as f64 - halo as f64;
                let at = self.edges_at(&turned, request.z_mm, column);
                let row0 = f64::from(window.row);
                *e = ColumnEdges { top_px: at.top_px - row0, bottom_px: at.bottom_px - row0 };
            }
        });
        self.check_field(&edges[halo..count - halo], window)?;
        Ok(edges)
    }

    /// Extra blur variance of every column by the axis' distance from the focal plane, px²; empty where there is none.
    fn defocus(&self, request: &FrameRequest, window: Window) -> Vec<f64> {
        let na = self.bench.nominal.optics.defocus_na;
        let shaft = self.outline.shaft();
        let centred =
            shaft.bow.is_empty() && shaft.deflection.is_empty() && shaft.eccentricity.amplitude_mm == 0.0;
        if na == 0.0 || centred || !self.esf.widens {
            return Vec::new();
        }
        let turned = self.outline.turned(request.angle_deg);
        (window.column..window.column + window.columns)
            .map(|c| turned.axis_y_mm(self.bench.column_z_mm(request.z_mm, f64::from(c))))
            .map(|y| (0.5 * y * na / self.bench.pixel_mm).powi(2))
            .collect()
    }

    fn check_field(&self, edges: &[ColumnEdges], window: Window) -> Result<(), RenderError> {
        let row0 = f64::from(window.row);
        let last = self.bench.rows() as f64 - 1.0;
        let outside = edges.iter().position(|e| !(e.top_px + row0 >= 0.0 && e.bottom_px + row0 <= last));
        let Some(column) = outside else { return Ok(()) };
        let e = edges[column];
        Err(RenderError::Field {
            what: format!(
                "at column {} the shaft's edges stand at rows {:.1} and {:.1}, outside the field's 0 to {last}: move or straighten the shaft, or lower optics.magnification",
                column + window.column as usize,
                e.top_px + row0,
                e.bottom_px + row0
            ),
        })
    }

    /// Levels in counts of the format asked for.
    pub fn levels(&self, format: PixelFormat) -> Levels {
        let nominal = &self.bench.nominal;
        Levels {
            shadow: nominal.light.shadow_counts,
            bright: nominal.light.bright_in(&nominal.sensor, self.bench.electrons_per_count),
            black: nominal.sensor.black_level_counts,
            electrons_per_count: self.bench.electrons_per_count,
            read_noise_e: nominal.sensor.read_noise_e,
            full_well_e: nominal.sensor.full_well_e,
            prnu: nominal.sensor.prnu_rel,
            dsnu_e: nominal.sensor.dsnu_e,
            hot_ppm: nominal.sensor.hot_pixels_ppm,
            hot_pixel_e: nominal.sensor.hot_pixel_e,
        }
        .in_format(nominal.sensor.format, format)
    }

    /// Format of the frame asked for.
    pub fn format(&self, request: &FrameRequest) -> PixelFormat {
        request.format.unwrap_or(self.bench.nominal.sensor.format)
    }

    /// What stands beside the pixels of the frame asked for.
    pub fn meta(&self, request: &FrameRequest) -> FrameMeta {
        FrameMeta {
            frame_id: request.frame_id,
            t_ns: request.t_ns,
            exposure_us: self.bench.nominal.camera.exposure_us,
            angle_deg: request.angle_deg,
            z_mm: request.z_mm,
            roi: request.roi,
        }
    }

    /// Everything the kernel needs for a frame.
    ///
    /// # Errors
    /// As [`Self::geometric_edges`].
    pub fn job(&self, request: &FrameRequest) -> Result<Job<'_>, RenderError> {
        let windows = self.windows(request)?;
        let window = windows.first;
        let format = self.format(request);
        let reach = self.blur.reach();
        let mut edges = self.edges_over(request, window, reach)?;
        let rises = match self.wiped {
            true => Vec::new(),
            false => veil::raise_edges(&self.bench, self.outline.shaft(), request, window, &mut edges)?,
        };
        stack(&mut edges, windows)?;
        let seen = |all: usize| reach.min(all)..all.saturating_sub(reach).max(reach.min(all));
        let contamination = veil::contamination(
            &self.bench,
            request,
            windows,
            &edges[seen(edges.len())],
            &rises[seen(rises.len())],
            self.esf.blur_px,
        )?;
        let columns = kernel_columns(&edges, &self.defocus(request, window), &self.blur, &self.esf);
        let (max_sin, _) = extremes(&columns, self.esf.scale_px);
        let quadrature = pixel_quadrature(self.esf.blur_px, max_sin);
        let bands = bands(&columns, pixels_per_word(format) as usize, &self.esf);
        let keys = FrameKeys {
            seed: request.seed,
            frame_id: request.frame_id,
            pattern_seed: self.bench.pattern_seed,
        };
        let mut params = Params::new(windows, format, &self.levels(format), request.noise, keys);
        params.nodes = quadrature.len() as u32;
        params.band_rows = bands.rows;
        params.overlap = u32::from(bands.overlap);
        params.esf_segments = self.esf.segments.len() as u32;
        params.esf_reach = self.esf.reach;
        params.esf_per_unit = self.esf.per_unit;
        self.light_params(&mut params, contamination.as_ref());
        Ok(Job {
            params,
            format,
            columns,
            bands,
            contamination,
            esf: &self.esf,
            quadrature,
            stacked: false,
            profiles: Vec::new(),
        })
    }

    fn light_params(&self, params: &mut Params, contamination: Option<&LightMap>) {
        params.light = match contamination {
            Some(map) if !map.words.is_empty() => 2,
            _ => u32::from(!self.bench.nominal.light.field.is_even()),
        };
        let light = &self.bench.nominal.light.field;
        params.field = [light.vignetting_2, light.vignetting_4, light.gradient_along, light.gradient_down]
            .map(|k| k as f32);
        params.sag = light.sag as f32;
        params.half_diagonals = (2.0 / (self.bench.rows() as f64).hypot(self.bench.columns() as f64)) as f32;
        params.axis = [self.bench.centre_column() as f32, self.bench.centre_row() as f32];
    }

    /// Takes a frame's contamination back for its memory and gives out its mask.
    pub(super) fn recycle(&self, mut map: LightMap) -> Vec<u8> {
        let mask = std::mem::take(&mut map.mask);
        if let Some(soiling) = &self.bench.soiling {
            soiling.recycle(map);
        }
        mask
    }
}

/// Moves the lower edges into the rows that a second window has in the frame.
fn stack(edges: &mut [ColumnEdges], windows: Windows) -> Result<(), RenderError> {
    if windows.second.is_none() {
        return Ok(());
    }
    let (split, rows) = (f64::from(windows.first.rows), f64::from(windows.frame().rows));
    for e in &mut *edges {
        e.bottom_px -= f64::from(windows.skip());
    }
    let apart =
        |e: &ColumnEdges| e.top_px >= 0.0 && e.top_px < split && e.bottom_px >= split && e.bottom_px < rows;
    if edges.iter().all(apart) {
        return Ok(());
    }
    let right = "each window must hold one edge of the shaft in every column: move it, or give it more rows";
    Err(RenderError::setting("second_roi", &format!("{windows:?}"), right))
}
