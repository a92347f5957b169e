// Pages in Chromium: a flow or all of them, then every page at two widths in both schemes, with pictures.
//   node check.mjs flow NAME URL CHROMIUM WORK.json   one flow: program, run, calibrate, live
//   node check.mjs all URL CHROMIUM WORK.json OUT [axe.min.js]
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { OBSERVER, audit, late } from "./audit.mjs";
import { Browser } from "./browser.mjs";
import * as flows from "./flows.mjs";

const root = resolve(dirname(fileURLToPath(import.meta.url)), "../..");

async function watched(page, host) {
  const foreign = page.asked.filter((url) => !url.startsWith(host) && !/^(about|data|blob|chrome):/.test(url));
  if (foreign.length) throw new Error(`another host is asked: ${[...new Set(foreign)].join(", ")}`);
  if (page.complaints.length) throw new Error(`the page complains: ${[...new Set(page.complaints)].join("; ")}`);
}

async function flow(browser, [name, url, work]) {
  const page = await browser.page();
  await page.look(1280, 900, "light");
  await page.open(url);
  await flows[name](page, { root, work });
  // a refusal that the flow asks for is an answer with a status of its own
  page.complaints = page.complaints.filter((words) => !/status of (404|409|422)/.test(words));
  await watched(page, url);
}

// Pages with what must be on them before they are looked at.
const pages = (programs) => [
  ["live", "#live", "document.querySelector('.now') !== null"], ["runs", "#runs", "document.querySelectorAll('.scroll tbody tr').length > 0"],
  ["run", "#run/first", "document.querySelectorAll('.plot canvas').length > 0"], ["compare", "#compare/first%2Cfirst", "document.querySelectorAll('.plot canvas').length > 0"],
  ["products", "#products", "document.querySelectorAll('.scroll tbody tr').length > 0"],
  ["tools", "#tools", "document.querySelectorAll('.scroll tbody tr').length > 0"], ["machines", "#machines", "document.querySelectorAll('.scroll tbody tr').length > 0"],
  ["compensation", "#programs", "document.querySelectorAll('.scroll tbody tr').length > 0"],
  ...programs.map((hash, k) => [`program${k + 1}`, hash, "document.querySelector('pre.program') !== null"]),
  ["history", "#history", "document.querySelectorAll('.plot canvas').length > 0"], ["gauge", "#gauge", "document.querySelectorAll('dl').length > 0"],
];

async function all(browser, [url, work, out, axe]) {
  mkdirSync(out, { recursive: true });
  let programs = [], faults = 0, worst = { paint: 0, weight: 0, shift: 0 };
  for (const name of ["live", "program", "run", "calibrate"]) {
    const page = await browser.page();
    await page.look(1280, 900, "light");
    await page.open(url);
    const made = await flows[name](page, { root, work });
    if (name === "program") programs = made;
    page.complaints = page.complaints.filter((words) => !/status of (404|409|422)/.test(words));
    await watched(page, url);
    await page.call("Page.close");
  }
  for (const [name, hash, ready] of pages(programs)) {
    for (const [width, scheme] of [[1280, "light"], [390, "light"], [390, "dark"], [1280, "dark"]]) {
      const page = await browser.page();
      await page.call("Page.addScriptToEvaluateOnNewDocument", { source: OBSERVER });
      await page.look(width, 900, scheme);
      await page.open(url + hash);
      await page.until(ready, `${name} filled`);
      await new Promise((done) => setTimeout(done, 600));
      // a busy machine paints late: the best of three loads is the page's
      for (let again = 0; again < 2 && await late(page); again += 1) {
        await page.open(url + hash);
        await page.until(ready, `${name} filled`);
        await new Promise((done) => setTimeout(done, 600));
      }
      const found = await audit(page, `${name} (${width} px, ${scheme})`, axe);
      faults += found.faults;
      for (const key of Object.keys(worst)) worst[key] = Math.max(worst[key], found[key] ?? 0);
      writeFileSync(`${out}/${name}_${width}_${scheme}.png`, await page.picture());
      await watched(page, url);
      await page.call("Page.close");
    }
  }
  console.log(`pages: first paint ${worst.paint.toFixed(0)} ms at most, ${worst.weight} bytes in all, layout shift ${worst.shift.toFixed(4)} at most, ${faults} faults; axe-core ${axe ? "applied" : "SKIPPED"}`);
  if (faults) process.exitCode = 1;
}

const [what, ...rest] = process.argv.slice(2);
const name = what === "flow" ? rest.shift() : null;
const [url, chromium, work, ...more] = rest;
const browser = new Browser(chromium);
try {
  const given = JSON.parse(readFileSync(work, "utf8"));
  if (name) await flow(browser, [name, url, given]);
  else await all(browser, [url, given, ...more]);
} catch (error) {
  console.error(`${name ?? "pages"}: FAILED: ${error.message}`);
  process.exitCode = 1;
} finally {
  await browser.end();
}
