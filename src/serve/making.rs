//! Numbers of the programs that are being made.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use crate::store::Utc;

/// Those that are being made.
#[derive(Debug, Default)]
pub(super) struct Making(Mutex<BTreeSet<String>>);

impl Making {
    fn with<T>(&self, act: impl FnOnce(&mut BTreeSet<String>) -> T) -> T {
        act(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// A new number: the time with a count, so that their order is that of time.
    pub(super) fn begin(&self) -> String {
        let now = Utc::now().0;
        self.with(|all| {
            let mut numbers = (0..).map(|k: usize| format!("{now:012x}-{k}"));
            let id = numbers.find(|id| !all.contains(id)).unwrap_or_default();
            all.insert(id.clone());
            id
        })
    }

    pub(super) fn end(&self, id: &str) {
        self.with(|all| all.remove(id));
    }

    pub(super) fn contains(&self, id: &str) -> bool {
        self.with(|all| all.contains(id))
    }
}
