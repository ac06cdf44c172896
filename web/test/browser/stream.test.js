// A stream during a measurement: the reason for a missing result, the estimate as others add nodes,
// its end.

import assert from "node:assert/strict";
import { watchRequests } from "./requests.js";
import { browserTest, example } from "./harness.js";

/** @typedef {import("./harness.js").World} World */

/** Opens a stream of the flank's nodes. @param {World} world @param {object} [change] */
async function opened({ job, call }, change = {}) {
  const { id } = await job();
  const { nodes, axes, model, regularization } = JSON.parse(await example("flank_z52.json"));
  const spec = { model, regularization, axes, flank: "left", tooth: "1", ...change };
  const stream = await call("POST", `/v1/jobs/${id}/streams`, spec);
  let sequence = 0;
  /** Sends rows of the flank as a block. @param {number[]} rows */
  const send = (rows) => {
    sequence += 1;
    /** @type {{ type: string, u: number[], v: number[], z: number[] }} */
    const block = { type: "scattered", u: [], v: [], z: [] };
    for (const row of rows) {
      for (const [column, z] of nodes.z[row].entries()) {
        if (z === null) continue;
        block.u.push(nodes.u[row]);
        block.v.push(nodes.v[column]);
        block.z.push(z);
      }
    }
    return call("POST", `/v1/streams/${stream.id}/nodes`, { sequence, nodes: block });
  };
  return { id, stream, send, path: `/jobs/${id}/streams/${stream.id}` };
}

browserTest("a stream says why there is no result yet, and follows its blocks", {}, async (world) => {
  const { page, open, loaded } = world;
  const { send, path } = await opened(world);
  await open(path);
  await page.getByRole("heading", { name: "No result yet" }).waitFor();
  await page.getByText("no nodes so far").waitFor();
  const first = await send([0]);
  await page.locator('[data-sequence="1"]').waitFor();
  await page.getByText(first.warnings[0].message).waitFor();
  await send([2, 4]);
  await page.getByRole("slider", { name: "Coefficient of 1" }).waitFor();
  const last = await send([6, 8]);
  await page.locator('[data-sequence="3"]').waitFor();
  await loaded();
  assert.equal(await page.getByText("No result yet").count(), 0);
  const { result, node_count: nodes } = last;
  const rows = page.getByRole("region", { name: "Coefficients" }).locator("tbody tr");
  assert.equal(await rows.count(), result.coefficients.length);
  for (const [i, { value, std_error: error }] of result.coefficients.entries()) {
    const place = 1 - Math.floor(Math.log10(Number(error.toPrecision(2))));
    // the smallest are written by a power of ten
    if (Math.max(Math.abs(value), error) < 1e-3) continue;
    const text = (await rows.nth(i).textContent()) ?? "";
    const words = `${value.toFixed(place)} ± ${error.toFixed(place)}`.replace("-", "−");
    assert.ok(text.includes(words), `${text}: ${words}`);
  }
  const figure = page.locator("figure", { hasText: "Condition" }).last();
  await figure.getByText(`after ${nodes} nodes`).waitFor();
  const lambda = page.locator("figure", { hasText: "λ*" });
  await lambda.getByRole("button", { name: "As table" }).click();
  assert.equal(await lambda.locator("tbody tr").count(), 2, "both estimates that were seen");
  await page.getByRole("group", { name: "Coefficients" }).getByRole("button", { name: "u²", exact: true }).click();
  await page.waitForURL(/term=/);
  await page.getByRole("slider", { name: "Coefficient of u² ±" }).waitFor();
  // the map has all nodes so far: their greatest height and where it is
  const map = page.getByRole("region", { name: "Nodes so far" });
  const flank = JSON.parse(await example("flank_z52.json")).nodes;
  const greatest = Math.max(...[0, 2, 4, 6, 8].flatMap((row) => flank.z[row]).filter((z) => z !== null));
  const written = `${greatest < 0 ? "−" : "+"}${Math.abs(greatest).toFixed(1)}`;
  const most = (await map.locator('[data-extreme="greatest"]').textContent()) ?? "";
  assert.ok(most.includes(written.replace("+", "")), `${most}: ${written}`);
  // a selection does not hold back events
  await send([1]);
  await page.locator('[data-sequence="4"]').waitFor();
});

browserTest("what waits in a dialog is stopped there, and by closing it", { offline: true }, async (world) => {
  const { page, open, call } = world;
  const { send, stream, path } = await opened(world);
  for (const row of [0, 4, 8]) await send([row]);
  await open(path);
  await page.clock.install();
  let tries = 0;
  await page.route("**/finish", (route) => {
    tries += 1;
    return route.abort("connectionreset");
  });
  const dialog = page.getByRole("dialog", { name: "Finish the stream" });
  const finish = dialog.getByRole("button", { name: "Finish", exact: true });
  await page.getByRole("button", { name: "Finish the stream" }).click();
  await finish.click();
  await dialog.getByRole("button", { name: "Do not resend" }).click();
  await dialog.getByText("The server is not responding").waitFor();
  const stopped = tries;
  assert.ok(stopped > 0 && stopped < 5, `it was tried ${stopped} times`);
  await page.clock.runFor(60_000);
  assert.equal(tries, stopped);

  await finish.click();
  await dialog.getByText("Your input is queued").waitFor();
  await page.keyboard.press("Escape");
  await dialog.waitFor({ state: "detached" });
  await page.getByText("Cancelled. Data that had already arrived may be stored").waitFor();
  const left = tries;
  await page.clock.runFor(60_000);
  assert.equal(tries, left);
  assert.equal((await call("GET", `/v1/streams/${stream.id}`)).state, "open");
});

browserTest("many blocks are requested at most twice a second", {}, async (world) => {
  const { page, open } = world;
  const { send, path, stream } = await opened(world);
  const requests = await watchRequests(page, `/v1/streams/${stream.id}`);
  await open(path);
  const before = (await requests()).times.length;
  const begun = performance.now();
  for (let i = 0; i < 24; i += 1) await send([i % 9]);
  await page.locator('[data-sequence="24"]').waitFor();
  const times = (await requests()).times.slice(before);
  // slow processing of 24 blocks takes more time
  const most = Math.max(12, 2 + (performance.now() - begun) / 500);
  assert.ok(times.length > 0 && times.length < most, `${times}`);
  for (const [i, time] of times.entries()) {
    const earlier = times[i - 2];
    if (earlier !== undefined) assert.ok(time - earlier > 800, `${times}`);
  }
});

browserTest("a stream is finished, here and by another client", {}, async (world) => {
  const { page, open, loaded, call } = world;
  const { id, stream, send, path } = await opened(world, { regularization: { type: "none" } });
  await send([0, 2, 4, 6, 8]);
  await open(path);
  await page.getByText("No regularisation, hence no").waitFor();
  await page.getByRole("button", { name: "Finish the stream" }).click();
  const dialog = page.getByRole("dialog", { name: "Finish the stream" });
  await dialog.getByLabel("Instrument").fill("P40");
  await dialog.getByRole("button", { name: "Finish", exact: true }).click();
  await page.waitForURL(`**/jobs/${id}/iterations/1`);
  await loaded();
  const kept = await call("GET", `/v1/jobs/${id}/iterations/1`);
  assert.deepEqual(
    [kept.instrument, kept.node_count],
    ["P40", (await call("GET", `/v1/streams/${stream.id}`)).node_count],
  );
  const other = await opened(world);
  await other.send([0, 2, 4, 6, 8]);
  await open(other.path);
  await page.getByText("being measured").waitFor();
  await call("POST", `/v1/streams/${other.stream.id}/finish`, {});
  await page.getByText("finished", { exact: true }).waitFor();
  await page.getByRole("link", { name: "To iteration 1" }).waitFor();
});

browserTest("the job's other pages lead to a stream that is being measured", {}, async (world) => {
  const { page, open } = world;
  const { id, send, path } = await opened(world);
  const begun = page.waitForResponse((response) => response.url().endsWith("/events"));
  await open(`/jobs/${id}`);
  await begun;
  await send([0, 2]);
  await page.getByRole("link", { name: "Watch" }).click();
  await page.waitForURL(`**${path}`);
  await page.getByText("being measured").first().waitFor();
  assert.equal(await page.getByRole("link", { name: "Watch" }).count(), 0);
});

browserTest("a job leads to the streams that were opened before, until they are finished", {}, async (world) => {
  const { page, open, loaded, call } = world;
  const { id, stream, send, path } = await opened(world);
  await send([0, 2, 4, 6, 8]);
  const right = await call("POST", `/v1/jobs/${id}/streams`, { model: stream.spec.model, flank: "right" });
  await open(`/jobs/${id}`);
  const note = (/** @type {string} */ text) => page.getByRole("status").filter({ hasText: text });
  await note("The left flank of tooth 1 is being measured").getByRole("link", { name: "Watch" }).waitFor();
  await note("The right flank is being measured").getByRole("link", { name: "Watch" }).waitFor();
  await call("DELETE", `/v1/streams/${right.id}`);
  await note("The right flank is being measured").waitFor({ state: "detached" });
  await page.getByRole("link", { name: "Watch" }).click();
  await page.waitForURL(`**${path}`);
  await loaded();
  await open(`/jobs/${id}`);
  await page.getByRole("link", { name: "Watch" }).waitFor();
  await call("POST", `/v1/streams/${stream.id}/finish`, {});
  await page.getByRole("link", { name: "Watch" }).waitFor({ state: "detached" });
});

browserTest("a job is shown before it is known what is being measured", {}, async (world) => {
  const { page, iteration, server, loaded } = world;
  const { id } = await opened(world);
  await iteration(id);
  /** @type {() => void} */
  let known = () => undefined;
  const late = new Promise((resolve) => {
    known = () => resolve(undefined);
  });
  let requests = 0;
  await page.route(`**/v1/jobs/${id}/streams?*`, async (route) => {
    requests += 1;
    await late;
    await route.continue();
  });
  await page.goto(`${server.url}/jobs/${id}`);
  await page.getByRole("table", { name: "Iterations" }).waitFor();
  assert.equal(await page.getByRole("link", { name: "Watch" }).count(), 0);
  assert.ok(requests > 0);
  known();
  await page.getByRole("link", { name: "Watch" }).waitFor();
  await loaded();
});

browserTest("heights of a few nanometres have the digits of their scale, in every place", {}, async (world) => {
  const { page, open, loaded, job, call } = world;
  const { id } = await job();
  const { nodes, axes, model } = JSON.parse(await example("flank_z52.json"));
  const small = (/** @type {(number | null)[]} */ row) => row.map((z) => (z === null ? null : z / 5000));
  const regularization = { type: "none" };
  const stream = await call("POST", `/v1/jobs/${id}/streams`, { model, axes, regularization, flank: "left" });
  const block = { sequence: 1, nodes: { ...nodes, z: nodes.z.map(small) } };
  await call("POST", `/v1/streams/${stream.id}/nodes`, block);
  const heights = block.nodes.z.flat().filter((/** @type {number | null} */ z) => z !== null);
  const limit = async () => Number(await page.locator(".map-legend text").last().textContent());
  await open(`/jobs/${id}/streams/${stream.id}`);
  assert.ok((await limit()) < 0.01, `±${await limit()} µm`);
  const ends = { least: Math.min(...heights), greatest: Math.max(...heights) };
  for (const [name, z] of Object.entries(ends)) {
    const said = (await page.locator(`[data-extreme="${name}"]`).textContent()) ?? "";
    assert.ok(said.includes(` · ${z.toFixed(4).replace("-", "−")} µm`), `${name} ${z}: ${said}`);
  }
  await page.getByRole("slider", { name: "Nodes so far" }).press("ArrowRight");
  await page.waitForURL(/at=/);
  await loaded();
  const read = await page.getByRole("slider", { name: "Nodes so far" }).getAttribute("aria-valuetext");
  assert.match(read ?? "", /0\.00\d\d µm/);
  // the section, and the tables of section and map
  const section = page.locator("figure", { hasText: "Profile section" });
  await section.getByRole("button", { name: "As table" }).click();
  assert.match((await section.locator("tbody td").last().textContent()) ?? "", /0\.00\d\d/);
  await page.locator(".flank-tools").getByRole("button", { name: "As table" }).click();
  const table = page.locator(".flank-map tbody tr").first();
  await table.waitFor();
  assert.match((await table.locator("td").last().textContent()) ?? "", /0\.00\d\d/);
});
