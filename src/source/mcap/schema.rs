//! The descriptors of the messages: what another program needs to read them.

use super::wire::Message;

/// Name of the message with the pixels: Foxglove's, <https://docs.foxglove.dev/docs/sdk/schemas>.
pub(super) const IMAGE: &str = "foxglove.RawImage";
/// Name of the message with what is known of a frame beside its pixels.
pub(super) const FRAME: &str = "shadowgauge.Frame";
/// Encoding of the messages, and of their descriptors.
pub(super) const ENCODING: &str = "protobuf";

/// Types of fields (`google.protobuf.FieldDescriptorProto.Type`).
#[derive(Clone, Copy)]
enum Type {
    Double = 1,
    Int64 = 3,
    Uint64 = 4,
    Int32 = 5,
    Fixed64 = 6,
    Fixed32 = 7,
    String = 9,
    Message = 11,
    Bytes = 12,
    Uint32 = 13,
}

/// A field: name, number, type, and of messages the full name of theirs.
type Field = (&'static str, u32, Type, &'static str);

const OPTIONAL: u64 = 1;
const REPEATED: u64 = 3;

/// A field; one whose name is in `repeated` may be there several times.
fn field(&(name, number, kind, of): &Field, repeated: &[&str]) -> Message {
    let label = if repeated.contains(&name) { REPEATED } else { OPTIONAL };
    Message::default()
        .text(1, name)
        .varint(3, u64::from(number))
        .varint(4, label)
        .varint(5, kind as u64)
        .text(6, of)
}

fn message(name: &str, fields: &[Field], repeated: &[&str]) -> Message {
    let named = Message::default().text(1, name);
    fields.iter().fold(named, |message, of| message.message(2, &field(of, repeated)))
}

fn file(name: &str, package: &str, needs: &[&str], messages: &[Message]) -> Message {
    let named = Message::default().text(1, name).text(2, package);
    let named = needs.iter().fold(named, |file, needed| file.text(3, needed));
    messages.iter().fold(named, |file, message| file.message(4, message)).text(12, "proto3")
}

const TIMESTAMP: &str = "google/protobuf/timestamp.proto";

/// The `FileDescriptorSet` of [`IMAGE`].
pub(super) fn image() -> Message {
    let stamp = message("Timestamp", &[("seconds", 1, Type::Int64, ""), ("nanos", 2, Type::Int32, "")], &[]);
    let image = message(
        "RawImage",
        &[
            ("timestamp", 1, Type::Message, ".google.protobuf.Timestamp"),
            ("width", 2, Type::Fixed32, ""),
            ("height", 3, Type::Fixed32, ""),
            ("encoding", 4, Type::String, ""),
            ("step", 5, Type::Fixed32, ""),
            ("data", 6, Type::Bytes, ""),
            ("frame_id", 7, Type::String, ""),
        ],
        &[],
    );
    Message::default()
        .message(1, &file(TIMESTAMP, "google.protobuf", &[], &[stamp]))
        .message(1, &file("foxglove/RawImage.proto", "foxglove", &[TIMESTAMP], &[image]))
}

/// The `FileDescriptorSet` of [`FRAME`].
pub(super) fn frame() -> Message {
    let time = message("Time", &[("t_ns", 1, Type::Fixed64, ""), ("clock", 2, Type::String, "")], &[]);
    let known = message("Known", &[("value", 1, Type::Double, ""), ("from", 2, Type::String, "")], &[]);
    let window = ["row", "column", "rows", "columns"];
    let window: Vec<Field> = (1..).zip(window).map(|(n, name)| (name, n, Type::Uint32, "")).collect();
    let messages = [time, known, message("Window", &window, &[]), scale(), gauge(), of_frame()];
    Message::default().message(1, &file("shadowgauge/Frame.proto", "shadowgauge", &[], &messages))
}

fn scale() -> Message {
    message(
        "Scale",
        &[
            ("across_um_per_px", 1, Type::Double, ""),
            ("down_um_per_px", 2, Type::Double, ""),
            ("rounding", 3, Type::Double, ""),
            ("trust", 4, Type::String, ""),
            ("origin", 5, Type::String, ""),
        ],
        &[],
    )
}

/// What the gauge takes with the pixels.
fn gauge() -> Message {
    message(
        "Gauge",
        &[
            ("frame_id", 1, Type::Uint64, ""),
            ("t_ns", 2, Type::Fixed64, ""),
            ("exposure_us", 3, Type::Double, ""),
            ("angle_deg", 4, Type::Double, ""),
            ("sweep_deg", 5, Type::Double, ""),
            ("z_mm", 6, Type::Double, ""),
            ("window", 7, Type::Message, ".shadowgauge.Window"),
            ("light_at_1_4", 8, Type::Double, ""),
            ("light_at_1_2", 9, Type::Double, ""),
            ("light_at_3_4", 10, Type::Double, ""),
            ("second_window", 11, Type::Message, ".shadowgauge.Window"),
        ],
        &[],
    )
}

fn of_frame() -> Message {
    const TIME: &str = ".shadowgauge.Time";
    const KNOWN: &str = ".shadowgauge.Known";
    message(
        "Frame",
        &[
            ("sequence", 1, Type::Uint64, ""),
            ("device_t", 2, Type::Message, TIME),
            ("host_t", 3, Type::Message, TIME),
            ("exposure_us", 4, Type::Message, KNOWN),
            ("gain_db", 5, Type::Message, KNOWN),
            ("angle_deg", 6, Type::Message, KNOWN),
            ("z_mm", 7, Type::Message, KNOWN),
            ("name", 8, Type::String, ""),
            ("significant_bits", 9, Type::Uint32, ""),
            ("full_scale", 10, Type::Double, ""),
            ("gauge", 11, Type::Message, ".shadowgauge.Gauge"),
            ("scale", 12, Type::Message, ".shadowgauge.Scale"),
            ("changed", 13, Type::String, ""),
            ("exposed_t", 14, Type::Message, TIME),
            ("head_c", 15, Type::Message, KNOWN),
            ("u_angle_deg", 16, Type::Message, KNOWN),
        ],
        &["changed"],
    )
}
