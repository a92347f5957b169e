//! Models of turned parts as exporters write them, and what can be wrong with them.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use glam::{DMat3, DQuat, DVec2, DVec3};

use crate::outline::{Outline, Side};
use crate::shaft::ContourPoint;

/// A corner with an arc of `radius_mm`, or 0.
pub fn corner(z_mm: f64, diameter_mm: f64, radius_mm: f64) -> ContourPoint {
    ContourPoint { z_mm, diameter_mm, chamfer_mm: 0.0, radius_mm }
}

/// Corners of the four parts of paper 004, as far as it gives them, with their end faces: a cone of
/// 23.996° with 10 mm of a cylinder behind it, one of 37.590° that ends at its large diameter, an
/// arc between cylinder and face, a cylinder.
pub fn papers_part(number: usize) -> Vec<ContourPoint> {
    let run = |deg: f64| 5.0 / deg.to_radians().tan();
    let corners = match number {
        1 => vec![
            corner(0.0, 40.0, 0.0),
            corner(10.0, 40.0, 0.0),
            corner(10.0, 30.0, 0.0),
            corner(20.0, 30.0, 0.0),
            corner(20.0 + run(23.996), 20.0, 0.0),
            corner(28.0 + run(23.996), 20.0, 0.0),
        ],
        2 => {
            vec![corner(0.0, 30.0, 0.0), corner(run(37.590), 20.0, 0.0), corner(8.0 + run(37.590), 20.0, 0.0)]
        }
        3 => vec![
            corner(0.0, 30.0, 0.0),
            corner(12.0, 30.0, 0.0),
            corner(12.0, 24.0, 2.0),
            corner(20.0, 24.0, 5.0),
        ],
        _ => vec![corner(0.0, 30.0, 0.0), corner(12.0, 30.0, 0.0)],
    };
    let (first, last) = (corners[0].z_mm, corners[corners.len() - 1].z_mm);
    [vec![corner(first, 0.0, 0.0)], corners, vec![corner(last, 0.0, 0.0)]].concat()
}

/// The outline of a part.
pub fn outline(corners: &[ContourPoint]) -> Outline {
    let mut corners = corners.to_vec();
    corners.dedup_by(|a, b| a.z_mm == b.z_mm && a.diameter_mm == b.diameter_mm);
    Outline::from_corners(&corners, Side::External).unwrap()
}

/// Points of an outline as an exporter divides it: arcs in steps of `step_deg` at most.
pub fn profile(outline: &Outline, step_deg: f64) -> Vec<DVec2> {
    let mut points = vec![outline.pieces[0].from];
    for piece in &outline.pieces {
        let turn = (piece.to_rad - piece.from_rad).to_degrees().abs();
        let steps = if piece.arc.is_some() { (turn / step_deg).ceil().max(1.0) as usize } else { 1 };
        points.extend((1..=steps).map(|k| piece.at(k as f64 / steps as f64)));
    }
    points
}

/// Turns of vertices, each with the same number, closed by poles at both ends.
#[derive(Clone, Debug)]
pub struct Body {
    pub rows: Vec<Vec<DVec3>>,
    pub poles: [Option<DVec3>; 2],
}

/// A list of triangles, mm.
pub type Triangles = Vec<[DVec3; 3]>;

impl Body {
    /// A profile from the axis to the axis turned into `n` vertices a turn; end faces have a pole.
    pub fn turned(profile: &[DVec2], n: usize) -> Self {
        let row = |p: &DVec2| -> Vec<DVec3> {
            let at = |k: usize| DVec2::from_angle(TAU * k as f64 / n as f64) * p.x;
            (0..n).map(|k| at(k).extend(p.y)).collect()
        };
        let pole = |p: &DVec2| (p.x == 0.0).then(|| DVec3::new(0.0, 0.0, p.y));
        let rows = profile.iter().filter(|p| p.x > 0.0).map(row).collect();
        Self { rows, poles: [pole(&profile[0]), pole(&profile[profile.len() - 1])] }
    }

    /// The facets, anticlockwise from outside.
    pub fn triangles(&self) -> Triangles {
        let mut all = Vec::new();
        for pair in self.rows.windows(2) {
            let n = pair[0].len();
            for k in 0..n {
                let (a, b, c, d) = (pair[0][k], pair[0][(k + 1) % n], pair[1][(k + 1) % n], pair[1][k]);
                all.extend([[a, b, c], [a, c, d]]);
            }
        }
        let (first, last) = (&self.rows[0], &self.rows[self.rows.len() - 1]);
        let n = first.len();
        for k in 0..n {
            all.extend(self.poles[0].map(|pole| [pole, first[(k + 1) % n], first[k]]));
            all.extend(self.poles[1].map(|pole| [pole, last[k], last[(k + 1) % n]]));
        }
        all
    }

    /// Every vertex changed.
    pub fn mapped(mut self, change: impl Fn(DVec3) -> DVec3) -> Self {
        self.rows.iter_mut().flatten().for_each(|v| *v = change(*v));
        self.poles.iter_mut().flatten().for_each(|v| *v = change(*v));
        self
    }
}

/// A pose that is square to nothing.
pub fn pose() -> (DMat3, DVec3) {
    let axis = DVec3::new(0.3, -0.8, 0.5).normalize();
    (DMat3::from_quat(DQuat::from_axis_angle(axis, 1.1)), DVec3::new(12.0, -7.0, 30.0))
}

pub fn placed(triangles: &Triangles, (turn, shift): (DMat3, DVec3)) -> Triangles {
    triangles.iter().map(|t| t.map(|p| turn * p + shift)).collect()
}

/// A binary file; its header begins like an ASCII one.
pub fn binary(triangles: &Triangles) -> Vec<u8> {
    let mut bytes = b"solid made by an exporter that writes binary".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        bytes.extend([0; 12]);
        for p in t {
            [p.x, p.y, p.z].iter().for_each(|v| bytes.extend((*v as f32).to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

/// An ASCII file with `digits` digits behind the first.
pub fn ascii(triangles: &Triangles, digits: usize) -> Vec<u8> {
    let mut text = "solid part\n".to_owned();
    for t in triangles {
        text += "  facet normal 0 0 0\n    outer loop\n";
        for p in t {
            let _ = writeln!(text, "      vertex {:.digits$e} {:.digits$e} {:.digits$e}", p.x, p.y, p.z);
        }
        text += "    endloop\n  endfacet\n";
    }
    (text + "endsolid part\n").into_bytes()
}
