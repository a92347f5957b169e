//! Lines to a program and back, over a stream of bytes.

use std::io::{ErrorKind, Read, Write};

use super::error::{Fault, ProgramError};
use super::messages::Message;
use super::reply::{self, Answer};

/// Largest length of a reply, bytes: a number of 17 digits takes 24 at most, and as much again is
/// left for separators and indentation.
const BYTES_A_STATION: usize = 48;
/// The rest of the largest reply, bytes: keys, or a reason of some sentences.
const BYTES_BESIDES: usize = 4096;
/// Characters of a faulty line that an error shows: one line of a terminal.
const SHOWN: usize = 80;

/// Lines to a program and back.
pub(super) struct Conversation<S> {
    stream: S,
    /// The program's name and command.
    program: String,
    /// Bytes read after the last line.
    unread: Vec<u8>,
    /// Lines read.
    lines: u64,
}

impl<S: Read + Write> Conversation<S> {
    pub(super) fn new(stream: S, program: String) -> Self {
        Self { stream, program, unread: Vec::new(), lines: 0 }
    }

    /// Writes a message as one line.
    ///
    /// # Errors
    /// Where the program takes no input.
    pub(super) fn send(&mut self, message: &Message<'_>) -> std::io::Result<()> {
        let mut line = serde_json::to_vec(message)?;
        line.push(b'\n');
        self.stream.write_all(&line)?;
        self.stream.flush()
    }

    /// Writes a message and reads the reply, which is for `pass`.
    ///
    /// # Errors
    /// Where the program takes no input, ends, is late, or replies anything but a reply.
    pub(super) fn ask(
        &mut self,
        message: &Message<'_>,
        pass: u32,
        stations: usize,
    ) -> Result<Answer, ProgramError> {
        let fault = match self.send(message).and_then(|()| self.line(stations)) {
            Ok(Some(line)) => match reply::read(&line, pass, stations) {
                Ok(answer) => return Ok(answer),
                Err(why) => Fault::Reply { line: self.lines, pass, why, text: shortened(&line), stations },
            },
            Ok(None) => Fault::Ended { pass, how: String::new() },
            Err(error) => fault(&error, pass),
        };
        Err(self.error(fault))
    }

    pub(super) fn error(&self, fault: Fault) -> ProgramError {
        ProgramError { program: self.program.clone(), fault }
    }

    /// The next line, without its end; none at the end of the output. A line that is too long comes
    /// cut off, which is no JSON.
    fn line(&mut self, stations: usize) -> std::io::Result<Option<String>> {
        let longest = BYTES_BESIDES + BYTES_A_STATION * stations;
        let mut chunk = [0; 4096];
        let length = loop {
            if let Some(end) = self.unread.iter().position(|byte| *byte == b'\n') {
                break end + 1;
            }
            if self.unread.len() > longest {
                break longest;
            }
            match self.stream.read(&mut chunk) {
                Ok(0) if self.unread.is_empty() => return Ok(None),
                Ok(0) => break self.unread.len(),
                Ok(read) => self.unread.extend_from_slice(&chunk[..read]),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        };
        self.lines += 1;
        let line: Vec<u8> = self.unread.drain(..length).collect();
        Ok(Some(String::from_utf8_lossy(&line).trim_end().to_owned()))
    }
}

/// What an error of the stream shows of the program.
fn fault(error: &std::io::Error, pass: u32) -> Fault {
    match error.kind() {
        ErrorKind::TimedOut => Fault::Late { pass, limit: error.to_string() },
        ErrorKind::UnexpectedEof => Fault::Ended { pass, how: format!(" ({error})") },
        ErrorKind::BrokenPipe => Fault::Ended { pass, how: String::new() },
        _ => Fault::Lost { pass, cause: error.to_string() },
    }
}

/// A line as an error shows it.
fn shortened(line: &str) -> String {
    let start: String = line.chars().take(SHOWN).collect();
    if start.len() < line.len() { format!("{start}…") } else { start }
}
