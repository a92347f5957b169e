//! `--setup`: a page a second of what focus, alignment and light are set by.

use std::fmt::Write as _;

use indicatif::ProgressBar;
use serde_json::{Value, json};

use crate::cli::terminal::progress;
use crate::frame::Frame;
use crate::gauge::FrameEdges;
use crate::measurement::Refusal;
use crate::measurement::watch::SetupReading;
use crate::profile::Reason;
use crate::source::live::LiveMeta;

/// Time from one page to the next, s.
const PERIOD_S: f64 = 1.0;

/// What of the gauge a page depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct SetupOf {
    /// Grey value without light, counts.
    pub(super) black: f64,
    /// Whether the calibration has a flat field, by which frames are corrected.
    pub(super) has_flat: bool,
    /// Whether what is not part is light.
    pub(super) is_backlit: bool,
    /// Whether the shaft stands upright in the images.
    pub(super) vertical: bool,
}

/// A frame as it was measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct PageOf<'a> {
    pub(super) frame: &'a Frame,
    pub(super) meta: &'a LiveMeta,
    /// Its edges, where it has a diameter.
    pub(super) edges: Option<&'a FrameEdges>,
    /// Why it has none.
    pub(super) refusal: Option<&'a Refusal>,
}

impl PageOf<'_> {
    fn reading(&self, of: SetupOf) -> SetupReading {
        let view = self.frame.view();
        let view = if of.vertical { view.transposed() } else { view };
        // Where a part may stand is known by its edges, or where there is none.
        let is_empty = self.refusal.is_some_and(|r| matches!(r.reason, Reason::NoEdge | Reason::LowContrast));
        let is_known = self.edges.is_some() || is_empty;
        SetupReading::of(&view, self.edges, of.black, of.is_backlit && is_known)
    }

    fn why(&self) -> Option<&str> {
        self.refusal.map(|refusal| refusal.why.as_str())
    }
}

/// The page on the terminal, and when it was last shown.
#[derive(Debug)]
pub(super) struct SetupPage {
    of: SetupOf,
    page: ProgressBar,
    shown_s: Option<f64>,
}

impl SetupPage {
    /// A page that is shown with the next frame.
    pub(super) fn new(of: SetupOf) -> Self {
        Self { of, page: progress::page(), shown_s: None }
    }

    /// Whether it is time for another page.
    pub(super) fn is_due(&self, t_s: f64) -> bool {
        self.shown_s.is_none_or(|shown_s| t_s - shown_s >= PERIOD_S)
    }

    /// The keys of a page; with `as_text` it is shown, too: where the terminal has no place for it,
    /// one below the other on stdout.
    pub(super) fn look(&mut self, t_s: f64, of: &PageOf<'_>, as_text: bool) -> Value {
        self.shown_s = Some(t_s);
        let reading = of.reading(self.of);
        if as_text && self.page.is_hidden() {
            say_line!("{}\n", text(&reading, of, self.of.has_flat));
        } else if as_text {
            self.page.set_message(text(&reading, of, self.of.has_flat));
            self.page.tick();
        }
        keys(&reading, of, self.of.has_flat)
    }

    /// Leaves the last page on the terminal.
    pub(super) fn finish(&self) {
        self.page.abandon();
    }
}

/// The keys of a page.
fn keys(reading: &SetupReading, of: &PageOf<'_>, has_flat: bool) -> Value {
    let mut all = json!({
        "sequence": of.meta.sequence,
        "why": of.why(),
        "light": {
            "brightest_counts": reading.light.brightest,
            "of_full_scale": reading.light.of_full_scale,
            "saturated_share": reading.light.saturated_share,
            "exposure_factor": reading.light.exposure_factor,
            "exposure_us": exposure_us(reading, of.meta).map(|[_, good]| good),
        },
        "evenness": reading.evenness.map(|e| json!({
            "lowest": e.lowest, "lowest_row": e.lowest_at[0], "lowest_column": e.lowest_at[1],
            "highest": e.highest, "tiles": e.tiles, "of_flat": has_flat,
        })),
    });
    if let Some(edges) = &reading.edges {
        all["edges"] = json!({
            "blur_px": edges.blur_px, "tilt_deg": edges.tilt_deg, "contrast": edges.contrast,
            "gradient_counts_per_px": edges.gradient, "snr": edges.snr,
        });
    }
    all
}

/// The exposure of the frame and the one that its light wants, µs.
fn exposure_us(reading: &SetupReading, meta: &LiveMeta) -> Option<[f64; 2]> {
    let now_us = meta.exposure_us?.value;
    Some([now_us, now_us * reading.light.exposure_factor?])
}

fn text(reading: &SetupReading, of: &PageOf<'_>, has_flat: bool) -> String {
    let mut page = format!("frame {}\n", of.meta.sequence);
    if let Some(why) = of.why() {
        let _ = writeln!(page, "edges      none: {why}");
    }
    if let Some(edges) = &reading.edges {
        let shown = |blur: Option<f64>| blur.map_or_else(|| "    -".to_owned(), |px| format!("{px:5.2}"));
        for (name, [left, middle, right]) in ["upper", "lower"].into_iter().zip(edges.blur_px) {
            let [left, middle, right] = [left, middle, right].map(shown);
            let _ =
                writeln!(page, "focus      {name} edge: blur left {left}  middle {middle}  right {right} px");
        }
        let [upper, lower] = edges.gradient;
        let _ = writeln!(page, "gradient   upper {upper:.1}, lower {lower:.1} counts/px");
        let _ = writeln!(page, "axis       {:+.3} degrees to the rows", edges.tilt_deg);
        let _ = writeln!(page, "contrast   {:.3}, over noise {:.0}", edges.contrast, edges.snr);
    }
    let light = &reading.light;
    let share =
        light.of_full_scale.map_or_else(String::new, |s| format!(", {:.1} % of full scale", 100.0 * s));
    let saturated = 100.0 * light.saturated_share;
    let _ = writeln!(page, "light      {:.0} counts{share}; {saturated:.3} % saturated", light.brightest);
    let _ = writeln!(page, "exposure   {}", exposure_text(reading, of.meta));
    page += &evenness_text(reading, has_flat);
    page
}

fn exposure_text(reading: &SetupReading, meta: &LiveMeta) -> String {
    match (reading.light.exposure_factor, exposure_us(reading, meta)) {
        (_, Some([now_us, good_us])) => format!("{now_us:.1} us; {good_us:.1} us brings the light to 80 %"),
        (Some(factor), None) => format!("{factor:.2} times as long brings the light to 80 %"),
        (None, None) if reading.light.of_full_scale.is_none() => "no full scale is stated".to_owned(),
        (None, None) if reading.light.saturated_share > 0.0 => "too long: halve it".to_owned(),
        (None, None) => "nothing is lit".to_owned(),
    }
}

fn evenness_text(reading: &SetupReading, has_flat: bool) -> String {
    let of = if has_flat { "against the calibrated flat" } else { "no flat field is calibrated" };
    match &reading.evenness {
        None => "evenness   too little of the field is lit".to_owned(),
        Some(even) => format!(
            "evenness   {:+.1} % at row {}, column {} to {:+.1} % of the median ({of})",
            100.0 * even.lowest,
            even.lowest_at[0],
            even.lowest_at[1],
            100.0 * even.highest
        ),
    }
}
