"use strict";
// Live, runs, history, gauge: each page is a function that fills <main> and returns what ends it.

const main = document.getElementById("main");
const problem = document.getElementById("problem");
let leave = () => {};

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "onclick" || name === "onsubmit" || name === "oninput") made[name] = value;
    else if (value !== null && value !== undefined) made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

const number = (value, digits) => (value === null || value === undefined ? "–" : value.toFixed(digits));

async function api(path, options = {}) {
  const changes = options.method && options.method !== "GET";
  const headers = changes ? { "content-type": "application/json", "x-shadowgauge": "1" } : {};
  const answer = await fetch("api/" + path, { ...options, headers });
  if (answer.status === 401) {
    askToken();
    throw new Error("a token is needed");
  }
  if (!answer.ok) {
    const words = await answer.json().catch(() => ({ error: answer.statusText }));
    throw new Error(words.error);
  }
  const type = answer.headers.get("content-type") || "";
  return type.includes("json") ? answer.json() : null;
}

function askToken() {
  const token = window.prompt("Token for this gauge:");
  if (token) {
    document.cookie = "shadowgauge_token=" + encodeURIComponent(token) + "; SameSite=Strict; path=/";
    show();
  }
}

const said = (error) => { problem.textContent = error ? String(error.message || error) : ""; };
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// A line with a band of ±U below and above it, over x with its unit.
function plot(place, x, value, band, { xLabel, yLabel, digits }) {
  const series = [
    { label: xLabel },
    { label: yLabel, stroke: colour("--line"), width: 2, points: { show: x.length < 60 }, value: (_, v) => number(v, digits) },
    { label: "+U", stroke: "transparent", value: (_, v) => number(v, digits), points: { show: false } },
    { label: "−U", stroke: "transparent", value: (_, v) => number(v, digits), points: { show: false } },
  ];
  const up = value.map((v, k) => (v === null || band[k] === null ? null : v + band[k]));
  const down = value.map((v, k) => (v === null || band[k] === null ? null : v - band[k]));
  const axis = { stroke: colour("--ink"), grid: { stroke: colour("--shade") }, ticks: { stroke: colour("--rule") } };
  const shown = new uPlot({
    width: Math.max(place.clientWidth, 280), height: 260,
    scales: { x: { time: false } },
    series, bands: [{ series: [2, 3], fill: colour("--band") }],
    axes: [{ ...axis, label: xLabel }, { ...axis, label: yLabel, size: 84, values: (_, all) => all.map((v) => number(v, digits)) }],
  }, [x, value, up, down], place);
  const resize = () => shown.setSize({ width: Math.max(place.clientWidth, 280), height: 260 });
  window.addEventListener("resize", resize);
  return { set: (data) => shown.setData(data), end: () => { window.removeEventListener("resize", resize); shown.destroy(); } };
}

function live() {
  const now = element("p", { class: "now", "aria-live": "off" }, "–");
  const under = element("p", { class: "under" }, "waiting for the source");
  const counts = element("p", { class: "under" });
  const place = element("div", { class: "plot", role: "img", "aria-label": "Diameter of the last 500 frames" });
  const events = element("ul");
  main.replaceChildren(element("h1", {}, "Live"), now, under, place, counts, element("h2", {}, "Events"), events);
  const x = [], y = [], u = [];
  const shown = plot(place, x, y, u, { xLabel: "frame", yLabel: "D / mm", digits: 4 });
  let frame = 0, lost = 0, drawn = 0;
  const stop = (why) => {
    now.textContent = "invalid";
    now.className = "now bad";
    under.textContent = why;
  };
  const source = new EventSource("api/live");
  source.onerror = () => stop("no connection to the server");
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
      shown.set([x, y, at(1), at(-1)]);
      counts.textContent = `${frame} frames, ${lost} lost, ${number(line.latency_ms, 1)} ms from arrival to diameter`;
    }
  };
  return () => { source.close(); shown.end(); };
}

function runs() {
  const list = element("tbody"), jobs = element("div"), more = element("p");
  const filter = element("input", { id: "filter", oninput: () => { offset = 0; load(); } });
  let offset = 0;
  const name = element("input", { id: "name", maxlength: "64", required: "" });
  const config = element("textarea", { id: "config", spellcheck: "false", required: "" });
  const form = element("form", { onsubmit: async (event) => {
    event.preventDefault();
    try {
      await api("runs", { method: "POST", body: JSON.stringify({ run: name.value, config: config.value }) });
      said(); form.reset(); load();
    } catch (error) { said(error); }
  } }, element("label", { for: "name" }, "Name"), name, element("label", { for: "config" }, "Config (TOML)"), config, element("p", {}, element("button", {}, "Start")));
  main.replaceChildren(
    element("h1", {}, "Runs"),
    element("label", { for: "filter" }, "Names that contain"), filter,
    element("div", { class: "scroll" }, element("table", {}, element("thead", {}, element("tr", {}, ...["run", "passes", "largest error / µm", "state"].map((t) => element("th", { scope: "col" }, t)))), list)),
    more, jobs,
    element("details", {}, element("summary", {}, "Start a simulated run"), form));
  const act = (run, what) => element("button", { onclick: () => api(`runs/${encodeURIComponent(run)}/${what}`, { method: "POST" }).then(() => { said(); load(); }, said) }, what);
  async function load() {
    try {
      const answer = await api(`runs?offset=${offset}&limit=50&name=${encodeURIComponent(filter.value)}`);
      const started = await api("jobs");
      list.replaceChildren(...answer.runs.map((r) => element("tr", {},
        element("td", {}, element("a", { href: "#run/" + encodeURIComponent(r.run) }, r.run)),
        element("td", {}, String(r.passes)),
        element("td", {}, r.max_abs_error_mm === null ? "–" : number(1e3 * r.max_abs_error_mm, 2)),
        element("td", {}, r.finished ? "finished" : started.some((j) => j.run === r.run && j.running) ? "running" : "unfinished"))));
      const step = (to, text) => element("button", { onclick: () => { offset = to; load(); } }, text);
      more.replaceChildren(`${answer.total} runs `, offset > 0 ? step(Math.max(0, offset - 50), "earlier") : null || "", offset + 50 < answer.total ? step(offset + 50, "later") : "");
      jobs.replaceChildren(...started.map((j) => element("section", {}, element("h2", {}, j.run), element("p", {}, j.running ? "running " : `ended (${j.exit ?? "stopped"}) `, j.running ? act(j.run, "stop") : act(j.run, "resume")), element("pre", {}, j.log.slice(-8).join("\n")))));
    } catch (error) { said(error); }
  }
  load();
  const timer = setInterval(load, 2000);
  return () => clearInterval(timer);
}

async function run(name) {
  const detail = await api("runs/" + encodeURIComponent(name));
  const plots = [];
  const rows = detail.passes.map((p) => element("tr", {}, ...[p.pass, number(p.nominal_mm, 3), number(1e3 * p.max_abs_error_mm, 2), p.decision].map((t) => element("td", {}, String(t)))));
  main.replaceChildren(
    element("h1", {}, name),
    element("p", {}, detail.finished ? element("a", { href: `api/runs/${encodeURIComponent(name)}/report` }, "Report") : "unfinished"),
    element("div", { class: "scroll" }, element("table", {}, element("thead", {}, element("tr", {}, ...["pass", "nominal / mm", "largest error / µm", "decision"].map((t) => element("th", { scope: "col" }, t)))), element("tbody", {}, ...rows))));
  for (const p of detail.passes) {
    const place = element("div", { class: "plot", role: "img", "aria-label": `Pass ${p.pass}: measured minus nominal along z` });
    main.append(element("h2", {}, `Pass ${p.pass}: measured − nominal`), place);
    const error = p.d_mm.map((d) => (d === null ? null : 1e3 * (d - p.nominal_mm)));
    const band = p.u_mm.map((v) => (v === null ? null : 2e3 * v));
    plots.push(plot(place, p.z_mm, error, band, { xLabel: "z / mm", yLabel: "error / µm", digits: 2 }));
  }
  main.append(element("details", {}, element("summary", {}, "Config"), element("pre", {}, detail.config)));
  return () => plots.forEach((p) => p.end());
}

function history() {
  const from = element("input", { id: "from", type: "date" }), to = element("input", { id: "to", type: "date" });
  const place = element("div"), text = element("p");
  let shown = null;
  async function load(event) {
    event?.preventDefault();
    try {
      const answer = await api(`history?from=${from.value}&to=${to.value}`);
      said();
      shown?.end();
      const good = answer.stations.filter((s) => s.d_mm !== null);
      text.textContent = `${answer.stations.length} stations${answer.more ? " and more: take fewer days" : ""}, ${answer.stations.length - good.length} without a diameter`;
      const chart = element("div", { class: "plot", role: "img", "aria-label": "Diameters in the order in which they were stored" });
      const table = element("tbody", {}, ...answer.stations.slice(-200).reverse().map((s) => element("tr", {}, ...[s.utc, s.name, s.pass, number(s.z_mm, 3), number(s.d_mm, 5), s.u_mm === null ? "–" : number(1e3 * s.u_mm, 2), s.flag || ""].map((t) => element("td", {}, String(t))))));
      place.replaceChildren(chart, element("div", { class: "scroll" }, element("table", {}, element("thead", {}, element("tr", {}, ...["stored", "run", "pass", "z / mm", "D / mm", "u / µm", "flag"].map((t) => element("th", { scope: "col" }, t)))), table)));
      if (good.length) shown = plot(chart, good.map((_, k) => k + 1), good.map((s) => s.d_mm), good.map((s) => (s.u_mm === null ? null : 2 * s.u_mm)), { xLabel: "station", yLabel: "D / mm", digits: 4 });
    } catch (error) { said(error); }
  }
  main.replaceChildren(element("h1", {}, "History"), element("form", { onsubmit: load }, element("label", { for: "from" }, "First day (UTC)"), from, element("label", { for: "to" }, "Last day"), to, element("p", {}, element("button", {}, "Show"))), text, place);
  load();
  return () => shown?.end();
}

async function gauge() {
  const store = await api("store").catch((error) => ({ missing: error.message }));
  const rows = store.missing ? [] : [["Runs", store.runs], ["Passes", store.passes], ["Stations", store.stations], ["Rows of the audit", store.audit_rows], ["Newest row", store.head || "–"]];
  main.replaceChildren(
    element("h1", {}, "Gauge"),
    store.missing ? element("p", {}, store.missing) : element("dl", {}, ...rows.flatMap(([t, v]) => [element("dt", {}, t), element("dd", {}, String(v))])),
    store.missing ? null : element("p", { class: store.findings.length ? "bad" : "good" }, store.findings.length ? `${store.findings.length} things do not fit together:` : "Everything is as it was stored."),
    element("ul", {}, ...(store.findings || []).slice(0, 100).map((f) => element("li", {}, f))));
  return () => {};
}

async function show() {
  const [page, argument] = (location.hash.slice(1) || "live").split("/");
  const pages = { live, runs, run, history, gauge };
  leave();
  leave = () => {};
  said();
  for (const link of document.querySelectorAll("nav a")) {
    if (link.hash === "#" + (page === "run" ? "runs" : page)) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  document.title = `${page} – shadowgauge`;
  try {
    leave = await (pages[page] || live)(argument && decodeURIComponent(argument));
  } catch (error) {
    main.replaceChildren(element("h1", {}, page));
    said(error);
  }
}

window.addEventListener("hashchange", show);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
show();
