//! The nose as a control takes it: registers, and what G41 and G42 make of a contour.
//!
//! With G41 or G42 the centre of the register's circle runs beside the contour at the distance R,
//! and the gauge point R·(σx, σz) from it: it starts, and ends, at right angles to the first and
//! the last move; between two moves the offset lines are extended or shortened to where they meet,
//! at a concave corner by as much as the two blocks that meet there allow. Vectors are (Z, X as a
//! radius), mm: to the right and up.

use std::collections::HashMap;

use glam::DVec2;

use crate::nc::nose_words;
use crate::nose::{Numbering, TipDirection};

/// Cosine of the largest turn of a compensated contour, 135°: beyond it extended lines run far off.
const MOST_TURN_COS: f64 = -0.707;

/// The register of a nose: radius and number of the tip direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct NoseRegister {
    /// Radius of the geometry, mm.
    pub(super) radius: f64,
    /// Radius of the wear, which adds to it, mm.
    pub(super) wear: f64,
    /// Number of the tip direction.
    pub(super) tip: u8,
}

/// What the control takes of the nose.
#[derive(Clone, Debug, Default)]
pub(super) struct Nose {
    /// Registers by the number of their offset.
    pub(super) registers: HashMap<u32, NoseRegister>,
    /// The offset in force.
    pub(super) offset: u32,
    /// Whether compensation begins and ends at right angles (SINUMERIK's NORM).
    pub(super) at_right_angles: bool,
    /// Whether offset lines are extended at outer corners (SINUMERIK's G451).
    pub(super) extends_corners: bool,
    /// G41 or G42.
    pub(super) compensation: Option<Compensation>,
}

impl Nose {
    /// The registers of a tool whose radius and tip direction stand on its page.
    pub(super) fn of_page(tool: u32, page: Option<nose_words::NoseRegister>) -> Self {
        let stands = |on: nose_words::NoseRegister| NoseRegister {
            radius: on.radius_mm,
            wear: 0.0,
            tip: on.tip.number(Numbering::Fanuc),
        };
        Self { registers: page.map(|on| (tool, stands(on))).into_iter().collect(), ..Self::default() }
    }
}

/// Compensation in force.
#[derive(Clone, Debug)]
pub(super) struct Compensation {
    /// Whether the tool runs on the right of the contour.
    pub(super) right: bool,
    /// R, mm.
    pub(super) radius: f64,
    /// Where the gauge point lies.
    pub(super) tip: TipDirection,
    /// Where the tool stood before it.
    pub(super) from: DVec2,
    /// The contour's points and the lines of their blocks.
    pub(super) contour: Vec<(DVec2, usize)>,
    /// Whether the next move ends it.
    pub(super) ends: bool,
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
    /// The gauge point along the contour, each place with the block that moves to it.
    pub(super) fn path(&self) -> Result<Vec<(DVec2, usize)>, String> {
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
        // a centre carries the block that begins there; the move to it belongs to the one before
        let blocks: Vec<usize> =
            self.contour.iter().take(1).chain(&centres).map(|(_, block)| *block).collect();
        Ok(centres.into_iter().zip(blocks).map(|((centre, _), block)| (centre + gauge, block)).collect())
    }

    /// Moves of the centre at the distance R from each move of the contour.
    fn ways(&self) -> Vec<Way> {
        let way = |w: &[(DVec2, usize)]| {
            let (from, to) = (w[0].0, w[1].0);
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
            let (x, z) = (2.0 * a.to.y, a.to.x);
            return Err(format!("the contour turns by more than 135 degrees at X {x:.3} Z {z:.3}"));
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
        let (x, z) = (2.0 * ways[k].to.y, ways[k].to.x);
        Err(format!(
            "the register's radius {:.4} does not fit into the contour at X {:.3} Z {:.3}",
            self.radius, x, z
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
