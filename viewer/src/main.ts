// The page: files in, panels out.
import { type Angles, type Direction, type Side, angles, direction, load } from "./core.js";
import { Scale } from "./colours.js";
import { Controls } from "./controls.js";
import { element } from "./elements.js";
import { type Given, fetched, onDrop, read } from "./files.js";
import { KEYS, listen } from "./keyboard.js";
import type { Page } from "./page.js";
import { LobePanel } from "./panels/lobe.js";
import { MapPanel } from "./panels/map.js";
import { SectionPanel } from "./panels/section.js";
import { Readout } from "./readout.js";
import { type State, Store } from "./state.js";
import { Query, Subject } from "./subject.js";

/// Pixels along a side of the map, levels of the lobe: while something moves, and at rest.
const MOVING = { map: 128, lobe: 8 };
const RESTING = { map: 512, lobe: 11 };
/// After so long without a change the page shows all that it can, ms.
const REST = 120;
/// What decides about numbers; of the rest a new drawing is enough.
const COMPUTED: readonly (keyof State)[] = [
    "incident", "reflection", "transmission", "map", "parts", "channel", "band", "smooth", "equalAngles", "slice", "compare", "log", "decades", "exposure", "colours",
];

class Viewer implements Page {
    readonly #store = new Store();
    readonly #lobe = new LobePanel(this);
    readonly #map = new MapPanel(this);
    readonly #section = new SectionPanel(this);
    readonly #readout = new Readout();
    readonly #controls = new Controls(this.#store);
    readonly #files = element("div", { className: "files" });
    readonly #messages = element("div", { className: "messages" });
    #subjects: Subject[] = [];
    #query: Query;
    #hovered: Direction | null = null;
    #asked = 0;
    #stale = true;
    #resting = 0;
    #quality = RESTING;

    constructor(root: HTMLElement) {
        this.#query = new Query(this.state);
        this.#messages.setAttribute("role", "status");
        const choose = element("input", { type: "file", multiple: true, hidden: true });
        choose.addEventListener("change", () => {
            void this.#take([...(choose.files ?? [])].map(read));
            choose.value = "";
        });
        const open = element("button", { type: "button", textContent: "Open files…", onclick: () => choose.click() });
        const help = dialog();
        const keys = element("button", { type: "button", textContent: "Keys", onclick: () => help.showModal() });
        const copy = element("button", { type: "button", textContent: "Copy link", onclick: () => this.#copy() });
        root.replaceChildren(
            element("header", {}, element("h1", { textContent: "bsdfkit viewer" }), open, choose, copy, keys),
            element("aside", {}, this.#files, this.#controls.root),
            element("main", {}, this.#messages, this.#lobe.root, this.#map.root, this.#section.root),
            this.#readout.root,
            help,
        );
        this.#store.onChange((changed) => this.#changed(changed));
        listen(this.#store, () => help.showModal());
        onDrop((files) => void this.#take(files.map(read)));
        new ResizeObserver(() => this.redraw()).observe(root);
        this.#list();
        this.#draw();
    }

    get state(): State {
        return this.#store.get();
    }

    get wi(): Direction {
        return this.#query.wi;
    }

    /// Files that the link names.
    async openLinked(): Promise<void> {
        if (this.state.open.length > 0) await this.#take(this.state.open.map(fetched), true);
    }

    hover(wo: Direction | null): void {
        this.#hovered = wo;
        this.redraw();
    }

    pin(wo: Direction | null): void {
        this.#store.set({ pinned: wo && angles(wo) });
    }

    drag(incident: Angles): void {
        this.#store.set({ incident });
    }

    redraw(): void {
        this.#asked ||= requestAnimationFrame(() => this.#draw());
    }

    #changed(changed: ReadonlySet<keyof State>): void {
        if (COMPUTED.some((key) => changed.has(key))) {
            this.#stale = true;
            this.#quality = MOVING;
        }
        this.redraw();
    }

    /// Opens files, two at most at a time: A and B.
    async #take(given: Promise<Given>[], linked = false): Promise<void> {
        const opened: Subject[] = [];
        for (const pending of given) {
            try {
                const { name, bytes } = await pending;
                opened.push(new Subject(name, bytes));
            } catch (e) {
                this.#say(e instanceof Error ? e.message : String(e));
            }
        }
        if (opened.length === 0) return;
        const all = [...(opened.length > 1 ? [] : this.#subjects.slice(0, 1)), ...opened];
        if (all.length > 2) this.#say(`two files are shown at a time: ${all[0]!.name} and ${all[1]!.name}`);
        this.#subjects = all.slice(0, 2);
        if (!linked) this.#store.set({ open: [] });
        this.#settle();
        this.#list();
        this.#stale = true;
        this.redraw();
    }

    /// Turns to where the files have something to show, if the state does not.
    #settle(): void {
        const query = new Query(this.state);
        const sides: Side[] = ["front", "back"];
        if (query.sides(this.#subjects).length === 0) {
            const from = sides.find((a) => sides.some((b) => this.#subjects.some((s) => s.answers(a, b))));
            const [theta, phi] = this.state.incident;
            const flipped = from && (from === "front") !== theta < 90;
            this.#store.set({ reflection: true, transmission: true, incident: flipped ? [180 - theta, phi] : [theta, phi] });
        }
        const now = new Query(this.state);
        const shown = now.sides(this.#subjects);
        if (shown.length > 0 && !shown.includes(now.side(this.state.map))) {
            this.#store.set({ map: this.state.map === "reflection" ? "transmission" : "reflection" });
        }
        query.free();
        now.free();
    }

    #list(): void {
        const boxes = this.#subjects.map((subject, n) => box(subject, this.#subjects.length > 1 ? "AB"[n]! : "", () => {
            this.#subjects.splice(n, 1);
            this.#store.set({ open: [] });
            this.#list();
            this.#stale = true;
            this.redraw();
        }));
        const hint = element("p", { className: "hint" },
            "Drop a BSDF here: the XML of WINDOW and Radiance, a compiled BSDF, an interpolant, a Radiance interpolant. ",
            "A second one is compared with the first. Nothing is uploaded.");
        this.#files.replaceChildren(...boxes, ...(boxes.length < 2 ? [hint] : []));
        this.#controls.offer(this.#subjects);
        document.body.classList.toggle("empty", boxes.length === 0);
    }

    #say(text: string): void {
        const message = element("p", {}, element("span", { textContent: text }));
        message.append(element("button", { type: "button", textContent: "×", title: "dismiss", onclick: () => message.remove() }));
        this.#messages.append(message);
    }

    #copy(): void {
        this.#store.writeLink();
        navigator.clipboard?.writeText(location.href).catch(() => this.#say(location.href));
    }

    #draw(): void {
        this.#asked = 0;
        const started = performance.now();
        if (this.#stale) this.#compute();
        const wo = this.#hovered ?? (this.state.pinned && direction(this.state.pinned));
        this.#lobe.draw(this.#query, wo);
        this.#map.draw(this.#query, this.#subjects, wo);
        this.#section.draw(this.#query, this.#subjects, wo);
        this.#readout.show(this.#query, this.#subjects, wo, this.#hovered === null);
        performance.measure("frame", { start: started, end: performance.now() });
    }

    #compute(): void {
        this.#stale = false;
        this.#query.free();
        const query = (this.#query = new Query(this.state));
        const sides = query.sides(this.#subjects);
        const largest = this.#lobe.compute(query, this.#subjects, sides, this.#quality.lobe);
        const scale = new Scale(largest, query.state);
        this.#lobe.show(query, scale);
        this.#map.compute(query, this.#subjects, scale, this.#quality.map);
        this.#section.compute(query, this.#subjects, scale);
        clearTimeout(this.#resting);
        if (this.#quality !== RESTING) {
            this.#resting = window.setTimeout(() => {
                this.#quality = RESTING;
                this.#stale = true;
                this.redraw();
            }, REST);
        }
    }
}

function box(subject: Subject, letter: string, close: () => void): HTMLElement {
    const { about } = subject;
    const line = (text: string) => element("p", { textContent: text });
    const lambertian = Object.entries(about.lambertian).filter(([, value]) => value > 0);
    return element("div", { className: `file file${letter}` },
        element("h2", {}, letter ? `${letter} ` : "", subject.name,
            element("button", { type: "button", title: "close", textContent: "×", onclick: close })),
        line([about.name, about.manufacturer].filter(Boolean).join(", ") || about.content),
        ...about.components.map((c) => line(`${c.name}: ${c.structure}`)),
        ...lambertian.map(([name, value]) => line(`${name}: Lambertian ${value.toPrecision(3)}`)),
        about.warnings.length > 0
            ? element("details", {}, element("summary", { textContent: `${about.warnings.length} remarks of the reader` }), ...about.warnings.map(line))
            : null);
}

function dialog(): HTMLDialogElement {
    const rows = KEYS.map(([key, does]) => element("tr", {}, element("th", { textContent: key }), element("td", { textContent: does })));
    return element("dialog", {}, element("table", {}, ...rows),
        element("form", { method: "dialog" }, element("button", { textContent: "Close" })));
}

async function start(): Promise<void> {
    const root = document.getElementById("app")!;
    try {
        await load();
    } catch (e) {
        root.textContent = `The viewer cannot start: ${e instanceof Error ? e.message : String(e)}. It needs WebAssembly and a browser of 2023 or later.`;
        return;
    }
    await new Viewer(root).openLinked();
}

void start();
