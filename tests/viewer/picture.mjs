// The picture of the viewer in the documentation: node picture.mjs OUT.png BSDF FILE..., the command and what it is to show.
import { spawn } from "node:child_process";
import { launch, rest } from "./browser.mjs";

const [out, bsdf, ...files] = process.argv.slice(2);
const command = spawn(bsdf, ["view", "--no-browser", ...files], { stdio: ["ignore", "pipe", "inherit"] });
const link = await new Promise((done) => command.stdout.once("data", (text) => done(String(text).trim())));
const browser = await launch();
const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
await page.goto(`${link}&incident=45,180&pinned=43,0&cells=true`);
await page.waitForFunction(() => /reflectance, transmittance [\d.]/.test(document.querySelector(".readout").textContent));
await rest(page);
await page.waitForTimeout(3000);
await page.screenshot({ path: out });
await browser.close();
command.kill("SIGINT");
