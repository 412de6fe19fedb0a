// The numbers that the page shows are those of Radiance's library.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { basename, join } from "node:path";
import { after, before, test } from "node:test";
import { GOLDEN, degrees, drop, launch, link, value, viewer } from "./browser.mjs";

// The reference moves what it looks up by up to 3e-4.
const TOLERANCE = 4e-4;

let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

const json = (name) => JSON.parse(readFileSync(join(GOLDEN, name), "utf8"));
const file = (path) => ({ name: basename(path), bytes: readFileSync(join(GOLDEN, path)) });
// Mirror and straight-through directions lie on the border between leaves: an angle's rounding decides between them.
const onBorder = (wi, wo) => Math.hypot(wi[0] + wo[0], wi[1] + wo[1]) < 1e-9;
const pairs = (wi, wo) => `incident=${degrees(wi).join()}&pinned=${degrees(wo).join()}`;

for (const name of ["tree4_rf_rb_tf_tb", "tree4_tf", "tree3_rf_rb_tf_tb"]) {
    test(`${name}: f of every golden pair`, async () => {
        const golden = json(`${name}.json`);
        const { page, faults, close } = await viewer(browser);
        await drop(page, [file(golden.file)]);
        await page.waitForSelector(".file");
        let compared = 0;
        for (const query of golden.eval.filter((query) => !onBorder(query.in, query.out))) {
            await link(page, pairs(query.in, query.out));
            const [found, expected] = [await value(page), query.eval[2]];
            assert.ok(Math.abs(found - expected) <= TOLERANCE * expected, `${query.in} ${query.out}: ${found}, not ${expected}`);
            compared += 1;
        }
        assert.ok(compared >= 8, `${compared} pairs`);
        assert.deepEqual(faults, []);
        await close();
    });
}
