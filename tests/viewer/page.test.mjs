// The page as a person uses it: files, mouse, keys, links.
import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, readdirSync, rmSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { after, before, test } from "node:test";
import { GOLDEN, PAGE, degrees, drop, launch, link, rest, value, viewer } from "./browser.mjs";

let browser;
before(async () => (browser = await launch()));
after(() => browser.close());

const golden = (name) => ({ name: basename(name), bytes: readFileSync(join(GOLDEN, name)) });
const TREE = golden("xml/t4_rf_rb_tf_tb.xml");
const files = (page) => page.locator(".file h2").allTextContents();
const message = (page) => page.locator(".messages p span").allTextContents();
const incident = async (page) => (await page.locator(".controls input[type=number]").evaluateAll((all) => all.map((e) => e.valueAsNumber)));

/// Disks of the map in the window: { x, y, radius, side }.
async function disks(page) {
    const box = await page.locator(".map canvas").boundingBox();
    const told = await page.locator(".map canvas").getAttribute("data-disks");
    return told.split(";").map((disk) => {
        const [x, y, radius, side] = disk.split(",");
        return { x: box.x + Number(x), y: box.y + Number(y), radius: Number(radius), side };
    });
}

test("needs nobody: opened from the disk it asks for nothing else", async () => {
    const { page, faults, requests, close } = await viewer(browser);
    await drop(page, [TREE]);
    await page.waitForSelector(".file");
    await rest(page);
    assert.deepEqual(requests.filter((url) => !url.startsWith("file:") && !url.startsWith("data:")), []);
    assert.equal(requests.filter((url) => url.startsWith("file:")).length, 1);
    assert.deepEqual(faults, []);
    await close();
});

test("hovering over the map shows the golden number and both directions", async () => {
    const { page, faults, close } = await viewer(browser);
    await drop(page, [TREE]);
    const data = JSON.parse(readFileSync(join(GOLDEN, "tree4_rf_rb_tf_tb.json"), "utf8"));
    let compared = 0;
    for (const { in: wi, out: wo, eval: [, , expected] } of data.eval) {
        if (Math.hypot(wi[0] + wo[0], wi[1] + wo[1]) < 1e-9) continue;
        const reflected = wi[2] > 0 === wo[2] > 0;
        await link(page, `incident=${degrees(wi).join()}${reflected ? "" : "&map=transmission"}`);
        await rest(page);
        const [{ x, y, radius, side }] = await disks(page);
        assert.equal(side, wo[2] > 0 ? "front" : "back");
        await page.mouse.move(x + radius * wo[0], y - radius * wo[1]);
        await rest(page);
        const text = await page.locator(".readout").textContent();
        // A pixel of the window is some third of a degree: near the border of a leaf it may lie beyond.
        const found = await value(page);
        compared += Math.abs(found - expected) <= 4e-4 * expected ? 1 : 0;
        const [theta] = degrees(wo);
        const shown = Number(/scattered θ ([\d.]+)°/.exec(text)[1]);
        assert.ok(Math.abs(shown - theta) < 1.5 || Math.abs(theta - 90) < 12, `${text}: not ${theta}`);
        assert.match(text, /incident θ [\d.]+° φ [\d.]+°/);
        assert.match(text, /f [\d.e−]+ 1\/sr/);
    }
    assert.ok(compared >= 8, `${compared} golden numbers`);
    assert.deepEqual(faults, []);
    await close();
});

test("a peak of no width is marked where it stands, with its share of the light", async (t) => {
    const bsdf = process.env.BSDF;
    if (!bsdf || !existsSync(bsdf)) return t.skip("BSDF names no command");
    const folder = mkdtempSync(join(tmpdir(), "bsdf-peak-"));
    const run = (...words) => {
        const { status, stdout, stderr } = spawnSync(bsdf, words, { encoding: "utf8" });
        assert.equal(status, 0, stderr);
        return stdout;
    };
    const glass = join(folder, "glass.xml");
    run("simulate", "clear-glass", "--sweeps", "12", "--points-per-sweep", "60", "--spiral-points", "300", "-o", join(folder, "measured"));
    run("fit", join(folder, "measured"), "--aperture", "1", "--to", "klems-full", "-o", glass);
    const { page, faults, close } = await viewer(browser, { hash: "incident=40,30&map=transmission" });
    await drop(page, [{ name: "glass.xml", bytes: readFileSync(glass) }]);
    await page.waitForSelector(".file");
    await rest(page);
    const text = await page.locator(".readout").textContent();
    const [, share, theta, phi] = /in a peak of no width ([\d.]+) to θ ([\d.]+)° φ ([\d.]+)°/.exec(text) ?? assert.fail(text);
    // The table of `simulate`: .85 at the normal, with Fresnel's fall.
    assert.ok(Math.abs(Number(share) - 0.83) < 0.02, text);
    assert.ok(Math.abs(Number(theta) - 140) < 0.1 && Math.abs(Number(phi) - 210) < 0.1, text);
    const [{ x, y, radius, side }] = await disks(page);
    assert.equal(side, "back");
    // A white diamond with a black border, and nothing of the kind where the light does not go.
    const sin = Math.sin((40 * Math.PI) / 180);
    const white = (turn) => page.locator(".map canvas").evaluate((canvas, [px, py]) => {
        const box = canvas.getBoundingClientRect();
        const scale = canvas.width / box.width;
        const pixel = canvas.getContext("2d").getImageData((px - box.left) * scale, (py - box.top) * scale, 1, 1).data;
        return Math.min(...pixel.slice(0, 3));
    }, [x + radius * sin * Math.cos(turn * Math.PI / 180), y - radius * sin * Math.sin(turn * Math.PI / 180)]);
    assert.equal(await white(210), 255);
    assert.notEqual(await white(120), 255);
    assert.deepEqual(faults, []);
    await close();
    rmSync(folder, { recursive: true });
});

test("dragging the light on the map moves it, and the link says so", async () => {
    const { page, faults, close } = await viewer(browser, { hash: "incident=30,0" });
    await drop(page, [TREE]);
    await page.waitForSelector(".file");
    await rest(page);
    const [{ x, y, radius }] = await disks(page);
    await page.mouse.move(x + 0.5 * radius, y);
    await page.mouse.down();
    await page.mouse.move(x + 0.3 * radius, y - 0.3 * radius, { steps: 4 });
    await page.mouse.move(x, y - Math.sin(Math.PI / 4) * radius, { steps: 4 });
    await page.mouse.up();
    await rest(page);
    const [theta, phi] = await incident(page);
    assert.ok(Math.abs(theta - 45) < 1 && Math.abs(phi - 90) < 1, `${theta}, ${phi}`);
    const said = /incident=([\d.]+),([\d.]+)/.exec(page.url());
    assert.ok(Math.abs(said[1] - theta) < 0.01 && Math.abs(said[2] - phi) < 0.01, page.url());
    assert.deepEqual(faults, []);
    await close();
});

test("dragging the light in three dimensions moves it over the hemisphere, and to the back", async () => {
    const { page, faults, close } = await viewer(browser, { hash: "incident=30,0" });
    await drop(page, [TREE]);
    await rest(page);
    const place = async () => {
        const box = await page.locator(".lobe canvas").boundingBox();
        const [x, y] = (await page.locator(".lobe canvas").getAttribute("data-light")).split(",").map(Number);
        return [box.x + x, box.y + y];
    };
    const [x, y] = await place();
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x - 40, y + 10, { steps: 4 });
    await page.waitForFunction(() => document.querySelector(".controls input[type=number]").valueAsNumber !== 30);
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    const moved = await incident(page);
    assert.ok(Math.hypot(moved[0] - 30, moved[1]) > 5, `${moved}`);
    const [nx, ny] = await place();
    assert.ok(Math.hypot(nx - x + 40, ny - y - 10) < 3, "the light is where the pointer is");
    await page.mouse.move(x - 40, y + 290, { steps: 6 });
    await page.mouse.up();
    await rest(page);
    const [theta] = await incident(page);
    assert.ok(theta > 90, `from the back, not ${theta}`);
    assert.deepEqual(faults, []);
    await close();
});

test("panels follow one another: a slice hovered is a number, a click keeps the direction", async () => {
    const { page, close } = await viewer(browser);
    await drop(page, [TREE]);
    await rest(page);
    const box = await page.locator(".slice canvas").boundingBox();
    await page.mouse.move(box.x + box.width / 2 + 20, box.y + box.height / 2 - 40);
    await page.waitForSelector(".readout .value");
    await page.mouse.down();
    await page.mouse.up();
    await page.mouse.move(5, 5);
    await rest(page);
    assert.match(await page.locator(".readout").textContent(), /scattered \(kept\) θ/);
    assert.match(page.url(), /pinned=/);
    await page.keyboard.press("Escape");
    await rest(page);
    assert.doesNotMatch(page.url(), /pinned=/);
    await close();
});

test("keys do what the list says", async () => {
    const { page, faults, close } = await viewer(browser, { hash: "incident=30,10" });
    await drop(page, [TREE]);
    await rest(page);
    const now = async () => (await rest(page), new URLSearchParams(new URL(page.url()).hash.slice(1)));
    await page.keyboard.press("ArrowDown");
    assert.equal((await now()).get("incident"), "31,10");
    await page.keyboard.press("Shift+ArrowRight");
    assert.equal((await now()).get("incident"), "31,0");
    for (const [key, name, expected] of [
        ["l", "log", "false"], ["+", "exposure", "0.5"], ["]", "decades", "4"], ["c", "colours", "cividis"],
        ["g", "cells", "true"], ["s", "smooth", "true"], ["m", "map", "transmission"], ["o", "shape", "drape"], ["b", "incident", "149,0"],
    ]) {
        await page.keyboard.press(key);
        assert.equal((await now()).get(name), expected, key);
    }
    await page.keyboard.press("?");
    assert.ok(await page.locator("dialog").isVisible());
    assert.deepEqual(faults, []);
    await close();
});

test("two files are compared", async () => {
    const { page, faults, close } = await viewer(browser, { hash: "incident=30,10&pinned=30,190" });
    await drop(page, [golden("xml/t4_rf_rb_tf_tb.xml"), golden("xml/t3_rf_rb_tf_tb.xml")]);
    await rest(page);
    assert.equal(await page.locator(".readout .value").count(), 2);
    const both = [await value(page, 0), await value(page, 1)];
    assert.equal((await disks(page)).length, 2);
    await link(page, "incident=30,10&pinned=30,190&compare=difference");
    assert.equal((await disks(page)).length, 1);
    await page.locator(".file button").first().click();
    await rest(page);
    assert.equal(await value(page), both[1]);
    assert.deepEqual(faults, []);
    await close();
});

test("rubbish gives a message that names the file, and what was shown stays", async () => {
    const { page, faults, close } = await viewer(browser);
    await drop(page, [TREE]);
    await page.waitForSelector(".file");
    const rubbish = [["empty.xml", ""], ["noise.bin", "\0\x01\x02\xff".repeat(99)], ["page.html", "<html><body>hello</body></html>"], ["note.txt", "dear reader"]];
    for (const [name, text] of rubbish) {
        await drop(page, [{ name, bytes: Buffer.from(text, "latin1") }]);
        await page.waitForFunction((name) => document.querySelector(".messages").textContent.includes(name), name);
    }
    const said = await message(page);
    assert.equal(said.length, rubbish.length);
    for (const text of said) assert.ok(text.length > 25 && text.length < 600 && !/panic|unreachable|undefined|wasm/i.test(text), text);
    assert.deepEqual(await files(page), ["t4_rf_rb_tf_tb.xml×"]);
    assert.deepEqual(faults, []);
    await close();
});

test("every damaged file is shown or refused in words", async () => {
    const { page, faults, close } = await viewer(browser);
    const folder = join(GOLDEN, "badxml");
    let refused = 0;
    for (const name of readdirSync(folder).filter((n) => n.endsWith(".xml"))) {
        const before = (await message(page)).length;
        await drop(page, [{ name, bytes: readFileSync(join(folder, name)) }]);
        await page.waitForFunction(([name, before]) =>
            [...document.querySelectorAll(".file h2")].some((h) => h.textContent.includes(name)) ||
            document.querySelectorAll(".messages p").length > before, [name, before]);
        refused += (await message(page)).length > before ? 1 : 0;
        await page.evaluate(() => document.querySelectorAll(".file button").forEach((b) => b.click()));
    }
    assert.ok(refused > 5, `${refused} refused`);
    assert.deepEqual(faults, []);
    await close();
});

test("a script in a sample's name is shown as text", async () => {
    const { page, faults, close } = await viewer(browser);
    await page.evaluate(() => (window.alert = () => (window.harmed = true)));
    const hostile = `<img src=x onerror="alert(1)"><script>alert(2)</script>`;
    const escaped = hostile.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");
    const source = readFileSync(join(GOLDEN, "xml/t4_rf_rb_tf_tb.xml"), "utf8");
    const xml = source.replace(/<Name>[^<]*<\/Name>/, `<Name>${escaped}</Name>`);
    assert.notEqual(xml, source);
    await drop(page, [{ name: `${hostile}.xml`, bytes: Buffer.from(xml) }]);
    await page.waitForSelector(".file");
    await rest(page);
    assert.ok((await page.locator(".file").textContent()).includes(hostile));
    assert.equal(await page.locator(".file img, .file script").count(), 0);
    await drop(page, [{ name: `${hostile}.txt`, bytes: Buffer.from("rubbish") }]);
    await page.waitForSelector(".messages p");
    assert.equal(await page.locator(".messages img, .messages script").count(), 0);
    await link(page, `open=${encodeURIComponent(hostile)}&colours=${encodeURIComponent(hostile)}&incident=x,y`);
    await rest(page);
    assert.equal(await page.evaluate(() => window.harmed), undefined);
    assert.deepEqual(faults, []);
    await close();
});

test("a link shows the same to others, with files beside the page on any web host", async () => {
    const served = { "/viewer.html": readFileSync(PAGE), "/fabrics/t4%20a.xml": TREE.bytes };
    const server = createServer((request, response) => {
        const body = served[request.url.split("?")[0]];
        response.writeHead(body ? 200 : 404, { "content-type": request.url.endsWith("html") ? "text/html" : "application/xml" });
        response.end(body ?? "none");
    });
    await new Promise((ready) => server.listen(0, "127.0.0.1", ready));
    const host = `http://127.0.0.1:${server.address().port}`;
    const page = await browser.newPage();
    const hash = "#open=fabrics/t4%20a.xml&incident=40,30&pinned=40,200&log=false&exposure=1&colours=cividis&cells=true&shape=plane";
    await page.goto(`${host}/viewer.html${hash}`);
    await page.waitForSelector(".file");
    await rest(page);
    assert.deepEqual(await files(page), ["t4 a.xml×"]);
    assert.match(await page.locator(".readout").textContent(), /θ 40\.0° φ 200\.0°/);
    const seen = await value(page);
    await page.keyboard.press("ArrowUp");
    await rest(page);
    const copied = page.url();
    assert.match(copied, /open=fabrics\/t4(%20|\+)a\.xml/);
    const other = await browser.newPage();
    await other.goto(copied.replace("incident=39,30", "incident=40,30"));
    await other.waitForSelector(".file");
    await rest(other);
    assert.equal(await value(other), seen);
    // Nobody else's files, whatever a link says.
    await other.goto("about:blank");
    await other.goto(`${host}/viewer.html#open=${encodeURIComponent("http://example.invalid/x.xml")}&open=missing.xml`);
    await other.waitForFunction(() => document.querySelectorAll(".messages p").length === 2);
    const said = await message(other);
    assert.match(said[0], /expected an address beside this page/);
    assert.match(said[1], /404/);
    await page.close();
    await other.close();
    server.close();
});

test("an object that is black all over says why", async () => {
    const { page, faults, close } = await viewer(browser, { hash: "incident=30,0" });
    await drop(page, [golden("xml/diffuse_tf.xml")]);
    await page.waitForSelector(".file");
    const note = page.locator(".lit .dark");
    // Nothing is reflected, and no light from behind gets through a sphere; it does through the others.
    for (const [shape, theta, words] of [
        ["sphere", 30, /drape and plane/], ["drape", 150, null], ["plane", 30, /light the other side/], ["plane", 150, null], ["sphere", 150, /drape and plane/],
    ]) {
        await link(page, `incident=${theta},90&shape=${shape}`);
        await rest(page);
        if (words === null) await note.waitFor({ state: "hidden" });
        else await note.filter({ hasText: words }).waitFor({ state: "visible" });
    }
    assert.deepEqual(faults, []);
    await close();
});

test("fits a phone", async () => {
    const { page, faults, close } = await viewer(browser, { size: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 });
    await drop(page, [TREE]);
    await rest(page);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing sticks out");
    for (const panel of [".lobe", ".map", ".slice", ".lit"]) {
        const box = await page.locator(panel).boundingBox();
        assert.ok(box.width > 300 && box.height > 250, `${panel}: ${box.width} × ${box.height}`);
    }
    await page.locator(".map canvas").scrollIntoViewIfNeeded();
    const [{ x, y }] = await disks(page);
    await page.touchscreen.tap(x + 20, y + 20);
    await page.waitForSelector(".readout .value");
    assert.deepEqual(faults, []);
    await close();
});

test("real files open by drop, or the reader's own words say why not", async (t) => {
    const data = process.env.BSDFKIT_DATA;
    if (!data) return t.skip("BSDFKIT_DATA is unset");
    const folders = readdirSync(data).filter((name) => name.startsWith("xml"));
    const paths = folders.flatMap((folder) => readdirSync(join(data, folder)).map((name) => join(data, folder, name)));
    const xml = paths.filter((path) => /\.xml$/i.test(path));
    const { page, faults, close } = await viewer(browser);
    let opened = 0;
    for (const path of xml) {
        await drop(page, [{ name: basename(path), bytes: readFileSync(path) }]);
        await rest(page);
        const said = await message(page);
        if (said.length === 0) {
            assert.deepEqual(await files(page), [`${basename(path)}×`]);
            assert.match(await page.locator(".readout").textContent(), /reflectance, transmittance [\d.]/, basename(path));
            opened += 1;
        }
        if (process.env.BSDF) {
            const told = spawnSync(process.env.BSDF, ["info", path], { encoding: "utf8" });
            assert.equal(told.status === 0, said.length === 0, `${path}: ${told.stderr}${said}`);
            if (said.length > 0) assert.ok(told.stderr.includes(said[0].slice(basename(path).length)), `${told.stderr}: ${said}`);
        }
        await page.evaluate(() => document.querySelectorAll(".file button, .messages button").forEach((b) => b.click()));
    }
    // Nine hold no BSDF: definitions of bases, templates without data.
    assert.ok(opened >= 26, `${opened} of ${xml.length} files`);
    assert.deepEqual(faults, []);
    await close();
});

test("the command hands its files to the page", async (t) => {
    const bsdf = process.env.BSDF;
    if (!bsdf || !existsSync(bsdf)) return t.skip("BSDF names no command");
    const command = spawn(bsdf, ["view", "--no-browser", join(GOLDEN, "xml/t4_rf_rb_tf_tb.xml"), join(GOLDEN, "xml/kf_in_tf.xml")]);
    const printed = await new Promise((done) => command.stdout.once("data", (text) => done(String(text).trim())));
    const { page, requests, close } = await (async () => {
        const page = await browser.newPage();
        const requests = [];
        page.on("request", (request) => requests.push(request.url()));
        await page.goto(printed);
        return { page, requests, close: () => page.close() };
    })();
    await page.waitForFunction(() => document.querySelectorAll(".file").length === 2);
    assert.deepEqual(await files(page), ["A t4_rf_rb_tf_tb.xml×", "B kf_in_tf.xml×"]);
    const own = new URL(printed).origin;
    assert.deepEqual(requests.filter((url) => !url.startsWith(own) && !url.startsWith("data:")), []);
    await close();
    command.kill("SIGINT");
});

test("where frames come late the lobe has fewer pixels while the light moves, and all of them at rest", async () => {
    const { page, faults, close } = await viewer(browser, { hash: "incident=40,30" });
    await drop(page, [TREE]);
    await page.waitForSelector(".file");
    await rest(page);
    const shares = () => page.locator(".lobe canvas").evaluate((canvas) => canvas.width / canvas.clientWidth);
    assert.ok(Math.abs((await shares()) - 1) < 0.01);
    // A clock on which frames are `late` ms further apart than they are.
    const dragged = (late) => page.evaluate(async (late) => {
        const now = (window.clock ??= performance.now.bind(performance));
        let passed = 0;
        performance.now = () => now() + passed;
        const canvas = document.querySelector(".map canvas");
        const [x, y, radius] = canvas.dataset.disks.split(";")[0].split(",").map(Number);
        const box = canvas.getBoundingClientRect();
        canvas.setPointerCapture = () => {};
        const at = (type, k) => canvas.dispatchEvent(new PointerEvent(type, {
            pointerId: 1, bubbles: true, buttons: 1,
            clientX: box.left + x + 0.64 * radius * Math.cos(0.52 + 0.02 * k), clientY: box.top + y - 0.64 * radius * Math.sin(0.52 + 0.02 * k),
        }));
        at("pointerdown", 0);
        const lobe = document.querySelector(".lobe canvas");
        let least = 1;
        for (let k = 1; k <= 40; k++) {
            passed += late;
            at("pointermove", k);
            await new Promise(requestAnimationFrame);
            least = Math.min(least, lobe.width / lobe.clientWidth);
        }
        at("pointerup", 40);
        performance.now = now;
        return least;
    }, late);
    assert.ok((await dragged(30)) < 0.4);
    await rest(page);
    assert.ok(Math.abs((await shares()) - 1) < 0.01);
    assert.deepEqual(faults, []);
    await close();
});
