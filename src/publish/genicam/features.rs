//! The features of a head, category by category.

use super::address as at;
use super::data_sheet::DataSheet;
use super::feature::{Category, Feature, Kind, Limit};
use crate::publish::gvsp::{Chunk, MIN_PACKET_BYTES, StreamFormat};

/// All features of a head.
pub(crate) fn features(sheet: &DataSheet) -> Vec<Feature> {
    let mut all = device();
    all.extend(image_format(sheet));
    all.extend(acquisition(sheet));
    all.extend(analog());
    all.extend(encoder(sheet));
    all.extend(chunks());
    all.extend(transport(sheet));
    all.extend(head(sheet));
    all.extend(passes(sheet));
    all.extend(faults());
    all
}

fn integer(least: u32, largest: u32) -> Kind {
    Kind::Integer(least, Limit::Is(largest))
}

/// Temperatures that a head may have, °C.
const TEMPERATURE: Kind = Kind::Float(-40.0, 120.0, "C");

fn device() -> Vec<Feature> {
    let text = |name, address, bytes| Feature::new(name, Category::Device, address, Kind::Text(bytes));
    vec![
        text("DeviceVendorName", at::VENDOR, 32).about("Maker."),
        text("DeviceModelName", at::MODEL, 32).about("Model."),
        text("DeviceManufacturerInfo", at::VENDOR_INFO, 48).about("What this device is."),
        text("DeviceVersion", at::DEVICE_VERSION, 32).about("Version of the program."),
        text("DeviceSerialNumber", at::SERIAL, 16).about("Serial number."),
        text("DeviceUserID", at::USER_NAME, 16).written().about("Name that the user gives."),
        Feature::new(
            "DeviceTemperatureSelector",
            Category::Device,
            at::TEMPERATURE_SELECTOR,
            Kind::Choice(vec![("Sensor", 0)]),
        )
        .written()
        .about("Which thermometer: that of the sensor."),
        Feature::new("DeviceTemperature", Category::Device, at::TEMPERATURE, TEMPERATURE)
            .selected("DeviceTemperatureSelector", 8, 1)
            .about("Temperature of the head, by HeadTemperature."),
        Feature::new("TimestampLatch", Category::Device, at::TIMESTAMP_CONTROL, Kind::Command(2))
            .written()
            .about("Latches the clock into TimestampLatchValue."),
        Feature::new("TimestampLatchValue", Category::Device, at::TIMESTAMP, Kind::Long)
            .about("The latched clock, ns."),
    ]
}

fn image_format(sheet: &DataSheet) -> Vec<Feature> {
    let new = |name, address, kind| Feature::new(name, Category::ImageFormat, address, kind);
    let (columns, rows) = (sheet.columns, sheet.rows);
    let formats = StreamFormat::ALL.iter().map(|(format, name)| (*name, format.code())).collect();
    vec![
        new("SensorWidth", at::SENSOR_WIDTH, integer(1, columns)).about("Columns of the sensor."),
        new("SensorHeight", at::SENSOR_HEIGHT, integer(1, rows)).about("Rows of the sensor."),
        new("WidthMax", at::SENSOR_WIDTH, integer(1, columns)).about("Most columns of a frame."),
        new("HeightMax", at::SENSOR_HEIGHT, integer(1, rows)).about("Most rows of a frame."),
        new("Width", at::WIDTH, Kind::Integer(1, Limit::Node("WidthLimit", columns)))
            .at_rest()
            .about("Columns of a frame."),
        new("Height", at::HEIGHT, Kind::Integer(1, Limit::Node("HeightLimit", rows)))
            .at_rest()
            .about("Rows of a frame."),
        new("OffsetX", at::OFFSET_X, Kind::Integer(0, Limit::Node("OffsetXLimit", columns - 1)))
            .at_rest()
            .about("First column of a frame on the sensor."),
        new("OffsetY", at::OFFSET_Y, Kind::Integer(0, Limit::Node("OffsetYLimit", rows - 1)))
            .at_rest()
            .about("First row of a frame on the sensor."),
        new("PixelFormat", at::PIXEL_FORMAT, Kind::Choice(formats)).at_rest().about("Format of the pixels."),
    ]
}

fn acquisition(sheet: &DataSheet) -> Vec<Feature> {
    let new = |name, address, kind| Feature::new(name, Category::Acquisition, address, kind);
    let choice = |entries: &[(&'static str, u32)]| Kind::Choice(entries.to_vec());
    vec![
        new(
            "AcquisitionMode",
            at::ACQUISITION_MODE,
            choice(&[("Continuous", 0), ("SingleFrame", 1), ("MultiFrame", 2)]),
        )
        .at_rest()
        .about("How many frames a start takes."),
        new("AcquisitionFrameCount", at::ACQUISITION_FRAMES, integer(1, u32::MAX))
            .at_rest()
            .about("Frames of MultiFrame."),
        new("AcquisitionStart", at::ACQUISITION_START, Kind::Command(1)).written().about("Starts."),
        new("AcquisitionStop", at::ACQUISITION_STOP, Kind::Command(1))
            .written()
            .about("Stops behind the frame that is being sent."),
        new("AcquisitionFrameRate", at::FRAME_RATE, Kind::Float(0.001, 10_000.0, "Hz"))
            .written()
            .about("Frames a second of a free run."),
        new("ExposureMode", at::EXPOSURE_MODE, choice(&[("Timed", 1)])).about("By ExposureTime."),
        new("ExposureTime", at::EXPOSURE_TIME, Kind::Float(0.1, sheet.longest_exposure_us, "us"))
            .written()
            .about("Exposure time; grey values grow with it."),
        new("TriggerSelector", at::TRIGGER_SELECTOR, choice(&[("FrameStart", 0)]))
            .written()
            .about("What a trigger starts: a frame."),
        new("TriggerMode", at::TRIGGER_MODE, choice(&[("Off", 0), ("On", 1)]))
            .at_rest()
            .about("Whether every frame waits for a trigger."),
        new("TriggerSource", at::TRIGGER_SOURCE, choice(&[("Software", 0)]))
            .written()
            .about("Where triggers come from."),
        new("TriggerSoftware", at::TRIGGER_SOFTWARE, Kind::Command(1)).written().about("Takes a frame."),
        new("TriggersMissed", at::TRIGGERS_MISSED, integer(0, u32::MAX))
            .about("Triggers that made no frame since the start."),
    ]
}

fn analog() -> Vec<Feature> {
    vec![
        Feature::new("Gain", Category::Analog, at::GAIN, Kind::Float(0.0, 36.0, "dB"))
            .written()
            .about("Gain behind the sensor; electrons a count fall with it."),
        Feature::new("BlackLevel", Category::Analog, at::BLACK_LEVEL, Kind::Float(0.0, 65535.0, "DN"))
            .about("Grey value without light, counts of the sensor's own format."),
    ]
}

/// Limits of the carriage beyond the part's ends, mm.
const CARRIAGE_BEYOND_MM: f64 = 1000.0;

fn encoder(sheet: &DataSheet) -> Vec<Feature> {
    let new = |name, address, kind| Feature::new(name, Category::Encoder, address, kind);
    let z = Kind::Float(-CARRIAGE_BEYOND_MM, sheet.length_mm + CARRIAGE_BEYOND_MM, "mm");
    let encoders = Kind::Choice(vec![("Encoder0", 0), ("Encoder1", 1)]);
    vec![
        new("EncoderSelector", at::ENCODER_SELECTOR, encoders)
            .written()
            .about("Encoder0: spindle angle, degrees; Encoder1: carriage z, mm."),
        new("EncoderValue", at::SPINDLE_ANGLE, Kind::Float(-1e6, 1e6, ""))
            .selected("EncoderSelector", 8, 2)
            .about("Value of the encoder now."),
        new("SpindleAngle", at::SPINDLE_ANGLE, Kind::Float(-360.0, 360.0, "deg"))
            .written()
            .about("Spindle angle; it turns from the value written by SpindleSpeed, from a start on."),
        new("CarriageZ", at::CARRIAGE_Z, z).written().about("Machine z of the middle of the field."),
    ]
}

fn chunks() -> Vec<Feature> {
    let new = |name, address, kind| Feature::new(name, Category::ChunkData, address, kind);
    let mut entries = vec![("Image", 0)];
    entries.extend(Chunk::ALL.iter().zip(1..).map(|((_, name), k)| (*name, k)));
    let count = Chunk::ALL.len() as u32 + 1;
    vec![
        new("ChunkModeActive", at::CHUNK_MODE, Kind::Flag).at_rest().about("Values behind the pixels."),
        new("ChunkSelector", at::CHUNK_SELECTOR, Kind::Choice(entries)).written().about("Which chunk."),
        new("ChunkEnable", at::CHUNK_ENABLE, Kind::Flag)
            .selected("ChunkSelector", 8, count)
            .at_rest()
            .about("Whether the chunk is in the frame; the image always is."),
    ]
}

fn transport(sheet: &DataSheet) -> Vec<Feature> {
    let new = |name, address, kind| Feature::new(name, Category::TransportLayer, address, kind);
    let ccp = Kind::Choice(vec![("OpenAccess", 0), ("ExclusiveAccess", 1), ("ControlAccess", 2)]);
    vec![
        new("PayloadSize", at::PAYLOAD_SIZE, integer(1, u32::MAX)).about("Bytes of a frame."),
        new("GevVersionMajor", at::VERSION, Kind::Bits([0, 15], [0, 65535])).about("Version of GigE Vision."),
        new("GevVersionMinor", at::VERSION, Kind::Bits([16, 31], [0, 65535])).about("Its second number."),
        new("GevCurrentIPAddress", at::IP_ADDRESS, integer(0, u32::MAX)).about("Address."),
        new("GevCurrentSubnetMask", at::SUBNET_MASK, integer(0, u32::MAX)).about("Mask."),
        new("GevLinkSpeed", at::LINK_SPEED, integer(0, u32::MAX)).about("Mbit/s."),
        new("GevCCP", at::PRIVILEGE, ccp).written().about("Who has control."),
        new("GevHeartbeatTimeout", at::HEARTBEAT, integer(500, 3_600_000))
            .written()
            .about("Time without a command after which control is released, ms."),
        new("GevGVCPHeartbeatDisable", at::GVCP_CONFIGURATION, Kind::Bit(31))
            .written()
            .about("No heartbeat, for debugging."),
        new("GevTimestampTickFrequency", at::TICK_FREQUENCY, Kind::Long).about("Ticks a second."),
        new("GevTimestampControlLatch", at::TIMESTAMP_CONTROL, Kind::Command(2))
            .written()
            .about("Latches the clock into GevTimestampValue."),
        new("GevTimestampValue", at::TIMESTAMP, Kind::Long).about("The latched clock."),
        new("GevStreamChannelCount", at::STREAM_CHANNELS, integer(1, 1)).about("One."),
        new("GevSCPHostPort", at::STREAM_PORT, Kind::Bits([16, 31], [0, 65535]))
            .written()
            .about("UDP port of the stream."),
        new("GevSCDA", at::STREAM_ADDRESS, integer(0, u32::MAX)).written().about("Address of the stream."),
        new("GevSCSP", at::STREAM_SOURCE_PORT, integer(0, 65535)).about("UDP port that it comes from."),
        new("GevSCPSFireTestPacket", at::PACKET_SIZE, Kind::Bit(0))
            .written()
            .about("Sends a packet of GevSCPSPacketSize."),
        new("GevSCPSDoNotFragment", at::PACKET_SIZE, Kind::Bit(1))
            .written()
            .about("Kept only: packets beyond the network's size are refused in either case."),
        new("GevSCPSPacketSize", at::PACKET_SIZE, Kind::Bits([16, 31], [MIN_PACKET_BYTES, sheet.mtu]))
            .at_rest()
            .about("Bytes of a packet."),
        new("GevSCPD", at::PACKET_DELAY, integer(0, 1_000_000_000)).written().about("ns between packets."),
        new("GevGVSPExtendedIDMode", at::GVSP_CONFIGURATION, Kind::Switch(1))
            .at_rest()
            .about("Ids of 64 bits for frames, 32 for packets."),
        new("DeviceLinkThroughputLimit", at::THROUGHPUT_LIMIT, integer(1_000_000, 4_000_000_000))
            .written()
            .about("Bytes a second at which packets leave."),
        new("FramesSent", at::FRAMES_SENT, integer(0, u32::MAX)).about("Frames sent since the start."),
        new("PacketsResent", at::PACKETS_RESENT, integer(0, u32::MAX)).about("Packets sent again."),
    ]
}

fn head(sheet: &DataSheet) -> Vec<Feature> {
    let new = |name, address, kind| Feature::new(name, Category::Head, address, kind);
    let diameter = |feature: Feature| if sheet.diameter_is_drawn { feature } else { feature.written() };
    let objects = [("Drawn", 0), ("Part", 1), ("Master", 2), ("Flat", 3), ("Dark", 4)];
    let objects = Kind::Choice(objects.to_vec());
    vec![
        new("HeadObject", at::HEAD_OBJECT, objects).at_rest().about(
            "Drawn: the config's shaft of ShaftDiameter; Part: as passes left it; Master: a pin; Flat: the \
                 light without a part; Dark: no light.",
        ),
        new("MasterIndex", at::MASTER_INDEX, integer(0, sheet.masters.saturating_sub(1)))
            .written()
            .about("Master pin before the camera; writing it clamps the pin anew."),
        new("HeadFrame", at::HEAD_FRAME, integer(0, MOST_FRAMES)).written().about(
            "Number of every next frame since the pass, or of the pin, from 1: noise by it; 0 counts.",
        ),
        diameter(new("ShaftDiameter", at::SHAFT_DIAMETER, Kind::Float(0.01, sheet.field_mm, "mm")))
            .about("Diameter of the drawn shaft; of a stepped one the drawing's, to read only."),
        new("SpindleSpeed", at::SPINDLE_SPEED, Kind::Float(-60_000.0, 60_000.0, "rev/min"))
            .written()
            .about("Speed of the spindle; it turns during the exposure, too."),
        new("Contamination", at::CONTAMINATION, Kind::Float(0.0, 100.0, "")).written().about(
            "Densities of the config's contamination times this; of a clean config, a usual mix of it.",
        ),
        new("HeadTemperature", at::TEMPERATURE, TEMPERATURE)
            .written()
            .about("What DeviceTemperature reads; nothing of the image follows from it."),
        new("HeadMessage", at::MESSAGE, Kind::Text(at::MESSAGE_BYTES))
            .about("Why the last frame or pass was refused; empty after one that was not."),
    ]
}

/// Most frames of a pass that are ordered by their numbers: those of a pin have 24 bits.
const MOST_FRAMES: u32 = (1 << 24) - 1;

/// Largest offset that a pass plan takes, mm of diameter.
const LARGEST_OFFSET_MM: f64 = 10.0;

fn passes(sheet: &DataSheet) -> Vec<Feature> {
    let new = |name, address, kind| Feature::new(name, Category::Head, address, kind);
    let states = Kind::Choice(vec![("Idle", 0), ("Cutting", 1), ("Cut", 2), ("Refused", 3)]);
    let (count, z) = (sheet.station_z_mm.len().max(1) as u32, sheet.length_mm);
    let stations = |feature: Feature| feature.selected("PassStation", 8, count);
    vec![
        new("PassNumber", at::PASS_NUMBER, integer(0, (sheet.pass_nominal_mm.len() as u32).max(1)))
            .written()
            .about(
                "Pass to cut, from 1, by the config's diameter and cutting data; 0: PassCut clamps a blank.",
            ),
        new("PassNominalDiameter", at::PASS_NOMINAL, Kind::Float(0.0, 1e4, "mm")).about("Of that pass."),
        new("PassStationCount", at::PASS_STATION_COUNT, integer(0, count)).about("Stations of the part."),
        new("PassStation", at::PASS_STATION_SELECTOR, integer(0, count - 1))
            .written()
            .about("Station of PassOffset and PassStationZ, from 0."),
        stations(new(
            "PassOffset",
            at::PASS_OFFSETS,
            Kind::Float(-LARGEST_OFFSET_MM, LARGEST_OFFSET_MM, "mm"),
        ))
        .written()
        .about("Offset of the station, mm of diameter, subtracted from the nominal diameter."),
        stations(new("PassStationZ", at::PASS_STATIONS, Kind::Float(-z, 2.0 * z, "mm")))
            .about("Middle of the station."),
        new("PassCut", at::PASS_CUT, Kind::Command(1)).written().about("Cuts the pass; PassState follows."),
        new("PassState", at::PASS_STATE, states).about("Whether the pass is cut."),
    ]
}

fn faults() -> Vec<Feature> {
    let new = |name, address, kind| Feature::new(name, Category::Fault, address, kind);
    let every = |name, address, about| {
        Feature::new(name, Category::Fault, address, integer(0, 1_000_000)).written().about(about)
    };
    vec![
        new("FaultPacketLoss", at::FAULT_PACKET_LOSS, integer(0, 1000))
            .written()
            .about("Packets of a thousand that are not sent; those asked for again are."),
        new("FaultResendRefused", at::FAULT_RESEND_REFUSED, Kind::Flag)
            .written()
            .about("Packets that are asked for again are stated as gone."),
        new("FaultSeed", at::FAULT_SEED, integer(0, u32::MAX)).written().about("Which packets are lost."),
        new("FaultStreamSilence", at::FAULT_STREAM_SILENCE, Kind::Flag)
            .written()
            .about("No packet of the stream is sent; control works, as behind a firewall."),
        new("FaultSilence", at::FAULT_SILENCE, integer(0, 600_000))
            .written()
            .about("From now on, for so many ms, neither answers nor packets."),
        every("FaultWrongSize", at::FAULT_WRONG_SIZE, "Every which frame has a row less; 0 for none."),
        every("FaultLate", at::FAULT_LATE, "Every which frame is late by FaultLateTime; 0 for none."),
        new("FaultLateTime", at::FAULT_LATE_MS, integer(0, 60_000)).written().about("ms."),
        every("FaultDuplicate", at::FAULT_DUPLICATE, "Every which frame is sent twice; 0 for none."),
        every(
            "FaultTriggerIgnored",
            at::FAULT_TRIGGER_IGNORED,
            "Every which trigger is ignored; 0 for none.",
        ),
        every(
            "FaultTriggerDoubled",
            at::FAULT_TRIGGER_DOUBLED,
            "Every which trigger takes two frames; 0 for none.",
        ),
    ]
}
