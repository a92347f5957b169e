"use strict";
// What all pages share: elements, the API, problems, plots.

const main = document.getElementById("main");
const problem = document.getElementById("problem");

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
  const media = typeof options.body === "string" ? "application/json" : "application/octet-stream";
  const headers = changes ? { "content-type": media, "x-shadowgauge": "1" } : {};
  const answer = await fetch("api/" + path, { ...options, headers });
  if (answer.status === 401) {
    askToken();
    throw new Error("a token is needed");
  }
  if (!answer.ok) {
    const text = await answer.text();
    let words = text || answer.statusText;
    try { words = JSON.parse(text).error || words; } catch { /* words of the server's libraries */ }
    throw new Error(words);
  }
  const type = answer.headers.get("content-type") || "";
  return type.includes("json") ? answer.json() : null;
}

function askToken() {
  const token = window.prompt("Token for this gauge:");
  if (token) {
    document.cookie = "shadowgauge_token=" + token + "; SameSite=Strict; path=/" + (location.protocol === "https:" ? "; Secure" : "");
    show();
  }
}

const said = (error) => { problem.textContent = error ? String(error.message || error) : ""; };
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// A line with a band of ±U below and above it, over x with its unit; `lines` are further ones (limits, other passes).
function plot(place, x, value, band, { xLabel, yLabel, digits, lines = [] }) {
  const series = [
    { label: xLabel },
    { label: yLabel, stroke: colour("--line"), width: 2, points: { show: x.length < 60 }, value: (_, v) => number(v, digits) },
    { label: "+U", stroke: "transparent", value: (_, v) => number(v, digits), points: { show: false } },
    { label: "−U", stroke: "transparent", value: (_, v) => number(v, digits), points: { show: false } },
    ...lines.map(({ label, stroke, dash }) => ({ label, stroke, dash, width: 1, points: { show: false }, value: (_, v) => number(v, digits) })),
  ];
  const up = value.map((v, k) => (v === null || band[k] === null ? null : v + band[k]));
  const down = value.map((v, k) => (v === null || band[k] === null ? null : v - band[k]));
  const axis = { stroke: colour("--ink"), grid: { stroke: colour("--shade") }, ticks: { stroke: colour("--rule") } };
  const shown = new uPlot({
    width: Math.max(place.clientWidth, 280), height: 260,
    scales: { x: { time: false } },
    series, bands: [{ series: [2, 3], fill: colour("--band") }],
    axes: [{ ...axis, label: xLabel }, { ...axis, label: yLabel, size: 84, values: (_, all) => all.map((v) => number(v, digits)) }],
  }, [x, value, up, down, ...lines.map((line) => line.values)], place);
  const resize = () => shown.setSize({ width: Math.max(place.clientWidth, 280), height: 260 });
  window.addEventListener("resize", resize);
  return { set: (data) => shown.setData(data), end: () => { window.removeEventListener("resize", resize); shown.destroy(); } };
}

