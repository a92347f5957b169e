//! Records of an MCAP file, one after another, into frames.

use std::collections::BTreeMap;

use ::mcap::records::{self, MessageHeader, Record};

use super::frame_message::Facts;
use super::raw_image::RawImage;
use super::{camera_record, schema};
use crate::frame::{CameraBinding, Frame, FrameMeta};
use crate::source::live::{Clock, LiveMeta, NewFrame, Remarks, Timestamp};

/// What a channel carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Carries {
    Image,
    Facts,
    Other,
}

/// A channel of the file.
#[derive(Clone, Debug)]
struct Channel {
    topic: String,
    /// Schema and encoding, for messages.
    what: String,
    carries: Carries,
}

/// What was read of a file so far.
#[derive(Debug, Default)]
pub(super) struct Records {
    /// Names of schemas.
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    /// The channel of the images, once one came.
    images: Option<u16>,
    /// Facts whose image comes next, with the number and the time of their entry.
    facts: Option<([u64; 2], Facts)>,
    /// The camera, where the file states it.
    camera: Option<CameraBinding>,
    given: u64,
}

impl Records {
    /// Frames so far.
    pub(super) fn given(&self) -> u64 {
        self.given
    }

    /// The camera that the file states before its first frame.
    pub(super) fn camera(&self) -> Option<&CameraBinding> {
        self.camera.as_ref()
    }

    /// What is wrong, and where.
    pub(super) fn after_given(&self, what: &str) -> String {
        match self.given {
            0 => what.to_owned(),
            given => format!("after frame {:06}: {what}", given - 1),
        }
    }

    /// Why a file has no frame.
    pub(super) fn why_none(&self, is_whole: bool) -> String {
        let whole = if is_whole { "" } else { "the file is cut off before the end of its first chunk; " };
        let topics: Vec<String> =
            self.channels.values().map(|c| format!("{} ({})", c.topic, c.what)).collect();
        let has = match topics.as_slice() {
            [] => "there are none".to_owned(),
            topics => format!("there are {}", topics.join(", ")),
        };
        format!("no frame is in it: {whole}a topic of {} in protobuf is needed, {has}", schema::IMAGE)
    }

    /// Takes a record; the frame that it completes.
    ///
    /// # Errors
    /// An image that a gauge does not read, images of two topics, messages that are no protobuf.
    pub(super) fn take(
        &mut self,
        record: Record<'_>,
        spare: &mut Option<Frame>,
    ) -> Result<Option<Box<NewFrame>>, String> {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => self.channel(channel),
            Record::Message { header, data } => return self.message(header, &data, spare),
            Record::Metadata(record) => self.camera = camera_record::camera(&record)?.or(self.camera.take()),
            _ => {}
        }
        Ok(None)
    }

    fn channel(&mut self, of: records::Channel) {
        let schema = self.schemas.get(&of.schema_id).map_or("no schema", String::as_str);
        let carries = match schema {
            schema::IMAGE if of.message_encoding == schema::ENCODING => Carries::Image,
            schema::FRAME if of.message_encoding == schema::ENCODING => Carries::Facts,
            _ => Carries::Other,
        };
        let what = format!("{schema}, {}", of.message_encoding);
        self.channels.insert(of.id, Channel { topic: of.topic, what, carries });
    }

    fn message(
        &mut self,
        header: MessageHeader,
        data: &[u8],
        spare: &mut Option<Frame>,
    ) -> Result<Option<Box<NewFrame>>, String> {
        let Some(channel) = self.channels.get(&header.channel_id) else { return Ok(None) };
        let damaged =
            || format!("topic {}, frame {:06}: the message is no protobuf", channel.topic, self.given);
        let entry = [u64::from(header.sequence), header.log_time];
        match channel.carries {
            Carries::Other => Ok(None),
            Carries::Facts => {
                self.facts = Some((entry, Facts::read(data).map_err(|_| damaged())?));
                Ok(None)
            }
            Carries::Image => {
                let first = *self.images.get_or_insert(header.channel_id);
                if first != header.channel_id {
                    let other = self.channels.get(&first).map_or("", |channel| &channel.topic);
                    return Err(format!(
                        "topics {other} and {} both have images: a file of one camera is needed",
                        channel.topic
                    ));
                }
                let facts = self.facts.take().filter(|(of, _)| *of == entry).map(|(_, facts)| facts);
                let facts = facts.unwrap_or_else(|| foreign(self.given, header.log_time));
                let image = RawImage::of(data).map_err(|_| damaged())?;
                let named = |why| format!("topic {}, frame {:06}: {why}", channel.topic, self.given);
                let frame = new_frame(&image, facts, spare.take()).map_err(named)?;
                self.given += 1;
                Ok(Some(Box::new(frame)))
            }
        }
    }
}

/// What is known of a frame that another program recorded: its place in the file and its time.
fn foreign(number: u64, t_ns: u64) -> Facts {
    let device_t = Some(Timestamp { t_ns, clock: Clock::Device });
    Facts {
        meta: LiveMeta { sequence: number, device_t, ..LiveMeta::default() },
        of_frame: FrameMeta { frame_id: number, t_ns, ..FrameMeta::default() },
        remarks: Remarks { stem: format!("{number:06}"), ..Remarks::default() },
        format: None,
        full_scale: None,
    }
}

fn new_frame(image: &RawImage<'_>, facts: Facts, spare: Option<Frame>) -> Result<NewFrame, String> {
    let Facts { meta, of_frame, remarks, format, full_scale } = facts;
    let frame = image.frame(format, of_frame, spare)?;
    let frame = match full_scale {
        Some(counts) => frame.with_full_scale(counts),
        None => frame,
    };
    Ok(NewFrame { frame, meta, remarks })
}
