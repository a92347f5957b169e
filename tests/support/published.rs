//! A published head in a process of its own, at an address of a test's own.
#![allow(dead_code, reason = "not every test uses every helper")]

use std::io::{BufRead as _, BufReader};
use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::gige_client::Client;
use crate::program;

/// A head that ends with the test.
pub struct Published {
    pub program: Child,
    /// What it prints when it begins.
    pub words: Vec<String>,
    pub address: Ipv4Addr,
}

impl Drop for Published {
    fn drop(&mut self) {
        let _ = (self.program.kill(), self.program.wait());
    }
}

impl Published {
    pub fn source(&self) -> String {
        format!("gige:{}", self.address)
    }

    pub fn client(&self) -> Client {
        Client::new(SocketAddrV4::new(self.address, 3956))
    }

    pub fn kill(&mut self) {
        self.program.kill().unwrap();
        self.program.wait().unwrap();
    }
}

/// An address of the loopback interface by the number of a test, so that tests may run at the same
/// time.
pub fn own_address(test: u8) -> Ipv4Addr {
    let process = std::process::id();
    Ipv4Addr::new(127, test, (process >> 8) as u8, (process as u8).clamp(1, 254))
}

/// The command that publishes.
pub fn publish(config: &Path, address: Ipv4Addr) -> Command {
    let mut command = Command::new(program::path());
    command.arg("publish").arg(config).args(["--listen", &address.to_string(), "--backend", "cpu"]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Publishes and waits until the head has introduced itself.
pub fn published(config: &Path, address: Ipv4Addr) -> Published {
    let mut program = publish(config, address).stderr(Stdio::null()).spawn().unwrap();
    let mut words = Vec::new();
    for line in BufReader::new(program.stdout.take().unwrap()).lines().map_while(Result::ok) {
        words.push(line);
        if words.last().is_some_and(|line| line.starts_with("Ctrl-C")) {
            return Published { program, words, address };
        }
    }
    let _ = (program.kill(), program.wait());
    panic!("the head does not start: {words:?}");
}
