// Everything that is set by hand beside dragging.
import { element } from "./elements.js";
import { degrees } from "./numbers.js";
import type { State, Store } from "./state.js";
import type { Subject } from "./subject.js";

type Keys<T> = { [K in keyof State]: State[K] extends T ? K : never }[keyof State];

export class Controls {
    readonly root = element("form", { className: "controls" });
    readonly #store: Store;
    /// What brings the elements up to the state.
    readonly #shown: (() => void)[] = [];
    readonly #band = element("select");
    readonly #bandRow: HTMLElement;
    readonly #compareRow: HTMLElement;
    readonly #channelRow: HTMLElement;

    constructor(store: Store) {
        this.#store = store;
        this.root.addEventListener("submit", (e) => e.preventDefault());
        this.#bandRow = row("Band", this.#band);
        this.#band.addEventListener("change", () => store.set({ band: this.#band.value }));
        this.#compareRow = row("Compare", this.#select("compare", { both: "A and B", a: "A", b: "B", difference: "difference" }));
        this.#channelRow = row("Channel", this.#select("channel", { y: "Y (photopic)", x: "X", z: "Z" }));
        this.root.append(
            group("Light", this.#incident(0, "θ", 0, 180), this.#incident(1, "φ", -360, 720), this.#flip()),
            group(
                "Scattered light",
                this.#tick("reflection", "reflected"),
                this.#tick("transmission", "transmitted"),
                row("Map shows", this.#select("map", { reflection: "reflected", transmission: "transmitted" })),
                row("Part", this.#select("parts", { all: "all", other: "not Lambertian", lambertian: "Lambertian" })),
                this.#channelRow,
                this.#bandRow,
                this.#compareRow,
            ),
            group(
                "Scale",
                this.#tick("log", "logarithmic"),
                this.#range("decades", "Decades", 0, 8, 0.5, "auto"),
                this.#range("exposure", "Exposure", -4, 12, 0.25),
                row("Colours", this.#select("colours", { viridis: "viridis", cividis: "cividis", grey: "grey" })),
                row("Map", this.#select("equalAngles", { false: "equal areas", true: "equal angles" })),
            ),
            group(
                "Show",
                this.#tick("cells", "leaves or patches"),
                this.#tick("smooth", "trees read smoothly"),
                this.#tick("points", "measured points"),
                this.#slice(),
                row("Object", this.#select("shape", { sphere: "sphere", drape: "drape", plane: "plane" })),
            ),
        );
        store.onChange(() => this.show());
        this.show();
    }

    /// The choices that these files leave.
    offer(subjects: readonly Subject[]): void {
        const bands = [...new Set(subjects.flatMap((s) => s.about.bands))];
        this.#band.replaceChildren(...["", ...bands].map((value) => element("option", { value, textContent: value || "Visible" })));
        this.#bandRow.hidden = bands.length === 0;
        this.#compareRow.hidden = subjects.length < 2;
        this.#channelRow.hidden = !subjects.some((s) => s.about.coloured);
        this.show();
    }

    show(): void {
        this.#shown.forEach((show) => show());
        this.#band.value = this.#store.get().band;
    }

    #select(key: keyof State, choices: Record<string, string>): HTMLSelectElement {
        const options = Object.entries(choices).map(([value, textContent]) => element("option", { value, textContent }));
        const made = element("select", {}, ...options);
        made.addEventListener("change", () => {
            const value = key === "equalAngles" ? made.value === "true" : made.value;
            this.#store.set({ [key]: value });
        });
        this.#shown.push(() => (made.value = String(this.#store.get()[key])));
        return made;
    }

    #tick(key: Keys<boolean>, text: string): HTMLElement {
        const made = element("input", { type: "checkbox" });
        made.addEventListener("change", () => this.#store.set({ [key]: made.checked }));
        this.#shown.push(() => (made.checked = this.#store.get()[key]));
        return element("label", { className: "tick" }, made, text);
    }

    #range(key: Keys<number>, text: string, min: number, max: number, step: number, zero = "0"): HTMLElement {
        const made = element("input", { type: "range", min: String(min), max: String(max), step: String(step) });
        const figure = element("output");
        made.addEventListener("input", () => this.#store.set({ [key]: made.valueAsNumber }));
        this.#shown.push(() => {
            made.valueAsNumber = this.#store.get()[key];
            figure.textContent = this.#store.get()[key] === 0 ? zero : String(this.#store.get()[key]);
        });
        return row(text, made, figure);
    }

    #incident(at: 0 | 1, text: string, min: number, max: number): HTMLElement {
        const made = element("input", { type: "number", min: String(min), max: String(max), step: "any" });
        made.addEventListener("change", () => {
            const incident: [number, number] = [...this.#store.get().incident];
            if (!Number.isFinite(made.valueAsNumber)) return this.show();
            incident[at] = made.valueAsNumber;
            this.#store.set({ incident });
        });
        this.#shown.push(() => {
            if (document.activeElement !== made) made.value = String(Math.round(this.#store.get().incident[at] * 100) / 100);
        });
        return row(text, made, element("span", { textContent: "°" }));
    }

    #flip(): HTMLElement {
        const made = element("button", { type: "button" });
        made.addEventListener("click", () => {
            const [theta, phi] = this.#store.get().incident;
            this.#store.set({ incident: [180 - theta, phi] });
        });
        this.#shown.push(() => {
            made.textContent = this.#store.get().incident[0] < 90 ? "on the front: turn to the back" : "on the back: turn to the front";
        });
        return made;
    }

    #slice(): HTMLElement {
        const made = element("input", { type: "range", min: "-1", max: "359", step: "1" });
        const figure = element("output");
        made.addEventListener("input", () => this.#store.set({ slice: made.valueAsNumber < 0 ? null : made.valueAsNumber }));
        this.#shown.push(() => {
            const { slice } = this.#store.get();
            made.valueAsNumber = slice ?? -1;
            figure.textContent = slice === null ? "with light" : degrees(slice);
        });
        return row("Slice at φ", made, figure);
    }
}

function row(text: string, ...controls: HTMLElement[]): HTMLElement {
    return element("label", { className: "row" }, element("span", { textContent: text }), ...controls);
}

function group(title: string, ...children: HTMLElement[]): HTMLElement {
    return element("details", { open: matchMedia("(min-width: 800px)").matches }, element("summary", { textContent: title }), ...children);
}
