//! Rows of `frames.csv` with encoder counts: their angles at mid-exposure, and the stops of a scan.

use super::frame_info::FrameInfo;
use crate::position::{EncoderSettings, Latched, Place, bind};

/// Gives the rows, in the order of the table, their angles by the encoder; rows of one z are
/// one scan. Rows of a void turn have the reason in its place.
///
/// # Errors
/// The row and what is wrong with it.
pub(super) fn bind_rows(rows: &mut [FrameInfo], settings: &EncoderSettings) -> Result<(), (usize, String)> {
    rows.sort_by_key(|info| info.row);
    rows.chunk_by_mut(|a, b| a.z_mm == b.z_mm).try_for_each(|field| bind_field(field, settings))
}

fn bind_field(field: &mut [FrameInfo], settings: &EncoderSettings) -> Result<(), (usize, String)> {
    let latched = |info: &FrameInfo| {
        let (count, index) = info.encoder.ok_or_else(|| {
            (info.row, "encoder_count is empty; the count of every frame is needed".to_owned())
        })?;
        Ok(Latched { count, index, t_ns: info.t_ns, exposure_us: info.exposure_us })
    };
    let frames: Vec<Latched> = field.iter().map(latched).collect::<Result<_, (usize, String)>>()?;
    let places = bind(settings, &frames).map_err(|(i, why)| (field[i].row, why))?;
    for (info, place) in field.iter_mut().zip(places) {
        match place {
            Place::At { angle_deg, sweep_deg } => {
                (info.angle_deg, info.sweep_deg) = (angle_deg, sweep_deg);
            }
            Place::Void(why) => info.void = Some(why),
        }
    }
    Ok(())
}

/// Whether the stops of a scan have the frames that they must have: `planned` frames in `fields`
/// fields, one a stop or all of a field a stop. Rows without any stop are not checked.
///
/// # Errors
/// The first stop that is missing, doubled or unknown.
#[cfg(feature = "render")]
pub(super) fn check_stops(rows: &[&FrameInfo], planned: usize, fields: usize) -> Result<(), String> {
    if rows.iter().all(|info| info.stop.is_none()) {
        return Ok(());
    }
    if let Some(info) = rows.iter().find(|info| info.stop.is_none()) {
        return Err(format!(
            "row {}: stop is empty; the number of the stop is needed in every row",
            info.row
        ));
    }
    let most = rows.iter().filter_map(|info| info.stop).max().unwrap_or(0) as usize;
    let (stops, each) = if most > fields { (planned, 1) } else { (fields, planned / fields.max(1)) };
    for stop in 1..=stops.max(most) {
        let found = rows.iter().filter(|info| info.stop == Some(stop as u32)).count();
        let due = if stop <= stops { each } else { 0 };
        if found != due {
            return Err(format!(
                "stop {stop} has {found} frames, {due} are due ({stops} stops of {each}): a trigger was ignored or doubled, or the \
                 frames are of another scan; scan again"
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(row: usize, count: i64, z_mm: f64) -> FrameInfo {
        FrameInfo { row, z_mm, encoder: Some((count, None)), ..FrameInfo::default() }
    }

    #[test]
    fn every_field_is_a_scan_of_its_own() {
        let settings = EncoderSettings { frames_per_turn: Some(4), ..EncoderSettings::new(400) };
        let counts = [0, 100, 200, 300, 1000, 1100, 1300, 1400];
        let z = [0.0, 0.0, 0.0, 0.0, 5.0, 5.0, 5.0, 5.0];
        let mut rows: Vec<FrameInfo> = (0..8).map(|i| row(i + 2, counts[i], z[i])).rev().collect();
        bind_rows(&mut rows, &settings).unwrap();
        assert_eq!(rows[3].angle_deg, 270.0);
        // the way to the next field is no lost trigger; the one at 1200 is
        assert!(rows[..4].iter().all(|info| info.void.is_none()));
        assert!(rows[4..].iter().all(|info| info.void.as_ref().is_some_and(|why| why.contains("ignored"))));
        let mut backwards = vec![row(2, 0, 0.0), row(3, -50, 0.0)];
        let (at, why) = bind_rows(&mut backwards, &settings).unwrap_err();
        assert!(at == 3 && why.contains("backwards"), "{at} {why}");
        let mut empty = vec![FrameInfo { row: 7, ..FrameInfo::default() }];
        assert_eq!(bind_rows(&mut empty, &settings).unwrap_err().0, 7);
    }

    #[test]
    fn stops_pair_with_frames() {
        let rows = |stops: &[u32]| -> Vec<FrameInfo> {
            let one =
                |(stop, row): (&u32, usize)| FrameInfo { row, stop: Some(*stop), ..FrameInfo::default() };
            stops.iter().zip(2..).map(one).collect()
        };
        let check = |stops: &[u32]| check_stops(&rows(stops).iter().collect::<Vec<_>>(), 6, 2);
        // held at three angles in two fields, or turning: two stops of three frames
        for good in [&[1, 2, 3, 4, 5, 6][..], &[1, 1, 1, 2, 2, 2]] {
            assert_eq!(check(good), Ok(()));
        }
        for (bad, word) in [
            (&[1, 2, 4, 5, 6][..], "stop 3 has 0 frames"),
            (&[1, 2, 3, 3, 4, 5, 6], "stop 3 has 2 frames"),
            (&[1, 2, 3, 4, 5, 6, 7], "stop 7 has 1 frames, 0 are due"),
            (&[1, 1, 2, 2, 2], "stop 1 has 2 frames, 3 are due"),
        ] {
            let why = check(bad).unwrap_err();
            assert!(why.contains(word), "{why}");
        }
        let mut some = rows(&[1, 2, 3, 4, 5, 6]);
        some[2].stop = None;
        assert!(check_stops(&some.iter().collect::<Vec<_>>(), 6, 2).unwrap_err().contains("row 4"));
        some.iter_mut().for_each(|info| info.stop = None);
        assert_eq!(check_stops(&some.iter().collect::<Vec<_>>(), 6, 2), Ok(()));
    }
}
