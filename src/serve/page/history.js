"use strict";
// History and gauge: what the store remembers.

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

