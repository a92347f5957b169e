//! What a program does, block by block: moves, touches, changes of tool, alarms.

/// Position of the programmed point: X mm of diameter, Z mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// X, mm of diameter.
    pub x: f64,
    /// Z, mm.
    pub z: f64,
}

/// An action of a block.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Deed {
    /// A straight move.
    Move {
        /// Where it begins.
        from: Point,
        /// Where it ends.
        to: Point,
        /// In rapid, not in feed.
        rapid: bool,
    },
    /// Tool or offset are changed here.
    ToolChange(Point),
    /// The part is measured.
    Measure(Point),
    /// The probe goes down and touches, or finds nothing.
    Probe {
        /// Where it begins.
        from: Point,
        /// Where it ends.
        to: Point,
        /// Where it would have ended without a touch.
        target: Point,
        /// Angle at which the spindle is held, degrees.
        angle_deg: Option<f64>,
    },
    /// The gauge head is triggered.
    Trigger(Trigger),
    /// The program stops with an alarm.
    Alarm(String),
}

/// A trigger of the gauge head.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Trigger {
    /// Where the programmed point stands.
    pub at: Point,
    /// Number of the stop that the program has counted.
    pub stop: u32,
    /// What the spindle does.
    pub spindle: SpindleState,
}

/// What the spindle does while a frame is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SpindleState {
    /// Held at an angle, degrees.
    Held(f64),
    /// Turning at a constant speed, 1/min.
    Turning(f64),
}

/// An action and the line that performs it, from 1.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Event {
    /// Line, from 1.
    pub block: usize,
    /// The action.
    pub deed: Deed,
    /// Whether the probe, not the turning tool, is in the carrier.
    pub with_probe: bool,
}

/// Where a program is refused: line from 1, and why.
pub(crate) type Fault = (usize, String);
