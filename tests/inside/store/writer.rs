//! A process that writes passes until something ends it: this test program again, with a store
//! named in its environment. What it has acknowledged stands on its stdout.

use std::ffi::OsStr;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use super::{pass, run};
use crate::store::{Store, StoreError};

/// Where the store's name stands.
const STORE: &str = "SHADOWGAUGE_WRITTEN_STORE";

/// The writer; without a store in the environment nothing is done.
#[test]
#[ignore = "a process of the tests beside it"]
fn writes_until_it_is_ended() {
    let Some(path) = std::env::var_os(STORE) else { return };
    let mut store = Store::open(Path::new(&path), "writer").unwrap();
    let stored = store.counts().unwrap().passes;
    // as a run that is resumed: what was stored last is offered again
    for number in u32::try_from(stored).unwrap().max(1).. {
        match store.acknowledge(&run("written"), &[pass(number, 22.0)]) {
            Ok(_) => println!("acknowledged {number}"),
            Err(StoreError::Full { path }) => return println!("full {}", path.display()),
            Err(error) => return println!("refused {error}"),
        }
    }
}

/// A writer that runs.
pub(super) struct Writer {
    child: Child,
}

/// What a writer has said until its end.
#[derive(Debug, Default)]
pub(super) struct Said {
    /// The newest pass that it acknowledged; 0 where there was none.
    pub(super) acknowledged: i64,
    /// Why it ended by itself.
    pub(super) refusal: Option<String>,
}

impl Writer {
    /// Starts one on a store; where `limit` is stated, its files are no longer than that many
    /// blocks of 512 bytes (or 1024, as the shell counts).
    pub(super) fn start(store: &Path, limit: Option<u32>) -> Self {
        let own = std::env::current_exe().unwrap();
        let test = "inside::store::writer::writes_until_it_is_ended";
        let arguments: Vec<&OsStr> = vec![own.as_os_str(), test.as_ref()];
        let mut command = Command::new("/bin/sh");
        // a write beyond the limit is an error, not the end of the process
        let limits = limit.map_or_else(String::new, |blocks| format!("trap '' XFSZ; ulimit -f {blocks}; "));
        command.arg("-c").arg(format!("{limits}exec \"$0\" \"$@\"")).args(arguments);
        command.args(["--exact", "--ignored", "--nocapture"]).env(STORE, store);
        Self { child: command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap() }
    }

    /// Kills it (SIGKILL) and reads what it has said.
    pub(super) fn killed(mut self) -> Said {
        let _ = self.child.kill();
        self.ended()
    }

    /// Reads until its end.
    pub(super) fn ended(mut self) -> Said {
        let mut said = Said::default();
        for line in BufReader::new(self.child.stdout.take().unwrap()).lines().map_while(Result::ok) {
            match line.split_once(' ') {
                // a line that the kill cut off has no end: what is parsed of it is smaller
                Some(("acknowledged", number)) => {
                    said.acknowledged = said.acknowledged.max(number.parse().unwrap_or(0));
                }
                Some(("full" | "refused", _)) => said.refusal = Some(line),
                _ => {}
            }
        }
        self.child.wait().unwrap();
        said
    }
}
