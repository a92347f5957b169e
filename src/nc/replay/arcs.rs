//! Arcs and nose radius compensation of a replay: both become straight moves.
//!
//! An arc by R (`CR=` of a SINUMERIK, whose I and K are read too) is the shorter one, clockwise for
//! G02 as seen with Z to the right and X up; `nose` has what G41 and G42 make of a contour.

use glam::DVec2;

use super::event::Point;
use super::interpreter::{Interpreter, Motion, Words};
use super::nose::Compensation;
use crate::nc::dialect::Dialect;
use crate::nose::{Numbering, TipDirection};

/// Largest sagitta of the chords of an arc, mm.
const SAGITTA_MM: f64 = 1e-6;
/// Half of a chord may be longer than R by this, mm: ends and R are rounded to increments.
const ROUNDING_MM: f64 = 0.002;

/// (Z, X as a radius): to the right and up.
fn plane(p: Point) -> DVec2 {
    DVec2::new(p.z, 0.5 * p.x)
}

fn point(v: DVec2) -> Point {
    Point { x: 2.0 * v.y, z: v.x }
}

impl Interpreter<'_> {
    /// G10 P R Q: a nose radius, and with P above 10000 the tip direction, of an offset.
    pub(super) fn write_nose(&mut self, words: &Words) -> Result<(), String> {
        if self.control.dialect != Dialect::Fanuc {
            return Err("G10 with R is a Fanuc's".into());
        }
        let (number, radius) = (words.get('P').unwrap_or_default(), words.get('R').unwrap_or(-1.0));
        if words.get('X').or(words.get('Z')).is_some() || radius < 0.0 {
            return Err("G10 with R takes P, R of 0 or more and Q alone".into());
        }
        let geometry = number > 10_000.0;
        let offset = (number % 10_000.0) as u32;
        if !(1..=99).contains(&offset) {
            return Err("G10 needs P of 1 to 99, or 10000 more".into());
        }
        let register = self.nose.registers.entry(offset).or_default();
        match (geometry, words.get('Q')) {
            (true, Some(tip)) => {
                (register.radius, register.tip) = (radius, tip as u8);
                Ok(())
            }
            (false, None) => {
                register.wear = radius;
                Ok(())
            }
            _ => Err("G10 with R needs Q in the geometry, and none in the wear".into()),
        }
    }

    /// G40, G41, G42 and LinuxCNC's G41.1 and G42.1.
    pub(super) fn set_compensation(&mut self, code: u32, words: &Words) -> Result<(), String> {
        if code == 400 {
            if let Some(compensation) = &mut self.nose.compensation {
                compensation.ends = true;
            }
            return Ok(());
        }
        if self.nose.compensation.is_some() {
            return Err("compensation starts while it is on".into());
        }
        let (radius, tip) = match (self.control.dialect, code % 10) {
            (Dialect::Linuxcnc, 1) => {
                let missing = "G41.1 and G42.1 need D, the diameter, and L, the tip direction";
                let (d, l) = (words.get('D').ok_or(missing)?, words.get('L').ok_or(missing)?);
                (0.5 * d, TipDirection::of(l as u8, Numbering::Linuxcnc))
            }
            (Dialect::Sinumerik, 0) if !(self.nose.at_right_angles && self.nose.extends_corners) => {
                return Err(
                    "G41 or G42 before NORM and G451: how it begins and rounds corners is open".into()
                );
            }
            (Dialect::Fanuc | Dialect::Gsk | Dialect::Sinumerik, 0) => {
                let nose = self.nose.registers.get(&self.nose.offset).copied();
                let nose = nose.ok_or("G41 or G42 with a register that is neither written nor stated")?;
                (nose.radius + nose.wear, TipDirection::of(nose.tip, Numbering::Fanuc))
            }
            _ => return Err("this G41 or G42 is not understood".into()),
        };
        let tip = tip.ok_or("a tip direction of 0 to 9 is needed")?;
        let (right, from) = (code / 10 == 42, plane(self.at));
        self.nose.compensation =
            Some(Compensation { right, radius, tip, from, contour: Vec::new(), ends: false });
        Ok(())
    }

    /// A move to `to`, straight or along an arc, compensated where it is on.
    pub(super) fn drive(&mut self, line: usize, to: Point, words: &Words) -> Result<(), String> {
        let motion = self.modal.motion;
        let points = match motion {
            Some(Motion::Arc { clockwise }) => {
                let radius = self.arc_radius(to, words, clockwise)?;
                chords(plane(self.at), plane(to), radius, clockwise)?
            }
            _ => vec![to],
        };
        let rapid = motion == Some(Motion::Rapid);
        let Some(compensation) = &mut self.nose.compensation else {
            points.into_iter().for_each(|p| self.go(line, p, rapid));
            return Ok(());
        };
        if rapid {
            return Err("a rapid while the nose is compensated".into());
        }
        if !compensation.ends {
            if compensation.contour.is_empty() && matches!(motion, Some(Motion::Arc { .. })) {
                return Err("compensation starts on an arc".into());
            }
            compensation.contour.extend(points.into_iter().map(|p| (plane(p), line)));
            self.at = to;
            return Ok(());
        }
        if points.len() > 1 {
            return Err("compensation ends on an arc".into());
        }
        let Some(done) = self.nose.compensation.take() else { return Ok(()) };
        self.at = point(done.from);
        for (at, line) in done.path()? {
            self.go(line, point(at), false);
        }
        self.go(line, to, false);
        Ok(())
    }

    /// The radius of an arc of less than half a turn: as stated, or by its centre from its first
    /// point, I (X as a radius) and K, where the ends are as far from it as each other.
    fn arc_radius(&self, to: Point, words: &Words, clockwise: bool) -> Result<f64, String> {
        let centre = (words.get('I'), words.get('K'));
        let (i, k) = match (words.get('R'), centre) {
            (Some(radius), (None, None)) => return Ok(radius),
            (None, (Some(i), Some(k))) => (i, k),
            _ => return Err("an arc needs R (CR=), or I and K".into()),
        };
        let (from, to) = (plane(self.at), plane(to));
        let centre = from + DVec2::new(k, i);
        let (before, behind) = (from.distance(centre), to.distance(centre));
        if (before - behind).abs() > ROUNDING_MM {
            return Err(format!("the ends of an arc lie {before:.4} and {behind:.4} mm from its centre"));
        }
        let sense = if clockwise { -1.0 } else { 1.0 };
        if (from - centre).perp_dot(to - centre) * sense <= 0.0 {
            return Err("an arc of half a turn or more".into());
        }
        Ok(0.5 * (before + behind))
    }
}

/// Points along an arc, the first one left out.
fn chords(from: DVec2, to: DVec2, radius: f64, clockwise: bool) -> Result<Vec<Point>, String> {
    let half = 0.5 * from.distance(to);
    if half <= 0.0 || radius <= 0.0 || half > radius + ROUNDING_MM {
        return Err(format!("no arc of R {radius} joins ends {:.4} mm apart", 2.0 * half));
    }
    let radius = radius.max(half);
    let way = (to - from) / (2.0 * half);
    let inwards = if clockwise { -way.perp() } else { way.perp() };
    let centre = 0.5 * (from + to) + inwards * (radius * radius - half * half).max(0.0).sqrt();
    let turn = 2.0 * (half / radius).min(1.0).asin() * if clockwise { -1.0 } else { 1.0 };
    let step = (8.0 * SAGITTA_MM / radius).sqrt();
    let count = (turn.abs() / step).ceil().max(1.0) as usize;
    let at =
        |k: usize| point(centre + DVec2::from_angle(turn * k as f64 / count as f64).rotate(from - centre));
    Ok((1..count).map(at).chain([point(to)]).collect())
}
