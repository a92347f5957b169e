//! A lathe with its errors in the state of a run: what it does to the tool's path.
//!
//! The tool is set towards the axis (X falls) and travels with the feed. A turn of the spindle
//! passes while the tool advances by its feed, so that the mean diameter has the mean of the
//! spindle's errors over a turn; their undulations become lobes of the part. The poses are those of
//! the exact chain; what the first order gives stands beside them in [`super::contribution`].

use super::turn_harmonics::{ANGLES, Undulation, angles_deg, undulations};
use crate::machine::conditions::Direction;
use crate::machine::response::{Part, cut_mm};
use crate::machine::settings::key_of;
use crate::machine::{Chain, Conditions, ErrorName, ErrorValues, MachineSettings, Motion, Pose, Station};
use crate::process::{PathDisplacement, PathPlace};
use crate::setting::SettingError;
use crate::shaft::Lobe;

/// The errors of C in [`ErrorName::ALL`].
const OF_C: std::ops::Range<usize> = 12..18;

/// Directions in which Z reaches its positions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ways {
    /// While the part is cut.
    pub cut: Direction,
    /// While it is looked at.
    pub scan: Direction,
}

/// A state of the machine, and the errors of C in it over a turn.
#[derive(Clone, Debug)]
struct State {
    conditions: Conditions,
    /// Means over a turn, mm and rad.
    mean: [f64; 6],
    /// Values at [`angles_deg`]; empty where they do not change over a turn.
    turn: Vec<[f64; 6]>,
}

impl State {
    fn new(motion: &Motion, conditions: Conditions) -> Self {
        let at = |c_deg: f64| {
            let state = Conditions { c_deg, ..conditions };
            let value = |k: usize| motion.value(ErrorName::ALL[OF_C.start + k], [0.0; 2], &state);
            std::array::from_fn::<f64, 6, _>(value)
        };
        let turn: Vec<[f64; 6]> = angles_deg().map(at).collect();
        let mean = std::array::from_fn(|k| turn.iter().map(|v| v[k]).sum::<f64>() / ANGLES as f64);
        let is_still = turn.iter().all(|v| *v == turn[0]);
        Self {
            conditions,
            mean: if is_still { turn[0] } else { mean },
            turn: if is_still { Vec::new() } else { turn },
        }
    }
}

/// A lathe in the state of a run.
#[derive(Clone, Debug)]
pub(crate) struct Lathe {
    settings: MachineSettings,
    motion: Motion,
    /// While the part is cut.
    cutting: State,
    /// While it is looked at.
    scanning: State,
    /// The machine as the control's own table has it; none where it does not compensate.
    table: Option<Box<Lathe>>,
}

impl Lathe {
    /// A lathe by its settings and their functions, in a state.
    ///
    /// # Errors
    /// Undulations of the spindle that are finer than the angles at which they are taken.
    pub(super) fn new(
        settings: &MachineSettings,
        motion: Motion,
        state: &Conditions,
        ways: Ways,
    ) -> Result<Self, SettingError> {
        check_orders(&motion)?;
        let set = |z_direction| Conditions { x_direction: Direction::Backward, z_direction, ..*state };
        Ok(Self {
            cutting: State::new(&motion, set(ways.cut)),
            scanning: State::new(&motion, set(ways.scan)),
            table: None,
            settings: settings.clone(),
            motion,
        })
    }

    /// The same with a control that compensates by a table of its own.
    #[must_use]
    pub(super) fn compensated_by(self, table: Self) -> Self {
        Self { table: Some(Box::new(table)), ..self }
    }

    /// The machine's chain, levers and travels.
    pub(super) fn settings(&self) -> &MachineSettings {
        &self.settings
    }

    /// Whether the spindle has error motion that changes over a turn.
    pub(crate) fn spindle_errs(&self) -> bool {
        !self.cutting.turn.is_empty()
    }

    /// The values of all errors at a station, those of C as given.
    fn values(&self, station: &Station, state: &State, of_c: &[f64; 6]) -> ErrorValues {
        let mut values = self.motion.values(station.x_mm, station.z_mm, &state.conditions);
        values.0[OF_C].copy_from_slice(of_c);
        values
    }

    /// The exact pose of what stands at a station.
    fn pose(&self, station: &Station, values: ErrorValues) -> Pose {
        Chain { topology: self.settings.chain, values }.pose(station)
    }

    /// The tool at a place of its path.
    pub(super) fn at_tool(&self, place: &PathPlace) -> Station {
        self.settings.tool(0.5 * place.diameter_mm, place.z_mm)
    }

    /// The pose of the tool while it cuts, and the values behind it.
    pub(super) fn tool_pose(&self, station: &Station) -> (Pose, ErrorValues) {
        let values = self.values(station, &self.cutting, &self.cutting.mean);
        (self.pose(station, values), values)
    }

    /// The mean pose over a turn of what stands at a station while the part is looked at.
    pub(super) fn scan_pose(&self, station: &Station) -> Pose {
        self.pose(station, self.values(station, &self.scanning, &self.scanning.mean))
    }

    /// The mean pose of the head over a turn, with Z where it sees the field at `field_z_mm`.
    pub(super) fn head_pose(&self, field_z_mm: f64) -> Pose {
        self.scan_pose(&self.at_head(field_z_mm))
    }

    /// The poses of the head at the angles of a turn; none where the spindle runs true.
    pub(super) fn head_poses(&self, field_z_mm: f64) -> Vec<Pose> {
        let station = self.at_head(field_z_mm);
        let pose = |of_c: &[f64; 6]| self.pose(&station, self.values(&station, &self.scanning, of_c));
        self.scanning.turn.iter().map(pose).collect()
    }

    fn at_head(&self, field_z_mm: f64) -> Station {
        self.settings.head(field_z_mm - self.settings.head_beside_tool_mm())
    }

    /// Change of the diameter that is cut in a state, mm.
    fn cut_in(&self, place: &PathPlace, state: &State, of_c: &[f64; 6]) -> f64 {
        let station = self.at_tool(place);
        let pose = self.pose(&station, self.values(&station, state, of_c));
        cut_mm(&part(place), self.settings.tip_above_axis_mm, &pose)
    }

    /// Lobes that the spindle's errors leave on every part, those of a place of the part (along z
    /// tilt errors change them, which is left out).
    pub(crate) fn lobes(&self, place: &PathPlace) -> Vec<Lobe> {
        let radius = |of_c: &[f64; 6]| 0.5 * self.cut_in(place, &self.cutting, of_c);
        let radii: Vec<f64> = self.cutting.turn.iter().map(radius).collect();
        // the tool at φ cuts the body's angle −φ
        let lobe = |u: Undulation| Lobe {
            order_upr: u.order,
            amplitude_mm: u.amplitude,
            phase_deg: u.phase_deg / f64::from(u.order),
        };
        undulations(&radii).into_iter().map(lobe).collect()
    }
}

/// The part at a place of the path.
pub(super) fn part(place: &PathPlace) -> Part {
    Part { diameter_mm: place.diameter_mm, taper: place.taper }
}

impl PathDisplacement for Lathe {
    fn cut_mm(&self, place: &PathPlace) -> f64 {
        self.cut_in(place, &self.cutting, &self.cutting.mean)
    }

    fn compensated_mm(&self, place: &PathPlace) -> f64 {
        self.table.as_ref().map_or(0.0, |table| table.cut_mm(place))
    }
}

/// Refuses undulations of the spindle that the angles of a turn do not separate.
fn check_orders(motion: &Motion) -> Result<(), SettingError> {
    let most = ANGLES / 2 - 1;
    for name in &ErrorName::ALL[OF_C] {
        let waves = motion.function(*name).map_or(&[][..], |function| &function.waves[..]);
        if let Some(k) = waves.iter().position(|wave| wave.frequency > most as f64) {
            let key = format!("{}.fourier[{k}].order", key_of(*name).replace("machine.", "machine.stated."));
            return Err(SettingError::of(key, waves[k].frequency, format!("at most {most}")));
        }
    }
    Ok(())
}
