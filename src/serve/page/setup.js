"use strict";
// Products, tools, machines: what programs are made from.

const field = (label, control) => [element("label", { for: control.id }, label), control];
const table = (heads, rows) => element("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": heads.filter(Boolean).join(", ") }, element("table", {}, element("thead", {}, element("tr", {}, ...heads.map((t) => (t ? element("th", { scope: "col" }, t) : element("td"))))), element("tbody", {}, ...rows)));
const row = (...cells) => element("tr", {}, ...cells.map((c) => element("td", {}, c)));
const json = (method, value) => ({ method, body: JSON.stringify(value) });
const file = (id, accept) => element("input", { id, type: "file", accept });
const input = (id, more = {}) => element("input", { id, ...more });
const text = (id) => element("textarea", { id, spellcheck: "false" });
const deleting = (path, again) => element("button", { type: "button", "aria-label": `Delete ${path}`, onclick: () => {
  if (window.confirm(`Delete ${path}? Programs that were made stay.`)) api(path, { method: "DELETE" }).then(() => { said(); again(); }, said);
} }, "Delete");

// A form that sends, says what is wrong and loads again.
function sending(send, again, button, ...fields) {
  const form = element("form", { onsubmit: async (event) => {
    event.preventDefault();
    form.querySelector("button").disabled = true;
    try { await send(); said(); form.reset(); await again(); } catch (error) { said(error); } finally { form.querySelector("button").disabled = false; }
  } }, ...fields, element("p", {}, element("button", {}, button)));
  return form;
}

// Z to the right, X up, in equal scales; each line has a class. Units stand at the corners.
function drawing(label, lines) {
  const all = lines.flatMap((l) => l.points);
  if (!all.length) return element("p", {}, "nothing to draw");
  const [z0, z1] = [Math.min(...all.map((p) => p[0])), Math.max(...all.map((p) => p[0]))];
  const [x0, x1] = [Math.min(0, ...all.map((p) => p[1])), Math.max(...all.map((p) => p[1]))];
  const margin = 0.05 * Math.max(z1 - z0, x1 - x0, 1), ns = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(ns, "svg");
  svg.setAttribute("viewBox", `${z0 - margin} ${-x1 - margin} ${z1 - z0 + 2 * margin} ${x1 - x0 + 2 * margin}`);
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", label);
  svg.setAttribute("class", "drawing");
  for (const { points, name } of lines) {
    const line = document.createElementNS(ns, "polyline");
    line.setAttribute("points", points.map((p) => `${p[0]},${-p[1]}`).join(" "));
    line.setAttribute("class", name);
    svg.append(line);
  }
  return element("figure", {}, svg, element("figcaption", {}, `${label}; Z ${number(z0, 2)} to ${number(z1, 2)} mm, distance from the axis ${number(x0, 2)} to ${number(x1, 2)} mm`));
}

async function products() {
  const list = element("div"), place = element("div");
  const draw = async (name) => {
    try { place.replaceChildren(drawing(`Outline of ${name}`, [{ points: (await api(`products/${name}/contour`)).points_mm, name: "part" }])); said(); } catch (error) { said(error); }
  };
  const load = async () => {
    const all = await api("products");
    list.replaceChildren(all.length ? table(["product", "from", "outline", ""], all.map((p) => row(p.name,
      p.outline ? "outline" : p.model ? `model in ${p.card.unit}, bar Ø${p.card.stock_mm} mm` : "card: no model yet",
      element("button", { type: "button", "aria-label": `Show ${p.name}`, onclick: () => draw(p.name) }, "Show"), deleting(`products/${p.name}`, load)))) : element("p", {}, "No product yet."));
  };
  const [n, o] = [input("product-name", { required: "", maxlength: "64" }), text("product-outline")];
  const [m, s, u, st, z] = [input("model-name", { required: "", maxlength: "64" }), file("model-file", ".stl"), element("select", { id: "model-unit" }, ...["mm", "cm", "m", "inch"].map((t) => element("option", {}, t))), input("model-stock", { type: "number", step: "any", min: "0", required: "" }), input("model-z", { type: "number", step: "any", min: "0", value: "0" })];
  s.required = true;
  const model = async () => {
    await api("products", json("POST", { name: m.value, card: { unit: u.value, stock_mm: Number(st.value), from_z_mm: Number(z.value) } }));
    try { await api(`products/${m.value}/model`, { method: "PUT", body: s.files[0] }); } catch (error) {
      // a card without its model is of no use
      await api(`products/${m.value}`, { method: "DELETE" });
      throw error;
    }
  };
  await load();
  main.replaceChildren(element("h1", {}, "Products"), list, place,
    element("details", {}, element("summary", {}, "Add an outline"), sending(() => api("products", json("POST", { name: n.value, outline: o.value })), load, "Add outline", ...field("Name", n), ...field("Outline (TOML)", o))),
    element("details", {}, element("summary", {}, "Add a model"), sending(model, load, "Add model", ...field("Name", m), ...field("Model (STL, 16 MiB at most)", s), ...field("Unit of its coordinates", u), ...field("Diameter of the bar / mm", st), ...field("Z of its end at the chuck / mm", z))));
  return () => {};
}

const readingWords = (r) => {
  const v = r.values, um = (x) => number(1e3 * x, 2);
  if (v.mean_radius_mm !== undefined) return `mean radius ${um(v.mean_radius_mm)} µm, u ${um(v.u_mean_radius_mm)} µm${v.flags?.length ? "; " + v.flags.join(", ") : ""}`;
  return Object.entries(v).map(([key, x]) => `${key} ${typeof x === "number" ? number(x, 1) : JSON.stringify(x)}`).join(", ");
};

// What of a reading shows its wear: VBB of a flank, else the mean radius of a nose; with its U.
function wearHistory(t) {
  const of = [["flank", "vbb_um", "u_vbb_um", 1, "VBB / µm"], ["nose", "mean_radius_mm", "u_mean_radius_mm", 1e3, "mean radius of the nose / µm"]];
  for (const [kind, key, u, scale, title] of of) {
    const all = t.readings.filter((r) => r.kind === kind && typeof r.values[key] === "number");
    if (all.length < 2) continue;
    const place = element("div", { class: "plot", role: "img", "aria-label": `${title} of ${t.name} by reading` });
    const draw = () => plot(place, all.map((_, k) => k + 1), all.map((r) => scale * r.values[key]), all.map((r) => (typeof r.values[u] === "number" ? 2 * scale * r.values[u] : null)), { xLabel: "reading", yLabel: title, digits: 2 });
    return { place, title: `Wear: ${title}`, draw };
  }
  return null;
}

async function tools() {
  const list = element("div"), place = element("div");
  let wear = null;
  const show = (t) => {
    const last = t.readings.length - 1, image = element("div"), history = wearHistory(t);
    const look = (k) => image.replaceChildren(t.readings[k]?.overlay ? element("img", { class: "overlay", alt: `${t.readings[k].kind} of ${t.name} of ${t.readings[k].utc.slice(0, 19)}Z with what was found`, src: `api/tools/${t.name}/overlay?reading=${k}` }) : element("p", {}, last < 0 ? "No image yet." : "This reading has no picture."));
    look(last);
    wear?.end();
    place.replaceChildren(element("h2", {}, t.name),
      table(["measured", "image", "µm/px", "result", ""], t.readings.map((r, k) => row(r.utc, r.kind, String(r.um_per_px), readingWords(r), element("button", { type: "button", "aria-label": `Show the image of ${r.utc}`, onclick: () => look(k) }, "Image"))).reverse()),
      image, ...(history ? [element("h3", {}, history.title), history.place] : []),
      element("details", {}, element("summary", {}, "Tool (TOML)"), element("pre", { tabindex: "0", role: "region", "aria-label": "Tool (TOML)" }, t.tool)));
    wear = history?.draw() ?? null;
  };
  const of = element("select", { id: "image-tool", required: "" });
  const load = async () => {
    const all = await api("tools");
    of.replaceChildren(...all.map((t) => element("option", {}, t.name)));
    list.replaceChildren(all.length ? table(["tool", "nose", "readings", "", ""], all.map((t) => row(t.name, t.readings.some((r) => r.kind === "nose") ? "measured" : t.nose ? "given" : "not measured", String(t.readings.length),
      element("button", { type: "button", "aria-label": `Show ${t.name}`, onclick: () => show(t) }, "Show"), deleting(`tools/${t.name}`, load)))) : element("p", {}, "No tool yet."));
    return all;
  };
  const [n, t, nose] = [input("tool-name", { required: "", maxlength: "64" }), text("tool-text"), file("tool-nose", ".json")];
  const add = async () => {
    const given = nose.files[0];
    if (given && given.size > 900000) throw new Error("the nose's document is longer than 900 kB: give one image of it");
    await api("tools", json("POST", { name: n.value, tool: t.value, nose: given ? await given.text() : null }));
  };
  const [kind, scale, image] = [element("select", { id: "image-kind" }, ...["nose", "baseline", "flank"].map((k) => element("option", {}, k))), input("image-scale", { type: "number", step: "any", min: "0", required: "" }), file("image-file", "image/*")];
  const sides = element("select", { id: "image-side" }, ...["any", "below", "right", "above", "left"].map((k) => element("option", {}, k)));
  const flankSide = element("div", { hidden: "" }, ...field("Flank at which side of its edge (where two borders could be it)", sides));
  const ofKind = () => { flankSide.hidden = kind.value !== "flank"; };
  kind.onchange = ofKind;
  image.required = true;
  const measure = async () => {
    const name = of.value;
    await api(`tools/${name}/images?kind=${kind.value}&um_per_px=${scale.value}${kind.value === "flank" ? `&flank_side=${sides.value}` : ""}`, { method: "POST", body: image.files[0] });
    show((await api("tools")).find((tool) => tool.name === name));
  };
  const measuring = sending(measure, load, "Measure", ...field("Tool", of), ...field("What it shows", kind), flankSide, ...field("Scale / µm per px", scale), ...field("Image (32 MiB at most)", image));
  // once the form has its first values again
  measuring.onreset = () => setTimeout(ofKind);
  await load();
  main.replaceChildren(element("h1", {}, "Tools"), list, place,
    element("details", {}, element("summary", {}, "Measure an image"), measuring),
    element("details", {}, element("summary", {}, "Add a tool"), sending(add, load, "Add tool", ...field("Name", n), ...field("Tool (TOML)", t), ...field("Its nose, where it was measured elsewhere (JSON of tool nose)", nose))));
  return () => wear?.end();
}

async function machines() {
  const list = element("div");
  const [n, d, data] = [input("machine-name", { required: "", maxlength: "64" }), element("select", { id: "machine-dialect" }, ...["fanuc", "linuxcnc", "gsk", "sinumerik"].map((t) => element("option", {}, t))), text("machine-data")];
  let all = [];
  const edit = (m) => { form.open = true; n.value = m.name; d.value = m.dialect; data.value = m.data; data.focus(); };
  const load = async () => {
    all = await api("machines");
    list.replaceChildren(all.length ? table(["machine", "control", "increment of X / mm", "", ""], all.map((m) => row(m.name, m.dialect, String(m.increment_mm),
      element("button", { type: "button", "aria-label": `Edit ${m.name}`, onclick: () => edit(m) }, "Edit"), deleting(`machines/${m.name}`, load)))) : element("p", {}, "No machine yet."));
  };
  const save = () => {
    const machine = { name: n.value, dialect: d.value, data: data.value };
    const known = all.some((m) => m.name === machine.name);
    return api(known ? `machines/${machine.name}` : "machines", json(known ? "PUT" : "POST", machine));
  };
  const form = element("details", {}, element("summary", {}, "Add or change a machine"), sending(save, load, "Save machine", ...field("Name", n), ...field("Control", d), ...field("Data (TOML): chuck, tailstock, change position, travel", data)));
  await load();
  main.replaceChildren(element("h1", {}, "Machines"), element("p", { class: "muted" }, "Control, increments and limits of each CNC machine. No page moves one."), list, form);
  return () => {};
}
