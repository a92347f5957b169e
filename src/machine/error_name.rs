//! The 21 geometric errors of a lathe by their names of ISO 230-1.

/// Number of errors: six of each of X, Z and C, and three orientations.
pub(crate) const COUNT: usize = 21;

/// An axis of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Axis {
    /// The slide that moves radially.
    X,
    /// The slide that moves along the spindle.
    Z,
    /// The spindle.
    C,
}

/// An error: E, then the direction (X, Y, Z along, A, B, C about X, Y, Z), then the axis; or an
/// orientation of an axis, with 0 in the middle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ErrorName {
    Exx,
    Eyx,
    Ezx,
    Eax,
    Ebx,
    Ecx,
    Exz,
    Eyz,
    Ezz,
    Eaz,
    Ebz,
    Ecz,
    Exc,
    Eyc,
    Ezc,
    Eac,
    Ebc,
    Ecc,
    B0x,
    A0c,
    B0c,
}

/// What an error is: a shift along a direction or a turn about it; 0, 1, 2 are X, Y, Z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Component {
    /// A shift, mm.
    Along(usize),
    /// A turn, rad.
    About(usize),
    /// An orientation about a direction, rad.
    Orientation(usize),
}

impl ErrorName {
    /// All errors, in the order of [`ErrorValues`].
    pub(crate) const ALL: [Self; COUNT] = [
        Self::Exx,
        Self::Eyx,
        Self::Ezx,
        Self::Eax,
        Self::Ebx,
        Self::Ecx,
        Self::Exz,
        Self::Eyz,
        Self::Ezz,
        Self::Eaz,
        Self::Ebz,
        Self::Ecz,
        Self::Exc,
        Self::Eyc,
        Self::Ezc,
        Self::Eac,
        Self::Ebc,
        Self::Ecc,
        Self::B0x,
        Self::A0c,
        Self::B0c,
    ];

    /// The name, in capitals.
    pub(crate) fn code(self) -> String {
        format!("{self:?}").to_uppercase()
    }

    /// The axis whose error it is.
    pub(crate) fn axis(self) -> Axis {
        match self as usize {
            0..6 | 18 => Axis::X,
            6..12 => Axis::Z,
            _ => Axis::C,
        }
    }

    /// What it is.
    pub(crate) fn component(self) -> Component {
        match self {
            Self::B0x | Self::B0c => Component::Orientation(1),
            Self::A0c => Component::Orientation(0),
            motion => match motion as usize % 6 {
                along @ 0..3 => Component::Along(along),
                about => Component::About(about - 3),
            },
        }
    }

    /// Whether its value is a length (mm); else it is an angle (rad).
    pub(crate) fn is_length(self) -> bool {
        matches!(self.component(), Component::Along(_))
    }

    /// Its unit in files and results.
    pub(crate) fn unit(self) -> &'static str {
        if self.is_length() { "µm" } else { "µrad" }
    }

    /// What it is, in words of ISO 230-1.
    pub(crate) fn meaning(self) -> String {
        const DIRECTIONS: [char; 3] = ['X', 'Y', 'Z'];
        let axis = format!("{:?}", self.axis());
        let own = match self.axis() {
            Axis::X => 0,
            Axis::Z | Axis::C => 2,
        };
        let is_slide = self.axis() != Axis::C;
        match self.component() {
            Component::Along(k) if is_slide && k == own => format!("positioning of {axis}"),
            Component::Along(k) if is_slide => format!("straightness of {axis} along {}", DIRECTIONS[k]),
            Component::Along(k) if k == own => "axial error motion of C".to_owned(),
            Component::Along(k) => format!("radial error motion of C along {}", DIRECTIONS[k]),
            Component::About(k) if is_slide && k == own => format!("roll of {axis}"),
            Component::About(1) if is_slide => format!("yaw of {axis}"),
            Component::About(_) if is_slide => format!("pitch of {axis}"),
            Component::About(k) if k == own => "angular positioning of C".to_owned(),
            Component::About(k) => format!("tilt error motion of C about {}", DIRECTIONS[k]),
            Component::Orientation(k) => format!("orientation of {axis} about {}", DIRECTIONS[k]),
        }
    }
}

/// A value of every error: mm along, rad about.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ErrorValues(pub(crate) [f64; COUNT]);

impl ErrorValues {
    /// One error alone.
    pub(crate) fn only(name: ErrorName, value: f64) -> Self {
        let mut values = Self::default();
        values.0[name as usize] = value;
        values
    }

    /// The value of an error, mm or rad.
    pub(crate) fn of(&self, name: ErrorName) -> f64 {
        self.0[name as usize]
    }

    /// The shifts along X, Y, Z of an axis, mm.
    pub(crate) fn along(&self, axis: Axis) -> [f64; 3] {
        let first = 6 * axis as usize;
        [self.0[first], self.0[first + 1], self.0[first + 2]]
    }

    /// The turns about X, Y, Z of an axis, rad.
    pub(crate) fn about(&self, axis: Axis) -> [f64; 3] {
        let first = 6 * axis as usize + 3;
        [self.0[first], self.0[first + 1], self.0[first + 2]]
    }
}
