//! Old passes, taken out; what was done stays in the audit.

use rusqlite::params;

use super::audit;
use super::database::{Store, classified};
use super::error::StoreError;
use super::row::Change;
use super::utc::Utc;

/// What `prune` writes into the audit, and what `check` finds there.
pub(super) const PRUNE: &str = "prune";

impl Store {
    /// Takes out the passes stored before an instant, and runs that have none left. Documents
    /// and the audit stay; the audit gets a row that states what went.
    ///
    /// # Errors
    /// A store that is busy, full or damaged: nothing is taken out then.
    pub(crate) fn prune(&mut self, before: Utc) -> Result<usize, StoreError> {
        let (path, who) = (self.path.clone(), self.who.clone());
        let change = self.change()?;
        let prune = || {
            for table in ["stations", "decisions", "alarms"] {
                let sql =
                    format!("DELETE FROM {table} WHERE pass IN (SELECT id FROM passes WHERE utc_ms < ?1)");
                change.execute(&sql, params![before.0])?;
            }
            let passes = change.execute("DELETE FROM passes WHERE utc_ms < ?1", params![before.0])?;
            let empty = "DELETE FROM runs WHERE utc_ms < ?1 AND id NOT IN (SELECT run FROM passes)";
            let runs = change.execute(empty, params![before.0])?;
            let (key, utc) = (before.0.to_string(), Utc::now());
            let new = format!("{{\"passes\":{passes},\"runs\":{runs}}}");
            let row = Change { utc, who: &who, what: PRUNE, key: &key, old: None, new: Some(&new) };
            audit::add(&change, &row)?;
            Ok(passes)
        };
        let pruned = prune().map_err(|e: rusqlite::Error| classified(&path, &e))?;
        change.commit().map_err(|e| classified(&path, &e))?;
        // gives the space back to the disk
        self.db.execute_batch("VACUUM").map_err(|e| self.failure(&e))?;
        Ok(pruned)
    }
}
