//! Simulated runs that were started here: child processes, bounded in number, memory and output.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;
use tokio::sync::Notify;
use utoipa::ToSchema;

use super::child::{self, LONGEST_LINE, RUN_MIB};

/// Runs at a time: one uses both cores of the smallest machine that this is for.
const MOST_RUNNING: usize = 2;
/// Last lines of a run's log that are kept.
const LOG_LINES: usize = 200;
/// Ended runs that are listed.
const MOST_ENDED: usize = 100;

/// A run that was started here.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub(super) struct JobStatus {
    /// Name of its folder.
    pub run: String,
    /// Whether it runs.
    pub running: bool,
    /// Exit code, of a run that has ended by itself.
    pub exit: Option<i32>,
    /// Passes that it has finished.
    pub passes: usize,
    /// Passes that its config has.
    pub passes_planned: usize,
    /// The last lines of its log.
    pub log: Vec<String>,
}

/// What a run is started with.
#[derive(Clone, Debug)]
pub(super) struct Planned {
    /// The program's arguments.
    pub arguments: Vec<String>,
    /// Passes of its config.
    pub passes: usize,
}

#[derive(Debug, Default)]
struct Job {
    log: VecDeque<String>,
    exit: Option<i32>,
    running: bool,
    planned: usize,
    stop: Arc<Notify>,
}

/// All of them.
#[derive(Debug, Default)]
pub(super) struct Jobs(Arc<Mutex<BTreeMap<String, Job>>>);

impl Jobs {
    /// Starts a run.
    ///
    /// # Errors
    /// A run of this name that is running, or as many as may be; a program that does not start.
    pub(super) fn start(&self, run: &str, planned: &Planned) -> Result<(), String> {
        let mut jobs = self.lock();
        if jobs.get(run).is_some_and(|job| job.running) {
            return Err(format!("{run} is running"));
        }
        if jobs.values().filter(|job| job.running).count() >= MOST_RUNNING {
            return Err(format!("{MOST_RUNNING} runs are running, as many as may: stop one or wait"));
        }
        let ended: Vec<String> = jobs.iter().filter(|(_, j)| !j.running).map(|(n, _)| n.clone()).collect();
        for name in ended.iter().take(ended.len().saturating_sub(MOST_ENDED)) {
            jobs.remove(name);
        }
        let running = child::start(&planned.arguments, Some(RUN_MIB))?;
        let stop = Arc::new(Notify::new());
        let job = Job { running: true, planned: planned.passes, stop: Arc::clone(&stop), ..Job::default() };
        jobs.insert(run.to_owned(), job);
        tokio::spawn(follow(Arc::clone(&self.0), run.to_owned(), running, stop));
        Ok(())
    }

    /// Stops a run; its finished passes stay.
    ///
    /// # Errors
    /// A run that is not running.
    pub(super) fn stop(&self, run: &str) -> Result<(), String> {
        match self.lock().get(run) {
            Some(job) if job.running => {
                job.stop.notify_one();
                Ok(())
            }
            _ => Err(format!("{run} is not running")),
        }
    }

    /// What became of them; passes that are finished are counted in their folders.
    pub(super) fn status(&self) -> Vec<JobStatus> {
        let of = |(run, job): (&String, &Job)| JobStatus {
            run: run.clone(),
            running: job.running,
            exit: job.exit,
            passes: 0,
            passes_planned: job.planned,
            log: job.log.iter().cloned().collect(),
        };
        self.lock().iter().map(of).collect()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<String, Job>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Follows a run to its end, or until it is stopped.
async fn follow(
    jobs: Arc<Mutex<BTreeMap<String, Job>>>,
    run: String,
    mut running: child::Running,
    stop: Arc<Notify>,
) {
    let note = |line: String| {
        let mut jobs = jobs.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(job) = jobs.get_mut(&run) {
            job.log.push_back(line.chars().take(LONGEST_LINE).collect());
            if job.log.len() > LOG_LINES {
                job.log.pop_front();
            }
        }
    };
    let mut exit = None;
    loop {
        tokio::select! {
            Ok(Some(line)) = running.out.next_line() => note(line),
            Ok(Some(line)) = running.err.next_line() => note(line),
            () = stop.notified() => {
                // finished passes are on the disk: a kill at any instant is what a run survives
                let _ = running.child.kill().await;
                break;
            }
            ended = running.child.wait() => {
                exit = ended.ok().and_then(|status| status.code());
                break;
            }
        }
    }
    while let Ok(Some(line)) = running.err.next_line().await {
        note(line);
    }
    let mut jobs = jobs.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(job) = jobs.get_mut(&run) {
        job.running = false;
        job.exit = exit;
    }
}
