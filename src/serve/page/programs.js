"use strict";
// Compensation: a product, a tool and a machine to a program, and what it leaves.

const modeWords = (g) => ({ plain: "none", compensated: `1, ${g.way.replace("_", " ")}`, batch: `2 (batch), ${g.way.replace("_", " ")}` })[g.mode];

async function programs() {
  const list = element("div"), more = element("p");
  const [p, t, m] = ["product", "tool", "machine"].map((id) => element("select", { id: `of-${id}`, required: "" }));
  const options = (id, all) => element("select", { id }, ...all.map(([value, words]) => element("option", { value }, words)));
  const mode = options("of-mode", [["compensated", "1: cones and arcs, as this tool is set"], ["batch", "2: batch, the offsets of the new insert stay"], ["plain", "none: the drawing's contour"]]);
  const way = options("of-way", [["path", "path of the measured nose"], ["edited_contour", "edited contour"], ["best_register", "best register"]]);
  mode.addEventListener("change", () => { way.disabled = mode.value === "plain"; });
  let offset = null;
  const load = async () => {
    const newest = await api("programs?offset=0&limit=1");
    const from = offset ?? Math.max(0, newest.total - 50);
    const { total, programs: all } = await api(`programs?offset=${from}&limit=50`);
    const step = (to, words) => element("button", { type: "button", onclick: () => { offset = to; load().catch(said); } }, words);
    more.replaceChildren(`${total} programs `, from > 0 ? step(Math.max(0, from - 50), "earlier") : "", from + 50 < total ? step(from + 50, "later") : "");
    list.replaceChildren(total ? table(["asked for", "product", "tool", "machine", "compensation", "state"], all.reverse().map((g) => row(element("a", { href: `#program/${g.id}` }, g.utc), g.product, g.tool, g.machine, modeWords(g), g.state))) : element("p", {}, "No program yet."));
  };
  const make = async () => {
    const chosen = mode.value === "plain" ? "register" : way.value;
    const { id } = await api("programs", json("POST", { product: p.value, tool: t.value, machine: m.value, mode: mode.value, way: chosen }));
    location.hash = `#program/${id}`;
  };
  const names = await Promise.all(["products", "tools", "machines"].map((kind) => api(kind)));
  [p, t, m].forEach((select, k) => select.append(...names[k].map((x) => element("option", {}, x.name))));
  const lacking = ["product", "tool", "machine"].filter((_, k) => !names[k].length);
  await load();
  main.replaceChildren(element("h1", {}, "Compensation"),
    lacking.length ? element("p", {}, `First add a ${lacking.join(", a ")}.`) : sending(make, load, "Make program", ...field("Product", p), ...field("Tool", t), ...field("Machine", m), ...field("Compensation", mode), ...field("By", way)),
    element("h2", {}, "Programs"), list, more);
  return () => {};
}

// Both texts with their line numbers, changed lines marked by a word too, not by colour alone.
function sideBySide(text, plain, changed) {
  const marked = new Set(changed);
  const lines = text.split("\n").map((line, k) => element("span", { class: marked.has(k + 1) ? "line changed" : "line" }, `${marked.has(k + 1) ? "▸" : " "}${String(k + 1).padStart(5)}  ${line}\n`));
  const old = plain?.split("\n").map((line, k) => element("span", { class: "line" }, ` ${String(k + 1).padStart(5)}  ${line}\n`));
  const column = (title, all) => element("section", {}, element("h3", {}, title), element("pre", { class: "program", tabindex: "0", role: "region", "aria-label": title }, ...all));
  return element("div", { class: "beside" }, column(`This program (${changed.length} lines changed)`, lines), old ? column("Without compensation", old) : null);
}

async function program(id) {
  let ended = false, plotted = null;
  const until = async () => {
    for (;;) {
      const found = await api(`programs/${id}`);
      if (ended || found.program.state !== "running") return found;
      main.replaceChildren(element("h1", {}, "Program"), element("p", { role: "status" }, "being made …"));
      await new Promise((done) => setTimeout(done, 300));
    }
  };
  const { program: g, compensation: c, plain_text: plain } = await until();
  const of = `${g.product}, ${g.tool}, ${g.machine}; compensation: ${modeWords(g)}`;
  main.replaceChildren(element("h1", {}, "Program"), element("p", {}, of));
  if (g.state !== "made") {
    main.append(element("p", { class: "bad", role: "status" }, `${g.state}: ${g.words}`));
    return () => { ended = true; };
  }
  const [text, path] = await Promise.all([fetch(`api/programs/${id}/nc`).then((a) => a.text()), api(`programs/${id}/path`)]);
  const drawn = path.polylines.filter((l) => l.kind !== "rapid").map((l) => ({ points: l.points_mm.map(([z, d]) => [z, d / 2]), name: l.kind }));
  main.append(element("p", {}, element("a", { href: `api/programs/${id}/nc`, download: `${id}.nc` }, "Download the program"), " The operator loads and releases it at the control."));
  if (g.words) main.append(element("p", {}, g.words));
  if (g.warnings?.length) main.append(element("h2", {}, "Warnings"), element("ul", {}, ...g.warnings.map((words) => element("li", {}, words))));
  main.append(element("h2", {}, "Path and programs"), element("div", { class: "made" },
    drawing("Part (solid) and path of the programmed point (dashed)", [{ points: path.outline_mm, name: "part" }, ...drawn]), sideBySide(text, plain, g.changed_lines)));
  if (c) {
    const place = element("div", { class: "plot", role: "img", "aria-label": "What the register's circle leaves of the nose, by the direction of the surface" });
    main.append(element("h2", {}, "e(a), what the register leaves"), place);
    plotted = plot(place, c.e.map((e) => e.a_deg), c.e.map((e) => e.e_um), c.e.map((e) => (e.u_um === null ? null : 2 * e.u_um)), { xLabel: "direction of the surface a / °", yLabel: "e / µm", digits: 2 });
    const left = (w) => w.refused ? w.refused : w.largest ? `${number(w.largest.left_um, 2)} µm at Ø${number(w.largest.diameter_mm, 2)} Z ${number(w.largest.z_mm, 2)} mm` : "–";
    main.append(element("h2", {}, "The ways"), table(["way", "register / mm", "largest remainder"], c.ways.map((w) => row(w.way, number(w.register_mm, 5), left(w)))));
    if (c.cautions?.length) main.append(element("ul", {}, ...c.cautions.map((words) => element("li", {}, words))));
  }
  return () => { ended = true; plotted?.end(); };
}
