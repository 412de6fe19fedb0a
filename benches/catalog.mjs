// A catalogue of many made-up materials: how long building, searching and opening the page take.
//
//     BSDF=target/release/bsdf node benches/catalog.mjs [COUNT [FOLDER]]
//
// 2000 unless COUNT says otherwise; FOLDER keeps what is made, and a site that it has is not built again. Of ten materials six
// are Klems Full, two Klems Quarter that also transmit, two isotropic tensor trees of 4,096 leaves. Needs node and Chromium, and `npm ci` in tests/viewer.
import { spawnSync } from "node:child_process";
import { createReadStream, existsSync, mkdirSync, mkdtempSync, rmSync, statSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { cpus, loadavg, tmpdir } from "node:os";
import { extname, join, normalize } from "node:path";

const { chromium } = createRequire(new URL("../tests/viewer/package.json", import.meta.url))("playwright-core");

const COUNT = Number(process.argv[2] ?? 2000);
const BSDF = process.env.BSDF ?? "bsdf";
const kept = process.argv[3];
const folder = kept ?? mkdtempSync(join(tmpdir(), "bsdf-catalog-"));

// ---- materials ----

const FULL = { name: "LBNL/Klems Full", rings: [[0, 5, 1], [5, 15, 8], [15, 25, 16], [25, 35, 20], [35, 45, 24], [45, 55, 24], [55, 65, 24], [65, 75, 16], [75, 90, 12]] };
const QUARTER = { name: "LBNL/Klems Quarter", rings: [[0, 9, 1], [9, 27, 8], [27, 46, 12], [46, 66, 12], [66, 90, 8]] };

/// Numbers that look drawn by chance: the same in every run.
const share = (k, n) => ((k + 1) * [0.6180339887, 0.7548776662, 0.5698402910, 0.8191725134, 0.6710436067][n]) % 1;

/// Direction cosines of a basis's centres.
const centres = ({ rings }) => rings.flatMap(([low, high, count]) => Array.from({ length: count }, (_, k) => {
    const sin = low === 0 ? 0 : Math.sin(((low + high) / 2) * Math.PI / 180);
    return [sin * Math.cos(2 * Math.PI * k / count), sin * Math.sin(2 * Math.PI * k / count)];
}));

/// f of material k for incident and scattered direction cosines: diffuse and one peak, drawn out along an axis.
function lobe(k, transmits) {
    const diffuse = 0.05 + 0.5 * share(k, 0), peak = 0.35 * share(k, 1), along = 0.08 + 0.3 * share(k, 2), across = along * (0.4 + 0.6 * share(k, 3));
    const height = peak / (Math.PI * along * across), sign = transmits ? 0.5 : 1;
    return ([ix, iy], [ox, oy]) => sign * (diffuse / Math.PI + height * Math.exp(-(((ix + ox) / along) ** 2) - ((iy + oy) / across) ** 2));
}

const block = (direction, basis, data) => `<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit="Integral">Visible</Wavelength>
<WavelengthDataBlock><WavelengthDataDirection>${direction}</WavelengthDataDirection>${basis}<ScatteringDataType>BTDF</ScatteringDataType>
<ScatteringData>\n${data}\n</ScatteringData></WavelengthDataBlock></WavelengthData>`;

const file = (k, definition, blocks) => `<?xml version="1.0" encoding="UTF-8"?>
<WindowElement xmlns="http://windows.lbl.gov"><WindowElementType>System</WindowElementType><FileType>BSDF</FileType><Optical><Layer>
<Material><Name>Material ${k}</Name><Manufacturer>Maker ${k % 40}</Manufacturer></Material>
<DataDefinition>${definition}</DataDefinition>
${blocks.join("\n")}
</Layer></Optical></WindowElement>\n`;

function matrix(k, basis, directions) {
    const at = centres(basis);
    const columns = `<ColumnAngleBasis>${basis.name}</ColumnAngleBasis><RowAngleBasis>${basis.name}</RowAngleBasis>`;
    const rings = basis.rings.map(([low, high, count]) => `<AngleBasisBlock><Theta>${(low + high) / 2 * (low > 0)}</Theta><nPhis>${count}</nPhis>
<ThetaBounds><LowerTheta>${low}</LowerTheta><UpperTheta>${high}</UpperTheta></ThetaBounds></AngleBasisBlock>`);
    const definition = `<IncidentDataStructure>Columns</IncidentDataStructure><AngleBasis><AngleBasisName>${basis.name}</AngleBasisName>${rings.join("")}</AngleBasis>`;
    // Directions of travel: the mirror is on the diagonal.
    const data = directions.map((direction) => {
        const f = lobe(k, direction.startsWith("Transmission"));
        return block(direction, columns, at.map((o) => at.map((i) => f([-i[0], -i[1]], o).toPrecision(5)).join(", ")).join(",\n"));
    });
    return file(k, definition, data);
}

/// Rank 3: the incident polar angle along the first axis, 16 steps an axis.
function tree(k) {
    const f = lobe(k, false);
    const square = (v) => 2 * v - 1;
    const leaves = (levels, [x, y, z], width) => {
        if (levels === 0) return f([-square(x + width / 2), 0], [square(y + width / 2), square(z + width / 2)]).toPrecision(4);
        const half = width / 2;
        const below = Array.from({ length: 8 }, (_, n) => leaves(levels - 1, [x + (n & 1) * half, y + ((n >> 1) & 1) * half, z + (n >> 2) * half], half));
        return levels === 1 ? `{ ${below.join(" ")} }` : `{${below.join("\n")}}`;
    };
    const data = block("Reflection Front", "<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>", leaves(4, [0, 0, 0], 1));
    return file(k, "<IncidentDataStructure>TensorTree3</IncidentDataStructure>", [data]);
}

const CLASSES = ["metal", "fabric", "glazing", "paint", "film", "screen", "stone", "wood"];
const WORDS = ["brushed", "woven", "satin", "fritted", "pearl", "coated", "perforated", "cast", "rolled", "sanded"];

function write(at) {
    mkdirSync(at, { recursive: true });
    for (let k = 0; k < COUNT; k++) {
        const name = `${WORDS[k % 10]}-${CLASSES[k % 8]}-${k}`;
        const text = k % 10 < 6 ? matrix(k, FULL, ["Reflection Back"]) : k % 10 < 8 ? matrix(k, QUARTER, ["Reflection Back", "Transmission Back"]) : tree(k);
        writeFileSync(join(at, `${name}.xml`), text);
        writeFileSync(join(at, `${name}.toml`), `name = "${WORDS[k % 10]} ${CLASSES[k % 8]} ${k}"\nmaker = "Maker ${k % 40}"\nclass = "${CLASSES[k % 8]}"
instrument = "made up"\ndate = 2026-11-30\nlicence = "CC0-1.0"\nnotes = "Batch ${k % 97}, colour ${k % 13}."\n`);
    }
}

// ---- measuring ----

/// Runs the command: wall-clock time, and the processors' time whatever else the machine does.
function bsdf(...words) {
    const start = performance.now();
    const { status, stderr, stdout, error } = spawnSync("bash", ["-c", '"$@" && times', "bash", BSDF, ...words], { encoding: "utf8", maxBuffer: 1 << 28 });
    if (status !== 0) throw error ?? new Error(`bsdf ${words.join(" ")}: ${stderr}`);
    const ms = performance.now() - start;
    const lines = stdout.trimEnd().split("\n");
    const seconds = [...lines.at(-1).matchAll(/(\d+)m([\d.]+)s/g)].map(([, m, s]) => 60 * m + Number(s));
    return { ms, cpu: 1000 * (seconds[0] + seconds[1]), stdout: lines.slice(0, -2).join("\n") };
}

/// Times of several runs: `ms` by the clock, `cpu` of processors.
function say(name, runs) {
    const of = (key) => runs.map((run) => run[key]).toSorted((a, b) => a - b);
    const middle = (times) => times[Math.floor(times.length / 2)].toFixed(0);
    const ms = of("ms");
    const more = ms.length > 1 ? `, longest ${ms.at(-1).toFixed(0)}, of ${ms.length}` : "";
    console.log(`${name}: ${middle(ms)} ms${more}${runs[0].cpu === undefined ? "" : `; processors ${middle(of("cpu"))} ms`}`);
}

const TYPES = { ".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".json": "application/json", ".png": "image/png" };

function serve(root) {
    const server = createServer((request, response) => {
        const path = normalize(decodeURIComponent(new URL(request.url, "http://localhost").pathname));
        const stream = createReadStream(join(root, path === "/" ? "index.html" : path));
        stream.on("error", () => response.writeHead(404).end());
        stream.on("open", () => response.writeHead(200, { "content-type": TYPES[extname(path) || ".html"] ?? "application/octet-stream" }));
        stream.pipe(response);
    });
    return new Promise((done) => server.listen(0, "127.0.0.1", () => done(server)));
}

/// Loaded: its load event is over and all pictures in view are drawn.
async function opened(browser, address) {
    const context = await browser.newContext({ viewport: { width: 1280, height: 820 } });
    const page = await context.newPage();
    const session = await context.newCDPSession(page);
    await session.send("Performance.enable", { timeDomain: "threadTicks" });
    await page.goto(address, { waitUntil: "load" });
    const told = await page.evaluate(async () => {
        // Of cards: asking where a picture is would lay out every card that nobody sees.
        const shown = [...document.querySelectorAll("#cards > li")].filter((card) => card.getBoundingClientRect().top < innerHeight);
        await Promise.all(shown.map((card) => card.querySelector("img").decode().catch(() => {})));
        await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
        const whole = performance.now();
        const paint = performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? NaN;
        return { whole, paint, load: performance.getEntriesByType("navigation")[0].loadEventEnd };
    });
    const { metrics } = await session.send("Performance.getMetrics");
    told.busy = 1000 * metrics.find((m) => m.name === "TaskDuration").value;
    return { page, context, told };
}

/// From a letter typed to the frame in which the cards show what it found.
const typed = (page, words) => page.evaluate(async (words) => {
    const field = document.querySelector("#filters [name=words]");
    const times = [];
    for (const word of words) {
        const start = performance.now();
        field.value = word;
        field.dispatchEvent(new InputEvent("input", { bubbles: true }));
        await new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
        times.push({ ms: performance.now() - start });
    }
    return times;
}, words);

const materials = join(folder, "materials"), site = join(folder, "site");
console.log(`${COUNT} materials; ${cpus().length} processors, load ${loadavg()[0].toFixed(1)}`);
if (!existsSync(join(site, "index.html"))) {
    write(materials);
    const first = bsdf("catalog", "build", materials, "-o", site);
    console.log(first.stdout);
    say("build", [first]);
    say("build again, nothing changed", [bsdf("catalog", "build", materials, "-o", site)]);
}
bsdf("catalog", "search", "--in", materials, "first");
const search = (...words) => bsdf("catalog", "search", "--in", materials, ...words);
const names = ["satin", "maker:maker", "class:glazing", "fritted glazing", "colour 7", "no-such-word"];
say("search by words", names.flatMap((words) => [search(...words.split(" ")), search(...words.split(" "))]));
const like = [0, 1, 6, 8, 9].filter((k) => k < COUNT).map((k) => join(materials, `${WORDS[k % 10]}-${CLASSES[k % 8]}-${k}.xml`));
say("search by look", like.flatMap((path) => [search("--like", path), search("--like", path)]));

const index = statSync(join(site, "index.html")).size;
const server = await serve(site);
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu"] });
const times = { whole: [], paint: [], load: [], busy: [] };
for (let k = 0; k < 5; k++) {
    const { page, context, told } = await opened(browser, `http://127.0.0.1:${server.address().port}/`);
    for (const [name, ms] of Object.entries(told)) times[name].push({ ms });
    if (k === 4) {
        say("a letter typed until the cards are shown", await typed(page, ["s", "sa", "sat", "satin", "satin m", "satin metal", ""]));
        if (kept) await page.screenshot({ path: join(folder, "index.png") });
    }
    await context.close();
}
console.log(`index.html ${(index / 1e6).toFixed(2)} MB`);
say("page: first paint", times.paint);
say("page: load event", times.load);
say("page: all pictures in view drawn", times.whole);
say("page: processor time of its thread", times.busy);
await browser.close();
server.close();
if (!kept) rmSync(folder, { recursive: true });
