//! Addresses of the head's memory: the bootstrap registers of GigE Vision (2.2, chapter 28), the
//! head's own registers, the pass plan, the XML.

/// Bytes of the bootstrap registers, from address 0 on.
pub(crate) const BOOTSTRAP_BYTES: u32 = 0x1000;
/// First of the head's own registers, eight bytes each.
pub(crate) const HEAD: u32 = 0x1_0000;
/// Their bytes.
pub(crate) const HEAD_BYTES: u32 = 0x1000;
/// Offsets of the pass plan, an f64 a station.
pub(crate) const PASS_OFFSETS: u32 = 0x2_0000;
/// Middles of the stations, an f64 each.
pub(crate) const PASS_STATIONS: u32 = 0x3_0000;
/// Bytes of both tables.
pub(crate) const PASS_BYTES: u32 = 0x2_0000;
/// Most stations that fit into a table.
pub(crate) const MOST_STATIONS: usize = (0x1_0000 / 8) as usize;
/// The XML.
pub(crate) const XML: u32 = 0x10_0000;

/// Version of GigE Vision, upper and lower half.
pub(crate) const VERSION: u32 = 0x0000;
/// Byte order, class and character set of the device.
pub(crate) const DEVICE_MODE: u32 = 0x0004;
/// Upper two bytes of the MAC address.
pub(crate) const MAC_HIGH: u32 = 0x0008;
/// Lower four bytes of it.
pub(crate) const MAC_LOW: u32 = 0x000c;
/// Ways of getting an address that the device has.
pub(crate) const IP_CAPABILITY: u32 = 0x0010;
/// Ways in use.
pub(crate) const IP_CONFIGURATION: u32 = 0x0014;
/// Address.
pub(crate) const IP_ADDRESS: u32 = 0x0024;
/// Mask of its subnet.
pub(crate) const SUBNET_MASK: u32 = 0x0034;
/// Maker, 32 bytes.
pub(crate) const VENDOR: u32 = 0x0048;
/// Model, 32 bytes.
pub(crate) const MODEL: u32 = 0x0068;
/// Version, 32 bytes.
pub(crate) const DEVICE_VERSION: u32 = 0x0088;
/// Words of the maker, 48 bytes.
pub(crate) const VENDOR_INFO: u32 = 0x00a8;
/// Serial number, 16 bytes.
pub(crate) const SERIAL: u32 = 0x00d8;
/// Name that a user gives, 16 bytes.
pub(crate) const USER_NAME: u32 = 0x00e8;
/// Bytes of the answer to a discovery, which are the registers from 0 on.
pub(crate) const DISCOVERY_BYTES: usize = 0x00f8;
/// Where the XML is, 512 bytes.
pub(crate) const FIRST_URL: u32 = 0x0200;
/// Network interfaces.
pub(crate) const INTERFACES: u32 = 0x0600;
/// Speed of the link, Mbit/s.
pub(crate) const LINK_SPEED: u32 = 0x0670;
/// Message channels.
pub(crate) const MESSAGE_CHANNELS: u32 = 0x0900;
/// Stream channels.
pub(crate) const STREAM_CHANNELS: u32 = 0x0904;
/// What the stream can.
pub(crate) const GVSP_CAPABILITY: u32 = 0x092c;
/// What control can.
pub(crate) const GVCP_CAPABILITY: u32 = 0x0934;
/// Time without a command after which control is released, ms.
pub(crate) const HEARTBEAT: u32 = 0x0938;
/// Ticks of the clock a second, 64 bits.
pub(crate) const TICK_FREQUENCY: u32 = 0x093c;
/// Latch (2) and reset (1) of the clock.
pub(crate) const TIMESTAMP_CONTROL: u32 = 0x0944;
/// The latched clock, 64 bits.
pub(crate) const TIMESTAMP: u32 = 0x0948;
/// Bit 31: no heartbeat.
pub(crate) const GVCP_CONFIGURATION: u32 = 0x0954;
/// Bit 1: ids of 64 bits.
pub(crate) const GVSP_CONFIGURATION: u32 = 0x0960;
/// Control channel privilege.
pub(crate) const PRIVILEGE: u32 = 0x0a00;
/// UDP port of the application in control.
pub(crate) const CONTROLLER_PORT: u32 = 0x0a04;
/// Its address.
pub(crate) const CONTROLLER_ADDRESS: u32 = 0x0a14;
/// UDP port that the stream goes to; 0 closes it.
pub(crate) const STREAM_PORT: u32 = 0x0d00;
/// Packet size and flags.
pub(crate) const PACKET_SIZE: u32 = 0x0d04;
/// Ticks between packets.
pub(crate) const PACKET_DELAY: u32 = 0x0d08;
/// Address that the stream goes to.
pub(crate) const STREAM_ADDRESS: u32 = 0x0d18;
/// UDP port that the stream comes from.
pub(crate) const STREAM_SOURCE_PORT: u32 = 0x0d1c;

/// Declares the head's own registers one after another, eight bytes apart.
macro_rules! own_registers {
    ($($(#[$about:meta])+ $name:ident,)*) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms, reason = "numbers the constants below")]
        enum Slot { $($name,)* }
        $($(#[$about])+ pub(crate) const $name: u32 = HEAD + 8 * Slot::$name as u32;)*
    };
}

own_registers! {
    /// Columns of the sensor.
    SENSOR_WIDTH,
    /// Rows of the sensor.
    SENSOR_HEIGHT,
    /// Columns of a frame.
    WIDTH,
    /// Rows of a frame.
    HEIGHT,
    /// First column of a frame.
    OFFSET_X,
    /// First row of a frame.
    OFFSET_Y,
    /// Code of the PFNC.
    PIXEL_FORMAT,
    /// Bytes of a frame.
    PAYLOAD_SIZE,
    /// Continuous, one frame, several.
    ACQUISITION_MODE,
    /// Frames of several.
    ACQUISITION_FRAMES,
    /// Command.
    ACQUISITION_START,
    /// Command.
    ACQUISITION_STOP,
    /// Hz.
    FRAME_RATE,
    /// µs.
    EXPOSURE_TIME,
    /// The one way to expose.
    EXPOSURE_MODE,
    /// dB.
    GAIN,
    /// Counts of the sensor's format.
    BLACK_LEVEL,
    /// The one trigger.
    TRIGGER_SELECTOR,
    /// Whether frames wait for triggers.
    TRIGGER_MODE,
    /// The one source.
    TRIGGER_SOURCE,
    /// Command.
    TRIGGER_SOFTWARE,
    /// Bytes a second.
    THROUGHPUT_LIMIT,
    /// Which encoder is read.
    ENCODER_SELECTOR,
    /// Spindle angle, degrees: encoder 0.
    SPINDLE_ANGLE,
    /// Carriage z, mm: encoder 1, behind encoder 0.
    CARRIAGE_Z,
    /// Whether chunks follow the pixels.
    CHUNK_MODE,
    /// Which chunk is switched.
    CHUNK_SELECTOR,
    /// What stands before the camera.
    HEAD_OBJECT,
    /// Which master pin, from 0.
    MASTER_INDEX,
    /// mm.
    SHAFT_DIAMETER,
    /// rev/min.
    SPINDLE_SPEED,
    /// Factor.
    CONTAMINATION,
    /// Which thermometer.
    TEMPERATURE_SELECTOR,
    /// °C.
    TEMPERATURE,
    /// Number of the pass, from 1; 0: a new blank.
    PASS_NUMBER,
    /// mm.
    PASS_NOMINAL,
    /// Number of stations.
    PASS_STATION_COUNT,
    /// Which station is read and written, from 0.
    PASS_STATION_SELECTOR,
    /// Command.
    PASS_CUT,
    /// Idle, cutting, cut, refused.
    PASS_STATE,
    /// Packets lost of a thousand.
    FAULT_PACKET_LOSS,
    /// Seed of the faults.
    FAULT_SEED,
    /// Whether no packet of the stream is sent.
    FAULT_STREAM_SILENCE,
    /// ms without any answer or packet.
    FAULT_SILENCE,
    /// Every which frame has another size.
    FAULT_WRONG_SIZE,
    /// Every which frame is late.
    FAULT_LATE,
    /// By how much, ms.
    FAULT_LATE_MS,
    /// Every which frame comes twice.
    FAULT_DUPLICATE,
    /// Every which trigger is ignored.
    FAULT_TRIGGER_IGNORED,
    /// Every which trigger counts twice.
    FAULT_TRIGGER_DOUBLED,
    /// Frames sent since the start.
    FRAMES_SENT,
    /// Packets sent again.
    PACKETS_RESENT,
    /// Triggers that made no frame.
    TRIGGERS_MISSED,
    /// Number of every frame of the object, from 1; 0: counted.
    HEAD_FRAME,
    /// Whether packets that are asked for again are stated as gone.
    FAULT_RESEND_REFUSED,
}

/// Switch of the image's chunk, always on; those of the others follow, eight bytes apart.
pub(crate) const CHUNK_ENABLE: u32 = HEAD + 0x0700;
/// Switch of the first chunk behind the image.
pub(crate) const CHUNK_ENABLE_1: u32 = CHUNK_ENABLE + 8;
/// Last words of the head, 128 bytes: why a frame or a pass was refused.
pub(crate) const MESSAGE: u32 = HEAD + 0x0800;
/// Bytes of the message.
pub(crate) const MESSAGE_BYTES: u32 = 128;
