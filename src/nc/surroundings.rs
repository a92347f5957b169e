//! The surroundings of the part as solids from the axis outwards, and the tool's outline.
//!
//! Where data are missing, safe assumptions hold: nothing may move behind Z = 0, a centre stands in
//! the end face and grows at once to a large quill, a steady rest of the run takes up its place at
//! every radius. The space under a solid counts as occupied, so that from every clear place the way
//! out in X is free.

use super::machine::{Centre, Direction, Tailstock};
use super::probe::{CORRECTION, QUALIFIED};
use super::replay::{CommandedCut, Convex, Solid, WorkingSpace};
use super::route::{QUILL_MM, Route, Workpiece};
use super::sinumerik::RAN_LAST;
use super::skeleton::Skeleton;

/// A length beyond all dimensions of a lathe, mm.
const FAR_MM: f64 = 1e4;
/// What a refusal calls the gauge head where it is parked.
pub(super) const PARKED_HEAD: &str = "parked gauge head";
/// Half width along Z of a steady rest of which only the place is stated, mm: rollers and arms of
/// common rests.
const HALF_STEADY_MM: f64 = 15.0;
/// Largest point of a centre that is assumed at the end face, as a share of the part's diameter:
/// above the countersinks that ISO 866 and DIN 332-1 give for shafts (a 1.6 mm centre hole, 3.35 mm
/// wide, for 6 mm; 6.7 mm wide for 25 mm).
const HOLE_SHARE: f64 = 0.6;
/// Tangents that circumscribe the nose, over its lower half.
const NOSE_TANGENTS: usize = 13;

/// The centre that is assumed in a part of `diameter` mm where none is stated.
pub(super) fn assumed_centre(piece: &Workpiece, diameter: f64) -> Centre {
    let quill = QUILL_MM.max(piece.largest_mm());
    let hole = HOLE_SHARE * diameter;
    // the cone alone, until it is as wide as the quill
    Centre { point_deg: 60.0, hole_mm: hole, body_mm: quill, quill_mm: quill, quill_from_mm: f64::INFINITY }
}

/// Outlines of the tool about the programmed point.
pub(super) fn tool(
    settings: &crate::nc::settings::NcSettings,
    route: &Route,
    direction: Direction,
) -> Vec<Convex> {
    let r = route.nose_mm;
    let middle = match direction {
        Direction::TowardsChuck => r,
        Direction::TowardsTailstock => -r,
    };
    let mut outline = vec![(middle - r, FAR_MM), (middle + r, FAR_MM)];
    // corners of the circumscribed polygon lie between neighbouring tangents, at r/cos(half the
    // step)
    let step = std::f64::consts::PI / (NOSE_TANGENTS - 1) as f64;
    outline.extend((0..NOSE_TANGENTS - 1).map(|i| {
        let (sin, cos) = (std::f64::consts::PI + (i as f64 + 0.5) * step).sin_cos();
        let out = r / (0.5 * step).cos();
        (middle + out * cos, r + out * sin)
    }));
    let mut shapes = vec![Convex::hull(outline)];
    if let Some(h) = settings.holder {
        let (left, right) = (-h.towards_chuck_mm, h.towards_tailstock_mm);
        let box_of = [(left, h.above_mm), (right, h.above_mm), (right, FAR_MM), (left, FAR_MM)];
        shapes.push(Convex::hull(box_of.to_vec()));
    }
    shapes
}

impl<'a> Skeleton<'a> {
    /// The solids, the stock and the tool for a replay of this program; `commanded` are (Z, X), Z
    /// ascending.
    pub(super) fn working_space(&self, commanded: Vec<(f64, f64)>) -> WorkingSpace<'a> {
        let (s, piece, route) = (self.settings, self.piece, &self.route);
        let smallest = commanded.iter().map(|c| c.1).fold(f64::INFINITY, f64::min);
        let mut solids = self.chuck();
        solids.extend(self.tailstock(smallest));
        solids.extend(self.rests());
        if let Some(h) = s.gauge_head {
            let shape = Convex::cylinder(h.from_z_mm, h.to_z_mm, h.diameter_mm);
            solids.push(Solid { what: PARKED_HEAD, shape });
        }
        let (end, clear) = (piece.length_mm, 0.5 * s.clearance_mm);
        let collar = route.full_from_mm;
        let before = piece.solids_before();
        let mut stock: Vec<Solid> =
            before.iter().map(|ends| Solid { what: "stock", shape: Convex::frustum(*ends) }).collect();
        stock.push(Solid {
            what: "uncut stock at the chuck",
            shape: Convex::cylinder(0.0, collar, piece.largest_mm()),
        });
        // clearance towards the chuck and around; at the end face the tool feeds in from outside
        let wide = |[a, b]: [(f64, f64); 2]| [(a.0 - clear, a.1 + clear), (b.0, b.1 + clear)];
        let mut kept_clear: Vec<Convex> = before.iter().map(|ends| Convex::frustum(wide(*ends))).collect();
        kept_clear.push(Convex::cylinder(-clear, collar, piece.largest_mm() + clear));
        let mut variables = vec![(RAN_LAST, 0.0)];
        if let Some(probe) = s.probe {
            variables.push((CORRECTION, probe.correction_mm));
            variables.push((QUALIFIED, f64::from(probe.tool)));
        }
        if let (Some(r), Some((low, high))) = (s.remeasure, self.limits_mm) {
            variables.extend([r.smallest_variable, r.largest_variable].map(|v| (v, 0.5 * (low + high))));
        }
        WorkingSpace {
            dialect: self.dialect,
            settings: s,
            solids,
            stock,
            kept_clear,
            tool: tool(s, route, piece.direction),
            bore: None,
            probe: s.probe.map(|p| p.outlines()).unwrap_or_default(),
            surface: None,
            change: route.change,
            cut: CommandedCut { commanded, between: (route.z_first.min(route.z_last), end), solid: None },
            travel: s.travel,
            head: Vec::new(),
            scan: None,
            tool_page: None,
            variables,
        }
    }

    /// Chuck and jaws, from the axis outwards.
    pub(super) fn chuck(&self) -> Vec<Solid> {
        let solid = |what, to_z, diameter| Solid { what, shape: Convex::cylinder(-FAR_MM, to_z, diameter) };
        match self.settings.chuck {
            None => vec![solid("room behind Z 0 (chuck not stated)", 0.0, 2.0 * FAR_MM)],
            Some(c) => vec![
                solid("chuck", 0.0, c.diameter_mm),
                solid("jaws", c.jaws_to_z_mm, c.jaws_diameter_mm.unwrap_or(c.diameter_mm)),
            ],
        }
    }

    fn tailstock(&self, smallest_mm: f64) -> Vec<Solid> {
        let end = self.piece.length_mm;
        let (centre, whats) = match self.settings.tailstock {
            Some(Tailstock::Absent) => return Vec::new(),
            Some(Tailstock::Centre(c)) => (c, ["tailstock centre", "body of the centre", "tailstock quill"]),
            None => {
                let whats =
                    ["tailstock centre (assumed)", "tailstock (assumed)", "tailstock quill (assumed)"];
                (assumed_centre(self.piece, smallest_mm), whats)
            }
        };
        let slope = (0.5 * centre.point_deg).to_radians().tan();
        let cone_end = end + 0.5 * (centre.body_mm - centre.hole_mm).max(0.0) / slope;
        let cone =
            vec![(end, 0.0), (end, 0.5 * centre.hole_mm), (cone_end, 0.5 * centre.body_mm), (cone_end, 0.0)];
        let [point, body, quill] = whats;
        let mut solids = vec![
            Solid { what: point, shape: Convex::hull(cone) },
            Solid { what: body, shape: Convex::cylinder(cone_end, end + FAR_MM, centre.body_mm) },
        ];
        if centre.quill_from_mm.is_finite() {
            let shape = Convex::cylinder(end + centre.quill_from_mm, end + FAR_MM, centre.quill_mm);
            solids.push(Solid { what: quill, shape });
        }
        solids
    }

    fn rests(&self) -> Vec<Solid> {
        let what = "steady rest";
        match &self.settings.steady_rests {
            Some(stated) => stated
                .iter()
                .map(|o| Solid { what, shape: Convex::cylinder(o.from_z_mm, o.to_z_mm, o.diameter_mm) })
                .collect(),
            None => self.piece.steady_z_mm.iter().map(|z| at_every_radius(*z)).collect(),
        }
    }
}

fn at_every_radius(z: f64) -> Solid {
    let shape = Convex::cylinder(z - HALF_STEADY_MM, z + HALF_STEADY_MM, 2.0 * FAR_MM);
    Solid { what: "steady rest of the run (nc.steady_rests is not stated)", shape }
}
