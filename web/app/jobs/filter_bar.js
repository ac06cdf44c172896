// The bar above the list: jobs by status, a search, and further filters.

import { Menu } from "../components/dialog.js";
import { Checkbox, Field, SelectField, TextField } from "../components/form.js";
import { useShortcut } from "../components/shortcuts.js";
import { t as common } from "../i18n/common.js";
import { t } from "../i18n/jobs.js";
import { fmt } from "../i18n/i18n.js";
import { setQuery } from "../navigation.js";
import { href } from "../router.js";
import { compact, hidden } from "../settings.js";
import { h, html, useEffect, useRef, useState } from "../../vendor/ui.js";
import { firstPage, isReversed, noFilters, SORTS, STATUSES } from "./filters.js";
import { optionalColumns, shows } from "./list.js";

/** @typedef {import("./filters.js").Filters} Filters */
/** @typedef {import("./filters.js").JobSummary} JobSummary */

/** The number of jobs of each status, as a link to them. @param {{ filters: Filters, sort: string, counts: (status: (typeof STATUSES)[number] | undefined) => number | undefined }} props */
export function StatusCounts({ filters, sort, counts }) {
  /** @param {(typeof STATUSES)[number] | undefined} status @param {string} label */
  const entry = (status, label) => {
    const count = counts(status);
    const to = href("/jobs", {}, { ...filters, status, sort: sort === "changed" ? undefined : sort });
    const here = filters.status === status;
    return html`<li key=${status ?? "all"}>
      <a class=${`status-count ${status ?? ""}`} href=${to} aria-current=${here ? "true" : undefined}>
        <span class="label">${label}</span> <b translate="no">${count === undefined ? "" : fmt.value.count(count)}</b>
      </a>
    </li>`;
  };
  return html`<nav class="status-counts" aria-label=${t.byStatus}>
    <ul>${entry(undefined, t.all)}${STATUSES.map((status) => entry(status, t[status]))}</ul>
  </nav>`;
}

/** The switch between one line per job and more details. */
export function Density() {
  const toggle = () => {
    compact.value = !compact.value;
  };
  return html`<button type="button" class="button density" aria-pressed=${compact.value ? "true" : "false"} onClick=${toggle}>${t.compact}</button>`;
}

/** The optional columns of the list. */
export function Columns() {
  const boxes = optionalColumns().map(({ key, header, minor: narrow }) => {
    // tablets show numbers below the name instead, except in compact lists
    const minor = narrow && (compact.value || (key !== "part" && key !== "serial"));
    const onChange = (/** @type {boolean} */ shown) => {
      const others = hidden.value.filter((one) => one !== key);
      hidden.value = shown ? others : [...others, key];
    };
    const box = h(Checkbox, { label: header, checked: shows(key), onChange });
    return html`<div key=${key} class=${minor ? "minor" : ""}>${box}</div>`;
  });
  return h(Menu, { label: t.columns, children: boxes });
}

/** @param {{ filters: Filters, sort: string, summary: JobSummary | undefined, error: unknown }} props */
export function FilterBar({ filters, sort, summary, error }) {
  return html`<div class="panel filter-bar" role="search" aria-label=${t.find}>
    <div class="filters">
      ${h(Search, { q: filters.q ?? "", error })}${h(Machine, { machine: filters.machine ?? "", summary })}
      ${h(SelectField, {
        label: t.sort,
        required: true,
        value: sort,
        options: SORTS.map((value) => ({ value, label: t[`sort_${value}`] })),
        onChange: (value) => setQuery({ sort: value === "changed" ? undefined : value, ...firstPage }, { step: true }),
      })}
    </div>
    ${h(MoreFilters, { key: JSON.stringify([filters.part, filters.tag, filters.class, filters.from, filters.to]), filters, error })}
  </div>`;
}

/** @param {{ q: string, error: unknown }} props */
function Search({ q, error }) {
  const [typed, setTyped] = useState(q);
  const field = useRef(/** @type {HTMLDivElement | null} */ (null));
  // back, forward and «all jobs» change the address independently of the field
  useEffect(() => {
    if (typed.trim() !== q) setTyped(q);
  }, [q]);
  useShortcut(
    "/",
    () => common.shortcutSearch,
    () => field.current?.querySelector("input")?.focus(),
  );
  return html`<div class="search" ref=${field}>
    ${h(TextField, {
      label: t.search,
      required: true,
      type: "search",
      value: typed,
      maxLength: 200,
      hint: t.searchHint,
      error,
      pointer: "/q",
      onInput: (value) => {
        setTyped(value);
        setQuery({ q: value.trim(), ...firstPage });
      },
    })}
  </div>`;
}

/** @param {{ machine: string, summary: JobSummary | undefined }} props */
function Machine({ machine, summary }) {
  const counted = summary?.by_machine ?? [];
  const listed = counted.some((one) => one.machine === machine) || machine === "" ? counted : [...counted, { machine }];
  const others = summary?.other_machines;
  return h(Field, {
    label: t.machine,
    required: true,
    hint: others && t.otherMachines(fmt.value.count(others.machines)),
    control: ({ id, describedBy }) => html`<select id=${id} value=${machine} aria-describedby=${describedBy}
      onChange=${(/** @type {import("../../vendor/ui.js").TargetedEvent<HTMLSelectElement>} */ event) =>
        setQuery({ machine: event.currentTarget.value, ...firstPage }, { step: true })}>
      <option value="">${t.allMachines}</option>
      ${listed.map(
        (one) => html`<option key=${one.machine} value=${one.machine} translate="no">
          ${"count" in one ? `${one.machine} (${fmt.value.count(one.count)})` : one.machine}
        </option>`,
      )}
    </select>`,
  });
}

/** The less frequent filters. They take effect when they are applied. @param {{ filters: Filters, error: unknown }} props */
function MoreFilters({ filters, error }) {
  const [typed, setTyped] = useState({
    part: filters.part ?? "",
    tag: filters.tag ?? "",
    class: filters.class ?? "",
    from: filters.from ?? "",
    to: filters.to ?? "",
  });
  const used = Object.values(typed).filter((value) => value !== "").length;
  const reversed = isReversed(typed);
  /** @param {keyof typeof typed} name @param {string} label @param {object} [more] */
  const field = (name, label, more = {}) =>
    h(TextField, {
      label,
      required: true,
      maxLength: 200,
      value: typed[name],
      error,
      onInput: (value) => setTyped((last) => ({ ...last, [name]: value })),
      ...more,
    });
  const submit = (/** @type {Event} */ event) => {
    event.preventDefault();
    if (reversed) return;
    const { part, tag, class: of, from, to } = typed;
    setQuery({ part: part.trim(), tag: tag.trim(), class: of.trim(), from, to, ...firstPage }, { step: true });
  };
  const clear = () => setQuery(noFilters(), { step: true });
  return html`<details class="more-filters" open=${used > 0}>
    <summary>${t.more}</summary>
    <form onSubmit=${submit} novalidate>
      <div class="fields">
        ${field("part", t.part, { hint: t.wholeHint, pointer: "/part_number" })}
        ${field("tag", t.tag, { hint: t.tagHint, maxLength: 401, pointer: "/tag" })}
        ${field("class", t.class, { hint: t.classHint, numeric: true, maxLength: 2, pointer: "/class" })}
        ${field("from", t.from, { type: "date", pointer: "/from" })}
        ${field("to", t.to, { type: "date", pointer: "/to", fieldError: reversed ? t.reversed : undefined })}
      </div>
      <div class="actions">
        <button type="submit" class="button">${t.apply}</button>
        <button type="button" class="button" onClick=${clear}>${t.clear}</button>
      </div>
    </form>
  </details>`;
}
