//! Support functions of bodies with closed forms, and values that belong to none.

use glam::DVec2;
use nalgebra::DMatrix;

use super::parts::{flat_support, nose, papers, round};
use crate::nose::{NoseError, NoseProfile, Support};

fn support(deg: f64, h_mm: f64, u_mm: f64) -> Support {
    Support { a_rad: deg.to_radians(), h_mm, u_mm }
}

#[test]
fn a_circle_is_exact_wherever_the_tool_point_lies() {
    let away = DVec2::new(0.7, -0.3);
    let profile = nose(5.0, |a| 0.4 + away.dot(DVec2::from_angle(a)));
    for k in 0..=1200 {
        let n = DVec2::from_angle((-27.0 + 0.1 * f64::from(k)).to_radians());
        let contact = profile.contact(n.to_angle());
        assert!((contact - 0.4 * n - away).length() < 1e-12, "{k}: {contact}");
    }
}

#[test]
fn an_ellipse_keeps_its_support_and_its_contact_between_the_values() {
    let (a, b) = (0.44, 0.36);
    let exact = |t: f64| (a * t.cos()).hypot(b * t.sin());
    for (step, most) in [(5.0, 6e-6), (1.0, 6e-8)] {
        let profile = nose(step, exact);
        let at = |k: i32| (-27.0 + 0.13 * f64::from(k)).to_radians();
        let worst = (0..920).map(|k| (profile.support_mm(at(k)) - exact(at(k))).abs()).fold(0.0, f64::max);
        println!("ellipse, values every {step}°: support within {worst:.3e} mm");
        assert!(worst < most, "{step}: {worst:e}");
    }
}

#[test]
fn the_contact_moves_along_the_surface() {
    for profile in [papers(), nose(1.0, flat_support), round(0.4)] {
        for k in 0..1190 {
            let a = (-26.95 + 0.1 * f64::from(k)).to_radians();
            let (before, behind) = (profile.contact(a - 5e-4), profile.contact(a + 5e-4));
            let n = DVec2::from_angle(a);
            assert!((behind - before).dot(n.perp()) > -1e-12, "convex at {k}");
            // a chord of two tangent points lies inside both tangents
            assert!(
                profile.support_mm(a) - before.dot(n) > -1e-12
                    && profile.support_mm(a) - behind.dot(n) > -1e-12
            );
        }
    }
}

#[test]
fn noise_is_lowered_to_a_hull_and_more_than_noise_refused() {
    let with = |excess: f64| {
        let values: Vec<Support> =
            (0..=60).map(|k| support(f64::from(k), 0.4 + if k == 30 { excess } else { 0.0 }, 5e-5)).collect();
        NoseProfile::new(&values, None, 0.0)
    };
    // 1° apart a value may lie r(1/cos 1° − 1) = .061 µm outside before it belongs to no body
    let profile = with(2e-4).unwrap();
    let tangent = 0.4 / 1f64.to_radians().cos();
    assert!((profile.support_mm(30f64.to_radians()) - tangent).abs() < 1e-9);
    match with(4e-4) {
        Err(NoseError::NoHull { deg, excess_um, .. }) => {
            assert!((deg - 30.0).abs() < 1e-9 && (excess_um - 0.339).abs() < 1e-3, "{deg} {excess_um}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn values_that_are_no_nose_are_named() {
    let new = |values: &[Support]| NoseProfile::new(values, None, 0.0).unwrap_err().to_string();
    assert!(new(&[support(0.0, 0.4, 0.0)]).contains("3 directions or more"));
    let far = [support(0.0, 0.4, 0.0), support(1.0, 0.4, 0.0), support(9.0, 0.4, 0.0)];
    assert!(new(&far).contains("1.000° and 9.000°"), "{}", new(&far));
    let twice = [support(0.0, 0.4, 0.0), support(0.0, 0.4, 0.0), support(1.0, 0.4, 0.0)];
    assert!(new(&twice).contains("more than 0"));
    let nan = [support(0.0, 0.4, 0.0), support(1.0, f64::NAN, 0.0), support(2.0, 0.4, 0.0)];
    assert!(new(&nan).contains("at 1.000°"));
    let values: Vec<Support> = (0..3).map(|k| support(f64::from(k), 0.4, 0.0)).collect();
    let skew = DMatrix::from_row_slice(3, 3, &[1.0, 0.5, 0.0, 0.4, 1.0, 0.0, 0.0, 0.0, 1.0]);
    assert_eq!(NoseProfile::new(&values, Some(skew), 0.0), Err(NoseError::Covariance(3)));
    assert!(NoseProfile::new(&values, Some(DMatrix::identity(2, 2)), 0.0).is_err());
}
