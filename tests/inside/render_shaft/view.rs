//! Tilt towards the camera, perspective, chief rays, distortion.

use shadowgauge::frame::PixelFormat;
use shadowgauge::render::lens::Distortion;
use shadowgauge::render::lens::entocentric::{edges_mm, entocentric_half_height_mm, tilted_half_height_mm};
use shadowgauge::render::reference::GaussianReference;
use shadowgauge::render::settings::Entocentric;
use shadowgauge::render::silhouette::{Outline, View};
use shadowgauge::render::{BackendChoice, FrameRequest, Renderer, Scene, geometric_edges};
use shadowgauge::shaft::{AxisKnot, Flat, Keyway, Lobe, Pose, ProfileKnot, Shaft};

use crate::inside::render_shaft::close;
use crate::inside::render_shaft::support::{counts, exact, setup, shifts, worst};

fn shoulder() -> Shaft {
    let mut shaft = Shaft::cylinder(25.0);
    let knot = |radius_mm| ProfileKnot { z_mm: 0.0, radius_mm };
    shaft.profile = vec![knot(12.5), knot(10.0)];
    shaft
}

#[test]
fn a_shoulder_tilted_towards_the_camera_is_the_envelope() {
    let tilt = 0.1f64.to_radians();
    let mut shaft = shoulder();
    shaft.pose = Pose { tilt_to_camera_mrad: tilt * 1e3, ..Pose::default() };
    let outline = Outline::new(shaft).unwrap();
    let turned = outline.turned(0.0);
    let radius = |s: f64| if s < 0.0 { 12.5 } else { 10.0 };
    let spread = 12.5 * tilt.sin();
    for share in [-1.2f64, -0.7, -0.2, 0.0, 0.3, 0.7, 0.95, 1.05, 1.3] {
        let z = share * spread;
        let e = turned.edges_seen(z, &View::default());
        // The rim is an ellipse; on one side of it the larger, on the other the smaller cylinder.
        let rim =
            if share <= 0.0 { 12.5 } else { 12.5 * (1.0 - (share * tilt.cos()).powi(2)).max(0.0).sqrt() };
        let wanted = rim.max(10.0);
        close(e.top_mm, wanted, 2e-6, &format!("upper at {share}"));
        close(e.bottom_mm, -wanted, 2e-6, &format!("lower at {share}"));
        close(e.top_mm, tilted_half_height_mm(radius, 12.5, z, tilt, 4096), 2e-3, "a sweep over slices");
    }
}

#[test]
fn a_cylinder_in_perspective_shows_its_tangents() {
    let mut shaft = Shaft::cylinder(15.0);
    shaft.deflection = vec![AxisKnot { z_mm: 0.0, x_mm: 3.0, y_mm: -4.0 }];
    let outline = Outline::new(shaft).unwrap();
    let (top, bottom) = edges_mm(7.5, 3.0, -4.0, 150.0).unwrap();
    for z in [-9.0, 0.0, 4.0] {
        let e = outline.turned(0.0).edges_seen(z, &View { middle_z_mm: 0.0, per_distance: 1.0 / 150.0 });
        close(e.top_mm, top, 1e-9, "upper");
        close(e.bottom_mm, bottom, 1e-9, "lower");
    }
}

/// Silhouette by painting: every point of the surface about z, projected; the largest height in a
/// narrow column.
fn painted(
    outline: &Outline,
    angle_deg: f64,
    z_mm: f64,
    project: impl Fn(f64, f64, f64) -> (f64, f64),
) -> f64 {
    let (width, phi) = (2e-4, angle_deg.to_radians());
    let mut best = f64::NEG_INFINITY;
    for i in 0..=34_000 {
        let machine = std::f64::consts::PI * (f64::from(i) / 34_000.0 - 0.5) * 0.34;
        let theta = machine - phi;
        let r0 = outline.radius_mm(z_mm, theta);
        // Only slices near the one that projects to the column.
        let centre = z_mm + (z_mm - project(r0 * machine.cos(), r0 * machine.sin(), z_mm).0);
        for j in -8..=8 {
            let s = centre + width * f64::from(j) / 4.0;
            let r = outline.radius_mm(s, theta);
            let (z, x) = project(r * machine.cos(), r * machine.sin(), s);
            if (z - z_mm).abs() <= width {
                best = best.max(x);
            }
        }
    }
    best
}

#[test]
fn lobes_flats_and_keyways_in_oblique_views_meet_painting() {
    let mut shaft = Shaft::cylinder(20.0);
    shaft.profile =
        vec![ProfileKnot { z_mm: -40.0, radius_mm: 9.0 }, ProfileKnot { z_mm: 40.0, radius_mm: 11.0 }];
    shaft.lobes = vec![Lobe { order_upr: 5, amplitude_mm: 0.05, phase_deg: 12.0 }];
    shaft.features.flats = vec![Flat { from_mm: -40.0, to_mm: 40.0, distance_mm: 9.2, angle_deg: 20.0 }];
    shaft.features.keyways =
        vec![Keyway { from_mm: -40.0, to_mm: 40.0, width_mm: 3.0, floor_mm: 7.0, angle_deg: -60.0 }];
    shaft.pose = Pose { tilt_to_camera_mrad: 15.0, ..Pose::default() };
    let outline = Outline::new(shaft).unwrap();
    let (sin, cos) = 0.015f64.sin_cos();
    let per_distance = 1.0 / 180.0;
    // Where a flat faces up, the steps along z miss its rim towards the lens: calculated by hand it
    // is 9.2/(1 - 3.52/180) = 9.3835 there.
    let up = outline.turned(-20.0).edges_seen(-6.0, &View { middle_z_mm: 1.0, per_distance });
    close(up.top_mm, 9.3835, 2e-3, "rim of a flat that faces up");
    for angle in [0.0, 60.0, 57.0, 133.0] {
        let turned = outline.turned(angle);
        for z in [-6.0, 5.0] {
            let e = turned.edges_seen(z, &View { middle_z_mm: 1.0, per_distance });
            let seen = painted(&outline, angle, z, |x, y, s| {
                let (z, y) = (1.0 + (s - 1.0) * cos + y * sin, y * cos - (s - 1.0) * sin);
                let m = 1.0 / (1.0 - y * per_distance);
                (1.0 + m * (z - 1.0), m * x)
            });
            // Painting misses a rim by one step of 3e-5 rad, where the height changes by 3.5
            // mm/rad.
            close(e.top_mm, seen, 2.5e-4, &format!("{angle}° z {z}"));
        }
    }
    let cone = |s: f64| 10.0 + 0.025 * s;
    let mut plain = Shaft::cylinder(20.0);
    plain.profile = vec![
        ProfileKnot { z_mm: -40.0, radius_mm: cone(-40.0) },
        ProfileKnot { z_mm: 40.0, radius_mm: cone(40.0) },
    ];
    let outline = Outline::new(plain).unwrap();
    let e = outline.turned(0.0).edges_seen(11.0, &View { middle_z_mm: 0.0, per_distance: 1.0 / 200.0 });
    let wanted = entocentric_half_height_mm(cone, 11.5, 11.0, 200.0, 2048).unwrap();
    close(e.top_mm, wanted, 1e-9, "a cone, by slices");
}

#[test]
fn a_chief_ray_at_an_angle_moves_an_edge_by_its_depth() {
    let mut setup = setup(400, 60, 1.2);
    let radius_px = 100.0;
    let mut shaft = Shaft::cylinder(2.0 * radius_px * setup.pixel_mm);
    let y_mm = 0.7;
    shaft.deflection = vec![AxisKnot { z_mm: 0.0, x_mm: 0.0, y_mm }];
    let straight =
        geometric_edges(&Scene::new(&setup, shaft.clone()).unwrap(), &FrameRequest::default()).unwrap();
    setup.nominal.optics.telecentricity_mrad = 5.0;
    let seen = geometric_edges(&Scene::new(&setup, shaft).unwrap(), &FrameRequest::default()).unwrap();
    let half_diagonal = 0.5 * 400f64.hypot(60.0);
    // y tan ε with ε in proportion to the height: 2 y tan ε of diameter.
    let shift_px = y_mm / setup.pixel_mm * (5e-3f64).tan() * radius_px / half_diagonal;
    let wider = (seen[30].bottom_px - seen[30].top_px) - (straight[30].bottom_px - straight[30].top_px);
    close(wider, 2.0 * shift_px, 0.01 * shift_px, "wider by 2 y tan ε");
}

#[test]
fn distorted_edges_are_drawn_where_the_lens_puts_them() {
    let mut setup = setup(500, 400, 1.2);
    setup.nominal.optics.distortion =
        Distortion { k1: -0.03, k2: 0.008, p1: 0.002, p2: -0.0015, ..Default::default() };
    let radius = |px: f64| px * setup.pixel_mm;
    let mut shaft = Shaft::cylinder(2.0 * radius(180.0));
    shaft.pose.tilt_mrad = 30.0;
    let scene = Scene::new(&setup, shaft.clone()).unwrap();
    let mut plain = setup.clone();
    plain.nominal.optics.distortion = Distortion::default();
    let ideal = Scene::new(&plain, shaft).unwrap();
    let request = FrameRequest { format: Some(PixelFormat::F32), ..Default::default() };
    let straight = exact(&ideal, 0.0, 0.0);
    let seen = exact(&scene, 0.0, 0.0);
    for column in [3.0, 120.25, 380.0] {
        let (row, at) = setup.nominal.optics.distortion.distort_px(straight(column)[0], column, 500, 400);
        close(seen(at)[0], row, 1e-8, "a point of the edge");
    }
    let truth = geometric_edges(&scene, &request).unwrap();
    close(truth[17].bottom_px, seen(17.0)[1], 1e-12, "truth holds the distorted rows");
    let frame = counts(&Renderer::new(BackendChoice::Cpu).unwrap().render(&scene, &request, None).unwrap());
    let levels = scene.setup().levels(PixelFormat::F32);
    let reference = GaussianReference { sigma_px: 1.2, shadow: levels.shadow, bright: levels.bright };
    let wanted = reference.frame(500, 400, seen);
    let shift = worst(&shifts(&frame, &wanted, 400, levels.bright - levels.shadow));
    println!("distorted edges: {shift:.1e} px");
    assert!(shift < 1e-5, "{shift}");
}

#[test]
fn a_pinhole_inside_the_shaft_is_refused() {
    let mut setup = setup(400, 60, 1.2);
    setup.nominal.optics.entocentric = Some(Entocentric { distance_mm: 2.0 });
    let text = Scene::new(&setup, Shaft::cylinder(4.0)).unwrap_err().to_string();
    assert!(text.contains("optics.entocentric.distance_mm"), "{text}");
}
