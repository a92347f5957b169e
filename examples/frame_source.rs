//! A source of frames of one's own, measured as a stream: `cargo run --example frame_source`.

use std::error::Error;

use shadowgauge::frame::{Buffer, Frame, FrameMeta, FrameSource, PixelFormat, SourceError};
use shadowgauge::gauge::{Calibration, Gauge, GaugeSettings};
use shadowgauge::measurement::{MeasureSettings, Stream};

const ROWS: usize = 140;
const COLUMNS: usize = 64;

/// Frames of a shaft that grows by a tenth of a pixel from frame to frame; a camera stands in its
/// place.
struct Camera {
    frames: u64,
}

/// Light on a pixel outside the shadow by so many pixels: all of it, none, or a share.
fn light(outside_px: f64) -> f64 {
    (outside_px + 0.5).clamp(0.0, 1.0)
}

impl FrameSource for Camera {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        if self.frames == 10 {
            return Ok(None);
        }
        let meta = FrameMeta { frame_id: self.frames, ..FrameMeta::default() };
        let half_px = 30.0 + 0.05 * self.frames as f64;
        self.frames += 1;
        let grey = |row: usize| 12.0 + 198.0 * light((row as f64 - 69.8).abs() - half_px);
        let counts = (0..ROWS * COLUMNS).map(|i| grey(i / COLUMNS) as u8).collect();
        let failed = |e| SourceError { what: "a frame".to_owned(), cause: Some(Box::new(e)) };
        Frame::new(Buffer::U8(counts), PixelFormat::Mono8, ROWS, COLUMNS, meta).map(Some).map_err(failed)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let gauge = Gauge::new(GaugeSettings::default())?;
    let calibration = Calibration::from_scale(17.4);
    let mut stream = Stream::calibrated(&gauge, &calibration, MeasureSettings::default())?;
    let mut camera = Camera { frames: 0 };
    while let Some(frame) = camera.next_frame()? {
        match stream.push(&frame.meta, &frame.view()) {
            Ok(measured) => {
                let d = measured.mean.ok_or("no column has both edges")?;
                println!("frame {}: {:.4} mm, u {:.4} mm", measured.frame, d.d_mm, d.u_mm());
            }
            Err(refused) => println!("{refused}"),
        }
        camera.recycle(frame);
    }
    println!("{}", serde_json::to_string(&stream.finish()?)?);
    Ok(())
}
