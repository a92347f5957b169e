//! Stations that a config lists.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test that cannot set up its case must fail")]

use shadowgauge::job::Job;

fn job(listed: &[f64]) -> Job {
    let mut job = Job::default();
    job.part.station_z_mm = Some(listed.to_vec());
    job
}

#[test]
fn a_list_is_taken_as_it_stands() {
    let job = job(&[5.0, 83.5, 250.0, 497.5]);
    job.check().expect("a job");
    assert_eq!(job.part.station_z_mm(), [5.0, 83.5, 250.0, 497.5]);
    assert_eq!(Job::default().part.station_z_mm().len(), 100);
}

#[test]
fn a_list_that_cannot_be_is_refused_with_its_place() {
    let said = |listed: &[f64]| job(listed).check().expect_err("refused").to_string();
    for (listed, words) in [
        (&[][..], ["part.station_z_mm:", "lists 0 stations"]),
        (&[1.0, 20.0], ["part.station_z_mm[0]: 1 mm", "between 2.5 and 497.5"]),
        (&[5.0, 498.0], ["part.station_z_mm[1]: 498 mm", "inside the part"]),
        (&[5.0, f64::NAN], ["part.station_z_mm[1]: NaN", "inside the part"]),
        (&[50.0, 20.0], ["part.station_z_mm[1]: 20 mm", "must ascend"]),
        (&[20.0, 20.0], ["part.station_z_mm[1]: 20 mm", "must ascend"]),
        (&[20.0, 24.0], ["part.station_z_mm[1]: 24 mm", "overlap"]),
    ] {
        let text = said(listed);
        assert!(words.iter().all(|w| text.contains(w)), "{text}");
    }
    // side by side as the default has them
    let touching: Vec<f64> = (0..100).map(|i| (f64::from(i) + 0.5) * 5.0).collect();
    job(&touching).check().expect("stations may touch");
}

#[test]
fn fields_that_show_no_station_are_left_out() {
    let (all, some) = (Job::default().scan_plan(), job(&[5.0, 250.0]).scan_plan());
    assert!(some.field_z_mm.len() < 6 && some.field_z_mm.iter().all(|z| all.field_z_mm.contains(z)));
    let half = Job::default().field_length_mm() / 2.0;
    // whatever of a station all fields show, the fields left show, too
    for z in [2.6, 5.0, 7.4, 247.6, 250.0, 252.4] {
        let shown = |fields: &[f64]| fields.iter().filter(|f| (*f - z).abs() <= half).count();
        assert_eq!(shown(&some.field_z_mm), shown(&all.field_z_mm), "Z {z}");
    }
}
