// Colour maps that the colour-blind can read, and the scale from values to them.
import { interpolateCividis, interpolatePuOr, interpolateViridis } from "d3-scale-chromatic";
import type { State } from "./state.js";

export const STEPS = 256;

/// Red, green, blue and opacity of `STEPS` colours.
export type Ramp = Uint8ClampedArray;

function ramp(colour: (t: number) => string): Ramp {
    const made = new Uint8ClampedArray(4 * STEPS);
    for (let k = 0; k < STEPS; k++) {
        const text = colour(k / (STEPS - 1));
        const parts = text.startsWith("#")
            ? [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16))
            : (text.match(/[\d.]+/g) ?? []).map(Number);
        made.set([parts[0]!, parts[1]!, parts[2]!, 255], 4 * k);
    }
    return made;
}

const grey = (t: number): string => `rgb(${[0, 0, 0].map(() => Math.round(12 + 243 * t)).join()})`;

export const RAMPS: Record<State["colours"], Ramp> = {
    viridis: ramp(interpolateViridis),
    cividis: ramp(interpolateCividis),
    grey: ramp(grey),
};

/// From purple (less) through white to orange (more).
export const DIFFERENCE: Ramp = ramp(interpolatePuOr);

/// Where the two files differ in drawing.
export const FILES = ["#2f6fb3", "#c2571a"] as const;

/// Values onto 0 to 1.
export class Scale {
    /// The value at 1, in 1/sr.
    readonly top: number;
    readonly log: boolean;
    readonly decades: number;

    /// Up to `largest`, from well below `matt`: what f would be if it were the same in all directions.
    constructor(largest: number, matt: number, state: Pick<State, "exposure" | "log" | "decades">) {
        this.top = (largest > 0 ? largest : 1) * 2 ** -state.exposure;
        this.log = state.log;
        const above = matt > 0 && largest > 0 ? Math.log10(largest / matt) : 1.5;
        this.decades = state.decades || Math.min(7, Math.max(0, above) + 1.5);
    }

    /// The value at 0.
    get bottom(): number {
        return this.log ? this.top * 10 ** -this.decades : 0;
    }

    at(value: number): number {
        const share = value / this.top;
        const t = this.log ? (share > 0 ? 1 + Math.log10(share) / this.decades : 0) : share;
        return Math.min(1, Math.max(0, t));
    }

    value(t: number): number {
        return this.log ? this.top * 10 ** ((t - 1) * this.decades) : t * this.top;
    }

    /// Round values within the scale.
    ticks(): number[] {
        const found = [];
        if (this.log) {
            const last = Math.floor(Math.log10(this.top) + 1e-9);
            for (let power = Math.ceil(Math.log10(this.bottom) - 1e-9); power <= last; power++) found.push(10 ** power);
            if (found.length > 1) return found;
        }
        const step = 10 ** Math.floor(Math.log10(this.top / 2));
        const wide = [1, 2, 5].map((n) => n * step).find((s) => this.top / s <= 5) ?? 10 * step;
        for (let value = this.log ? wide : 0; value <= this.top * 1.0001; value += wide) found.push(value);
        return found;
    }
}

/// Colours of values into `out`, four bytes each; nothing where a value is no number.
export function paint(values: Float32Array, scale: Scale, colours: Ramp, out: Uint8ClampedArray): void {
    for (let k = 0; k < values.length; k++) {
        const value = values[k]!;
        const at = 4 * k;
        if (Number.isNaN(value)) {
            out[at + 3] = 0;
            continue;
        }
        const from = 4 * Math.round(scale.at(value) * (STEPS - 1));
        out[at] = colours[from]!;
        out[at + 1] = colours[from + 1]!;
        out[at + 2] = colours[from + 2]!;
        out[at + 3] = 255;
    }
}
