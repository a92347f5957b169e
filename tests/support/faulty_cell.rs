//! A lathe, its gauge and their faults, fast enough for 10⁵ cycles.
//!
//! Stations are independent: the shaft yields by H(z, k)·(a/0.25 mm)^0.9 with the actual depth of
//! cut a and a barrel H that grows from pass to pass; repeatability 0.4 µm, reading 0.3 µm. One
//! fault per part, or none.

use super::plant::CUTTING;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;
use shadowgauge::control::{
    ControlSettings, Controller, ControllerName, NextPass, Origin, PartAndTool, PartStart, PassContext, build,
};
use shadowgauge::plan::{Decision, DiameterOffset, PassPlan, PlannedForm};
use shadowgauge::profile::{Diameter, DiameterProfile, Reading, Reason, Station};

const STATIONS: usize = 24;
const NOMINALS_MM: [f64; 4] = [26.5, 26.0, 25.5, 25.0 - 0.0065];
const LOWER_MM: f64 = 25.0 - 0.013;
/// Error from which a step that increases it is in the wrong direction, mm: half the tolerance.
const CLEAR_MM: f64 = 0.0065;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    None,
    /// The last pass's profile, unchanged.
    Stale,
    /// The last pass's values under this pass's number and a new scan.
    StaleRelabelled,
    /// Values of another part of the batch, its labels with them.
    WrongPart,
    /// Values of another part of the batch under this part's labels.
    Swapped,
    /// Error of one station: in one scan, or in both (dirt on the shaft).
    Outlier {
        size_mm: f64,
        lasting: bool,
    },
    /// Drift of the gauge per pass, detectable on the master.
    Drift(f64),
    /// The machine multiplies the offset by this.
    Factor(f64),
    Gap,
}

#[derive(Debug, Default)]
pub struct Tally {
    pub parts: usize,
    pub cycles: usize,
    pub faults: usize,
    pub finished: usize,
    pub stopped: usize,
    pub good_parts_stopped: usize,
    pub held: usize,
    pub wrong_direction: usize,
    pub above_limit: usize,
    pub undersize: usize,
}

impl Tally {
    pub fn add(&mut self, other: &Self) {
        self.parts += other.parts;
        self.cycles += other.cycles;
        self.faults += other.faults;
        self.finished += other.finished;
        self.stopped += other.stopped;
        self.good_parts_stopped += other.good_parts_stopped;
        self.held += other.held;
        self.wrong_direction += other.wrong_direction;
        self.above_limit += other.above_limit;
        self.undersize += other.undersize;
    }
}

fn settings(name: ControllerName) -> ControlSettings {
    let mut settings = ControlSettings { controller: name, ..ControlSettings::default() };
    settings.guards.lower_limit_mm = Some(LOWER_MM);
    settings.guards.confirm_above_mm = 0.001;
    settings.ilc.q_cutoff_mm = 0.0;
    settings
}

pub fn run(name: ControllerName, parts: usize, seed: u64) -> Tally {
    Cell::new(&settings(name), seed).run(parts, true)
}

/// Guards as wide as possible, no origin of measurements, alarms ignored.
pub fn run_unguarded(name: ControllerName, parts: usize, seed: u64) -> Tally {
    let mut open = settings(name);
    let g = &mut open.guards;
    (g.plausible_error_mm, g.scatter_limit_mm, g.outlier_limit_mm) = (10.0, 10.0, 10.0);
    (g.step_limit_mm, g.cumulative_limit_mm, g.confirm_above_mm) = (10.0, 10.0, 10.0);
    (g.response_from_mm, g.lower_limit_mm, g.max_depth_mm, g.min_depth_mm) = (10.0, None, 10.0, 0.0);
    Cell::new(&open, seed).run(parts, false)
}

/// Two scans of one pass.
type Scans = [DiameterProfile; 2];

struct Cell {
    rng: Pcg64,
    z_mm: Vec<f64>,
    controller: Box<dyn Controller + Send>,
    settings: ControlSettings,
    scan: u64,
    tally: Tally,
}

struct Part {
    id: usize,
    fault: Fault,
    at: u32,
    height_mm: f64,
    d_mm: Vec<f64>,
    e_mm: Vec<f64>,
    drift_mm: f64,
    last: Option<(Scans, Origin)>,
}

impl Cell {
    fn new(settings: &ControlSettings, seed: u64) -> Self {
        let z_mm: Vec<f64> = (0..STATIONS).map(|i| 500.0 / STATIONS as f64 * (i as f64 + 0.5)).collect();
        let controller = build(settings, &z_mm).expect("a controller");
        let rng = Pcg64::seed_from_u64(seed);
        Self { rng, z_mm, controller, settings: settings.clone(), scan: 0, tally: Tally::default() }
    }

    fn normal(&mut self, sd: f64) -> f64 {
        sd * self.rng.sample::<f64, _>(StandardNormal)
    }

    fn run(mut self, parts: usize, guarded: bool) -> Tally {
        for id in 0..parts {
            self.part(id, guarded);
        }
        self.tally
    }

    fn draw_fault(&mut self) -> Fault {
        let size = self.rng.random_range(0.005..0.2);
        let sign = if self.rng.random_bool(0.5) { 1.0 } else { -1.0 };
        match self.rng.random_range(0..20) {
            0 => Fault::Stale,
            1 => Fault::StaleRelabelled,
            2 => Fault::WrongPart,
            3 => Fault::Swapped,
            4 => Fault::Outlier { size_mm: sign * size, lasting: self.rng.random_bool(0.5) },
            5 => Fault::Drift(sign * 0.1 * size),
            6 => Fault::Factor(2.0),
            7 => Fault::Factor(0.5),
            8 => Fault::Factor(-1.0),
            9 => Fault::Factor(0.0),
            10 => Fault::Gap,
            _ => Fault::None,
        }
    }

    fn part(&mut self, id: usize, guarded: bool) {
        let fault = self.draw_fault();
        let mut part = Part {
            id,
            fault,
            at: self.rng.random_range(1..4),
            height_mm: self.rng.random_range(0.040..0.046),
            d_mm: vec![27.0; STATIONS],
            e_mm: vec![0.0; STATIONS],
            drift_mm: 0.0,
            last: None,
        };
        self.tally.parts += 1;
        self.tally.faults += usize::from(fault != Fault::None);
        let mut offset = self.controller.begin_part(&PartStart::default(), STATIONS);
        for pass in 1..=4_u32 {
            let plan = self.plan(pass, offset.clone());
            self.cut(&mut part, &plan);
            if pass == 4 {
                break;
            }
            match self.correct(&mut part, &plan, guarded) {
                Some(next) => offset = next,
                None => {
                    self.tally.stopped += 1;
                    self.tally.good_parts_stopped += usize::from(fault == Fault::None);
                    return;
                }
            }
        }
        self.tally.finished += 1;
        let least = part.e_mm.iter().copied().fold(f64::INFINITY, f64::min);
        if NOMINALS_MM[3] + least < LOWER_MM {
            self.tally.undersize += 1;
            if guarded {
                println!("part {id} undersize by {fault:?} at pass {}: {least:.4}", part.at);
            }
        }
    }

    fn plan(&self, pass: u32, offset: DiameterOffset) -> PassPlan {
        let nominal_mm = NOMINALS_MM[pass as usize - 1];
        PassPlan {
            pass,
            nominal_mm,
            cutting: CUTTING,
            station_z_mm: self.z_mm.clone(),
            offset,
            form: PlannedForm::PLAIN,
        }
    }

    fn cut(&mut self, part: &mut Part, plan: &PassPlan) {
        let factor = if let Fault::Factor(f) = part.fault { f } else { 1.0 };
        for i in 0..STATIONS {
            let xi = 2.0 * (i as f64 + 0.5) / STATIONS as f64 - 1.0;
            let grown = 1.0 + 0.09 * f64::from(plan.pass - 1);
            let yields = part.height_mm * (1.0 - 0.9 * xi * xi) * grown;
            let noise = self.normal(0.0004);
            let commanded = plan.nominal_mm - factor * plan.offset.o_mm[i];
            // each round reduces the change to about H·0.9/(2·0.25 mm), a twelfth
            let after = (0..6)
                .fold(commanded, |d, _| commanded + yields * ((part.d_mm[i] - d).max(0.0) / 0.5).powf(0.9));
            part.d_mm[i] = after + noise;
            part.e_mm[i] = part.d_mm[i] - plan.nominal_mm;
        }
    }

    fn measure(&mut self, part: &mut Part, plan: &PassPlan) -> (Scans, Origin) {
        self.scan += 1;
        let now = part.at == plan.pass;
        if let Fault::Drift(step) = part.fault {
            part.drift_mm += step;
        }
        let other = self.rng.random_range(0.93..1.07);
        let at = self.rng.random_range(0..STATIONS);
        let scans = [0, 1].map(|scan| self.scan_once(part, plan, (other, at, scan)));
        let master = part.drift_mm + self.normal(0.0002);
        let owner = if part.fault == Fault::WrongPart && now { part.id + 1 } else { part.id };
        let of = PartAndTool { part: owner.to_string(), tool: "T1".into() };
        let origin =
            Origin { of, scan: self.scan, age_s: 10.0, since_cut_s: 5.0, master_deviation_mm: Some(master) };
        let fresh = (scans, origin);
        let shown = match (&part.last, part.fault) {
            (Some(last), Fault::Stale) if now => last.clone(),
            (Some((scans, _)), Fault::StaleRelabelled) if now => {
                (scans.clone().map(|s| DiameterProfile { pass: plan.pass, ..s }), fresh.1.clone())
            }
            _ => fresh.clone(),
        };
        part.last = Some(fresh);
        shown
    }

    fn scan_once(
        &mut self,
        part: &Part,
        plan: &PassPlan,
        (other, at, scan): (f64, usize, usize),
    ) -> DiameterProfile {
        let now = part.at == plan.pass;
        let mut stations = Vec::with_capacity(STATIONS);
        for i in 0..STATIONS {
            let mut d_mm = plan.nominal_mm + part.e_mm[i] + part.drift_mm + self.normal(0.0003);
            match part.fault {
                Fault::Swapped if now => d_mm += (other - 1.0) * part.e_mm[i],
                Fault::WrongPart if now => d_mm += 0.01,
                Fault::Outlier { size_mm, lasting } if now && i == at && (lasting || scan == 0) => {
                    d_mm += size_mm;
                }
                _ => {}
            }
            let value = Diameter { d_mm, u_random_mm: 0.0003, u_common_mm: 0.0002 };
            let lost = part.fault == Fault::Gap && now && i == at;
            let reading = if lost { Reading::Gap(Reason::Contaminated) } else { Reading::Value(value) };
            stations.push(Station { z_mm: self.z_mm[i], reading, freedom: None });
        }
        DiameterProfile { pass: plan.pass, stations }
    }

    /// Offsets of the next pass; `None` where the cell stops.
    fn correct(&mut self, part: &mut Part, plan: &PassPlan, guarded: bool) -> Option<DiameterOffset> {
        let ([profile, again], origin) = self.measure(part, plan);
        let here = PartAndTool { part: part.id.to_string(), tool: "T1".into() };
        let nominal_mm = NOMINALS_MM[plan.pass as usize];
        let next = NextPass { nominal_mm, cutting: CUTTING, finishing: plan.pass == 3 };
        let context = PassContext {
            origin: guarded.then_some(&origin),
            in_machine: guarded.then_some(&here),
            repeat: guarded.then_some(&again),
            next: guarded.then_some(next),
            blank_mm: None,
        };
        self.tally.cycles += 1;
        let released = match self.controller.decide_in(plan, &profile, &context) {
            Decision::Offset(released) => released,
            Decision::Held(_) => {
                self.tally.held += 1;
                let stops = guarded && self.controller.alarm().is_some();
                return (!stops).then(|| plan.offset.clone());
            }
        };
        self.judge(part, plan, &released);
        Some(released)
    }

    fn judge(&mut self, part: &Part, plan: &PassPlan, released: &DiameterOffset) {
        let guards = &self.settings.guards;
        let steps = released.o_mm.iter().zip(&plan.offset.o_mm).map(|(new, old)| new - old);
        let (mut wrong, mut above) = (false, false);
        for ((step, o), e) in steps.zip(&released.o_mm).zip(&part.e_mm) {
            wrong |= e.abs() > CLEAR_MM && step * e < 0.0;
            above |= step.abs() > guards.step_limit_mm || o.abs() > guards.cumulative_limit_mm;
        }
        self.tally.wrong_direction += usize::from(wrong);
        self.tally.above_limit += usize::from(above);
    }
}
