//! The words by which each control is given the radius of a nose, starts its compensation, and
//! drives an arc.
//!
//! - Fanuc: the radius goes into the geometry of the tool's offset (G10 P10000 + n, R, Q), the wear
//!   radius, which adds to it, is set to zero.
//! - LinuxCNC: G41.1 and G42.1 take the diameter and the tip direction with them and leave the tool
//!   table alone.
//! - GSK 980TDi: no word for it is known that holds on every version, so the program states what
//!   must stand on the tool's page: R, the tip direction (T), no wear. Its compensation starts and
//!   ends in G00 or G01, never on an arc. After the maker's manual, not checked on a control.
//! - SINUMERIK: position, radius and wear of the radius of the cutting edge stand in `$TC_DP2`,
//!   `$TC_DP6` and `$TC_DP15` of tool and edge; they act from the next call of the tool on. `NORM`
//!   begins and ends at right angles, `G451` extends the offset lines at outer corners to where
//!   they intersect. An arc takes its radius in `CR=`. From the maker's programming guides as
//!   commonly used, not checked on a control.

use super::dialect::{Dialect, number};
use super::sinumerik;
use crate::nose::{Numbering, TipDirection};

/// The register of a nose for the control's compensation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NoseRegister {
    /// Radius R, mm.
    pub radius_mm: f64,
    /// Tip direction.
    pub tip: TipDirection,
}

/// Blocks that write the register of tool `tool`, before it is called.
pub(super) fn writing(d: Dialect, tool: u32, register: NoseRegister) -> Vec<String> {
    let radius = number(register.radius_mm, d.x_decimals());
    let tip = register.tip.number(Numbering::Fanuc);
    match d {
        Dialect::Fanuc => vec![
            d.comment("geometry radius and tip, the wear radius adds to it"),
            format!("G10 P{} R{radius} Q{tip}", 10_000 + tool),
            format!("G10 P{tool} R0."),
        ],
        Dialect::Sinumerik => vec![
            d.comment("position and radius of the edge, the radius wear adds to it"),
            "STOPRE".to_owned(),
            // a centre is position 9: there is no 0
            format!("$TC_DP2[{tool},1]={}", if tip == 0 { 9 } else { tip }),
            format!("$TC_DP6[{tool},1]={}", sinumerik::value(&radius)),
            format!("$TC_DP15[{tool},1]=0"),
            "G451 NORM".to_owned(),
        ],
        Dialect::Linuxcnc | Dialect::Gsk => Vec::new(),
    }
}

/// What must stand on the tool's page before a program starts; none where the program itself gives
/// the control radius and tip.
pub(super) fn on_tool_page(d: Dialect, register: Option<NoseRegister>) -> Option<NoseRegister> {
    let scale = 10f64.powi(d.x_decimals() as i32);
    let rounded = |r: NoseRegister| NoseRegister { radius_mm: (r.radius_mm * scale).round() / scale, ..r };
    register.filter(|_| d == Dialect::Gsk).map(rounded)
}

/// The same in words, for the head of the program.
pub(super) fn tool_page_words(d: Dialect, tool: u32, register: NoseRegister) -> [String; 2] {
    let radius = number(register.radius_mm, d.x_decimals());
    let tip = register.tip.number(Numbering::Fanuc);
    [
        format!("tool page, set by hand: offset {tool:02}, R {radius}, T {tip}, no wear of R"),
        "no block writes or checks them: with another R or T the part is wrong".to_owned(),
    ]
}

/// Words that start the compensation, the tool on the right or on the left of the contour.
pub(super) fn start(d: Dialect, right: bool, register: NoseRegister) -> String {
    let side = if right { "G42" } else { "G41" };
    match d {
        Dialect::Linuxcnc => {
            let tip = register.tip.number(Numbering::Linuxcnc);
            format!("{side}.1 D{} L{tip} ", number(2.0 * register.radius_mm, d.x_decimals()))
        }
        _ => format!("{side} "),
    }
}

/// The radius of an arc, a blank before it.
pub(super) fn arc_radius(d: Dialect, radius_mm: f64) -> String {
    let radius = number(radius_mm, d.x_decimals());
    match d {
        Dialect::Sinumerik => format!(" CR={}", sinumerik::value(&radius)),
        _ => format!(" R{radius}"),
    }
}
