// The choice of λ*.

import assert from "node:assert/strict";
import { watchRequests } from "./requests.js";
import { browserTest } from "./harness.js";
import { unitOf } from "./numbers.js";
import { formats } from "../../app/lib/format.js";
import { termSign } from "../../app/lib/terms.js";

const f = formats("en");

browserTest("gcv is shown, stored and chosen: in the trace and the interface", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job();
  const { fits } = await iteration(id);
  await open(`/jobs/${id}/iterations/1/lambda`);
  const [fit] = fits;
  const labels = await page.locator(".choice-label").evaluateAll((all) =>
    all.map((one) => {
      const { left, right, top, bottom } = one.getBoundingClientRect();
      return { left, right, top, bottom, text: one.textContent ?? "" };
    }),
  );
  const names = fit.result.regularization.choices.flatMap((/** @type {any} */ one) =>
    one.lambda_star ? [one.criterion] : [],
  );
  assert.deepEqual(labels.flatMap(({ text }) => text.split(", ")).sort(), names.sort());
  for (const [i, a] of labels.entries())
    for (const b of labels.slice(i + 1))
      assert.ok(
        a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top,
        `${a.text} over ${b.text}`,
      );
  for (const choice of fit.result.regularization.choices) {
    const row = page
      .getByRole("table", { name: "Choices of the criteria" })
      .getByRole("row")
      .filter({ has: page.locator("code", { hasText: new RegExp(`^${choice.criterion}$`) }) });
    const cells = await row.locator(".cell").allTextContents();
    assert.deepEqual(cells.slice(1, 6), [
      f.three(choice.lambda_star),
      f.three(choice.predicted_mse),
      f.condition(choice.condition),
      f.three(choice.rms),
      f.three(choice.bias_norm),
    ]);
  }
  await page.getByRole("button", { name: "Show the refit by gcv" }).click();
  await page.getByText("not stored").waitFor();
  await loaded();
  await page.getByRole("button", { name: "Store", exact: true }).click();
  await page.getByRole("dialog").getByLabel("Reason").fill("GCV agrees with the error budget");
  await page.getByRole("dialog").getByRole("button", { name: "Store" }).click();
  await page.getByText("The refit has been stored.").waitFor();
  await page.getByRole("button", { name: "Choose this fit" }).click();
  await page.getByRole("dialog").getByLabel("Reason").fill("as agreed");
  await page.getByRole("dialog").getByRole("button", { name: "Choose this fit" }).click();
  await page.getByText("This fit is now the chosen one.").waitFor();
  const trace = await call("GET", `/v1/jobs/${id}/trace`);
  const [traced] = trace.iterations;
  const kept = traced.fits.find((/** @type {any} */ one) => one.chosen);
  assert.equal(kept.criterion, "gcv");
  assert.equal(kept.reason, "GCV agrees with the error budget");
  assert.equal(traced.choices.at(-1).fit_id, kept.id);
  assert.equal(traced.choices.at(-1).reason, "as agreed");
});

browserTest("the slider shows the interface's own values; quick moves end in the last", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job();
  const { fits } = await iteration(id);
  const requests = await watchRequests(page, "/preview");
  await open(`/jobs/${id}/iterations/1/lambda`);
  const slider = page.getByRole("slider", { name: "λ*, manual" });
  await slider.focus();
  for (let i = 0; i < 20; i += 1) await page.keyboard.press("ArrowRight");
  const { spec, result } = fits[0];
  const [low, high] = [result.spectrum.eigenvalues[0], result.spectrum.eigenvalues.at(-1)];
  const from = Math.round((500 * Math.log(result.regularization.lambda_star / low)) / Math.log(high / low));
  const value = Number((low * (high / low) ** ((from + 20) / 500)).toPrecision(6));
  await page.waitForFunction((last) => Number(new URLSearchParams(location.search).get("lambda")) === last, value);
  await loaded();
  assert.equal((await requests()).most, 1, "one request under way");
  const own = await call("POST", `/v1/jobs/${id}/iterations/1/preview`, {
    ...spec,
    include: [],
    regularization: { ...spec.regularization, lambda_star: { criterion: "fixed", value } },
  });
  assert.equal(Number(await slider.inputValue()), from + 20);
  const facts = page.locator(".lambda-shown dd");
  assert.equal(await facts.nth(0).textContent(), f.three(value));
  assert.equal(await facts.nth(1).textContent(), `${f.three(own.residuals.rms)} µm`);
  assert.equal(await facts.nth(2).textContent(), f.condition(own.spectrum.regularized.condition));
  assert.equal(await facts.nth(4).textContent(), f.three(own.bias.norm));
  const rows = page.getByRole("table", { name: "Coefficients" }).locator("tbody tr");
  for (const [i, one] of own.coefficients.entries()) {
    const cells = await rows.nth(i).locator(".cell").allTextContents();
    const unit = unitOf(one);
    assert.ok(cells[0]?.startsWith(termSign(one.term)), cells[0]);
    assert.deepEqual(cells.slice(1, 5), [
      f.withError(one.least_squares, one.least_squares_std_error, unit),
      f.withError(fits[0].result.coefficients[i].value, fits[0].result.coefficients[i].std_error, unit),
      f.withError(one.value, one.std_error, unit),
      `${f.three(one.bias_bound)}\u202f${unit}`,
    ]);
  }
  // the map is that of the refit: its least and greatest residual
  const expected = await call("POST", `/v1/jobs/${id}/iterations/1/preview`, {
    ...spec,
    include: ["residuals", "fitted"],
    regularization: { ...spec.regularization, lambda_star: { criterion: "fixed", value } },
  });
  const said = (/** @type {number[]} */ all) =>
    `Minimum ${f.um(Math.min(...all))}\u202fµm, maximum ${f.um(Math.max(...all))}\u202fµm.`;
  const map = page.locator(".lambda-map");
  await map.getByText(said(expected.residuals.values), { exact: true }).waitFor();
  await map.getByLabel("Layer").selectOption("fitted");
  await map.getByText(said(expected.residuals.fitted), { exact: true }).waitFor();
  // the address has the whole view
  await page.reload();
  await loaded();
  assert.equal(await facts.nth(1).textContent(), `${f.three(own.residuals.rms)} µm`);
  await page.getByLabel("Exact value").fill("1e-4");
  await page.getByRole("button", { name: "Show", exact: true }).first().click();
  await page.waitForFunction(() => new URLSearchParams(location.search).get("lambda") === "0.0001");
});

browserTest("ridge has its trace, truncation its ranks", {}, async ({ page, open, loaded, job, iteration, call }) => {
  const { id } = await job();
  const { fits } = await iteration(id);
  const { spec } = fits[0];
  const ridge = await call("POST", `/v1/jobs/${id}/iterations/1/fits`, { ...spec, regularization: { type: "ridge" } });
  await open(`/jobs/${id}/iterations/1/lambda?fit=${ridge.id}`);
  await page.getByRole("heading", { name: "Ridge trace" }).waitFor();
  const svd = { ...spec, regularization: { type: "truncated_svd", rank: 8 } };
  const truncated = await call("POST", `/v1/jobs/${id}/iterations/1/fits`, svd);
  await open(`/jobs/${id}/iterations/1/lambda?fit=${truncated.id}`);
  const slider = page.getByRole("slider", { name: "Directions kept" });
  assert.equal(await slider.inputValue(), "8");
  await slider.press("ArrowLeft");
  await page.waitForFunction(() => new URLSearchParams(location.search).get("lambda") === "7");
  await loaded();
  const own = await call("POST", `/v1/jobs/${id}/iterations/1/preview`, {
    ...svd,
    regularization: { type: "truncated_svd", rank: 7 },
  });
  assert.equal(await page.locator(".lambda-shown dd").nth(1).textContent(), `${f.three(own.residuals.rms)} µm`);
});

browserTest("where nobody has said a unit, it is the caller's", {}, async ({ page, open, job, call }) => {
  const { id } = await job();
  const [u, v] = [
    [1, 2, 3, 4],
    [1, 2, 3, 4],
  ];
  const nodes = { type: "grid", u, v, z: u.map((a) => v.map((b) => a * b + Math.sin(3 * a + b))) };
  await call("POST", `/v1/jobs/${id}/iterations`, { nodes, model: { type: "polynomial", degree: 1 } });
  await open(`/jobs/${id}/iterations/1/lambda`);
  await page.locator(".lambda-shown").getByText("caller’s unit").waitFor();
  await page.getByRole("columnheader", { name: "caller’s unit" }).first().waitFor();
});

browserTest("of many nodes the map follows when the slider is let go", {}, async (world) => {
  const { page, open, loaded, job, call } = world;
  const { id } = await job();
  const u = Array.from({ length: 80 }, (_, i) => 1 + i / 10);
  const z = u.map((a) => u.map((b) => Number((a * b + Math.sin(9 * a + 7 * b)).toFixed(4))));
  await call("POST", `/v1/jobs/${id}/iterations`, {
    nodes: { type: "grid", u, v: u, z },
    model: { type: "polynomial", degree: [2, 2] },
    regularization: { type: "spectral" },
  });
  await open(`/jobs/${id}/iterations/1/lambda`);
  /** @type {string[][]} */
  const requests = [];
  page.on("request", (request) => {
    if (request.url().endsWith("/preview")) requests.push(request.postDataJSON().include);
  });
  const slider = page.getByRole("slider", { name: "λ*, manual" });
  await page.getByText("the map is updated when the slider is released").waitFor();
  const send = (/** @type {string} */ kind) =>
    slider.evaluate((one, type) => {
      const input = /** @type {HTMLInputElement} */ (one);
      input.value = String(Number(input.value) + (type === "input" ? 7 : 0));
      input.dispatchEvent(new Event(type, { bubbles: true }));
    }, kind);
  await send("input");
  await page.getByText("not stored").waitFor();
  await loaded();
  assert.deepEqual(requests, [[]], "no residuals while it moves");
  const answered = page.waitForResponse((answer) => answer.url().endsWith("/preview"));
  await send("change");
  await answered;
  await loaded();
  assert.deepEqual(requests.at(-1), ["residuals"]);
  await page.locator('.lambda-map[data-refit="1"] [data-extremes]').waitFor();
});

browserTest("keeping a refit that takes long ends when it is cancelled", {}, async (world) => {
  const { page, open, loaded, job, call } = world;
  const { id } = await job();
  const u = Array.from({ length: 150 }, (_, i) => 1 + i / 10);
  const z = u.map((a) => u.slice(0, 120).map((b) => Number((Math.sin(a) + Math.sin(50 * a * b)).toFixed(4))));
  const nodes = { type: "grid", u, v: u.slice(0, 120), z };
  await call("POST", `/v1/jobs/${id}/iterations`, {
    nodes,
    model: { type: "polynomial", degree: [2, 2] },
    regularization: { type: "spectral" },
  });
  // storing takes long, as a robust fit of many nodes does
  await page.route("**/fits", async (route, request) => {
    if (request.method() !== "POST") return route.continue();
    const body = {
      ...request.postDataJSON(),
      model: { type: "polynomial", degree: [8, 8] },
      estimator: { type: "least_trimmed_squares" },
    };
    return route.continue({ postData: JSON.stringify(body) });
  });
  await open(`/jobs/${id}/iterations/1/lambda?lambda=1e-3`);
  await loaded();
  await page.getByRole("button", { name: "Store", exact: true }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("Reason").fill("to be stopped");
  await dialog.getByRole("button", { name: "Store" }).click();
  await dialog.getByRole("progressbar").waitFor();
  await dialog.getByText(/^\d+\u202f%/).waitFor();
  await dialog.getByRole("button", { name: "Cancel" }).click();
  await page.getByText("Cancelled. Data that had already arrived may be stored").waitFor();
  assert.equal(await dialog.getByLabel("Reason").inputValue(), "to be stopped");
  const { fits } = await call("GET", `/v1/jobs/${id}/iterations/1`);
  assert.equal(fits.length, 1);
});

browserTest("tables fit a tablet, of the fit and of a refit", {}, async (world) => {
  const { page, open, loaded, job, iteration } = world;
  const { id } = await job();
  await iteration(id);
  await open("/settings");
  for (const language of ["en", "de"]) {
    await page.evaluate(
      (expected) => localStorage.setItem("flankfit.settings", JSON.stringify({ language: expected })),
      language,
    );
    for (const query of ["", "?lambda=1e-4"]) {
      await page.setViewportSize({ width: 768, height: 1024 });
      await open(`/jobs/${id}/iterations/1/lambda${query}`);
      for (const width of [768, 1024]) {
        await page.setViewportSize({ width, height: 1024 });
        await loaded();
        const wide = await page
          .locator(".table-scroll")
          .evaluateAll((all) =>
            all.filter((one) => one.scrollWidth > one.clientWidth).map((one) => one.getAttribute("aria-label")),
          );
        assert.deepEqual(wide, [], `${width} px, ${language}, ${query}`);
        assert.equal(await page.locator(".table-scroll").count(), 3);
      }
    }
  }
});
