"use strict";
// Live: the diameter of now, its trend, the frame, events.

function live() {
  const now = element("p", { class: "now", "aria-live": "off" }, "–");
  const under = element("p", { class: "under" }, "waiting for the source");
  const counts = element("p", { class: "under" }, "no frame yet");
  const place = element("div", { class: "plot", role: "img", "aria-label": "Diameter of the last 500 frames" });
  const events = element("ul"), frames = picture();
  main.replaceChildren(element("h1", {}, "Live"), element("div", { class: "watch" }, element("section", {}, now, under, place, counts), frames.frame), frames.profile, element("h2", {}, "Events"), events);
  const x = [], y = [], u = [];
  let frame = 0, lost = 0, drawn = 0, shown = null;
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
  source.onmessage = (message) => {
    const line = JSON.parse(message.data);
    if (line.event === "invalid") return stop(line.why || line.reason);
    if (line.event) {
      if (line.event === "gap") lost += (line.lost || 0) + (line.incomplete || 0);
      const text = line.event === "part" ? `part ${line.part}: ${number(line.diameter_mm, 4)} mm ± ${number(line.expanded_u_mm, 4)} ${line.judgement || ""}` : JSON.stringify(line);
      events.prepend(element("li", {}, text));
      while (events.children.length > 20) events.lastChild.remove();
      return;
    }
    frame += 1;
    const d = line.max_diameter_mm ?? null;
    const expanded = line.expanded_u_max_mm ?? null;
    if (!line.valid || d === null) stop(line.error || line.refused || "no diameter in this frame");
    else {
      now.textContent = number(d, 4) + " mm";
      now.className = "now " + ({ GO: "good", LL: "bad", HH: "bad", LO: "open", HI: "open" }[line.judgement] || "");
      const settled = line.settled && line.settled.state ? `, ${line.settled.state}` : "";
      under.textContent = `± ${number(expanded, 4)} mm (U)${line.judgement ? ", " + line.judgement : ""}${settled}`;
    }
    x.push(frame); y.push(line.valid ? d : null); u.push(expanded);
    if (x.length > 500) { x.shift(); y.shift(); u.shift(); }
    const t = performance.now();
    if (t - drawn > 100) {
      drawn = t;
      const at = (sign) => y.map((v, k) => (v === null || u[k] === null ? null : v + sign * u[k]));
      // drawn once there is a value: a plot without one has no axes, and moves when they come
      shown ??= plot(place, x, y, u, { xLabel: "frame", yLabel: "D / mm", digits: 4 });
      shown.set([x, y, at(1), at(-1)]);
      counts.textContent = `${frame} frames, ${lost} lost, ${number(line.latency_ms, 1)} ms from arrival to diameter`;
    }
  };
  return () => { source.close(); shown?.end(); frames.end(); };
}

