//! A scene: one shaft before one bench, ready to be drawn at any field and angle.

use std::sync::Arc;

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::column_profiles::Profiles;
use super::contamination_layer::{self, Seen};
use super::exposure::{self, Instant};
use super::true_optics::OpticalBench;
use crate::frame::{FrameMeta, PixelFormat, Roi};
use crate::render::error::RenderError;
use crate::render::kernel::column_edges::{
    ColumnEdges, Depth, RowBlur, Straight, bands, fold_pixel, kernel_columns, steepest,
};
use crate::render::kernel::light_map::LightMap;
use crate::render::kernel::params::{FrameKeys, Job, Levels, Params, Window, Windows, pixels_per_word};
use crate::render::optics::edge_spread::{EdgeSpread, LaserShadow};
use crate::render::optics::esf_table::{EsfTable, Extent, Node, pixel_quadrature};
use crate::render::optics::laser_shoulder::SEEN_UNITS;
use crate::render::optics::settings::Esf;
use crate::render::silhouette::{Outline, Turned, View};
use crate::shaft::Shaft;

/// Stream of the spindle's asynchronous error motion.
const ASYNCHRONOUS_STREAM: u64 = 0x6173_796e_6368;

/// Room that a pinhole keeps from the shaft, mm.
const CLEARANCE_MM: f64 = 1.0;

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
    esf: Arc<EsfTable>,
    blur: RowBlur,
    /// One over the distance of the pinhole, 1/mm; 0 for a telecentric lens.
    per_distance: f64,
    /// Largest distance of any axis from the plane of focus, mm.
    depth_mm: f64,
    /// Standard deviation of the widest Gaussian, px.
    largest_sigma_px: f64,
    /// How far along z tilt, perspective and distortion may carry a corner, mm.
    margin_mm: f64,
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
        let per_distance = per_distance(bench, &outline)?;
        let pose = outline.shaft().pose;
        let lean = (pose.tilt_to_camera_mrad * 1e-3).sin().abs();
        let half_mm = 0.5 * bench.columns() as f64 * bench.pixel_mm;
        let depth_mm = outline.largest_depth_mm() + half_mm * lean;
        let radius_mm = outline.mean_radii_mm();
        let esf = bench.tables.table(
            &bench.esf,
            &bench.nominal.optics,
            &Extent { pixel_mm: bench.pixel_mm, depth_mm, radius_mm },
        )?;
        let margin_mm = radius_mm.1 * ((pose.tilt_mrad * 1e-3).sin().abs() + lean)
            + (half_mm + radius_mm.1) * radius_mm.1 * per_distance.abs()
            + sideways_px(bench) * bench.pixel_mm;
        let widest = if esf.widens { esf.place(depth_mm, radius_mm.1, 0.0).scale_px } else { esf.blur_px };
        let blur = RowBlur::new(esf.blur_px);
        let (bench, largest_sigma_px) = (bench.clone(), widest);
        Ok(Self {
            bench,
            outline,
            esf,
            blur,
            per_distance,
            depth_mm,
            largest_sigma_px,
            margin_mm,
            wiped: false,
        })
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

    /// The edge spreads of the scene in f64, µm on the object; none where it is the plain Gaussian.
    pub fn edge_spreads(&self) -> &[EdgeSpread] {
        self.esf.sources()
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

    /// Exact edges of the silhouette at every column, in rows of the frame asked for: the mean over the exposure where they
    /// move, as the lens distorts them.
    ///
    /// # Errors
    /// Refuses a window outside the sensor and a shaft that leaves the field.
    pub fn geometric_edges(&self, request: &FrameRequest) -> Result<Vec<ColumnEdges>, RenderError> {
        let windows = self.windows(request)?;
        let mut edges = exposure::mean(&exposure::instants(self, request, windows.span(), 0)?);
        stack(&mut edges, windows)?;
        Ok(edges)
    }

    /// The shaft at a spindle angle, with the error motion that this frame alone has.
    pub(crate) fn turned(&self, request: &FrameRequest, angle_deg: f64) -> Turned<'_> {
        let turned = self.outline.turned(angle_deg);
        let rms_um = self.outline.shaft().spindle.asynchronous_rms_um;
        if rms_um == 0.0 {
            return turned;
        }
        let key = request.seed ^ ASYNCHRONOUS_STREAM ^ request.frame_id.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut random = Pcg64::seed_from_u64(key);
        let mut draw = || {
            let z: f64 = StandardNormal.sample(&mut random);
            1e-3 * rms_um * z.clamp(-4.0, 4.0)
        };
        turned.shifted(draw(), draw())
    }

    /// Whether every slice projects by itself.
    pub(crate) fn is_straight(&self) -> bool {
        self.view(0.0).is_straight(self.outline.shaft().pose.tilt_to_camera_mrad)
    }

    fn view(&self, field_z_mm: f64) -> View {
        View { middle_z_mm: field_z_mm, per_distance: self.per_distance }
    }

    /// Exact edges at a fractional column, in rows of the full sensor.
    pub fn edges_at(&self, turned: &Turned<'_>, field_z_mm: f64, sensor_column: f64) -> ColumnEdges {
        let distortion = &self.bench.nominal.optics.distortion;
        let view = self.view(field_z_mm);
        if distortion.is_none() {
            let pair = turned.edges_seen(self.bench.column_z_mm(field_z_mm, sensor_column), &view);
            return ColumnEdges {
                top_px: self.bench.row_of_x(pair.top_mm),
                bottom_px: self.bench.row_of_x(pair.bottom_mm),
            };
        }
        let ideal = |upper: bool| {
            distortion.edge_row(sensor_column, self.bench.rows(), self.bench.columns(), |c| {
                self.bench.row_of_x(turned.edge_seen(self.bench.column_z_mm(field_z_mm, c), &view, upper))
            })
        };
        ColumnEdges { top_px: ideal(true), bottom_px: ideal(false) }
    }

    /// Upper and lower row of the light beneath an overhang of either edge at a fractional column, in rows of the full sensor.
    pub(crate) fn gaps_at(
        &self,
        turned: &Turned<'_>,
        field_z_mm: f64,
        sensor_column: f64,
    ) -> [Option<[f64; 2]>; 2] {
        if !(self.is_straight() && self.bench.nominal.optics.distortion.is_none()) {
            return [None; 2];
        }
        let z = self.bench.column_z_mm(field_z_mm, sensor_column);
        let rows = |ends: [f64; 2]| {
            let [a, b] = ends.map(|x| self.bench.row_of_x(x));
            [a.min(b), a.max(b)]
        };
        [true, false].map(|top| turned.gap(z, top).map(rows))
    }

    /// Straight-edge equivalent of an edge (0 upper, 1 lower) of a column at an instant.
    pub(crate) fn straight(&self, instant: &Instant<'_>, column: usize, side: usize) -> Straight {
        let window = instant.edges[column..column + 2 * self.blur.reach() + 1].iter();
        self.blur.straight(window.map(|e| if side == 0 { e.top_px } else { e.bottom_px }))
    }

    /// Whether a column of a frame sees a corner of the outline within the blur.
    pub(crate) fn is_broken(&self, frame: &Profiles<'_>, column: usize) -> bool {
        if !self.outline.has_breaks() {
            return false;
        }
        let mut reach_px = 5.25 * self.largest_sigma_px + 1.0;
        if let Some(laser) = self.laser_shoulders() {
            reach_px = reach_px.max(SEEN_UNITS * laser.unit_um() * 1e-3 / self.bench.pixel_mm);
        }
        let reach_mm = reach_px * self.bench.pixel_mm + self.margin_mm;
        let column = f64::from(frame.window.column) + column as f64;
        frame.instants.iter().any(|i| {
            let z = self.bench.column_z_mm(i.field_z_mm, column);
            self.outline.is_broken(z - reach_mm, z + reach_mm)
        })
    }

    /// The laser, where its light at the outline's corners is known in amplitude: level pieces between shoulders.
    pub(crate) fn laser_shoulders(&self) -> Option<&LaserShadow> {
        let Esf::Fresnel(laser) = &self.bench.esf else { return None };
        let optics = &self.bench.nominal.optics;
        let plain = self.is_straight() && optics.distortion.is_none() && optics.reflection.is_none();
        (plain && self.outline.is_stepped()).then_some(laser)
    }

    /// Columns of the full sensor at which the outline seen at an instant has corners, and whether these are all.
    pub(crate) fn corners(&self, instant: &Instant<'_>, low: f64, high: f64) -> (Vec<f64>, bool) {
        let bench = &self.bench;
        let (rows, columns) = (bench.rows(), bench.columns());
        let distortion = &bench.nominal.optics.distortion;
        let z = |column: f64| bench.column_z_mm(instant.field_z_mm, column);
        let (from, to) = (z(low) - self.margin_mm, z(high) + self.margin_mm);
        let mut corners = Vec::new();
        for s in self.outline.breaks_mm(from, to) {
            for (z_mm, x_mm) in instant.turned.corner_seen(s) {
                let column = bench.centre_column() + (z_mm - instant.field_z_mm) / bench.pixel_mm;
                let row = bench.row_of_x(x_mm);
                corners.push(if distortion.is_none() {
                    column
                } else {
                    distortion.distort_px(row, column, rows, columns).1
                });
            }
        }
        corners.sort_by(f64::total_cmp);
        corners.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        let helices = &self.outline.shaft().features.helices;
        let known = self.is_straight() && !helices.iter().any(|h| h.from_mm <= to && h.to_mm >= from);
        (corners, known)
    }

    /// Where axis and surface of every column lie; empty where all edges share a table and its scale.
    fn depth(&self, instant: &Instant<'_>, window: Window) -> Vec<Depth> {
        if self.esf.is_even() || (self.depth_mm == 0.0 && !self.esf.has_radii()) {
            return Vec::new();
        }
        let view = self.view(instant.field_z_mm);
        (window.column..window.column + window.columns)
            .map(|c| self.bench.column_z_mm(instant.field_z_mm, f64::from(c)))
            .map(|z| Depth {
                y_mm: instant.turned.axis_depth_mm(z, &view),
                radius_mm: self.outline.mean_radius_mm(z),
            })
            .collect()
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
            ..FrameMeta::default()
        }
    }

    /// Everything the kernel needs for a frame.
    ///
    /// # Errors
    /// As [`Self::geometric_edges`].
    pub fn job(&self, request: &FrameRequest) -> Result<Job<'_>, RenderError> {
        self.job_with(request, true)
    }

    /// [`Self::job`], the truth of the contamination only where it is asked for.
    ///
    /// # Errors
    /// As [`Self::job`].
    pub fn job_with(&self, request: &FrameRequest, with_mask: bool) -> Result<Job<'_>, RenderError> {
        let windows = self.windows(request)?;
        let window = windows.span();
        let format = self.format(request);
        let halo = self.blur.reach();
        let mut instants = exposure::instants(self, request, window, halo)?;
        if !self.wiped {
            for instant in &mut instants {
                let edges = &mut instant.edges;
                instant.rises = contamination_layer::raise_edges(
                    &self.bench,
                    self.outline.shaft(),
                    request,
                    window,
                    edges,
                )?;
            }
        }
        let edges = exposure::mean(&instants);
        let mut stacked = edges.clone();
        stack(&mut stacked, windows)?;
        let seen = |all: usize| halo.min(all)..all.saturating_sub(halo).max(halo.min(all));
        let depth = self.depth(&instants[0], window);
        let mut columns = kernel_columns(&edges, &depth, &self.blur, &self.esf);
        let mut quadrature = pixel_quadrature(self.esf.sharp_px, steepest(&columns));
        let folded = fold_pixel(&self.esf, &mut columns);
        let esf = folded.unwrap_or(&self.esf);
        let profiles = if instants.len() > 1 || self.outline.has_breaks() {
            let frame = Profiles {
                scene: self,
                esf: &self.esf,
                window,
                halo,
                instants: &instants,
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
        columns.iter_mut().for_each(|c| c.bottom.whole -= windows.skip() as i32);
        let bands = bands(&columns, pixels_per_word(format) as usize, esf);
        let rises = instants.last().map_or(&[][..], |i| &i.rises);
        let seen = Seen {
            edges: &stacked[seen(stacked.len())],
            rises: &rises[seen(rises.len())],
            blur_px: self.esf.blur_px,
            dark: bands.dark.clone(),
        };
        let contamination =
            contamination_layer::contamination(&self.bench, request, windows, &seen, with_mask)?;
        let keys = FrameKeys {
            seed: request.seed,
            frame_id: request.frame_id,
            pattern_seed: self.bench.pattern_seed,
        };
        let mut params = Params::new(windows, format, &self.levels(format), request.noise, keys);
        params.nodes = quadrature.len() as u32;
        params.band_rows = bands.rows;
        params.overlap = u32::from(bands.overlap);
        params.esf_segments = esf.per_table;
        params.esf_reach = esf.reach;
        params.esf_per_unit = esf.per_unit;
        self.light_params(&mut params, contamination.as_ref());
        params.set_dark(&bands.dark);
        Ok(Job {
            params,
            format,
            columns,
            bands,
            contamination,
            esf,
            quadrature,
            stacked: self.esf.is_stacked(),
            profiles,
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

    /// Takes a job's memory back for the next frame.
    pub fn give_back(&self, job: Job<'_>) {
        if let Some(map) = job.contamination {
            self.recycle(map);
        }
    }

    /// Takes a frame's contamination back for its memory and gives out its mask.
    pub(crate) fn recycle(&self, mut map: LightMap) -> Vec<u8> {
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

/// One over the distance of the pinhole: that of an entocentric lens, or the one whose rays cross the telecentric lens' residual
/// angle at half the diagonal.
fn per_distance(bench: &OpticalBench, outline: &Outline) -> Result<f64, RenderError> {
    let optics = &bench.nominal.optics;
    let half_mm = 0.5 * (bench.rows() as f64).hypot(bench.columns() as f64) * bench.pixel_mm;
    let per_distance = match optics.entocentric {
        Some(e) => 1.0 / e.distance_mm,
        None => (optics.telecentricity_mrad * 1e-3).tan() / half_mm,
    };
    let needed = outline.mean_radii_mm().1 + outline.largest_depth_mm() + CLEARANCE_MM;
    if per_distance.abs() * needed < 1.0 {
        return Ok(per_distance);
    }
    let right = format!("must leave the shaft in front of the lens: at least {needed:.3} mm");
    Err(RenderError::setting("optics.entocentric.distance_mm", &(1.0 / per_distance), right))
}

/// Farthest that the distortion carries a point of the sensor's border along the row, px.
fn sideways_px(bench: &OpticalBench) -> f64 {
    let distortion = &bench.nominal.optics.distortion;
    if distortion.is_none() {
        return 0.0;
    }
    let (rows, columns) = (bench.rows(), bench.columns());
    let border = (0..=16).flat_map(|i| {
        let (r, c) = ((rows - 1) as f64 * f64::from(i) / 16.0, (columns - 1) as f64 * f64::from(i) / 16.0);
        [(r, 0.0), (r, (columns - 1) as f64), (0.0, c), ((rows - 1) as f64, c)]
    });
    border.map(|(r, c)| (distortion.distort_px(r, c, rows, columns).1 - c).abs()).fold(0.0, f64::max)
}
