//! The tables, as migrations: the schema of a store is the number of those it has.

/// Marks a SQLite file as a store: "SGau".
pub(super) const APPLICATION_ID: i64 = 0x5347_6175;

/// SQL of each migration, in their order; one that was published is never altered.
///
/// Stations have no row id: those of a pass lie together, in the order of the part, and are found
/// by the time of their pass. Numbers are 64-bit floats as measured; gaps have their reason.
pub(super) const MIGRATIONS: [&str; 1] = ["
    CREATE TABLE entries (
        kind TEXT NOT NULL,
        key TEXT NOT NULL,
        utc_ms INTEGER NOT NULL,
        document TEXT NOT NULL,
        PRIMARY KEY (kind, key)
    ) STRICT, WITHOUT ROWID;

    CREATE TABLE runs (
        id INTEGER PRIMARY KEY,
        key TEXT NOT NULL UNIQUE,
        origin TEXT NOT NULL,
        name TEXT NOT NULL,
        part TEXT,
        tool TEXT,
        calibration TEXT,
        utc_ms INTEGER NOT NULL,
        config TEXT NOT NULL
    ) STRICT;
    CREATE INDEX runs_by_time ON runs (utc_ms);

    CREATE TABLE passes (
        id INTEGER PRIMARY KEY,
        run INTEGER NOT NULL REFERENCES runs (id),
        pass INTEGER NOT NULL,
        name TEXT,
        utc_ms INTEGER NOT NULL,
        digest TEXT NOT NULL,
        max_abs_error_mm REAL,
        UNIQUE (run, pass)
    ) STRICT;
    CREATE INDEX passes_by_time ON passes (utc_ms);

    CREATE TABLE stations (
        pass INTEGER NOT NULL REFERENCES passes (id),
        station INTEGER NOT NULL,
        z_mm REAL,
        nominal_mm REAL,
        d_mm REAL,
        u_mm REAL,
        flag TEXT,
        PRIMARY KEY (pass, station)
    ) STRICT, WITHOUT ROWID;

    CREATE TABLE decisions (
        pass INTEGER PRIMARY KEY REFERENCES passes (id),
        decision TEXT NOT NULL,
        reason TEXT NOT NULL,
        offsets_mm TEXT NOT NULL
    ) STRICT;

    CREATE TABLE alarms (
        id INTEGER PRIMARY KEY,
        pass INTEGER REFERENCES passes (id),
        utc_ms INTEGER NOT NULL,
        words TEXT NOT NULL
    ) STRICT;

    CREATE TABLE audit (
        seq INTEGER PRIMARY KEY,
        utc_ms INTEGER NOT NULL,
        who TEXT NOT NULL,
        what TEXT NOT NULL,
        key TEXT NOT NULL,
        old TEXT,
        new TEXT,
        hash TEXT NOT NULL
    ) STRICT;
"];

/// The newest schema known.
pub(super) fn newest() -> i64 {
    MIGRATIONS.len().cast_signed() as i64
}
