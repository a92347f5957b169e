//! What `--picture FILE` keeps: the newest frame as a page shows it, with the edges found in it.
//!
//! The file is replaced as a whole, a few times a second: the length of a JSON text (32 bits,
//! little-endian), that text, and an 8-bit PNG. The PNG has every row and at most 512 columns, each
//! taken as it is and not averaged, so that a column of it is a grey profile of the camera. The
//! text has the frame's name and size, the number of columns from one shown to the next, and the
//! rows of both edges at each. Frames are sampled in the thread that measures (half a millisecond)
//! and written by another one; while it writes, frames are left out: the newest wins.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use serde_json::{Value, json};

use crate::cli::failure::Failure;
use crate::frame::FrameView;
use crate::gauge::{Edge, FrameEdges};
use crate::measurement::Measurement;

/// Most columns: a page is seldom wider, and 512 × 2048 are compressed in ten milliseconds.
const MOST_COLUMNS: usize = 512;
/// Time between pictures, s: five a second are seen as motion, and cost a tenth of a core.
const EVERY_S: f64 = 0.2;

/// The frame that is shown.
#[derive(Clone, Copy)]
pub(super) struct Pictured<'a> {
    /// Number of the frame in the lines of `--json`.
    pub(super) number: u64,
    /// Its pixels as they were measured: the axis along the rows.
    pub(super) view: FrameView<'a>,
    /// Its edges; none where it was refused.
    pub(super) edges: Option<&'a FrameEdges>,
    /// What makes diameters of their distances.
    pub(super) scale: PictureScale,
}

/// What makes diameters of distances of edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct PictureScale {
    /// Pitch of columns, mm; 1 px in pixels.
    pub(super) pitch: f64,
    /// Diameter over its distance in pixels, as the frame's largest diameter has it: with scale,
    /// slope of the axis, temperature and pin.
    pub(super) per_px: f64,
    /// Standard uncertainty that all columns share beside the edges.
    pub(super) u_common: f64,
    /// Coverage factor.
    pub(super) k: f64,
    /// `mm` or `px`.
    pub(super) unit: &'static str,
}

impl PictureScale {
    /// That of a measured frame; `pitch` in mm per px, or 1 in pixels.
    pub(super) fn of(measurement: &Measurement, pitch: f64) -> Self {
        let in_px = Self { pitch: 1.0, per_px: 1.0, u_common: 0.0, k: 2.0, unit: "px" };
        let Some(mm) = &measurement.diameter else { return in_px };
        let per_px = measurement.largest.as_ref().map(|px| mm.diameter.d_mm / px.diameter_px);
        Self {
            pitch,
            per_px: per_px.filter(|scale| scale.is_finite()).unwrap_or(pitch),
            u_common: mm.diameter.u_common_mm,
            k: mm.coverage_factor,
            unit: "mm",
        }
    }

    /// Diameter and U in a column; none in a gap.
    fn diameter(&self, edges: &FrameEdges, column: usize) -> Option<[f64; 2]> {
        let width_px = edges.width_px(column)?;
        let (top, bottom) = (edges.top.get(column)?, edges.bottom.get(column)?);
        let u_px = [top.u_own_px, top.u_shared_px, bottom.u_own_px, bottom.u_shared_px];
        let squares = u_px.iter().map(|&u| (self.per_px * f64::from(u)).powi(2)).sum::<f64>();
        Some([self.per_px * width_px, self.k * (squares + self.u_common.powi(2)).sqrt()])
    }
}

/// A frame on its way to the file.
struct Sampled {
    head: Value,
    columns: usize,
    grey: Vec<u8>,
}

/// The file that is replaced again and again.
pub(super) struct Picture {
    to: Option<SyncSender<Sampled>>,
    thread: Option<JoinHandle<()>>,
    next_s: f64,
}

impl Picture {
    /// Begins; the first picture must be written.
    ///
    /// # Errors
    /// Exit 3 where the folder cannot be written.
    pub(super) fn begin(path: &Path) -> Result<Self, Failure> {
        let failed = |error: io::Error| Failure::fail(format!("--picture {}: {error}", path.display()));
        let beside = beside(path);
        fs::write(&beside, []).and_then(|()| fs::remove_file(&beside)).map_err(failed)?;
        let (to, from) = sync_channel(0);
        let path = path.to_owned();
        let write = move || written(&from, &path, &beside);
        let thread = std::thread::Builder::new().name("picture".to_owned()).spawn(write).map_err(failed)?;
        Ok(Self { to: Some(to), thread: Some(thread), next_s: 0.0 })
    }

    /// Whether it is time for another one.
    pub(super) fn is_due(&self, t_s: f64) -> bool {
        t_s >= self.next_s
    }

    /// Shows a frame; where the one before is still being written, it is left out.
    pub(super) fn show(&mut self, t_s: f64, frame: Pictured<'_>) {
        if let Some(to) = self.to.as_ref().filter(|_| self.is_due(t_s))
            && to.try_send(sampled(frame)).is_ok()
        {
            self.next_s = t_s + EVERY_S;
        }
    }
}

impl Drop for Picture {
    fn drop(&mut self) {
        self.to = None;
        if let Some(thread) = self.thread.take() {
            // no result: what cannot be written was logged
            let _ = thread.join();
        }
    }
}

/// The file that is renamed to `path` when it is whole.
fn beside(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    path.with_file_name(name)
}

fn written(from: &Receiver<Sampled>, path: &Path, beside: &Path) {
    let mut has_failed = false;
    for frame in from {
        let done = contents(&frame)
            .and_then(|bytes| fs::write(beside, bytes).and_then(|()| fs::rename(beside, path)));
        if let Err(error) = &done
            && !has_failed
        {
            tracing::warn!("{}: the picture is not written: {error}", path.display());
        }
        has_failed = done.is_err();
    }
}

fn contents(frame: &Sampled) -> io::Result<Vec<u8>> {
    let head = frame.head.to_string().into_bytes();
    let length = u32::try_from(head.len()).map_err(io::Error::other)?;
    let mut bytes = [&length.to_le_bytes()[..], &head].concat();
    let rows = frame.grey.len() / frame.columns;
    let mut encoder = png::Encoder::new(&mut bytes, frame.columns as u32, rows as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&frame.grey));
    written.map(|()| bytes).map_err(io::Error::other)
}

/// Every row of some columns, as 8 bits.
fn sampled(frame: Pictured<'_>) -> Sampled {
    let (rows, all) = (frame.view.rows(), frame.view.columns());
    let step = all.div_ceil(MOST_COLUMNS).max(1);
    let columns = all.div_ceil(step);
    let to_8_bits = 255.0 / frame.view.full_scale().unwrap_or(1.0);
    let mut grey = Vec::with_capacity(rows * columns);
    for row in 0..rows {
        let at = |k: usize| frame.view.get(row, k * step).unwrap_or_default();
        grey.extend((0..columns).map(|k| (at(k) * to_8_bits).round().clamp(0.0, 255.0) as u8));
    }
    let along = |edges: &[Edge]| -> Vec<Option<f64>> {
        let row = |k| edges.get(k * step).filter(|e: &&Edge| e.is_usable()).map(|e| rounded(e.row_px));
        (0..columns).map(row).collect()
    };
    let [top, bottom] = match frame.edges {
        Some(edges) => [along(&edges.top), along(&edges.bottom)],
        None => [Vec::new(), Vec::new()],
    };
    let number = frame.number;
    let profile: Vec<Option<[f64; 2]>> = frame
        .edges
        .map_or_else(Vec::new, |edges| (0..columns).map(|k| frame.scale.diameter(edges, k * step)).collect());
    let of = |which: usize| -> Vec<Option<f64>> {
        // nine digits are an ångström of a millimetre: half of the bytes
        profile.iter().map(|at| at.map(|values| (values[which] * 1e7).round() * 1e-7)).collect()
    };
    let unit = frame.scale.unit;
    let mut head = json!({
        "frame": number, "rows": rows, "columns": all, "column_step": step, "top_px": top, "bottom_px": bottom,
        "grey_full_scale": frame.view.full_scale(), "unit": unit, "pitch": frame.scale.pitch,
    });
    head[format!("d_{unit}")] = json!(of(0));
    head[format!("expanded_u_{unit}")] = json!(of(1));
    Sampled { head, columns, grey }
}

/// To a thousandth of a pixel: less than is seen, and half of the bytes.
fn rounded(px: f64) -> f64 {
    (px * 1e3).round() / 1e3
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::{Picture, PictureScale, Pictured};
    use crate::frame::{FrameView, PixelFormat, Pixels};
    use crate::gauge::{Edge, EdgeState, FrameEdges};
    use crate::profile::Reason;

    #[test]
    fn a_picture_has_every_row_of_its_columns_and_the_edges_there() {
        let (rows, columns) = (3_usize, 1025_usize);
        let grey: Vec<u16> =
            (0..rows * columns).map(|k| ((k / columns) * 1000 + k % columns) as u16).collect();
        let view = FrameView::new(Pixels::U16(&grey), PixelFormat::Mono12, rows, columns, columns).unwrap();
        let edge = |row_px| Edge { row_px, ..Edge::gap(Reason::Implausible) };
        let edges = FrameEdges {
            top: vec![edge(0.5); columns],
            bottom: vec![edge(1.5); columns],
            ..FrameEdges::default()
        };
        let scale = PictureScale { pitch: 0.02, per_px: 0.021, u_common: 1e-4, k: 2.0, unit: "mm" };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("now.bin");
        let mut picture = Picture::begin(&path).unwrap();
        while !path.exists() {
            picture.show(0.0, Pictured { number: 7, view, edges: Some(&edges), scale });
            std::thread::yield_now();
        }
        drop(picture);
        let bytes = std::fs::read(&path).unwrap();
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        let head: Value = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
        assert_eq!((&head["frame"], &head["column_step"]), (&7.into(), &3.into()));
        // gaps are no edges
        let top = head["top_px"].as_array().unwrap();
        assert!(top.len() == 342 && top.iter().all(Value::is_null), "{head}");
        assert!(head["d_mm"].as_array().unwrap().iter().all(Value::is_null), "{head}");
        let shown = image::load_from_memory(&bytes[4 + length..]).unwrap().into_luma8();
        assert_eq!(shown.dimensions(), (342, 3));
        let expected = |row: f64, column: f64| ((row * 1000.0 + 3.0 * column) * 255.0 / 4095.0).round() as u8;
        assert_eq!(shown.get_pixel(100, 2).0[0], expected(2.0, 100.0));
    }
    #[test]
    fn a_diameter_of_a_column_has_what_its_edges_and_the_frame_do_not_know() {
        let edge =
            |row_px| Edge { row_px, u_own_px: 0.03, u_shared_px: 0.04, chi2: 1.0, state: EdgeState::Good };
        let edges =
            FrameEdges { top: vec![edge(10.0); 3], bottom: vec![edge(110.0); 3], ..FrameEdges::default() };
        let scale = PictureScale { pitch: 0.02, per_px: 0.02, u_common: 0.001, k: 2.0, unit: "mm" };
        let [d, u] = scale.diameter(&edges, 1).unwrap();
        // two edges of .05 px at 20 um/px are 1.414 um, with 1 um beside: 1.732 um
        assert!((d - 0.02 * edges.width_px(1).unwrap()).abs() < 1e-12, "{d}");
        assert!((u - 2.0 * 3e-6_f64.sqrt()).abs() < 1e-9, "{u}");
        assert_eq!(scale.diameter(&edges, 3), None);
    }
}
