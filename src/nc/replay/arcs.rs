//! Arcs and nose radius compensation of a replay: both become straight moves.
//!
//! An arc by R is the shorter one, clockwise for G02 as seen with Z to the right and X up. With G41
//! or G42 the centre of the register's circle runs beside the contour at the distance R, and the
//! gauge point R·(σx, σz) from it: it starts, and ends, at right angles to the first and the last
//! move; between two moves the offset lines are extended or shortened to where they meet, at a
//! concave corner by as much as the two blocks that meet there allow.

use std::collections::HashMap;

use glam::DVec2;

use super::interpreter::{Interpreter, Motion, Point, Words};
use crate::nc::dialect::Dialect;
use crate::nose::{Numbering, TipDirection};

/// Largest sagitta of the chords of an arc, mm.
const SAGITTA_MM: f64 = 1e-6;
/// Half of a chord may be longer than R by this, mm: ends and R are rounded to increments.
const ROUNDING_MM: f64 = 0.002;
/// Cosine of the largest turn of a compensated contour, 135°: beyond it extended lines run far off.
const MOST_TURN_COS: f64 = -0.707;

/// The register of a nose: radius and number of the tip direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct NoseRegister {
    radius: f64,
    wear: f64,
    tip: u8,
}

/// What the control takes of the nose.
#[derive(Clone, Debug, Default)]
pub(super) struct Nose {
    /// Registers by the number of their offset.
    registers: HashMap<u32, NoseRegister>,
    /// The offset in force.
    pub(super) offset: u32,
    /// G41 or G42.
    pub(super) compensation: Option<Compensation>,
}

/// Compensation in force.
#[derive(Clone, Debug)]
pub(super) struct Compensation {
    /// Whether the tool runs on the right of the contour.
    right: bool,
    radius: f64,
    tip: TipDirection,
    /// Where the tool stood before it.
    from: Point,
    /// The contour's points and the lines of their blocks.
    contour: Vec<(Point, usize)>,
    ends: bool,
}

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
            (Dialect::Fanuc, 0) => {
                let nose = self.nose.registers.get(&self.nose.offset).copied();
                let nose = nose.ok_or("G41 or G42 with a register that the program has not written")?;
                (nose.radius + nose.wear, TipDirection::of(nose.tip, Numbering::Fanuc))
            }
            _ => return Err("this G41 or G42 is not understood".into()),
        };
        let tip = tip.ok_or("a tip direction of 0 to 9 is needed")?;
        let (right, from) = (code / 10 == 42, self.at);
        self.nose.compensation =
            Some(Compensation { right, radius, tip, from, contour: Vec::new(), ends: false });
        Ok(())
    }

    /// A move to `to`, straight or along an arc, compensated where it is on.
    pub(super) fn drive(&mut self, line: usize, to: Point, words: &Words) -> Result<(), String> {
        let motion = self.modal.motion;
        let points = match motion {
            Some(Motion::Arc { clockwise }) => {
                let radius = words.get('R').ok_or("an arc needs R")?;
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
            compensation.contour.extend(points.into_iter().map(|p| (p, line)));
            self.at = to;
            return Ok(());
        }
        if points.len() > 1 {
            return Err("compensation ends on an arc".into());
        }
        let Some(done) = self.nose.compensation.take() else { return Ok(()) };
        self.at = done.from;
        for (at, line) in done.path()? {
            self.go(line, at, false);
        }
        self.go(line, to, false);
        Ok(())
    }
}

/// A straight move of the circle's centre, and the line of its block.
#[derive(Clone, Copy, Debug)]
struct Way {
    from: DVec2,
    to: DVec2,
    along: DVec2,
    block: usize,
}

impl Compensation {
    /// The gauge point along the contour.
    fn path(&self) -> Result<Vec<(Point, usize)>, String> {
        let ways = self.ways();
        let Some(first) = ways.first() else { return Err("a compensated contour without a move".into()) };
        let mut centres = vec![(first.from, first.block)];
        let mut k = 0;
        while k + 1 < ways.len() {
            let start = centres[centres.len() - 1].0;
            k = match Self::extended(start, (&ways[k], &ways[k + 1]))? {
                Some(at) => {
                    centres.push((at, ways[k + 1].block));
                    k + 1
                }
                None => self.shortened(&mut centres, &ways, k)?,
            };
        }
        centres.push((ways[k].to, ways[k].block));
        let (sx, sz) = self.tip.signs();
        let gauge = self.radius * DVec2::new(sz, sx);
        Ok(centres.into_iter().map(|(centre, block)| (point(centre + gauge), block)).collect())
    }

    /// Moves of the centre at the distance R from each move of the contour.
    fn ways(&self) -> Vec<Way> {
        let way = |w: &[(Point, usize)]| {
            let (from, to) = (plane(w[0].0), plane(w[1].0));
            let along = (to - from).try_normalize().filter(|_| from.distance(to) > 1e-9)?;
            let beside = self.radius * if self.right { -along.perp() } else { along.perp() };
            Some(Way { from: from + beside, to: to + beside, along, block: w[1].1 })
        };
        self.contour.windows(2).filter_map(way).collect()
    }

    /// Where two moves meet, extended, or shortened by less than their lengths.
    fn extended(start: DVec2, (a, b): (&Way, &Way)) -> Result<Option<DVec2>, String> {
        let cos = a.along.dot(b.along);
        if cos < MOST_TURN_COS {
            let at = point(a.to);
            return Err(format!("the contour turns by more than 135 degrees at X {:.3} Z {:.3}", at.x, at.z));
        }
        let sine = a.along.perp_dot(b.along);
        let at = if sine.abs() < 1e-12 {
            a.to
        } else {
            a.to + a.along * ((b.from - a.to).perp_dot(b.along) / sine)
        };
        let fits = (at - start).dot(a.along) > -1e-9 && (b.to - at).dot(b.along) > -1e-9;
        Ok(fits.then_some(at))
    }

    /// Ends the centre's path where it first meets the next block; the number of the move that goes
    /// on from there.
    fn shortened(&self, centres: &mut Vec<(DVec2, usize)>, ways: &[Way], k: usize) -> Result<usize, String> {
        let next = &ways[k + 1..];
        let ahead = next.iter().take_while(|w| w.block == next[0].block).count();
        for back in
            (1..centres.len() + 1).take_while(|&back| centres[centres.len() - back].1 == ways[k].block)
        {
            let i = centres.len() - back;
            let from = centres[i].0;
            let to = centres.get(i + 1).map_or(ways[k].to, |c| c.0);
            for (j, way) in next[..ahead].iter().enumerate() {
                if let Some(at) = crossing((from, to), (way.from, way.to)) {
                    centres.truncate(i + 1);
                    centres.push((at, way.block));
                    return Ok(k + 1 + j);
                }
            }
        }
        let at = point(ways[k].to);
        Err(format!(
            "the register's radius {:.4} does not fit into the contour at X {:.3} Z {:.3}",
            self.radius, at.x, at.z
        ))
    }
}

/// Where two stretches cross.
fn crossing((a, b): (DVec2, DVec2), (c, d): (DVec2, DVec2)) -> Option<DVec2> {
    let (u, v) = (b - a, d - c);
    let sine = u.perp_dot(v);
    let (s, t) = ((c - a).perp_dot(v) / sine, (c - a).perp_dot(u) / sine);
    let on = |share: f64| (-1e-9..=1.0 + 1e-9).contains(&share);
    (on(s) && on(t)).then(|| a + u * s)
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
