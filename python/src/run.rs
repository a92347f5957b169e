//! A config's job, pass after pass.
//!
//! The closed loop lives on a thread of its own, which waits between passes for the order to go on;
//! the interpreter's thread waits for a pass without the lock and looks for Ctrl-C meanwhile.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use pyo3::prelude::*;
use shadowgauge::cell::SimulatedCell;
use shadowgauge::closed_loop::{ClosedLoop, PassResult};
use shadowgauge::control::ControllerName;
use shadowgauge::job::Job;
use shadowgauge::plan::Decision;
use shadowgauge::profile::{Diameter, Reading};
use shadowgauge::render::{BackendChoice, Renderer};

use crate::column::{Column, Values};
use crate::controller::{PythonController, Raised, take};
use crate::errors::{from_json, raise};
use crate::scene::{backend, read_job};
use crate::table::Table;

/// Interval at which a waiting interpreter looks for Ctrl-C: what a person does not notice.
const LOOK: Duration = Duration::from_millis(50);

/// A finished pass, as plain values.
struct Pass {
    number: u32,
    nominal_mm: f64,
    frames: usize,
    held: Option<String>,
    alarm: Option<String>,
    notes: Vec<String>,
    stations: Vec<Column>,
}

/// What the loop's thread reports.
enum Report {
    /// Ready for a first pass.
    Ready,
    Pass(Box<Pass>),
    /// All passes are done.
    Done,
    Failed(String),
}

/// Passes of a job, one for each `next`: the numbers of the pass and the table of its stations.
#[pyclass(frozen, module = "shadowgauge")]
pub(crate) struct Run {
    state: Mutex<State>,
    raised: Raised,
}

struct State {
    /// Orders to cut another pass; none once the run has ended.
    orders: Option<Sender<()>>,
    reports: Receiver<Report>,
    /// A pass was ordered and is not reported yet: the wait for it was interrupted.
    is_due: bool,
}

/// What a run is started with.
struct Order {
    job: Job,
    backend: BackendChoice,
    controller: Option<(PythonController, String)>,
}

impl Order {
    /// The loop's thread: passes by order, until no one orders any more.
    fn follow(self, orders: &Receiver<()>, reports: &Sender<Report>) -> Result<(), String> {
        let Self { job, backend, controller } = self;
        let words = |error: &dyn std::fmt::Display| error.to_string();
        let renderer = Renderer::new(backend).map_err(|e| words(&e))?;
        let cell = Box::new(SimulatedCell::new(&job, &renderer).map_err(|e| words(&e))?);
        let order = job.checked_loop().map_err(|e| words(&e))?;
        let turning = match controller {
            None => ClosedLoop::start(order, cell, None),
            Some((stream, name)) => {
                let controller = job.program_controller(stream, &name, "Python");
                ClosedLoop::with_controller(order, cell, None, controller)
            }
        };
        let mut turning = turning.map_err(|e| words(&e))?;
        // Whoever waits for a report has gone where it cannot be sent.
        let _ = reports.send(Report::Ready);
        while orders.recv().is_ok() {
            if turning.next_pass().is_none() {
                let _ = reports.send(Report::Done);
                continue;
            }
            let pass = turning.run_pass(&mut |_, _| {}).map_err(|e| words(&e))?;
            let _ = reports.send(Report::Pass(Box::new(Pass::of(&pass))));
        }
        Ok(())
    }
}

impl Pass {
    fn of(result: &PassResult) -> Self {
        let stations = &result.profile.stations;
        let value = |of: fn(Diameter) -> f64| {
            Values::Double(stations.iter().map(|s| s.reading.value().map_or(f64::NAN, of)).collect())
        };
        let flag = |reading: &Reading| match reading {
            Reading::Value(_) => String::new(),
            Reading::Gap(reason) => reason.to_string(),
        };
        let mut columns = vec![
            ("z_mm", Values::Double(stations.iter().map(|s| s.z_mm).collect())),
            ("nominal_mm", Values::Double(result.plan.station_nominal_mm().collect())),
            ("offset_mm", Values::Double(result.plan.offset.o_mm.clone())),
            ("d_mm", value(|d| d.d_mm)),
            ("u_random_mm", value(|d| d.u_random_mm)),
            ("u_common_mm", value(|d| d.u_common_mm)),
            ("flag", Values::Text(stations.iter().map(|s| flag(&s.reading)).collect())),
        ];
        if let Some(truth) = &result.truth_mm {
            columns.push(("true_mm", Values::Double(truth.clone())));
        }
        let held = match &result.decision {
            Some(Decision::Held(reason)) => Some(reason.to_string()),
            _ => None,
        };
        Self {
            number: result.plan.pass,
            nominal_mm: result.plan.nominal_mm,
            frames: result.frames,
            held,
            alarm: result.alarm.clone(),
            notes: result.notes.clone(),
            stations: columns,
        }
    }
}

/// The numbers of a pass: number, nominal diameter, frames, why its offsets were held, alarm, notes,
/// stations.
type PyPass = (u32, f64, usize, Option<String>, Option<String>, Vec<String>, Table);

impl Run {
    /// Waits for the next report, looking for Ctrl-C.
    fn report(&self, py: Python<'_>) -> PyResult<Report> {
        loop {
            let report = py.detach(|| {
                let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
                state.reports.recv_timeout(LOOK)
            });
            match report {
                Ok(report) => return Ok(report),
                Err(RecvTimeoutError::Timeout) => py.check_signals()?,
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(raise(py, "Error", "the run has ended: begin another one"));
                }
            }
        }
    }

    /// What failed: what a Python controller raised is its cause.
    fn failed(&self, py: Python<'_>, text: &str) -> PyErr {
        let Some(cause) = take(&self.raised) else {
            let class = if text.starts_with("controller ") { "ControllerError" } else { "Error" };
            return raise(py, class, text);
        };
        let error = raise(py, "ControllerError", text);
        error.set_cause(py, Some(cause));
        error
    }
}

#[pymethods]
impl Run {
    /// Of a config: its path, or a text with the folder of its files; a controller by its name, or a
    /// function of a line as `shadowgauge.controller` makes one.
    #[new]
    #[pyo3(signature = (path, text=None, controller=None, function=None, seed=None, backend="cpu"))]
    fn new(
        py: Python<'_>,
        path: PathBuf,
        text: Option<&str>,
        controller: Option<String>,
        function: Option<Py<PyAny>>,
        seed: Option<u64>,
        backend: &str,
    ) -> PyResult<Self> {
        let mut job = read_job(py, text, &path, false)?;
        job.seed = seed.unwrap_or(job.seed);
        let raised = Raised::default();
        let own = match (function, controller) {
            (Some(function), name) => {
                // As for every program beside the controllers: those of the config are out of the way.
                job.control.controller = ControllerName::None;
                let name = name.unwrap_or_else(|| "controller".to_owned());
                Some((PythonController::new(function, raised.clone()), name))
            }
            (None, Some(name)) => {
                let text = serde_json::Value::from(name).to_string();
                job.control.controller = from_json(py, "controller", &text)?;
                None
            }
            (None, None) => None,
        };
        let order = Order { job, backend: self::backend(py, backend)?, controller: own };
        let (orders, ordered) = channel();
        let (sender, reports) = channel();
        std::thread::spawn(move || {
            if let Err(text) = order.follow(&ordered, &sender) {
                let _ = sender.send(Report::Failed(text));
            }
        });
        let state = Mutex::new(State { orders: Some(orders), reports, is_due: false });
        let run = Self { state, raised };
        match run.report(py)? {
            Report::Failed(text) => Err(run.failed(py, &text)),
            _ => Ok(run),
        }
    }

    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    /// Cuts, scans, measures and corrects the next pass.
    fn __next__(&self, py: Python<'_>) -> PyResult<Option<PyPass>> {
        {
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            if !state.is_due {
                let sent = state.orders.as_ref().is_some_and(|orders| orders.send(()).is_ok());
                if !sent {
                    return Err(raise(py, "Error", "the run has ended: begin another one"));
                }
                state.is_due = true;
            }
        }
        let report = self.report(py)?;
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.is_due = false;
        match report {
            Report::Pass(pass) => {
                let Pass { number, nominal_mm, frames, held, alarm, notes, stations } = *pass;
                Ok(Some((number, nominal_mm, frames, held, alarm, notes, Table::new(stations))))
            }
            Report::Ready | Report::Done => Ok(None),
            Report::Failed(text) => {
                state.orders = None;
                drop(state);
                Err(self.failed(py, &text))
            }
        }
    }
}
