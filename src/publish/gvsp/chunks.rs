//! Values that travel behind the pixels of a frame: each chunk is its data, its id and its length,
//! so that a frame is read from its end.

/// A chunk that can be switched on; the image is the first and always there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Chunk {
    /// Start of exposure on the head's clock, ns, 64 bits.
    Timestamp,
    /// Id of the block, 64 bits.
    FrameId,
    /// Exposure time, µs, f64.
    ExposureTime,
    /// Gain, dB, f64.
    Gain,
    /// Encoder 0 (spindle angle, degrees) and encoder 1 (carriage z, mm) at the start of exposure,
    /// two f64.
    EncoderValue,
}

/// Id of the image's chunk.
const IMAGE_ID: u32 = 0x5347_0001;

impl Chunk {
    /// All of them, in the order in which they follow the image, with their names in the SFNC.
    pub(crate) const ALL: [(Self, &'static str); 5] = [
        (Self::Timestamp, "Timestamp"),
        (Self::FrameId, "FrameID"),
        (Self::ExposureTime, "ExposureTime"),
        (Self::Gain, "Gain"),
        (Self::EncoderValue, "EncoderValue"),
    ];

    /// Its id in frames and in the head's XML.
    pub(crate) const fn id(self) -> u32 {
        IMAGE_ID
            + match self {
                Self::Timestamp => 1,
                Self::FrameId => 2,
                Self::ExposureTime => 3,
                Self::Gain => 4,
                Self::EncoderValue => 5,
            }
    }

    const fn length(self) -> usize {
        if matches!(self, Self::EncoderValue) { 16 } else { 8 }
    }
}

/// What the chunks of a frame state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ChunkValues {
    /// Start of exposure on the head's clock, ns.
    pub timestamp_ns: u64,
    /// Id of the block.
    pub block: u64,
    /// Exposure time, µs.
    pub exposure_us: f64,
    /// Gain, dB.
    pub gain_db: f64,
    /// Spindle angle at the start of exposure, degrees.
    pub angle_deg: f64,
    /// Machine z of the field's middle, mm.
    pub z_mm: f64,
}

impl ChunkValues {
    fn data(&self, chunk: Chunk) -> ([u8; 16], usize) {
        let mut data = [0; 16];
        let (first, second) = match chunk {
            Chunk::Timestamp => (self.timestamp_ns, 0),
            Chunk::FrameId => (self.block, 0),
            Chunk::ExposureTime => (self.exposure_us.to_bits(), 0),
            Chunk::Gain => (self.gain_db.to_bits(), 0),
            Chunk::EncoderValue => (self.angle_deg.to_bits(), self.z_mm.to_bits()),
        };
        data[..8].copy_from_slice(&first.to_be_bytes());
        data[8..].copy_from_slice(&second.to_be_bytes());
        (data, chunk.length())
    }
}

/// Bytes of a frame with `image_bytes` of pixels and these chunks.
pub(crate) fn chunk_bytes(image_bytes: usize, chunks: &[Chunk]) -> usize {
    let values: usize = chunks.iter().map(|chunk| chunk.length() + 8).sum();
    image_bytes.next_multiple_of(4) + 8 + values
}

/// Closes the image in `payload` as a chunk of whole words and appends the values.
pub(crate) fn append_chunks(payload: &mut Vec<u8>, chunks: &[Chunk], values: &ChunkValues) {
    payload.resize(payload.len().next_multiple_of(4), 0);
    close(payload, IMAGE_ID, payload.len());
    for chunk in chunks {
        let (data, length) = values.data(*chunk);
        payload.extend_from_slice(&data[..length]);
        close(payload, chunk.id(), length);
    }
}

fn close(payload: &mut Vec<u8>, id: u32, length: usize) {
    payload.extend(id.to_be_bytes());
    payload.extend(u32::try_from(length).unwrap_or(u32::MAX).to_be_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_read_from_the_end_and_add_up_to_the_frame() {
        let mut payload = vec![7_u8; 10];
        let chunks = Chunk::ALL.map(|(chunk, _)| chunk);
        let values = ChunkValues {
            timestamp_ns: 5,
            block: 1 << 40,
            exposure_us: 50.0,
            gain_db: 6.0,
            angle_deg: 157.5,
            z_mm: -3.25,
        };
        append_chunks(&mut payload, &chunks, &values);
        assert_eq!(payload.len(), chunk_bytes(10, &chunks));
        let (mut end, mut read) = (payload.len(), Vec::new());
        while end > 0 {
            let word = |at: usize| u32::from_be_bytes(payload[at..at + 4].try_into().unwrap());
            let (id, length) = (word(end - 8), word(end - 4) as usize);
            read.push((id, payload[end - 8 - length..end - 8].to_vec()));
            end -= 8 + length;
        }
        read.reverse();
        assert_eq!(read[0], (IMAGE_ID, vec![7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 0, 0]));
        assert_eq!(read.iter().map(|(id, _)| id - IMAGE_ID).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5]);
        assert_eq!(read[2].1, (1_u64 << 40).to_be_bytes());
        let float = |bytes: &[u8]| f64::from_be_bytes(bytes.try_into().unwrap());
        assert_eq!((float(&read[5].1[..8]), float(&read[5].1[8..])), (157.5, -3.25));
        assert_eq!((float(&read[3].1), float(&read[4].1)), (50.0, 6.0));
    }
}
