//! A controller in Python, behind the protocol of programs.
//!
//! The closed loop writes a line of JSON and reads one back (`docs/controllers.md`), as with a
//! program on pipes; here the line goes to a Python function and its result is the reply. So the
//! guards stand before the offsets of a Python controller as they do before every other.

use std::io::{Error, ErrorKind, Read, Result, Write};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;

/// What the function raised.
pub(crate) type Raised = Arc<Mutex<Option<PyErr>>>;

/// Takes what a function raised.
pub(crate) fn take(raised: &Raised) -> Option<PyErr> {
    raised.lock().unwrap_or_else(PoisonError::into_inner).take()
}

/// A stream to a Python function of a line that returns a line or None.
pub(crate) struct PythonController {
    function: Py<PyAny>,
    /// The line that is being written.
    line: Vec<u8>,
    /// Replies that are not read yet.
    replies: Vec<u8>,
    raised: Raised,
}

impl PythonController {
    pub(crate) fn new(function: Py<PyAny>, raised: Raised) -> Self {
        Self { function, line: Vec::new(), replies: Vec::new(), raised }
    }

    /// Gives a line to the function.
    fn answer(&mut self, line: &str) -> Result<()> {
        let reply = Python::attach(|py| self.function.call1(py, (line,))?.extract::<Option<String>>(py));
        match reply {
            Ok(reply) => {
                self.replies.extend(reply.into_iter().flat_map(|reply| (reply + "\n").into_bytes()));
                Ok(())
            }
            Err(error) => {
                let text = error.to_string();
                self.raised.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                Err(Error::other(text))
            }
        }
    }
}

impl Write for PythonController {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.line.extend_from_slice(bytes);
        while let Some(end) = self.line.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = self.line.drain(..=end).collect();
            self.answer(&String::from_utf8_lossy(&line))?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

impl Read for PythonController {
    fn read(&mut self, into: &mut [u8]) -> Result<usize> {
        if self.replies.is_empty() {
            return Err(Error::new(ErrorKind::UnexpectedEof, "it returned no reply"));
        }
        let length = into.len().min(self.replies.len());
        into[..length].copy_from_slice(&self.replies[..length]);
        self.replies.drain(..length);
        Ok(length)
    }
}
