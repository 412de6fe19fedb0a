// A catalogue's first page as a person uses it: what is typed and chosen, what is shown then.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { copyFileSync, mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { GOLDEN, launch } from "./browser.mjs";

const COUNT = 230;
const { BSDF } = process.env;
let browser, folder;
before(async () => {
    if (!BSDF) return;
    folder = mkdtempSync(join(tmpdir(), "bsdf-catalog-"));
    const materials = join(folder, "materials");
    mkdirSync(materials);
    for (let k = 0; k < COUNT; k++) {
        // Materials that are called as parts of the page are.
        const name = ["cards", "filters", "count"][k] ?? `m${String(k).padStart(3, "0")}`;
        copyFileSync(join(GOLDEN, "xml/diffuse_pure.xml"), join(materials, `${name}.xml`));
        writeFileSync(join(materials, `${name}.toml`), `name = "t${COUNT - k} <b>felt</b>"\nclass = "${k % 2 ? "odd" : "even"}"\n`);
    }
    const made = spawnSync(BSDF, ["catalog", "build", materials, "-o", join(folder, "site")], { encoding: "utf8" });
    assert.equal(made.status, 0, made.stderr);
    browser = await launch();
});
after(async () => {
    await browser?.close();
    if (folder) rmSync(folder, { recursive: true });
});

/// Titles of the cards that are seen.
const shown = (page) => page.evaluate(() => [...document.querySelectorAll(".cards > li")].filter((card) => card.checkVisibility()).map((card) => card.querySelector("h2").textContent));
const until = (page, count) => page.waitForFunction((count) => [...document.querySelectorAll(".cards > li")].filter((card) => card.checkVisibility()).length === count, count);

test("what is typed and chosen is what is shown, in order, and no card is lost", async (t) => {
    if (!BSDF) return t.skip("BSDF is unset");
    const page = await browser.newPage();
    const faults = [];
    page.on("pageerror", (error) => faults.push(error.message));
    await page.goto(pathToFileURL(join(folder, "site/index.html")).href);
    const all = await shown(page);
    assert.equal(all.length, COUNT);
    const words = page.locator("#filters [name=words]");
    await words.fill("t12 felt");
    const some = all.filter((name) => name.includes("t12"));
    await until(page, some.length);
    assert.deepEqual(await shown(page), some);
    assert.equal(await page.locator("#count").textContent(), `${some.length} of ${COUNT}`);
    await page.locator("#filters [name=class]").selectOption("odd");
    await until(page, some.filter((name) => (COUNT - parseInt(name.slice(1), 10)) % 2 === 1).length);
    await words.fill("no such word");
    await until(page, 0);
    // More than are put into the page at once, while those of before are still being taken out.
    await page.locator("#filters [name=class]").selectOption("");
    await words.fill("");
    await until(page, COUNT);
    assert.deepEqual(await shown(page), all);
    await page.locator("#filters [name=sort]").selectOption("name");
    await page.waitForFunction(() => document.querySelectorAll("ol.cards").length === 2);
    await until(page, COUNT);
    assert.deepEqual(await shown(page), all.toSorted(new Intl.Collator().compare));
    // However many copies there are, an id is one element's, and nothing of a name is markup.
    const ids = await page.evaluate(() => [...document.querySelectorAll("[id]")].map((e) => e.id));
    assert.equal(new Set(ids).size, ids.length);
    assert.equal(await page.locator(".cards b").count(), 0);
    assert.deepEqual(faults, []);
    // The address says what is shown.
    await words.fill("t12 felt");
    await until(page, some.length);
    await page.reload();
    await until(page, some.length);
    await page.close();
});
