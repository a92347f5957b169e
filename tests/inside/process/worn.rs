//! A pass that leaves another contour than the drawn one: a worn nose's.

use shadowgauge::plan::{
    Contour, ContourKnot, CuttingData, DiameterOffset, FeedDirection, PassPlan, PlannedForm, Section, Side,
    Taper, value_at,
};
use shadowgauge::process::{BaseForm, ProcessSettings, Stock, TurningProcess};
use shadowgauge::shaft::Shaft;

/// Ø25 to 40, a cone to Ø21 at 60, Ø21 to 80, a shoulder, Ø17 to 120.
fn drawn() -> Contour {
    let points = [(0.0, 0.0), (40.0, 0.0), (60.0, -4.0), (80.0, -4.0), (80.0, -8.0), (120.0, -8.0)];
    let section = |(ends_mm, relative_mm): ((f64, f64), f64)| Section {
        name: String::new(),
        ends_mm,
        clear_mm: (ends_mm.0 + 1.0, ends_mm.1 - 1.0),
        drawn_mm: 25.0 + relative_mm,
        aim_mm: 0.0,
        relative_mm,
        limits_mm: None,
    };
    let (ends_mm, clear_mm) = ((40.0, 60.0), (41.0, 59.0));
    Contour {
        knots: points.map(|(z_mm, relative_mm)| ContourKnot { z_mm, relative_mm }).to_vec(),
        sections: [((0.0, 40.0), 0.0), ((60.0, 80.0), -4.0), ((80.0, 120.0), -8.0)].map(section).to_vec(),
        tapers: vec![Taper { name: String::new(), ends_mm, clear_mm, drawn_mm: (24.8, 21.2) }],
        direction: FeedDirection::TowardsChuck,
    }
}

/// .02 mm more on the cylinders, .04 on the cone, the shoulder .015 nearer to the tailstock, a
/// chamfer in its corner.
fn worn() -> Contour {
    let points = [
        (0.0, 0.02),
        (40.05, 0.02),
        (40.1, 0.02),
        (60.1, -3.98),
        (80.015, -3.98),
        (80.015, -7.4),
        (80.3, -7.98),
        (120.0, -7.98),
    ];
    Contour { knots: points.map(|(z_mm, relative_mm)| ContourKnot { z_mm, relative_mm }).to_vec(), ..drawn() }
}

fn cut(worn: Option<Contour>, tailstock_n_per_um: f64, passes: u32) -> Shaft {
    let mut settings = ProcessSettings::default();
    (settings.texture.rms_um, settings.texture.lobe_um) = (0.0, 0.0);
    settings.support.chuck_n_per_um = f64::INFINITY;
    settings.support.tailstock_n_per_um = tailstock_n_per_um;
    settings.material.youngs_modulus_n_per_mm2 =
        Some(if tailstock_n_per_um.is_infinite() { 1e12 } else { 2.1e5 });
    let form = BaseForm { contour: Some(drawn()), worn, ..BaseForm::default() };
    let stock = Stock { diameter_mm: 26.0, length_mm: 120.0 };
    let mut process = TurningProcess::new(&settings, stock, &form, 1).unwrap();
    let z = [20.0, 70.0, 100.0];
    let plan = |pass: u32| PassPlan {
        pass,
        nominal_mm: 26.0 - 0.5 * f64::from(pass),
        cutting: CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 },
        station_z_mm: z.to_vec(),
        offset: DiameterOffset { o_mm: vec![0.0; z.len()] },
        form: PlannedForm::stepped(drawn()),
    };
    (1..=passes).map(|pass| process.cut(&plan(pass)).unwrap()).last().unwrap()
}

fn diameter_mm(shaft: &Shaft, z: f64, side: Side) -> f64 {
    2.0 * value_at(&shaft.profile, z, side, |k| (k.z_mm, k.radius_mm))
}

const PLACES: [f64; 9] = [5.0, 30.0, 40.03, 45.0, 55.0, 70.0, 80.01, 80.2, 110.0];

#[test]
fn every_pass_of_a_rigid_shaft_leaves_the_worn_contour() {
    for passes in [1, 2] {
        let shaft = cut(Some(worn()), f64::INFINITY, passes);
        for z in PLACES {
            let wanted = 26.0 - 0.5 * f64::from(passes) + worn().relative_mm(z, Side::Chuck);
            let found = diameter_mm(&shaft, z, Side::Chuck);
            assert!((found - wanted).abs() < 2e-6, "pass {passes}, z {z}: {found} instead of {wanted}");
        }
    }
}

/// The deflection is that of the drawn contour but for the change of the depth, and the worn
/// contour comes on top of it everywhere.
#[test]
fn deflection_and_wear_add_up() {
    let (with, without) = (cut(Some(worn()), 5.0, 2), cut(None, 5.0, 2));
    let mut bent: f64 = 0.0;
    for z in PLACES.into_iter().filter(|z| !(80.0..80.5).contains(z)) {
        let more = worn().relative_mm(z, Side::Chuck) - drawn().relative_mm(z, Side::Chuck);
        let (a, b) = (diameter_mm(&with, z, Side::Chuck), diameter_mm(&without, z, Side::Chuck));
        assert!((a - b - more).abs() < 2e-4, "z {z}: {} more, {more} by the nose", a - b);
        bent = bent.max(b - 25.0 - drawn().relative_mm(z, Side::Chuck));
    }
    assert!(bent > 5e-3, "{bent}");
}
