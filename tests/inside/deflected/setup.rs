//! A bent, turning shaft in an optical setup, scanned as by a carriage.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use shadowgauge::frame::{Frame, FrameMeta};
use shadowgauge::gauge::{
    Calibration, ColumnDiameters, FrameEdges, Gauge, GaugeSettings, MasterCertificate, MasterMeasurement,
    StationAverager, StationSettings,
};
use shadowgauge::profile::DiameterProfile;
use shadowgauge::render::form::form_shaft;
use shadowgauge::render::settings::{Esf, GaussianEsf, SetupDeviations, SetupSettings};
use shadowgauge::render::{BackendChoice, FrameRequest, OpticalSetup, Renderer, Scene};
use shadowgauge::shaft::{Pose, ProfileKnot, Shaft, ShaftForm};

/// Expanded uncertainty of the masters' certificates, mm (k = 2).
const MASTER_U_MM: f64 = 1e-4;

/// A case: the shaft and the scan.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub diameter_mm: f64,
    pub length_mm: f64,
    pub station_mm: f64,
    pub rows: u32,
    pub columns: u32,
    pub fields: usize,
    pub angles: usize,
    /// Angles over a whole turn instead of half of one.
    pub whole_turn: bool,
    /// Step between scanned fields; stations in the fields between are not measured.
    pub field_step: usize,
}

impl Case {
    pub fn stations(&self) -> Vec<f64> {
        let n = (self.length_mm / self.station_mm).round() as usize;
        (0..n).map(|k| (k as f64 + 0.5) * self.station_mm).collect()
    }

    pub fn intervals(&self) -> Vec<(f64, f64)> {
        self.stations().into_iter().map(|z| (z - 0.5 * self.station_mm, z + 0.5 * self.station_mm)).collect()
    }

    /// (z of the field's middle, spindle angle) of every frame, field after field.
    fn stops(&self) -> Vec<(f64, f64)> {
        let pitch = self.length_mm / self.fields as f64;
        let span = if self.whole_turn { 360.0 } else { 180.0 };
        (0..self.fields)
            .step_by(self.field_step)
            .flat_map(|f| {
                (0..self.angles)
                    .map(move |a| ((f as f64 + 0.5) * pitch, span * a as f64 / self.angles as f64))
            })
            .collect()
    }

    fn setup(&self, seed: u64, telecentricity_mrad: f64) -> OpticalSetup {
        let departures = SetupDeviations { magnification_rel: 1e-3, blur_rel: 0.05, gain_rel: 0.05 };
        let mut settings = SetupSettings { departures, ..Default::default() };
        settings.optics.telecentricity_mrad = telecentricity_mrad;
        settings.camera.rows = self.rows;
        settings.camera.columns = self.columns;
        settings.optics.esf = Esf::Gaussian(GaussianEsf { sigma_px: 1.2 });
        OpticalSetup::resolve(&settings, seed).unwrap()
    }
}

/// An optical setup with its gauge calibrated on two pins whose true diameters are drawn from their
/// certificates.
pub struct Head {
    pub case: Case,
    pub seed: u64,
    pub setup: OpticalSetup,
    pub gauge: Gauge,
    pub calibration: Calibration,
    pub renderer: Renderer,
}

/// A frame's columns with its metadata.
pub struct Measured {
    pub meta: FrameMeta,
    pub columns: ColumnDiameters,
}

impl Head {
    pub fn new(case: Case, seed: u64) -> Self {
        Self::with_telecentricity(case, seed, 0.0)
    }

    /// Before a lens whose chief ray stands at this angle at half the diagonal.
    pub fn with_telecentricity(case: Case, seed: u64, telecentricity_mrad: f64) -> Self {
        let renderer = Renderer::new(BackendChoice::Cpu).unwrap();
        let setup = case.setup(seed, telecentricity_mrad);
        let gauge = Gauge::new(GaugeSettings::default()).unwrap();
        let mut rng = Pcg64::seed_from_u64(seed ^ 0x6d61_7374);
        let mut draw = |size: f64| -> f64 {
            let z: f64 = StandardNormal.sample(&mut rng);
            size * z
        };
        let masters: Vec<MasterMeasurement> = [0.96, 1.04]
            .into_iter()
            .enumerate()
            .map(|(k, share)| {
                let diameter_mm = (share * case.diameter_mm * 2.0).round() / 2.0;
                let truth = diameter_mm + draw(0.5 * MASTER_U_MM);
                let frames = (0..8)
                    .map(|i| {
                        let pose = Pose { x_mm: draw(0.05), tilt_mrad: draw(0.3), ..Pose::default() };
                        let scene = Scene::new(&setup, Shaft { pose, ..Shaft::cylinder(truth) }).unwrap();
                        let id = 1_000_000 + 1000 * k as u64 + i;
                        let request =
                            FrameRequest { frame_id: id, noise: true, seed, ..FrameRequest::default() };
                        gauge.edges(&renderer.render(&scene, &request, None).unwrap().view()).unwrap()
                    })
                    .collect();
                let certificate =
                    MasterCertificate { diameter_mm, expanded_u_mm: MASTER_U_MM, coverage_factor: 2.0 };
                MasterMeasurement { certificate, frames }
            })
            .collect();
        let calibration = Calibration::fit(&masters).unwrap().with_edge_model(&gauge.settings().esf);
        Self { case, seed, setup, gauge, calibration, renderer }
    }

    pub fn shaft(&self, form: &ShaftForm) -> Shaft {
        let blank = vec![ProfileKnot { z_mm: 0.0, radius_mm: 0.5 * self.case.diameter_mm }];
        form_shaft(blank, form, self.case.length_mm, self.seed).unwrap()
    }

    /// Frames of a shaft, measured in one stream.
    pub fn scan(&self, shaft: &Shaft) -> Vec<Measured> {
        self.scan_beside(shaft, |_, _| {})
    }

    /// Frames of a shaft, measured in one stream, and each by itself.
    pub fn scan_twice(&self, shaft: &Shaft) -> [Vec<Measured>; 2] {
        let mut single = Vec::new();
        let stream = self.scan_beside(shaft, |frame, head| {
            let edges = head.gauge.edges(&frame.view()).unwrap();
            single.push(Measured { meta: frame.meta.clone(), columns: head.calibration.diameters(&edges) });
        });
        [stream, single]
    }

    fn scan_beside(&self, shaft: &Shaft, mut beside: impl FnMut(&Frame, &Self)) -> Vec<Measured> {
        let scene = Scene::new(&self.setup, shaft.clone()).unwrap();
        let mut stream = self.gauge.stream();
        let mut edges = FrameEdges::default();
        let mut spare: Option<Frame> = None;
        let mut all = Vec::new();
        for (k, (z_mm, angle_deg)) in self.case.stops().into_iter().enumerate() {
            let seed = self.seed;
            let request = FrameRequest {
                frame_id: k as u64,
                z_mm,
                angle_deg,
                noise: true,
                seed,
                ..FrameRequest::default()
            };
            let frame = self.renderer.render(&scene, &request, spare.take()).unwrap();
            stream.measure(&frame.view(), &mut edges).unwrap();
            beside(&frame, self);
            all.push(Measured { meta: frame.meta.clone(), columns: self.calibration.diameters(&edges) });
            spare = Some(frame);
        }
        all
    }

    pub fn profile(&self, frames: &[Measured]) -> DiameterProfile {
        let mut averager =
            StationAverager::new(&StationSettings::default(), self.case.stations(), self.case.station_mm);
        frames.iter().for_each(|f| averager.add(&f.meta, &f.columns));
        averager.finish(1)
    }
}
