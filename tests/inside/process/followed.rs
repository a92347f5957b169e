//! The shaft while it is cut: its state in the frames is consistent with the result of the pass.

use shadowgauge::plan::{CuttingData, DiameterOffset, PassPlan, PlannedForm};
use shadowgauge::process::bending::axis_at;
use shadowgauge::process::{
    BaseForm, BendingSettings, FeedDirection, ProcessSettings, Stock, TurningProcess,
};
use shadowgauge::shaft::AxisKnot;

const STOCK: Stock = Stock { diameter_mm: 27.0, length_mm: 500.0 };

fn plan(o_mm: Vec<f64>) -> PassPlan {
    PassPlan {
        pass: 1,
        nominal_mm: 26.5,
        cutting: CuttingData { speed_m_per_min: 80.0, feed_mm_per_rev: 0.1 },
        station_z_mm: (0..100).map(|i| 2.5 + 5.0 * f64::from(i)).collect(),
        offset: DiameterOffset { o_mm },
        form: PlannedForm::PLAIN,
    }
}

fn turning(settings: &ProcessSettings) -> TurningProcess {
    TurningProcess::new(settings, STOCK, &BaseForm::default(), 1).unwrap()
}

/// Half the diameter error is the displacement of the axis away from the tool, in either direction
/// of feed.
#[test]
fn the_axis_under_the_tool_has_moved_by_half_the_diameter_error() {
    for feed_direction in [FeedDirection::TowardsChuck, FeedDirection::TowardsTailstock] {
        let mut settings = ProcessSettings::default();
        settings.pass.feed_direction = feed_direction;
        settings.bending.tool_deg = 30.0;
        let mut process = turning(&settings);
        let pass = process.followed(&plan(vec![0.0; 100])).unwrap();
        let seen: Vec<f64> = [20, 137, 250, 400, 480]
            .map(|node| {
                let [x, y] = axis_at(&pass.at(f64::from(node)).deflection, f64::from(node));
                let (sin, cos) = 30f64.to_radians().sin_cos();
                // Tangential over radial force is 2.5, and so are the deflections.
                let (away, along) = (-(x * cos + y * sin), x * sin - y * cos);
                assert!((along / away - 2.5).abs() < 1e-9, "{along} {away}");
                away
            })
            .to_vec();
        process.cut(&plan(vec![0.0; 100])).unwrap();
        for (node, away) in [20, 137, 250, 400, 480].into_iter().zip(seen) {
            let half = 0.5 * (process.diameter_mm()[node] - 26.5);
            // Elements behind and ahead of the tool take their mean diameters: a fraction of the
            // change along one element.
            assert!((away - half).abs() < 2e-5 * half + 1e-9, "{node}: {away} {half}");
        }
    }
}

#[test]
fn behind_the_tool_lies_what_the_pass_leaves_and_ahead_what_was() {
    let mut process = turning(&ProcessSettings::default());
    let pass = process.followed(&plan(vec![0.0; 100])).unwrap();
    let shaft = pass.at(200.5);
    let done = process.cut(&plan(vec![0.0; 100])).unwrap();
    assert_eq!(shaft.texture, done.texture);
    let radius = |z: f64| shaft.profile.iter().find(|k| k.z_mm == z).unwrap().radius_mm;
    assert_eq!(radius(300.0), 0.5 * process.diameter_mm()[300]);
    assert_eq!(radius(100.0), 13.5);
    assert!(shaft.profile.windows(2).all(|k| k[0].z_mm <= k[1].z_mm));
    let shoulder: Vec<f64> = shaft.profile.iter().filter(|k| k.z_mm == 200.5).map(|k| k.radius_mm).collect();
    assert!(shoulder.len() == 2 && shoulder[0] > shoulder[1] + 0.2, "{shoulder:?}");
    assert_eq!(pass.force(-1.0).passive_n, 0.0);
}

/// A command ahead of the tool changes nothing behind it: a pass can be corrected in progress.
#[test]
fn a_pass_is_causal_along_the_feed() {
    let process = turning(&ProcessSettings::default());
    let mut o_mm = vec![0.0; 100];
    let planned = process.followed(&plan(o_mm.clone())).unwrap().at(0.0);
    o_mm[..40].fill(0.02);
    let changed = process.followed(&plan(o_mm)).unwrap().at(0.0);
    // At the end of its travel the tool is at the first node.
    for (a, b) in planned.profile.iter().zip(&changed.profile).skip(1) {
        assert_eq!(a != b, a.z_mm < 202.5, "{a:?} {b:?}");
    }
}

/// A tailstock 20 µm further from the tool leaves a taper of 40 µm at its end; across the tool
/// hardly anything.
#[test]
fn a_tailstock_out_of_line_turns_a_taper() {
    let cut = |x_um: f64, y_um: f64, tangential_error: bool| {
        let bending = BendingSettings {
            tool_deg: 0.0,
            tailstock_x_um: x_um,
            tailstock_y_um: y_um,
            tangential_error,
            ..BendingSettings::default()
        };
        let mut process = turning(&ProcessSettings { bending, ..ProcessSettings::default() });
        process.cut(&plan(vec![0.0; 100])).unwrap();
        process.diameter_mm().to_vec()
    };
    let straight = cut(0.0, 0.0, false);
    let away = cut(-20.0, 0.0, false);
    // Error copying reduces it by a few percent: the more the shaft yields, the less is cut.
    let taper = away[499] - straight[499];
    assert!((0.036..0.040).contains(&taper), "{taper}");
    // The chuck yields by .05 µm under the bent shaft.
    assert!((away[1] - straight[1]).abs() < 3e-4);
    assert_eq!(cut(0.0, 20.0, false), straight);
    // Tangential: 2.5 times a radial deflection of 21 µm, u²·2/D.
    let carried = cut(0.0, 0.0, true);
    let node = 290;
    let aside = 2.5 * 0.5 * (straight[node] - 26.5);
    let expected = 2.0 * aside * aside / 26.5;
    assert!(((carried[node] - straight[node]) / expected - 1.0).abs() < 0.02, "{expected}");
}

/// The heat of the cut affects the shaft during the cut, not at 20 °C after it; the heat of the
/// scan affects the scan.
#[test]
fn a_warm_shaft_is_seen_larger() {
    let mut settings = ProcessSettings::default();
    (settings.disturbance.heat_start_k, settings.disturbance.heat_end_k) = (10.0, 10.0);
    settings.disturbance.heat_scan_k = 4.0;
    let mut process = turning(&settings);
    let warm = process.followed(&plan(vec![0.0; 100])).unwrap().at(0.0);
    let cold = process.cut(&plan(vec![0.0; 100])).unwrap();
    let scanned = process.as_scanned(&cold);
    let at = |shaft: &shadowgauge::shaft::Shaft| shaft.profile[300].radius_mm;
    assert!((at(&warm) / at(&cold) - 1.0 - 115e-6).abs() < 1e-9);
    assert!((at(&scanned) / at(&cold) - 1.0 - 46e-6).abs() < 1e-9);
    assert!((scanned.profile[500].z_mm - 500.023).abs() < 1e-9);
}

#[test]
fn contributions_add_up_to_the_axis() {
    let bending = BendingSettings {
        self_weight: true,
        gravity_deg: 225.0,
        tool_deg: 135.0,
        tailstock_push: true,
        tailstock_x_um: 6.0,
        tailstock_y_um: -4.0,
        chuck_eccentricity_um: 10.0,
        chuck_eccentricity_deg: 200.0,
        tangential_error: true,
    };
    let bow: Vec<AxisKnot> = (0..=64)
        .map(|i| f64::from(i) * 500.0 / 64.0)
        .map(|z_mm| AxisKnot { z_mm, x_mm: 0.0, y_mm: 0.015 * (std::f64::consts::PI * z_mm / 500.0).sin() })
        .collect();
    let settings = ProcessSettings { bending, ..ProcessSettings::default() };
    let form = BaseForm { bow, ..BaseForm::default() };
    let process = TurningProcess::new(&settings, STOCK, &form, 1).unwrap();
    let pass = process.followed(&plan(vec![0.0; 100])).unwrap();
    let (parts, shaft) = (pass.contributions(Some(310.0)), pass.at(310.0));
    for z in [1.0, 77.0, 310.0, 499.0] {
        let at = |knots: &[AxisKnot]| axis_at(knots, z);
        for axis in [0, 1] {
            let still = at(&parts.weight)[axis] + at(&parts.tailstock)[axis] + at(&parts.force)[axis];
            assert!((still - at(&shaft.deflection)[axis]).abs() < 1e-12, "{z}");
            let turning = at(&parts.chuck)[axis] + at(&parts.bow)[axis];
            assert!((turning - at(&shaft.bow)[axis]).abs() < 1e-12, "{z}");
        }
        assert!(at(&parts.weight)[0] < 0.0 && at(&parts.weight)[1] < 0.0);
    }
}
