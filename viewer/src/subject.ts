// The opened files and what is asked of them for the present state.
import {
    type About, type Direction, Selection, type Side, Surface, direction, opposite, sideOf,
} from "./core.js";
import type { State } from "./state.js";

/// An opened file.
export class Subject {
    static #count = 0;
    /// Tells it from every other, files of the same name too.
    readonly number = ++Subject.#count;
    readonly name: string;
    readonly #file: Surface;
    #shown: Surface;
    #reading = "";
    readonly about: About;

    constructor(name: string, bytes: Uint8Array) {
        this.name = name;
        this.#file = Surface.open(name, bytes);
        this.#shown = this.#file;
        this.about = JSON.parse(this.#file.about()) as About;
    }

    /// Pairs of sides that are answered: those stored, and a lone transmission the other way.
    answers(incident: Side, scattered: Side): boolean {
        const { lambertian } = this.about;
        const components = [...this.about.components, ...this.about.specular];
        if (components.some((c) => c.incident === incident && c.scattered === scattered)) return true;
        const crossing = incident === scattered ? "reflection" : "transmission";
        if ((lambertian[`${incident} ${crossing}`] ?? 0) > 0) return true;
        return incident !== scattered && components.some((c) => c.incident === scattered && c.scattered === incident);
    }

    /// The surface in the band and with the lookup asked for.
    surface(state: State): Surface {
        const reading = `${state.band}\n${state.smooth}`;
        if (reading !== this.#reading) {
            const banded = state.band && this.about.bands.includes(state.band) ? this.#file.band(state.band) : undefined;
            const base = banded ?? this.#file;
            this.#shown = state.smooth ? base.with_lookup(true) : base;
            this.#reading = reading;
        }
        return this.#shown;
    }
}

const BITS = { reflection: 1, transmission: 2, other: 4, lambertian: 8 };

/// What is switched on, for the core.
export function selection(state: State): Selection {
    const parts = state.parts === "all" ? BITS.other | BITS.lambertian : BITS[state.parts];
    return new Selection(BITS.reflection | BITS.transmission | parts, state.channel);
}

/// One state, seen for one incident direction.
export class Query {
    readonly state: State;
    readonly wi: Direction;
    readonly #wi: Float64Array;
    readonly selection: Selection;

    constructor(state: State) {
        this.state = state;
        this.wi = direction(state.incident);
        this.#wi = Float64Array.from(this.wi);
        this.selection = selection(state);
    }

    /// The side that light of a kind is scattered to.
    side(kind: "reflection" | "transmission"): Side {
        const here = sideOf(this.wi);
        return kind === "reflection" ? here : opposite(here);
    }

    /// Sides that are shown and that any of these answers for.
    sides(answering: readonly { answers(incident: Side, scattered: Side): boolean }[]): Side[] {
        const here = sideOf(this.wi);
        const kinds = (["reflection", "transmission"] as const).filter((kind) => this.state[kind]);
        return kinds.map((kind) => this.side(kind)).filter((to) => answering.some((a) => a.answers(here, to)));
    }

    map(subject: Subject, side: Side, size: number): Float32Array {
        const surface = subject.surface(this.state);
        return surface.map(this.#wi, side === "front", this.selection, size, this.state.equalAngles);
    }

    lobe(subject: Subject, side: Side, finest: number, samples: number) {
        return subject.surface(this.state).lobe(this.#wi, side === "front", this.selection, finest, samples);
    }

    section(subject: Subject, phi: number, steps: number): Float32Array {
        return subject.surface(this.state).section(this.#wi, phi, this.selection, steps);
    }

    /// Peaks of no width: where they go, and the share of the light.
    peaks(subject: Subject): { wo: Direction; share: number }[] {
        if (subject.about.specular.length === 0) return [];
        const flat = subject.surface(this.state).specular_peaks(this.#wi, this.selection);
        return Array.from({ length: flat.length / 4 }, (_, k) => {
            const [x, y, z, share] = flat.subarray(4 * k, 4 * k + 4);
            return { wo: [x!, y!, z!] as Direction, share: share! };
        });
    }

    cells(subject: Subject, side: Side): Float32Array {
        return subject.surface(this.state).cells(this.#wi, side === "front");
    }

    value(subject: Subject, wo: Direction): number {
        return subject.surface(this.state).value(this.#wi, Float64Array.from(wo), this.selection);
    }

    xyz(subject: Subject, wo: Direction): Direction {
        const [x, y, z] = subject.surface(this.state).value_xyz(this.#wi, Float64Array.from(wo));
        return [x!, y!, z!];
    }

    cellSize(subject: Subject, wo: Direction): number {
        return subject.surface(this.state).cell_size(this.#wi, Float64Array.from(wo));
    }

    /// Rows of a lit object: four bytes a pixel.
    scene(subject: Subject, exposure: number, size: number, first: number, count: number): Uint8Array {
        return subject.surface(this.state).scene(this.state.shape, this.#wi, exposure, size, first, count);
    }

    /// Reflectance and transmittance.
    totals(subject: Subject): [number, number] {
        const [reflected, transmitted] = subject.surface(this.state).totals(this.#wi, this.selection);
        return [reflected!, transmitted!];
    }

    free(): void {
        this.selection.free();
    }
}
