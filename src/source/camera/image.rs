//! Blocks of a stream to frames: the seven grey formats, whole and of one size.

use viva_genicam::pfnc::PixelFormat as Pfnc;
use viva_genicam::{Frame as Block, FrameStatus};

use super::error::{CameraError, SUPPORTED};
use super::features::Features;
use crate::frame::{Frame, FrameMeta};
use crate::source::raw::RawLayout;
use crate::source::spare::Spare;

/// Size and pixel format that every frame of a camera has.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ImageLayout {
    columns: u32,
    rows: u32,
    format: Pfnc,
    layout: RawLayout,
}

fn shown(columns: u32, rows: u32, format: Pfnc) -> String {
    format!("{columns} x {rows} {format}")
}

impl std::fmt::Display for ImageLayout {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&shown(self.columns, self.rows, self.format))
    }
}

impl ImageLayout {
    /// The layout that a camera is set to.
    ///
    /// # Errors
    /// A format that is not read, with those of it that the camera has; no size.
    pub(super) fn of(camera: &impl Features) -> Result<Self, CameraError> {
        let found = camera.value("PixelFormat").unwrap_or_else(|| "not stated".to_owned());
        let side = |name: &'static str| {
            let pixels =
                camera.number(name).filter(|pixels| *pixels >= 1.0 && *pixels <= f64::from(u32::MAX));
            let why = || CameraError::failed("size of the frames", format!("{name} is not stated"));
            pixels.map(|pixels| pixels as u32).ok_or_else(why)
        };
        let (columns, rows) = (side("Width")?, side("Height")?);
        let is_read = |name: &str| format!("1x1:{name}").parse::<RawLayout>().is_ok();
        if !is_read(&found) {
            let all = camera.entries("PixelFormat");
            let offered: Vec<String> = all.into_iter().filter(|name| is_read(name)).collect();
            let offered = match offered.is_empty() {
                true => format!(", and the camera has none of them ({SUPPORTED})"),
                false => format!("; set the camera to {}", offered.join(" or ")),
            };
            return Err(CameraError::Format { found, offered });
        }
        let layout = format!("{columns}x{rows}:{found}").parse::<RawLayout>();
        let layout = layout.map_err(|why| CameraError::failed("size of the frames", why))?;
        Ok(Self { columns, rows, format: Pfnc::from_name(&found), layout })
    }

    /// The frame of a block, in the block's own memory where its bytes are the pixels.
    ///
    /// # Errors
    /// Why a block is refused: it is incomplete, or of another size or format.
    pub(super) fn frame(&self, block: Block, meta: FrameMeta, spare: &Spare) -> Result<Frame, String> {
        match block.status {
            FrameStatus::Complete => {}
            FrameStatus::Incomplete { missing_packets } => {
                return Err(format!("{missing_packets} packets are missing"));
            }
            FrameStatus::TrailerMissing => return Err("its last packet is missing".to_owned()),
            FrameStatus::DeviceStatus(status) => return Err(format!("the camera reports {status}")),
            _ => return Err("it is not whole".to_owned()),
        }
        // A trailer that leaves its number of rows out has 0 there.
        let delivered = block.delivered_height.filter(|rows| *rows > 0).unwrap_or(block.height);
        let (columns, rows) = (block.width, delivered.min(block.height));
        if (columns, rows, block.pixel_format) != (self.columns, self.rows, self.format) {
            return Err(format!("{} came in place of {self}", shown(columns, rows, block.pixel_format)));
        }
        let bytes = self.without_padding(block)?;
        self.layout.decode_owned(bytes, meta, spare).map_err(|why| why.to_string())
    }

    /// The bytes of the rows, one after another.
    fn without_padding(&self, block: Block) -> Result<Vec<u8>, String> {
        let Some(stride) = block.row_stride().filter(|_| block.padding_x > 0) else {
            // The last owner of the memory has it without a copy.
            drop((block.chunks, block.raw_payload));
            return Ok(block.payload.into());
        };
        let row = stride - usize::from(block.padding_x);
        if row as u64 * u64::from(self.rows) != self.layout.bytes() {
            let why = "rows of packed pixels that end within a byte are padded";
            return Err(format!("{why}; set an even Width, or a format that is not packed"));
        }
        let rows: Option<Vec<&[u8]>> =
            (0..self.rows as usize).map(|k| block.payload.get(k * stride..k * stride + row)).collect();
        rows.map(|rows| rows.concat()).ok_or_else(|| "the block ends within a row".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::super::features::Stated;
    use super::*;
    use crate::frame::Pixels;

    fn layout(columns: &str, rows: &str, format: &str) -> Result<ImageLayout, CameraError> {
        ImageLayout::of(&Stated::of(&[("Width", columns), ("Height", rows), ("PixelFormat", format)]))
    }

    fn grey(layout: &ImageLayout, block: &Block) -> Result<Vec<f32>, String> {
        let frame = layout.frame(block.clone(), FrameMeta::default(), &Spare::default())?;
        Ok(match frame.view().pixels() {
            Pixels::U8(grey) => grey.iter().map(|v| f32::from(*v)).collect(),
            Pixels::U16(grey) => grey.iter().map(|v| f32::from(*v)).collect(),
            Pixels::F32(grey) => grey.to_vec(),
        })
    }

    fn block(bytes: &[u8], columns: u32, rows: u32, format: Pfnc) -> Block {
        Block::new(bytes.to_vec().into(), columns, rows, format)
    }

    #[test]
    fn every_format_is_unpacked_by_its_definition() {
        // 0xABC and 0x123 by PFNC 2.4 and GigE Vision 1.2; 10 bits: 0x2BC and 0x123
        for (format, bytes, values) in [
            (Pfnc::Mono8, &[0xBC, 0x23][..], [0xBC, 0x23]),
            (Pfnc::Mono10, &[0xBC, 0x02, 0x23, 0x01], [0x2BC, 0x123]),
            (Pfnc::Mono10p, &[0xBC, 0x8E, 0x04], [0x2BC, 0x123]),
            (Pfnc::Mono12, &[0xBC, 0x0A, 0x23, 0x01], [0xABC, 0x123]),
            (Pfnc::Mono12p, &[0xBC, 0x3A, 0x12], [0xABC, 0x123]),
            (Pfnc::Mono12Packed, &[0xAB, 0x3C, 0x12], [0xABC, 0x123]),
            (Pfnc::Mono16, &[0xBC, 0xFA, 0x23, 0x01], [0xFABC, 0x123]),
        ] {
            let layout = layout("2", "1", &format.to_string()).unwrap();
            let found = grey(&layout, &block(bytes, 2, 1, format)).unwrap();
            assert_eq!(found, values.map(|v: u16| f32::from(v)), "{format}");
        }
    }

    #[test]
    fn a_frame_of_bytes_is_the_memory_of_its_block() {
        let pixels = vec![7_u8; 64];
        let place = pixels.as_ptr();
        let layout = layout("8", "8", "Mono8").unwrap();
        let block = Block::new(pixels.into(), 8, 8, Pfnc::Mono8);
        let frame = layout.frame(block, FrameMeta::default(), &Spare::default()).unwrap();
        assert!(matches!(frame.into_buffer(), crate::frame::Buffer::U8(bytes) if bytes.as_ptr() == place));
    }

    #[test]
    fn rows_are_taken_without_their_padding() {
        let mut padded = block(&[1, 2, 3, 9, 4, 5, 6, 9], 3, 2, Pfnc::Mono8);
        padded.padding_x = 1;
        let layout = layout("3", "2", "Mono8").unwrap();
        assert_eq!(grey(&layout, &padded).unwrap(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        padded.payload = padded.payload.slice(..6);
        assert!(grey(&layout, &padded).unwrap_err().contains("within a row"));
    }

    #[test]
    fn what_is_not_whole_or_of_another_size_is_no_frame() {
        let layout = layout("2", "2", "Mono8").unwrap();
        let mut whole = block(&[1, 2, 3, 4], 2, 2, Pfnc::Mono8);
        assert!(grey(&layout, &whole).is_ok());
        let other = block(&[1, 2], 2, 1, Pfnc::Mono8);
        assert_eq!(grey(&layout, &other).unwrap_err(), "2 x 1 Mono8 came in place of 2 x 2 Mono8");
        let deeper = block(&[0; 8], 2, 2, Pfnc::Mono16);
        assert!(grey(&layout, &deeper).unwrap_err().starts_with("2 x 2 Mono16 came"));
        whole.delivered_height = Some(0);
        assert!(grey(&layout, &whole).is_ok());
        whole.delivered_height = Some(1);
        assert!(grey(&layout, &whole).unwrap_err().starts_with("2 x 1 Mono8 came"));
        whole.status = FrameStatus::Incomplete { missing_packets: 3 };
        assert_eq!(grey(&layout, &whole).unwrap_err(), "3 packets are missing");
        whole.status = FrameStatus::TrailerMissing;
        assert!(grey(&layout, &whole).unwrap_err().contains("last packet"));
        assert!(grey(&layout, &block(&[1, 2, 3], 2, 2, Pfnc::Mono8)).unwrap_err().contains("3 bytes of 4"));
    }

    #[test]
    fn formats_that_are_not_read_are_refused_with_those_that_are() {
        let why = layout("4", "4", "BayerRG8").unwrap_err().to_string();
        assert!(why.contains("PixelFormat is BayerRG8") && why.contains("Mono12Packed"), "{why}");
        let why = layout("0", "4", "Mono8").unwrap_err().to_string();
        assert!(why.contains("Width"), "{why}");
    }
}
