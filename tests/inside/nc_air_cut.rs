//! Air cuts: the moves of the pass, above the stock, in every dialect.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use shadowgauge::nc::replay::{self, Control, Deed, Point};
use shadowgauge::nc::{
    AirCut, Dialect, GeometryOffset, NcSettings, Spindle, TurningProgram, WearX, Workpiece,
};
use shadowgauge::plan::{CuttingData, DiameterOffset, PassPlan, PlannedForm};

const CUTTING: CuttingData = CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 };
const STOCK_MM: f64 = 12.0;
const TRIAL_MM: f64 = 0.05;

fn settings() -> NcSettings {
    NcSettings {
        wear_x: Some(WearX::Radius),
        geometry_offset: Some(GeometryOffset::ByTool),
        spindle: Some(Spindle::M03),
        ..NcSettings::default()
    }
}

/// A pass with a trial's offsets: every diameter 50 µm larger.
fn trial() -> PassPlan {
    let station_z_mm: Vec<f64> = (0..12).map(|i| 2.5 + 5.0 * f64::from(i)).collect();
    let offset = DiameterOffset { o_mm: vec![-TRIAL_MM; 12] };
    PassPlan { pass: 2, nominal_mm: 11.0, cutting: CUTTING, station_z_mm, offset, form: PlannedForm::PLAIN }
}

/// Feeds of a program: start and end of each, from one start position.
fn feeds(text: &str, dialect: Dialect, settings: &NcSettings, change: Point) -> Vec<(Point, Point)> {
    let control = Control {
        dialect,
        settings,
        start: change,
        reference: change,
        variables: vec![(820, 0.0)],
        with_probe: false,
        surface: None,
        tool_page: None,
    };
    let events = replay::run(text, &control).unwrap_or_else(|e| panic!("{dialect:?} {e:?}\n{text}"));
    let feed = |deed: Deed| match deed {
        Deed::Move { from, to, rapid: false } => Some((from, to)),
        _ => None,
    };
    events.into_iter().filter_map(|e| feed(e.deed)).collect()
}

#[test]
fn an_air_cut_makes_the_moves_of_the_pass_above_the_stock() {
    let (plan, settings, piece) = (trial(), settings(), Workpiece::new(60.0, STOCK_MM, 11.5));
    for dialect in Dialect::ALL {
        let program = TurningProgram {
            plan: &plan,
            settings: &settings,
            piece: &piece,
            limits_mm: None,
            reason: "trial",
        };
        let change = program.working_space(dialect).expect("a scene").change;
        let change = Point { x: change.x_mm, z: change.z_mm };
        let cut = feeds(&program.write(dialect).expect("a program").text, dialect, &settings, change);
        let text = AirCut { of: program }.write(dialect).expect("an air cut").text;
        let air = feeds(&text, dialect, &settings, change);
        assert_eq!(cut.len(), air.len(), "{dialect:?}: the same feeds");
        // the trial leaves 50 µm more than the nominal, the air cut touches nothing
        let least = |feeds: &[(Point, Point)]| feeds.iter().map(|f| f.1.x).fold(f64::INFINITY, f64::min);
        assert!((least(&cut) - (11.0 + TRIAL_MM)).abs() < 1e-9, "{dialect:?}: {}", least(&cut));
        assert!(least(&air) >= STOCK_MM + 0.99, "{dialect:?}: {}", least(&air));
        for (a, b) in cut.iter().zip(&air) {
            assert!((a.1.z - b.1.z).abs() < 1e-9, "{dialect:?}: {a:?} {b:?}");
        }
        assert!(text.contains("AIR CUT OF PASS 2") && text.contains("CUTS NOTHING"), "{text}");
        // a register in radius: half of the correction, so that the diameter has all of it
        assert!(dialect != Dialect::Fanuc || text.contains("G10 P16 X0.025"), "{text}");
    }
}
