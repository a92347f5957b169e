//! A source of frames of one's own: the shadow of a shaft that grows from frame to frame, drawn in
//! closed form. Imports nothing but the vocabulary, so that a crate beside this one may use it too.
#![allow(dead_code, reason = "not every test uses every helper")]

use shadowgauge::frame::{Buffer, Frame, FrameMeta, FrameSource, PixelFormat, SourceError};

pub const ROWS: usize = 64;
pub const COLUMNS: usize = 128;
pub const FRAMES: u64 = 200;
/// Scale, µm per pixel.
pub const UM_PER_PX: f64 = 20.0;
/// Width of the shadow in the first frame, px, and its growth from frame to frame: over 200 frames
/// every sub-pixel phase comes up.
const WIDTH_PX: (f64, f64) = (28.0, 0.013);
/// Blur of the edge as a logistic's length, px: a Gaussian of 0.9 px has about its slope.
const BLUR_PX: f64 = 0.56;
/// Counts of 8 bits in the shadow and in the light.
const LEVELS: (f64, f64) = (18.0, 214.0);
/// Half width of the noise, counts: rounding alone would repeat in every column.
const NOISE: f64 = 1.5;

/// True width of the shadow of a frame, px.
pub fn width_px(frame_id: u64) -> f64 {
    WIDTH_PX.0 + WIDTH_PX.1 * frame_id as f64
}

/// Uniform in -1 to 1 from a counter (splitmix64).
fn uniform(counter: u64) -> f64 {
    let mut z = counter.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    2.0 * (z ^ (z >> 31)) as f64 / u64::MAX as f64 - 1.0
}

/// Counts of a frame, row by row.
pub fn counts(frame_id: u64) -> Vec<u8> {
    let half_px = 0.5 * width_px(frame_id);
    let pixel = |index: usize| {
        let (row, column) = (index / COLUMNS, index % COLUMNS);
        // The axis is a little tilted, so that the columns differ in their phase.
        let axis_px = 31.4 + 0.004 * column as f64;
        let outside_px = (row as f64 - axis_px).abs() - half_px;
        let light = 1.0 / (1.0 + (-outside_px / BLUR_PX).exp());
        let noise = NOISE * uniform(frame_id * (ROWS * COLUMNS) as u64 + index as u64);
        (LEVELS.0 + (LEVELS.1 - LEVELS.0) * light + noise).round() as u8
    };
    (0..ROWS * COLUMNS).map(pixel).collect()
}

/// Draws frame after frame.
#[derive(Debug, Default)]
pub struct DrawnFrames {
    next: u64,
}

impl FrameSource for DrawnFrames {
    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        if self.next == FRAMES {
            return Ok(None);
        }
        let frame_id = self.next;
        self.next += 1;
        let meta = FrameMeta { frame_id, ..FrameMeta::default() };
        let frame = Frame::new(Buffer::U8(counts(frame_id)), PixelFormat::Mono8, ROWS, COLUMNS, meta);
        let failed = |e| SourceError { what: format!("frame {frame_id}"), cause: Some(Box::new(e)) };
        frame.map(Some).map_err(failed)
    }
}
