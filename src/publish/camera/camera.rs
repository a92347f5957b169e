//! The camera: answers datagrams, states the next task.

use std::net::SocketAddrV4;

use super::acquisition::{Acquisition, FrameTask, Task};
use super::clients::{Controller, LastAnswers, Privilege};
use super::memory::Memory;
use super::settings::{StreamSettings, payload_bytes, stream};
use crate::publish::genicam::{DataSheet, RegisterMap, address as at, features, xml};
use crate::publish::gvcp::{self, Answer, Command, Refusal, Request, Resend, Status};
use crate::publish::head::{FrameOrder, Object, PassOrder, SceneOrder};

/// Bytes a second of a link of 1 Gbit/s.
const GIGABIT_BYTES_PER_S: u64 = 125_000_000;

/// What an answer comes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// Packets of a frame are sent once more.
    Resend(Resend),
    /// A datagram of so many bytes goes to the stream's place.
    TestPacket(SocketAddrV4, usize),
}

/// What a datagram leads to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Reply {
    /// The answer, where the client waits for one.
    pub datagram: Option<Vec<u8>>,
    /// What else is to be sent.
    pub action: Option<Action>,
}

/// The spindle: an angle at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Spindle {
    pub(super) angle_deg: f64,
    pub(super) since_ns: u64,
}

/// What a head has counted since it was started.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    /// Acquisitions that were started or stopped.
    pub(super) starts: u64,
    /// Openings of the stream.
    pub(super) channel: u64,
    /// Frames of this stream: the id of the last one.
    pub(super) block: u64,
    /// Pins that were put in.
    pub(super) clamped: u64,
    /// Triggers that came.
    pub(super) triggers: u64,
}

/// The camera without a network.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    pub(super) memory: Memory,
    pub(super) map: RegisterMap,
    pub(super) sheet: DataSheet,
    pub(super) controller: Option<Controller>,
    last: LastAnswers,
    pub(super) acquisition: Option<Acquisition>,
    pub(super) counts: Counts,
    pub(super) spindle: Spindle,
    pub(super) cut: Option<PassOrder>,
    pub(super) silent_until_ns: u64,
}

impl Camera {
    /// The camera of a head, not yet found by a client.
    pub(crate) fn new(sheet: DataSheet) -> Self {
        let features = features(&sheet);
        Self {
            memory: Memory::new(&sheet, xml(&features)),
            map: RegisterMap::new(&features),
            sheet,
            controller: None,
            last: LastAnswers::default(),
            acquisition: None,
            counts: Counts::default(),
            spindle: Spindle::default(),
            cut: None,
            silent_until_ns: 0,
        }
    }

    /// Where clients read the XML.
    pub(crate) fn xml_url(&self) -> String {
        self.memory.xml_url()
    }

    /// Answers a datagram of a client.
    pub(crate) fn answer(&mut self, datagram: &[u8], from: SocketAddrV4, now_ns: u64) -> Reply {
        if self.is_silent(now_ns) {
            return Reply::default();
        }
        let request = match gvcp::parse(datagram) {
            Ok(request) => request,
            Err(refusal) => return Reply { datagram: refused(refusal), action: None },
        };
        if let Some(controller) = self.controller.as_mut().filter(|c| c.client == from) {
            controller.heard_ns = now_ns;
        }
        match &request.command {
            Command::Discovery => return Reply { datagram: self.discovery(request.id), action: None },
            Command::Resend(resend) => return self.resend(*resend, from),
            _ => {}
        }
        if let Some(datagram) = self.last.repeated(from, datagram, now_ns) {
            return Reply { datagram, action: None };
        }
        let (status, payload, action) = self.execute(&request, from, now_ns);
        let head = Answer { status, code: request.command.answer_code(), id: request.id };
        let answer = request.wants_answer.then(|| gvcp::answer(head, &payload));
        self.last.keep(from, now_ns, datagram, answer.as_deref());
        Reply { datagram: answer, action }
    }

    fn discovery(&self, id: u16) -> Option<Vec<u8>> {
        let head = Answer { status: Status::Success, code: Command::Discovery.answer_code(), id };
        let bytes = self.memory.read(0, at::DISCOVERY_BYTES).ok()?;
        Some(gvcp::answer(head, bytes))
    }

    /// Resend requests come from the socket of the stream: from the controller's address.
    fn resend(&self, resend: Resend, from: SocketAddrV4) -> Reply {
        let is_known = self.controller.is_some_and(|c| c.client.ip() == from.ip()) && resend.channel == 0;
        Reply { datagram: None, action: is_known.then_some(Action::Resend(resend)) }
    }

    fn execute(
        &mut self,
        request: &Request,
        from: SocketAddrV4,
        now_ns: u64,
    ) -> (Status, Vec<u8>, Option<Action>) {
        let done = match &request.command {
            Command::ReadRegisters(addresses) => self.read_registers(addresses, from, now_ns),
            Command::ReadMemory { address, length } => self.read_memory(*address, *length, from, now_ns),
            Command::WriteRegisters(writes) => return self.write_registers(writes, from, now_ns),
            Command::WriteMemory { address, data } => {
                let done = self.write(*address, data, from, now_ns);
                let (status, action) = done.map_or_else(|status| (status, None), |a| (Status::Success, a));
                return (status, written(usize::from(status == Status::Success)), action);
            }
            Command::Discovery | Command::Resend(_) | Command::Other(_) => Err(Status::NotImplemented),
        };
        let (status, payload) =
            done.map_or_else(|status| (status, Vec::new()), |bytes| (Status::Success, bytes));
        (status, payload, None)
    }

    fn may_read(&self, from: SocketAddrV4) -> Result<(), Status> {
        match self.controller {
            Some(c) if c.privilege == Privilege::Exclusive && c.client != from => Err(Status::AccessDenied),
            _ => Ok(()),
        }
    }

    fn read_registers(&mut self, all: &[u32], from: SocketAddrV4, now_ns: u64) -> Result<Vec<u8>, Status> {
        self.may_read(from)?;
        self.refresh(now_ns);
        let mut bytes = Vec::with_capacity(4 * all.len());
        for address in all {
            if !address.is_multiple_of(4) {
                return Err(Status::BadAlignment);
            }
            bytes.extend_from_slice(self.memory.read(*address, 4)?);
        }
        Ok(bytes)
    }

    fn read_memory(
        &mut self,
        address: u32,
        length: u16,
        from: SocketAddrV4,
        now_ns: u64,
    ) -> Result<Vec<u8>, Status> {
        self.may_read(from)?;
        self.refresh(now_ns);
        let mut bytes = address.to_be_bytes().to_vec();
        bytes.extend_from_slice(self.memory.read(address, length.into())?);
        Ok(bytes)
    }

    fn write_registers(
        &mut self,
        writes: &[(u32, u32)],
        from: SocketAddrV4,
        now_ns: u64,
    ) -> (Status, Vec<u8>, Option<Action>) {
        let mut action = None;
        for (k, (address, value)) in writes.iter().enumerate() {
            match self.write(*address, &value.to_be_bytes(), from, now_ns) {
                Ok(done) => action = done.or(action),
                // the number of the write that failed; those before it are done
                Err(status) => return (status, written(k), action),
            }
        }
        (Status::Success, written(writes.len()), action)
    }

    /// Registers that are computed, as of now.
    fn refresh(&mut self, now_ns: u64) {
        let payload = u32::try_from(payload_bytes(&self.memory)).unwrap_or(u32::MAX);
        self.memory.set(at::PAYLOAD_SIZE, payload);
        self.memory.set_float(at::SPINDLE_ANGLE, self.angle_deg(now_ns));
    }

    /// Spindle angle at a time, degrees: at rest as it was written.
    pub(super) fn angle_deg(&self, t_ns: u64) -> f64 {
        let rpm = self.memory.float(at::SPINDLE_SPEED);
        if rpm == 0.0 || self.acquisition.is_none() {
            return self.spindle.angle_deg;
        }
        let turned_deg = 6.0 * rpm * t_ns.saturating_sub(self.spindle.since_ns) as f64 * 1e-9;
        (self.spindle.angle_deg + turned_deg).rem_euclid(360.0)
    }

    /// Releases control that was not heard of for the heartbeat's time.
    pub(crate) fn tick(&mut self, now_ns: u64) {
        let timeout_ns = u64::from(self.memory.get(at::HEARTBEAT)) * 1_000_000;
        let is_checked = self.memory.get(at::GVCP_CONFIGURATION) & 1 == 0;
        let is_gone = |c: &Controller| now_ns.saturating_sub(c.heard_ns) > timeout_ns;
        if is_checked && self.controller.as_ref().is_some_and(is_gone) {
            self.release();
        }
    }

    /// Gives control up: the stream is closed.
    pub(super) fn release(&mut self) {
        self.controller = None;
        self.acquisition = None;
        self.counts.channel += 1;
        self.counts.starts += 1;
        // a client that is gone holds the number of no frame
        let held = [at::CONTROLLER_PORT, at::CONTROLLER_ADDRESS, at::STREAM_PORT, at::HEAD_FRAME];
        for address in [at::PRIVILEGE].into_iter().chain(held) {
            self.memory.set(address, 0);
        }
    }

    /// Whether neither answers nor packets are sent.
    pub(crate) fn is_silent(&self, now_ns: u64) -> bool {
        now_ns < self.silent_until_ns
    }

    /// What the head does next; frames are ordered ahead of their time.
    pub(crate) fn next_task(&mut self, now_ns: u64) -> Option<Task> {
        if let Some(order) = self.cut.take() {
            self.memory.set(at::PASS_STATE, 1);
            return Some(Task::Cut(order));
        }
        let period_ns = self.period_ns();
        let stream = self.paced(stream(&self.memory)?, period_ns);
        let acquisition = self.acquisition.as_mut()?;
        let (number, scene_ns, due_ns) = acquisition.next(now_ns, period_ns)?;
        let started_ns = now_ns - acquisition.elapsed_ns(now_ns);
        let is_last = acquisition.remaining == Some(0);
        let order = FrameOrder {
            number,
            of_object: self.memory.get(at::HEAD_FRAME).checked_sub(1).map(u64::from),
            t_ns: due_ns,
            angle_deg: self.angle_deg(started_ns + scene_ns),
            z_mm: self.memory.float(at::CARRIAGE_Z),
            window: stream.window,
            format: stream.format.grey(),
            scene: self.scene(),
        };
        if is_last {
            self.acquisition = None;
        }
        let Counts { starts: acquisition, channel, .. } = self.counts;
        Some(Task::Frame(Box::new(FrameTask { order, stream, due_ns, acquisition, channel })))
    }

    /// A free run takes no more of the link than it needs: a frame is spread over half its period,
    /// at 1 Gbit/s or faster, so that it does not overrun a receiver's buffer in one burst.
    fn paced(&self, stream: StreamSettings, period_ns: u64) -> StreamSettings {
        if self.memory.get(at::TRIGGER_MODE) != 0 {
            return stream;
        }
        let frame_bytes = payload_bytes(&self.memory) as u64;
        let needed = frame_bytes.saturating_mul(2_000_000_000) / period_ns.max(1);
        let bytes_per_s = stream.bytes_per_s.min(needed.max(GIGABIT_BYTES_PER_S));
        StreamSettings { bytes_per_s, ..stream }
    }

    /// How frames are sent now; `None` where no stream is open.
    pub(crate) fn stream(&self) -> Option<StreamSettings> {
        stream(&self.memory)
    }

    /// Time from frame to frame, ns: that of the rate, not less than the exposure.
    fn period_ns(&self) -> u64 {
        let rate_hz = self.memory.float(at::FRAME_RATE).max(1e-3);
        (1e9 / rate_hz).max(1e3 * self.memory.float(at::EXPOSURE_TIME)).max(1.0) as u64
    }

    fn scene(&self) -> SceneOrder {
        let memory = &self.memory;
        SceneOrder {
            object: match memory.get(at::HEAD_OBJECT) {
                1 => Object::Part,
                2 => Object::Master { index: memory.get(at::MASTER_INDEX), clamped: self.counts.clamped },
                3 => Object::Flat,
                4 => Object::Dark,
                _ => Object::Drawn,
            },
            diameter_mm: memory.float(at::SHAFT_DIAMETER),
            spindle_rpm: memory.float(at::SPINDLE_SPEED),
            exposure_us: memory.float(at::EXPOSURE_TIME),
            gain_db: memory.float(at::GAIN),
            contamination: memory.float(at::CONTAMINATION),
        }
    }

    /// Whether a frame still waits to be sent: its acquisition was neither stopped nor started
    /// anew.
    pub(crate) fn is_wanted(&self, task: &FrameTask) -> bool {
        task.acquisition == self.counts.starts && task.channel == self.counts.channel
    }

    /// Number of the opening of the stream; a frame of an earlier one is not sent to its end.
    pub(crate) fn channel(&self) -> u64 {
        self.counts.channel
    }

    /// Id of the frame that is sent next.
    pub(crate) fn next_block(&mut self) -> u64 {
        self.counts.block += 1;
        self.memory.count(at::FRAMES_SENT);
        self.counts.block
    }

    /// Counts packets that were sent again.
    pub(crate) fn resent(&mut self, packets: u32) {
        let count = self.memory.get(at::PACKETS_RESENT).wrapping_add(packets);
        self.memory.set(at::PACKETS_RESENT, count);
    }

    /// A frame that could not be taken ends the acquisition, and its reason can be read.
    pub(crate) fn frame_refused(&mut self, why: &str) {
        self.acquisition = None;
        self.set_message(why);
    }

    /// How a pass ended.
    pub(crate) fn pass_ended(&mut self, result: &Result<(), String>) {
        self.memory.set(at::PASS_STATE, if result.is_ok() { 2 } else { 3 });
        self.set_message(result.as_ref().err().map_or("", String::as_str));
    }

    /// Sets the words that a client reads as HeadMessage.
    pub(super) fn set_message(&mut self, words: &str) {
        self.memory.set_text(at::MESSAGE, words, at::MESSAGE_BYTES as usize);
    }

    /// Sets the port from which the stream comes.
    pub(crate) fn set_source_port(&mut self, port: u16) {
        self.memory.set(at::STREAM_SOURCE_PORT, port.into());
    }
}

/// The payload that answers a write: how many registers were written.
fn written(registers: usize) -> Vec<u8> {
    (registers as u32).to_be_bytes().to_vec()
}

fn refused(refusal: Refusal) -> Option<Vec<u8>> {
    match refusal {
        Refusal::Status { id, answer_code, wants_answer: true, status } => {
            Some(gvcp::answer(Answer { status, code: answer_code, id }, &[]))
        }
        _ => None,
    }
}
