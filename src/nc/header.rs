//! The comments at the head of a program: points that the operator must check before the start.

use super::dialect::{Dialect, number};
use super::machine::{Centre, Direction, Spindle, Tailstock};
use super::probe::CORRECTION;
use super::probe_settings::NcProbe;
use super::sinumerik::{self, RAN_LAST};
use super::skeleton::Skeleton;
use super::surroundings::assumed_centre;

/// Longest comment, so that a line stays below 80 characters.
const LONGEST: usize = 72;

fn mm(value: f64) -> String {
    let text = number(value, 3);
    text.strip_suffix('.').map(str::to_owned).unwrap_or(text)
}

impl Skeleton<'_> {
    /// First lines, with the head.
    pub(super) fn head(&self, title: &str, about: &[String], smallest_mm: f64) -> Vec<String> {
        let mut texts = about.to_vec();
        texts.extend(self.setup());
        texts.extend(self.extent());
        texts.extend(self.judged());
        texts.extend(self.assumed(smallest_mm, true));
        self.framed(title, texts)
    }

    /// First lines of a program that cuts nothing; `raised_mm` is its least diameter.
    pub(super) fn head_of_air(&self, title: &str, about: &[String], raised_mm: f64) -> Vec<String> {
        let mut texts = about.to_vec();
        texts.extend(self.setup());
        texts.extend(self.assumed(raised_mm, true));
        self.framed(title, texts)
    }

    /// First lines of a program that moves the probe alone.
    pub(super) fn head_of_probe(&self, title: &str, about: &[String]) -> Vec<String> {
        let mut texts = about.to_vec();
        texts.extend(self.change_position(false));
        texts.extend(self.settings.probe.iter().flat_map(|probe| self.probed_with(probe, true)));
        texts.extend(self.assumed(self.piece.before_mm, false));
        self.framed(title, texts)
    }

    pub(super) fn framed(&self, title: &str, mut texts: Vec<String>) -> Vec<String> {
        let d = self.dialect;
        if d == Dialect::Sinumerik {
            texts.push(format!(
                "zero offset G54, {} belongs to these programs alone",
                sinumerik::variable(RAN_LAST)
            ));
        }
        if d.changes_at_reference() {
            texts.push("not verified on a control: run dry above the part first".to_owned());
        }
        let mut lines = d.start(self.settings.program, title);
        let preparatory = lines.pop();
        lines.extend(texts.iter().flat_map(|t| wrapped(t)).map(|t| d.comment(&t)));
        lines.extend(preparatory);
        lines
    }

    /// Zero point, tool, change position, start.
    fn setup(&self) -> Vec<String> {
        let (s, route) = (self.settings, &self.route);
        let leading = match self.piece.direction {
            Direction::TowardsChuck => "chuck",
            Direction::TowardsTailstock => "tailstock",
        };
        let spindle = match s.spindle {
            Some(Spindle::M04) => "M04",
            _ => "M03",
        };
        let mut texts = vec![
            format!(
                "X is a diameter, Z 0 the face that clamps the part, its end Z {}",
                mm(self.piece.length_mm)
            ),
            format!("tool {} nose r {}, spindle {spindle}", s.tool, mm(route.nose_mm)),
            format!("tool Z is set at the side of the nose towards the {leading}"),
        ];
        texts.extend(self.change_position(false));
        if let Some(taken) = s.wear_x.filter(|_| s.uses_wear_register(self.dialect)) {
            let taken = if taken.diameter_per_unit() > 1.0 { "radius" } else { "diameter" };
            texts.push(format!("wear offset {} is written here, X in {taken}", s.wear_offset));
        }
        texts
    }

    /// The change position, and which axis goes there first: out of a bore Z.
    pub(super) fn change_position(&self, of_bore: bool) -> [String; 2] {
        let (first, then) = if of_bore { ('Z', 'X') } else { ('X', 'Z') };
        let change = self.route.change;
        let change = format!("X {} Z {}", mm(change.x_mm), mm(change.z_mm));
        if self.dialect.changes_at_reference() {
            [
                format!("change position: {}, at or beyond {change}", self.dialect.reference_words()),
                format!("start: anywhere clear, first {first} then {then} goes to the reference point"),
            ]
        } else {
            [
                format!("change position: {change}"),
                format!("start: anywhere clear, offset of the tool in use active, {first} goes first"),
            ]
        }
    }

    /// The probe, and how the spindle is held under it, at its angle and, where asked for, at the
    /// opposite one as well.
    fn probed_with(&self, probe: &NcProbe, both: bool) -> [String; 2] {
        let correction = if probe.stored_correction {
            format!("{CORRECTION} of its qualification")
        } else {
            number(probe.correction_mm, 5)
        };
        let about = format!(
            "probe: tool {}, ball {}, read less {correction} is the diameter, U {}",
            probe.tool,
            mm(probe.ball_mm),
            number(probe.expanded_u_mm, 4)
        );
        let held = match self.settings.spindle_orientation {
            Some(held) => {
                let opposite = if both { format!(" and {}", mm(held.angle(true))) } else { String::new() };
                let (angle, code) = (mm(held.angle(false)), held.m_code);
                format!("the spindle is held at {angle}{opposite} deg by M{code:02} while the probe touches")
            }
            None => "the angle of the spindle is not fixed while the probe touches: run-out and lobes are part of U"
                .to_owned(),
        };
        [about, held]
    }

    /// The extent of the cut, and what stays uncut.
    fn extent(&self) -> Vec<String> {
        let (s, route) = (self.settings, &self.route);
        let cut = format!("cuts in feed from Z {} to Z {}", mm(route.z_first), mm(route.z_last));
        let (least, full) = (mm(s.least_z_mm), mm(route.full_from_mm));
        vec![cut, format!("stays uncut: Z 0 to {least}, nose fillet to Z {full}")]
    }

    /// Whether the part is measured after this cut, and against which limits.
    fn judged(&self) -> Vec<String> {
        let s = self.settings;
        let mut texts = Vec::new();
        if let Some(probe) = s.probe.filter(|_| self.probes()) {
            texts.extend(self.probed_with(&probe, false));
        }
        let range = |(low, high): (f64, f64)| format!("{} to {}", number(low, 4), number(high, 4));
        match (self.limits_mm, self.piece.tolerance_mm) {
            (Some(limits), _) => {
                if let Some(m) = s.remeasure {
                    texts.push(format!(
                        "measures again by M{:02}: alarm outside {}",
                        m.m_code,
                        range(limits)
                    ));
                }
                if let Some(proven) = s.probe.and_then(|p| Self::proven_limits(&p, limits).ok()) {
                    texts.push(format!(
                        "probes again: alarm outside {}, the tolerance {} less U",
                        range(proven),
                        range(limits)
                    ));
                }
                if s.remeasure.is_none() && s.probe.is_none() {
                    texts.push(format!(
                        "does not measure again: whether the part lies in {} is not checked here, nc.remeasure and \
                         nc.probe are not stated",
                        range(limits)
                    ));
                }
            }
            (None, Some(limits)) if self.measures_first => texts.push(format!(
                "probes again without an alarm: the tolerance {} belongs to the last pass",
                range(limits)
            )),
            (None, Some(limits)) => texts.push(format!(
                "does not measure again: the tolerance {} belongs to the last pass",
                range(limits)
            )),
            (None, None) => {}
        }
        texts
    }

    /// Assumptions in place of data that the machine's table lacks.
    pub(super) fn assumed(&self, smallest_mm: f64, cuts: bool) -> Vec<String> {
        let s = self.settings;
        let mut texts = Vec::new();
        let mut not_stated = |is: bool, text: String| {
            if !is {
                texts.push(format!("not stated: {text}"));
            }
        };
        not_stated(s.change_position.is_some(), "change position, the place above is assumed".into());
        not_stated(
            !cuts || s.nose_radius_mm.is_some(),
            format!("nose radius, {} assumed", mm(self.route.nose_mm)),
        );
        let has_body = s.holder.is_some() || s.boring_bar.is_some();
        not_stated(!cuts || has_body, "tool holder, only the nose was checked".into());
        not_stated(s.chuck.is_some(), "chuck and jaws, nothing moves behind Z 0".into());
        let c: Centre = assumed_centre(self.piece, smallest_mm);
        let centre = format!(
            "tailstock, a centre of 60 deg is assumed, {} wide in the end face, growing to {}",
            mm(c.hole_mm.floor()),
            mm(c.body_mm)
        );
        not_stated(s.tailstock.is_some(), centre);
        let rests = match self.piece.steady_z_mm[..] {
            [] => "steady rests, none assumed".to_owned(),
            _ => "steady rests, those of the run are assumed".to_owned(),
        };
        not_stated(s.steady_rests.is_some(), rests);
        let park = "gauge head, park it away from part and tool";
        not_stated(s.gauge_head.is_some(), park.into());
        not_stated(s.travel.is_some(), "travel limits, not checked".into());
        if s.tailstock == Some(Tailstock::Absent) {
            texts.push("no tailstock: the room beyond the end face must be free".into());
        }
        texts
    }

    /// One sentence on what stays uncut, for a log.
    pub(super) fn uncut(&self) -> String {
        let (s, route) = (self.settings, &self.route);
        format!(
            "uncut: Z 0 to {} mm at the chuck (nc.least_z_mm), with the nose's fillet to Z {} mm",
            mm(s.least_z_mm),
            mm(route.full_from_mm)
        )
    }
}

/// A text in pieces that fit into comments.
fn wrapped(text: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().filter(|l| l.is_empty() || l.len() + 1 + word.len() <= LONGEST);
        match line {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) => {
                line.push(' ');
                line.push_str(word);
            }
            None => lines.push(word.to_owned()),
        }
    }
    lines
}
