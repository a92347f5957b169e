//! A feature: its name, what it is for, its register and what may be written into it.

/// Category of the SFNC in which a client lists a feature; there its name ends in Control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Category {
    /// What the device is.
    Device,
    /// Size and format.
    ImageFormat,
    /// When frames are taken.
    Acquisition,
    /// Gain and black level.
    Analog,
    /// Angle and carriage.
    Encoder,
    /// Values behind the pixels.
    ChunkData,
    /// The wire.
    TransportLayer,
    /// Shaft, spindle, contamination, passes: the head's own.
    Head,
    /// Faults on demand: the head's own.
    Fault,
}

impl Category {
    /// All, in the order of the XML.
    pub(crate) const ALL: [Self; 9] = [
        Self::Device,
        Self::ImageFormat,
        Self::Acquisition,
        Self::Analog,
        Self::Encoder,
        Self::ChunkData,
        Self::TransportLayer,
        Self::Head,
        Self::Fault,
    ];

    /// Its name in the SFNC.
    pub(crate) fn name(self) -> String {
        format!("{self:?}Control")
    }
}

/// Who may do what with a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    /// Clients only read it.
    Read,
    /// The client in control writes it.
    Write,
    /// The same, but not while frames are acquired.
    WriteAtRest,
}

/// A limit of an integer: a number, or a node of the XML that computes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Limit {
    /// A number.
    Is(u32),
    /// A node; the number is the limit that never changes.
    Node(&'static str, u32),
}

impl Limit {
    /// The limit that never changes.
    pub(crate) fn fixed(&self) -> u32 {
        match self {
            Self::Is(value) | Self::Node(_, value) => *value,
        }
    }
}

/// What a register holds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Kind {
    /// 32 bits, from a least to a largest value.
    Integer(u32, Limit),
    /// 64 bits, read only.
    Long,
    /// Bits of a register of 32, numbered from the most significant: first, last, then the least
    /// and the largest value.
    Bits([u32; 2], [u32; 2]),
    /// One bit of a register of 32, numbered so.
    Bit(u32),
    /// The same, named Off and On.
    Switch(u32),
    /// An f64 between limits, with its unit.
    Float(f64, f64, &'static str),
    /// One of the named values.
    Choice(Vec<(&'static str, u32)>),
    /// Off and on.
    Flag,
    /// The value that starts something.
    Command(u32),
    /// Bytes of UTF-8, 0 at the end.
    Text(u32),
}

impl Kind {
    /// Bytes of the register.
    pub(crate) fn bytes(&self) -> u32 {
        match self {
            Self::Long | Self::Float(..) => 8,
            Self::Text(bytes) => *bytes,
            _ => 4,
        }
    }
}

/// A feature whose register is one of several, chosen by another feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Selected {
    /// The choosing feature.
    pub by: &'static str,
    /// Bytes from one register to the next.
    pub stride: u32,
    /// Number of registers.
    pub count: u32,
}

/// A feature of the head.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Feature {
    /// Name of the SFNC, or the head's own.
    pub name: &'static str,
    /// Where it is listed.
    pub category: Category,
    /// One sentence for users.
    pub about: &'static str,
    /// Its register.
    pub address: u32,
    /// What the register holds.
    pub kind: Kind,
    /// Who writes it.
    pub access: Access,
    /// Whether another feature chooses the register.
    pub selected: Option<Selected>,
}

impl Feature {
    /// A feature that clients read.
    pub(crate) fn new(name: &'static str, category: Category, address: u32, kind: Kind) -> Self {
        Self { name, category, about: "", address, kind, access: Access::Read, selected: None }
    }

    /// With its sentence.
    pub(crate) fn about(self, about: &'static str) -> Self {
        Self { about, ..self }
    }

    /// Written by the client in control.
    pub(crate) fn written(self) -> Self {
        Self { access: Access::Write, ..self }
    }

    /// Written while no frame is acquired.
    pub(crate) fn at_rest(self) -> Self {
        Self { access: Access::WriteAtRest, ..self }
    }

    /// One of several registers.
    pub(crate) fn selected(self, by: &'static str, stride: u32, count: u32) -> Self {
        Self { selected: Some(Selected { by, stride, count }), ..self }
    }
}
