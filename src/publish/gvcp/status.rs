//! Status codes of answers and stream packets (GigE Vision 2.2, table of status codes).

/// Status of an answer or of a stream packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Status {
    /// Done.
    Success,
    /// The command is not known to the device.
    NotImplemented,
    /// A value is out of its range.
    InvalidParameter,
    /// No register lies at the address.
    InvalidAddress,
    /// The register cannot be written, or not while frames are acquired.
    WriteProtect,
    /// The address or the length is no multiple of four.
    BadAlignment,
    /// Another application has control.
    AccessDenied,
    /// The packet is not in memory (any more).
    PacketUnavailable,
    /// The lengths of a datagram do not agree.
    InvalidHeader,
}

impl Status {
    /// The code on the wire.
    pub(crate) const fn code(self) -> u16 {
        match self {
            Self::Success => 0x0000,
            Self::NotImplemented => 0x8001,
            Self::InvalidParameter => 0x8002,
            Self::InvalidAddress => 0x8003,
            Self::WriteProtect => 0x8004,
            Self::BadAlignment => 0x8005,
            Self::AccessDenied => 0x8006,
            Self::PacketUnavailable => 0x800c,
            Self::InvalidHeader => 0x800e,
        }
    }
}
