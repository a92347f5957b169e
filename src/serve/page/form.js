"use strict";
// The schema of a run's config as a form, beside the TOML that is sent: each writes the other.

const isTable = (value) => value !== null && typeof value === "object" && !Array.isArray(value);
const tomlKey = (key) => (/^[A-Za-z0-9_-]+$/.test(key) ? key : JSON.stringify(key));

function tomlValue(value) {
  if (Array.isArray(value)) return `[${value.map(tomlValue).join(", ")}]`;
  if (isTable(value)) return `{ ${Object.entries(value).map(([key, inner]) => `${tomlKey(key)} = ${tomlValue(inner)}`).join(", ")} }`;
  return typeof value === "string" ? JSON.stringify(value) : String(value);
}

// Values before tables, as TOML has them; a list of tables as [[…]].
function toml(values, above = []) {
  const [lines, tables] = [[], []];
  for (const [key, value] of Object.entries(values)) {
    const at = [...above, key], name = at.map(tomlKey).join(".");
    if (isTable(value)) {
      const inner = toml(value, at);
      // a table that has tables alone needs no line of its own
      const bare = Object.keys(value).length && Object.values(value).every(isTable);
      tables.push(bare ? inner : `[${name}]\n${inner}`);
    } else if (Array.isArray(value) && value.length && value.every(isTable)) value.forEach((one) => tables.push(`[[${name}]]\n${toml(one, at)}`));
    else lines.push(`${tomlKey(key)} = ${tomlValue(value)}\n`);
  }
  return lines.join("") + (lines.length && tables.length ? "\n" : "") + tables.join("\n");
}

// A schema without its references and without "or null".
function plain(schema, all) {
  const named = schema.$ref ? { ...all.$defs[schema.$ref.split("/").pop()], ...schema, $ref: undefined } : schema;
  const either = named.anyOf?.filter((one) => one.type !== "null");
  if (named.anyOf && either.length === 1 && either.length < named.anyOf.length) return plain({ ...either[0], description: named.description ?? either[0].description, default: named.default }, all);
  return named;
}

const within = (values, path) => path.reduce((at, key) => (isTable(at) ? at[key] : undefined), values);

// Sets a value, or takes it out with the tables that are empty then.
function setValue(values, [key, ...rest], value) {
  if (rest.length) {
    if (!isTable(values[key])) values[key] = {};
    setValue(values[key], rest, value);
    if (!Object.keys(values[key]).length) delete values[key];
  } else if (value === undefined) delete values[key];
  else values[key] = value;
}

const shownDefault = (schema) => (schema.default === undefined || schema.default === null ? "" : typeof schema.default === "string" ? schema.default : JSON.stringify(schema.default));

// A control of one value: its text to a value, undefined where it is empty (the default then). What is no single value is JSON.
function leaf(schema, id, value) {
  const kind = [].concat(schema.type ?? []).find((type) => type !== "null"), words = schema.enum ?? (schema.oneOf?.every((one) => typeof one.const === "string") ? schema.oneOf.map((one) => one.const) : null);
  const choices = words ?? (kind === "boolean" ? ["true", "false"] : null);
  const initial = value === undefined ? "" : typeof value === "string" ? value : JSON.stringify(value);
  if (choices) {
    const select = element("select", { id }, element("option", { value: "" }, `default${shownDefault(schema) ? `: ${shownDefault(schema)}` : ""}`), ...choices.map((word) => element("option", { value: word }, word)));
    select.value = initial;
    return [select, () => (select.value === "" ? undefined : kind === "boolean" ? select.value === "true" : select.value)];
  }
  const isNumber = kind === "number" || kind === "integer";
  const control = element("input", { id, type: isNumber ? "number" : "text", step: kind === "integer" ? "1" : "any", placeholder: shownDefault(schema).slice(0, 60) });
  control.value = initial;
  const read = () => {
    if (control.value === "") return undefined;
    if (isNumber) return Number(control.value);
    if (kind === "string") return control.value;
    try { return JSON.parse(control.value); } catch { return control.value; }
  };
  return [control, read];
}

// The fields of a table; tables in it are made when they are opened.
function fields(schema, all, { path, values, changed }) {
  return Object.entries(schema.properties ?? {}).map(([key, property]) => {
    const inner = plain(property, all), at = [...path, key], id = `config-${at.join("-")}`;
    if (inner.properties) {
      const state = within(values(), at), place = element("div", { class: "table" });
      const details = element("details", {}, element("summary", {}, key, state ? ` (${Object.keys(state).length} set)` : "", element("small", {}, ` ${(inner.description ?? "").split("\n")[0]}`)), place);
      const fill = () => { if (details.open && !place.childElementCount) place.append(...fields(inner, all, { path: at, values, changed })); };
      details.addEventListener("toggle", fill);
      return details;
    }
    const [control, read] = leaf(inner, id, within(values(), at));
    control.addEventListener("change", () => changed(at, read()));
    const words = (property.description ?? inner.description ?? "").replaceAll("\n", " ");
    control.setAttribute("aria-describedby", `${id}-words`);
    return element("div", { class: "leaf" }, element("label", { for: id }, key), control, element("small", { id: `${id}-words` }, words.slice(0, 240)));
  });
}

// The form beside a text of TOML. It writes the text anew, without its comments; the text writes the form when it is left.
function configForm(area) {
  const place = element("div"), verdict = element("p", { class: "under", role: "status" }, "");
  let values = {}, schema = null;
  async function look() {
    try {
      const answer = await api("config", { method: "POST", body: JSON.stringify({ config: area.value }) });
      ({ values } = answer);
      verdict.textContent = answer.refused ? `would be refused: ${answer.refused}` : "would be accepted";
      verdict.className = answer.refused ? "under bad" : "under good";
      return true;
    } catch (error) {
      verdict.textContent = `no TOML: ${error.message}`;
      verdict.className = "under bad";
      return false;
    }
  }
  const changed = (path, value) => {
    setValue(values, path, value);
    area.value = toml(values);
    look();
  };
  async function load() {
    schema ??= await api("config");
    if (await look()) place.replaceChildren(...fields(schema, schema, { path: [], values: () => values, changed }));
  }
  area.addEventListener("change", () => load().catch(said));
  return { whole: element("section", {}, element("h2", {}, "As a form"), verdict, place), load };
}
