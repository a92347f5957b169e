//! What `watch` prints: lines of JSON, or a line a part and the line of now on a terminal.

use indicatif::ProgressBar;
use serde_json::{Map, Value, json};

use super::live_conditions::TakenConditions;
use super::saved::Saved;
use crate::cli::failure::Failure;
use crate::cli::measure::document::line;
use crate::cli::terminal::progress;
use crate::frame::Frame;
use crate::gauge::stated::stated;
use crate::measurement::Measurement;
use crate::measurement::watch::{Invalid, Pace, PartValue, Profile, Slope, Turn};
use crate::source::Arrival;
use crate::source::live::{Counters, Gap, Known, LiveMeta};

/// Frames that were lost and left out before one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Missed {
    pub(super) lost: u64,
    pub(super) incomplete: u64,
    pub(super) dropped: u64,
}

/// A frame, measured.
#[derive(Clone, Debug)]
pub(super) struct ShownFrame<'a> {
    pub(super) measurement: &'a Measurement,
    pub(super) meta: &'a LiveMeta,
    pub(super) missed: Missed,
    pub(super) latency_ms: Option<f64>,
    pub(super) slope: Option<Slope>,
    pub(super) is_alarmed: bool,
    pub(super) conditions: TakenConditions,
    /// Whether the diameter is good by its course in time.
    pub(super) is_settled: bool,
    /// The turn that ended with the frame.
    pub(super) turn: Option<Turn>,
    /// The file that the frame is saved in.
    pub(super) saved: Option<String>,
}

/// What the line of now shows.
#[derive(Clone, Debug)]
pub(super) struct Now<'a> {
    /// Diameter, U and the word of the judgement; or why there is none.
    pub(super) reading: Result<(f64, f64, &'a str), &'a Invalid>,
    /// Diameters along the frame.
    pub(super) profile: Option<Profile>,
    pub(super) slope: Option<Slope>,
    pub(super) pace: &'a Pace,
    pub(super) counters: &'a Counters,
    pub(super) parts: u64,
    pub(super) alarm: Option<&'a str>,
}

/// How results are shown.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShownAs {
    /// As JSON, else as text.
    pub(super) json: bool,
    /// Whether they are judged.
    pub(super) judges: bool,
    /// Lower and upper limit of the tolerance, mm, where one is given.
    pub(super) limits_mm: Option<[f64; 2]>,
    /// Whether diameters have to settle.
    pub(super) settles: bool,
    /// `mm` or `px`.
    pub(super) unit: &'static str,
}

/// Where results go.
pub(super) struct Shown {
    json: bool,
    judges: bool,
    limits_mm: Option<[f64; 2]>,
    settles: bool,
    unit: &'static str,
    saved: Option<Saved>,
    now: ProgressBar,
}

impl Shown {
    /// Results on stdout, and all of them in a folder where that is wanted.
    pub(super) fn new(shown: ShownAs, saved: Option<Saved>) -> Self {
        let ShownAs { json, judges, limits_mm, settles, unit } = shown;
        Self { json, judges, limits_mm, settles, unit, saved, now: progress::line() }
    }

    /// Whether stdout has JSON.
    pub(super) fn is_json(&self) -> bool {
        self.json
    }

    /// Whether a terminal has the line of now.
    pub(super) fn is_live(&self) -> bool {
        !self.now.is_hidden()
    }

    /// Whether frames are saved, and more of them may be.
    pub(super) fn saves_frames(&self) -> bool {
        self.saved.as_ref().is_some_and(Saved::has_room)
    }

    /// Saves a frame where that is wanted; its file.
    pub(super) fn save(&mut self, number: u64, frame: impl FnOnce() -> Option<Frame>) -> Option<String> {
        let saved = self.saved.as_mut()?;
        let frame = if saved.has_room() { frame() } else { None };
        saved.frame(number, frame)
    }

    /// Waits until everything that is saved is written.
    ///
    /// # Errors
    /// Where the disk refused.
    pub(super) fn end_saving(self) -> Result<(), Failure> {
        self.saved.map_or(Ok(()), Saved::finish)
    }

    /// A frame.
    pub(super) fn frame(&mut self, frame: &ShownFrame<'_>) {
        if self.json || self.saved.is_some() {
            let mut line = frame_line(frame);
            if let Some(limits_mm) = self.limits_mm {
                line["limits_mm"] = json!(limits_mm);
            }
            self.line(&line);
        }
    }

    /// A page of `--setup`.
    pub(super) fn set_up(&mut self, keys: Value) {
        self.event("setup", keys);
    }

    fn line(&mut self, line: &Value) {
        if self.json {
            say_line!("{line}");
        }
        if let Some(saved) = &mut self.saved {
            saved.line(line);
        }
    }

    /// Numbers without a frame.
    pub(super) fn gap(&mut self, gap: &Gap) {
        // Frames that were left out are counted: each would have a line of its own.
        if gap.lost + gap.incomplete == 0 {
            return;
        }
        tracing::warn!("{gap}");
        let Gap { first, next, lost, incomplete, dropped, why } = gap;
        self.event(
            "gap",
            json!({ "first": first, "last": next - 1, "lost": lost, "incomplete": incomplete, "dropped": dropped, "why": why }),
        );
    }

    /// A part that has left.
    pub(super) fn part(&mut self, part: &PartValue) {
        let (value, u) = (format!("diameter_{}", self.unit), format!("expanded_u_{}", self.unit));
        let mut keys = json!({ "part": part.number, "first": part.frames[0], "last": part.frames[1],
            "frames": part.count, value: part.value, u: part.expanded_u });
        if self.judges {
            keys["judgement"] = json!(part.word);
        }
        if self.settles {
            keys["settled"] = json!(part.is_settled);
        }
        self.event("part", keys);
        if self.json {
            return;
        }
        let [value, u] = stated(part.value, part.expanded_u);
        let word = if part.is_settled { part.word } else { "has not settled" };
        let (number, count, unit) = (part.number, part.count, self.unit);
        self.beside(&format!("part {number}: {value} {unit}, U {u} {unit}, {count} frames  {word}"));
    }

    /// No valid reading from here on.
    pub(super) fn invalid(&mut self, invalid: &Invalid) {
        self.event("invalid", json!({ "reason": invalid.word(), "why": invalid.to_string() }));
    }

    /// The alarm is raised.
    pub(super) fn alarm(&mut self, cause: &str) {
        tracing::error!("alarm: {cause}");
        self.event("alarm", json!({ "cause": cause }));
    }

    /// The line of now.
    pub(super) fn now(&self, now: &Now<'_>) {
        if !self.now.is_hidden() {
            self.now.set_message(self.now_text(now));
            self.now.tick();
        }
    }

    /// The counts at the end: of the source, of frames with a value and of parts.
    pub(super) fn end(&mut self, counters: &Counters, [measured, parts]: [u64; 2], pace: &Pace) {
        self.now.finish_and_clear();
        let [p50, p99] = [0.5, 0.99].map(|share| pace.latency_ms(share));
        let c = counters;
        self.event(
            "end",
            json!({ "delivered": c.delivered, "measured": measured, "dropped": c.dropped, "incomplete": c.incomplete, "lost": c.lost,
                "waiting": c.waiting, "repeated": c.repeated, "disappeared": c.disappeared, "parts": parts,
                "latency_p50_ms": p50, "latency_p99_ms": p99 }),
        );
        if self.json {
            return;
        }
        say_line!(
            "{} frames: {} taken and {measured} measured, {} left out, {} incomplete, {} lost, {} waiting; {parts} parts{}",
            c.accounted(),
            c.delivered,
            c.dropped,
            c.incomplete,
            c.lost,
            c.waiting,
            latency(pace).map_or_else(String::new, |text| format!("; {text}"))
        );
    }

    fn now_text(&self, now: &Now<'_>) -> String {
        let unit = self.unit;
        let mut text = match now.reading {
            Ok((value, u, word)) => {
                let [value, u] = stated(value, u);
                format!("{value} {unit} U {u}  {word}")
            }
            Err(invalid) => format!("INVALID: {invalid}"),
        };
        if let Some(slope) = now.slope.filter(Slope::is_trend) {
            let [slope, u] = stated(1e3 * slope.per_minute, 1e3 * slope.u_per_minute);
            let unit = if unit == "mm" { "µm" } else { "mpx" };
            text += &format!("  trend {slope} ± {u} {unit}/min");
        }
        if let Some(Profile { blocks, span }) = &now.profile {
            let unit = if unit == "mm" { "µm" } else { "mpx" };
            text += &format!("  {blocks} {:.1} {unit}", 1e3 * span);
        }
        if let Some(rate) = now.pace.rate_hz() {
            text += &format!("  {rate:.1}/s");
        }
        let c = now.counters;
        text += &format!("  lost {} incomplete {} left out {}", c.lost, c.incomplete, c.dropped);
        if let Some(latency) = latency(now.pace) {
            text += &format!("  {latency}");
        }
        if now.parts > 0 {
            text += &format!("  parts {}", now.parts);
        }
        now.alarm.map_or(text.clone(), |cause| format!("ALARM ({cause})  {text}"))
    }

    /// A line of JSON, on stdout and among the results that are saved; on other output nothing.
    fn event(&mut self, name: &str, keys: Value) {
        let Value::Object(mut all) = keys else { return };
        all.insert("event".to_owned(), name.into());
        self.line(&Value::Object(all));
    }

    /// A line of text above the line of now.
    fn beside(&self, text: &str) {
        progress::beside(|| say_line!("{text}"));
    }
}

fn latency(pace: &Pace) -> Option<String> {
    let [p50, p99] = [0.5, 0.99].map(|share| pace.latency_ms(share));
    Some(format!("latency {:.1} ms, p99 {:.1} ms", p50?, p99?))
}

/// The line of a frame: the keys of `measure`, then those of what is watched.
fn frame_line(frame: &ShownFrame<'_>) -> Value {
    let meta = frame.meta;
    let arrival = Arrival {
        device_t_ns: meta.device_t.map(|t| t.t_ns),
        host_t_ns: meta.host_t.map(|t| t.t_ns),
        lost: frame.missed.lost + frame.missed.incomplete,
        ..Arrival::default()
    };
    let mut all = line(json!(frame.measurement), &arrival, meta.sequence);
    if let Value::Object(keys) = &mut all {
        keys.extend(watched_keys(frame));
    }
    all
}

fn watched_keys(frame: &ShownFrame<'_>) -> Map<String, Value> {
    let meta = frame.meta;
    let known = |known: &Option<Known<f64>>| {
        known.map(|known| json!({ "value": known.value, "from": known.provenance.word() }))
    };
    let slope = frame
        .slope
        .map(|s| json!({ "per_min": s.per_minute, "u_per_min": s.u_per_minute, "is_trend": s.is_trend() }));
    let pairs = [
        ("device_clock", meta.device_t.map(|t| json!(t.clock.word()))),
        ("exposed_host_t_ns", meta.exposed_t.map(|t| t.t_ns.into())),
        ("dropped", Some(frame.missed.dropped.into())),
        ("valid", Some((frame.measurement.refusal.is_none() && frame.is_settled).into())),
        ("alarm", Some(frame.is_alarmed.into())),
        ("latency_ms", frame.latency_ms.map(Value::from)),
        ("trend", slope),
        ("angle_deg", known(&meta.angle_deg)),
        ("u_angle_deg", meta.u_angle_deg.map(Value::from)),
        ("coverage", frame.turn.as_ref().map(|turn| json!(turn))),
        ("z_mm", known(&meta.z_mm)),
        ("exposure_us", known(&meta.exposure_us)),
        ("gain_db", known(&meta.gain_db)),
        ("head_c", known(&meta.head_c)),
        ("saved", frame.saved.as_deref().map(Value::from)),
    ];
    let given = pairs.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?)));
    given.chain(frame.conditions.keys()).collect()
}
