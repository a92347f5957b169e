//! The published head: the camera without a network (`state`), and over the loopback interface with
//! a client of its own (`wire`), on drawn frames; any session of any clients (`hostile`).

mod hostile;
mod state;
mod wire;

#[path = "../../support/gige_client.rs"]
pub(super) mod gige_client;
#[path = "../../../fuzz/session.rs"]
mod session;

use shadowgauge::frame::{Buffer, Frame, FrameMeta, PixelFormat};
use shadowgauge::publish::DataSheet;
use shadowgauge::publish::head::{FrameMaker, FrameOrder, PassOrder};

fn sheet() -> DataSheet {
    DataSheet::of_tests()
}

/// Grey value of a pixel of frame `number`: a hash, so that no frame and no row is like another.
fn grey(number: u64, row: u32, column: u32) -> u16 {
    let key = number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ u64::from(row) << 20 ^ u64::from(column);
    (key.wrapping_mul(0xd1b5_4a32_d192_ed03) >> 40) as u16
}

/// Draws hashes; a pass with an offset above 1 mm is refused, and so is a shaft of 3 mm.
#[derive(Debug, Default)]
struct DrawnHead {
    passes: Vec<PassOrder>,
}

impl FrameMaker for DrawnHead {
    fn frame(&mut self, order: &FrameOrder, _reuse: Option<Frame>) -> Result<Frame, String> {
        if order.scene.diameter_mm == 3.0 {
            return Err("no shaft of 3 mm".into());
        }
        let w = order.window;
        let mask = order.format.full_scale().unwrap();
        let place = |k: u32| (w.row + k / w.columns, w.column + k % w.columns);
        let all = (0..w.rows * w.columns).map(place).map(|(r, c)| grey(order.number, r, c) & mask);
        let buffer = match order.format {
            PixelFormat::Mono8 => Buffer::U8(all.map(|v| v as u8).collect()),
            _ => Buffer::U16(all.collect()),
        };
        Ok(Frame::new(buffer, order.format, w.rows as usize, w.columns as usize, FrameMeta::default())
            .unwrap())
    }

    fn cut(&mut self, order: &PassOrder) -> Result<(), String> {
        if order.offset_mm.iter().any(|o| *o > 1.0) {
            return Err("an offset of more than 1 mm".into());
        }
        self.passes.push(order.clone());
        Ok(())
    }
}
