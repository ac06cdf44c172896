// Language, theme, shortcuts; the caller and their key.

import { answer, api } from "../api/client.js";
import { currentKey, forgetKey, keyWanted, session } from "../api/key.js";
import { forgetResources, useResource } from "../api/resource.js";
import { Facts } from "../components/figure.js";
import { Checkbox, SelectField } from "../components/form.js";
import { Page } from "../components/page.js";
import { loaded } from "../components/states.js";
import { t as common } from "../i18n/common.js";
import de from "../i18n/de/settings.js";
import en from "../i18n/en/settings.js";
import { fmt, texts } from "../i18n/i18n.js";
import { language, shortcuts, theme } from "../settings.js";
import { Fragment, h, html } from "../../vendor/ui.js";

const t = texts({ en, de });

export default function Settings() {
  return h(Page, {
    title: t.title,
    about: t.about,
    children: html`${h(Display, null)}${h(Access, null)}${h(Program, null)}`,
  });
}

function Display() {
  const languages = [
    { value: "en", label: html`<span lang="en" translate="no">English</span>` },
    { value: "de", label: html`<span lang="de" translate="no">Deutsch</span>` },
  ];
  const themes = [
    { value: "system", label: t.system },
    { value: "light", label: t.light },
    { value: "dark", label: t.dark },
  ];
  return html`<section class="panel" aria-labelledby="display">
    <h2 id="display">${t.display}</h2>
    <div class="fields">
      ${h(SelectField, {
        label: t.language,
        required: true,
        value: language.value,
        options: languages,
        onChange: (value) => {
          language.value = value === "de" ? "de" : "en";
        },
      })}
      ${h(SelectField, {
        label: t.theme,
        required: true,
        value: theme.value,
        options: themes,
        onChange: (value) => {
          theme.value = value === "light" || value === "dark" ? value : "system";
        },
      })}
    </div>
    <div>
      ${h(Checkbox, {
        label: t.shortcuts,
        checked: shortcuts.value,
        onChange: (on) => {
          shortcuts.value = on;
        },
      })}
      <p class="hint">${t.shortcutsHint}</p>
    </div>
  </section>`;
}

function Access() {
  // another key may be in use by now
  session.value;
  const key = currentKey();
  const who = useResource("whoami", (signal) => answer(api.GET("/v1/whoami", { signal })));
  const forget = () => {
    forgetResources();
    forgetKey();
  };
  const ask = () => {
    keyWanted.value = "unauthorized";
  };
  return html`<section class="panel" aria-labelledby="access">
    <h2 id="access">${t.access}</h2>
    ${loaded({
      resource: who,
      lines: 2,
      children: (caller) => {
        const facts = [
          { name: t.who, value: data(caller.key_name ?? caller.actor) },
          ...(caller.role ? [{ name: t.role, value: data(caller.role) }] : []),
          ...(caller.tenant ? [{ name: t.tenant, value: data(caller.tenant) }] : []),
          { name: t.scopes, value: scopesOf(caller.scopes) },
          ...(caller.expires_at ? [{ name: t.expires, value: data(fmt.value.time(caller.expires_at)) }] : []),
        ];
        return h(Facts, { items: facts });
      },
    })}
    <p class="quiet">${key ? t.hasKey : t.noKey}</p>
    <div class="actions">
      <button type="button" class="button" onClick=${ask}>${common.enterKey}</button>
      ${key && html`<button type="button" class="button" onClick=${forget}>${common.forgetKey}</button>`}
    </div>
  </section>`;
}

function Program() {
  const health = useResource("health", (signal) => answer(api.GET("/healthz", { signal })));
  return html`<section class="panel" aria-labelledby="program">
    <h2 id="program">${t.program}</h2>
    ${loaded({
      resource: health,
      lines: 1,
      children: ({ engine }) => h(Fragment, null, h(Facts, { items: [{ name: t.engine, value: data(engine) }] })),
    })}
    <p class="link-alone"><a href="/docs/">${t.interface}</a></p>
  </section>`;
}

/** The caller's permissions, in words; those without a word here by name. @param {readonly string[]} scopes */
const scopesOf = (scopes) =>
  scopes.map((scope, i) => {
    const word = /** @type {Record<string, string>} */ (/** @type {unknown} */ (t))[`may_${scope}`];
    return html`${i > 0 && ", "}${word ?? data(scope)}`;
  });

/** @param {string} text */
const data = (text) => html`<span translate="no">${text}</span>`;
