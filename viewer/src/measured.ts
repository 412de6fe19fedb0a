// Measured points, beside the surfaces that were made of them.
import { type Angles, type Direction, Points, type Side, direction } from "./core.js";

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
    /// Whether the light is elsewhere: then they are not to be compared with what is beside them.
    apart: boolean;
}

/// The cosine of how far from an incidence its points still count as the light's own: 0.5 degrees.
const NEAR = 0.99996;

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
        const incident = [theta!, phi!] as const;
        const [x, y, z] = direction(incident);
        const apart = x * wi[0] + y * wi[1] + z * wi[2] < NEAR;
        const found = { incident, directions: seen.directions, values: seen.values, apart };
        seen.free();
        return found;
    }

    /// Measured incident directions on a side.
    incidences(side: Side): Direction[] {
        const flat = this.#points.incidences(side === "front");
        return Array.from({ length: flat.length / 3 }, (_, k) => [flat[3 * k]!, flat[3 * k + 1]!, flat[3 * k + 2]!] as const);
    }
}
