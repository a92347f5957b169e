//! A frame of a scene made ready for the kernel, each step a value from those before it: the
//! request's windows ([`RequestedFrame`]) → the instants of its exposure, raised by films
//! ([`ExposedEdges`]) → columns and profiles ([`ColumnTables`]) → contamination ([`LightMap`]) →
//! parameters ([`Params`]) → the kernel's [`Job`].

use super::column_profiles::Profiles;
use super::contamination_layer::{self, WindowView};
use super::exposure::{self, Instant};
use super::request::FrameRequest;
use super::scene::Scene;
use crate::frame::PixelFormat;
use crate::render::error::RenderError;
use crate::render::kernel::column_edges::{
    Bands, Column, ColumnEdges, Depth, bands, fold_pixel, kernel_columns, steepest,
};
use crate::render::kernel::job::Job;
use crate::render::kernel::light_map::LightMap;
use crate::render::kernel::params::{
    EdgeParams, FlatParams, FrameKeys, Params, Window, Windows, pixels_per_word,
};
use crate::render::kernel::shadowgraph::noise_polynomial;
use crate::render::optics::esf_table::{EsfTable, Node, pixel_quadrature};

/// What a request reads of the sensor.
#[derive(Clone, Copy, Debug)]
struct RequestedFrame {
    windows: Windows,
    /// From the upper window's first row to the lower one's last.
    window: Window,
    format: PixelFormat,
    /// Columns computed beyond the frame's own at either side.
    halo: usize,
}

/// Where the edges of a frame stand while it is exposed, with the halo, in rows of its window.
struct ExposedEdges<'a> {
    instants: Vec<Instant<'a>>,
    /// Mean over the instants.
    mean: Vec<ColumnEdges>,
    /// The mean with the lower edges in the rows that a second window has in the frame.
    stacked: Vec<ColumnEdges>,
}

/// What the kernel reads of the columns of a frame.
struct ColumnTables<'a> {
    columns: Vec<Column>,
    bands: Bands,
    /// The edge-spread table, with the pixel's square folded in where that suits all edges.
    esf: &'a EsfTable,
    quadrature: Vec<Node>,
    profiles: Vec<[f32; 4]>,
}

impl ExposedEdges<'_> {
    /// The frame's own columns as contamination meets them.
    fn view(&self, frame: &RequestedFrame, blur_px: f64, bands: &Bands) -> WindowView<'_> {
        let rises = self.instants.last().map_or(&[][..], |i| &i.rises);
        let (edges, rises) = (within_halo(&self.stacked, frame.halo), within_halo(rises, frame.halo));
        WindowView { edges, rises, blur_px, dark: bands.dark.clone() }
    }
}

impl Scene {
    /// Exact edges of the silhouette at every column, in rows of the requested frame: the mean over
    /// the exposure where they move, distorted by the lens.
    ///
    /// # Errors
    /// Refuses a window outside the sensor and a shaft that leaves the field.
    pub fn geometric_edges(&self, request: &FrameRequest) -> Result<Vec<ColumnEdges>, RenderError> {
        let windows = self.windows(request)?;
        let mut edges = exposure::mean(&exposure::instants(self, request, windows.span(), 0)?);
        stack(&mut edges, windows)?;
        Ok(edges)
    }

    /// The kernel's job for a frame.
    ///
    /// # Errors
    /// As [`Self::geometric_edges`].
    pub fn job(&self, request: &FrameRequest) -> Result<Job<'_>, RenderError> {
        self.job_with(request, true)
    }

    /// [`Self::job`], with the truth of the contamination only where requested.
    ///
    /// # Errors
    /// As [`Self::job`].
    pub fn job_with(&self, request: &FrameRequest, with_mask: bool) -> Result<Job<'_>, RenderError> {
        let frame = self.requested(request)?;
        let exposed = self.exposed(request, &frame)?;
        let tables = self.column_tables(&frame, &exposed);
        let seen = exposed.view(&frame, self.esf.blur_px, &tables.bands);
        let contamination =
            contamination_layer::contamination(&self.setup, request, frame.windows, &seen, with_mask)?;
        let params = self.params(request, &frame, &tables, contamination.as_ref());
        let ColumnTables { columns, bands, esf, quadrature, profiles } = tables;
        Ok(Job {
            params,
            format: frame.format,
            columns,
            bands,
            contamination,
            esf,
            quadrature,
            stacked: self.esf.is_stacked(),
            profiles,
        })
    }

    /// The windows and the format of a request.
    fn requested(&self, request: &FrameRequest) -> Result<RequestedFrame, RenderError> {
        let windows = self.windows(request)?;
        let (format, halo) = (self.format(request), self.blur.reach());
        Ok(RequestedFrame { windows, window: windows.span(), format, halo })
    }

    /// The edges of a frame over its exposure.
    fn exposed(
        &self,
        request: &FrameRequest,
        frame: &RequestedFrame,
    ) -> Result<ExposedEdges<'_>, RenderError> {
        let instants = self.filmed_instants(request, frame.window, frame.halo)?;
        let mean = exposure::mean(&instants);
        let mut stacked = mean.clone();
        stack(&mut stacked, frame.windows)?;
        Ok(ExposedEdges { instants, mean, stacked })
    }

    /// What the kernel reads of a frame's columns.
    fn column_tables(&self, frame: &RequestedFrame, exposed: &ExposedEdges<'_>) -> ColumnTables<'_> {
        let instants = &exposed.instants;
        let depth = self.depth(&instants[0], frame.window);
        let mut columns = kernel_columns(&exposed.mean, &depth, &self.blur, &self.esf);
        let mut quadrature = pixel_quadrature(self.esf.sharp_px, steepest(&columns));
        let folded = fold_pixel(&self.esf, &mut columns);
        let esf = folded.unwrap_or(&self.esf);
        let profiles = if instants.len() > 1 || self.outline.has_breaks() {
            let frame = Profiles {
                scene: self,
                esf: &self.esf,
                window: frame.window,
                halo: frame.halo,
                instants,
                depth: &depth,
                quadrature: &quadrature,
                kernel_segments: esf.segments.len(),
            };
            frame.add(&mut columns)
        } else {
            Vec::new()
        };
        if folded.is_some() {
            quadrature = vec![Node { along: 0.0, down: 0.0, weight: 1.0, padding: 0.0 }];
        }
        // Whole rows: the lower edges keep their places to the last bit.
        columns.iter_mut().for_each(|c| c.bottom.whole -= frame.windows.skip() as i32);
        let bands = bands(&columns, pixels_per_word(frame.format) as usize, esf);
        ColumnTables { columns, bands, esf, quadrature, profiles }
    }

    /// The kernel's parameters of a frame.
    fn params(
        &self,
        request: &FrameRequest,
        frame: &RequestedFrame,
        tables: &ColumnTables<'_>,
        contamination: Option<&LightMap>,
    ) -> Params {
        let levels = self.levels(frame.format);
        let mut params = Params::new(frame.windows, frame.format, &levels, request.noise, self.keys(request));
        params.flat = flat_noise(&params);
        params.edge = edge_params(tables.esf, &tables.bands);
        params.size.nodes = tables.quadrature.len() as u32;
        params.pixels.overlap = u32::from(tables.bands.overlap);
        self.light_params(&mut params, contamination);
        params.set_dark(&tables.bands.dark);
        params
    }

    /// Instants of the exposure, their edges raised by the films that adhere to the part.
    fn filmed_instants(
        &self,
        request: &FrameRequest,
        window: Window,
        halo: usize,
    ) -> Result<Vec<Instant<'_>>, RenderError> {
        let mut instants = exposure::instants(self, request, window, halo)?;
        if !self.wiped {
            for instant in &mut instants {
                let edges = &mut instant.edges;
                instant.rises = contamination_layer::raise_edges(
                    &self.setup,
                    self.outline.shaft(),
                    request,
                    window,
                    edges,
                )?;
            }
        }
        Ok(instants)
    }

    fn keys(&self, request: &FrameRequest) -> FrameKeys {
        FrameKeys { seed: request.seed, frame_id: request.frame_id, pattern_seed: self.setup.pattern_seed }
    }

    fn light_params(&self, params: &mut Params, contamination: Option<&LightMap>) {
        params.light.kind = match contamination {
            Some(map) if !map.words.is_empty() => 2,
            _ => u32::from(!self.setup.nominal.light.field.is_even()),
        };
        let light = &self.setup.nominal.light.field;
        params.field.polynomial =
            [light.vignetting_2, light.vignetting_4, light.gradient_along, light.gradient_down]
                .map(|k| k as f32);
        params.field.sag = light.sag as f32;
        params.field.half_diagonals =
            (2.0 / (self.setup.rows() as f64).hypot(self.setup.columns() as f64)) as f32;
        params.field.axis = [self.setup.centre_column() as f32, self.setup.centre_row() as f32];
    }

    /// Depth of the axis and radius of the surface of every column; empty where all edges share a
    /// table and its scale.
    fn depth(&self, instant: &Instant<'_>, window: Window) -> Vec<Depth> {
        if self.esf.is_even() || (self.depth_mm == 0.0 && !self.esf.has_radii()) {
            return Vec::new();
        }
        let view = self.view(instant.field_z_mm);
        (window.column..window.column + window.columns)
            .map(|c| self.setup.column_z_mm(instant.field_z_mm, f64::from(c)))
            .map(|z| Depth {
                y_mm: instant.turned.axis_depth_mm(z, &view),
                radius_mm: self.outline.mean_radius_mm(z),
            })
            .collect()
    }

    /// Takes back a job's memory for the next frame.
    pub fn give_back(&self, job: Job<'_>) {
        if let Some(map) = job.contamination {
            self.recycle(map);
        }
    }

    /// Takes back the memory of a frame's contamination and returns its mask.
    pub(crate) fn recycle(&self, mut map: LightMap) -> Vec<u8> {
        let mask = std::mem::take(&mut map.mask);
        if let Some(contamination) = &self.setup.contamination {
            contamination.recycle(map);
        }
        mask
    }
}

/// The elements of the frame's own columns, without the `halo` on either side.
fn within_halo<T>(all: &[T], halo: usize) -> &[T] {
    let first = halo.min(all.len());
    &all[first..all.len().saturating_sub(halo).max(first)]
}

fn flat_noise(params: &Params) -> FlatParams {
    FlatParams {
        bright: noise_polynomial(params, params.signal.shadow + params.signal.contrast),
        shadow: noise_polynomial(params, params.signal.shadow),
    }
}

fn edge_params(esf: &EsfTable, bands: &Bands) -> EdgeParams {
    EdgeParams { band_rows: bands.rows, segments: esf.per_table, reach: esf.reach, per_unit: esf.per_unit }
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
