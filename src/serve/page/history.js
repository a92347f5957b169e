"use strict";
// History: stations that the store remembers.

// Stations one after another, diameters with U = 2u; between two passes the line is broken.
function byPass(stations) {
  const [x, d, band] = [[], [], []];
  stations.forEach((s, k) => {
    const before = stations[k - 1];
    if (before && (before.run !== s.run || before.pass !== s.pass)) { x.push(k + 0.5); d.push(null); band.push(null); }
    x.push(k + 1); d.push(s.d_mm); band.push(s.u_mm === null ? null : 2 * s.u_mm);
  });
  return [x, d, band];
}

async function history() {
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
      const rows = answer.stations.slice(-200).reverse().map((s) => row(...[s.utc, s.name, s.pass, number(s.z_mm, 3), number(s.d_mm, 5), s.u_mm === null ? "–" : number(1e3 * s.u_mm, 2), s.flag || ""].map(String)));
      place.replaceChildren(chart, table(["stored", "run", "pass", "z / mm", "D / mm", "u / µm", "flag"], rows));
      if (good.length) shown = plot(chart, ...byPass(good), { xLabel: "station", yLabel: "D / mm", digits: 4 });
    } catch (error) { said(error); }
  }
  main.replaceChildren(element("h1", {}, "History"), element("form", { onsubmit: load, class: "line-up" }, ...[["from", "First day (UTC)", from], ["to", "Last day", to]].map(([id, words, day]) => element("div", {}, element("label", { for: id }, words), day)), element("button", {}, "Show")), text, place);
  await load();
  return () => shown?.end();
}
