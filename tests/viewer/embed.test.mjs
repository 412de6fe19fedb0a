// The page in a frame, as in a notebook: files and state are handed in, changes are told.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { GOLDEN, PAGE, launch } from "./browser.mjs";

let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

/// The code that a notebook runs, of the Python module.
const widget = () => {
    const source = readFileSync(join(import.meta.dirname, "../../bindings/python/bsdfkit/jupyter.py"), "utf8");
    return source.split('_ESM = """')[1].split('"""')[0];
};

test("a notebook's frame shows what it is handed, and tells of the light", async () => {
    const page = await browser.newPage();
    const faults = [];
    page.on("pageerror", (error) => faults.push(error.message));
    await page.setContent("<main></main>");
    const given = { esm: widget(), html: readFileSync(PAGE, "utf8"), file: readFileSync(join(GOLDEN, "xml/t4_rf_rb_tf_tb.xml")).toString("base64") };
    await page.evaluate(async ({ esm, html, file }) => {
        const bytes = Uint8Array.from(atob(file), (c) => c.charCodeAt(0));
        const values = { _page: html, _files: [["four.xml", new DataView(bytes.buffer)]], state: "incident=40,30", height: 500 };
        const listeners = {};
        window.model = {
            get: (name) => values[name],
            set: (name, value) => { values[name] = value; },
            save_changes: () => {},
            on: (name, f) => { listeners[name] = f; },
            off: () => {},
            change: (name, value) => { values[name] = value; listeners[`change:${name}`](); },
        };
        const { default: { render } } = await import(URL.createObjectURL(new Blob([esm], { type: "text/javascript" })));
        render({ model: window.model, el: document.querySelector("main") });
    }, given);
    const frame = page.frameLocator("iframe");
    await frame.locator(".file h2", { hasText: "four.xml" }).waitFor();
    await frame.locator(".readout", { hasText: /reflectance, transmittance [\d.]/ }).waitFor();
    // Set from outside, and by hand.
    await page.evaluate(() => window.model.change("state", "incident=60,90"));
    const state = () => page.evaluate(() => window.model.get("state"));
    await frame.locator("body[aria-busy=false]").waitFor();
    assert.match(await state(), /incident=60,90/);
    await frame.locator("header h1").click();
    await page.keyboard.press("ArrowLeft");
    await page.waitForFunction(() => window.model.get("state").includes("incident=60,91"), null, { timeout: 60_000 });
    assert.deepEqual(faults, []);
    await page.close();
});
