//! A frame of a scene made ready for the kernel, each step a function of the values before it: the
//! request's windows ([`RequestedFrame`]) → the instants of its exposure, raised by films
//! ([`ExposedEdges`]) → columns and profiles ([`ColumnTables`]) → contamination ([`LightMap`]) →
//! parameters ([`Params`]) → the kernel's [`Job`]. Where the sensor is more than the noise of its
//! pixels, the request is first replaced by one for the means ([`SensorReadout`]).

use super::column_profiles::Profiles;
use super::contamination_layer;
use super::exposure::{self, ExposedEdges, Instant, RequestedFrame};
use super::request::FrameRequest;
use super::scene::Scene;
use super::sensor_readout::{SensorReadout, mean_levels};
use super::true_optics::OpticalSetup;
use crate::render::error::RenderError;
use crate::render::kernel::column_edges::{
    Bands, Column, ColumnEdges, Depth, bands, fold_pixel, kernel_columns, steepest,
};
use crate::render::kernel::job::Job;
use crate::render::kernel::light_map::LightMap;
use crate::render::kernel::params::{EdgeParams, FlatParams, FrameKeys, GreyLevels, Params, pixels_per_word};
use crate::render::kernel::shadowgraph::noise_polynomial;
use crate::render::optics::esf_table::{EsfTable, Node, pixel_quadrature};

/// What the kernel reads of the columns of a frame.
struct ColumnTables<'a> {
    columns: Vec<Column>,
    bands: Bands,
    /// The edge-spread table, with the pixel's square folded in where that suits all edges.
    esf: &'a EsfTable,
    quadrature: Vec<Node>,
    profiles: Vec<[f32; 4]>,
}

/// The kernel's job for a frame, with the truth of the contamination only where requested.
///
/// # Errors
/// Refuses a window outside the sensor and a shaft that leaves the field.
pub fn frame_job<'a>(
    scene: &'a Scene,
    request: &FrameRequest,
    with_mask: bool,
) -> Result<Job<'a>, RenderError> {
    let sensor = SensorReadout::of(&scene.setup, request)?;
    let (means, readout) = match sensor {
        Some(SensorReadout { means, readout }) => (Some(means), Some(readout)),
        None => (None, None),
    };
    let levels = levels(&scene.setup, request, readout.is_some());
    let (read, request) = (request, means.as_ref().unwrap_or(request));
    let frame = RequestedFrame::of(scene, request, read)?;
    let exposed = exposure::expose(scene, request, &frame)?;
    let tables = column_tables(scene, &frame, &exposed);
    let seen = exposed.view(&frame, scene.esf.blur_px, &tables.bands);
    let contamination =
        contamination_layer::contamination(&scene.setup, request, frame.windows, &seen, with_mask)?;
    let mut params = params(&scene.setup, request, &frame, &tables, &levels);
    light_params(&scene.setup, &mut params, contamination.as_ref());
    params.set_dark(&tables.bands.dark);
    let ColumnTables { columns, bands, esf, quadrature, profiles } = tables;
    Ok(Job {
        params,
        format: frame.format,
        columns,
        bands,
        contamination,
        esf,
        quadrature,
        stacked: scene.esf.is_stacked(),
        profiles,
        readout,
    })
}

/// Levels of what the kernel draws: the frame, or its means in counts of the frame's format.
fn levels(setup: &OpticalSetup, request: &FrameRequest, as_means: bool) -> GreyLevels {
    let levels = setup.levels(setup.format(request));
    if as_means { mean_levels(&levels) } else { levels }
}

/// What the kernel reads of a frame's columns.
fn column_tables<'a>(
    scene: &'a Scene,
    frame: &RequestedFrame,
    exposed: &ExposedEdges<'_>,
) -> ColumnTables<'a> {
    let instants = &exposed.instants;
    let depth = depth(scene, &instants[0], frame);
    let mut columns = kernel_columns(&exposed.mean, &depth, &scene.blur, &scene.esf);
    let mut quadrature = pixel_quadrature(scene.esf.sharp_px, steepest(&columns));
    let folded = fold_pixel(&scene.esf, &mut columns);
    let esf = folded.unwrap_or(&scene.esf);
    let profiled = instants.len() > 1 || scene.outline.has_breaks() || scene.esf.is_by_field();
    let profiles = if profiled {
        let frame = Profiles {
            scene,
            esf: &scene.esf,
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

/// The kernel's parameters of a frame, in even light.
fn params(
    setup: &OpticalSetup,
    request: &FrameRequest,
    frame: &RequestedFrame,
    tables: &ColumnTables<'_>,
    levels: &GreyLevels,
) -> Params {
    let keys = FrameKeys { seed: request.seed, frame_id: request.frame_id, pattern_seed: setup.pattern_seed };
    let mut params = Params::new(frame.windows, frame.format, levels, request.noise, keys);
    params.flat = flat_noise(&params);
    params.edge = edge_params(tables.esf, &tables.bands);
    params.size.nodes = tables.quadrature.len() as u32;
    params.pixels.overlap = u32::from(tables.bands.overlap);
    params
}

fn light_params(setup: &OpticalSetup, params: &mut Params, contamination: Option<&LightMap>) {
    params.light.kind = match contamination {
        Some(map) if !map.words.is_empty() => 2,
        _ => u32::from(!setup.nominal.light.field.is_even()),
    };
    let light = &setup.nominal.light.field;
    params.field.polynomial =
        [light.vignetting_2, light.vignetting_4, light.gradient_along, light.gradient_down].map(|k| k as f32);
    params.field.sag = light.sag as f32;
    params.field.half_diagonals = (2.0 / (setup.rows() as f64).hypot(setup.columns() as f64)) as f32;
    params.field.axis = [setup.centre_column() as f32, setup.centre_row() as f32];
}

/// Distance of both edges from best focus and radius of the surface of every column; empty where
/// all edges share a table and its scale.
fn depth(scene: &Scene, instant: &Instant<'_>, frame: &RequestedFrame) -> Vec<Depth> {
    if scene.esf.is_even() || (scene.depth_mm == 0.0 && !scene.esf.has_radii()) {
        return Vec::new();
    }
    let (setup, view, window) = (&scene.setup, scene.view(instant.field_z_mm), frame.window);
    let size = (setup.rows(), setup.columns());
    let curvature = setup.nominal.optics.field_curvature;
    let focus_mm = |row: f64, column: f64| {
        curvature.map_or(0.0, |c| c.focus_mm(f64::from(window.row) + row, column, size))
    };
    let own = &instant.edges[frame.halo..];
    let of = |(column, e): (u32, &ColumnEdges)| {
        let column = f64::from(column);
        let z_mm = setup.column_z_mm(instant.field_z_mm, column);
        let y_mm = instant.turned.axis_depth_mm(z_mm, &view);
        let y_mm = [e.top_px, e.bottom_px].map(|row| y_mm - focus_mm(row, column));
        Depth { y_mm, radius_mm: scene.outline.mean_radius_mm(z_mm) }
    };
    (window.column..window.column + window.columns).zip(own).map(of).collect()
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
