//! The tool, a probe and two-sided heads side by side: what each error does to each, and what each
//! would read of the part that this machine turned.

use serde::Serialize;

use super::config::MachineStudyConfig;
use super::map::range;
use super::prepared::Prepared;
use crate::machine::response::{Part, Side, TwoSided, cut_mm, probe_mm};
use crate::machine::{Chain, ErrorName, ErrorValues, Pose, Station};

/// Size of the errors that are compared: a length, mm, and an angle, rad (typical values).
const SIZE: [f64; 2] = [1e-3, 5e-6];

/// What one error alone does to a diameter, nm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Sensitivity {
    /// Name of ISO 230-1.
    pub error: String,
    /// Its size, with its unit.
    pub size: &'static str,
    /// The diameter that is cut.
    pub cut_nm: f64,
    /// A probe on the tool's side of the X slide, at the tool's levers.
    pub probe_nm: f64,
    /// The heads, in their order.
    pub heads_nm: Vec<f64>,
    /// The midline between both edges of a head.
    pub midline_nm: f64,
}

/// What a probe or a head makes of a place of the part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct ReadingPoint {
    /// Place on the part, mm.
    pub z_mm: f64,
    /// Deviation of the diameter that was cut, µm.
    pub cut_um: f64,
    /// What the errors of the machine add to the reading, µm.
    pub own_um: f64,
    /// Deviation that is indicated: both together, µm.
    pub indicated_um: f64,
    /// Midline of both edges, µm; none of a probe.
    pub midline_um: Option<f64>,
}

/// The readings of a probe or of a head along the part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Reading {
    /// Name.
    pub name: String,
    /// Peak to valley of the deviation cut, where this one measured, µm.
    pub cut_range_um: f64,
    /// Peak to valley of what is indicated, µm.
    pub indicated_range_um: f64,
    /// Rms over the places of indicated less cut, their means taken out, µm.
    pub rms_off_um: f64,
    /// Readings along the part.
    pub points: Vec<ReadingPoint>,
}

/// The comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Comparison {
    /// Names of the heads.
    pub heads: Vec<String>,
    /// One row an error.
    pub sensitivities: Vec<Sensitivity>,
    /// What is read of the part that was cut: probes, then heads; without those that do not reach
    /// the part.
    pub readings: Vec<Reading>,
}

/// Compares.
pub(crate) fn compare(machine: &Prepared, config: &MachineStudyConfig) -> Comparison {
    let setup = Setup { machine, part: config.part.part() };
    let optics: Vec<TwoSided> = config.heads.iter().map(super::config::StudyHead::optics).collect();
    let sensitivity = |name: &ErrorName| setup.sensitivity(*name, &optics);
    let sides = [("probe, tool's side", Side::Tool), ("probe, opposite side", Side::Opposite)];
    let probes = sides.into_iter().map(|(name, side)| (name.to_owned(), setup.probe(side)));
    let heads =
        config.heads.iter().zip(&optics).map(|(head, optics)| (head.name.clone(), setup.head(optics)));
    let readings = probes.chain(heads).filter(|(_, points)| !points.is_empty());
    Comparison {
        heads: config.heads.iter().map(|head| head.name.clone()).collect(),
        sensitivities: ErrorName::ALL.iter().map(sensitivity).collect(),
        readings: readings.map(|(name, points)| reading(name, points)).collect(),
    }
}

/// A machine and the part on it.
struct Setup<'a> {
    machine: &'a Prepared,
    part: Part,
}

impl Setup<'_> {
    fn tip_mm(&self) -> f64 {
        self.machine.settings.tip_above_axis_mm
    }

    fn radius_mm(&self) -> f64 {
        0.5 * self.part.diameter_mm
    }

    /// The pose of a station by the machine's errors.
    fn pose(&self, station: &Station) -> Pose {
        let values = self.machine.motion.values(station.x_mm, station.z_mm, &self.machine.state);
        Chain { topology: self.machine.settings.chain, values }.pose(station)
    }

    /// The deviation of the diameter cut at a place, mm.
    fn cut_mm(&self, z_mm: f64) -> f64 {
        let station = self.machine.settings.tool(self.radius_mm(), z_mm);
        cut_mm(&self.part, self.tip_mm(), &self.pose(&station))
    }

    fn sensitivity(&self, name: ErrorName, heads: &[TwoSided]) -> Sensitivity {
        let settings = &self.machine.settings;
        let [from, to] = settings.z_travel_mm;
        let middle = 0.5 * (from + to);
        let size = if name.is_length() { SIZE[0] } else { SIZE[1] };
        let chain = Chain { topology: settings.chain, values: ErrorValues::only(name, size) };
        let tool = chain.pose(&settings.tool(self.radius_mm(), middle));
        let head = chain.pose(&settings.head(middle - settings.head_beside_tool_mm()));
        Sensitivity {
            error: name.code(),
            size: if name.is_length() { "1 µm" } else { "5 µrad" },
            cut_nm: 1e6 * cut_mm(&self.part, self.tip_mm(), &tool),
            probe_nm: 1e6 * probe_mm(&self.part, self.tip_mm(), Side::Tool, &tool),
            heads_nm: heads.iter().map(|optics| 1e6 * optics.read_mm(&self.part, &head)).collect(),
            midline_nm: 1e6 * TwoSided::midline_mm(&head),
        }
    }

    /// A probe's readings along the part; none where X does not reach that side.
    fn probe(&self, side: Side) -> Vec<ReadingPoint> {
        let x_mm = match side {
            Side::Tool => self.radius_mm(),
            Side::Opposite => -self.radius_mm(),
        };
        let [from, to] = self.machine.settings.x_travel_mm;
        if !(from..=to).contains(&x_mm) {
            return Vec::new();
        }
        let at = |z: &f64| {
            let pose = self.pose(&self.machine.settings.tool(x_mm, *z));
            self.point(*z, probe_mm(&self.part, self.tip_mm(), side, &pose), None)
        };
        self.machine.z_mm.iter().map(at).collect()
    }

    /// A head's readings, where it reaches what the tool cut.
    fn head(&self, optics: &TwoSided) -> Vec<ReadingPoint> {
        let settings = &self.machine.settings;
        let [from, to] = settings.z_travel_mm;
        let at = |z: &f64| {
            let slide = z - settings.head_beside_tool_mm();
            if !(from..=to).contains(&slide) {
                return None;
            }
            let pose = self.pose(&settings.head(slide));
            let midline = 1e3 * TwoSided::midline_mm(&pose);
            Some(self.point(*z, optics.read_mm(&self.part, &pose), Some(midline)))
        };
        self.machine.z_mm.iter().filter_map(at).collect()
    }

    fn point(&self, z_mm: f64, own_mm: f64, midline_um: Option<f64>) -> ReadingPoint {
        let (cut_um, own_um) = (1e3 * self.cut_mm(z_mm), 1e3 * own_mm);
        ReadingPoint { z_mm, cut_um, own_um, indicated_um: cut_um + own_um, midline_um }
    }
}

fn reading(name: String, points: Vec<ReadingPoint>) -> Reading {
    let span = |component: fn(&ReadingPoint) -> f64| {
        let (low, high) = range(points.iter().map(component));
        high - low
    };
    let count = points.len() as f64;
    let mean = points.iter().map(|p| p.own_um).sum::<f64>() / count;
    let squares = points.iter().map(|p| (p.own_um - mean).powi(2)).sum::<f64>();
    Reading {
        cut_range_um: span(|p| p.cut_um),
        indicated_range_um: span(|p| p.indicated_um),
        rms_off_um: (squares / count).sqrt(),
        name,
        points,
    }
}
