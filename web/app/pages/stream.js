// A measurement as a stream of nodes: the estimate over time.

import { may } from "../api/key.js";
import { useStream, useStreamNodes } from "../api/stream.js";
import { Badge, Facts } from "../components/figure.js";
import { FinishStream } from "../components/finish_stream.js";
import { JobPage } from "../components/job_page.js";
import { Empty, Failure, loaded } from "../components/states.js";
import { CoefficientChart, FigureChart } from "../components/stream_charts.js";
import { notify } from "../components/toast.js";
import { CoefficientTable, FitFacts, Warnings } from "../flank/figures.js";
import { surfaceOf } from "../flank/layers.js";
import { kept, useNodes } from "../flank/use_layers.js";
import { FlankView } from "../flank/view.js";
import { t as common } from "../i18n/common.js";
import { heightUnit } from "../lib/units.js";
import { termSign } from "../lib/terms.js";
import de from "../i18n/de/stream.js";
import en from "../i18n/en/stream.js";
import { fmt, texts } from "../i18n/i18n.js";
import { navigate, query, setQuery } from "../navigation.js";
import { href, hrefIf } from "../router.js";
import { WarningList } from "../components/warnings.js";
import { Fragment, h, html, useMemo, useState } from "../../vendor/ui.js";

/** @typedef {import("../api/stream.js").Stream} Stream */
/** @typedef {import("../api/stream.js").Estimate} Estimate */

const t = texts({ en, de });
export const styles = ["iteration", "stream"];

/** @param {{ params: Record<string, string> }} props */
export default function StreamPage({ params }) {
  const jobId = params["job_id"] ?? "";
  const streamId = params["stream_id"] ?? "";
  const { resource, history, wake } = useStream(streamId);
  return h(JobPage, {
    jobId,
    view: t.stream,
    onEvents: (events) => {
      if (events.length === 0 || events.some(({ stream_id: id }) => id === streamId)) wake();
    },
    children: (job) =>
      loaded({
        resource,
        lines: 10,
        back: html`<a class="button" href=${href("/jobs/{job_id}", { job_id: jobId })}>${t.toJob}</a>`,
        children: (stream) =>
          h(Whole, { stream, history, flipU: job.gear?.internal === true, reload: resource.reload }),
      }),
  });
}

/** @param {{ stream: Stream, history: readonly Estimate[], flipU: boolean, reload: () => void }} props */
function Whole({ stream, history, flipU, reload }) {
  const result = stream.result ?? history.at(-1)?.result;
  return html`<div class="flank-page" data-sequence=${stream.sequence}>
    <div class="flank-main">
      ${!stream.result && stream.warnings && stream.warnings.length > 0 && h(NoResult, { warnings: stream.warnings })}
      ${history.length > 0 && h(Charts, { history, stream })}
      ${h(NodesMap, { stream, domain: result?.domain, flipU })}
      ${history.length === 0 && stream.state === "finished" && h(Empty, { children: t.nothingKept })}
      ${
        result &&
        html`<section class="panel" aria-labelledby="coefficients">
          <h2 id="coefficients">${t.coefficients}</h2>
          ${h(CoefficientTable, { result, axes: stream.axes, level: stream.spec.level ?? 0.95, hideCaption: true })}
        </section>`
      }
    </div>
    <div class="flank-aside">
      ${h(State, { stream, reload })}
      ${
        result &&
        h(
          Fragment,
          null,
          html`<section class="panel" aria-labelledby="figures">
            <h2 id="figures">${t.estimate}</h2>${h(FitFacts, { result, axes: stream.axes })}
          </section>`,
          h(Warnings, { result }),
        )
      }
    </div>
  </div>`;
}

/**
 * The nodes of the blocks; of a finished stream those of its iteration.
 * @param {{ stream: Stream, domain: import("../api/client.js").Schema<"Domain"> | null | undefined, flipU: boolean }} props
 */
function NodesMap({ stream, domain, flipU }) {
  const blocks = useStreamNodes(stream);
  const finished = useNodes(stream.job_id, stream.iteration_number ?? null);
  const surface = useMemo(() => {
    if (finished.data) return kept(finished.data);
    // a surface needs places that are not all on one line
    const { u, v } = blocks.data ?? { u: [], v: [] };
    if (!blocks.data || new Set(u).size < 2 || new Set(v).size < 2) return undefined;
    return surfaceOf({ type: "scattered", ...blocks.data });
  }, [finished.data, blocks.data]);
  const error = blocks.error ?? finished.error;
  if (error !== undefined)
    return h(Failure, { error, retry: stream.iteration_number ? finished.reload : blocks.reload });
  if (!surface) return null;
  return html`<section class="panel" aria-labelledby="map">
    <h2 id="map">${t.map}</h2>
    ${h(FlankView, {
      surface,
      title: t.measured,
      name: t.map,
      unit: heightUnit(stream.axes) ?? common.callersUnit,
      axes: stream.axes,
      range: domain,
      flipU,
      file: `stream-${stream.id}`,
    })}
  </section>`;
}

/** @param {{ warnings: readonly { code: string, message: string }[] }} props */
function NoResult({ warnings }) {
  return html`<section class="panel" aria-labelledby="no-result">
    <h2 id="no-result">${t.noResult}</h2>
    ${h(WarningList, { warnings })}
  </section>`;
}

/** @param {{ history: readonly Estimate[], stream: Stream }} props */
function Charts({ history, stream }) {
  const terms = history.at(-1)?.result.coefficients.map(({ term }) => term) ?? [];
  const selected = query.value.get("term");
  const term = terms.find((one) => one === selected) ?? terms[0] ?? "";
  // buttons, since events are held back while a field has the focus
  return html`<section class="panel" aria-labelledby="course">
    <h2 id="course">${t.course}</h2>
    <p class="quiet">${t.since}</p>
    <div class="flank-tools">
      <div class="actions" role="group" aria-label=${t.coefficients}>
        ${terms.map(
          (
            one,
          ) => html`<button key=${one} type="button" class="button small" aria-pressed=${one === term} translate="no"
            onClick=${() => setQuery({ term: one === terms[0] ? undefined : one })}>${termSign(one)}</button>`,
        )}
      </div>
    </div>
    ${h(CoefficientChart, { history, term, axes: stream.axes })}
    <div class="flank-layout">
      <div>${h(FigureChart, { history, kind: "condition" })}</div>
      <div>${h(FigureChart, { history, kind: "lambda" })}</div>
    </div>
  </section>`;
}

/** @param {{ stream: Stream, reload: () => void }} props */
function State({ stream, reload }) {
  const [finishing, setFinishing] = useState(false);
  const data = (/** @type {string | null | undefined} */ text) => text && html`<span translate="no">${text}</span>`;
  const at = { job_id: stream.job_id, number: stream.iteration_number ?? 0 };
  const map = hrefIf("/jobs/{job_id}/iterations/{number}", at) ?? href("/jobs/{job_id}", at);
  const items = [
    { name: t.state, value: h(Badge, { kind: stream.state === "open" ? "news" : "good", children: t[stream.state] }) },
    { name: t.nodes, value: data(fmt.value.count(stream.node_count)) },
    { name: t.blocks, value: data(fmt.value.count(stream.sequence)) },
    { name: t.flank, value: stream.flank && t[stream.flank] },
    { name: t.tooth, value: data(stream.tooth) },
    { name: t.forgetting, value: data(fmt.value.input(stream.forgetting_factor)) },
    { name: t.opened, value: data(fmt.value.time(stream.created_at)) },
    { name: t.lastBlock, value: stream.sequence > 0 && data(fmt.value.clock(stream.updated_at)) },
  ].flatMap(({ name, value }) => (value ? [{ name, value }] : []));
  return html`<section class="panel" aria-labelledby="stream">
    <h2 id="stream">${t.stream}</h2>
    ${h(Facts, { items, columns: true })}
    <div class="actions">
      ${
        stream.state === "open"
          ? may("measure") &&
            html`<button type="button" class="button primary" disabled=${stream.node_count === 0} onClick=${() => setFinishing(true)}>${t.finish}</button>`
          : html`<a class="button primary" href=${map}>${t.toIteration(stream.iteration_number ?? 0)}</a>`
      }
    </div>
    ${
      finishing &&
      h(FinishStream, {
        streamId: stream.id,
        onClose: () => setFinishing(false),
        onDone: (number) => {
          setFinishing(false);
          reload();
          notify(t.finishedAs(number));
          navigate(hrefIf("/jobs/{job_id}/iterations/{number}", { ...at, number }) ?? href("/jobs/{job_id}", at));
        },
      })
    }
  </section>`;
}
