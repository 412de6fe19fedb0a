// The line that says what the pointer is on.
import { angles, sideOf, type Direction } from "./core.js";
import { element } from "./elements.js";
import { digits, place } from "./numbers.js";
import type { Query, Subject } from "./subject.js";

export class Readout {
    readonly root = element("footer", { className: "readout" });

    show(query: Query, subjects: readonly Subject[], wo: Direction | null, pinned: boolean): void {
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
        });
        if (!wo && subjects.length > 0) parts.push(part("", "point at a panel for values; click to keep a direction"));
        else if (wo && subjects.length > 0) parts.push(part("", sideOf(wo) === sideOf(query.wi) ? "reflected" : "transmitted"));
        this.root.replaceChildren(...parts);
    }
}

function part(name: string, text: string): HTMLElement {
    return element("span", { className: "part" }, name ? element("b", { textContent: name }) : null, " ", text);
}
