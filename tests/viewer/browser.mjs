// A browser with the viewer in it, for tests.
import { existsSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const here = dirname(fileURLToPath(import.meta.url));
export const ROOT = resolve(here, "../..");
export const GOLDEN = join(ROOT, "tests/golden");
export const PAGE = process.env.BSDFKIT_VIEWER ?? join(ROOT, "crates/viewer/page/viewer.html");

const CHROMIUM = process.env.CHROMIUM ?? "/usr/bin/chromium";
// Nothing but the page under test is asked for anything; WebGL is drawn by software.
const FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--enable-unsafe-swiftshader",
];

if (!existsSync(PAGE)) throw new Error(`${PAGE} is missing: \`make viewer\` builds it`);

export const launch = () => chromium.launch({ executablePath: CHROMIUM, args: FLAGS });

/// The viewer opened from the disk. `faults` gathers what the page throws, `requests` what it asks of anybody.
export async function viewer(browser, { hash = "", size = { width: 1280, height: 820 }, ...options } = {}) {
    const context = await browser.newContext({ viewport: size, ...options });
    const page = await context.newPage();
    const faults = [];
    const requests = [];
    page.on("pageerror", (error) => faults.push(error.message));
    page.on("request", (request) => requests.push(request.url()));
    await page.goto(`${pathToFileURL(PAGE)}${hash ? `#${hash}` : ""}`);
    await page.waitForSelector("header");
    return { page, faults, requests, close: () => context.close() };
}

/// Files dropped on the page, as by a person: [{ name, bytes }].
export async function drop(page, files) {
    const given = files.map(({ name, bytes }) => ({ name, base64: Buffer.from(bytes).toString("base64") }));
    await page.evaluate((given) => {
        const transfer = new DataTransfer();
        for (const { name, base64 } of given) {
            transfer.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name));
        }
        for (const type of ["dragenter", "dragover", "drop"]) {
            document.body.dispatchEvent(new DragEvent(type, { bubbles: true, cancelable: true, dataTransfer: transfer }));
        }
    }, given);
}

/// Unit vector → (θ, φ) in degrees.
export const degrees = ([x, y, z]) => [Math.atan2(Math.hypot(x, y), z), Math.atan2(y, x)].map((a) => (a * 180) / Math.PI);

/// f of the readout, with all its digits.
export const value = (page, n = 0) =>
    page.locator(".readout .value").nth(n).evaluate((e) => Number(e.dataset.value));

/// Sets the state by the page's link.
export async function link(page, hash) {
    await page.evaluate((hash) => {
        location.hash = hash;
        return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
    }, hash);
}

/// Once the page is at rest: all is loaded, drawn as finely as it will be, and in the address.
export const rest = (page) => page.waitForFunction(() => document.body.getAttribute("aria-busy") === "false");
