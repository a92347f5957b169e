//! Tables of text with names in their first row, as programs and spreadsheets write them.
//!
//! Separated by commas, semicolons or tabs; decimal points, or decimal commas where they do not
//! separate; any line ending; UTF-8 with or without a byte order mark, UTF-16 with one, or Latin-1;
//! quoted fields; Excel's `sep=` line; lines that begin with `#` where a table has comments. What
//! a column means, and which of them a table must have, is its reader's affair.
//!
//! `dialect` makes records of a text, `named` a table of records whose columns have names, `plain`
//! one whose columns go by their order. One more dialect is a line in `dialect`.

mod dialect;
mod named;
mod plain;

pub(crate) use self::dialect::{Comments, TextTableError, number};
pub(crate) use self::named::{Cells, TextTable};
pub(crate) use self::plain::{PlainRow, plain_rows};
