// What the page shows, and the link that says so.
import type { Angles } from "./core.js";
import { embedded, tellAround } from "./embed.js";

export interface State {
    /// Files to load, by addresses relative to the page.
    open: string[];
    /// Incident direction, degrees; beyond 90 from the back.
    incident: Angles;
    /// The scattered direction that is kept in view, degrees.
    pinned: Angles | null;
    reflection: boolean;
    transmission: boolean;
    /// Which hemisphere the map shows: that of reflected or of transmitted light.
    map: "reflection" | "transmission";
    parts: "all" | "other" | "lambertian";
    channel: "y" | "x" | "z";
    band: string;
    smooth: boolean;
    log: boolean;
    /// Of the logarithmic scale; 0: as many as show matt light as well as peaks.
    decades: number;
    /// Powers of two by which the scale ends below the largest value.
    exposure: number;
    colours: "viridis" | "cividis" | "grey";
    equalAngles: boolean;
    cells: boolean;
    points: boolean;
    /// Azimuth of the slice, degrees; null: the plane of incidence.
    slice: number | null;
    compare: "both" | "a" | "b" | "difference";
    shape: "sphere" | "drape" | "plane";
}

export const START: State = {
    open: [],
    incident: [30, 0],
    pinned: null,
    reflection: true,
    transmission: true,
    map: "reflection",
    parts: "all",
    channel: "y",
    band: "",
    smooth: false,
    log: true,
    decades: 0,
    exposure: 0,
    colours: "viridis",
    equalAngles: false,
    cells: false,
    points: true,
    slice: null,
    compare: "both",
    shape: "sphere",
};

/// Values that words may have, beside the one they start with.
const WORDS: Partial<Record<keyof State, readonly string[]>> = {
    map: ["reflection", "transmission"],
    parts: ["all", "other", "lambertian"],
    channel: ["x", "y", "z"],
    colours: ["viridis", "cividis", "grey"],
    compare: ["both", "a", "b", "difference"],
    shape: ["sphere", "drape", "plane"],
};

const short = (n: number): string => String(Math.round(n * 1e4) / 1e4);

/// What differs from the start, as the part of a link behind "#".
export function toLink(state: State): string {
    const link = new URLSearchParams();
    for (const key of Object.keys(START) as (keyof State)[]) {
        const value = state[key];
        if (JSON.stringify(value) === JSON.stringify(START[key])) continue;
        if (key === "open") state.open.forEach((address) => link.append("open", address));
        else if (Array.isArray(value)) link.set(key, value.map((n) => short(Number(n))).join(","));
        else if (typeof value === "number") link.set(key, short(value));
        else link.set(key, value === null ? "" : String(value));
    }
    return link.toString().replaceAll("%2C", ",").replaceAll("%2F", "/");
}

/// The state that a link means; what it does not say, or says wrongly, is as at the start.
export function fromLink(text: string): State {
    const link = new URLSearchParams(text.replace(/^#/, ""));
    const state: Record<string, unknown> = { ...START };
    for (const [key, value] of link) {
        const start = START[key as keyof State];
        const words = WORDS[key as keyof State];
        if (key === "open") state["open"] = link.getAll("open");
        else if (key === "incident" || key === "pinned") state[key] = pair(value) ?? start;
        else if (key === "slice") state[key] = value === "" ? null : number(value) ?? null;
        else if (words) state[key] = words.includes(value) ? value : start;
        else if (typeof start === "boolean") state[key] = value === "true";
        else if (typeof start === "number") state[key] = number(value) ?? start;
        else if (typeof start === "string") state[key] = value;
    }
    return clamped(state as unknown as State);
}

function clamped(state: State): State {
    const within = (n: number, low: number, high: number) => Math.min(high, Math.max(low, n));
    return {
        ...state,
        incident: [within(state.incident[0], 0, 180), state.incident[1]],
        decades: within(state.decades, 0, 8),
        exposure: within(state.exposure, -10, 20),
    };
}

function number(text: string): number | undefined {
    const n = Number(text);
    return text !== "" && Number.isFinite(n) ? n : undefined;
}

function pair(text: string): Angles | undefined {
    const [a, b, ...more] = text.split(",").map(number);
    return a !== undefined && b !== undefined && more.length === 0 ? [a, b] : undefined;
}

type Listener = (changed: ReadonlySet<keyof State>) => void;

/// The state with those who want to know of changes. The address of the page follows it.
export class Store {
    #state: State;
    #listeners: Listener[] = [];
    #timer = 0;
    /// The address as it was last read or written.
    #address = location.hash;

    constructor() {
        this.#state = fromLink(location.hash);
        addEventListener("hashchange", () => {
            this.#address = location.hash;
            if (location.hash.replace(/^#/, "") !== toLink(this.#state)) {
                this.set(fromLink(location.hash));
            }
        });
    }

    get(): State {
        return this.#state;
    }

    /// Whether the address does not say all of it yet.
    get pending(): boolean {
        return this.#timer !== 0;
    }

    onChange(listener: Listener): void {
        this.#listeners.push(listener);
    }

    set(change: Partial<State>): void {
        const next = clamped({ ...this.#state, ...change });
        const keys = Object.keys(next) as (keyof State)[];
        const changed = new Set(keys.filter((k) => JSON.stringify(next[k]) !== JSON.stringify(this.#state[k])));
        if (changed.size === 0) return;
        this.#state = next;
        // Browsers refuse too many changes of the address in a row.
        clearTimeout(this.#timer);
        this.#timer = window.setTimeout(() => this.writeLink(), 200);
        this.#listeners.forEach((listener) => listener(changed));
    }

    /// All that a link says.
    read(link: string): void {
        if (link !== toLink(this.#state)) this.set(fromLink(link));
    }

    writeLink(): void {
        clearTimeout(this.#timer);
        this.#timer = 0;
        if (embedded) {
            tellAround(toLink(this.#state));
        } else if (location.hash === this.#address) {
            // If somebody has just changed it, that counts.
            const link = toLink(this.#state);
            history.replaceState(null, "", link ? `#${link}` : location.pathname + location.search);
            this.#address = location.hash;
        }
        this.#listeners.forEach((listener) => listener(new Set()));
    }
}
