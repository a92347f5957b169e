//! Contours, spectra and growth.

use shadowgauge::render::form::{contour_knots, form_shaft, read_contour};
use shadowgauge::shaft::{
    ContourPoint, ProfileKnot, Shaft, ShaftForm, TextureForm, TextureSpectrum, Thermal,
};

use crate::inside::render_shaft::close;

fn point(z_mm: f64, diameter_mm: f64) -> ContourPoint {
    ContourPoint { z_mm, diameter_mm, ..Default::default() }
}

fn knots(points: &[ContourPoint]) -> Shaft {
    let mut shaft = Shaft::cylinder(1.0);
    shaft.profile = contour_knots(points).unwrap();
    shaft
}

fn radius(shaft: &Shaft, z: f64) -> f64 {
    shadowgauge::render::silhouette::Outline::new(shaft.clone()).unwrap().turned(0.0).edges(z).top_mm
}

#[test]
fn chamfers_roundings_and_fillets_touch_their_lines() {
    let shaft = knots(&[
        point(0.0, 10.0),
        ContourPoint { radius_mm: 1.5, ..point(20.0, 10.0) },
        ContourPoint { chamfer_mm: 0.5, ..point(20.0, 16.0) },
        ContourPoint { radius_mm: 2.0, ..point(40.0, 16.0) },
        point(40.0, 8.0),
        point(60.0, 7.0),
    ]);
    // Fillet of 1.5 at the foot, centre (18.5, 6.5).
    for z in [18.6, 19.0, 19.7, 19.99] {
        close(radius(&shaft, z), 6.5 - (1.5f64.powi(2) - (z - 18.5f64).powi(2)).sqrt(), 3e-6, "fillet");
    }
    // Chamfer .5 x 45° behind the shoulder.
    close(radius(&shaft, 20.2), 7.5 + 0.2, 1e-12, "chamfer");
    close(radius(&shaft, 20.6), 8.0, 1e-12, "behind it");
    // Rounding of 2 before the next shoulder, centre (38, 6).
    for z in [38.5, 39.2, 39.9] {
        close(radius(&shaft, z), 6.0 + (4.0 - (z - 38.0f64).powi(2)).sqrt(), 3e-6, "rounding");
    }
    close(radius(&shaft, 50.0), 3.75, 1e-12, "taper");
}

#[test]
fn contours_that_intersect_themselves_are_refused() {
    let cases = [
        (vec![point(0.0, 10.0), point(20.0, 10.0), point(15.0, 8.0)], "z must not fall"),
        (
            vec![point(0.0, 10.0), ContourPoint { radius_mm: 6.0, ..point(20.0, 10.0) }, point(20.0, 12.0)],
            "intersect",
        ),
        (vec![ContourPoint { chamfer_mm: 1.0, ..point(0.0, 10.0) }, point(20.0, 10.0)], "both sides"),
        (vec![point(0.0, -1.0)], "diameter_mm"),
    ];
    for (points, wanted) in cases {
        let text = contour_knots(&points).unwrap_err().to_string();
        assert!(text.contains(wanted) && text.contains("shaft.contour"), "{wanted}: {text}");
    }
    let fin =
        knots(&[point(0.0, 10.0), point(5.0, 10.0), point(5.0, 14.0), point(5.0, 9.0), point(9.0, 9.0)]);
    let text = shadowgauge::render::silhouette::Outline::new(fin).unwrap_err().to_string();
    assert!(text.contains("intersects itself"), "{text}");
}

#[test]
fn a_contour_is_read_from_a_file_and_a_bad_line_named() {
    let text = "# drawing 17\nz_mm,diameter_mm,chamfer_mm\n0, 10\n20,10,0.5\n20,8,0\n30,8,0,0\n";
    let points = read_contour(text.as_bytes()).unwrap();
    assert_eq!(points.len(), 4);
    close(points[1].chamfer_mm, 0.5, 0.0, "third column");
    for (text, wanted) in
        [("0,10\n5,x\n", "line 2"), ("0\n", "line 1"), ("z,d\n", "no point"), ("0,1,2,3,4\n", "2 to 4")]
    {
        let found = read_contour(text.as_bytes()).unwrap_err().to_string();
        assert!(found.contains(wanted) && found.contains("shaft.contour_file"), "{wanted}: {found}");
    }
}

/// A contour with decimal commas, with and without its header, as spreadsheets save it.
#[test]
fn a_contour_with_decimal_commas_is_the_same() {
    let commas = "z_mm;diameter_mm;chamfer_mm\n0;10,5\n20,25;10,5;0,5\n20,25;8\n";
    let points = read_contour(commas.replace(',', ".").replace(';', ",").as_bytes()).unwrap();
    close(points[1].z_mm, 20.25, 0.0, "z");
    let mut wide = vec![0xff, 0xfe];
    wide.extend(commas.encode_utf16().flat_map(u16::to_le_bytes));
    let tabs = commas.replace(';', "\t").into_bytes();
    let bare = commas.split_once('\n').unwrap().1.as_bytes().to_vec();
    for bytes in [commas.as_bytes().to_vec(), tabs, bare, wide, format!("sep=;\n{commas}").into_bytes()] {
        let shown = String::from_utf8_lossy(&bytes).into_owned();
        assert_eq!(read_contour(bytes.as_slice()).unwrap(), points, "{shown:?}");
    }
    let found = read_contour("0;10,5\n5;x\n".as_bytes()).unwrap_err().to_string();
    assert!(found.contains("line 2: '5;x'") && found.contains("must be 2 to 4"), "{found}");
}

/// Mean periodogram along z of a texture, unit rms: (frequency, density).
fn periodogram(form: TextureForm, length_mm: f64) -> (Vec<(f64, f64)>, f64) {
    let plain = vec![ProfileKnot { z_mm: 0.0, radius_mm: 5.0 }];
    let shaft =
        form_shaft(plain, &ShaftForm { texture: Some(form), ..Default::default() }, length_mm, 5).unwrap();
    let t = shaft.texture.unwrap();
    let (n, rows) = (t.nodes_theta, t.height_mm.len() / t.nodes_theta);
    let rms =
        (t.height_mm.iter().map(|h| f64::from(*h).powi(2)).sum::<f64>() / t.height_mm.len() as f64).sqrt();
    let lines = (1..40)
        .map(|k| {
            let density = (0..n).step_by(3).map(|j| {
                let (mut re, mut im) = (0.0, 0.0);
                for i in 0..rows {
                    // Hann window: far leakage must not fill a steep spectrum.
                    let phase = std::f64::consts::TAU * i as f64 / rows as f64;
                    let h = f64::from(t.height_mm[i * n + j]) * (1.0 - phase.cos());
                    re += h * (k as f64 * 3.0 * phase).cos();
                    im += h * (k as f64 * 3.0 * phase).sin();
                }
                re * re + im * im
            });
            (f64::from(k) * 3.0 / (rows as f64 * t.step_mm), density.sum::<f64>())
        })
        .collect();
    (lines, rms)
}

#[test]
fn a_surface_has_the_spectrum_it_was_given() {
    let around = TextureForm { rms_um: 1.0, correlation_theta_deg: 1.0, ..Default::default() };
    type Law = fn(f64) -> f64;
    let cases: [(TextureForm, Law, f64); 3] = [
        (
            TextureForm {
                spectrum: TextureSpectrum::PowerLaw { exponent: 2.0, longest_mm: 5.0, shortest_mm: 0.2 },
                ..around.clone()
            },
            |f| f.max(0.2).powi(-2),
            4.5,
        ),
        (
            TextureForm { correlation_z_mm: 0.8, spectrum: TextureSpectrum::Exponential, ..around.clone() },
            |f| 1.0 / (1.0 + (std::f64::consts::TAU * 0.8 * f).powi(2)),
            3.0,
        ),
        (
            TextureForm {
                spectrum: TextureSpectrum::Points {
                    per_mm: vec![0.0, 1.0, 3.0],
                    density: vec![0.5, 2.0, 0.1],
                },
                ..around
            },
            |f| if f < 1.0 { 0.5 + 1.5 * f } else { 2.0 - 0.95 * (f - 1.0) },
            2.5,
        ),
    ];
    for (form, law, highest) in cases {
        let (lines, rms) = periodogram(form.clone(), 40.0);
        close(rms * 1e3, 1.0, 0.08, "rms");
        let lines: Vec<_> = lines.into_iter().filter(|(f, _)| *f < highest).collect();
        let ratio = |range: &[(f64, f64)]| {
            range.iter().map(|(_, d)| d).sum::<f64>() / range.iter().map(|(f, _)| law(*f)).sum::<f64>()
        };
        let all = ratio(&lines);
        // 120 directions, every third of them independent, four to ten lines a band.
        for band in lines.chunks(lines.len().div_ceil(4)) {
            close(ratio(band) / all, 1.0, 0.2, &format!("{:?} about {:.2}/mm", form.spectrum, band[0].0));
        }
    }
}

#[test]
fn heat_grows_radius_and_length() {
    let thermal = Thermal { rise_at_chuck_k: 10.0, rise_at_end_k: 30.0, expansion_um_per_m_k: 11.5 };
    let contour = vec![point(0.0, 20.0), point(300.0, 20.0), point(300.0, 18.0), point(500.0, 18.0)];
    let form = ShaftForm { thermal, contour, ..Default::default() };
    let shaft = form_shaft(Vec::new(), &form, 500.0, 0).unwrap();
    // ∫ΔT dz to 300 mm: 300·10 + 300²·20/1000 = 4800 K mm.
    let shoulder = 300.0 + 11.5e-6 * 4800.0;
    close(radius(&shaft, shoulder - 1e-6), 10.0 * (1.0 + 11.5e-6 * 22.0), 1e-9, "at the shoulder");
    close(radius(&shaft, shoulder + 1e-6), 9.0 * (1.0 + 11.5e-6 * 22.0), 1e-9, "behind it");
    close(radius(&shaft, 0.0), 10.0 * (1.0 + 11.5e-5), 1e-12, "at the chuck");
    let plain = form_shaft(
        vec![ProfileKnot { z_mm: 0.0, radius_mm: 5.0 }],
        &ShaftForm { thermal, ..Default::default() },
        500.0,
        0,
    );
    close(radius(&plain.unwrap(), 250.0), 5.0 * (1.0 + 11.5e-6 * 20.0), 2e-7, "half way along a plain shaft");
}
