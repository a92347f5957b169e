//! The true optical setup: drawn by seed around the nominal settings. Only `truth` may use it.

use std::sync::Arc;

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::request::FrameRequest;
use crate::frame::{FrameMeta, PixelFormat, Roi};
use crate::render::contamination::{ContaminationModel, FieldGeometry};
use crate::render::error::RenderError;
use crate::render::kernel::job::Job;
use crate::render::kernel::light_map::LightMap;
use crate::render::kernel::params::{GreyLevels, Window, Windows};
use crate::render::optics::esf_table::{EsfTable, Extent, TableCache};
use crate::render::settings::{Esf, Optics, SetupSettings};

/// Stream of the generator that departures are drawn from, apart from every other use of the same
/// seed.
const DEPARTURE_STREAM: u64 = 0x6465_7061_7274;

/// Stream of the sensor's fixed pattern.
const PATTERN_STREAM: u64 = 0x0070_6174_7465_726e;

/// Stream of the contamination.
const CONTAMINATION_STREAM: u64 = 0x0000_0000_736f_696c;

/// Limit of the draws, standard deviations, so that no seed yields an absurd lens.
const LARGEST_DRAW: f64 = 2.5;

/// True camera, lens, light and sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct OpticalSetup {
    /// The nominal settings from which it was drawn.
    pub nominal: SetupSettings,
    /// True size of a pixel on the object, mm.
    pub pixel_mm: f64,
    /// True edge spread, in image pixels.
    pub esf: Esf,
    /// True electrons per count.
    pub electrons_per_count: f64,
    /// Cache of edge-spread tables.
    pub tables: TableCache,
    /// Key of the sensor's fixed pattern: the same camera in every frame.
    pub pattern_seed: u64,
    /// The contamination, if any.
    pub contamination: Option<Arc<ContaminationModel>>,
}

impl OpticalSetup {
    /// Draws the true optical setup; the same settings and seed give the same optical setup.
    ///
    /// # Errors
    /// Refuses settings outside their ranges, naming the key.
    pub fn resolve(settings: &SetupSettings, seed: u64) -> Result<Self, RenderError> {
        settings.check()?;
        let mut random = Pcg64::seed_from_u64(seed ^ DEPARTURE_STREAM);
        let mut factor = |relative: f64| {
            let draw: f64 = StandardNormal.sample(&mut random);
            1.0 + relative * draw.clamp(-LARGEST_DRAW, LARGEST_DRAW)
        };
        let departures = &settings.departures;
        let magnification = settings.optics.magnification * factor(departures.magnification_rel);
        let blur = factor(departures.blur_rel);
        let gain = factor(departures.gain_rel);
        let pixel_mm = settings.camera.pixel_um * 1e-3 / magnification;
        let esf = scaled_blur(&settings.optics.esf, blur);
        let contamination = contamination(settings, &esf, pixel_mm, seed)?;
        Ok(Self {
            nominal: settings.clone(),
            tables: TableCache::default(),
            pixel_mm,
            esf,
            contamination: contamination.map(Arc::new),
            electrons_per_count: settings.sensor.electrons_per_count * gain,
            pattern_seed: seed ^ PATTERN_STREAM,
        })
    }

    /// Rows of the full sensor.
    pub(crate) fn rows(&self) -> usize {
        self.nominal.camera.rows as usize
    }

    /// Columns of the full sensor.
    pub(crate) fn columns(&self) -> usize {
        self.nominal.camera.columns as usize
    }

    /// Row of the optical axis: (rows - 1)/2.
    pub(crate) fn centre_row(&self) -> f64 {
        (self.rows() as f64 - 1.0) / 2.0
    }

    /// Column of the optical axis: (columns - 1)/2.
    pub(crate) fn centre_column(&self) -> f64 {
        (self.columns() as f64 - 1.0) / 2.0
    }

    /// Machine z, mm, of a column of the full sensor with the field's centre at `field_z_mm`.
    pub(crate) fn column_z_mm(&self, field_z_mm: f64, column: f64) -> f64 {
        field_z_mm + (column - self.centre_column()) * self.pixel_mm
    }

    /// Row of the full sensor that shows a height `x_mm` above the optical axis.
    pub(crate) fn row_of_x(&self, x_mm: f64) -> f64 {
        self.centre_row() - x_mm / self.pixel_mm
    }

    /// The one or two windows of the sensor that a request reads.
    ///
    /// # Errors
    /// Refuses a window that is empty or leaves the sensor, and a second one that is not below the
    /// first or has other columns.
    pub(crate) fn windows(&self, request: &FrameRequest) -> Result<Windows, RenderError> {
        let first = self.window(request.roi, "roi")?;
        let Some(roi) = request.second_roi else { return Ok(Windows { first, second: None }) };
        let second = self.window(Some(roi), "second_roi")?;
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

    fn window(&self, roi: Option<Roi>, key: &'static str) -> Result<Window, RenderError> {
        let (rows, columns) = (self.nominal.camera.rows, self.nominal.camera.columns);
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

    /// Levels in counts of the requested format; noise and pattern are the shares that pixels have
    /// for themselves.
    pub(crate) fn levels(&self, format: PixelFormat) -> GreyLevels {
        let nominal = &self.nominal;
        let dark = nominal.sensor.dark_signal(nominal.camera.exposure_us);
        // In every pixel, lit or not: the black level of the exposure, and less room in the well.
        let counts = dark.mean_e / self.electrons_per_count;
        GreyLevels {
            shadow: nominal.light.shadow_counts + counts,
            bright: nominal.light.bright_in(&nominal.sensor, self.electrons_per_count) + counts,
            black: nominal.sensor.black_level_counts + counts,
            electrons_per_count: self.electrons_per_count,
            read_noise_e: dark.noise_e(nominal.sensor.pixel_noise_e()),
            full_well_e: (nominal.sensor.full_well_e - dark.mean_e).max(0.0),
            prnu: nominal.sensor.pixel_prnu_rel(),
            dsnu_e: dark.dsnu_e(nominal.sensor.pixel_dsnu_e()),
            hot_ppm: nominal.sensor.hot_pixels_ppm,
            hot_pixel_e: nominal.sensor.hot_pixel_e,
        }
        .in_format(nominal.sensor.format, format)
    }

    /// Format of the requested frame.
    pub(crate) fn format(&self, request: &FrameRequest) -> PixelFormat {
        request.format.unwrap_or(self.nominal.sensor.format)
    }

    /// Metadata of the requested frame.
    pub(crate) fn meta(&self, request: &FrameRequest) -> FrameMeta {
        FrameMeta {
            frame_id: request.frame_id,
            t_ns: request.t_ns,
            exposure_us: self.nominal.camera.exposure_us,
            angle_deg: request.angle_deg,
            z_mm: request.z_mm,
            roi: request.roi,
            ..FrameMeta::default()
        }
    }

    /// Takes back the memory of a frame's contamination and returns its mask.
    pub(crate) fn recycle(&self, mut map: LightMap) -> Vec<u8> {
        let mask = std::mem::take(&mut map.mask);
        if let Some(contamination) = &self.contamination {
            contamination.recycle(map);
        }
        mask
    }

    /// Takes back a job's memory for the next frame.
    pub(crate) fn give_back(&self, job: Job<'_>) {
        if let Some(map) = job.contamination {
            self.recycle(map);
        }
    }
}

/// The contamination with the true optics; its defocus is determined by the smaller aperture.
fn contamination(
    settings: &SetupSettings,
    esf: &Esf,
    pixel_mm: f64,
    seed: u64,
) -> Result<Option<ContaminationModel>, RenderError> {
    if settings.contamination.is_clean() {
        return Ok(None);
    }
    let effective_na = match esf {
        Esf::PartiallyCoherent(p) => p.na * p.coherence_ratio.min(1.0),
        Esf::Cylinder(c) => c.na * c.coherence_ratio.min(1.0),
        _ => settings.optics.defocus_na,
    };
    let dull = Optics { reflection: None, aberrations: Vec::new(), ..settings.optics.clone() };
    // Contamination is thin, whatever the part.
    let thin = match esf {
        Esf::Cylinder(c) => Esf::PartiallyCoherent(c.thin()),
        other => other.clone(),
    };
    let in_focus = Extent { pixel_mm, depth_mm: 0.0, radius_mm: (1.0, 1.0) };
    let geometry = FieldGeometry {
        rows: settings.camera.rows as usize,
        columns: settings.camera.columns as usize,
        pixel_um: pixel_mm * 1e3,
        effective_na,
        sigma_um: EsfTable::new(&thin, &dull, &in_focus)?.blur_px * pixel_mm * 1e3,
    };
    ContaminationModel::new(&settings.contamination, geometry, seed ^ CONTAMINATION_STREAM)
}

fn scaled_blur(esf: &Esf, factor: f64) -> Esf {
    match esf {
        Esf::Gaussian(g) => {
            let mut scaled = g.clone();
            scaled.sigma_px *= factor;
            Esf::Gaussian(scaled)
        }
        Esf::PartiallyCoherent(p) => {
            let mut scaled = p.clone();
            scaled.na /= factor;
            Esf::PartiallyCoherent(scaled)
        }
        Esf::Cylinder(c) => {
            let mut scaled = c.clone();
            scaled.na /= factor;
            Esf::Cylinder(scaled)
        }
        Esf::Fresnel(f) => {
            let mut scaled = f.clone();
            scaled.distance_mm *= factor * factor;
            Esf::Fresnel(scaled)
        }
        Esf::Measured(m) => {
            let mut scaled = m.clone();
            scaled.d_um.iter_mut().for_each(|d| *d *= factor);
            Esf::Measured(scaled)
        }
    }
}
