//! A shard's Parquet file: a row a scene, and in its key-value metadata what it is a shard of.

use std::path::Path;
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::record::{Field, Row};
use parquet::schema::parser::parse_message_type;

use crate::cli::failure::Failure;
use crate::studies::sharding::{Cell, ColumnKind, Columns, Identity, Shard, ShardOf};

/// What every key of the metadata begins with.
const KEY: &str = "shadowgauge.";

/// The schema of a study's shards.
fn schema(study: &str, columns: Columns) -> String {
    let column = |(name, kind): &(&str, ColumnKind)| match kind {
        ColumnKind::Text => format!("REQUIRED BYTE_ARRAY {name} (UTF8);"),
        ColumnKind::Int => format!("REQUIRED INT64 {name};"),
        ColumnKind::Bool => format!("REQUIRED BOOLEAN {name};"),
        ColumnKind::Double => format!("OPTIONAL DOUBLE {name};"),
    };
    let columns: Vec<String> = columns.iter().map(column).collect();
    format!("message {study} {{ REQUIRED INT64 scene; {} }}", columns.join(" "))
}

fn metadata(identity: &Identity) -> Vec<KeyValue> {
    let pair = |key: &str, value: String| KeyValue::new(format!("{KEY}{key}"), value);
    vec![
        pair("study", identity.study.clone()),
        pair("version", identity.version.clone()),
        pair("config", identity.settings.clone()),
        pair("config_sha256", identity.settings_sha256.clone()),
        pair("seed", identity.seed.to_string()),
        pair("scenes", identity.scenes.to_string()),
        pair("shard", identity.shard.number.to_string()),
        pair("shards", identity.shard.of.to_string()),
    ]
}

/// The file's bytes.
///
/// # Errors
/// Rows that do not follow the columns.
pub(super) fn encode(columns: Columns, shard: &Shard) -> Result<Vec<u8>, ParquetError> {
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(metadata(&shard.identity)))
        .build();
    let schema = Arc::new(parse_message_type(&schema(&shard.identity.study, columns))?);
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    let mut column = None;
    while let Some(mut target) = group.next_column()? {
        let number = |(number, _): &(u64, Vec<Cell>)| Cell::Int(number.cast_signed());
        match column {
            None => put(target.untyped(), &mut shard.rows.iter().map(number))?,
            Some(at) => {
                let mut cells = shard.rows.iter().filter_map(|(_, row)| row.get::<usize>(at).cloned());
                put(target.untyped(), &mut cells)?;
            }
        }
        target.close()?;
        column = Some(column.map_or(0, |at| at + 1));
    }
    group.close()?;
    writer.into_inner()
}

/// Writes the cells of a column.
fn put(into: &mut ColumnWriter<'_>, cells: &mut dyn Iterator<Item = Cell>) -> Result<(), ParquetError> {
    let foreign = |cell: &Cell| ParquetError::General(format!("a column has a cell of {:?}", cell.kind()));
    macro_rules! all {
        ($kind:pat => $value:expr) => {
            cells
                .map(|cell| match cell {
                    $kind => Ok($value),
                    other => Err(foreign(&other)),
                })
                .collect::<Result<Vec<_>, _>>()?
        };
    }
    match into {
        ColumnWriter::ByteArrayColumnWriter(w) => {
            let values = all!(Cell::Text(text) => ByteArray::from(text.as_str()));
            w.write_batch(&values, None, None)?;
        }
        ColumnWriter::Int64ColumnWriter(w) => {
            let values = all!(Cell::Int(value) => value);
            w.write_batch(&values, None, None)?;
        }
        ColumnWriter::BoolColumnWriter(w) => {
            let values = all!(Cell::Bool(value) => value);
            w.write_batch(&values, None, None)?;
        }
        ColumnWriter::DoubleColumnWriter(w) => {
            let values = all!(Cell::Double(value) => value);
            let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
            let given: Vec<f64> = values.into_iter().flatten().collect();
            w.write_batch(&given, Some(&levels), None)?;
        }
        _ => return Err(ParquetError::General("a column of a type that no shard has".to_owned())),
    }
    Ok(())
}

/// Reads a shard.
///
/// # Errors
/// Exit 3 for a file that cannot be read; 2 for one that is no shard.
pub(crate) fn read(path: &Path) -> Result<Shard, Failure> {
    let name = path.display();
    let file =
        std::fs::File::open(path).map_err(|e| Failure::fail(format!("{name}: cannot be read: {e}")))?;
    let no_shard = |why: &dyn std::fmt::Display| {
        Failure::refuse(format!("{name} is no shard of a study ({why}): --shard I/N writes them; remove it"))
    };
    let reader = SerializedFileReader::new(file).map_err(|e| no_shard(&e))?;
    let identity = identity(&reader).map_err(|e| no_shard(&e))?;
    let rows = reader.get_row_iter(None).map_err(|e| no_shard(&e))?;
    let rows =
        rows.map(|row| row.map_err(|e| no_shard(&e)).and_then(|row| cells(&row).map_err(|e| no_shard(&e))));
    Ok(Shard { file: name.to_string(), identity, rows: rows.collect::<Result<_, _>>()? })
}

fn identity(reader: &SerializedFileReader<std::fs::File>) -> Result<Identity, String> {
    let pairs = reader.metadata().file_metadata().key_value_metadata();
    let text = |key: &str| -> Result<String, String> {
        let wanted = format!("{KEY}{key}");
        let pair = pairs.into_iter().flatten().find(|pair| pair.key == wanted);
        pair.and_then(|pair| pair.value.clone()).ok_or_else(|| format!("its metadata has no {wanted}"))
    };
    let number = |key: &str| -> Result<u64, String> {
        text(key)?.parse().map_err(|_| format!("its metadata has no number as {KEY}{key}"))
    };
    let shard = format!("{}/{}", number("shard")?, number("shards")?);
    Ok(Identity {
        study: text("study")?,
        version: text("version")?,
        settings: text("config")?,
        settings_sha256: text("config_sha256")?,
        seed: number("seed")?,
        scenes: number("scenes")?,
        shard: shard.parse::<ShardOf>()?,
    })
}

/// A row: the scene's number and the cells of its outcome.
fn cells(row: &Row) -> Result<(u64, Vec<Cell>), String> {
    let mut columns = row.get_column_iter();
    let number = match columns.next() {
        Some((_, Field::Long(number))) => u64::try_from(*number).ok(),
        _ => None,
    };
    let number = number.ok_or("its first column has no scene's number")?;
    let cell = |(name, field): (&String, &Field)| match field {
        Field::Str(text) => Ok(Cell::Text(text.clone())),
        Field::Long(value) => Ok(Cell::Int(*value)),
        Field::Bool(value) => Ok(Cell::Bool(*value)),
        Field::Double(value) => Ok(Cell::Double(Some(*value))),
        Field::Null => Ok(Cell::Double(None)),
        _ => Err(format!("its column {name} has a type that no shard has")),
    };
    Ok((number, columns.map(cell).collect::<Result<_, _>>()?))
}
