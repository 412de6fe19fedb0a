// The line that says what the pointer is on.
import { angles, sideOf, type Direction, type Side } from "./core.js";
import { element } from "./elements.js";
import type { Seen } from "./measured.js";
import { digits, place } from "./numbers.js";
import type { Query, Subject } from "./subject.js";

export class Readout {
    readonly root = element("footer", { className: "readout" });

    show(query: Query, subjects: readonly Subject[], points: ReadonlyMap<Side, Seen>, wo: Direction | null, pinned: boolean): void {
        const parts: HTMLElement[] = [part("incident", place(query.state.incident))];
        if (wo) parts.push(part(pinned ? "scattered (kept)" : "scattered", place(angles(wo))));
        subjects.forEach((subject, n) => {
            const label = subjects.length > 1 ? `${"AB"[n]}: ` : "";
            if (wo) {
                const value = query.value(subject, wo);
                const f = part(`${label}f`, `${digits(value)} 1/sr`);
                f.dataset["value"] = String(value);
                f.classList.add("value");
                parts.push(f);
                if (subject.about.coloured) {
                    const [x, y, z] = query.xyz(subject, wo).map((v) => digits(v, 4));
                    parts.push(part("X, Y, Z", `${x}, ${y}, ${z} 1/sr`));
                }
                parts.push(part("cell", `${digits(query.cellSize(subject, wo), 3)} sr`));
            }
            const [reflected, transmitted] = query.totals(subject);
            parts.push(part(`${label}reflectance, transmittance`, `${digits(reflected, 4)}, ${digits(transmitted, 4)}`));
            for (const { wo, share } of query.peaks(subject)) {
                parts.push(part(`${label}of it in a peak of no width`, `${digits(share, 4)} to ${place(angles(wo))}`));
            }
        });
        const seen = wo ? points.get(sideOf(wo)) : [...points.values()][0];
        if (seen) parts.push(part("measured", wo ? nearest(seen, wo) : `from ${place(seen.incident)}`));
        if (!wo && subjects.length > 0) parts.push(part("", "point at a panel for values; click to keep a direction"));
        else if (wo && subjects.length > 0) parts.push(part("", sideOf(wo) === sideOf(query.wi) ? "reflected" : "transmitted"));
        this.root.replaceChildren(...parts);
    }
}

/// The measured point that is nearest to a direction, in words.
function nearest({ incident, directions, values, apart }: Seen, wo: Direction): string {
    let [best, at] = [-2, 0];
    values.forEach((_, k) => {
        const dot = directions[3 * k]! * wo[0] + directions[3 * k + 1]! * wo[1] + directions[3 * k + 2]! * wo[2];
        if (dot > best) [best, at] = [dot, k];
    });
    const there = angles([directions[3 * at]!, directions[3 * at + 1]!, directions[3 * at + 2]!]);
    return `${digits(values[at]!, 4)} 1/sr at ${place(there)}${apart ? `, but light from ${place(incident)}` : ""}`;
}

function part(name: string, text: string): HTMLElement {
    return element("span", { className: "part" }, name ? element("b", { textContent: name }) : null, " ", text);
}
