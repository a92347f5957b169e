// A headless Chromium by the DevTools protocol over its pipe (--remote-debugging-pipe): Node alone, no package, no port.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

// A step of a page may take this long: a program is made in seconds, a small run in ten.
const PATIENCE_MS = 90_000;

export class Browser {
  constructor(program) {
    this.profile = mkdtempSync(join(tmpdir(), "pages-"));
    const options = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars", "--no-first-run",
      "--disable-background-networking", "--disable-component-update", "--disable-sync", "--remote-debugging-pipe", `--user-data-dir=${this.profile}`, "about:blank"];
    this.child = spawn(program, options, { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
    this.exited = new Promise((done) => this.child.once("exit", done));
    this.waiting = new Map();
    this.listeners = [];
    this.last = 0;
    let rest = Buffer.alloc(0);
    this.child.stdio[4].on("data", (bytes) => {
      rest = Buffer.concat([rest, bytes]);
      for (let end = rest.indexOf(0); end >= 0; end = rest.indexOf(0)) {
        this.take(JSON.parse(rest.subarray(0, end).toString()));
        rest = rest.subarray(end + 1);
      }
    });
    this.child.stdio[3].on("error", () => {});
  }

  take(message) {
    const call = this.waiting.get(message.id);
    if (call) {
      this.waiting.delete(message.id);
      if (message.error) call.no(new Error(`${call.method}: ${message.error.message}`));
      else call.yes(message.result);
      return;
    }
    for (const listener of this.listeners) listener(message);
  }

  call(method, params = {}, sessionId = undefined) {
    this.last += 1;
    const id = this.last;
    return new Promise((yes, no) => {
      this.waiting.set(id, { yes, no, method });
      this.child.stdio[3].write(JSON.stringify({ id, method, params, sessionId }) + "\0");
    });
  }

  async page() {
    const { targetId } = await this.call("Target.createTarget", { url: "about:blank" });
    const { sessionId } = await this.call("Target.attachToTarget", { targetId, flatten: true });
    const page = new Page(this, sessionId);
    for (const domain of ["Page", "Runtime", "Network", "DOM", "Log"]) await page.call(`${domain}.enable`);
    return page;
  }

  async end() {
    this.call("Browser.close").catch(() => {});
    await Promise.race([this.exited, new Promise((done) => setTimeout(done, 5000))]);
    this.child.kill("SIGKILL");
    await this.exited;
    rmSync(this.profile, { recursive: true, force: true, maxRetries: 5, retryDelay: 200 });
  }
}

const pause = (ms) => new Promise((done) => setTimeout(done, ms));

export class Page {
  constructor(browser, session) {
    this.browser = browser;
    this.session = session;
    // what the page asked for, and what it complained of
    this.asked = [];
    this.complaints = [];
    browser.listeners.push((message) => message.sessionId === session && this.note(message));
  }

  note({ method, params }) {
    if (method === "Network.requestWillBeSent") this.asked.push(params.request.url);
    if (method === "Runtime.exceptionThrown") this.complaints.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
    if (method === "Log.entryAdded" && params.entry.level === "error") this.complaints.push(`${params.entry.text} ${params.entry.url ?? ""}`);
    if (method === "Page.javascriptDialogOpening") this.call("Page.handleJavaScriptDialog", { accept: true }).catch(() => {});
  }

  call(method, params = {}) {
    return this.browser.call(method, params, this.session);
  }

  // The value of an expression in the page; promises are awaited.
  async value(expression) {
    const { result, exceptionDetails } = await this.call("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) throw new Error(`${expression.slice(0, 120)}: ${exceptionDetails.exception?.description ?? exceptionDetails.text}`);
    return result.value;
  }

  async until(expression, what) {
    const over = Date.now() + PATIENCE_MS;
    for (;;) {
      const value = await this.value(expression);
      if (value) return value;
      if (Date.now() > over) throw new Error(`${what}: not within ${PATIENCE_MS / 1000} s; the page says: ${await this.value("document.body.innerText.slice(0, 1500)")}`);
      await pause(50);
    }
  }

  async look(width, height, scheme) {
    await this.call("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: width < 600 });
    await this.call("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: scheme }] });
  }

  // A document is loaded anew.
  async open(url) {
    await this.call("Page.navigate", { url: "about:blank" });
    await this.until("location.href === 'about:blank'", "the empty page");
    await this.call("Page.navigate", { url });
    await this.until(`location.href.startsWith(${JSON.stringify(url.split("#")[0])}) && document.readyState === "complete"`, url);
  }

  async onlyOne(selector) {
    return this.until(`document.querySelector(${JSON.stringify(selector)}) !== null`, `${selector} on the page`);
  }

  // A click as a mouse has it: at the element's middle, once it is in view.
  async click(selector) {
    await this.onlyOne(selector);
    const [x, y] = await this.value(`(() => { const e = document.querySelector(${JSON.stringify(selector)}); e.scrollIntoView({ block: "center" }); const r = e.getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2]; })()`);
    for (const type of ["mousePressed", "mouseReleased"]) await this.call("Input.dispatchMouseEvent", { type, x, y, button: "left", clickCount: 1 });
  }

  // The element of a tag with these words.
  async clickWords(tag, words) {
    const found = `[...document.querySelectorAll(${JSON.stringify(tag)})].find((e) => e.textContent.trim() === ${JSON.stringify(words)})`;
    await this.until(`${found} !== undefined`, `${tag} "${words}"`);
    await this.value(`${found}.setAttribute("data-wanted", "")`);
    await this.click("[data-wanted]");
    await this.value(`document.querySelector("[data-wanted]")?.removeAttribute("data-wanted")`);
  }

  async type(selector, text) {
    await this.onlyOne(selector);
    await this.value(`document.querySelector(${JSON.stringify(selector)}).focus()`);
    await this.call("Input.insertText", { text });
  }

  async choose(selector, value) {
    await this.onlyOne(selector);
    const set = await this.value(`(() => { const e = document.querySelector(${JSON.stringify(selector)}); e.value = ${JSON.stringify(value)}; e.dispatchEvent(new Event("change", { bubbles: true })); return e.value; })()`);
    if (set !== value) throw new Error(`${selector} has no choice ${value}`);
  }

  async upload(selector, path) {
    await this.onlyOne(selector);
    const { root } = await this.call("DOM.getDocument");
    const { nodeId } = await this.call("DOM.querySelector", { nodeId: root.nodeId, selector });
    await this.call("DOM.setFileInputFiles", { nodeId, files: [path] });
  }

  async picture() {
    const { cssContentSize } = await this.call("Page.getLayoutMetrics");
    const clip = { x: 0, y: 0, width: cssContentSize.width, height: Math.min(cssContentSize.height, 4000), scale: 1 };
    const { data } = await this.call("Page.captureScreenshot", { format: "png", captureBeyondViewport: true, clip });
    return Buffer.from(data, "base64");
  }
}
