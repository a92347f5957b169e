// A page as everybody gets it: axe-core, no sideways scroll, no shift of the layout, first paint, weight, hosts asked.
import { readFileSync } from "node:fs";

// Limits: of the issue of these pages; a shift of the layout of 0.1 is "good" by web.dev's measure, ours is ten times stricter.
const PAINT_MS = 300, WEIGHT_BYTES = 300 * 1024, SHIFT = 0.01;

// Sees shifts from the first frame on: it runs before any script of the page.
export const OBSERVER = `window.shifts = []; window.weight = 0;
new PerformanceObserver((list) => { for (const e of list.getEntries()) if (!e.hadRecentInput) window.shifts.push([e.value, [...e.sources ?? []].map((s) => s.node?.nodeName + "." + (s.node?.className ?? "")).join(" ")]); }).observe({ type: "layout-shift", buffered: true });`;

export const late = (page) => page.value(`!(performance.getEntriesByName("first-contentful-paint")[0]?.startTime <= ${PAINT_MS})`);

export async function audit(page, name, axe) {
  const faults = [];
  const measured = await page.value(`(() => {
    const paint = performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? null;
    const all = [...performance.getEntriesByType("navigation"), ...performance.getEntriesByType("resource")].filter((e) => !/\\/api\\//.test(e.name));
    return { paint, weight: all.reduce((sum, e) => sum + e.transferSize, 0), shifts: window.shifts, wide: document.documentElement.scrollWidth - innerWidth };
  })()`);
  if (measured.wide > 0) faults.push(`scrolls sideways by ${measured.wide} px`);
  const shift = measured.shifts.reduce((sum, [value]) => sum + value, 0);
  if (shift > SHIFT) faults.push(`the layout shifts by ${shift.toFixed(3)}: ${measured.shifts.map(([v, n]) => `${v.toFixed(3)} ${n}`).slice(0, 4).join("; ")}`);
  if (measured.paint === null || measured.paint > PAINT_MS) faults.push(`first paint after ${measured.paint} ms`);
  if (measured.weight > WEIGHT_BYTES) faults.push(`${measured.weight} bytes of pages and scripts`);
  if (axe) {
    // the page's own policy forbids eval, not what the protocol runs
    await page.value(readFileSync(axe, "utf8") + "; 0");
    const { found, rules } = await page.value(`axe.run(document).then((r) => ({ found: r.violations.map((v) => ({ impact: v.impact, id: v.id, help: v.help, where: v.nodes.slice(0, 3).map((n) => n.target.join(" ")) })), rules: r.passes.length }))`);
    for (const { impact, id, help, where } of found) {
      const words = `${impact}: ${id}: ${help}: ${where.join(", ")}`;
      if (impact === "serious" || impact === "critical") faults.push(words);
      else console.log(`${name}: ${words}`);
    }
    if (rules < 5) faults.push(`only ${rules} rules of axe-core applied`);
  }
  for (const fault of faults) console.error(`${name}: ${fault}`);
  return { faults: faults.length, paint: measured.paint, weight: measured.weight, shift };
}
