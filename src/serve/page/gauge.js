"use strict";
// Gauge: window and drift, calibrations with their validity, check pins as a control chart, whether the store is whole.

const holds = (c) => (c.holds === null ? "unknown" : c.holds ? "valid" : "expired");
const pins = (c) => c.masters.map((m) => `${number(m.diameter_mm, 4)} ± ${number(m.expanded_u_um / 1e3, 4)}`).join(", ") || "–";

// Errors of the check pins with ±U as whiskers, in the order in which the calibrations were stored; 0 is a line.
function controlChart(all) {
  const checked = all.filter((c) => c.check && !c.unreadable).reverse();
  if (!checked.length) return { whole: element("p", { class: "muted" }, "No calibration with a check pin yet.") };
  const place = element("div", { class: "plot", role: "img", "aria-label": "Error of the check pin by calibration, with its expanded uncertainty; accepted where a whisker reaches 0" });
  const [x, error, u] = [checked.map((_, k) => k + 1), checked.map((c) => c.check.error_um), checked.map((c) => c.check.expanded_u_um)];
  const most = 1.1 * Math.max(...error.map((e, k) => Math.abs(e) + u[k]));
  const whiskers = (shown) => {
    const { ctx } = shown, px = (value, scale) => Math.round(shown.valToPos(value, scale, true)) + 0.5, lines = [];
    x.forEach((at, k) => { lines.push([[px(at, "x"), px(error[k] - u[k], "y")], [px(at, "x"), px(error[k] + u[k], "y")]]); });
    lines.push([[shown.bbox.left, px(0, "y")], [shown.bbox.left + shown.bbox.width, px(0, "y")]]);
    ctx.save();
    ctx.strokeStyle = colour("--ink");
    ctx.lineWidth = window.devicePixelRatio || 1;
    for (const [from, to] of lines) { ctx.beginPath(); ctx.moveTo(...from); ctx.lineTo(...to); ctx.stroke(); }
    ctx.restore();
  };
  const draw = () => {
    const axis = { stroke: colour("--ink"), grid: { stroke: colour("--shade") }, ticks: { stroke: colour("--rule") } };
    const width = () => Math.max(place.clientWidth, 280);
    const shown = new uPlot({
      width: width(), height: 260, hooks: { draw: [whiskers] },
      scales: { x: { time: false, range: [0.5, x.length + 0.5] }, y: { range: [-most, most] } },
      series: [{ label: "calibration with a check pin" }, { label: "error of the pin / µm", stroke: colour("--line"), width: 0, paths: () => null, points: { show: true, size: 9, fill: colour("--line") }, value: (_, v) => number(v, 2) }],
      axes: [{ ...axis, label: "calibration with a check pin", incrs: [1, 2, 5, 10, 20, 50] }, { ...axis, label: "error of the pin / µm", size: 84 }],
    }, [x, error], place);
    const resize = () => shown.setSize({ width: width(), height: 260 });
    window.addEventListener("resize", resize);
    return { end: () => { window.removeEventListener("resize", resize); shown.destroy(); } };
  };
  return { whole: place, draw };
}

// A store of this size is checked in a second: larger ones where it is asked for.
const CHECKED_AT_ONCE = 32 * 2 ** 20;

const found = (store) => [
  element("dl", {}, ...[["Runs", store.runs], ["Passes", store.passes], ["Stations", store.stations]].flatMap(([t, v]) => [element("dt", {}, t), element("dd", {}, String(v))])),
  element("p", { class: store.findings.length ? "bad" : "good", role: "status" }, store.findings.length ? `${store.findings.length} things do not fit together:` : "Everything is as it was stored."),
  element("ul", {}, ...store.findings.slice(0, 100).map((f) => element("li", {}, f)))];

// The newest row of the audit, and the last check: made again where the store was written since.
async function storeState(place) {
  const store = await api("store/state");
  const rows = [["Size", `${number(store.bytes / 2 ** 20, 1)} MiB`], ["Rows of the audit", store.audit_rows], ["Newest row", store.head || "–"]];
  const result = element("div"), button = element("button", { type: "button" }, "Check the store");
  button.onclick = async () => {
    button.disabled = true;
    result.replaceChildren(element("p", { role: "status" }, "being checked …"));
    try { result.replaceChildren(...found(await api("store"))); said(); } catch (error) { said(error); result.replaceChildren(); } finally { button.disabled = false; }
  };
  place.replaceChildren(element("dl", {}, ...rows.flatMap(([t, v]) => [element("dt", {}, t), element("dd", {}, String(v))])), element("p", {}, button), result);
  if (store.checked) return result.replaceChildren(...found(store.checked));
  if (store.bytes <= CHECKED_AT_ONCE) return button.onclick();
  result.replaceChildren(element("p", { class: "muted" }, store.checked_utc ? `written to since the check of ${store.checked_utc.slice(0, 19)}Z` : "not checked yet"));
}

async function gauge() {
  const list = element("div"), state = element("div"), source = health();
  let chart = null, made = null;
  // a plot takes the width of its place, which it has once it is on the page
  const draw = () => { chart = made?.draw?.() ?? null; };
  const load = async () => {
    const all = await api("calibrations");
    chart?.end();
    made = controlChart(all);
    const calibrations = all.map((c) => c.unreadable ? row(c.utc.slice(0, 19) + "Z", element("span", { class: "bad", title: c.id }, `unreadable: ${c.unreadable}`), "–", "–", "–", "–", "–", "–", "–") : row(c.utc.slice(0, 19) + "Z", c.optics_id || "of a run", c.expires ?? "–", element("span", { class: c.holds === false ? "bad" : "" }, holds(c)),
      `${number(c.scale_um_per_px, 5)} ± ${number(2 * c.u_scale_um_per_px, 5)}`, `${number(c.offset_um, 2)} ± ${number(2 * c.u_offset_um, 2)}`,
      c.check ? `${number(c.check.error_um, 2)} ± ${number(c.check.expanded_u_um, 2)}` : "–", c.check ? number(c.check.e_n, 2) : "–", pins(c)));
    list.replaceChildren(all.length ? table(["stored", "setup", "valid to", "today", "scale / (µm/px)", "edge offset / µm", "check pin / µm", "Eₙ", "masters / mm"], calibrations) : element("p", {}, "No calibration yet."), element("h3", {}, "Check pins"), made.whole);
    if (list.isConnected) draw();
    await storeState(state);
  };
  const [given, config] = [file("calibration-file", ".json"), text("calibration-config")];
  given.required = true;
  config.required = true;
  await source.load().catch(said);
  await load().catch((error) => { list.replaceChildren(element("p", {}, error.message)); state.replaceChildren(); });
  main.replaceChildren(element("h1", {}, "Gauge"), source.whole, element("h2", {}, "Calibrations"), list,
    element("details", {}, element("summary", {}, "Add a calibration"), sending(() => api("calibrations", { method: "POST", body: given.files[0] }), load, "Add calibration", ...field("File of calibrate --out (JSON, 16 MiB at most)", given))),
    element("details", {}, element("summary", {}, "Calibrate a simulated setup"), sending(() => api("calibrations/simulated", json("POST", { config: config.value })), load, "Calibrate", ...field("Plan with [simulate] (TOML)", config))),
    element("h2", {}, "Store"), state);
  draw();
  source.load().catch(said);
  return () => { chart?.end(); source.end(); };
}
