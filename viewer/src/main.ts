// The page: files in, panels out.
import { type Angles, type Direction, Points, type Side, angles, direction, load, sideOf } from "./core.js";
import { Scale } from "./colours.js";
import { Controls } from "./controls.js";
import { element } from "./elements.js";
import { type Handed, listenAround } from "./embed.js";
import { type Given, fetched, onDrop, read } from "./files.js";
import { KEYS, listen } from "./keyboard.js";
import { Measured, type Seen } from "./measured.js";
import type { Page } from "./page.js";
import { LobePanel } from "./panels/lobe.js";
import { LitPanel } from "./panels/lit.js";
import { MapPanel } from "./panels/map.js";
import { SectionPanel } from "./panels/section.js";
import { Readout } from "./readout.js";
import { type State, Store } from "./state.js";
import { Query, Subject } from "./subject.js";

/// How fine map, lobe and slice are: at rest; while something moves, as fine as a frame has time for.
const RESTING = { map: 512, finest: 11, samples: 4096, section: 1440 };
const MOVING = [
    { map: 48, finest: 7, samples: 256, section: 360 },
    { map: 72, finest: 7, samples: 512, section: 360 },
    { map: 112, finest: 8, samples: 1024, section: 720 },
    { map: 160, finest: 9, samples: 2048, section: 1440 },
];
/// What a frame's work may take, ms; beyond it, it is done less finely, at less than a third of it more so.
const FRAME = 11;
/// How many pixels the lobe has along a side while something moves, as a share of those at rest: without a graphics processor
/// drawing takes longer than the numbers.
const SHARES = [1, 0.5, 0.33];
/// Frames further apart than this, ms, are late; after so many late ones and none in time the lobe is drawn with fewer pixels, after so
/// many in time with more.
const LATE = 20;
const LATE_FRAMES = 3;
const FRAMES_IN_TIME = 60;
/// Frames further apart than this are of two movements, ms.
const PAUSE = 200;
/// After so long without a change the page shows all that it can, ms.
const REST = 120;
/// What decides about numbers; of the rest a new drawing is enough.
const COMPUTED: readonly (keyof State)[] = [
    "incident", "shape", "reflection", "transmission", "map", "parts", "channel", "band", "smooth", "equalAngles", "slice", "compare", "log", "decades", "exposure", "colours", "points",
];

class Viewer implements Page {
    readonly #store = new Store();
    readonly #lobe = new LobePanel(this);
    readonly #map = new MapPanel(this);
    readonly #section = new SectionPanel(this);
    readonly #lit = new LitPanel();
    readonly #readout = new Readout();
    readonly #controls = new Controls(this.#store);
    readonly #files = element("div", { className: "files" });
    readonly #messages = element("div", { className: "messages" });
    #subjects: Subject[] = [];
    #measured: Measured | null = null;
    #seen = new Map<Side, Seen>();
    #query: Query;
    #hovered: Direction | null = null;
    #asked = 0;
    #stale = true;
    #resting = 0;
    #loading = 0;
    /// Whether something is being dragged.
    #held = false;
    #quality = RESTING;
    #moving = MOVING.length - 2;
    /// Of `SHARES`; frames in a row that were late, or else in time; when the last one began.
    #share = 0;
    #late = 0;
    #inTime = 0;
    #began = 0;

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
            element("main", {}, this.#messages, this.#lobe.root, this.#map.root, this.#section.root, this.#lit.root),
            this.#readout.root,
            help,
        );
        this.#store.onChange((changed) => this.#changed(changed));
        listen(this.#store, () => help.showModal(), () => this.#snap());
        onDrop((files) => void this.#take(files.map(read)));
        for (const [event, held] of [["pointerdown", true], ["pointerup", false], ["pointercancel", false]] as const) {
            addEventListener(event, () => (this.#held = held), { capture: true });
        }
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

    /// What a page around this one hands over.
    handed({ state, files }: Handed): void {
        if (state !== undefined) this.#store.read(state);
        if (files) void this.#take(files.map(async ({ name, bytes }) => ({ name, bytes: new Uint8Array(bytes) })));
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
        this.#tell();
    }

    /// Whether something is still to come, for whoever waits for the page.
    #tell(): void {
        const busy = this.#loading > 0 || this.#asked !== 0 || this.#quality !== RESTING || this.#store.pending;
        document.body.setAttribute("aria-busy", String(busy));
    }

    #changed(changed: ReadonlySet<keyof State>): void {
        if (COMPUTED.some((key) => changed.has(key))) {
            this.#stale = true;
            this.#quality = MOVING[this.#moving]!;
        }
        if (changed.size > 0) this.redraw();
        else this.#tell();
    }

    /// What answers, for one side or another.
    get #sources(): readonly (Subject | Measured)[] {
        return this.#measured ? [...this.#subjects, this.#measured] : this.#subjects;
    }

    /// The light to the nearest measured incidence.
    #snap(): void {
        const [seen] = this.#seen.values();
        if (seen) this.#store.set({ incident: seen.incident });
    }

    /// Opens files, two at most at a time, A and B, and measured points.
    async #take(given: Promise<Given>[], linked = false): Promise<void> {
        const opened: Subject[] = [];
        this.#loading += 1;
        this.#tell();
        for (const pending of given) {
            try {
                const { name, bytes } = await pending;
                if (Points.are_in(bytes)) this.#measured = new Measured(name, bytes);
                else opened.push(new Subject(name, bytes));
            } catch (e) {
                this.#say(e instanceof Error ? e.message : String(e));
            }
        }
        this.#loading -= 1;
        const kept = opened.length === 0 ? this.#subjects : opened.length === 1 ? this.#subjects.slice(0, 1) : [];
        const all = [...kept, ...opened];
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
        if (query.sides(this.#sources).length === 0) {
            const from = sides.find((a) => sides.some((b) => this.#sources.some((s) => s.answers(a, b))));
            const [theta, phi] = this.state.incident;
            const flipped = from && (from === "front") !== theta < 90;
            this.#store.set({ reflection: true, transmission: true, incident: flipped ? [180 - theta, phi] : [theta, phi] });
        }
        const now = new Query(this.state);
        const shown = now.sides(this.#sources);
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
            "A second one is compared with the first. Measurements are shown by the command: bsdf view FOLDER. ",
            "Nothing is uploaded.");
        const measured = this.#measured && pointsBox(this.#measured, () => {
            this.#measured = null;
            this.#store.set({ open: [] });
            this.#list();
            this.#stale = true;
            this.redraw();
        });
        this.#files.replaceChildren(...boxes, ...(measured ? [measured] : []), ...(boxes.length < 2 ? [hint] : []));
        this.#controls.offer(this.#subjects);
        document.body.classList.toggle("empty", this.#sources.length === 0);
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
        const [computed, moving] = [this.#stale, this.#quality !== RESTING];
        if (computed) this.#compute();
        const numbers = performance.now();
        const wo = this.#hovered ?? (this.state.pinned && direction(this.state.pinned));
        this.#lobe.draw(this.#query, wo, moving ? SHARES[this.#share]! : 1);
        this.#map.draw(this.#query, this.#subjects, wo);
        this.#section.draw(this.#query, wo);
        this.#lit.show(this.#query, this.#subjects, this.#quality !== RESTING);
        this.#readout.show(this.#query, this.#subjects, this.#seen, wo, this.#hovered === null);
        const ended = performance.now();
        if (computed && moving) this.#pace(started, ended - started);
        performance.measure("numbers", { start: started, end: numbers });
        performance.measure("frame", { start: started, end: ended });
        this.#tell();
    }

    /// The next moving frame is as fine as this one lets expect.
    #pace(started: number, taken: number): void {
        const apart = started - this.#began;
        this.#began = started;
        // What the numbers took is answered by coarser numbers, below.
        if (apart <= LATE) this.#late = 0;
        else if (apart < PAUSE && taken < LATE) this.#late++;
        this.#inTime = apart <= LATE ? this.#inTime + 1 : 0;
        if (this.#late === LATE_FRAMES) {
            this.#share = Math.min(SHARES.length - 1, this.#share + 1);
            this.#late = 0;
        } else if (this.#inTime === FRAMES_IN_TIME) {
            this.#share = Math.max(0, this.#share - 1);
            this.#inTime = 0;
        }
        if (taken > FRAME) this.#moving = Math.max(0, this.#moving - 1);
        else if (taken < FRAME / 3) this.#moving = Math.min(MOVING.length - 1, this.#moving + 1);
    }

    #compute(): void {
        this.#stale = false;
        this.#query.free();
        const query = (this.#query = new Query(this.state));
        const { points } = query.state;
        const sides = query.sides(this.#sources);
        const answered = query.sides(this.#subjects);
        const measured = points ? this.#measured : null;
        this.#seen = new Map(sides.flatMap((side) => {
            const seen = measured?.nearest(query.wi, side);
            return seen ? [[side, seen] as const] : [];
        }));
        let largest = this.#lobe.compute(query, this.#subjects, answered, this.#quality);
        if (answered.length === 0) {
            for (const { values } of this.#seen.values()) largest = values.reduce((a, b) => Math.max(a, b), largest);
        }
        const totals = this.#subjects.flatMap((subject) => query.totals(subject));
        const scale = new Scale(largest, Math.max(0, ...totals) / Math.PI, query.state);
        this.#lobe.points(this.#seen.values());
        this.#lobe.show(query, scale);
        const incidences = measured?.incidences(sideOf(query.wi)) ?? [];
        this.#map.compute(query, this.#subjects, { seen: this.#seen, incidences }, scale, this.#quality.map);
        this.#section.compute(query, this.#subjects, this.#seen, sides, scale, this.#quality.section);
        if (this.#quality !== RESTING) this.#rest();
    }

    /// Draws all as finely as it goes once nothing has moved for a while.
    #rest(): void {
        clearTimeout(this.#resting);
        this.#resting = window.setTimeout(() => {
            if (this.#held) return this.#rest();
            this.#quality = RESTING;
            this.#stale = true;
            this.redraw();
        }, REST);
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
        ...about.specular.map((s) => line(`${s.name}: ${s.law}, a peak of no width`)),
        ...lambertian.map(([name, value]) => line(`${name}: Lambertian ${value.toPrecision(3)}`)),
        about.warnings.length > 0
            ? element("details", {}, element("summary", { textContent: `remarks of the reader: ${about.warnings.length}` }), ...about.warnings.map(line))
            : null);
}

function pointsBox({ name, about }: Measured, close: () => void): HTMLElement {
    const lines = about.components.map((c) =>
        element("p", { textContent: `${c.name}: ${c.points} points of ${c.incidences} incidences, ${c.symmetry} symmetry` }));
    return element("div", { className: "file points" },
        element("h2", {}, name, element("button", { type: "button", title: "close", textContent: "×", onclick: close })),
        element("p", { textContent: about.name || "measurement" }), ...lines);
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
    const viewer = new Viewer(root);
    await viewer.openLinked();
    listenAround((handed) => viewer.handed(handed));
}

void start();
