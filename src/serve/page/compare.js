"use strict";
// Passes of one run or of several, in one plot and one table.

const dashes = [[], [8, 4], [2, 3], [8, 3, 2, 3], [12, 6]];
const strokes = () => ["--line", "--bad", "--good", "--open", "--ink"].map(colour);

// Errors of passes over z, each with a colour and a dash of its own; stations of different runs need not agree.
function passesPlot(place, all) {
  const z = [...new Set(all.flatMap((p) => p.z_mm))].sort((a, b) => a - b);
  const series = all.map((p, k) => {
    const at = new Map(p.z_mm.map((value, j) => [value, p.d_mm[j] === null ? null : 1e3 * (p.d_mm[j] - p.nominal_mm)]));
    return { label: p.label, stroke: strokes()[k % 5], dash: dashes[Math.floor(k / 5) % 5], width: 2, points: { show: false }, value: (_, v) => number(v, 2), of: z.map((value) => at.get(value)) };
  });
  // undefined: a station that this pass does not have, which is passed over; null: one without a diameter, a gap
  const data = [z, ...series.map((s) => s.of)];
  const axis = { stroke: colour("--ink"), grid: { stroke: colour("--shade") }, ticks: { stroke: colour("--rule") } };
  const width = () => Math.max(place.clientWidth, 280);
  const shown = new uPlot({ width: width(), height: 300, scales: { x: { time: false } }, series: [{ label: "z / mm" }, ...series], axes: [{ ...axis, label: "z / mm" }, { ...axis, label: "measured − nominal / µm", size: 84 }] }, data, place);
  const resize = () => shown.setSize({ width: width(), height: 300 });
  window.addEventListener("resize", resize);
  return { end: () => { window.removeEventListener("resize", resize); shown.destroy(); } };
}

// Runs beside each other: #compare/a,b (their last passes), a pass of each in a row.
async function compare(names) {
  const runs = await Promise.all((names ?? "").split(",").filter(Boolean).slice(0, 10).map((name) => api("runs/" + encodeURIComponent(name))));
  const lasts = runs.filter((r) => r.passes.length).map((r) => ({ ...r.passes.at(-1), label: `${r.run}, pass ${r.passes.at(-1).pass}` }));
  const most = Math.max(0, ...runs.map((r) => r.passes.length));
  const cell = (r, k) => (r.passes[k] ? `${number(1e3 * r.passes[k].max_abs_error_mm, 2)} (${r.passes[k].decision})` : "–");
  const rows = Array.from({ length: most }, (_, k) => row(String(k + 1), ...runs.map((r) => cell(r, k))));
  const place = element("div", { class: "plot", role: "img", "aria-label": `Last passes of ${runs.map((r) => r.run).join(", ")}: measured minus nominal along z` });
  main.replaceChildren(element("h1", {}, "Runs compared"), element("p", {}, ...runs.flatMap((r) => [element("a", { href: "#run/" + encodeURIComponent(r.run) }, r.run), " "])),
    table(["pass", ...runs.map((r) => `${r.run}: largest error / µm`)], rows), element("h2", {}, "Last passes: measured − nominal"), place);
  const shown = lasts.length ? passesPlot(place, lasts) : null;
  if (!shown) place.replaceWith(element("p", {}, "None of them has a pass yet."));
  return () => shown?.end();
}
