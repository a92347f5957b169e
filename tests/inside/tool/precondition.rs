//! The cut that is corrected against the pass after which the nose was measured, and the place
//! where a path gouges, by the program.

use crate::plan::CuttingData;
use crate::tool::MeasuredPass;

const PASS: MeasuredPass =
    MeasuredPass { speed_m_per_min: 180.0, feed_mm_per_rev: 0.08, depth_mm: Some(0.2) };

fn cut(speed_m_per_min: f64, feed_mm_per_rev: f64) -> CuttingData {
    CuttingData { speed_m_per_min, feed_mm_per_rev }
}

#[test]
fn a_correction_holds_for_the_same_speed_feed_and_depth() {
    let depth = |mm: f64| Some(("depth_mm", mm));
    assert_eq!(PASS.allows(&cut(180.0, 0.08), depth(0.2)), Ok(()));
    // a thousandth, as the controllers' guards allow
    assert_eq!(PASS.allows(&cut(180.1, 0.08), depth(0.2005)), Ok(()));
    assert_eq!(PASS.allows(&cut(180.0, 0.08), None), Ok(()));
    let said = |cutting: CuttingData, mm: f64| PASS.allows(&cutting, depth(mm)).unwrap_err().to_string();
    let speed = said(cut(200.0, 0.08), 0.2);
    assert!(speed.contains("cutting.speed_m_per_min = 200") && speed.contains("180 m/min"), "{speed}");
    let feed = said(cut(180.0, 0.1), 0.2);
    assert!(feed.contains("cutting.feed_mm_per_rev = 0.1") && feed.contains("0.08 mm per"), "{feed}");
    let deep = said(cut(180.0, 0.08), 0.25);
    assert!(deep.contains("depth_mm") && deep.contains("0.2500 mm") && deep.contains("0.2 mm"), "{deep}");
    let none = MeasuredPass { depth_mm: None, ..PASS };
    assert_eq!(none.allows(&cut(180.0, 0.08), depth(9.0)), Ok(()));
    let wrong = MeasuredPass { feed_mm_per_rev: -1.0, ..PASS };
    assert!(wrong.validate().unwrap_err().to_string().contains("measured_pass.feed_mm_per_rev"));
}
