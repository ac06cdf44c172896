// Pictures of every page, for visual checks: `SHOTS=folder node --test web/test/shots.js`.
import path from "node:path";
import { after, test } from "node:test";
import { inBrowser, serve } from "./browser/harness.js";
import { pageList, visit } from "./browser/pages.js";

const folder = process.env["SHOTS"] ?? "shots";
const looks = /** @type {const} */ ([
  ["light", { settings: { theme: "light" } }],
  ["dark", { settings: { theme: "dark" } }],
  ["tablet", { settings: { theme: "dark" }, context: { viewport: { width: 768, height: 1024 } } }],
  ["narrow", { settings: { theme: "light" }, context: { viewport: { width: 360, height: 740 } } }],
  ["german", { settings: { theme: "light", language: "de" } }],
]);

test("pictures", async () => {
  const server = await serve();
  after(() => server.stop());
  /** @type {import("./browser/pages.js").Listed[] | undefined} */
  let list;
  for (const [look, options] of looks) {
    await inBrowser(server, options, async (world) => {
      list ??= await pageList(world);
      for (const listed of list) {
        const { name } = listed;
        await visit(world, listed);
        // as high as the page: a capture larger than the window changes its layout
        const { width } = world.page.viewportSize() ?? { width: 1280 };
        const height = await world.page.evaluate(() => document.documentElement.scrollHeight);
        await world.page.setViewportSize({ width, height });
        await world.page.screenshot({ path: path.join(folder, `${name}-${look}.png`), animations: "disabled" });
        await world.page.setViewportSize({ width, height: 800 });
      }
    });
  }
});
