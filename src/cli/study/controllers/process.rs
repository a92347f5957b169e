//! A process as a stream of bytes: what is written goes to its stdin, what is read comes from its
//! stdout, within a time limit; its stderr is this program's.
//!
//! Threads of their own write and read, so that neither a full pipe nor a silent program stops the
//! study: both end as reads that time out.

use std::io::{Error, ErrorKind, Read, Result, Write};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel, sync_channel};
use std::time::{Duration, Instant};

/// Interval at which a process that should end is looked after.
const LOOK: Duration = Duration::from_millis(5);
/// Time from the end of a program's output to its exit status, for the message: it has closed its
/// output and is about to end, or runs on.
const TO_STATUS: Duration = Duration::from_millis(200);
/// Chunks of output that are read ahead; a program that writes more waits.
const READ_AHEAD: usize = 16;

/// A running process; dropped, it has the time limit to end once its stdin is closed, and is
/// killed then.
pub(super) struct Process {
    child: Child,
    timeout: Duration,
    /// What is written to its stdin; none once that is closed.
    input: Option<Sender<Vec<u8>>>,
    output: Receiver<Vec<u8>>,
    /// Output that was received and not read.
    chunk: Vec<u8>,
    /// When the next output is due.
    due: Instant,
    /// It did not reply in time.
    late: bool,
}

impl Process {
    /// Starts a program.
    ///
    /// # Errors
    /// Where it is not found or cannot be run.
    pub(super) fn start(program: &str, arguments: &[String], timeout: Duration) -> Result<Self> {
        let mut command = Command::new(program);
        command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::inherit());
        let mut child = command.spawn()?;
        let (input, lines) = channel::<Vec<u8>>();
        let (chunks, output) = sync_channel(READ_AHEAD);
        if let Some(mut stdin) = child.stdin.take() {
            // A program that takes no more input has ended or will be late.
            std::thread::spawn(move || lines.iter().try_for_each(|line| stdin.write_all(&line)));
        }
        if let Some(mut stdout) = child.stdout.take() {
            std::thread::spawn(move || {
                let mut bytes = [0; 8192];
                while let Ok(length @ 1..) = stdout.read(&mut bytes) {
                    if chunks.send(bytes[..length].to_vec()).is_err() {
                        return;
                    }
                }
            });
        }
        let (chunk, due) = (Vec::new(), Instant::now() + timeout);
        Ok(Self { child, timeout, input: Some(input), output, chunk, due, late: false })
    }

    /// Waits for its end; `None` where it runs on.
    fn wait(&mut self, limit: Duration) -> Option<std::process::ExitStatus> {
        let until = Instant::now() + limit;
        loop {
            match self.child.try_wait() {
                Ok(None) if Instant::now() < until => std::thread::sleep(LOOK),
                Ok(status) => return status,
                Err(_) => return None,
            }
        }
    }

    /// The end of its output, as an error with its exit status.
    fn ended(&mut self) -> Error {
        let how = self.wait(TO_STATUS).map_or_else(|| "its output is closed".to_owned(), |s| s.to_string());
        Error::new(ErrorKind::UnexpectedEof, how)
    }
}

impl Write for Process {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        // Where the thread has gone, the read that follows reports the end of the program.
        let _ = self.input.as_ref().map(|input| input.send(bytes.to_vec()));
        self.due = Instant::now() + self.timeout;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

impl Read for Process {
    fn read(&mut self, into: &mut [u8]) -> Result<usize> {
        if self.chunk.is_empty() {
            match self.output.recv_timeout(self.due.saturating_duration_since(Instant::now())) {
                Ok(chunk) => self.chunk = chunk,
                Err(RecvTimeoutError::Disconnected) => return Err(self.ended()),
                Err(RecvTimeoutError::Timeout) => {
                    self.late = true;
                    let limit = format!("none within {} s (--command-timeout-s)", self.timeout.as_secs());
                    return Err(Error::new(ErrorKind::TimedOut, limit));
                }
            }
        }
        let length = into.len().min(self.chunk.len());
        into[..length].copy_from_slice(&self.chunk[..length]);
        self.chunk.drain(..length);
        Ok(length)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.input = None;
        let limit = if self.late { Duration::ZERO } else { self.timeout };
        match self.wait(limit) {
            Some(status) if !status.success() => tracing::warn!("a controller's program ended with {status}"),
            Some(_) => {}
            None => {
                let why = if self.late { "it is late" } else { "it runs on after its input has ended" };
                tracing::warn!("a controller's program is killed: {why}");
                let _ = self.child.kill().and_then(|()| self.child.wait().map(drop));
            }
        }
    }
}
