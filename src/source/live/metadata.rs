//! Metadata of a live frame: times with the clocks that they are of, values with their provenance.

/// A clock that times are read from. Times of two clocks are never compared without a
/// [`ClockMap`](super::clock_map::ClockMap).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Clock {
    /// This machine's, ns since 1970 (`CLOCK_REALTIME`).
    Host,
    /// The camera's own, ns since its start.
    Device,
    /// The simulated head's, ns since its first frame.
    Simulated,
    /// The column `t_ns` of a table of frames.
    Table,
}

impl Clock {
    const ALL: [Self; 4] = [Self::Host, Self::Device, Self::Simulated, Self::Table];

    /// Its word in outputs and recordings.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Host => "host",
            Self::Device => "device",
            Self::Simulated => "simulation",
            Self::Table => "frames.csv",
        }
    }

    /// The clock of a word.
    pub(crate) fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|clock| clock.word() == word)
    }
}

/// A time on a named clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Timestamp {
    /// Time, ns.
    pub t_ns: u64,
    /// The clock.
    pub clock: Clock,
}

/// How a value of a frame became known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Provenance {
    /// Latched by the device and delivered with the frame (GenICam chunk data).
    Chunk,
    /// Read from the device's register before it began to acquire.
    Register,
    /// From the number of triggers since a reference.
    TriggerCount,
    /// Between two latched samples.
    Interpolated,
    /// From the simulation's own state.
    Simulated,
    /// From a file or the command line.
    Stated,
}

impl Provenance {
    const ALL: [Self; 6] =
        [Self::Chunk, Self::Register, Self::TriggerCount, Self::Interpolated, Self::Simulated, Self::Stated];

    /// Its word in outputs and recordings.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Chunk => "chunk",
            Self::Register => "register",
            Self::TriggerCount => "trigger_count",
            Self::Interpolated => "interpolated",
            Self::Simulated => "simulated",
            Self::Stated => "stated",
        }
    }

    /// The provenance of a word.
    pub(crate) fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|provenance| provenance.word() == word)
    }
}

/// A value with its provenance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Known<T> {
    /// The value.
    pub value: T,
    /// How it became known.
    pub provenance: Provenance,
}

impl<T> Known<T> {
    /// A value from a file or the command line.
    pub(crate) fn stated(value: T) -> Self {
        Self { value, provenance: Provenance::Stated }
    }

    /// A value of the simulation.
    pub(crate) fn simulated(value: T) -> Self {
        Self { value, provenance: Provenance::Simulated }
    }
}

/// Metadata of a live frame; `None` where the source does not give it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LiveMeta {
    /// Sequence number of 64 bits, without the wraps of the device's ids.
    pub sequence: u64,
    /// Start of exposure.
    pub device_t: Option<Timestamp>,
    /// Start of exposure on this machine's clock, by the map of the device's.
    pub exposed_t: Option<Timestamp>,
    /// When this machine had the whole frame.
    pub host_t: Option<Timestamp>,
    /// Exposure time, µs.
    pub exposure_us: Option<Known<f64>>,
    /// Gain, dB.
    pub gain_db: Option<Known<f64>>,
    /// Spindle angle, degrees.
    pub angle_deg: Option<Known<f64>>,
    /// Standard uncertainty of an angle that was moved or interpolated, degrees, by the change of
    /// speed and, of an encoder beside the frames, its resolution; `None` where it is not known.
    pub u_angle_deg: Option<f64>,
    /// Machine z of the image's central column, mm.
    pub z_mm: Option<Known<f64>>,
    /// Temperature of the head, °C, by its own sensor.
    pub head_c: Option<Known<f64>>,
}
