// What a person does on the pages, each step by mouse and keyboard; what is shown then is compared.
import { readFileSync } from "node:fs";
import { resolve } from "node:path";

const fail = (words) => { throw new Error(words); };
const went = (page, heading) => page.until(`document.querySelector("main h1")?.textContent === ${JSON.stringify(heading)}`, `the page ${heading}`);
const shows = (page, words) => page.until(`document.querySelector("main").innerText.includes(${JSON.stringify(words)})`, `"${words}" on the page`);
const listed = (page, words) => page.until(`[...document.querySelectorAll("td")].some((e) => e.textContent === ${JSON.stringify(words)})`, `"${words}" in a list`);

async function go(page, link, heading) {
  await page.clickWords("nav a", link);
  await went(page, heading ?? link);
}

async function add(page, summary, fill, button) {
  await page.clickWords("summary", summary);
  await fill();
  await page.clickWords("button", button);
}

// upload -> compensation -> program
export async function program(page, { root, work }) {
  const read = (name) => readFileSync(`${root}/configs/tool/${name}`, "utf8");
  await go(page, "Products");
  await add(page, "Add an outline", async () => {
    await page.type("#product-name", "shaft");
    await page.type("#product-outline", read("outline.toml"));
  }, "Add outline");
  await listed(page, "shaft");
  await page.click("[aria-label='Show shaft']");
  await page.onlyOne("svg.drawing polyline.part");
  await go(page, "Tools");
  await add(page, "Add a tool", async () => {
    await page.type("#tool-name", "finishing");
    await page.type("#tool-text", read("tool.toml"));
    await page.upload("#tool-nose", resolve(root, "configs/tool/nose.json"));
  }, "Add tool");
  await listed(page, "given");
  if (work.nose) await measure(page, work.nose);
  if (work.flank) await measureFlank(page, work.flank);
  await go(page, "Machines");
  await add(page, "Add or change a machine", async () => {
    await page.type("#machine-name", "lathe");
    await page.choose("#machine-dialect", "linuxcnc");
    await page.type("#machine-data", read("machine.toml"));
  }, "Save machine");
  await listed(page, "linuxcnc");
  const ids = [];
  for (const mode of work.modes ?? ["compensated"]) {
    await go(page, "Compensation");
    await page.choose("#of-mode", mode);
    await page.clickWords("button", "Make program");
    await went(page, "Program");
    await page.onlyOne("pre.program");
    ids.push(await page.value("location.hash"));
    await compared(page, mode);
  }
  return ids;
}

async function measure(page, image) {
  await add(page, "Measure an image", async () => {
    await page.choose("#image-tool", "finishing");
    await page.type("#image-scale", "2.415");
    await page.upload("#image-file", image);
  }, "Measure");
  await shows(page, "mean radius");
  await page.until("document.querySelector('img.overlay')?.naturalWidth > 0", "the picture with what was found");
}

// A flank has a side to state, a nose none.
async function measureFlank(page, image) {
  await go(page, "Machines");
  await go(page, "Tools");
  await add(page, "Measure an image", async () => {
    if (await page.value("document.querySelector('#image-side').offsetParent !== null")) fail("a nose is asked for the side of its flank");
    await page.choose("#image-tool", "finishing");
    await page.choose("#image-kind", "flank");
    if (await page.value("document.querySelector('#image-side').offsetParent === null")) fail("a flank's side cannot be stated");
    await page.choose("#image-side", "below");
    await page.type("#image-scale", "2.415");
    await page.upload("#image-file", image);
  }, "Measure");
  await shows(page, "vbb_um");
  await page.until("document.querySelector('#image-side').offsetParent === null", "no side to state for the nose that the form asks for again");
}

// The text that is downloaded, as a person would type it in, ends where the drawn line does: each place within 1e-4 mm.
async function compared(page, mode) {
  const { text, drawn, marked } = await page.value(`(async () => ({
    text: await (await fetch(document.querySelector("a[download]").href)).text(),
    drawn: [...document.querySelectorAll("svg.drawing polyline:not(.part)")].map((l) => l.getAttribute("points").split(" ").map((p) => p.split(",").map(Number))),
    marked: document.querySelectorAll(".line.changed").length }))()`);
  const all = places(text);
  if (all.length < 10) fail(`${mode}: only ${all.length} places in the program`);
  if ((mode === "plain") !== (marked === 0)) fail(`${mode}: ${marked} lines are marked as changed`);
  // a plain text has the drawing's contour, and the control moves the point off it by its compensation: the line drawn is that
  if (mode === "plain") return console.log(`program (plain): ${all.length} places`);
  const worst = Math.max(...all.map((p) => Math.min(...drawn.map((line) => distance(p, line)))));
  if (!(worst < 1e-4)) fail(`${mode}: the program lies ${worst} mm beside the line drawn`);
  console.log(`program (${mode}): ${all.length} places of the download within ${worst.toExponential(1)} mm of the line drawn, ${marked} lines marked`);
}

// Places in feed: Z and the distance from the axis, mm; as the drawing has them, X downwards.
function places(text) {
  const at = {}, all = [];
  let feed = false;
  for (const line of text.split("\n")) {
    let moves = false;
    for (const word of line.replace(/\(.*?\)|;.*/g, "").split(/\s+/)) {
      if (/^G0?0$/.test(word)) feed = false;
      else if (/^G0?[123]$/.test(word)) feed = true;
      else if (/^[XZ]-?[\d.]+$/.test(word)) { at[word[0]] = Number(word.slice(1)); moves = true; }
    }
    if (feed && moves && at.X !== undefined && at.Z !== undefined) all.push([at.Z, -at.X / 2]);
  }
  return all;
}

function distance([z, x], line) {
  let least = Infinity;
  for (let k = 0; k + 1 < line.length; k += 1) {
    const [[az, ax], [bz, bx]] = [line[k], line[k + 1]];
    const [dz, dx] = [bz - az, bx - ax];
    const share = Math.min(1, Math.max(0, ((z - az) * dz + (x - ax) * dx) / Math.max(dz * dz + dx * dx, 1e-300)));
    least = Math.min(least, Math.hypot(z - az - share * dz, x - ax - share * dx));
  }
  return least;
}

// start run -> watch -> report
export async function run(page, { work }) {
  await go(page, "Runs");
  await add(page, "Start a simulated run", async () => {
    await page.type("#name", "first");
    await page.type("#config", readFileSync(work.job, "utf8"));
    await formed(page);
  }, "Start");
  await page.until(`[...document.querySelectorAll("main h2")].some((h) => h.textContent === "first")`, "the run that was started");
  await listed(page, "finished");
  await page.clickWords("td a", "first");
  await went(page, "first");
  await page.until("document.querySelectorAll('.plot canvas').length >= 1", "the profile of a pass");
  const report = await page.value(`(async () => { const a = await fetch(document.querySelector("main p a").href); return [a.status, (await a.text()).includes("</html>")]; })()`);
  if (report[0] !== 200 || !report[1]) fail(`the report: ${report}`);
  await go(page, "History");
  await shows(page, "stations");
  await page.until("document.querySelectorAll('.scroll tbody tr').length >= 1", "stations of the run");
  console.log(`run: started, watched, reported; ${await page.value("document.querySelector('main p:not(form p)').textContent")}`);
}

// The form beside the TOML: what is set in one stands in the other.
async function formed(page) {
  await page.value(`document.getElementById("config").dispatchEvent(new Event("change"))`);
  // an empty config is accepted, too: the form is that of this one once it has its seed
  await page.until(`document.getElementById("config-seed")?.value > ""`, "the seed of the TOML in the form");
  await shows(page, "would be accepted");
  await page.value(`(() => { const seed = document.getElementById("config-seed"); seed.value = "7"; seed.dispatchEvent(new Event("change")); })()`);
  await page.until(`/^seed = 7$/m.test(document.getElementById("config").value)`, "the seed of the form in the TOML");
  await shows(page, "would be accepted");
}

// calibrate -> history
export async function calibrate(page, { root, work }) {
  await go(page, "Gauge");
  const plan = readFileSync(`${root}/configs/small_calibration.toml`, "utf8");
  await page.clickWords("summary", "Calibrate a simulated setup");
  // those of runs are in the list, too
  const before = await page.value('document.querySelectorAll(".scroll tbody tr").length');
  for (let k = 0; k < (work.calibrations ?? 1); k += 1) {
    await page.type("#calibration-config", plan.replace("seed = 1", `seed = ${k + 1}`));
    await page.clickWords("button", "Calibrate");
    await page.until(`document.querySelectorAll(".scroll tbody tr").length === ${before + k + 1} && document.getElementById("calibration-config").value === ""`, `calibration ${k + 1} in the list`);
  }
  await listed(page, "valid");
  await page.onlyOne(".plot canvas");
  // what is no calibration is refused in words
  await page.clickWords("summary", "Add a calibration");
  await page.upload("#calibration-file", resolve(root, "configs/tool/nose.json"));
  await page.clickWords("button", "Add calibration");
  await page.until("document.getElementById('problem').textContent.includes('no calibration')", "a refusal");
  await shows(page, "Everything is as it was stored.");
  await shows(page, "Window and drift");
  console.log("calibrate: calibrated, in the list with its check pin, a foreign file refused");
}

// a source that is measured
export async function live(page) {
  await go(page, "Live");
  await page.until("/mm$/.test(document.querySelector('.now').textContent)", "a diameter");
  await page.until("/frame \\d+/.test(document.querySelector('.frame-place').innerText)", "a frame with its edges");
  await page.until("document.querySelectorAll('.plot canvas').length >= 3", "trend, profile along z and grey profile");
  await page.clickWords("summary", "Set-up aids: focus, alignment, light");
  await shows(page, "Blur of the upper edge");
  await go(page, "Gauge");
  await shows(page, "darkest place");
  console.log(`gauge: ${await page.value("[...document.querySelectorAll('main dd')].slice(0, 4).map((e) => e.textContent).join('; ')")}`);
  await go(page, "Live");
  await page.until("/mm$/.test(document.querySelector('.now').textContent)", "a diameter again");
  console.log(`live: ${await page.value("document.querySelector('.now').textContent + ' ' + document.querySelector('.under').textContent")}`);
}
