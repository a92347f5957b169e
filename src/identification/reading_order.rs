//! Whether the positions of each run are those of its direction.

use super::reading::Row;
use crate::machine::conditions::Direction;

/// Refuses runs whose positions are not in the order of their direction: two directions in one run,
/// a direction with the wrong name, shuffled rows, a position twice.
pub(super) fn check_order(rows: &[Row]) -> Result<(), String> {
    let mut begun: Vec<&Row> = Vec::new();
    for row in rows {
        if !begun.iter().any(|first| same_run(first, row)) {
            begun.push(row);
            run_order(rows.iter().filter(|other| same_run(other, row)))?;
        }
    }
    Ok(())
}

/// Whether two rows are of one run, at one angle.
fn same_run(a: &Row, b: &Row) -> bool {
    let key = |row: &Row| (row.reading.quantity, row.reading.direction, row.reading.run, row.reading.setup);
    key(a) == key(b) && a.angle_deg == b.angle_deg
}

fn run_order<'a>(rows: impl Iterator<Item = &'a Row>) -> Result<(), String> {
    let rows: Vec<&Row> = rows.collect();
    let sign = |row: &Row| if row.reading.direction == Direction::Forward { 1.0 } else { -1.0 };
    let steps: Vec<f64> = rows
        .windows(2)
        .map(|pair| sign(pair[0]) * (pair[1].reading.position_mm - pair[0].reading.position_mm))
        .collect();
    let Some(k) = steps.iter().position(|step| !(*step > 0.0)) else { return Ok(()) };
    let (before, here) = (rows[k].reading, rows[k + 1].reading);
    let name = if here.direction == Direction::Forward { "forward" } else { "backward" };
    let place = format!(
        "line {}: {} run {} {name}: position {} mm after {} mm",
        here.line,
        here.quantity.word(),
        here.run,
        here.position_mm,
        before.position_mm
    );
    let turns = steps[k + 1..].iter().all(|step| *step < 0.0);
    Err(if steps[k] == 0.0 {
        format!("{place}: each position once a run; readings that are repeated are a run more")
    } else if k == 0 && turns {
        format!("{place}: the positions run the other way: is the direction the opposite one?")
    } else if turns {
        format!("{place}: two directions are mixed: the way back needs the other direction in its column")
    } else {
        let word = if here.direction == Direction::Forward { "ascend" } else { "descend" };
        format!("{place}: rows are shuffled or steps not monotone: positions of this run must {word}")
    })
}
