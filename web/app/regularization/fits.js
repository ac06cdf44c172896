// The fits of an iteration: the one that is viewed, the chosen one, and choosing another.

import { answer, api } from "../api/client.js";
import { may } from "../api/key.js";
import { ApiError } from "../api/problem.js";
import { Criterion } from "../components/criterion.js";
import { criterionColumn, numberColumn } from "../components/columns.js";
import { Badge } from "../components/figure.js";
import { ReasonDialog } from "../components/reason_dialog.js";
import { table } from "../components/table.js";
import { notify } from "../components/toast.js";
import de from "../i18n/de/lambda.js";
import en from "../i18n/en/lambda.js";
import { t as common } from "../i18n/common.js";
import { fmt, texts } from "../i18n/i18n.js";
import { setQuery } from "../navigation.js";
import { Fragment, h, html, useState } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"Iteration">} Iteration */
/** @typedef {import("../api/client.js").Schema<"FitSummary">} FitSummary */

const t = texts({ en, de });

/**
 * @param {{ iteration: Iteration, etag: string | undefined, viewed: string, unit: string | undefined, onChosen: (iteration: Iteration, etag: string | undefined) => void }} props
 */
export function Fits({ iteration, etag, viewed, unit, onChosen }) {
  const [picked, setPicked] = useState(/** @type {FitSummary | undefined} */ (undefined));
  // the version that the dialog opened on, or that it showed after a 412: a newer one is not
  // overruled unseen
  const [known, setKnown] = useState(etag);
  const ask = (/** @type {FitSummary} */ one) => {
    setKnown(etag);
    setPicked(one);
  };
  const choose = async (/** @type {string} */ reason) => {
    if (!picked) return;
    const path = { job_id: iteration.job_id, number: iteration.number };
    const params = { path, header: known ? { "If-Match": known } : {} };
    const body = { fit_id: picked.id, ...(reason ? { reason } : {}) };
    try {
      const { data, etag: next } = await answer(
        api.PUT("/v1/jobs/{job_id}/iterations/{number}/chosen-fit", { params, body }),
      );
      onChosen(data, next);
      notify(t.nowChosen);
    } catch (failed) {
      // shows the current choice next to the one to be made
      if (failed instanceof ApiError && failed.status === 412) {
        const now = await answer(api.GET("/v1/jobs/{job_id}/iterations/{number}", { params: { path } }));
        setKnown(now.etag);
        onChosen(now.data, now.etag);
      }
      throw failed;
    }
  };
  /** @type {readonly import("../components/table.js").Column<FitSummary>[]} */
  const columns = [
    criterionColumn(t.criterion),
    numberColumn("lambda", t.symbol("λ*"), (one) => one.lambda_star),
    numberColumn("condition", t.condition, (one) => one.regularized_condition, { write: fmt.value.condition }),
    numberColumn("rms", t.rms, (one) => one.rms, { unit }),
    {
      key: "made",
      header: t.made,
      numeric: true,
      cell: (one) => html`<time datetime=${one.created_at} translate="no">${fmt.value.time(one.created_at)}</time>`,
      csv: (one) => one.created_at,
    },
    {
      key: "reason",
      header: t.reason,
      cell: ({ reason }) => (reason ? html`<span translate="no">${reason}</span>` : "–"),
      csv: ({ reason }) => reason,
    },
    { key: "chosen", header: t.state, cell: (one) => stateOf(one), csv: ({ chosen }) => chosen },
  ];
  const stateOf = (/** @type {FitSummary} */ one) => html`<span class="actions">
    ${one.chosen && h(Badge, { kind: "good", children: t.chosen })}
    ${
      one.id === viewed
        ? html`<span class="quiet">${t.viewed}</span>`
        : html`<button type="button" class="button small" onClick=${() => setQuery({ fit: one.chosen ? undefined : one.id, by: undefined, lambda: undefined }, { step: true })}>${t.view}</button>`
    }
    ${!one.chosen && may("decide") && html`<button type="button" class="button small" onClick=${() => ask(one)}>${t.choose}</button>`}
  </span>`;
  return h(
    Fragment,
    null,
    html`<section class="panel">
      <h2>${t.fits}</h2>
      ${(iteration.earlier_fits ?? 0) > 0 && html`<p class="quiet">${t.earlierFits(iteration.earlier_fits ?? 0)}</p>`}
      ${table({ caption: t.fits, hideCaption: true, columns, rows: iteration.fits, rowKey: ({ id }) => id, csvName: "fits", stacked: true })}
    </section>`,
    picked &&
      h(ReasonDialog, {
        title: t.choose,
        text: t.chooseText,
        label: t.reason,
        action: t.choose,
        draft: `choose ${picked.id}`,
        versions: () => h(Versions, { iteration, mine: picked }),
        send: choose,
        onClose: () => setPicked(undefined),
      }),
  );
}

/** The current choice, and the one to be made. @param {{ iteration: Iteration, mine: FitSummary }} props */
function Versions({ iteration, mine }) {
  const now = iteration.fits.find(({ chosen }) => chosen);
  const written = (/** @type {FitSummary | undefined} */ fit) =>
    fit
      ? html`${h(Criterion, { name: fit.criterion })}, <span translate="no">λ* ${fmt.value.three(fit.lambda_star)}</span>`
      : "–";
  const decided = iteration.decision ? common[iteration.decision] : undefined;
  return html`<dl class="facts">
    <div><dt>${t.chosenNow}</dt><dd>${written(now)}${decided && html` · ${decided}`}</dd></div>
    <div><dt>${t.yours}</dt><dd>${written(mine)}</dd></div>
  </dl>`;
}
