// Numbers as a person reads them.
import type { Angles } from "./core.js";

const MINUS = "\u2212";

/// So many digits that count; powers of ten only where zeros would be in the way.
export function digits(value: number, count = 6): string {
    if (Number.isNaN(value)) return "no data";
    if (value === 0) return "0";
    const size = Math.abs(value);
    const text = size >= 1e6 || size < 1e-4 ? value.toExponential(count - 1) : value.toPrecision(count);
    return text.replace(/^-/, MINUS).replace(/e([+-])(\d+)$/, (_, sign, power) => `e${sign === "-" ? MINUS : ""}${power}`);
}

export function degrees(value: number): string {
    return `${(Math.round(value * 10) / 10).toFixed(1).replace(/^-/, MINUS)}°`;
}

export function place([theta, phi]: Angles): string {
    return `θ ${degrees(theta)} φ ${degrees(((phi % 360) + 360) % 360)}`;
}
