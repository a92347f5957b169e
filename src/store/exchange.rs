//! A store as JSON Lines and back: every row of every table, its columns by name; the audit
//! included, so that what is read in elsewhere is held to the same chain.

use std::io::{BufRead, Write};
use std::path::Path;

use rusqlite::types::{Value as Cell, ValueRef};
use rusqlite::{Connection, params_from_iter};
use serde_json::{Map, Value, json};

use super::database::{Store, classified};
use super::error::StoreError;
use super::schema::newest;

/// The tables, each after those that it refers to.
const TABLES: [&str; 7] = ["entries", "runs", "passes", "stations", "decisions", "alarms", "audit"];

/// Key of the first line.
const HEADER: &str = "shadowgauge_store";

impl Store {
    /// Writes every row as a line.
    ///
    /// # Errors
    /// `out` that cannot be written, a store that is damaged.
    pub(crate) fn export(&mut self, out: &mut dyn Write) -> Result<(), StoreError> {
        let path = self.path.clone();
        // one state of all tables, whatever others write meanwhile
        let view = self.db.transaction().map_err(|e| classified(&path, &e))?;
        let failed = |cause: String| StoreError::Database { path: path.clone(), cause };
        writeln!(out, "{}", json!({ HEADER: newest() })).map_err(|e| failed(e.to_string()))?;
        for table in TABLES {
            export_table(&view, table, out).map_err(&failed)?;
        }
        out.flush().map_err(|e| failed(e.to_string()))
    }

    /// Reads an export into this store, which is new.
    ///
    /// # Errors
    /// A store that holds something; a line that is no row of an export, with its number: nothing
    /// is stored then.
    pub(crate) fn import(&mut self, from: &mut dyn BufRead, name: &Path) -> Result<usize, StoreError> {
        let path = self.path.clone();
        if super::audit::head(&self.db).map_err(|e| self.failure(&e))?.0 != 0 {
            let what = "it holds a history of its own; an export is read into a new file".to_owned();
            return Err(StoreError::Foreign { path, what });
        }
        let change = self.change()?;
        let mut rows = 0;
        for (k, line) in from.lines().enumerate() {
            let wrong = |what: String| StoreError::Line { path: name.to_path_buf(), line: k + 1, what };
            let line = line.map_err(|e| wrong(e.to_string()))?;
            let value: Value = serde_json::from_str(&line).map_err(|e| wrong(e.to_string()))?;
            if k == 0 {
                check_header(&value).map_err(wrong)?;
                continue;
            }
            import_row(&change, &value).map_err(wrong)?;
            rows += 1;
        }
        if rows == 0 {
            let what = "no row of a store".to_owned();
            return Err(StoreError::Line { path: name.to_path_buf(), line: 1, what });
        }
        change.commit().map_err(|e| classified(&path, &e))?;
        Ok(rows)
    }
}

fn check_header(value: &Value) -> Result<(), String> {
    match value.get(HEADER).and_then(Value::as_i64) {
        Some(schema) if schema == newest() => Ok(()),
        Some(schema) => Err(format!("an export of schema {schema}; this program reads schema {}", newest())),
        None => Err(format!("no export of a store: its first line would have the key {HEADER:?}")),
    }
}

fn export_table(db: &Connection, table: &str, out: &mut dyn Write) -> Result<(), String> {
    let text = |e: rusqlite::Error| e.to_string();
    let mut query = db.prepare(&format!("SELECT * FROM {table}")).map_err(text)?;
    let names: Vec<String> = query.column_names().map(str::to_owned).collect();
    let mut rows = query.query([]).map_err(text)?;
    while let Some(row) = rows.next().map_err(text)? {
        let mut columns = Map::new();
        for (k, name) in names.iter().enumerate() {
            columns.insert(name.clone(), json_of(row.get_ref(k).map_err(text)?));
        }
        writeln!(out, "{}", json!({ "table": table, "row": columns })).map_err(|e| e.to_string())?;
    }
    Ok(())
}

fn json_of(cell: ValueRef<'_>) -> Value {
    match cell {
        ValueRef::Integer(value) => value.into(),
        ValueRef::Real(value) => value.into(),
        ValueRef::Text(text) => String::from_utf8_lossy(text).into_owned().into(),
        ValueRef::Null | ValueRef::Blob(_) => Value::Null,
    }
}

fn cell_of(value: &Value) -> Result<Cell, String> {
    match value {
        Value::Null => Ok(Cell::Null),
        Value::String(text) => Ok(Cell::Text(text.clone())),
        Value::Number(number) if number.is_f64() => Ok(Cell::Real(number.as_f64().unwrap_or_default())),
        Value::Number(number) => {
            number.as_i64().map(Cell::Integer).ok_or_else(|| format!("{number} is too large"))
        }
        other => Err(format!("{other} is no value of a column")),
    }
}

fn import_row(db: &Connection, value: &Value) -> Result<(), String> {
    let table = value.get("table").and_then(Value::as_str).unwrap_or_default();
    let (Some(table), Some(row)) =
        (TABLES.into_iter().find(|t| *t == table), value.get("row").and_then(Value::as_object))
    else {
        return Err("no row of an export: it would be {\"table\": …, \"row\": {…}}".into());
    };
    let known = columns(db, table).map_err(|e| e.to_string())?;
    if let Some(unknown) = row.keys().find(|name| !known.contains(name)) {
        return Err(format!("{table} has no column {unknown:?}"));
    }
    let names = row.keys().cloned().collect::<Vec<_>>().join(", ");
    let places = vec!["?"; row.len()].join(", ");
    let cells = row.values().map(cell_of).collect::<Result<Vec<_>, _>>()?;
    let sql = format!("INSERT INTO {table} ({names}) VALUES ({places})");
    let inserted = db.prepare_cached(&sql).and_then(|mut insert| insert.execute(params_from_iter(cells)));
    inserted.map(|_| ()).map_err(|e| format!("{table}: {e}"))
}

fn columns(db: &Connection, table: &str) -> rusqlite::Result<Vec<String>> {
    let mut query = db.prepare_cached("SELECT name FROM pragma_table_info(?1)")?;
    let names = query.query_map([table], |row| row.get(0))?;
    names.collect()
}
