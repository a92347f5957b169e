//! A series of 200 frames from this program's own source, measured one after another.

use std::error::Error;
use std::time::Instant;

use serde_json::{Value, json};
use shadowgauge::frame::{Frame, FrameMeta, FrameSource, SourceError};
use shadowgauge::gauge::{FrameEdges, Gauge, GaugeSettings};

use crate::drawing::{COLUMNS, MM_PER_PX, draw};

const FRAMES: u64 = 200;
/// Diameter of the shaft in the first frame and its growth a frame, mm.
const DIAMETER_MM: (f64, f64) = (11.8, 0.001);

/// A camera of one's own.
struct Growing {
    next: u64,
}

fn diameter_mm(frame_id: u64) -> f64 {
    DIAMETER_MM.0 + DIAMETER_MM.1 * frame_id as f64
}

impl FrameSource for Growing {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        if self.next == FRAMES {
            return Ok(None);
        }
        let frame_id = self.next;
        self.next += 1;
        let meta = FrameMeta { frame_id, ..FrameMeta::default() };
        let failed = |cause| SourceError { what: format!("frame {frame_id}"), cause: Some(cause) };
        draw(|_| diameter_mm(frame_id), 0.3, meta).map(Some).map_err(failed)
    }
}

/// Measures all frames: how many, how many edges, and the largest difference of a frame's mean
/// width from the true one, px.
pub fn measured() -> Result<Value, Box<dyn Error>> {
    let gauge = Gauge::new(GaugeSettings::default())?;
    let (mut stream, mut edges, mut source) = (gauge.stream(), FrameEdges::default(), Growing { next: 0 });
    let (mut frames, mut columns, mut worst_px) = (0, 0, 0.0_f64);
    let start = Instant::now();
    while let Some(frame) = source.next_frame()? {
        stream.measure(&frame.view(), &mut edges)?;
        let widths: Vec<f64> = (0..COLUMNS).filter_map(|column| edges.width_px(column)).collect();
        let mean_px = widths.iter().sum::<f64>() / widths.len() as f64;
        worst_px = worst_px.max((mean_px - diameter_mm(frame.meta.frame_id) / MM_PER_PX).abs());
        frames += 1;
        columns += widths.len();
        source.recycle(frame);
    }
    Ok(json!({
        "frames": frames,
        "columns": columns,
        "worst_px": worst_px,
        "seconds": start.elapsed().as_secs_f64(),
    }))
}
