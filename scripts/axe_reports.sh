#!/bin/sh
# Whether HTML reports can be read by everybody: axe-core in a headless Chromium, on a screen of 1280 px, on one of 390 px and in the
# dark scheme; nothing serious or critical may be found, and no page may scroll sideways.
#   sh scripts/axe_reports.sh FILE.html...
# Needs Chromium (Debian: apt-get install chromium), Node with npm, and the package axe-core: from AXE=PATH/axe.min.js, or by npm.
# Where one of them is missing it prints SKIPPED and ends well; REQUIRE_AXE=1 makes that an error.
set -eu

skipped() {
  echo "SKIPPED: reports are not checked by axe-core: $1" >&2
  [ "${REQUIRE_AXE:-0}" = 1 ] && exit 1
  exit 0
}

[ $# -gt 0 ] || { echo "usage: sh scripts/axe_reports.sh FILE.html..." >&2; exit 2; }
for file; do
  [ -f "$file" ] || { echo "$file: no such file" >&2; exit 3; }
done
browser=
for name in chromium chromium-browser google-chrome; do
  if command -v "$name" >/dev/null 2>&1; then browser=$name; break; fi
done
[ -n "$browser" ] || skipped "no Chromium (apt-get install chromium)"
command -v node >/dev/null 2>&1 || skipped "no Node (apt-get install nodejs npm)"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
axe=${AXE:-}
if [ -z "$axe" ]; then
  command -v npm >/dev/null 2>&1 || skipped "no npm (apt-get install npm), and AXE names no axe.min.js"
  (cd "$work" && npm pack --silent axe-core@4 >/dev/null 2>&1 && tar xzf axe-core-*.tgz) || skipped "npm cannot fetch axe-core"
  axe=$work/package/axe.min.js
fi
[ -f "$axe" ] || skipped "no $axe"

# A copy of the page with axe-core in it, which writes its result into the document; and a page that holds the copy in a frame of a
# stated width, because a window of Chromium has a least one.
cat >"$work/prepare.js" <<'JS'
const fs = require("fs");
const [axe, page, copy, holder, width] = process.argv.slice(2);
const script = `<script>${fs.readFileSync(axe, "utf8").replace(/<\/script/g, "<\\/script")}</script>
<script>window.addEventListener("load", () => axe.run(document).then(
  found => parent.postMessage({ found: found.violations, rules: found.passes.length, wide: document.documentElement.scrollWidth > innerWidth }, "*"),
  error => parent.postMessage({ error: String(error) }, "*")));</script>`;
const html = fs.readFileSync(page, "utf8");
const end = html.lastIndexOf("</body>");
if (end < 0) { console.error(`${page}: no </body>`); process.exit(3); }
fs.writeFileSync(copy, html.slice(0, end) + script + html.slice(end));
fs.writeFileSync(holder, `<!doctype html><title>holder</title><iframe src="file://${copy}" width="${width}" height="2000"></iframe>
<script>window.addEventListener("message", event => {
  const result = document.createElement("pre");
  result.id = "result";
  result.textContent = encodeURIComponent(JSON.stringify(event.data));
  document.body.append(result);
});</script>`);
JS

cat >"$work/judge.js" <<'JS'
const fs = require("fs");
const [dump, name] = process.argv.slice(2);
const text = /<pre id="result">([^<]*)<\/pre>/.exec(fs.readFileSync(dump, "utf8"));
if (!text) { console.error(`${name}: axe-core gave no result`); process.exit(1); }
const { error, found, rules, wide } = JSON.parse(decodeURIComponent(text[1]));
if (error) { console.error(`${name}: ${error}`); process.exit(1); }
let bad = wide;
if (wide) console.error(`${name}: the page scrolls sideways`);
for (const { impact, id, help, nodes } of found) {
  const isBad = impact === "serious" || impact === "critical";
  bad ||= isBad;
  console.error(`${name}: ${impact}: ${id}: ${help}: ${nodes.slice(0, 3).map(node => node.target.join(" ")).join(", ")}`);
}
if (rules < 5) { console.error(`${name}: only ${rules} rules applied`); bad = true; }
console.log(`${name}: ${bad ? "FAILED" : "ok"}, ${rules} rules passed`);
process.exit(bad ? 1 : 0);
JS

failed=0
for file; do
  # Width of the page, and Chromium's number of the scheme: 1 light, 0 dark.
  for look in 1280:1 390:1 390:0 1280:0; do
    width=${look%:*} scheme=${look#*:}
    node "$work/prepare.js" "$axe" "$file" "$work/copy.html" "$work/holder.html" "$width"
    timeout 120 "$browser" --headless --no-sandbox --disable-gpu --allow-file-access-from-files --virtual-time-budget=60000 \
      --window-size=1400,2100 --blink-settings="preferredColorScheme=$scheme" --user-data-dir="$work/profile" \
      --dump-dom "file://$work/holder.html" >"$work/dump.html" 2>"$work/browser.log" || { cat "$work/browser.log" >&2; failed=1; continue; }
    [ "$scheme" = 1 ] && words=light || words=dark
    node "$work/judge.js" "$work/dump.html" "$file ($width px, $words)" || failed=1
  done
done
exit "$failed"
