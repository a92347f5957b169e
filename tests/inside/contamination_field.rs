//! Contamination against closed forms, conservation of light and the configured statistics.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use shadowgauge::frame::{PixelFormat, Pixels};
use shadowgauge::render::contamination::shapes::{
    clear_radius_of_ball, clear_radius_of_cap, disc, half_plane, into_polygon, line,
};
use shadowgauge::render::contamination::{
    AdheringFilms, AirDroplets, Chips, Contamination, ContaminationField, Dirt, FieldGeometry, Film, Films,
    Mist, Scratches, SizeDistribution, TransmissionMap, WindowDroplets, mask,
};
use shadowgauge::render::settings::{SetupDeviations, SetupSettings};
use shadowgauge::render::{BackendChoice, FrameRequest, OpticalSetup, Renderer, Scene};
use shadowgauge::shaft::{ProfileKnot, Shaft};

fn close(found: f64, wanted: f64, tolerance: f64, what: &str) {
    assert!((found - wanted).abs() <= tolerance, "{what}: {found}, not {wanted} ± {tolerance}");
}

fn geometry() -> FieldGeometry {
    FieldGeometry { rows: 600, columns: 800, pixel_um: 15.0, effective_na: 0.01, sigma_um: 15.0 }
}

fn alike(um: f64) -> SizeDistribution {
    SizeDistribution { median_um: um, geometric_sd: 1.0, largest_um: um }
}

fn dirty() -> Contamination {
    Contamination {
        window_distance_mm: 20.0,
        mist: Mist { clouds_per_cm2: 2.0, ..Mist::default() },
        window_droplets: WindowDroplets { per_cm2: 8.0, ..WindowDroplets::default() },
        air_droplets: AirDroplets { per_cm2: 12.0, ..AirDroplets::default() },
        chips: Chips { per_cm2: 1.5, ..Chips::default() },
        films: Films { per_cm2: 1.0, ..Films::default() },
        dirt: Dirt { per_cm2: 10.0, ..Dirt::default() },
        scratches: Scratches { per_cm2: 1.0, ..Scratches::default() },
        ..Contamination::default()
    }
}

// -- shapes

#[test]
fn a_disc_out_of_focus_is_the_folding_of_two_discs() {
    for (radius, blur) in [(3.0, 1.0), (1.0, 4.0), (2.0, 2.0), (0.3, 0.2)] {
        for r in [0.0, 0.5, 1.0, 1.9, 2.6, 3.7, 4.9] {
            // Points of the disc of confusion about r, on a fine grid.
            let n = 1200;
            let at = |i: i32| blur * (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0);
            let (mut inside, mut all) = (0, 0);
            for i in 0..n {
                for j in 0..n {
                    let (x, y) = (at(i), at(j));
                    if x.hypot(y) < blur {
                        all += 1;
                        inside += i32::from((r + x).hypot(y) < radius);
                    }
                }
            }
            let wanted = f64::from(inside) / f64::from(all);
            close(disc(r, radius, blur), wanted, 2e-3, &format!("radius {radius}, blur {blur}, r {r}"));
        }
        // Conservation of light: ∫ shade = area of the disc.
        let h = 1e-3;
        let steps = ((radius + blur) / h) as i32 + 1;
        let lost: f64 = (0..steps)
            .map(|i| (f64::from(i) + 0.5) * h)
            .map(|r| disc(r, radius, blur) * std::f64::consts::TAU * r * h)
            .sum();
        close(lost, std::f64::consts::PI * radius * radius, 1e-4 * radius * radius, "light lost");
    }
}

#[test]
fn a_large_disc_has_the_border_of_a_half_plane() {
    for inside in [-0.9, -0.3, 0.0, 0.5, 1.2] {
        close(disc(1e5 - inside, 1e5, 1.0), half_plane(inside, 1.0), 1e-4, "border");
    }
    let h = 1e-3;
    let lost: f64 = (-5000..5000).map(|i| line(f64::from(i) * h, 0.3, 2.0) * h).sum();
    close(lost, 0.3, 1e-6, "light lost by a scratch");
    assert_eq!((half_plane(0.1, 0.0), half_plane(-0.1, 0.0)), (1.0, 0.0));
}

#[test]
fn polygons_know_inside_and_distance() {
    let l = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
    for (p, wanted) in [
        ([0.5, 0.5], 0.5),
        ([2.0, 0.25], 0.25),
        ([2.0, 2.0], -1.0),
        ([5.0, 2.0], -2f64.sqrt()),
        ([-1.0, 1.0], -1.0),
    ] {
        close(into_polygon(p, &l), wanted, 1e-12, "distance");
        let mut other = l;
        other.reverse();
        close(into_polygon(p, &other), wanted, 1e-12, "the other way round");
    }
}

#[test]
fn droplets_pass_the_rays_they_hardly_turn() {
    // Small angles: a ball has the focal length n a/(2(n-1)), so that h = θ a n/(2(n-1)).
    let angle = 1e-3;
    close(clear_radius_of_ball(2.0, 1.34, angle), angle * 2.0 * 1.34 / (2.0 * 0.34), 1e-6, "ball");
    // A cap is a plano-convex lens of focal length a/(sin φ (n-1)).
    let contact = 50f64.to_radians();
    close(clear_radius_of_cap(2.0, contact, 1.34, angle), angle * 2.0 / contact.sin() / 0.34, 1e-6, "cap");
    close(clear_radius_of_cap(2.0, 0.05, 1.34, 0.1), 2.0, 1e-12, "a flat film passes everything");
    assert!(clear_radius_of_ball(2.0, 1.34, 0.0) < 1e-9);
}

// -- fields

#[test]
fn counts_and_sizes_follow_the_settings() {
    // Identical specks in focus: light lost = number × area × opacity; Poisson over seeds.
    let settings = Contamination {
        window_distance_mm: 0.0,
        dirt: Dirt { per_cm2: 30.0, radius_um: alike(60.0), opacity: 0.5 },
        ..Contamination::default()
    };
    let g = geometry();
    let area_cm2 = (g.rows as f64 * g.columns as f64) * (15e-4f64).powi(2);
    let lost: Vec<f64> = (0..60)
        .map(|seed| {
            let map = ContaminationField::new(&settings, g, seed)
                .unwrap()
                .frame(0, [0, 0], [g.rows, g.columns])
                .unwrap();
            // Overlapping specks multiply; the logarithm adds.
            map.values().iter().map(|t| 1.0 - f64::from(*t)).sum::<f64>()
        })
        .collect();
    let one = 0.5 * std::f64::consts::PI * (60.0f64 / 15.0).powi(2);
    let mean = lost.iter().sum::<f64>() / lost.len() as f64 / one;
    let wanted = 30.0 * area_cm2;
    close(mean, wanted, 4.0 * (wanted / 60.0).sqrt() + 0.02 * wanted, "mean number");
    let variance = lost.iter().map(|l| (l / one - mean).powi(2)).sum::<f64>() / 59.0;
    assert!((0.5..1.7).contains(&(variance / wanted)), "Poisson: {variance} about {wanted}");
}

#[test]
fn the_window_stays_and_the_air_changes() {
    let field = ContaminationField::new(&dirty(), geometry(), 7).unwrap();
    let frame = |id| field.frame(id, [0, 0], [600, 800]).unwrap();
    let (a, b) = (frame(1), frame(2));
    assert_eq!(a, frame(1), "the same frame twice");
    assert_ne!(a.values(), b.values());
    let fixed = mask::WINDOW_DROPLET | mask::DIRT | mask::SCRATCH;
    let same = a.mask().iter().zip(b.mask()).all(|(x, y)| x & fixed == y & fixed);
    assert!(same, "what lies on the window moved");
    assert!(a.mask().iter().any(|m| m & fixed != 0) && a.mask().iter().any(|m| m & mask::CHIP != 0));
    assert!(a.values().iter().all(|t| (0.0..=1.0).contains(t)));
    let other =
        ContaminationField::new(&dirty(), geometry(), 8).unwrap().frame(1, [0, 0], [600, 800]).unwrap();
    assert_ne!(a.values(), other.values());
}

#[test]
fn a_window_of_the_sensor_shows_its_part() {
    let field = ContaminationField::new(&dirty(), geometry(), 3).unwrap();
    let whole = field.frame(5, [0, 0], [600, 800]).unwrap();
    let part = field.frame(5, [100, 250], [64, 300]).unwrap();
    for row in 0..64 {
        for column in 0..300 {
            let (i, j) = (row * 300 + column, (row + 100) * 800 + column + 250);
            assert!((part.values()[i] - whole.values()[j]).abs() < 1e-5, "{row} {column}");
            assert_eq!(part.mask()[i], whole.mask()[j]);
        }
    }
}

#[test]
fn only_touched_pixels_are_written_and_the_mask_tells_which() {
    let settings =
        Contamination { dirt: Dirt { per_cm2: 0.7, ..Dirt::default() }, ..Contamination::default() };
    let field = ContaminationField::new(&settings, geometry(), 1).unwrap();
    let map = field.frame(0, [0, 0], [600, 800]).unwrap();
    for (i, t) in map.values().iter().enumerate() {
        let tile = i / 800 / 32 * map.tile_columns() + i % 800 / 32;
        assert!(*t == 1.0 || map.touched()[tile], "pixel {i}");
        assert_eq!(map.mask()[i] != 0, (1.0 - t).abs() > mask::THRESHOLD, "mask of pixel {i}");
    }
    assert!(map.touched().iter().any(|t| *t) && !map.touched().iter().all(|t| *t));
    let mut reused =
        ContaminationField::new(&dirty(), geometry(), 2).unwrap().frame(3, [0, 0], [600, 800]).unwrap();
    reused.copy_from(&map);
    assert_eq!(reused, map);
    assert!(TransmissionMap::new(3, 5).values().iter().all(|t| *t == 1.0));
    let clean = ContaminationField::new(&Contamination::default(), geometry(), 1).unwrap();
    assert_eq!(clean.frame(9, [0, 0], [600, 800]).unwrap(), TransmissionMap::new(600, 800));
    assert!(Contamination::default().is_clean() && !dirty().is_clear());
}

#[test]
fn mist_attenuates_as_a_gaussian() {
    let mist = Mist { clouds_per_cm2: 3.0, optical_depth: 0.3, size_um: alike(900.0), haze_depth: 0.2 };
    let settings = Contamination { mist, ..Contamination::default() };
    let g = geometry();
    let depths: Vec<f64> = (0..40)
        .map(|seed| {
            let map = ContaminationField::new(&settings, g, seed)
                .unwrap()
                .frame(1, [0, 0], [g.rows, g.columns])
                .unwrap();
            map.values().iter().map(|t| -f64::from(*t).ln()).sum::<f64>() / (g.rows * g.columns) as f64
        })
        .collect();
    let mean = depths.iter().sum::<f64>() / 40.0;
    // Campbell: mean depth = density × ∫ τ exp(-r²/2s²).
    let wanted = 0.2 + 3.0 * 0.3 * std::f64::consts::TAU * 0.09f64.powi(2);
    let sd = (depths.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 39.0).sqrt();
    close(mean, wanted, 4.0 * sd / 40f64.sqrt(), "mean optical depth");
    assert!(sd / mean < 0.2, "{sd} about {mean}");
}

#[test]
fn defocus_spreads_the_shade_and_keeps_its_light() {
    let lost = |distance: f64, seed| {
        let settings = Contamination {
            window_distance_mm: distance,
            dirt: Dirt { per_cm2: 3.0, radius_um: alike(200.0), opacity: 0.3 },
            ..Contamination::default()
        };
        let g = FieldGeometry { rows: 1500, columns: 1500, ..geometry() };
        let map =
            ContaminationField::new(&settings, g, seed).unwrap().frame(0, [0, 0], [1500, 1500]).unwrap();
        let darkest = map.values().iter().fold(1.0f32, |m, t| m.min(*t));
        (map.values().iter().map(|t| 1.0 - f64::from(*t)).sum::<f64>(), f64::from(darkest))
    };
    let mean = |distance| (0..6).map(|s| lost(distance, s).0).sum::<f64>() / 6.0;
    let (near, far) = (mean(0.0), mean(60.0));
    // Fields widened by the blur contain more specks: the comparison is by the loss of one speck
    // times their mean number.
    let number = 3.0 * (1500.0f64 * 15e-4).powi(2);
    let one = 0.3 * std::f64::consts::PI * (200.0f64 / 15.0).powi(2);
    close(near / one, number, 0.35 * number, "near");
    close(far / one, number, 0.35 * number, "far");
    assert!(lost(0.0, 1).1 <= 0.705 && lost(60.0, 1).1 > 0.85, "{} {}", lost(0.0, 1).1, lost(60.0, 1).1);
}

// -- films

#[test]
fn a_film_raises_the_edge_when_it_faces_it() {
    let film =
        Film { z_mm: 40.0, theta_deg: 30.0, half_length_mm: 2.0, half_width_deg: 10.0, thickness_mm: 0.02 };
    let films = AdheringFilms::new(vec![film]);
    // A body point θ is at θ + φ: up at φ = -30°.
    close(films.rise_mm(12.5, 40.0, -30.0), 0.02, 1e-9, "at the top");
    close(films.rise_mm(12.5, 41.0, -30.0), 0.01, 1e-9, "half way along z");
    assert_eq!(films.rise_mm(12.5, 40.0, 150.0), 0.0, "below");
    assert_eq!(films.rise_mm(12.5, 42.0, -30.0), 0.0, "beside it");
    // Turned by some degrees: the maximum over a million points of the outline.
    for turn in [-34.0, -27.5, -24.0, -20.5, 330.0 + 3.0] {
        let wanted = (0..1_000_000).fold(0.0f64, |best, i| {
            let theta = f64::from(i) * 3.6e-4;
            let r = 12.5 + film.height_mm(40.0, theta);
            best.max(r * (theta + turn).to_radians().cos() - 12.5)
        });
        close(films.rise_mm(12.5, 40.0, turn), wanted, 1e-8, &format!("turned by {turn}"));
    }
}

/// Films rise at corners of the outline as at its straight edges: no step where columns with their
/// own profiles begin.
#[test]
fn films_adhere_beside_a_shoulder_as_elsewhere() {
    let mut settings = SetupSettings { departures: SetupDeviations::none(), ..Default::default() };
    (settings.camera.rows, settings.camera.columns) = (400, 300);
    (settings.camera.pixel_um, settings.optics.magnification) = (3.0, 0.2);
    let films = Films { per_cm2: 60.0, half_extent_um: alike(900.0), thickness_um: alike(30.0) };
    settings.contamination = Contamination { films, ..Contamination::default() };
    let setup = OpticalSetup::resolve(&settings, 5).unwrap();
    let mut shaft = Shaft::cylinder(4.0);
    shaft.profile =
        vec![ProfileKnot { z_mm: 0.0, radius_mm: 1.9 }, ProfileKnot { z_mm: 0.0, radius_mm: 2.1 }];
    let scene = Scene::new(&setup, shaft).unwrap();
    let request = FrameRequest { format: Some(PixelFormat::F32), ..Default::default() };
    let twin = Renderer::new(BackendChoice::Cpu).unwrap();
    let dark = |scene: &Scene| -> Vec<f64> {
        let frame = twin.render(scene, &request, None).unwrap();
        let Pixels::F32(pixels) = frame.view().pixels() else { panic!("not f32") };
        let levels = scene.setup().levels(PixelFormat::F32);
        let shade = |v: f32| (levels.bright - f64::from(v)) / (levels.bright - levels.shadow);
        (0..300).map(|c| (0..200).map(|r| shade(pixels[r * 300 + c])).sum()).collect()
    };
    let (filmed, wiped) = (dark(&scene), dark(&scene.clone().wiped()));
    let lift: Vec<f64> = filmed.iter().zip(&wiped).map(|(a, b)| a - b).collect();
    println!("lift of the upper edge about the shoulder: {:.3?}", &lift[140..160]);
    // The shoulder is at column 149.5; columns up to about 9 px on either side have their own
    // profiles.
    assert!(lift[130..170].iter().all(|l| *l > 0.1), "no film where it is looked for: {lift:.3?}");
    assert!(lift.windows(3).all(|w| (w[0] - 2.0 * w[1] + w[2]).abs() < 0.03), "{lift:.3?}");
}

#[test]
fn films_are_drawn_by_seed_and_density() {
    let settings =
        Contamination { films: Films { per_cm2: 2.0, ..Films::default() }, ..Contamination::default() };
    let draw = |seed| AdheringFilms::draw(&settings, 12.5, 100.0..160.0, seed).unwrap();
    assert_eq!(draw(4), draw(4));
    assert_ne!(draw(4), draw(5));
    let mean = (0..40).map(|s| draw(s).films().len() as f64).sum::<f64>() / 40.0;
    let wanted = 2.0 * std::f64::consts::TAU * 1.25 * 6.0;
    close(mean, wanted, 4.0 * (wanted / 40.0).sqrt(), "number");
    let mut sizes: Vec<f64> =
        (0..40).flat_map(|s| draw(s).films().to_vec()).map(|f| f.thickness_mm * 1e3).collect();
    sizes.sort_by(f64::total_cmp);
    close(sizes[sizes.len() / 2], 8.0, 0.4, "median thickness");
    close(sizes[sizes.len() * 84 / 100], 8.0 * 1.8, 0.9, "one geometric standard deviation");
    assert!(
        sizes[sizes.len() - 1] <= 100.0 && draw(1).films().iter().all(|f| (100.0..160.0).contains(&f.z_mm))
    );
}

#[test]
fn bad_settings_name_their_key() {
    let refused = |s: Contamination| ContaminationField::new(&s, geometry(), 1).unwrap_err().to_string();
    let cases = [
        (
            Contamination { dirt: Dirt { per_cm2: -1.0, ..Dirt::default() }, ..Contamination::default() },
            "contamination.dirt.per_cm2",
        ),
        (
            Contamination {
                mist: Mist { size_um: alike(f64::NAN), ..Mist::default() },
                ..Contamination::default()
            },
            "contamination.mist.size_um.median_um",
        ),
        (
            Contamination { chips: Chips { corners: 2, ..Chips::default() }, ..Contamination::default() },
            "contamination.chips.corners",
        ),
        (
            Contamination {
                scratches: Scratches { opacity: 1.5, ..Scratches::default() },
                ..Contamination::default()
            },
            "contamination.scratches.opacity",
        ),
        (
            Contamination { dirt: Dirt { per_cm2: 9.9e4, ..Dirt::default() }, ..Contamination::default() },
            "fewer than",
        ),
    ];
    for (settings, key) in cases {
        let text = refused(settings);
        assert!(text.contains(key), "{key}: {text}");
    }
    let text = "[dirt]\nper_cm = 3.0\n";
    assert!(toml::from_str::<Contamination>(text).unwrap_err().to_string().contains("per_cm"));
    let set: Contamination = toml::from_str("[mist]\nhaze_depth = 0.1\n[chips]\nper_cm2 = 2.0\n").unwrap();
    assert_eq!(set.chips.per_cm2, 2.0);
}
