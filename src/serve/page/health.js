"use strict";
// Gauge: window and drift of the source that is watched, now and over the last day.

const since = (s) => (s < 3600 ? `${number(s / 60, 1)} min` : `${number(s / 3600, 2)} h`);

function windowWords(h) {
  const w = h.window;
  if (!w) return h.is_now ? "too little of the field is lit to look at the light" : "no source is watched now (serve --source)";
  return `darkest place ${number(w.darkest_percent, 2)} % at row ${w.darkest_at_px[0]}, column ${w.darkest_at_px[1]}, brightest ${number(w.brightest_percent, 2)} % of the median (${w.of_flat ? "since the calibrated flat" : "no flat field is calibrated: with the lamp's own unevenness"})`;
}

function driftWords(h) {
  const d = h.drift;
  if (d) return `zero ${since(d.since_zero_s)} ago, head ${number(d.head_k, 2)} K since; u of a diameter by it ${number(d.u_drift_um, 3)} µm`;
  return h.is_now ? "the source states no zero (-- --zero FILE.csv --zero-interval-s S), or the last frame is refused" : "no source is watched now (serve --source)";
}

// Window and drift, with their course where there are two minutes at least.
function health() {
  const figures = element("dl"), light = element("div", { class: "plot", role: "img", "aria-label": "Darkest place of the window by the minute, % of the median" });
  const none = element("p", { class: "muted" }, "The course by the minute begins with the second minute of a source.");
  // the plot has its place from the beginning: nothing below it moves when it comes
  light.append(none);
  const whole = element("section", {}, element("h2", {}, "Window and drift"), figures, light);
  let shown = null;
  async function load() {
    const h = await api("gauge");
    const last = h.minutes.at(-1), refused = Object.entries(h.refused).map(([reason, n]) => `${n} ${reason.replaceAll("_", " ")}`).join(", ");
    const rows = [["Window", windowWords(h)],
      ["Contaminated columns, this minute", last && last.contaminated_percent !== null ? `${number(last.contaminated_percent, 2)} % of ${last.frames} frames` : "–"],
      ["Refused frames, this minute", refused || (h.is_now ? "none" : "–")], ["Drift since zero", driftWords(h)]];
    if (h.why) rows.push(["Last frame", h.why]);
    figures.replaceChildren(...rows.flatMap(([t, v]) => [element("dt", {}, t), element("dd", {}, v)]));
    const seen = h.minutes.filter((m) => m.darkest_percent !== null);
    if (seen.length < 2 || !whole.isConnected) return;
    none.remove();
    const x = seen.map((m) => (Date.parse(m.utc) - Date.parse(seen.at(-1).utc)) / 60000);
    const lines = [seen.map((m) => m.darkest_percent), seen.map((m) => m.contaminated_percent), seen.map((m) => m.u_drift_um)];
    if (shown) return shown.setData([x, ...lines]);
    const axis = { stroke: colour("--ink"), grid: { stroke: colour("--shade") }, ticks: { stroke: colour("--rule") } };
    shown = new uPlot({
      width: Math.max(light.clientWidth, 280), height: 260, scales: { x: { time: false }, um: {} },
      series: [{ label: "minutes before now" }, { label: "darkest place / %", stroke: colour("--line"), width: 2, value: (_, v) => number(v, 2) }, { label: "contaminated columns / %", stroke: colour("--bad"), width: 1.5, dash: [6, 4], value: (_, v) => number(v, 2) }, { label: "u by drift / µm", scale: "um", stroke: colour("--open"), width: 1.5, value: (_, v) => number(v, 3) }],
      axes: [{ ...axis, label: "minutes before now" }, { ...axis, label: "%", size: 70 }, { ...axis, scale: "um", side: 1, label: "u by drift / µm", grid: { show: false } }],
    }, [x, ...lines], light);
  }
  const resized = () => shown?.setSize({ width: Math.max(light.clientWidth, 280), height: 260 });
  window.addEventListener("resize", resized);
  const timer = setInterval(() => { if (!document.hidden) load().catch(said); }, 2000);
  return { whole, load, end: () => { clearInterval(timer); window.removeEventListener("resize", resized); shown?.destroy(); } };
}
