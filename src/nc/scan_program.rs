//! A program that takes the gauge head along the finished part and triggers it at every stop.
//!
//! ```text
//! retract (X, then Z), tool called for its offset, coolant off, air blast, pause
//! measuring speed, or spindle off          shutter open
//! per field: carriage to Z = field - head, per angle: oriented stop, settle, count, trigger, wait
//!            alarm where the count is not the plan's
//! shutter closed, spindle off, retract
//! ```
//!
//! With a measuring speed a stop is a field, and its trigger starts all frames of it; without one
//! a stop is an angle of a field. Stops are numbered from 1 in the order of the program, in
//! `#838` (`R97`): a program that is started in the middle counts wrong and ends in an alarm.
//! Column `stop` of `frames.csv` holds the number, so that a missing or doubled frame is found and
//! never shifts the others.

use super::dialect::{Dialect, number};
use super::error::NcError;
use super::machine::{Spindle, SpindleOrientation};
use super::replay::{self, CommandedScan, CommandedStop, Convex, SpindleState, WorkingSpace};
use super::route::{Route, Workpiece, round3};
use super::scan_settings::NcScan;
use super::settings::NcSettings;
use super::sinumerik::{self, STOP};
use super::skeleton::Skeleton;
use super::turning::Written;
use crate::plan::{CuttingData, ScanPlan};

/// First label of the alarms, one a field.
const LABEL: u32 = 201;
/// Most fields: their labels stay below the four digits of N.
const MOST_FIELDS: usize = 1000;
/// A radius beyond all dimensions of a lathe, mm.
const FAR_MM: f64 = 1e4;

/// A scan to be written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScanProgram<'a> {
    /// Fields and angles.
    pub plan: &'a ScanPlan,
    /// Machine, with its `scan` table.
    pub settings: &'a NcSettings,
    /// The part before the pass: no smaller than the one that is scanned.
    pub piece: &'a Workpiece,
    /// Number of the pass after which the part is scanned.
    pub pass: u32,
}

/// A stop of the program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stop {
    /// Its number, from 1.
    pub stop: u32,
    /// Machine z of the middle of the field, mm.
    pub z_mm: f64,
    /// Angle at which the spindle is held, degrees of the scan plan; none where it turns.
    pub angle_deg: Option<f64>,
}

/// Table of stops, as CSV: `stop,z_mm,angle_deg`.
pub(crate) fn stop_list(stops: &[Stop]) -> String {
    let row = |s: &Stop| {
        let angle = s.angle_deg.map_or_else(String::new, |a| a.to_string());
        format!("{},{},{angle}\n", s.stop, s.z_mm)
    };
    std::iter::once("stop,z_mm,angle_deg\n".to_owned()).chain(stops.iter().map(row)).collect()
}

/// The scan table, and how the spindle is held where it does not turn.
#[derive(Clone, Copy)]
struct Prepared {
    scan: NcScan,
    held: Option<SpindleOrientation>,
}

impl<'a> ScanProgram<'a> {
    /// The stops, in the order of the program.
    ///
    /// # Errors
    /// A machine without the table `scan`, or without a way to hold the spindle.
    pub(crate) fn stops(&self) -> Result<Vec<Stop>, NcError> {
        let Prepared { held, .. } = self.prepare()?;
        let angles: Vec<Option<f64>> = match held {
            Some(_) => self.plan.angle_deg.iter().copied().map(Some).collect(),
            None => vec![None],
        };
        let places =
            self.plan.field_z_mm.iter().flat_map(|z| angles.iter().map(move |angle_deg| (*z, *angle_deg)));
        Ok(places.zip(1..).map(|((z_mm, angle_deg), stop)| Stop { stop, z_mm, angle_deg }).collect())
    }

    /// The program's text and its stops, replayed from every start position that is clear for tool
    /// and head.
    ///
    /// # Errors
    /// Machine data that are missing, a head that cannot pass, a block that is refused.
    pub(crate) fn write(&self, dialect: Dialect) -> Result<Written<Vec<Stop>>, NcError> {
        let prepared = self.prepare()?;
        let stops = self.stops()?;
        let skeleton = self.skeleton(dialect, &prepared)?;
        let text = self.text(&skeleton, &prepared, &stops);
        replay::check(&text, &self.working_space_of(&skeleton, &prepared, &stops))?;
        let uncut = format!("scans the part: {} stops, nothing is cut", stops.len());
        Ok(Written { text, cut: stops, uncut })
    }

    /// The working space for a replay.
    ///
    /// # Errors
    /// As [`Self::write`], but for the replay.
    #[cfg(test)]
    pub(crate) fn working_space(&self, dialect: Dialect) -> Result<WorkingSpace<'a>, NcError> {
        let prepared = self.prepare()?;
        let skeleton = self.skeleton(dialect, &prepared)?;
        Ok(self.working_space_of(&skeleton, &prepared, &self.stops()?))
    }

    fn prepare(&self) -> Result<Prepared, NcError> {
        self.settings.validate()?;
        let Some(scan) = self.settings.scan else {
            return Err(NcError::Plan(
                "a scan program needs the scan table of the machine's data: nc.scan (head_z_mm, trigger, head)".into(),
            ));
        };
        let held = match (scan.speed_per_min, self.settings.spindle_orientation) {
            (Some(_), _) => None,
            (None, Some(orientation)) => Some(orientation),
            (None, None) => {
                return Err(NcError::Plan(
                    "a scan needs nc.scan.speed_per_min (the part turns) or nc.spindle_orientation (it is held at every angle)"
                        .into(),
                ));
            }
        };
        let fields = self.plan.field_z_mm.len();
        if fields == 0 || fields > MOST_FIELDS || self.plan.angle_deg.is_empty() {
            return Err(NcError::Plan(format!(
                "{fields} fields and {} angles; a scan program has 1 to {MOST_FIELDS} fields and an angle or more",
                self.plan.angle_deg.len()
            )));
        }
        Ok(Prepared { scan, held })
    }

    fn skeleton(&self, dialect: Dialect, prepared: &Prepared) -> Result<Skeleton<'a>, NcError> {
        self.settings.check_stated(dialect)?;
        prepared.scan.check_codes(dialect)?;
        self.piece.check(self.piece.before_mm)?;
        Ok(Skeleton {
            dialect,
            settings: self.settings,
            piece: self.piece,
            route: Route::new(self.piece, self.settings)?,
            // nothing is cut
            cutting: CuttingData { speed_m_per_min: 1.0, feed_mm_per_rev: 0.1 },
            pass: self.pass,
            wear_mm: 0.0,
            limits_mm: None,
            measures_first: false,
        })
    }

    fn working_space_of(
        &self,
        skeleton: &Skeleton<'a>,
        prepared: &Prepared,
        stops: &[Stop],
    ) -> WorkingSpace<'a> {
        let scan = &prepared.scan;
        let mut space = skeleton.working_space(vec![(0.0, self.piece.before_mm)]);
        // any feed is a fault, and no length must be covered
        space.cut = Default::default();
        // the head is the one that moves
        space.solids.retain(|solid| solid.what != super::surroundings::PARKED_HEAD);
        let (from, to) = (-scan.head.towards_chuck_mm, scan.head.towards_tailstock_mm);
        let opening = 0.5 * scan.head.opening_mm;
        let head = [(from, opening), (to, opening), (to, FAR_MM), (from, FAR_MM)];
        space.head = vec![Convex::hull(head.map(|(z, r)| (z + scan.head_z_mm, r)).to_vec())];
        let stop = |s: &Stop| CommandedStop {
            z_mm: self.carriage_mm(scan, s.z_mm),
            spindle: match (prepared.held, s.angle_deg) {
                (Some(held), Some(angle)) => SpindleState::Held(spindle_deg(held, angle)),
                _ => SpindleState::Turning(scan.speed_per_min.unwrap_or_default()),
            },
        };
        let stops = stops.iter().map(stop).collect();
        space.scan = Some(CommandedScan { x_mm: skeleton.route.change.x_mm, stops });
        space
    }

    /// Z of the programmed point for a field, mm.
    fn carriage_mm(&self, scan: &NcScan, field_z_mm: f64) -> f64 {
        round3(field_z_mm - scan.head_z_mm)
    }

    fn text(&self, skeleton: &Skeleton<'_>, prepared: &Prepared, stops: &[Stop]) -> String {
        let mut lines = self.head(skeleton, prepared, stops);
        lines.extend(self.prepares(skeleton, prepared));
        let each = stops.len() / self.plan.field_z_mm.len();
        for ((field, of_field), label) in self.plan.field_z_mm.iter().zip(stops.chunks(each)).zip(LABEL..) {
            let z = number(self.carriage_mm(&prepared.scan, *field), 3);
            lines.push(format!("G00 {}", skeleton.dialect.axis('Z', &z)));
            for stop in of_field {
                lines.extend(stop_blocks(skeleton.dialect, prepared, stop));
            }
            let counted = of_field.last().map_or(0, |last| last.stop);
            let counted = number(f64::from(counted), 0);
            let count = format!("#{STOP}");
            lines.extend(skeleton.dialect.alarm_if(label, (&count, "NE", &counted), "STOPS ARE MISCOUNTED"));
        }
        lines.extend(self.ends(skeleton, prepared));
        lines.join("\n") + "\n"
    }

    /// Retracts, dries the part, brings the spindle to its speed or to a stop, opens the shutter.
    fn prepares(&self, skeleton: &Skeleton<'_>, prepared: &Prepared) -> Vec<String> {
        let (d, s, scan) = (skeleton.dialect, self.settings, &prepared.scan);
        let change = skeleton.route.change;
        let mut lines = d.to_change(change);
        lines.extend(d.tool(s.tool, s.tool));
        if !d.changes_at_reference() {
            // the offset of the tool just called acts from here on
            lines.push(format!("G00 X{}", number(change.x_mm, 3)));
        }
        lines.push(scan.coolant_off.to_string());
        lines.push(match scan.speed_per_min {
            Some(speed) => d.constant_speed(speed, s.spindle.unwrap_or(Spindle::M03)),
            None => d.spindle_off().to_owned(),
        });
        if let (Some(on), Some(off)) = (scan.air_on, scan.air_off) {
            lines.extend([on.to_string(), d.dwell(scan.air_s), off.to_string()]);
        }
        lines.push(d.dwell(scan.dwell_s));
        lines.extend(d.assign(STOP, "0."));
        lines.extend(scan.shutter_open.map(|code| code.to_string()));
        lines
    }

    fn ends(&self, skeleton: &Skeleton<'_>, prepared: &Prepared) -> Vec<String> {
        let d = skeleton.dialect;
        let mut lines: Vec<String> = prepared.scan.shutter_close.iter().map(ToString::to_string).collect();
        lines.push(d.spindle_off().to_owned());
        lines.extend(d.to_change(skeleton.route.change));
        lines.extend(skeleton.release_spindle().into_iter().filter(|_| prepared.held.is_some()));
        lines.extend(d.end());
        lines
    }

    fn head(&self, skeleton: &Skeleton<'_>, prepared: &Prepared, stops: &[Stop]) -> Vec<String> {
        let (scan, d) = (&prepared.scan, skeleton.dialect);
        let count = match d {
            Dialect::Sinumerik => sinumerik::variable(STOP),
            _ => STOP.to_string(),
        };
        let (fields, angles) = (self.plan.field_z_mm.len(), self.plan.angle_deg.len());
        let spindle = match (prepared.held, scan.speed_per_min) {
            (Some(_), _) => format!("{fields} fields, at each the spindle is held at {angles} angles"),
            (None, speed) => format!(
                "{fields} fields, at each {angles} frames while the spindle turns at {} 1/min",
                speed.unwrap_or_default().round()
            ),
        };
        let mut texts = vec![
            format!("shadowgauge {} for {}", env!("CARGO_PKG_VERSION"), d.as_str()),
            spindle,
            format!("{} stops, counted in {count}; column stop of frames.csv", stops.len()),
            format!(
                "middle of the field at Z of tool {} plus {}, opening {}",
                self.settings.tool,
                number(scan.head_z_mm, 3),
                number(scan.head.opening_mm, 3)
            ),
            format!("trigger {}: must end after the frame, or within {} s", scan.trigger, scan.frame_s),
        ];
        if scan.air_on.is_none() {
            texts.push("no air blast is stated: the part must be dry".to_owned());
        }
        texts.extend(skeleton.change_position(false));
        let parked = |text: &String| !text.contains("gauge head");
        texts.extend(skeleton.assumed(self.piece.before_mm, false).into_iter().filter(parked));
        let title = format!("PART {} SCAN AFTER PASS {}", self.settings.part_number, self.pass);
        skeleton.framed(&title, texts)
    }
}

/// Angle of the spindle for an angle of the scan, degrees.
fn spindle_deg(held: SpindleOrientation, scan_deg: f64) -> f64 {
    round3((held.angle_deg + scan_deg).rem_euclid(360.0)) % 360.0
}

/// Oriented stop, pause, count, trigger, and the time of the frames.
fn stop_blocks(d: Dialect, prepared: &Prepared, stop: &Stop) -> Vec<String> {
    let scan = &prepared.scan;
    let mut lines = Vec::new();
    if let (Some(held), Some(angle)) = (prepared.held, stop.angle_deg) {
        lines.push(d.orient_to(held, spindle_deg(held, angle)));
    }
    lines.push(d.dwell(scan.settle_s));
    lines.extend(d.count(STOP));
    lines.push(scan.trigger.to_string());
    lines.push(d.dwell(replay::frames_s(scan)));
    lines.extend(scan.trigger_off.map(|code| code.to_string()));
    lines
}
