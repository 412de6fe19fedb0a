// How long a frame takes while the light is dragged: node frames.mjs [FILE...] (not a test). Without a file, a tensor tree
// of 16^5 leaves, 1,048,576, with a peak along the diagonal.
//
// Prints the time that a frame's work takes in the page (numbers, drawing, the commands of WebGL), the time from frame to
// frame, which has the drawing itself in it: here by software; and, whatever else the machine does, the processors' time a frame.
import { readFileSync } from "node:fs";
import { basename, join } from "node:path";
import { GOLDEN, drop, launch, rest, viewer } from "./browser.mjs";

const STEPS = 150;

/// Values of all leaves below a cell, in the order of the text: bit d of a child's number is the upper half of dimension d.
function leaves(levels, corner, width) {
    if (levels === 0) {
        const [ix, iy, ox, oy] = corner.map((c) => c + width / 2);
        return (0.05 + 20 * Math.exp(-((ix - ox) ** 2 + (iy - oy) ** 2) / 0.005)).toPrecision(4);
    }
    const half = width / 2;
    const children = Array.from({ length: 16 }, (_, n) => leaves(levels - 1, corner.map((c, d) => c + ((n >> d) & 1) * half), half));
    return levels === 1 ? `{ ${children.join(" ")} }` : `{${children.join("\n")}}`;
}

function tree() {
    const golden = readFileSync(join(GOLDEN, "xml/t4_grid16.xml"), "utf8");
    const xml = golden.replace("Reflection Back", "Reflection Front")
        .replace(/(<ScatteringData>)[^<]*/, (_, tag) => `${tag}\n${leaves(5, [0, 0, 0, 0], 1)}\n`);
    return { name: "million.xml", bytes: Buffer.from(xml) };
}

const given = process.argv.slice(2).map((path) => ({ name: basename(path), bytes: readFileSync(path) }));
const browser = await launch();
const { page, close } = await viewer(browser, { hash: "incident=40,30" });
await drop(page, given.length > 0 ? given : [tree()]);
await page.waitForFunction(() => /reflectance, transmittance [\d.]/.test(document.querySelector(".readout").textContent), null, { timeout: 120_000 });
await rest(page);
const session = await browser.newBrowserCDPSession();
const used = async () => {
    const { processInfo } = await session.send("SystemInfo.getProcessInfo");
    const of = (type) => processInfo.filter((p) => p.type === type).reduce((sum, p) => sum + p.cpuTime, 0);
    return { page: of("renderer"), drawing: of("GPU") };
};
const earlier = await used();
const told = await page.evaluate(async (steps) => {
    const canvas = document.querySelector(".map canvas");
    const [x, y, radius] = canvas.dataset.disks.split(";")[0].split(",").map(Number);
    const box = canvas.getBoundingClientRect();
    const at = (type, k) => {
        const turn = (k / steps) * 2 * Math.PI + 0.52;
        const r = Math.sin((40 * Math.PI) / 180) * radius * (1 + 0.4 * Math.sin(3 * (turn - 0.52)));
        canvas.dispatchEvent(new PointerEvent(type, {
            pointerId: 1, bubbles: true, buttons: 1, clientX: box.left + x + r * Math.cos(turn), clientY: box.top + y - r * Math.sin(turn),
        }));
    };
    canvas.setPointerCapture = () => {};
    performance.clearMeasures();
    at("pointerdown", 0);
    const times = [];
    for (let k = 1; k <= steps; k++) {
        at("pointermove", k);
        times.push(await new Promise(requestAnimationFrame));
    }
    at("pointerup", steps);
    const work = performance.getEntriesByName("frame").map((entry) => entry.duration);
    return { work, gaps: times.slice(1).map((time, k) => time - times[k]), parts: Object.fromEntries(["numbers"].map((name) => [name, performance.getEntriesByName(name).map((e) => e.duration)])) };
}, STEPS);
const say = (name, times) => {
    const sorted = times.toSorted((a, b) => a - b);
    const at = (share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))].toFixed(1);
    console.log(`${name}: a tenth within ${at(0.1)} ms, median ${at(0.5)} ms, 95 % within ${at(0.95)} ms, of ${times.length}`);
};
console.log((await page.locator(".file p").allTextContents()).join("; "));
say("work of a frame", told.work);
for (const [name, times] of Object.entries(told.parts)) if (times.length > 0) say(`  ${name}`, times);
say("from frame to frame", told.gaps);
const later = await used();
const each = (name) => ((1000 * (later[name] - earlier[name])) / STEPS).toFixed(1);
console.log(`processors' time a frame: the page ${each("page")} ms, drawing by software ${each("drawing")} ms`);
await close();
await browser.close();
