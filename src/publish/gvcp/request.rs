//! A datagram of a client: key 0x42, flags, command, length of what follows, request id, payload.

use super::status::Status;

/// Largest datagram of the control protocol, bytes: an IP packet of 576 less the headers of IP and
/// UDP.
pub(crate) const LARGEST_DATAGRAM: usize = 548;

/// First byte of every command.
const KEY: u8 = 0x42;
/// Flag: the client waits for an answer.
const WANTS_ANSWER: u8 = 0x01;
/// Flag of a resend request: ids of 64 bits.
const EXTENDED_IDS: u8 = 0x10;

/// A command with its number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Request {
    /// The client's number of it, which the answer repeats; never 0.
    pub id: u16,
    /// Whether the client waits for an answer.
    pub wants_answer: bool,
    /// What is asked for.
    pub command: Command,
}

/// What a client asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Command {
    /// Who is there.
    Discovery,
    /// Registers of four bytes, by address.
    ReadRegisters(Vec<u32>),
    /// Registers of four bytes and what to write into them.
    WriteRegisters(Vec<(u32, u32)>),
    /// Bytes from an address on.
    ReadMemory {
        /// First address.
        address: u32,
        /// Number of bytes.
        length: u16,
    },
    /// Bytes to write from an address on.
    WriteMemory {
        /// First address.
        address: u32,
        /// The bytes.
        data: Vec<u8>,
    },
    /// Packets of a frame once more.
    Resend(Resend),
    /// A command without meaning here, by its code.
    Other(u16),
}

impl Command {
    /// The code of its answer.
    pub(crate) fn answer_code(&self) -> u16 {
        match self {
            Self::Discovery => 0x0003,
            Self::Resend(_) => 0x0041,
            Self::ReadRegisters(_) => 0x0081,
            Self::WriteRegisters(_) => 0x0083,
            Self::ReadMemory { .. } => 0x0085,
            Self::WriteMemory { .. } => 0x0087,
            Self::Other(code) => code.wrapping_add(1),
        }
    }
}

/// Packets of a frame that a client misses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Resend {
    /// Stream channel.
    pub channel: u16,
    /// Id of the frame: 16 bits, or 64 of the extended kind.
    pub block: u64,
    /// First packet, 0 the leader.
    pub first: u32,
    /// Last packet, this one included.
    pub last: u32,
    /// Whether the id has 64 bits.
    pub extended: bool,
}

/// Why a datagram is no request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// No command of this protocol: it gets no answer.
    Foreign,
    /// A command whose content cannot be: it is answered by this status.
    Status {
        /// Number of the request.
        id: u16,
        /// Code of its answer.
        answer_code: u16,
        /// Whether the client waits for an answer.
        wants_answer: bool,
        /// The reason.
        status: Status,
    },
}

/// A request from a datagram.
///
/// # Errors
/// Where it is foreign, or its lengths do not agree.
pub(crate) fn parse(datagram: &[u8]) -> Result<Request, Refusal> {
    let Some((&[key, flags, c0, c1, l0, l1, i0, i1], payload)) = datagram.split_first_chunk::<8>() else {
        return Err(Refusal::Foreign);
    };
    let (code, id) = (u16::from_be_bytes([c0, c1]), u16::from_be_bytes([i0, i1]));
    if key != KEY || id == 0 || datagram.len() > LARGEST_DATAGRAM {
        return Err(Refusal::Foreign);
    }
    let wants_answer = flags & WANTS_ANSWER != 0;
    let whole = payload.len() == usize::from(u16::from_be_bytes([l0, l1]));
    let command = if whole { command(code, flags, payload) } else { Err(Status::InvalidHeader) };
    command.map(|command| Request { id, wants_answer, command }).map_err(|status| Refusal::Status {
        id,
        answer_code: code.wrapping_add(1),
        wants_answer,
        status,
    })
}

fn command(code: u16, flags: u8, payload: &[u8]) -> Result<Command, Status> {
    Ok(match code {
        0x0002 => Command::Discovery,
        0x0040 => Command::Resend(resend(flags, payload)?),
        0x0080 => Command::ReadRegisters(words(payload)?),
        0x0082 => Command::WriteRegisters(pairs(payload)?),
        0x0084 => read_memory(payload)?,
        0x0086 => write_memory(payload)?,
        other => Command::Other(other),
    })
}

/// Whole words of four bytes, at least one.
fn words(payload: &[u8]) -> Result<Vec<u32>, Status> {
    let (words, rest) = payload.as_chunks::<4>();
    if words.is_empty() || !rest.is_empty() {
        return Err(Status::InvalidHeader);
    }
    let words: Vec<u32> = words.iter().map(|word| u32::from_be_bytes(*word)).collect();
    Ok(words)
}

fn pairs(payload: &[u8]) -> Result<Vec<(u32, u32)>, Status> {
    let words = words(payload)?;
    let (pairs, rest) = words.as_chunks::<2>();
    if rest.is_empty() {
        Ok(pairs.iter().map(|p| (p[0], p[1])).collect())
    } else {
        Err(Status::InvalidHeader)
    }
}

/// Most bytes that an answer of read memory holds beside its address.
const MOST_MEMORY: u16 = 536;

fn read_memory(payload: &[u8]) -> Result<Command, Status> {
    let words = words(payload)?;
    let [address, count] = words[..] else { return Err(Status::InvalidHeader) };
    // the upper half is reserved
    let length = (count & 0xffff) as u16;
    if !address.is_multiple_of(4) || !length.is_multiple_of(4) {
        return Err(Status::BadAlignment);
    }
    if length == 0 || length > MOST_MEMORY {
        return Err(Status::InvalidParameter);
    }
    Ok(Command::ReadMemory { address, length })
}

fn write_memory(payload: &[u8]) -> Result<Command, Status> {
    let Some((address, data)) = payload.split_first_chunk::<4>() else { return Err(Status::InvalidHeader) };
    let address = u32::from_be_bytes(*address);
    if data.is_empty() {
        return Err(Status::InvalidHeader);
    }
    if !address.is_multiple_of(4) || !data.len().is_multiple_of(4) {
        return Err(Status::BadAlignment);
    }
    Ok(Command::WriteMemory { address, data: data.to_vec() })
}

/// Packet ids have 24 bits, of extended ids 32; the block of 16 bits, or of 64 behind the packets.
fn resend(flags: u8, payload: &[u8]) -> Result<Resend, Status> {
    let words = words(payload)?;
    let (channel, short) = ((words[0] >> 16) as u16, u64::from(words[0] & 0xffff));
    match (flags & EXTENDED_IDS != 0, &words[1..]) {
        (false, &[first, last]) => {
            let (first, last) = (first & 0x00ff_ffff, last & 0x00ff_ffff);
            Ok(Resend { channel, block: short, first, last, extended: false })
        }
        (true, &[first, last, high, low]) => {
            let block = u64::from(high) << 32 | u64::from(low);
            Ok(Resend { channel, block, first, last, extended: true })
        }
        _ => Err(Status::InvalidHeader),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn refused(datagram: &[u8]) -> Status {
        match parse(datagram) {
            Err(Refusal::Status { status, .. }) => status,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn commands_are_read_by_their_published_layout() {
        // discovery: 42 11 0002 0000 id
        let discovery = parse(&[0x42, 0x11, 0, 2, 0, 0, 0x12, 0x34]).unwrap();
        assert_eq!(discovery, Request { id: 0x1234, wants_answer: true, command: Command::Discovery });
        // read register 0x0A00
        let read = parse(&[0x42, 1, 0, 0x80, 0, 4, 0, 1, 0, 0, 0x0a, 0]).unwrap();
        assert_eq!(read.command, Command::ReadRegisters(vec![0x0a00]));
        // write 2 into 0x0A00, no answer
        let write = parse(&[0x42, 0, 0, 0x82, 0, 8, 0, 2, 0, 0, 0x0a, 0, 0, 0, 0, 2]).unwrap();
        let command = Command::WriteRegisters(vec![(0x0a00, 2)]);
        assert_eq!(write, Request { id: 2, wants_answer: false, command });
        // read 512 bytes from 0x200; the reserved half is ignored
        let memory = parse(&[0x42, 1, 0, 0x84, 0, 8, 0, 3, 0, 0, 2, 0, 0xff, 0xff, 2, 0]).unwrap();
        assert_eq!(memory.command, Command::ReadMemory { address: 0x200, length: 512 });
        let bytes = parse(&[0x42, 1, 0, 0x86, 0, 8, 0, 4, 0, 0, 0, 0xe8, b'h', b'e', b'a', b'd']).unwrap();
        assert_eq!(bytes.command, Command::WriteMemory { address: 0xe8, data: b"head".to_vec() });
        assert_eq!(parse(&[0x42, 1, 1, 0, 0, 0, 0, 5]).unwrap().command, Command::Other(0x0100));
    }

    #[test]
    fn resend_requests_have_ids_of_16_or_64_bits() {
        let short = [0x42, 0, 0, 0x40, 0, 12, 0, 9, 0, 0, 0, 7, 0xff, 0, 0, 2, 0, 0, 0, 5];
        let wanted = Resend { channel: 0, block: 7, first: 2, last: 5, extended: false };
        assert_eq!(parse(&short).unwrap().command, Command::Resend(wanted));
        let mut long = short.to_vec();
        (long[1], long[5]) = (0x10, 20);
        long.extend([0, 0, 0, 1, 0, 0, 0, 2]);
        let wanted = Resend { block: (1 << 32) + 2, extended: true, first: 0xff00_0002, ..wanted };
        assert_eq!(parse(&long).unwrap().command, Command::Resend(wanted));
        long[1] = 0;
        assert_eq!(refused(&long), Status::InvalidHeader, "an extended length without its flag");
    }

    #[test]
    fn what_cannot_be_is_foreign_or_refused_by_its_reason() {
        for foreign in
            [&[][..], &[0x42, 1, 0, 2, 0, 0, 0], &[0x41, 1, 0, 2, 0, 0, 0, 1], &[0x42, 1, 0, 2, 0, 0, 0, 0]]
        {
            assert_eq!(parse(foreign), Err(Refusal::Foreign), "{foreign:?}");
        }
        let mut long = vec![0x42, 1, 0, 0x80, 2, 0x1d, 0, 1];
        long.resize(LARGEST_DATAGRAM + 1, 0);
        assert_eq!(parse(&long), Err(Refusal::Foreign), "longer than the protocol allows");
        assert_eq!(refused(&[0x42, 1, 0, 0x80, 0, 8, 0, 1, 0, 0, 0, 0]), Status::InvalidHeader);
        assert_eq!(refused(&[0x42, 1, 0, 0x80, 0, 0, 0, 1]), Status::InvalidHeader);
        assert_eq!(refused(&[0x42, 1, 0, 0x82, 0, 4, 0, 1, 0, 0, 0, 0]), Status::InvalidHeader);
        assert_eq!(refused(&[0x42, 1, 0, 0x84, 0, 8, 0, 1, 0, 0, 0, 2, 0, 0, 0, 4]), Status::BadAlignment);
        assert_eq!(
            refused(&[0x42, 1, 0, 0x84, 0, 8, 0, 1, 0, 0, 0, 0, 0, 0, 2, 28]),
            Status::InvalidParameter
        );
        assert_eq!(refused(&[0x42, 1, 0, 0x86, 0, 6, 0, 1, 0, 0, 0, 0, 1, 2]), Status::BadAlignment);
    }

    proptest! {
        /// Any datagram is parsed or refused, and what is kept of it is no longer than itself.
        #[test]
        fn any_datagram_is_parsed_or_refused_within_its_own_length(
            mut datagram in prop::collection::vec(any::<u8>(), 0..700),
            framed: bool,
            code in prop::sample::select(vec![2_u16, 0x40, 0x80, 0x82, 0x84, 0x86, 0x100]),
        ) {
            if framed && datagram.len() >= 8 {
                let length = (datagram.len() - 8) as u16;
                datagram[0] = KEY;
                datagram[2..4].copy_from_slice(&code.to_be_bytes());
                datagram[4..6].copy_from_slice(&length.to_be_bytes());
            }
            let kept = match parse(&datagram).map(|request| request.command) {
                Ok(Command::ReadRegisters(all)) => 4 * all.len(),
                Ok(Command::WriteRegisters(all)) => 8 * all.len(),
                Ok(Command::WriteMemory { data, .. }) => data.len(),
                Ok(Command::ReadMemory { length, .. }) => {
                    prop_assert!(length <= MOST_MEMORY);
                    0
                }
                _ => 0,
            };
            prop_assert!(kept <= datagram.len() && kept < LARGEST_DATAGRAM);
        }
    }
}
