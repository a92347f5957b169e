//! What is known of a frame beside its pixels, as `shadowgauge.Frame` and back, to the bit.

use super::wire::{Damaged, Fields, Message, Value};
use crate::frame::{Encoding, Frame, FrameMeta, PixelFormat, Roi};
use crate::source::live::{Clock, Known, LiveMeta, Provenance, Remarks, Timestamp};
use crate::source::scale::{FileScale, Trust};

/// Everything of a frame but its pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Facts {
    /// Times, and values with their provenance.
    pub(super) meta: LiveMeta,
    /// What the gauge takes with the pixels.
    pub(super) of_frame: FrameMeta,
    /// Name, scale and changes; notices are of the files that the frame came from, and not kept.
    pub(super) remarks: Remarks,
    /// Format of the pixels.
    pub(super) format: Option<PixelFormat>,
    /// Full scale, counts, where it is not the format's.
    pub(super) full_scale: Option<f32>,
}

const FORMATS: [PixelFormat; 6] = [
    PixelFormat::Mono8,
    PixelFormat::Mono10,
    PixelFormat::Mono12,
    PixelFormat::Mono14,
    PixelFormat::Mono16,
    PixelFormat::F32,
];
const TRUSTS: [(Trust, &str); 3] =
    [(Trust::Object, "object"), (Trust::Print, "print"), (Trust::Screen, "screen")];

impl Facts {
    /// Of a frame from a live source.
    pub(super) fn of(frame: &Frame, meta: &LiveMeta, remarks: &Remarks) -> Self {
        let view = frame.view();
        let own = view.format().full_scale().map(f32::from);
        Self {
            meta: meta.clone(),
            of_frame: frame.meta.clone(),
            remarks: Remarks { notices: Vec::new(), ..remarks.clone() },
            format: Some(view.format()),
            full_scale: view.full_scale().filter(|scale| Some(*scale) != own),
        }
    }

    /// The message.
    pub(super) fn encoded(&self) -> Message {
        let Self { meta, of_frame, remarks, format, full_scale } = self;
        let message = Message::default()
            .varint(1, meta.sequence)
            .optional(2, meta.device_t.map(time).as_ref())
            .optional(3, meta.host_t.map(time).as_ref())
            .optional(4, meta.exposure_us.map(known).as_ref())
            .optional(5, meta.gain_db.map(known).as_ref())
            .optional(6, meta.angle_deg.map(known).as_ref())
            .optional(7, meta.z_mm.map(known).as_ref())
            .text(8, &remarks.stem)
            .varint(9, format.map_or(0, |format| u64::from(format.bit_depth())))
            .double(10, full_scale.map_or(0.0, f64::from))
            .message(11, &gauge(of_frame))
            .optional(12, remarks.scale.as_ref().map(scale).as_ref())
            .optional(14, meta.exposed_t.map(time).as_ref())
            .optional(15, meta.head_c.map(known).as_ref())
            .optional(16, meta.u_angle_deg.map(|u| Message::default().double(1, u)).as_ref());
        // A member of a repeated field is there even if it is empty.
        remarks.changed.iter().fold(message, |message, text| match text.as_str() {
            "" => message.message(13, &Message::default()),
            text => message.text(13, text),
        })
    }

    /// Reads the message; fields that are not known are passed over.
    ///
    /// # Errors
    /// Bytes that are no protobuf.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, Damaged> {
        let mut facts = Self::default();
        for field in Fields::of(bytes) {
            let (number, value) = field?;
            facts.take(number, value)?;
        }
        Ok(facts)
    }

    fn take(&mut self, number: u32, value: Value<'_>) -> Result<(), Damaged> {
        let meta = &mut self.meta;
        match number {
            1 => meta.sequence = value.number(),
            2 => meta.device_t = Some(read_time(value)?),
            3 => meta.host_t = Some(read_time(value)?),
            4 => meta.exposure_us = Some(read_known(value)?),
            5 => meta.gain_db = Some(read_known(value)?),
            6 => meta.angle_deg = Some(read_known(value)?),
            7 => meta.z_mm = Some(read_known(value)?),
            8 => self.remarks.stem = value.text(),
            9 => {
                let is_it = |format: &PixelFormat| u64::from(format.bit_depth()) == value.number();
                self.format = FORMATS.into_iter().find(is_it);
            }
            10 => self.full_scale = Some(value.double() as f32),
            11 => self.of_frame = read_gauge(value)?,
            12 => self.remarks.scale = Some(read_scale(value)?),
            13 => self.remarks.changed.push(value.text()),
            14 => meta.exposed_t = Some(read_time(value)?),
            15 => meta.head_c = Some(read_known(value)?),
            16 => meta.u_angle_deg = Some(read_known(value)?.value),
            _ => {}
        }
        Ok(())
    }
}

fn time(of: Timestamp) -> Message {
    Message::default().fixed64(1, of.t_ns).text(2, of.clock.word())
}

fn known(of: Known<f64>) -> Message {
    Message::default().double(1, of.value).text(2, of.provenance.word())
}

fn scale(of: &FileScale) -> Message {
    let [across, down] = of.um_per_px;
    let trust = TRUSTS.iter().find(|(trust, _)| *trust == of.trust).map_or("", |(_, word)| word);
    Message::default()
        .double(1, across)
        .double(2, down)
        .double(3, of.rounding)
        .text(4, trust)
        .text(5, &of.origin)
}

fn gauge(of: &FrameMeta) -> Message {
    let [a, b, c] = of.encoding.light_at_quarters;
    let window = |roi: Roi| {
        let numbers = [roi.row, roi.column, roi.rows, roi.columns];
        (1..).zip(numbers).fold(Message::default(), |m, (field, n)| m.varint(field, u64::from(n)))
    };
    Message::default()
        .varint(1, of.frame_id)
        .fixed64(2, of.t_ns)
        .double(3, of.exposure_us)
        .double(4, of.angle_deg)
        .double(5, of.sweep_deg)
        .double(6, of.z_mm)
        .optional(7, of.roi.map(window).as_ref())
        .double(8, a)
        .double(9, b)
        .double(10, c)
        .optional(11, of.second_roi.map(window).as_ref())
}

fn read_time(value: Value<'_>) -> Result<Timestamp, Damaged> {
    // A clock without a word that is known is the device's: it is compared with no other.
    let mut time = Timestamp { t_ns: 0, clock: Clock::Device };
    for field in Fields::of(value.bytes()) {
        match field? {
            (1, t_ns) => time.t_ns = t_ns.number(),
            (2, word) => time.clock = Clock::of_word(&word.text()).unwrap_or(Clock::Device),
            _ => {}
        }
    }
    Ok(time)
}

fn read_known(value: Value<'_>) -> Result<Known<f64>, Damaged> {
    let mut known = Known::stated(0.0);
    for field in Fields::of(value.bytes()) {
        match field? {
            (1, value) => known.value = value.double(),
            (2, word) => known.provenance = Provenance::of_word(&word.text()).unwrap_or(Provenance::Stated),
            _ => {}
        }
    }
    Ok(known)
}

fn read_scale(value: Value<'_>) -> Result<FileScale, Damaged> {
    let mut scale =
        FileScale { um_per_px: [0.0; 2], origin: String::new(), trust: Trust::Object, rounding: 0.0 };
    for field in Fields::of(value.bytes()) {
        match field? {
            (1, across) => scale.um_per_px[0] = across.double(),
            (2, down) => scale.um_per_px[1] = down.double(),
            (3, rounding) => scale.rounding = rounding.double(),
            (4, word) => {
                let word = word.text();
                let trust = TRUSTS.into_iter().find(|(_, known)| *known == word);
                scale.trust = trust.map_or(Trust::Object, |(trust, _)| trust);
            }
            (5, origin) => scale.origin = origin.text(),
            _ => {}
        }
    }
    Ok(scale)
}

fn read_gauge(value: Value<'_>) -> Result<FrameMeta, Damaged> {
    let none = Encoding { light_at_quarters: [0.0; 3] };
    let mut meta = FrameMeta { encoding: none, ..FrameMeta::default() };
    for field in Fields::of(value.bytes()) {
        let (number, value) = field?;
        match number {
            1 => meta.frame_id = value.number(),
            2 => meta.t_ns = value.number(),
            3 => meta.exposure_us = value.double(),
            4 => meta.angle_deg = value.double(),
            5 => meta.sweep_deg = value.double(),
            6 => meta.z_mm = value.double(),
            7 => meta.roi = Some(read_window(value)?),
            11 => meta.second_roi = Some(read_window(value)?),
            8..=10 => meta.encoding.light_at_quarters[number as usize - 8] = value.double(),
            _ => {}
        }
    }
    Ok(meta)
}

fn read_window(value: Value<'_>) -> Result<Roi, Damaged> {
    let mut numbers = [0; 4];
    for field in Fields::of(value.bytes()) {
        let (number, value) = field?;
        if let Some(to) = numbers.get_mut((number as usize).wrapping_sub(1)) {
            *to = u32::try_from(value.number()).map_err(|_| Damaged)?;
        }
    }
    let [row, column, rows, columns] = numbers;
    Ok(Roi { row, column, rows, columns })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full() -> Facts {
        let from = |value, provenance| Some(Known { value, provenance });
        let at = |t_ns, clock| Some(Timestamp { t_ns, clock });
        Facts {
            meta: LiveMeta {
                sequence: u64::MAX - 3,
                device_t: at(0, Clock::Simulated),
                exposed_t: at(1_764_600_000_123_000_000, Clock::Host),
                host_t: at(1_764_600_000_123_456_789, Clock::Host),
                exposure_us: from(1.0 / 3.0, Provenance::Chunk),
                gain_db: from(-0.0, Provenance::TriggerCount),
                angle_deg: from(359.999_999_999_9, Provenance::Interpolated),
                u_angle_deg: Some(0.0),
                z_mm: from(-12.345, Provenance::Simulated),
                head_c: from(31.25, Provenance::Register),
            },
            of_frame: FrameMeta {
                frame_id: 7,
                t_ns: 8,
                exposure_us: 20.0,
                angle_deg: 0.1 + 0.2,
                sweep_deg: -0.0,
                z_mm: f64::MIN_POSITIVE,
                roi: Some(Roi { row: 0, column: 3, rows: 5, columns: u32::MAX }),
                second_roi: Some(Roi { row: 9, column: 3, rows: 5, columns: 1 }),
                encoding: Encoding { light_at_quarters: [0.0, 0.21, 1.0] },
            },
            remarks: Remarks {
                stem: "wélle 1".to_owned(),
                scale: Some(FileScale {
                    um_per_px: [17.4, 17.5],
                    origin: "pHYs".to_owned(),
                    trust: Trust::Print,
                    rounding: 1e-4,
                }),
                changed: vec![String::new(), "sRGB to linear".to_owned()],
                notices: Vec::new(),
            },
            format: Some(PixelFormat::Mono12),
            full_scale: Some(4000.0),
        }
    }

    #[test]
    fn facts_come_back_to_the_bit() {
        for facts in [full(), Facts::default()] {
            let read = Facts::read(facts.encoded().bytes()).unwrap();
            assert_eq!(read, facts);
            // In its debug form -0 differs from 0.
            assert_eq!(format!("{read:?}"), format!("{facts:?}"));
        }
        for format in FORMATS {
            let facts = Facts { format: Some(format), ..Facts::default() };
            assert_eq!(Facts::read(facts.encoded().bytes()).unwrap(), facts);
        }
    }

    #[test]
    fn a_message_that_is_cut_never_passes_for_the_whole_one() {
        let whole = full().encoded();
        for cut in 0..whole.bytes().len() {
            assert_ne!(Facts::read(&whole.bytes()[..cut]), Ok(full()), "{cut}");
        }
    }

    #[test]
    fn the_message_is_exact() {
        let meta = LiveMeta { sequence: 300, device_t: full().meta.device_t, ..LiveMeta::default() };
        let of_frame =
            FrameMeta { encoding: Encoding { light_at_quarters: [0.0; 3] }, ..FrameMeta::default() };
        let facts = Facts { meta, of_frame, format: Some(PixelFormat::Mono12), ..Facts::default() };
        let right = [&[0x08, 0xac, 0x02][..], b"\x12\x0c\x12\x0asimulation", &[0x48, 12], &[0x5a, 0]];
        assert_eq!(facts.encoded().bytes(), right.concat());
    }
}
