//! Tip directions: where the gauge point of a tool lies beside the centre of its register circle.
//!
//! Signs (σx, σz) and the numbers of the controls:
//!
//! | (σx, σz) | ++ | +− | −− | −+ | 0+ | +0 | 0− | −0 | 00 |
//! |---|---|---|---|---|---|---|---|---|---|
//! | Fanuc, GSK, rear turret | 1 | 2 | 3 | 4 | 5 | 6 | 7 | 8 | 0, 9 |
//! | LinuxCNC | 4 | 3 | 2 | 1 | 5 | 8 | 7 | 6 | 0, 9 |

/// Whose numbers of tip directions are meant.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Numbering {
    /// Fanuc and GSK with a rear turret.
    #[default]
    Fanuc,
    /// LinuxCNC.
    Linuxcnc,
}

/// Where the gauge point lies: centre + R·(σx, σz).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TipDirection {
    /// Sign along X: −1 towards the axis, 1 away from it, 0 at the centre.
    pub x: i8,
    /// Sign along Z: −1 towards the chuck, 1 towards the tailstock, 0 at the centre.
    pub z: i8,
}

/// Signs by Fanuc's numbers 0 to 9.
const FANUC: [(i8, i8); 10] =
    [(0, 0), (1, 1), (1, -1), (-1, -1), (-1, 1), (0, 1), (1, 0), (0, -1), (-1, 0), (0, 0)];
/// Signs by LinuxCNC's numbers 0 to 9.
const LINUXCNC: [(i8, i8); 10] =
    [(0, 0), (-1, 1), (-1, -1), (1, -1), (1, 1), (0, 1), (-1, 0), (0, -1), (1, 0), (0, 0)];

impl TipDirection {
    /// The direction of a number; `None` above 9.
    pub(crate) fn of(number: u8, numbering: Numbering) -> Option<Self> {
        let table = match numbering {
            Numbering::Fanuc => &FANUC,
            Numbering::Linuxcnc => &LINUXCNC,
        };
        table.get(usize::from(number)).map(|&(x, z)| Self { x, z })
    }

    /// Its number, the smaller one of two.
    pub(crate) fn number(self, numbering: Numbering) -> u8 {
        let is = |n: &u8| Self::of(*n, numbering) == Some(self);
        (0..10).find(is).unwrap_or_default()
    }

    /// The signs as factors.
    pub(crate) fn signs(self) -> (f64, f64) {
        (f64::from(self.x), f64::from(self.z))
    }
}
