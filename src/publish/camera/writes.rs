//! What a write into a register sets off.

use std::net::SocketAddrV4;

use super::acquisition::Acquisition;
use super::camera::{Action, Camera, Spindle};
use super::clients::{Controller, Privilege};
use super::settings::{stream, window};
use crate::publish::genicam::address as at;
use crate::publish::gvcp::Status;
use crate::publish::gvsp::{MIN_PACKET_BYTES, UDP_IP_HEADER_BYTES};
use crate::publish::head::PassOrder;

/// Bit of the packet size: send a packet of this size.
const FIRE_TEST_PACKET: u32 = 0x8000_0000;

/// A write into one register of 32 bits or of another length.
struct Write<'a> {
    address: u32,
    bytes: &'a [u8],
    now_ns: u64,
}

impl Write<'_> {
    /// The value of 32 bits; 0 for registers of another length.
    fn value(&self) -> u32 {
        self.bytes.try_into().map_or(0, u32::from_be_bytes)
    }

    fn float(&self) -> f64 {
        self.bytes.try_into().map_or(0.0, f64::from_be_bytes)
    }
}

impl Camera {
    /// Writes bytes into the registers that they fill.
    ///
    /// # Errors
    /// Where another client has control, no register fits, or a value is refused: nothing of a
    /// register is then changed.
    pub(super) fn write(
        &mut self,
        address: u32,
        bytes: &[u8],
        from: SocketAddrV4,
        now_ns: u64,
    ) -> Result<Option<Action>, Status> {
        if !address.is_multiple_of(4) {
            return Err(Status::BadAlignment);
        }
        if address == at::PRIVILEGE && bytes.len() == 4 {
            return self.write_privilege(&Write { address, bytes, now_ns }, from);
        }
        if self.controller.is_none_or(|c| c.client != from) {
            return Err(Status::AccessDenied);
        }
        let writes = self.map.writes(address, bytes)?;
        if self.acquisition.is_some() && writes.iter().any(|(register, _)| register.at_rest) {
            return Err(Status::WriteProtect);
        }
        let places: Vec<(u32, &[u8])> =
            writes.iter().map(|(register, own)| (register.address, *own)).collect();
        let mut action = None;
        for (address, bytes) in places {
            action = self.put(&Write { address, bytes, now_ns })?.or(action);
        }
        Ok(action)
    }

    fn write_privilege(&mut self, write: &Write<'_>, from: SocketAddrV4) -> Result<Option<Action>, Status> {
        if self.controller.is_some_and(|c| c.client != from) {
            return Err(Status::AccessDenied);
        }
        if write.value() & !3 != 0 {
            return Err(Status::InvalidParameter);
        }
        let Some(privilege) = Privilege::from_register(write.value()) else {
            if self.controller.is_some() {
                self.release();
            }
            return Ok(None);
        };
        self.controller = Some(Controller { client: from, privilege, heard_ns: write.now_ns });
        self.memory.set(at::PRIVILEGE, write.value());
        self.memory.set(at::CONTROLLER_PORT, from.port().into());
        self.memory.set(at::CONTROLLER_ADDRESS, (*from.ip()).into());
        Ok(None)
    }

    /// Keeps a value that fits its register, and does what follows from it.
    fn put(&mut self, write: &Write<'_>) -> Result<Option<Action>, Status> {
        match write.address {
            at::WIDTH | at::HEIGHT | at::OFFSET_X | at::OFFSET_Y => return self.put_window(write),
            at::PACKET_SIZE => return self.put_packet_size(write),
            at::STREAM_PORT => self.open_or_close(write.value()),
            at::ACQUISITION_START if write.value() == 1 => self.start(write.now_ns)?,
            at::ACQUISITION_STOP if write.value() == 1 => self.stop(),
            at::TRIGGER_SOFTWARE if write.value() == 1 => self.trigger(write.now_ns),
            at::TIMESTAMP_CONTROL if write.value() == 2 => {
                self.memory.write(at::TIMESTAMP, &write.now_ns.to_be_bytes());
            }
            at::PASS_CUT if write.value() == 1 => self.order_pass()?,
            at::ACQUISITION_START
            | at::ACQUISITION_STOP
            | at::TRIGGER_SOFTWARE
            | at::TIMESTAMP_CONTROL
            | at::PASS_CUT => {}
            at::SPINDLE_ANGLE => {
                self.spindle =
                    Spindle { angle_deg: write.float(), since_ns: self.scene_now_ns(write.now_ns) };
            }
            at::SPINDLE_SPEED => {
                let since_ns = self.scene_now_ns(write.now_ns);
                self.spindle = Spindle { angle_deg: self.angle_deg(since_ns), since_ns };
                self.memory.write(write.address, write.bytes);
            }
            at::FAULT_SILENCE => self.silent_until_ns = write.now_ns + u64::from(write.value()) * 1_000_000,
            // the image stays in the frame: clients switch all chunks off before they choose
            at::CHUNK_ENABLE => {}
            _ => self.keep(write),
        }
        Ok(None)
    }

    /// Registers that do nothing but hold a value, and those whose change others follow.
    fn keep(&mut self, write: &Write<'_>) {
        if write.address == at::USER_NAME {
            self.memory.write(at::USER_NAME, &[0; 16]);
        }
        self.memory.write(write.address, write.bytes);
        match write.address {
            at::MASTER_INDEX | at::HEAD_OBJECT => self.counts.clamped += 1,
            at::PASS_NUMBER => {
                let index = (write.value() as usize).checked_sub(1);
                let nominal_mm = index.and_then(|index| self.sheet.pass_nominal_mm.get(index).copied());
                let nominal_mm = nominal_mm.unwrap_or(0.0);
                self.memory.set_float(at::PASS_NOMINAL, nominal_mm);
            }
            _ => {}
        }
    }

    fn scene_now_ns(&self, now_ns: u64) -> u64 {
        if self.acquisition.is_some() { now_ns } else { 0 }
    }

    fn put_window(&mut self, write: &Write<'_>) -> Result<Option<Action>, Status> {
        let mut wanted = window(&self.memory);
        match write.address {
            at::WIDTH => wanted.columns = write.value(),
            at::HEIGHT => wanted.rows = write.value(),
            at::OFFSET_X => wanted.column = write.value(),
            _ => wanted.row = write.value(),
        }
        let inside = |from: u32, length: u32, all: u32| {
            length > 0 && from.checked_add(length).is_some_and(|end| end <= all)
        };
        let fits = inside(wanted.column, wanted.columns, self.sheet.columns)
            && inside(wanted.row, wanted.rows, self.sheet.rows);
        if !fits {
            return Err(Status::InvalidParameter);
        }
        self.memory.write(write.address, write.bytes);
        Ok(None)
    }

    /// The size must be one that the network carries: a larger packet would be cut in pieces on the
    /// way, which the standard library cannot forbid.
    fn put_packet_size(&mut self, write: &Write<'_>) -> Result<Option<Action>, Status> {
        let (size, fires) = (write.value() & 0xffff, write.value() & FIRE_TEST_PACKET != 0);
        if !(MIN_PACKET_BYTES..=self.sheet.mtu).contains(&size) {
            return Err(Status::InvalidParameter);
        }
        self.memory.set(at::PACKET_SIZE, write.value() & !FIRE_TEST_PACKET);
        let to = stream(&self.memory).map(|stream| stream.to).filter(|_| fires);
        Ok(to.map(|to| Action::TestPacket(to, size as usize - UDP_IP_HEADER_BYTES)))
    }

    /// Ids of frames begin anew with every opening of the stream.
    fn open_or_close(&mut self, port: u32) {
        self.memory.set(at::STREAM_PORT, port & 0xffff);
        self.counts.block = 0;
        self.counts.channel += 1;
        if port & 0xffff == 0 {
            self.stop();
        }
    }

    fn start(&mut self, now_ns: u64) -> Result<(), Status> {
        if self.acquisition.is_some() {
            return Err(Status::WriteProtect);
        }
        let remaining = match self.memory.get(at::ACQUISITION_MODE) {
            0 => None,
            1 => Some(1),
            _ => Some(self.memory.get(at::ACQUISITION_FRAMES).into()),
        };
        self.counts.starts += 1;
        self.spindle.since_ns = now_ns;
        let triggered = self.memory.get(at::TRIGGER_MODE) != 0;
        self.acquisition = Some(Acquisition::new(now_ns, remaining, triggered));
        self.set_message("");
        Ok(())
    }

    fn stop(&mut self) {
        if self.acquisition.take().is_some() {
            self.counts.starts += 1;
        }
    }

    /// A trigger, by the faults that are asked for taken once, twice or not at all.
    fn trigger(&mut self, now_ns: u64) {
        self.counts.triggers += 1;
        let every = |address| {
            let nth = u64::from(self.memory.get(address));
            nth > 0 && self.counts.triggers.is_multiple_of(nth)
        };
        let (ignored, doubled) = (every(at::FAULT_TRIGGER_IGNORED), every(at::FAULT_TRIGGER_DOUBLED));
        let times = if ignored { 0 } else { 1 + u32::from(doubled) };
        let mut taken = 0;
        if let Some(acquisition) = &mut self.acquisition {
            taken = (0..times).filter(|_| acquisition.trigger(now_ns)).count();
        }
        if taken == 0 {
            self.memory.count(at::TRIGGERS_MISSED);
        }
    }

    fn order_pass(&mut self) -> Result<(), Status> {
        // idle, cut or refused; not while the last one is cut
        if self.memory.get(at::PASS_STATE) == 1 || self.cut.is_some() {
            return Err(Status::WriteProtect);
        }
        let stations = self.sheet.station_z_mm.len() as u32;
        let offset_mm = (0..stations).map(|k| self.memory.float(at::PASS_OFFSETS + 8 * k)).collect();
        self.memory.set(at::PASS_STATE, 1);
        self.cut = Some(PassOrder { pass: self.memory.get(at::PASS_NUMBER), offset_mm });
        Ok(())
    }
}
