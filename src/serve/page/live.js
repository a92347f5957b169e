"use strict";
// Live: the diameter of now, its trend between the limits, what was lost and refused, set-up aids, events.

const words = { gap: "frames lost", alarm: "ALARM", invalid: "invalid", end: "the source has ended" };

function eventWords(line) {
  if (line.event === "part") return `part ${line.part}: ${number(line.diameter_mm ?? line.diameter_px, 4)} ${line.diameter_mm === undefined ? "px" : "mm"} ± ${number(line.expanded_u_mm ?? line.expanded_u_px, 4)} ${line.judgement || ""}`;
  if (line.event === "gap") return `frames ${line.first} to ${line.last}: ${line.lost} lost, ${line.incomplete} incomplete${line.why ? `: ${line.why}` : ""}`;
  return `${words[line.event] ?? line.event}: ${line.cause ?? line.why ?? line.reason ?? ""}`;
}

// What focus, alignment and light are set by, as `watch --setup` has them.
function aids(line) {
  const three = (all) => (all ? all.map((px) => number(px, 2)).join(" / ") : "–");
  const { light = {}, edges, evenness } = line;
  const factor = light.exposure_factor, percent = (share, digits) => (share === null || share === undefined ? "–" : `${number(100 * share, digits)} %`);
  const rows = edges ? [
    ["Blur of the upper edge, left / middle / right", `${three(edges.blur_px?.[0])} px`], ["Blur of the lower edge", `${three(edges.blur_px?.[1])} px`],
    ["Slope of the axis", `${number(edges.tilt_deg, 3)}°`], ["Contrast, over noise", `${number(edges.contrast, 3)}, ${number(edges.snr, 0)}`],
    ["Gradient, upper and lower", `${(edges.gradient_counts_per_px ?? []).map((g) => number(g, 1)).join(", ")} counts/px`]] : [["Edges", line.why || "none in this frame"]];
  rows.push(["Light", `${number(light.brightest_counts, 0)} counts, ${percent(light.of_full_scale, 1)} of full scale, ${percent(light.saturated_share, 3)} saturated`],
    ["Exposure", light.exposure_us !== null && light.exposure_us !== undefined ? `${number(light.exposure_us, 1)} µs brings the light to 80 %` : factor ? `${number(factor, 2)} times as long brings the light to 80 %` : "–"],
    ["Evenness", evenness ? `${percent(evenness.lowest, 1)} at row ${evenness.lowest_row}, column ${evenness.lowest_column}, to ${percent(evenness.highest, 1)} of the median (${evenness.of_flat ? "against the calibrated flat" : "no flat field is calibrated"})` : "too little of the field is lit"]);
  return rows.flatMap(([t, v]) => [element("dt", {}, t), element("dd", {}, v)]);
}

function live() {
  const now = element("p", { class: "now", "aria-live": "off" }, "–");
  const under = element("p", { class: "under" }, "waiting for the source");
  const counts = element("p", { class: "under" }, "no frame yet");
  const bands = element("p", { class: "under" }, "no tolerance is given (watch --tolerance)");
  const place = element("div", { class: "plot", role: "img", "aria-label": "Diameter of the last 500 frames, with the limits of the tolerance and the guard bands inside them" });
  const events = element("ul"), frames = picture(), set = element("dl", {}, element("dt", {}, "Set-up"), element("dd", {}, "no frame yet"));
  main.replaceChildren(element("h1", {}, "Live"), element("div", { class: "watch" }, element("section", {}, now, under, place, bands, counts), frames.frame),
    frames.along, frames.profile, element("details", {}, element("summary", {}, "Set-up aids: focus, alignment, light"), set), element("h2", {}, "Events"), events);
  const x = [], y = [], u = [], limits = [[], [], [], []], refused = {};
  let frame = 0, lost = 0, left = 0, drawn = 0, shown = null;
  const stop = (why) => {
    now.textContent = "invalid";
    now.className = "now bad";
    under.textContent = why;
  };
  const source = new EventSource("api/live");
  source.onerror = () => {
    stop("no connection to the server");
    // a stream does not say why it ended: where a token is needed, this asks for it
    api("jobs").then(() => said(), said);
  };
  const trend = (t) => (t ? `, ${t.is_trend ? "trend" : "no trend:"} ${number(1e3 * t.per_min, 2)} ± ${number(1e3 * t.u_per_min, 2)} µm/min` : "");
  // limits of the tolerance, and the guard bands inside them: only between these is GO proven (ISO 14253-1)
  function limitsOf(line) {
    const [low, high] = line.limits_mm ?? [null, null], guard = line.judged?.guard_mm ?? null;
    [low, high, low === null || guard === null ? null : low + guard, high === null || guard === null ? null : high - guard].forEach((v, k) => limits[k].push(v));
    if (line.limits_mm) bands.textContent = `limits ${number(low, 4)} and ${number(high, 4)} mm; guard band ${guard === null ? "leaves no zone of acceptance" : number(1e3 * guard, 2) + " µm"}`;
  }
  function draw() {
    const at = (sign) => y.map((v, k) => (v === null || u[k] === null ? null : v + sign * u[k]));
    // drawn once there is a value: a plot without one has no axes, and moves when they come
    if (!shown && y.some((v) => v !== null)) {
      const lines = limits.map((values, k) => ({ label: ["lower limit", "upper limit", "proven above", "proven below"][k], values, stroke: colour(k < 2 ? "--bad" : "--good"), dash: k < 2 ? [] : [6, 4] }));
      shown = plot(place, x, y, u, { xLabel: "frame", yLabel: "D / mm", digits: 4, lines: limits[0].some((v) => v !== null) ? lines : [] });
    }
    shown?.set([x, y, at(1), at(-1), ...(limits[0].some((v) => v !== null) ? limits : [])]);
  }
  source.onmessage = (message) => {
    const line = JSON.parse(message.data);
    if (line.event === "setup") return set.replaceChildren(...aids(line));
    if (line.event === "invalid") stop(line.why || line.reason);
    if (line.event) {
      if (line.event === "gap") lost += (line.lost || 0) + (line.incomplete || 0);
      events.prepend(element("li", { class: line.event === "part" ? "" : "bad" }, eventWords(line)));
      while (events.children.length > 20) events.lastChild.remove();
      return;
    }
    frame += 1;
    left += line.dropped || 0;
    const d = line.max_diameter_mm ?? null;
    const expanded = line.expanded_u_max_mm ?? null;
    const settled = line.settled && line.settled.state ? line.settled.state : "";
    if (!line.valid || d === null) {
      const why = line.warnings?.[0] ?? line.error ?? (settled ? `has not settled: ${settled}` : line.max_diameter_px ? `${number(line.max_diameter_px, 3)} px: no scale is given` : "no diameter in this frame");
      const reason = settled && !line.warnings ? "not settled" : Object.keys(line.flags ?? {})[0] ?? why;
      if (!line.valid) refused[reason] = (refused[reason] || 0) + 1;
      stop(why);
    } else {
      now.textContent = number(d, 4) + " mm";
      now.className = "now " + ({ GO: "good", LL: "bad", HH: "bad", LO: "open", HI: "open" }[line.judgement] || "");
      under.textContent = `± ${number(expanded, 4)} mm (U)${line.judgement ? ", " + line.judgement : ""}${settled ? ", " + settled : ""}${trend(line.trend)}`;
    }
    x.push(frame); y.push(line.valid ? d : null); u.push(expanded);
    limitsOf(line);
    if (x.length > 500) [x, y, u, ...limits].forEach((all) => all.shift());
    const t = performance.now();
    if (t - drawn > 100) {
      drawn = t;
      draw();
      const why = Object.entries(refused).map(([reason, n]) => `${n} ${reason.replaceAll("_", " ")}`).join(", ");
      counts.textContent = `${frame} frames, ${lost} lost, ${left} left out, refused: ${why || "none"}; ${number(line.latency_ms, 1)} ms from arrival to diameter`;
    }
  };
  return () => { source.close(); shown?.end(); frames.end(); };
}
