//! Nodes of the XML that read the values behind the pixels of a frame: a port a chunk.

use std::fmt::Write as _;

use crate::publish::gvsp::Chunk;

/// Their names, as the category of chunks lists them.
pub(crate) const CHUNK_FEATURES: [&str; 8] = [
    "ChunkTimestamp",
    "ChunkFrameID",
    "ChunkExposureTime",
    "ChunkGain",
    "ChunkEncoderSelector",
    "ChunkEncoderValue",
    "ChunkSpindleAngle",
    "ChunkCarriageZ",
];

/// The encoder is chosen in the client; its number is the index of the register.
const SELECTOR: &str = concat!(
    "<Enumeration Name=\"ChunkEncoderSelector\" NameSpace=\"Standard\">",
    "<ToolTip>Encoder0: spindle angle, degrees; Encoder1: carriage z, mm.</ToolTip>",
    "<Visibility>Beginner</Visibility>",
    "<EnumEntry Name=\"Encoder0\"><Value>0</Value></EnumEntry>",
    "<EnumEntry Name=\"Encoder1\"><Value>1</Value></EnumEntry>",
    "<pValue>ChunkEncoderIndex</pValue><pSelected>ChunkEncoderValue</pSelected></Enumeration>\n",
    "<Integer Name=\"ChunkEncoderIndex\" NameSpace=\"Custom\">",
    "<Value>0</Value><Min>0</Min><Max>1</Max></Integer>\n",
);

/// What every chunk's register states.
const READ_ONLY: &str = "<Length>8</Length><AccessMode>RO</AccessMode>";

/// The nodes.
pub(crate) fn chunk_nodes() -> String {
    let mut out = String::from(SELECTOR);
    for (chunk, name) in Chunk::ALL {
        // Writing to a `String` never fails.
        let _ = writeln!(
            out,
            "<Port Name=\"{name}ChunkPort\"><ChunkID>{:08x}</ChunkID><CacheChunkData>No</CacheChunkData></Port>",
            chunk.id()
        );
    }
    whole("ChunkTimestamp", "Timestamp", "Start of exposure, ns of the head's clock.", &mut out);
    whole("ChunkFrameID", "FrameID", "Number of the frame, 64 bits.", &mut out);
    float("ChunkExposureTime", "ExposureTime", ("", 0), "us", &mut out);
    float("ChunkGain", "Gain", ("", 0), "dB", &mut out);
    let index = "<pIndex Offset=\"8\">ChunkEncoderIndex</pIndex>";
    float("ChunkEncoderValue", "EncoderValue", (index, 0), "", &mut out);
    float("ChunkSpindleAngle", "EncoderValue", ("", 0), "deg", &mut out);
    float("ChunkCarriageZ", "EncoderValue", ("", 8), "mm", &mut out);
    out
}

fn whole(name: &str, port: &str, about: &str, out: &mut String) {
    let _ = write!(
        out,
        "<Integer Name=\"{name}\" NameSpace=\"Standard\"><ToolTip>{about}</ToolTip>\
         <Visibility>Beginner</Visibility><pValue>{name}_Reg</pValue></Integer>\n\
         <IntReg Name=\"{name}_Reg\" NameSpace=\"Custom\"><Address>0</Address>"
    );
    let _ = writeln!(
        out,
        "{READ_ONLY}<pPort>{port}ChunkPort</pPort><Cachable>NoCache</Cachable><Sign>Signed</Sign>\
         <Endianess>BigEndian</Endianess></IntReg>"
    );
}

fn float(name: &str, port: &str, (index, address): (&str, u32), unit: &str, out: &mut String) {
    let unit = if unit.is_empty() { String::new() } else { format!("<Unit>{unit}</Unit>") };
    let _ = write!(
        out,
        "<Float Name=\"{name}\" NameSpace=\"Custom\"><ToolTip>At the start of exposure.</ToolTip>\
         <Visibility>Beginner</Visibility><pValue>{name}_Reg</pValue>{unit}</Float>\n\
         <FloatReg Name=\"{name}_Reg\" NameSpace=\"Custom\"><Address>{address}</Address>{index}"
    );
    let _ = writeln!(
        out,
        "{READ_ONLY}<pPort>{port}ChunkPort</pPort><Cachable>NoCache</Cachable>\
         <Endianess>BigEndian</Endianess></FloatReg>"
    );
}
