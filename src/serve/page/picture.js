"use strict";
// The newest frame with its edges; under the cursor the grey profile of a column and its derivative.

// The body of api/live/picture: length of the head (32 bits, little-endian), head (JSON), PNG.
async function readPicture() {
  const answer = await fetch("api/live/picture");
  if (!answer.ok) return null;
  const bytes = await answer.arrayBuffer();
  const length = new DataView(bytes).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  const image = await createImageBitmap(new Blob([bytes.slice(4 + length)], { type: "image/png" }));
  return { head, image };
}

// Colour and stretch of an edge drawn over the frame: gaps are gaps.
function drawEdge(context, rows, scaleX, scaleY) {
  context.beginPath();
  let on = false;
  rows.forEach((row, k) => {
    if (row === null) { on = false; return; }
    const x = (k + 0.5) * scaleX, y = (row + 0.5) * scaleY;
    if (on) context.lineTo(x, y); else context.moveTo(x, y);
    on = true;
  });
  context.stroke();
}

function picture() {
  const canvas = element("canvas", { class: "frame", tabindex: "0", role: "img", "aria-label": "The newest frame with both edges. Left and right arrow: another column." });
  const text = element("p", { class: "under" }, "no frame yet");
  const place = element("div", { class: "plot", role: "img", "aria-label": "Grey profile of the column under the cursor and its derivative" });
  const run = element("div", { class: "plot", role: "img", "aria-label": "Diameter along z in the newest frame, with its expanded uncertainty" });
  const frame = element("section", { class: "frame-place" }, text, canvas);
  const along = element("section", {}, element("h2", {}, "Along z"), run);
  const whole = element("section", {}, element("h2", {}, "Column under the cursor"), place);
  const grey = document.createElement("canvas");
  let now = null, column = null, shown = null, profiled = null, timer = 0, ended = false, busy = false;

  function draw() {
    if (!now) return;
    const width = canvas.clientWidth, height = canvas.clientHeight, ratio = window.devicePixelRatio || 1;
    if (canvas.width !== Math.round(width * ratio)) { canvas.width = Math.round(width * ratio); canvas.height = Math.round(height * ratio); }
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.drawImage(now.image, 0, 0, width, height);
    const scaleX = width / now.image.width, scaleY = height / now.head.rows;
    context.lineWidth = 1.5;
    context.strokeStyle = "#e69f00";
    drawEdge(context, now.head.top_px, scaleX, scaleY);
    context.strokeStyle = "#56b4e9";
    drawEdge(context, now.head.bottom_px, scaleX, scaleY);
    if (column !== null) {
      context.strokeStyle = "#d55e00";
      context.setLineDash([4, 3]);
      context.beginPath();
      context.moveTo((column + 0.5) * scaleX, 0);
      context.lineTo((column + 0.5) * scaleX, height);
      context.stroke();
      context.setLineDash([]);
    }
  }

  function valueAt(head) {
    const d = head[`d_${head.unit}`]?.[column] ?? null, u = head[`expanded_u_${head.unit}`]?.[column] ?? null;
    return d === null ? ", no diameter" : `, D ${number(d, 4)} ± ${number(u, 4)} ${head.unit} (U)`;
  }

  // Grey values of a column in 8 bits, as the picture has them, and their central difference.
  function profile() {
    if (!now || column === null) return;
    const { head } = now, context = grey.getContext("2d", { willReadFrequently: true });
    grey.width = now.image.width; grey.height = now.image.height;
    context.drawImage(now.image, 0, 0);
    const pixels = context.getImageData(column, 0, 1, head.rows).data;
    const rows = [], values = [];
    for (let row = 0; row < head.rows; row += 1) { rows.push(row); values.push(pixels[4 * row]); }
    const slope = values.map((v, k) => (k === 0 || k === values.length - 1 ? null : (values[k + 1] - values[k - 1]) / 2));
    const [top, bottom] = [head.top_px[column] ?? null, head.bottom_px[column] ?? null];
    text.textContent = `frame ${head.frame}, column ${column * head.column_step} of ${head.columns}: edges at ${number(top, 3)} and ${number(bottom, 3)} px${valueAt(head)}`;
    if (shown) return shown.setData([rows, values, slope]);
    const axis = { stroke: colour("--ink"), grid: { stroke: colour("--shade") }, ticks: { stroke: colour("--rule") } };
    shown = new uPlot({
      width: Math.max(place.clientWidth, 280), height: 260, scales: { x: { time: false }, slope: {} },
      series: [{ label: "row / px" }, { label: "grey (of 255)", stroke: colour("--line"), width: 1.5 }, { label: "derivative / px⁻¹", scale: "slope", stroke: colour("--open"), width: 1.5 }],
      axes: [{ ...axis, label: "row / px" }, { ...axis, label: "grey (of 255)" }, { ...axis, scale: "slope", side: 1, label: "derivative / px⁻¹", grid: { show: false } }],
    }, [rows, values, slope], place);
  }

  // Diameters along z with U, z from the middle of the field; of a refused frame none.
  function drawAlong() {
    const { head } = now, unit = head.unit, middle = (head.columns - 1) / 2;
    const d = head[`d_${unit}`] ?? [], u = head[`expanded_u_${unit}`] ?? [];
    const z = d.map((_, k) => (k * head.column_step - middle) * head.pitch);
    if (profiled) return profiled.set([z, d, d.map((v, k) => (v === null ? null : v + u[k])), d.map((v, k) => (v === null ? null : v - u[k]))]);
    if (d.some((v) => v !== null)) profiled = plot(run, z, d, u, { xLabel: `z from the middle of the field / ${unit}`, yLabel: `D / ${unit}`, digits: unit === "mm" ? 4 : 2 });
  }

  const choose = (to) => {
    if (!now) return;
    column = Math.min(Math.max(Math.round(to), 0), now.image.width - 1);
    draw();
    profile();
  };
  canvas.addEventListener("pointermove", (event) => now && choose((event.offsetX / canvas.clientWidth) * now.image.width - 0.5));
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1, PageUp: -32, PageDown: 32 }[event.key];
    if (step && now) { event.preventDefault(); choose((column ?? now.image.width / 2) + step); }
  });

  // One request at a time: what comes is the newest frame then.
  async function next() {
    if (busy || document.hidden) return;
    busy = true;
    try {
      const read = await readPicture();
      if (ended) return;
      if (read === null) { text.textContent = "no frame of now"; canvas.classList.add("stale"); return; }
      canvas.classList.remove("stale");
      if (now && now.head.frame === read.head.frame) return;
      now?.image.close();
      now = read;
      canvas.style.setProperty("--ratio", read.head.columns / read.head.rows);
      if (column === null) column = Math.floor(read.image.width / 2);
      draw();
      profile();
      drawAlong();
    } catch { text.textContent = "no connection to the server"; canvas.classList.add("stale"); } finally { busy = false; }
  }
  timer = setInterval(next, 250);
  next();
  const resized = () => { draw(); shown?.setSize({ width: Math.max(place.clientWidth, 280), height: 260 }); };
  window.addEventListener("resize", resized);
  return { frame, along, profile: whole, end: () => { ended = true; clearInterval(timer); window.removeEventListener("resize", resized); shown?.destroy(); profiled?.end(); } };
}
