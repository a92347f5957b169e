"use strict";
// Runs: the list, those that were started here, one of them.

async function runs() {
  const list = element("div"), jobs = element("div"), more = element("p");
  const filter = element("input", { id: "filter", oninput: () => { offset = 0; load(); } });
  let offset = 0;
  const name = element("input", { id: "name", maxlength: "64", required: "" });
  const config = element("textarea", { id: "config", spellcheck: "false", required: "" });
  const configured = configForm(config);
  const form = element("form", { onsubmit: async (event) => {
    event.preventDefault();
    try {
      await api("runs", { method: "POST", body: JSON.stringify({ run: name.value, config: config.value }) });
      said(); form.reset(); load();
    } catch (error) { said(error); }
  } }, element("label", { for: "name" }, "Name"), name, element("div", { class: "beside" }, element("section", {}, element("label", { for: "config" }, "Config (TOML)"), config), configured.whole), element("p", {}, element("button", {}, "Start")));
  const starting = element("details", {}, element("summary", {}, "Start a simulated run"), form);
  starting.addEventListener("toggle", () => { if (starting.open) configured.load().catch(said); });
  const chosen = new Set(), together = element("button", { type: "button", disabled: "", onclick: () => { location.hash = `#compare/${encodeURIComponent([...chosen].join(","))}`; } }, "Compare chosen runs");
  const choice = (name) => {
    const box = element("input", { type: "checkbox", "aria-label": `Compare ${name}` });
    box.checked = chosen.has(name);
    box.addEventListener("change", () => { if (box.checked) chosen.add(name); else chosen.delete(name); together.disabled = chosen.size < 2; });
    return box;
  };
  const all = [
    element("h1", {}, "Runs"),
    element("label", { for: "filter" }, "Names that contain"), filter,
    list, element("p", {}, together), more, jobs, starting];
  const act = (run, what) => element("button", { onclick: () => api(`runs/${encodeURIComponent(run)}/${what}`, { method: "POST" }).then(() => { said(); load(); }, said) }, what);
  async function load() {
    try {
      const answer = await api(`runs?offset=${offset}&limit=50&name=${encodeURIComponent(filter.value)}`);
      const started = await api("jobs");
      list.replaceChildren(table(["run", "passes", "largest error / µm", "state", "compare"], answer.runs.map((r) => row(
        element("a", { href: "#run/" + encodeURIComponent(r.run) }, r.run), String(r.passes),
        r.max_abs_error_mm === null ? "–" : number(1e3 * r.max_abs_error_mm, 2),
        r.finished ? "finished" : started.some((j) => j.run === r.run && j.running) ? "running" : "unfinished", choice(r.run)))));
      const step = (to, text) => element("button", { onclick: () => { offset = to; load(); } }, text);
      more.replaceChildren(`${answer.total} run${answer.total === 1 ? "" : "s"} `, offset > 0 ? step(Math.max(0, offset - 50), "earlier") : null || "", offset + 50 < answer.total ? step(offset + 50, "later") : "");
      jobs.replaceChildren(...started.map((j) => element("section", {}, element("h2", {}, j.run), element("p", {}, element("progress", { max: Math.max(1, j.passes_planned), value: j.passes, "aria-label": `Passes of ${j.run}` }), ` ${j.passes} of ${j.passes_planned} passes, `, j.running ? "running " : `ended (${j.exit ?? "stopped"}) `, j.running ? act(j.run, "stop") : j.exit === 0 ? null : act(j.run, "resume")), element("pre", { tabindex: "0", role: "region", "aria-label": `Log of ${j.run}` }, j.log.slice(-8).join("\n")))));
    } catch (error) { said(error); }
  }
  await load();
  main.replaceChildren(...all);
  const timer = setInterval(load, 2000);
  return () => clearInterval(timer);
}

async function run(name) {
  const detail = await api("runs/" + encodeURIComponent(name));
  const plots = [];
  const rows = detail.passes.map((p) => row(...[p.pass, number(p.nominal_mm, 3), number(1e3 * p.max_abs_error_mm, 2), p.decision].map(String)));
  main.replaceChildren(
    element("h1", {}, name),
    element("p", {}, detail.finished ? element("a", { href: `api/runs/${encodeURIComponent(name)}/report` }, "Report") : "unfinished"),
    table(["pass", "nominal / mm", "largest error / µm", "decision"], rows));
  if (detail.passes.length > 1) {
    const place = element("div", { class: "plot", role: "img", "aria-label": "All passes: measured minus nominal along z" });
    main.append(element("h2", {}, "All passes: measured − nominal"), place);
    plots.push(passesPlot(place, detail.passes.map((p) => ({ ...p, label: `pass ${p.pass}` }))));
  }
  for (const p of detail.passes) {
    const place = element("div", { class: "plot", role: "img", "aria-label": `Pass ${p.pass}: measured minus nominal along z` });
    main.append(element("h2", {}, `Pass ${p.pass}: measured − nominal`), place);
    const error = p.d_mm.map((d) => (d === null ? null : 1e3 * (d - p.nominal_mm)));
    const band = p.u_mm.map((v) => (v === null ? null : 2e3 * v));
    plots.push(plot(place, p.z_mm, error, band, { xLabel: "z / mm", yLabel: "error / µm", digits: 2 }));
  }
  main.append(element("details", {}, element("summary", {}, "Config"), element("pre", { tabindex: "0", role: "region", "aria-label": "Config" }, detail.config)));
  return () => plots.forEach((p) => p.end());
}

