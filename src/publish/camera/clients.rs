//! Who is in control, and what was answered last to whom.

use std::net::SocketAddrV4;

/// Who may read and write besides the client in control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Privilege {
    /// Others read.
    Control,
    /// Others only find it.
    Exclusive,
}

impl Privilege {
    /// From the register: exclusive has precedence; `None` gives control up.
    pub(crate) fn from_register(value: u32) -> Option<Self> {
        match value {
            0 => None,
            value if value & 1 != 0 => Some(Self::Exclusive),
            _ => Some(Self::Control),
        }
    }
}

/// The client in control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Controller {
    /// Where its commands come from.
    pub client: SocketAddrV4,
    /// What it took.
    pub privilege: Privilege,
    /// Time of its last command, ns.
    pub heard_ns: u64,
}

/// Clients whose last command is kept.
const MOST_CLIENTS: usize = 16;
/// Time after which a command with the same bytes is a new one, ns: clients repeat within a second.
const REPEATS_WITHIN_NS: u64 = 5_000_000_000;

#[derive(Clone, Debug)]
struct Answered {
    client: SocketAddrV4,
    at_ns: u64,
    command: Vec<u8>,
    answer: Option<Vec<u8>>,
}

/// The last command of every client with its answer: one that comes again was lost on the way, and
/// is answered again without being executed again.
#[derive(Clone, Debug, Default)]
pub(crate) struct LastAnswers(Vec<Answered>);

impl LastAnswers {
    /// The answer to a command that was just executed for the same client.
    pub(crate) fn repeated(
        &self,
        client: SocketAddrV4,
        command: &[u8],
        now_ns: u64,
    ) -> Option<Option<Vec<u8>>> {
        let same = |known: &&Answered| {
            known.client == client
                && known.command == command
                && now_ns.saturating_sub(known.at_ns) < REPEATS_WITHIN_NS
        };
        self.0.iter().find(same).map(|known| known.answer.clone())
    }

    /// Keeps an answer; the oldest of too many clients is forgotten.
    pub(crate) fn keep(&mut self, client: SocketAddrV4, now_ns: u64, command: &[u8], answer: Option<&[u8]>) {
        self.0.retain(|known| known.client != client);
        if self.0.len() >= MOST_CLIENTS {
            self.0.remove(0);
        }
        let (command, answer) = (command.to_vec(), answer.map(<[u8]>::to_vec));
        self.0.push(Answered { client, at_ns: now_ns, command, answer });
    }
}
