//! The columnar tables of a run folder, for pandas, polars, DuckDB: `diameters.parquet` and
//! `truth.parquet`.

use std::sync::Arc;

use parquet::basic::Compression;
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::record::RowAccessor;
use parquet::schema::parser::parse_message_type;

use super::folder::{RunFolder, RunFolderError};

const DIAMETERS: &str = "message diameters { REQUIRED BYTE_ARRAY run_id (UTF8); REQUIRED INT32 pass; REQUIRED INT64 frame_id;
  REQUIRED INT64 t_ns; REQUIRED DOUBLE z_mm; REQUIRED DOUBLE angle_deg; REQUIRED DOUBLE d_mm; REQUIRED DOUBLE u_random_mm;
  REQUIRED DOUBLE u_common_mm; REQUIRED BYTE_ARRAY flag (UTF8); }";
const TRUTH: &str = "message truth { REQUIRED BYTE_ARRAY run_id (UTF8); REQUIRED INT32 pass; REQUIRED DOUBLE z_mm; REQUIRED DOUBLE d_mm; }";

/// A row of `diameters.parquet`: the mean caliper diameter of a short z interval in one frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DiameterRow {
    /// Pass, from 1.
    pub pass: u32,
    /// Frame it comes from.
    pub frame_id: u64,
    /// Start of the frame's exposure on the device's clock, ns.
    pub t_ns: u64,
    /// Middle of the interval, mm.
    pub z_mm: f64,
    /// Spindle angle, degrees.
    pub angle_deg: f64,
    /// Diameter, mm; NaN for a gap.
    pub d_mm: f64,
    /// Random standard uncertainty, mm; NaN for a gap.
    pub u_random_mm: f64,
    /// Common standard uncertainty, mm; NaN for a gap.
    pub u_common_mm: f64,
    /// Reason of a gap, empty for a value.
    pub flag: String,
}

/// A row of `truth.parquet`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TruthRow {
    /// Pass, from 1.
    pub pass: u32,
    /// Middle of the station, mm.
    pub z_mm: f64,
    /// True mean caliper diameter of the station, mm.
    pub d_mm: f64,
}

/// A column of a table, in schema order.
enum Column {
    Text(Vec<ByteArray>),
    Int32(Vec<i32>),
    Int64(Vec<i64>),
    Double(Vec<f64>),
}

impl RunFolder {
    /// Writes `diameters.parquet` with all rows so far.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub(crate) fn write_diameters(&self, run_id: &str, rows: &[DiameterRow]) -> Result<(), RunFolderError> {
        let text = |f: &dyn Fn(&DiameterRow) -> ByteArray| Column::Text(rows.iter().map(f).collect());
        let double = |f: &dyn Fn(&DiameterRow) -> f64| Column::Double(rows.iter().map(f).collect());
        let columns = [
            text(&|_| ByteArray::from(run_id)),
            Column::Int32(rows.iter().map(|r| r.pass.cast_signed()).collect()),
            Column::Int64(rows.iter().map(|r| r.frame_id.cast_signed()).collect()),
            Column::Int64(rows.iter().map(|r| r.t_ns.cast_signed()).collect()),
            double(&|r| r.z_mm),
            double(&|r| r.angle_deg),
            double(&|r| r.d_mm),
            double(&|r| r.u_random_mm),
            double(&|r| r.u_common_mm),
            text(&|r| ByteArray::from(r.flag.as_str())),
        ];
        self.write_table("diameters.parquet", DIAMETERS, &columns)
    }

    /// Writes `truth.parquet`.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub(crate) fn write_truth(&self, run_id: &str, rows: &[TruthRow]) -> Result<(), RunFolderError> {
        let columns = [
            Column::Text(rows.iter().map(|_| ByteArray::from(run_id)).collect()),
            Column::Int32(rows.iter().map(|r| r.pass.cast_signed()).collect()),
            Column::Double(rows.iter().map(|r| r.z_mm).collect()),
            Column::Double(rows.iter().map(|r| r.d_mm).collect()),
        ];
        self.write_table("truth.parquet", TRUTH, &columns)
    }

    fn write_table(&self, name: &str, schema: &str, columns: &[Column]) -> Result<(), RunFolderError> {
        let bytes = encode(schema, columns).map_err(|e| RunFolderError::Write {
            path: self.path().join(name),
            cause: std::io::Error::other(e),
        })?;
        self.write(name, &bytes)
    }
}

fn encode(schema: &str, columns: &[Column]) -> Result<Vec<u8>, parquet::errors::ParquetError> {
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer =
        SerializedFileWriter::new(Vec::new(), Arc::new(parse_message_type(schema)?), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    let mut columns = columns.iter();
    while let Some(mut target) = group.next_column()? {
        match (target.untyped(), columns.next()) {
            (ColumnWriter::ByteArrayColumnWriter(w), Some(Column::Text(values))) => {
                w.write_batch(values, None, None)?
            }
            (ColumnWriter::Int32ColumnWriter(w), Some(Column::Int32(values))) => {
                w.write_batch(values, None, None)?
            }
            (ColumnWriter::Int64ColumnWriter(w), Some(Column::Int64(values))) => {
                w.write_batch(values, None, None)?
            }
            (ColumnWriter::DoubleColumnWriter(w), Some(Column::Double(values))) => {
                w.write_batch(values, None, None)?
            }
            _ => {
                return Err(parquet::errors::ParquetError::General(
                    "the columns do not follow the schema".to_owned(),
                ));
            }
        };
        target.close()?;
    }
    group.close()?;
    writer.into_inner()
}

/// Reads `diameters.parquet`; empty where no pass is finished.
///
/// # Errors
/// Where it cannot be read.
pub(crate) fn read_diameters(folder: &RunFolder) -> Result<Vec<DiameterRow>, RunFolderError> {
    let path = folder.path().join("diameters.parquet");
    if !path.exists() {
        return Ok(Vec::new());
    }
    let failed = |cause: String| RunFolderError::Read { path: path.clone(), cause };
    let file = std::fs::File::open(&path).map_err(|e| failed(e.to_string()))?;
    let reader = SerializedFileReader::new(file).map_err(|e| failed(e.to_string()))?;
    let rows = reader.get_row_iter(None).map_err(|e| failed(e.to_string()))?;
    rows.map(|row| {
        let row = row?;
        Ok(DiameterRow {
            pass: row.get_int(1)?.cast_unsigned(),
            frame_id: row.get_long(2)?.cast_unsigned(),
            t_ns: row.get_long(3)?.cast_unsigned(),
            z_mm: row.get_double(4)?,
            angle_deg: row.get_double(5)?,
            d_mm: row.get_double(6)?,
            u_random_mm: row.get_double(7)?,
            u_common_mm: row.get_double(8)?,
            flag: row.get_string(9)?.clone(),
        })
    })
    .collect::<Result<_, parquet::errors::ParquetError>>()
    .map_err(|e| failed(e.to_string()))
}
