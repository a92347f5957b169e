//! A series of 200 frames from this program's own source: what `shadowgauge measure --json` prints
//! of the same frames as files.

use std::error::Error;

use shadowgauge::frame::FrameSource;
use shadowgauge::gauge::{Calibration, Gauge, GaugeSettings};
use shadowgauge::measurement::{Document, MeasureSettings, Stream};

use crate::drawn_frames::{DrawnFrames, UM_PER_PX};

/// Measures all frames; the document as JSON.
pub fn measured() -> Result<String, Box<dyn Error>> {
    let gauge = Gauge::new(GaugeSettings::default())?;
    let calibration = Calibration::from_scale(UM_PER_PX);
    let mut stream = Stream::calibrated(&gauge, &calibration, MeasureSettings::default())?;
    let (mut source, mut frames) = (DrawnFrames::default(), Vec::new());
    while let Some(frame) = source.next_frame()? {
        frames.push(stream.push(&frame.meta, &frame.view())?.clone());
        source.recycle(frame);
    }
    let series = stream.finish()?;
    Ok(serde_json::to_string(&Document { frames: &frames, series: &series, bench: None })?)
}
