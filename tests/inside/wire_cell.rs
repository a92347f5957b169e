//! The cell of a head on the wire, before a head in memory whose triggers are ignored, count twice,
//! or make frames that are late, damaged, lost or of another place.

use std::cell::Cell;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use shadowgauge::cell::TurningCell;
use shadowgauge::cell::wire::{Unfit, WireCell, check};
use shadowgauge::frame::{Buffer, Frame, FrameMeta, FrameSource, PixelFormat};
use shadowgauge::job::{LoopJob, ScanWhen};
use shadowgauge::plan::{DiameterOffset, ScanPlan};
use shadowgauge::source::commanded::{Arrived, CommandedHead, HeadError, HeadFrame, Place};

/// What becomes of a trigger.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    Ignored,
    Doubled,
    Late,
    Lost,
    Damaged,
    Displaced,
    Refused,
    Gone,
}

/// A head in memory: features as text, frames of one pixel that is their number.
#[derive(Debug, Default)]
struct Scripted {
    values: BTreeMap<String, String>,
    stations_mm: Vec<f64>,
    nominal_mm: Vec<f64>,
    clock_ns: Cell<u64>,
    triggers: u64,
    faults: BTreeMap<u64, Fault>,
    /// Exposure of a frame that is drawn with the next trigger, before its own.
    behind_ns: Option<u64>,
    queue: VecDeque<Arrived>,
    is_gone: bool,
    refuses_pass: Option<u32>,
    /// Everything that was set and executed, in order.
    log: Arc<Mutex<Vec<String>>>,
}

impl Scripted {
    fn of(job: &LoopJob) -> Self {
        let own = [
            ("CarriageZ", "0"),
            ("FramesSent", "0"),
            ("HeadFrame", "0"),
            ("HeadMessage", ""),
            ("HeadObject", "Drawn"),
            ("MasterIndex", "0"),
            ("PassNumber", "1"),
            ("PassOffset", "0"),
            ("PassStation", "0"),
            ("PassState", "Idle"),
            ("SpindleAngle", "0"),
            ("SpindleSpeed", "0"),
            ("TriggersMissed", "0"),
        ];
        let mut values: BTreeMap<String, String> =
            own.into_iter().map(|(name, value)| (name.to_owned(), value.to_owned())).collect();
        let stations_mm = job.station_z_mm();
        values.insert("PassStationCount".to_owned(), stations_mm.len().to_string());
        values.insert("Width".to_owned(), job.field.columns.to_string());
        values.insert("Height".to_owned(), job.field.rows.to_string());
        values.insert("Pins".to_owned(), job.masters.pins.len().to_string());
        let nominal_mm = (1..=job.passes() as u32).map(|pass| job.part.target_mm(pass)).collect();
        Self { values, stations_mm, nominal_mm, clock_ns: Cell::new(1), ..Self::default() }
    }

    fn with_faults(faults: &[(u64, Fault)]) -> Self {
        Self { faults: faults.iter().copied().collect(), ..Self::of(&LoopJob::default()) }
    }

    fn tick(&self) -> u64 {
        self.clock_ns.set(self.clock_ns.get() + 1000);
        self.clock_ns.get()
    }

    fn float(&self, name: &str) -> f64 {
        self.values[name].parse().unwrap()
    }

    fn count(&mut self, name: &str) {
        let next = self.float(name) + 1.0;
        self.values.insert(name.to_owned(), next.to_string());
    }

    /// A frame by the registers as they are now.
    fn draw(&mut self, exposed_ns: u64, off_mm: f64) -> Arrived {
        self.count("FramesSent");
        let place = Place { z_mm: self.float("CarriageZ") + off_mm, angle_deg: self.float("SpindleAngle") };
        let pixels = Buffer::U16(vec![self.float("HeadFrame") as u16]);
        let meta = FrameMeta { z_mm: place.z_mm, angle_deg: place.angle_deg, ..FrameMeta::default() };
        let frame = Frame::new(pixels, PixelFormat::Mono12, 1, 1, meta).unwrap();
        Arrived::Frame(Box::new(HeadFrame { frame, place: Some(place), exposed_ns: Some(exposed_ns) }))
    }

    fn trigger(&mut self) {
        self.triggers += 1;
        let now_ns = self.tick();
        if let Some(behind_ns) = self.behind_ns.take() {
            let late = self.draw(behind_ns, 0.0);
            self.queue.push_back(late);
        }
        let fault = self.faults.get(&self.triggers).copied();
        match fault {
            Some(Fault::Ignored) => self.count("TriggersMissed"),
            Some(Fault::Lost) => self.count("FramesSent"),
            Some(Fault::Late) => {
                self.count("FramesSent");
                self.behind_ns = Some(now_ns);
            }
            Some(Fault::Damaged) => self.queue.push_back(Arrived::Incomplete("2 packets are missing".into())),
            Some(Fault::Refused) => {
                self.values.insert("HeadMessage".to_owned(), "the part exceeds the field".to_owned());
            }
            Some(Fault::Gone) => self.is_gone = true,
            None | Some(Fault::Doubled | Fault::Displaced) => {
                let off_mm = if fault == Some(Fault::Displaced) { 0.5 } else { 0.0 };
                let drawn = self.draw(now_ns, off_mm);
                self.queue.push_back(drawn);
                self.behind_ns = (fault == Some(Fault::Doubled)).then_some(now_ns);
            }
        }
    }
}

impl CommandedHead for Scripted {
    fn value(&self, feature: &str) -> Option<String> {
        let index = |selector: &str| self.values.get(selector)?.parse::<usize>().ok();
        let at = |all: &[f64], index: usize| all.get(index).map(f64::to_string);
        match feature {
            _ if self.is_gone => None,
            "PassStationZ" => at(&self.stations_mm, index("PassStation")?),
            "PassNominalDiameter" => at(&self.nominal_mm, index("PassNumber")?.saturating_sub(1)),
            _ => self.values.get(feature).cloned(),
        }
    }

    fn set(&mut self, feature: &str, value: &str) -> Result<(), HeadError> {
        self.check()?;
        let number = value.parse::<f64>().unwrap_or(0.0);
        let is_beyond = feature == "PassNumber" && number > self.nominal_mm.len() as f64
            || feature == "MasterIndex" && number >= self.float("Pins");
        if is_beyond {
            let (feature, value, why) = (feature.to_owned(), value.to_owned(), "out of range".to_owned());
            return Err(HeadError::NotSet { feature, value, why });
        }
        self.log.lock().unwrap().push(format!("{feature} {value}"));
        self.values.insert(feature.to_owned(), value.to_owned());
        Ok(())
    }

    fn set_until_end(&mut self, feature: &str, value: &str) -> Result<(), HeadError> {
        self.set(feature, value)
    }

    fn execute(&mut self, command: &str) -> Result<(), HeadError> {
        self.check()?;
        self.log.lock().unwrap().push(command.to_owned());
        match command {
            "TriggerSoftware" => self.trigger(),
            "PassCut" => {
                let refuses = self.refuses_pass == Some(self.float("PassNumber") as u32);
                let (state, words) = if refuses { ("Refused", "no chip that thin") } else { ("Cut", "") };
                self.values.insert("PassState".to_owned(), state.to_owned());
                self.values.insert("HeadMessage".to_owned(), words.to_owned());
            }
            _ => {}
        }
        Ok(())
    }

    fn start(&mut self) -> Result<(), HeadError> {
        self.execute("start")
    }

    fn stop(&mut self) -> Result<(), HeadError> {
        self.execute("stop")
    }

    fn receive(&mut self, _wait: Duration) -> Result<Arrived, HeadError> {
        Ok(self.queue.pop_front().unwrap_or(Arrived::Nothing))
    }

    fn check(&self) -> Result<(), HeadError> {
        let gone = HeadError::Gone("it does not answer".to_owned());
        if self.is_gone { Err(gone) } else { Ok(()) }
    }

    fn now_ns(&self) -> Option<u64> {
        (!self.is_gone).then(|| self.tick())
    }
}

fn cell(head: Scripted) -> WireCell {
    WireCell::new(Box::new(head), "gige:10.0.0.7", "shaft").unwrap()
}

fn plan() -> ScanPlan {
    ScanPlan { field_z_mm: vec![10.25, 31.5], angle_deg: vec![0.0, 120.0, 240.0] }
}

/// Id, place and pixel of every frame.
fn all(frames: &mut dyn FrameSource) -> Vec<(u64, f64, f64, f32)> {
    let taken = std::iter::from_fn(|| frames.next_frame().unwrap());
    let of = |frame: &Frame| (frame.meta.frame_id, frame.meta.z_mm, frame.meta.angle_deg);
    taken
        .map(|frame| {
            let (id, z_mm, angle_deg) = of(&frame);
            (id, z_mm, angle_deg, frame.view().get(0, 0).unwrap())
        })
        .collect()
}

/// The frames of the plan in pass `pass`, from the one of number `first` (from 0) on.
fn wanted(pass: u64, first: u64) -> Vec<(u64, f64, f64, f32)> {
    let ScanPlan { field_z_mm, angle_deg } = plan();
    let places = field_z_mm.iter().flat_map(|z| angle_deg.iter().map(move |angle| (*z, *angle)));
    let frame = |(k, (z, angle)): (u64, (f64, f64))| ((pass << 32) + k, z, angle, (k + 1) as f32);
    (first..).zip(places).map(frame).collect()
}

fn cut(cell: &mut WireCell, pass: u32, o_mm: Vec<f64>) -> Result<(), String> {
    let plan = LoopJob::default().pass_plan(pass, DiameterOffset { o_mm });
    cell.cut(&plan).map_err(|error| error.to_string())
}

#[test]
fn every_frame_has_its_own_place_and_number_whatever_becomes_of_triggers() {
    assert_eq!(all(cell(Scripted::with_faults(&[])).scan(&plan()).unwrap().as_mut()), wanted(0, 0));
    let faults = [Fault::Ignored, Fault::Doubled, Fault::Late, Fault::Lost, Fault::Damaged, Fault::Displaced];
    for fault in faults {
        for at in 1..=6 {
            let mut cell = cell(Scripted::with_faults(&[(at, fault)]));
            let found = all(cell.scan(&plan()).unwrap().as_mut());
            assert_eq!(found, wanted(0, 0), "{fault:?} at trigger {at}");
        }
    }
    // a trigger that counts twice, then one that is late, then one that is lost
    let mixed = [(2, Fault::Doubled), (3, Fault::Late), (4, Fault::Lost), (6, Fault::Doubled)];
    assert_eq!(all(cell(Scripted::with_faults(&mixed)).scan(&plan()).unwrap().as_mut()), wanted(0, 0));
}

/// Frames of one place are kept apart by the clock alone: those of a pin, trigger by trigger.
#[test]
fn frames_of_a_pin_are_counted_from_its_first_whatever_became_of_the_last_trigger() {
    let mut cell = cell(Scripted::with_faults(&[(1, Fault::Doubled), (3, Fault::Late)]));
    for _ in 0..2 {
        let found = all(cell.scan_master(1, 3).unwrap().as_mut());
        let first = (1_u64 << 31) + (1 << 24);
        let wanted: Vec<_> = (0..3).map(|k| (first + k, 0.0, 0.0, (k + 1) as f32)).collect();
        assert_eq!(found, wanted);
    }
}

#[test]
fn a_second_scan_counts_on_and_a_cut_begins_anew() {
    let mut cell = cell(Scripted::with_faults(&[]));
    let stations = LoopJob::default().station_z_mm().len();
    cut(&mut cell, 1, vec![0.0; stations]).unwrap();
    assert_eq!(all(cell.scan(&plan()).unwrap().as_mut()), wanted(1, 0));
    all(cell.scan_master(0, 1).unwrap().as_mut());
    assert_eq!(all(cell.scan(&plan()).unwrap().as_mut()), wanted(1, 6));
    cut(&mut cell, 2, vec![0.0; stations]).unwrap();
    assert_eq!(all(cell.scan(&plan()).unwrap().as_mut()), wanted(2, 0));
}

#[test]
fn a_blank_is_clamped_first_and_offsets_arrive_to_the_last_bit() {
    let head = Scripted::with_faults(&[]);
    let log = Arc::clone(&head.log);
    let mut cell = cell(head);
    let began = ["TriggerSelector FrameStart", "TriggerSource Software", "TriggerMode On"];
    assert_eq!(*log.lock().unwrap(), [&began[..], &["PassNumber 0", "PassCut"]].concat());
    log.lock().unwrap().clear();
    // neighbours of simple numbers, and numbers without a short decimal form
    let o_mm = vec![0.1 + 0.2, -1.0 / 3.0, 5e-324, f64::from_bits(0x3f50_624d_d2f1_a9fd), -0.0];
    cut(&mut cell, 3, o_mm.clone()).unwrap();
    let log = log.lock().unwrap();
    let written = log.iter().filter_map(|line| line.strip_prefix("PassOffset "));
    let found: Vec<u64> = written.map(|text| text.parse::<f64>().unwrap().to_bits()).collect();
    assert_eq!(found, o_mm.iter().map(|o| o.to_bits()).collect::<Vec<_>>());
    assert_eq!(log[log.len() - 2..], ["PassNumber 3", "PassCut"]);
}

#[test]
fn an_object_is_chosen_at_rest_and_a_pin_is_put_in_for_every_look() {
    let head = Scripted::with_faults(&[]);
    let log = Arc::clone(&head.log);
    let mut cell = cell(head);
    log.lock().unwrap().clear();
    drop(cell.scan(&plan()).unwrap());
    drop(cell.scan_master(0, 1).unwrap());
    drop(cell.scan_master(0, 1).unwrap());
    drop(cell.scan(&plan()).unwrap());
    let wanted = [
        "HeadObject Part",
        "start",
        "stop",
        "HeadObject Master",
        "start",
        "MasterIndex 0",
        "MasterIndex 0",
        "stop",
        "HeadObject Part",
        "start",
    ];
    assert_eq!(*log.lock().unwrap(), wanted);
}

#[test]
fn what_fails_is_named_with_the_head_the_frame_or_the_pass_and_the_reason() {
    let fails = |faults: &[(u64, Fault)]| {
        let mut cell = cell(Scripted::with_faults(faults));
        let mut frames = cell.scan(&plan()).unwrap();
        std::iter::repeat_with(|| frames.next_frame()).find_map(Result::err).unwrap().to_string()
    };
    let why = fails(&[(2, Fault::Ignored), (3, Fault::Lost), (4, Fault::Damaged)]);
    assert!(why.starts_with("gige:10.0.0.7: frame 2 of 6 (z = 10.250 mm, 120.0°): "), "{why}");
    assert!(why.contains("3 triggers") && why.contains("2 packets are missing"), "{why}");
    let why = fails(&[(5, Fault::Refused)]);
    assert!(why.contains("frame 5 of 6") && why.ends_with("the part exceeds the field"), "{why}");
    let why = fails(&[(6, Fault::Gone)]);
    assert!(why.contains("frame 6 of 6") && why.contains("the head is gone: it does not answer"), "{why}");

    let head = Scripted { refuses_pass: Some(2), ..Scripted::with_faults(&[]) };
    let mut cell = cell(head);
    cut(&mut cell, 1, vec![0.0]).unwrap();
    let why = cut(&mut cell, 2, vec![0.0]).unwrap_err();
    assert_eq!(why, "gige:10.0.0.7: pass 2: the head refuses: no chip that thin");
}

/// The key and the words of a refusal.
fn refusal(head: &mut Scripted, job: &LoopJob) -> (String, String) {
    match check(head, job).unwrap_err() {
        Unfit::Job(error) => (error.key.clone(), error.to_string()),
        Unfit::Head(error) => panic!("{error}"),
    }
}

/// What is changed of a head that fits, the key that is refused, and words of the reason.
type Misfit<'a> = (&'a dyn Fn(&mut Scripted), &'a str, &'a str);

#[test]
fn a_head_that_does_not_fit_is_refused_by_the_key_of_the_job() {
    let job = LoopJob::default();
    assert!(check(&mut Scripted::of(&job), &job).is_ok());
    let cases: [Misfit<'_>; 7] = [
        (&|head| head.values.retain(|name, _| !name.starts_with("Pass")), "source", "publish CONFIG.toml"),
        (&|head| drop(head.values.insert("Width".into(), "640".into())), "camera.columns", "640"),
        (&|head| drop(head.values.insert("SpindleSpeed".into(), "1200".into())), "source", "1200 rev/min"),
        (&|head| drop(head.values.insert("PassStationCount".into(), "7".into())), "part.station_mm", "7"),
        (&|head| head.stations_mm[3] += 1e-6, "part.station_mm", "station 4"),
        (&|head| head.nominal_mm[1] += 0.01, "part.nominal_diameter_mm", "pass 2"),
        (&|head| drop(head.values.insert("Pins".into(), "1".into())), "masters.pins", "no pin 2"),
    ];
    for (change, key, words) in cases {
        let mut head = Scripted::of(&job);
        change(&mut head);
        let (found, said) = refusal(&mut head, &job);
        assert!(found == key && said.contains(words), "{key}: {found} {said}");
    }
    let mut short = Scripted::of(&job);
    short.nominal_mm.truncate(2);
    assert!(refusal(&mut short, &job).1.contains("the head has no pass 3"));
    let mut during = job.clone();
    during.scan.when = ScanWhen::DuringCut;
    assert_eq!(refusal(&mut Scripted::of(&job), &during).0, "scan.when");
    let mut gone = Scripted { is_gone: true, ..Scripted::of(&job) };
    assert!(matches!(check(&mut gone, &job), Err(Unfit::Head(HeadError::Gone(_)))));
}
