//! What of a JPEG is decoded: grey, sequential, and in strips that take less memory than the frame.

use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::options::DecoderOptions;
use zune_jpeg::{ImageInfo, JpegDecoder, SampleRatios};

use super::decode::DecodeError;

/// Memory of a strip of 8 rows, bytes a column: 16-bit samples.
const STRIP: usize = 16;
/// The same where the one channel claims to be sampled more finely than others: with room for rows between the samples.
const SAMPLED_STRIP: usize = 64;
/// Strips up to this many bytes are decoded however small the frame.
const SMALL_STRIP: usize = 256 << 10;

/// Reads the header alone and refuses what would take more than twice the frame's memory. Colour passes: it is told of elsewhere.
pub(super) fn check(bytes: &[u8]) -> Result<(), DecodeError> {
    let longest = usize::from(u16::MAX);
    let options = DecoderOptions::default().set_strict_mode(false);
    let options = options.set_max_width(longest).set_max_height(longest);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|e| DecodeError::Damaged(format!("{e:?}")))?;
    let Some(info) = decoder.info().filter(|info| info.components == 1) else { return Ok(()) };
    if info.sof.is_progressive() {
        return Err(DecodeError::Progressive);
    }
    let (columns, rows) = (usize::from(info.width), usize::from(info.height));
    if strip_bytes(&info) > columns * rows + SMALL_STRIP {
        return Err(DecodeError::FlatJpeg { columns, rows });
    }
    Ok(())
}

fn strip_bytes(info: &ImageInfo) -> usize {
    let a_column = if matches!(info.sample_ratio, SampleRatios::None) { STRIP } else { SAMPLED_STRIP };
    a_column * usize::from(info.width).next_multiple_of(32)
}
