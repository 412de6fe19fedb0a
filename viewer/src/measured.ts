// Measured points, beside the surfaces that were made of them.
import { type Angles, type Direction, Points, type Side } from "./core.js";

interface About {
    name: string;
    components: { name: string; incident: Side; scattered: Side; symmetry: string; incidences: number; points: number }[];
}

/// The points of one incidence on one side.
export interface Seen {
    /// (θ, φ) of the incidence, degrees.
    incident: Angles;
    directions: Float32Array;
    /// f, 1/sr.
    values: Float32Array;
}

export class Measured {
    readonly name: string;
    readonly about: About;
    readonly #points: Points;

    constructor(name: string, bytes: Uint8Array) {
        this.name = name;
        this.#points = Points.open(name, bytes);
        this.about = JSON.parse(this.#points.about()) as About;
    }

    answers(incident: Side, scattered: Side): boolean {
        return this.about.components.some((c) => c.incident === incident && c.scattered === scattered);
    }

    /// Of the incidence that is nearest to the light.
    nearest(wi: Direction, side: Side): Seen | null {
        const seen = this.#points.nearest(Float64Array.from(wi), side === "front");
        if (!seen) return null;
        const [theta, phi] = seen.incident;
        const found = { incident: [theta!, phi!] as const, directions: seen.directions, values: seen.values };
        seen.free();
        return found;
    }

    /// Measured incident directions on a side.
    incidences(side: Side): Direction[] {
        const flat = this.#points.incidences(side === "front");
        return Array.from({ length: flat.length / 3 }, (_, k) => [flat[3 * k]!, flat[3 * k + 1]!, flat[3 * k + 2]!] as const);
    }
}
