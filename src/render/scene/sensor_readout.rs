//! A frame whose sensor is more than the noise of its pixels: what the kernel draws of it, and what
//! the host adds ([`Readout`]).
//!
//! In: an optical setup and a request. Out: the request for the means (f32, no noise, one pixel
//! further at each border that has a neighbour on the sensor, for cross-talk) and the readout that
//! turns them into the frame. Gains and offsets of rows and columns are the camera's: normal
//! deviates by its pattern's seed, standardised over the sensor, so that a measurement after EMVA
//! 1288 finds what was set and not one draw of a few hundred rows (5 % at 200).

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::request::FrameRequest;
use super::true_optics::OpticalSetup;
use crate::frame::{PixelFormat, Roi};
use crate::render::error::RenderError;
use crate::render::kernel::noise::frame_key;
use crate::render::kernel::params::{FrameKeys, GreyLevels, MOST_COUNTS, Params, Window, Windows};
use crate::render::kernel::readout_terms::{Readout, Response, RowTerms};
use crate::render::kernel::shadowgraph::{hash, row_key, standard_normal};

/// Streams of the camera's generators, apart from each other and from the pixels' pattern.
const ROW_GAIN: u64 = 0x726f_775f_6761_696e;
const ROW_OFFSET: u64 = 0x726f_775f_6f66_6673;
const COLUMN_GAIN: u64 = 0x636f_6c5f_6761_696e;
const COLUMN_OFFSET: u64 = 0x636f_6c5f_6f66_6673;

/// Stream of the rows' temporal noise, apart from the pixels'.
const ROW_NOISE: u64 = 0x726f_775f_6e6f_6973;

/// What is drawn of a frame and what the host adds to it.
pub(super) struct SensorReadout {
    /// The request for the means.
    pub(super) means: FrameRequest,
    /// From means to counts.
    pub(super) readout: Readout,
}

impl SensorReadout {
    /// The readout of a request; none where noise and pattern of single pixels are all.
    ///
    /// # Errors
    /// Refuses a window outside the sensor.
    pub(super) fn of(setup: &OpticalSetup, request: &FrameRequest) -> Result<Option<Self>, RenderError> {
        let sensor = &setup.nominal.sensor;
        if sensor.is_plain() {
            return Ok(None);
        }
        let windows = setup.windows(request)?;
        let crosstalk =
            sensor.read_out().crosstalk_along_rel > 0.0 || sensor.read_out().crosstalk_down_rel > 0.0;
        let margins = if crosstalk { Margins::of(setup, windows) } else { Margins::default() };
        let format = setup.format(request);
        let levels = setup.levels(format);
        let keys =
            FrameKeys { seed: request.seed, frame_id: request.frame_id, pattern_seed: setup.pattern_seed };
        let mut params = Params::new(windows, format, &levels, request.noise, keys);
        // The well clips before the response, in `Response`.
        params.pixels.ceiling = MOST_COUNTS as f32;
        let readout = Readout {
            rows: row_terms(setup, request, windows, margins, &levels),
            first_column: margins.left as usize,
            column_gain: within(columns_gain(setup), windows.first.column, windows.first.columns),
            column_offset: within(
                columns_offset(setup, &levels),
                windows.first.column,
                windows.first.columns,
            ),
            response: response(setup, &levels),
            params,
            format,
        };
        Ok(Some(Self { means: margins.request(request, windows), readout }))
    }
}

/// Levels of the means: neither pattern nor full well.
pub(super) fn mean_levels(levels: &GreyLevels) -> GreyLevels {
    GreyLevels { prnu: 0.0, dsnu_e: 0.0, hot_ppm: 0.0, full_well_e: f64::INFINITY, ..*levels }
}

/// Pixels drawn beyond a frame's borders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Margins {
    top: u32,
    bottom: u32,
    left: u32,
    right: u32,
    /// Below the upper window and above the lower one, where there are two.
    between: [u32; 2],
}

impl Margins {
    /// One pixel where the sensor has one.
    fn of(setup: &OpticalSetup, windows: Windows) -> Self {
        let camera = &setup.nominal.camera;
        let first = windows.first;
        let last = windows.second.unwrap_or(first);
        let skip = windows.skip();
        Self {
            top: u32::from(first.row > 0),
            bottom: u32::from(last.row + last.rows < camera.rows),
            left: u32::from(first.column > 0),
            right: u32::from(first.column + first.columns < camera.columns),
            // Windows that touch are each other's neighbours.
            between: [u32::from(skip > 0), u32::from(skip > 1)],
        }
    }

    /// The request for the means of a frame of these windows.
    fn request(self, request: &FrameRequest, windows: Windows) -> FrameRequest {
        let widened = |window: Window, above: u32, below: u32| Roi {
            row: window.row - above,
            column: window.column - self.left,
            rows: window.rows + above + below,
            columns: window.columns + self.left + self.right,
        };
        let below = windows.second.map_or(self.bottom, |_| self.between[0]);
        FrameRequest {
            noise: false,
            format: Some(PixelFormat::F32),
            roi: Some(widened(windows.first, self.top, below)),
            second_roi: windows.second.map(|second| widened(second, self.between[1], self.bottom)),
            ..request.clone()
        }
    }
}

/// The rows of a frame: where each was drawn, and what it adds.
fn row_terms(
    setup: &OpticalSetup,
    request: &FrameRequest,
    windows: Windows,
    margins: Margins,
    levels: &GreyLevels,
) -> Vec<RowTerms> {
    let sensor = &setup.nominal.sensor;
    let (shares, seed) = (sensor.shares(), setup.pattern_seed);
    let gains = standardised(setup.rows(), seed ^ ROW_GAIN, shares.prnu_row_rel);
    let per_count = 1.0 / levels.electrons_per_count;
    let offsets = standardised(setup.rows(), seed ^ ROW_OFFSET, shares.dsnu_row_e * per_count);
    let noise = if request.noise { sensor.read_out().row_noise_e * per_count } else { 0.0 };
    let key = frame_key(request.seed ^ ROW_NOISE, request.frame_id);
    let drawn_second = margins.top + windows.first.rows + margins.between[0] + margins.between[1];
    let first = (0..windows.first.rows).map(|row| (margins.top + row, windows.first.row + row));
    let second = windows
        .second
        .into_iter()
        .flat_map(|window| (0..window.rows).map(move |row| (drawn_second + row, window.row + row)));
    let term = |(drawn, sensor_row): (u32, u32)| {
        let z = f64::from(standard_normal(hash(row_key(key, sensor_row), 0)));
        RowTerms {
            drawn: drawn as usize,
            sensor: sensor_row,
            gain: gains[sensor_row as usize] as f32,
            offset: (offsets[sensor_row as usize] + noise * z) as f32,
        }
    };
    first.chain(second).map(term).collect()
}

fn columns_gain(setup: &OpticalSetup) -> Vec<f64> {
    let share = setup.nominal.sensor.shares().prnu_column_rel;
    standardised(setup.columns(), setup.pattern_seed ^ COLUMN_GAIN, share)
}

fn columns_offset(setup: &OpticalSetup, levels: &GreyLevels) -> Vec<f64> {
    let share = setup.nominal.sensor.shares().dsnu_column_e / levels.electrons_per_count;
    standardised(setup.columns(), setup.pattern_seed ^ COLUMN_OFFSET, share)
}

fn within(all: Vec<f64>, first: u32, count: u32) -> Vec<f32> {
    all.into_iter().skip(first as usize).take(count as usize).map(|v| v as f32).collect()
}

/// Neighbours' shares and response, counts of the frame's format.
fn response(setup: &OpticalSetup, levels: &GreyLevels) -> Response {
    let readout = setup.nominal.sensor.read_out();
    let full_well = levels.full_well_e / levels.electrons_per_count;
    Response {
        along: readout.crosstalk_along_rel as f32,
        down: readout.crosstalk_down_rel as f32,
        full_well: full_well.min(MOST_COUNTS) as f32,
        quadratic: (readout.quadratic_rel / full_well.max(1.0)) as f32,
        cubic: (readout.cubic_rel / full_well.max(1.0).powi(2)) as f32,
    }
}

/// Normal deviates of which mean and standard deviation over all of them are 0 and `deviation`.
/// Fewer than two have none.
fn standardised(count: usize, seed: u64, deviation: f64) -> Vec<f64> {
    if deviation == 0.0 || count < 2 {
        return vec![0.0; count];
    }
    let mut random = Pcg64::seed_from_u64(seed);
    let draws: Vec<f64> = (0..count).map(|_| StandardNormal.sample(&mut random)).collect();
    let mean = draws.iter().sum::<f64>() / count as f64;
    let variance = draws.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / count as f64;
    let scale = deviation / variance.sqrt();
    draws.into_iter().map(|d| (d - mean) * scale).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_have_exactly_the_deviation_asked_for() {
        for count in [2, 7, 200] {
            let draws = standardised(count, 5, 0.3);
            let mean = draws.iter().sum::<f64>() / count as f64;
            let variance = draws.iter().map(|d| d * d).sum::<f64>() / count as f64;
            assert!(mean.abs() < 1e-12 && (variance.sqrt() - 0.3).abs() < 1e-12, "{count}");
        }
        assert_eq!(standardised(1, 5, 0.3), [0.0]);
        assert_ne!(standardised(9, 5, 0.3), standardised(9, 6, 0.3));
    }
}
