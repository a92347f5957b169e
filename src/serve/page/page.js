"use strict";
// The pages: each is a function that fills <main> and returns what ends it.

let leave = () => {};

async function show() {
  const [page, argument] = (location.hash.slice(1) || "live").split("/");
  const pages = { live, runs, run, compare, products, tools, machines, programs, program, history, gauge };
  leave();
  leave = () => {};
  said();
  for (const link of document.querySelectorAll("nav a")) {
    if (link.hash === "#" + ({ run: "runs", compare: "runs", program: "programs" }[page] || page)) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  document.title = `${page} – shadowgauge`;
  try {
    leave = await (pages[page] || live)(argument && decodeURIComponent(argument));
  } catch (error) {
    main.replaceChildren(element("h1", {}, page));
    said(error);
  }
}

window.addEventListener("hashchange", show);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
show();
