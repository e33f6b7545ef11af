// Headless Chromium for the tests that draw, and the server of the pages. FJELL_SHOTS: where pictures go, to be looked at.
import { mkdir } from "node:fs/promises";
import { join } from "node:path";
import { after, before } from "node:test";

import { build } from "esbuild";
import { chromium } from "playwright-core";

import { serve } from "./serve.mjs";

export const patience = { timeout: 90_000 };
/** NAME.mjs and all that it imports, as NAME.bundle.mjs: deck.gl is no single file that a page could import. */
export const bundle = (name) => build({ entryPoints: [`${name}.mjs`], outfile: `${name}.bundle.mjs`, bundle: true, format: "esm", minify: true, logLevel: "error" });

export const launch = { executablePath: process.env.FJELL_CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"] };

/** answered(request, response): as serve() of serve.mjs. */
export function openBrowser(folder, answered) {
  const here = { visit, shoot: (page, name) => page.screenshot({ path: join(process.env.FJELL_SHOTS, `${name}.png`) }) };
  before(async () => {
    await mkdir(process.env.FJELL_SHOTS, { recursive: true });
    here.server = await serve(folder, 0, answered);
    here.home = `http://127.0.0.1:${here.server.address().port}/`;
    here.browser = await chromium.launch(launch);
  });
  after(async () => {
    await here.browser?.close();
    here.server?.closeAllConnections();
    here.server?.close();
  });
  /** A page; page.said: its errors. */
  async function visit(path, options = { viewport: { width: 640, height: 360 } }) {
    const page = await here.browser.newPage(options);
    page.said = [];
    page.on("pageerror", (error) => page.said.push(error.message));
    page.on("console", (message) => { if (message.type() === "error") page.said.push(message.text()); });
    await page.goto(here.home + path);
    return page;
  }
  return here;
}
