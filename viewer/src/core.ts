// The Rust core: everything that is more than drawing.
import init, {
    Points, Selection, Surface, from_degrees, map_direction, map_place, to_degrees,
} from "bsdfkit-web";

export { Points, Selection, Surface };

/// A unit vector away from the surface; front is z > 0.
export type Direction = readonly [number, number, number];
/// (θ, φ) in degrees.
export type Angles = readonly [number, number];

/// What `Surface.about` says.
export interface About {
    content: string;
    name: string;
    manufacturer: string;
    size: [number, number, number];
    properties: [string, string][];
    comments: string[];
    components: { name: string; incident: Side; scattered: Side; structure: string }[];
    specular: { name: string; incident: Side; scattered: Side; law: string }[];
    bands: string[];
    coloured: boolean;
    lambertian: Record<string, number>;
    warnings: string[];
}

export type Side = "front" | "back";

/// Unpacks and starts the core, which the page holds.
export async function load(): Promise<void> {
    const text = document.getElementById("core")?.textContent ?? "";
    const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    await init({ module_or_path: await new Response(stream).arrayBuffer() });
}

export const direction = ([theta, phi]: Angles): Direction => triple(from_degrees(theta, phi));
export const angles = ([x, y, z]: Direction): Angles => {
    const [theta, phi] = to_degrees(x, y, z);
    return [theta!, phi!];
};
export const sideOf = (w: Direction): Side => (w[2] > 0 ? "front" : "back");
export const opposite = (side: Side): Side => (side === "front" ? "back" : "front");

/// The direction drawn at a point of the disk of radius 1 in a map, +X right and +Y up.
export function mapDirection(x: number, y: number, side: Side, equalAngles: boolean): Direction | null {
    const w = map_direction(x, y, side === "front", equalAngles);
    return w.length === 3 ? triple(w) : null;
}

/// Where in that disk a direction is drawn.
export function mapPlace(w: Direction, equalAngles: boolean): [number, number] {
    const [x, y] = map_place(Float64Array.from(w), equalAngles);
    return [x!, y!];
}

export const triple = (v: ArrayLike<number>): Direction => [v[0]!, v[1]!, v[2]!];
