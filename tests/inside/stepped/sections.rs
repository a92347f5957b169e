//! Sections of a drawing: where stations lie, what is refused.

use super::job;
use shadowgauge::job::{Job, PartSection, ScanWhen};
use shadowgauge::shaft::ContourPoint;

#[test]
fn stations_keep_clear_of_shoulders_and_tapers() {
    let order = job().loop_job();
    order.check_coverage().unwrap();
    let contour = order.turned_contour().unwrap();
    let names: Vec<&str> = contour.sections.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["collar", "bearing seat A", "bearing seat B"]);
    assert_eq!(contour.tapers.len(), 1);
    let z = order.station_z_mm();
    let ranges = contour.stations_of_sections(&z);
    assert_eq!(ranges.len(), 3);
    assert_eq!(ranges.iter().map(ExactSizeIterator::len).sum::<usize>(), z.len());
    // Twenty pixels of 15.27 µm beside a chamfer of .5 mm, or a fillet of 1.2 mm.
    let edge = 20.0 * order.field.mm_per_px;
    for (range, (from, to)) in
        ranges.iter().zip([(0.0, 69.5 - edge), (71.2 + edge, 125.0 - edge), (156.2 + edge, 200.0)])
    {
        let (first, last) = (z[range.start] - 2.0, z[range.end - 1] + 2.0);
        assert!(first >= from - 1e-6 && last <= to + 1e-6, "{first} {last}: {from} {to}");
        assert!(first - from < 2.0 && to - last < 2.0, "as many stations as fit: {first} {last}");
    }
    let plan = order.pass_plan(3, shadowgauge::plan::DiameterOffset::zero(z.len()));
    let nominal: Vec<f64> = plan.station_nominal_mm().collect();
    assert!((nominal[0] - 28.0).abs() < 1e-12);
    assert!((nominal[ranges[1].start] - (22.0 - 0.0065)).abs() < 1e-9, "the middle of 22 h6");
    assert!((nominal[ranges[2].start] - (16.0 - 0.0055)).abs() < 1e-9, "the middle of 16 h6");
}

fn entry(z_mm: f64, tolerance: Option<&str>) -> PartSection {
    let tolerance = tolerance.map(|t| t.parse().unwrap());
    PartSection { z_mm, name: None, tolerance, aim_mm: None, measured: true }
}

fn point(z_mm: f64, diameter_mm: f64) -> ContourPoint {
    ContourPoint { z_mm, diameter_mm, ..ContourPoint::default() }
}

/// What cannot be turned or judged is refused by name.
#[test]
fn a_contour_that_cannot_be_is_refused_with_its_place() {
    let said = |change: &dyn Fn(&mut Job)| {
        let mut job = job();
        change(&mut job);
        job.check_coverage().expect_err("refused").to_string()
    };
    let rest = |z: f64| {
        move |j: &mut Job| {
            j.process.support.steady_rests =
                vec![shadowgauge::process::SteadyRestSettings { z_mm: z, stiffness_n_per_um: 30.0 }];
        }
    };
    type Change<'a> = &'a dyn Fn(&mut Job);
    let cases: [(Change<'_>, &[&str]); 17] = [
        (&|j| j.shaft.contour[3].z_mm = 69.0, &["shaft.contour", "z must not fall"]),
        (&|j| j.shaft.contour[6].z_mm = 190.0, &["shaft.contour", "0 to 190", "part.length_mm = 200"]),
        (&|j| j.part.sections.push(entry(70.0, None)), &["part.sections[4].z_mm", "no section is there"]),
        (
            &|j| j.part.sections.push(entry(250.0, Some("22 h6"))),
            &["part.sections[4].z_mm", "no section is there"],
        ),
        (&|j| j.part.sections.push(entry(100.0, None)), &["part.sections[4].z_mm", "one entry each"]),
        (&|j| j.part.sections[2].tolerance = "20 h6".parse().ok(), &["part.sections[2].tolerance", "taper"]),
        (
            &|j| j.part.sections[1].tolerance = "21 h6".parse().ok(),
            &["part.sections[1].tolerance", "Ø22", "21 mm"],
        ),
        (&|j| j.part.sections[1].aim_mm = Some(0.1), &["part.sections[1].tolerance", "outside"]),
        (&|j| j.part.station_mm = 60.0, &["part.station_mm", "longer than the section", "Ø22"]),
        (
            &|j| j.part.station_z_mm = Some(vec![20.0, 70.0]),
            &["part.station_z_mm[1]", "span a shoulder or a taper"],
        ),
        (
            &|j| j.part.station_z_mm = Some(vec![140.0]),
            &["part.station_z_mm[0]", "span a shoulder or a taper"],
        ),
        (&rest(140.0), &["process.support.steady_rests[0].z_mm", "taper", "needs a cylinder"]),
        (&rest(70.0), &["process.support.steady_rests[0].z_mm", "shoulder"]),
        (&|j| j.part.nominal_diameter_mm[2] = 27.9, &["part.nominal_diameter_mm[2]", "leaves 28 mm"]),
        (&|j| j.part.tolerance = "28 h6".parse().ok(), &["part.tolerance", "[[part.sections]]"]),
        (
            &|j| j.shaft.contour.splice(2..4, [point(70.0, 22.0), point(74.0, 27.0)]).for_each(drop),
            &["falls by 32", "27°"],
        ),
        (&|j| j.scan.when = ScanWhen::DuringCut, &["scan.when", "after_pass"]),
    ];
    for (i, (change, words)) in cases.iter().enumerate() {
        let text = said(change);
        for word in *words {
            assert!(text.contains(word), "case {i}: {word:?} is missing in: {text}");
        }
    }
}

#[test]
fn a_shoulder_that_falls_along_the_feed_and_sections_without_a_contour_are_refused() {
    let mut job = job();
    job.process.pass.feed_direction = shadowgauge::plan::FeedDirection::TowardsTailstock;
    let undercut = job.check_coverage().expect_err("refused").to_string();
    assert!(
        undercut.contains("shoulder from Ø28 to Ø22") && undercut.contains("feed_direction"),
        "{undercut}"
    );
    let mut plain = Job::default();
    plain.part.sections.push(entry(10.0, None));
    assert!(plain.check_coverage().unwrap_err().to_string().contains("part.sections[0].z_mm"));
}

/// A groove too short for a station is cut and not judged once the drawing states so.
#[test]
fn a_short_collar_is_left_out_by_name() {
    let mut job = job();
    job.shaft.contour.splice(4..6, [point(155.0, 19.0), point(158.0, 19.0), point(158.0, 16.0)]);
    let refused = job.check_coverage().unwrap_err().to_string();
    assert!(refused.contains("part.station_mm") && refused.contains("z_mm = 156.5"), "{refused}");
    job.part.sections.push(PartSection { measured: false, ..entry(156.5, None) });
    job.check_coverage().unwrap();
    assert_eq!(job.loop_job().turned_contour().unwrap().sections.len(), 3);
}
