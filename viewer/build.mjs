// One page that holds everything: script, style and WebAssembly. It opens from a disk and sends nothing anywhere.
//
// node build.mjs WEB OUT: the folder that wasm-bindgen wrote, the page to write.
import { createHash } from "node:crypto";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import * as esbuild from "esbuild";

// What a page that is to open at once on a slow line may take.
const MOST_BYTES = 3_000_000;

const here = dirname(fileURLToPath(import.meta.url));
const [web, out] = process.argv.slice(2).map((path) => resolve(path));
if (!web || !out) {
    console.error("usage: node build.mjs WEB OUT.html");
    process.exit(2);
}

async function bundle(entry) {
    const built = await esbuild.build({
        entryPoints: [join(here, "src", entry)],
        alias: { "bsdfkit-web": join(web, "bsdfkit_web.js") },
        nodePaths: [join(here, "node_modules")],
        absWorkingDir: here,
        bundle: true,
        minify: true,
        write: false,
        format: "esm",
        target: ["chrome111", "firefox113", "safari16.4"],
        legalComments: "none",
        logLevel: "warning",
    });
    return built.outputFiles[0].text;
}

// Of a text inside an element `script` or `style`, this alone could end it.
const inside = (text) => text.replaceAll("</", "<\\/");
const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

const script = inside(await bundle("main.ts"));
const style = await bundle("style.css");
const core = gzipSync(readFileSync(join(web, "bsdfkit_web_bg.wasm")), { level: 9 }).toString("base64");
// Nothing but this script runs, nothing is loaded or sent but from and to where the page is from.
const policy = [
    "default-src 'none'",
    `script-src ${hash(script)} 'wasm-unsafe-eval'`,
    `style-src ${hash(style)}`,
    "img-src data: blob:",
    "connect-src 'self'",
    "base-uri 'none'",
    "form-action 'none'",
].join("; ");
const parts = { policy, style, script, core };
const page = readFileSync(join(here, "src", "index.html"), "utf8").replace(
    /\{\{(\w+)\}\}/g,
    (_, name) => parts[name],
);
if (page.length > MOST_BYTES) {
    console.error(`${out}: expected a page of at most ${MOST_BYTES} bytes, found ${page.length}`);
    process.exit(1);
}
mkdirSync(dirname(out), { recursive: true });
writeFileSync(out, page);
console.log(`${out}: ${page.length} bytes (script ${script.length}, core ${core.length})`);
