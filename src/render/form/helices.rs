//! Threads and feed marks as heights over the phase of a helix.

use crate::render::error::{RenderError, within};
use crate::shaft::{FeedMarks, Helix, HelixPiece, Thread};

/// The trapezoid of a thread: crest on the radius, flanks, root `depth` below.
pub(super) fn thread(thread: &Thread) -> Result<Helix, RenderError> {
    within("shaft.threads.pitch_mm", thread.pitch_mm, 1e-3, 1e3)?;
    within("shaft.threads.included_angle_deg", thread.included_angle_deg, 1.0, 170.0)?;
    within("shaft.threads.starts", f64::from(thread.starts), 1.0, 64.0)?;
    within("shaft.threads.from_mm", thread.from_mm, -1e5, thread.to_mm)?;
    let pitch = thread.pitch_mm;
    let tan = (0.5 * thread.included_angle_deg).to_radians().tan();
    let crest = thread.crest_mm.unwrap_or(pitch / 8.0);
    // The sharp triangle of the pitch is pitch/(2 tan) high.
    let depth = thread.depth_mm.unwrap_or(0.625 * 0.5 * pitch / tan);
    within("shaft.threads.crest_mm", crest, 0.0, pitch)?;
    within("shaft.threads.depth_mm", depth, 1e-6, 1e3)?;
    let flank = depth * tan;
    if crest + 2.0 * flank > pitch * (1.0 + 1e-12) {
        let right = format!(
            "makes the flanks intersect: crest {crest:.4} and two flanks of {flank:.4} mm exceed the pitch of {pitch} mm"
        );
        return Err(RenderError::setting("shaft.threads.depth_mm", &depth, right));
    }
    let piece = |from_mm: f64, c0: f64, slope: f64| HelixPiece {
        from: from_mm / pitch,
        height_mm: [c0, slope * pitch, 0.0],
    };
    let mut pieces = Vec::new();
    if crest > 0.0 {
        pieces.push(piece(0.0, 0.0, 0.0));
    }
    pieces.push(piece(crest, 0.0, -1.0 / tan));
    if crest + 2.0 * flank < pitch * (1.0 - 1e-12) {
        pieces.push(piece(crest + flank, -depth, 0.0));
    }
    pieces.push(piece(pitch - flank, -depth, 1.0 / tan));
    Ok(Helix {
        from_mm: thread.from_mm,
        to_mm: thread.to_mm,
        pitch_mm: pitch,
        starts: thread.starts,
        left_handed: thread.left_handed,
        pieces,
    })
}

/// One parabola per turn: s²/2r, s from the middle of the mark, valleys on the radius.
pub(super) fn feed_marks(marks: &FeedMarks, length_mm: f64) -> Result<Helix, RenderError> {
    within("shaft.feed_marks.feed_mm", marks.feed_mm, 1e-4, 100.0)?;
    within("shaft.feed_marks.nose_radius_mm", marks.nose_radius_mm, 0.5 * marks.feed_mm, 1e4)?;
    let c2 = marks.feed_mm * marks.feed_mm / (2.0 * marks.nose_radius_mm);
    Ok(Helix {
        from_mm: 0.0,
        to_mm: length_mm,
        pitch_mm: marks.feed_mm,
        starts: 1,
        left_handed: false,
        pieces: vec![HelixPiece { from: 0.0, height_mm: [0.25 * c2, -c2, c2] }],
    })
}
