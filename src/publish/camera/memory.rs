//! The bytes of the camera by address: bootstrap registers, own registers, pass plan, XML.

use crate::publish::genicam::{DataSheet, address as at};
use crate::publish::gvcp::Status;
use crate::publish::gvsp::{Chunk, MIN_PACKET_BYTES};

/// The camera's memory; big-endian, as on the wire.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    bootstrap: Vec<u8>,
    head: Vec<u8>,
    passes: Vec<u8>,
    xml: Vec<u8>,
}

impl Memory {
    /// The memory of a head at rest.
    pub(crate) fn new(sheet: &DataSheet, xml: String) -> Self {
        let mut memory = Self {
            bootstrap: vec![0; at::BOOTSTRAP_BYTES as usize],
            head: vec![0; at::HEAD_BYTES as usize],
            passes: vec![0; at::PASS_BYTES as usize],
            xml: xml.into_bytes(),
        };
        let bytes = memory.xml.len();
        // whole words, as memory is read
        memory.xml.resize(bytes.next_multiple_of(4), b'\n');
        memory.set_text(at::FIRST_URL, &memory.xml_url(), 512);
        memory.bootstrap_values(sheet);
        memory.image_values(sheet);
        memory.head_values(sheet);
        memory
    }

    /// Where the XML is: a name, its address and length in hexadecimal digits.
    pub(crate) fn xml_url(&self) -> String {
        format!("Local:shadowgauge_head.xml;{:x};{:x}", at::XML, self.xml.len())
    }

    fn bootstrap_values(&mut self, sheet: &DataSheet) {
        let (mac_high, mac_low) = sheet.mac();
        // persistent addresses and such are not offered: the system sets them
        let (lla, dhcp) = (4, 2);
        for (address, value) in [
            (at::VERSION, 0x0002_0000),
            // big-endian, a transmitter, UTF-8
            (at::DEVICE_MODE, 0x8000_0001),
            (at::MAC_HIGH, mac_high),
            (at::MAC_LOW, mac_low),
            (at::IP_CAPABILITY, lla | dhcp),
            (at::IP_CONFIGURATION, lla | dhcp),
            (at::IP_ADDRESS, sheet.address.into()),
            (at::SUBNET_MASK, sheet.mask()),
            (at::INTERFACES, 1),
            (at::LINK_SPEED, 10_000),
            (at::MESSAGE_CHANNELS, 0),
            (at::STREAM_CHANNELS, 1),
            // source port, ids of 16 bits
            (at::GVSP_CAPABILITY, 0xc000_0000),
            // user name, serial number, heartbeat off, link speed, controller's address; resend,
            // write memory, several registers at once
            (at::GVCP_CAPABILITY, 0xf800_0007),
            (at::HEARTBEAT, 3000),
            (at::TICK_FREQUENCY, 0),
            (at::TICK_FREQUENCY + 4, 1_000_000_000),
            (at::GVSP_CONFIGURATION, 0x4000_0000),
            (at::PACKET_SIZE, sheet.mtu.clamp(MIN_PACKET_BYTES, 1500)),
        ] {
            self.set(address, value);
        }
        self.set_text(at::VENDOR, "shadowgauge", 32);
        self.set_text(at::MODEL, &sheet.model, 32);
        self.set_text(at::DEVICE_VERSION, env!("CARGO_PKG_VERSION"), 32);
        self.set_text(at::VENDOR_INFO, "simulated shadowgraph head", 48);
        self.set_text(at::SERIAL, &sheet.serial, 16);
    }

    fn image_values(&mut self, sheet: &DataSheet) {
        for (address, value) in [
            (at::SENSOR_WIDTH, sheet.columns),
            (at::SENSOR_HEIGHT, sheet.rows),
            (at::WIDTH, sheet.columns),
            (at::HEIGHT, sheet.rows),
            (at::PIXEL_FORMAT, sheet.format.code()),
            (at::ACQUISITION_FRAMES, 1),
            (at::EXPOSURE_MODE, 1),
            // 10 Gbit/s
            (at::THROUGHPUT_LIMIT, 1_250_000_000),
            (at::CHUNK_ENABLE, 1),
        ] {
            self.set(address, value);
        }
        for k in 0..Chunk::ALL.len() as u32 {
            self.set(at::CHUNK_ENABLE_1 + 8 * k, 1);
        }
        self.set_float(at::FRAME_RATE, sheet.frame_rate_hz);
        self.set_float(at::EXPOSURE_TIME, sheet.exposure_us);
        self.set_float(at::BLACK_LEVEL, sheet.black_level_counts);
    }

    fn head_values(&mut self, sheet: &DataSheet) {
        self.set_float(at::CARRIAGE_Z, sheet.length_mm / 2.0);
        self.set_float(at::SHAFT_DIAMETER, sheet.diameter_mm);
        self.set_float(at::SPINDLE_SPEED, sheet.spindle_rpm);
        self.set_float(at::CONTAMINATION, sheet.contamination);
        // the reference temperature of ISO 1
        self.set_float(at::TEMPERATURE, 20.0);
        self.set(at::PASS_NUMBER, 1);
        self.set_float(at::PASS_NOMINAL, sheet.pass_nominal_mm.first().copied().unwrap_or(0.0));
        self.set(at::PASS_STATION_COUNT, sheet.station_z_mm.len() as u32);
        for (z_mm, k) in sheet.station_z_mm.iter().zip(0..) {
            self.set_float(at::PASS_STATIONS + 8 * k, *z_mm);
        }
    }

    /// Place and length of the part of memory that holds an address.
    fn part(&self, address: u32) -> Option<(u32, &[u8])> {
        let parts = [
            (0, &self.bootstrap),
            (at::HEAD, &self.head),
            (at::PASS_OFFSETS, &self.passes),
            (at::XML, &self.xml),
        ];
        let holds = |(from, bytes): &(u32, &Vec<u8>)| {
            address.checked_sub(*from).is_some_and(|at| (at as usize) < bytes.len())
        };
        parts.into_iter().find(holds).map(|(from, bytes)| (from, bytes.as_slice()))
    }

    /// Bytes from an address on.
    ///
    /// # Errors
    /// Where no memory is.
    pub(crate) fn read(&self, address: u32, length: usize) -> Result<&[u8], Status> {
        let (from, bytes) = self.part(address).ok_or(Status::InvalidAddress)?;
        let start = (address - from) as usize;
        bytes.get(start..start + length).ok_or(Status::InvalidAddress)
    }

    /// Keeps bytes at an address of a register; those beyond the memory are dropped.
    pub(crate) fn write(&mut self, address: u32, bytes: &[u8]) {
        let (from, part) = match address {
            0..at::BOOTSTRAP_BYTES => (0, &mut self.bootstrap),
            at::HEAD..at::PASS_OFFSETS => (at::HEAD, &mut self.head),
            at::PASS_OFFSETS..at::XML => (at::PASS_OFFSETS, &mut self.passes),
            _ => return,
        };
        let start = (address - from) as usize;
        if let Some(place) = part.get_mut(start..start + bytes.len()) {
            place.copy_from_slice(bytes);
        }
    }

    /// A register of 32 bits; 0 where none is.
    pub(crate) fn get(&self, address: u32) -> u32 {
        let word = self.read(address, 4).ok().and_then(|bytes| bytes.try_into().ok());
        word.map_or(0, u32::from_be_bytes)
    }

    /// Sets a register of 32 bits.
    pub(crate) fn set(&mut self, address: u32, value: u32) {
        self.write(address, &value.to_be_bytes());
    }

    /// Adds one to a counter, which starts over at its end.
    pub(crate) fn count(&mut self, address: u32) {
        self.set(address, self.get(address).wrapping_add(1));
    }

    /// A register of 64 bits as f64.
    pub(crate) fn float(&self, address: u32) -> f64 {
        let bytes = self.read(address, 8).ok().and_then(|bytes| bytes.try_into().ok());
        bytes.map_or(0.0, f64::from_be_bytes)
    }

    /// Sets an f64.
    pub(crate) fn set_float(&mut self, address: u32, value: f64) {
        self.write(address, &value.to_be_bytes());
    }

    /// Sets a text, cut off before the last of `bytes` bytes, the rest filled with 0.
    pub(crate) fn set_text(&mut self, address: u32, text: &str, bytes: usize) {
        let mut end = text.len().min(bytes - 1);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        let mut padded = vec![0; bytes];
        padded[..end].copy_from_slice(&text.as_bytes()[..end]);
        self.write(address, &padded);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_to_a_discovery_is_the_start_of_the_memory() {
        let memory = Memory::new(&DataSheet::of_tests(), "<xml/>".into());
        let bytes = memory.read(0, at::DISCOVERY_BYTES).unwrap();
        // published layout: version, mode, MAC, address at 36, mask at 52, maker at 72, model 104
        assert_eq!(bytes[..8], [0, 2, 0, 0, 0x80, 0, 0, 1]);
        assert_eq!(bytes[8..16], [0, 0, 2, 0x53, 127, 0, 0, 1]);
        assert_eq!((&bytes[36..40], &bytes[52..56]), (&[127, 0, 0, 1][..], &[255, 0, 0, 0][..]));
        assert_eq!(&bytes[72..84], b"shadowgauge\0");
        assert_eq!((&bytes[104..117], &bytes[216..221]), (&b"head of tests"[..], &b"SG-1\0"[..]));
        let url = memory.read(at::FIRST_URL, 36).unwrap();
        assert_eq!(&url[..35], b"Local:shadowgauge_head.xml;100000;8");
        assert_eq!(memory.read(at::XML, 8).unwrap(), b"<xml/>\n\n");
    }

    #[test]
    fn what_no_register_holds_is_an_address_that_is_refused() {
        let memory = Memory::new(&DataSheet::of_tests(), "<xml/>".into());
        for (address, length) in [(0xffe, 4), (0x2000, 4), (at::XML + 8, 4), (u32::MAX - 3, 4), (at::XML, 12)]
        {
            assert_eq!(memory.read(address, length), Err(Status::InvalidAddress), "{address:#x}");
        }
    }

    #[test]
    fn a_text_is_cut_off_at_a_whole_character() {
        let mut memory = Memory::new(&DataSheet::of_tests(), String::new());
        memory.set_text(at::USER_NAME, "Durchmesser-µµµµ", 16);
        assert_eq!(memory.read(at::USER_NAME, 16).unwrap(), "Durchmesser-µ\0\0".as_bytes());
    }
}
