//! Of what a followed frame does for a change of its blur.

use super::*;
use crate::gauge::edge::image::scan_windows::Side;

/// What a frame does whose blur is another by a share of it, everywhere alike.
fn by(share: f64, is_ringed: bool) -> Change {
    let sigma = 1.2;
    let information = 1e4;
    let mut sum = BlurSums::default();
    (sum.score, sum.information, sum.count) = (share * sigma * information, information, 100.0);
    let track = BlurTrack { follows: true, sums: [sum; BLOCKS] };
    let (windows, table) = (Windows::new(Side::Top), Table::empty());
    let view = TrackView { windows: &windows, table: &table, level_lines: false, is_ringed };
    let mut blur = BlurEstimate::uniform(sigma);
    let change = track.follow(&mut blur, 1e-4, &view, &mut []);
    let expected = if change == Change::Lost { sigma } else { sigma * (1.0 + share) };
    assert!((blur.mean() - expected).abs() < 1e-6, "{share}: {} for {expected}", blur.mean());
    change
}

/// Focus that drifts by a tenth is followed, edges placed anew; a frame that is blurred by a fifth
/// more is another view, and is searched anew.
#[test]
fn a_blur_that_jumps_is_lost_and_one_that_drifts_is_followed() {
    for sign in [-1.0, 1.0] {
        assert_eq!(by(0.005 * sign, false), Change::Moved);
        assert_eq!(by(0.1 * sign, false), Change::Refit);
        assert_eq!(by(0.22 * sign, false), Change::Lost);
    }
}

/// The phase of the farthest ring, πv²/2 at v = 10 units, turns by πv²·δ for a change of the blur
/// by a share δ: by 0.22 rad for 7e-4, where sin x is x to 0.8 %, and by 0.44 rad for 1.4e-3, where
/// it is off by 3 %.
#[test]
fn edges_among_rings_are_placed_anew_for_a_smaller_change() {
    assert_eq!(by(7e-4, true), Change::Moved);
    assert_eq!(by(1.4e-3, true), Change::Refit);
    assert_eq!(by(1.4e-3, false), Change::Moved);
}
