// One hemisphere of scattered light as colours, seen from the front.
import { type Direction, type Side, mapDirection, mapPlace, sideOf, angles, direction } from "../core.js";
import { DIFFERENCE, RAMPS, type Ramp, Scale, paint } from "../colours.js";
import { element, fit } from "../elements.js";
import { digits } from "../numbers.js";
import type { Seen } from "../measured.js";
import type { Query, Subject } from "../subject.js";
import type { Page } from "../page.js";

const MARGIN = 18;
const NEAR = 18;
const RINGS = [30, 60, 90];

/// Measured points by side, and where light was measured from.
export interface Shown {
    seen: ReadonlyMap<Side, Seen>;
    incidences: readonly Direction[];
}

/// One disk of the panel, in CSS pixels.
interface Disk {
    title: string;
    x: number;
    y: number;
    radius: number;
    side: Side;
    image: HTMLCanvasElement;
}

export class MapPanel {
    readonly root: HTMLElement;
    readonly #canvas = element("canvas", { tabIndex: 0 });
    readonly #page: Page;
    #disks: Disk[] = [];
    #scale: Scale | null = null;
    #ramp: Ramp = RAMPS.viridis;
    #dragging = false;
    #points: Seen | null = null;
    #incidences: readonly Direction[] = [];

    constructor(page: Page) {
        this.#page = page;
        this.#canvas.setAttribute("aria-label", "Hemisphere of scattered light; drag the ring to move the light");
        this.root = element("section", { className: "panel map" }, this.#canvas);
        this.#canvas.addEventListener("pointerdown", (e) => this.#press(e));
        this.#canvas.addEventListener("pointermove", (e) => this.#move(e));
        this.#canvas.addEventListener("pointerup", () => (this.#dragging = false));
        this.#canvas.addEventListener("pointercancel", () => (this.#dragging = false));
        this.#canvas.addEventListener("pointerleave", () => page.hover(null));
    }

    /// Fills the disks: `size` pixels each.
    compute(query: Query, subjects: readonly Subject[], points: Shown, scale: Scale, size: number): void {
        const { state } = query;
        const side = query.side(state.map);
        this.#points = points.seen.get(side) ?? null;
        this.#incidences = points.incidences;
        const [a, b] = subjects;
        this.#scale = scale;
        this.#ramp = RAMPS[state.colours];
        const shown: { title: string; values: Float32Array; scale: Scale; ramp: Ramp }[] = [];
        const plain = (subject: Subject) => {
            const values = query.map(subject, side, size);
            shown.push({ title: subject.name, values, scale, ramp: this.#ramp });
            return values;
        };
        if (a && b && state.compare === "difference") {
            const [first, second] = [query.map(a, side, size), query.map(b, side, size)];
            const share = second.map((v, k) => (v - first[k]!) / (v + first[k]! || 1));
            const whole = { top: 1, bottom: -1, at: (v: number) => (v + 1) / 2, value: (t: number) => 2 * t - 1, ticks: () => [-1, 0, 1] };
            this.#scale = whole as unknown as Scale;
            this.#ramp = DIFFERENCE;
            shown.push({ title: "(B − A) / (B + A)", values: share, scale: this.#scale, ramp: DIFFERENCE });
        } else {
            if (a && (state.compare !== "b" || !b)) plain(a);
            if (b && state.compare !== "a") plain(b);
        }
        if (shown.length === 0 && this.#points) {
            const values = new Float32Array(size * size).fill(NaN);
            shown.push({ title: "", values, scale, ramp: this.#ramp });
        }
        this.#disks = shown.map(({ title, values, scale, ramp }) => {
            const image = document.createElement("canvas");
            image.width = image.height = size;
            const pixels = new ImageData(size, size);
            paint(values, scale, ramp, pixels.data);
            image.getContext("2d")!.putImageData(pixels, 0, 0);
            return { title, x: 0, y: 0, radius: 0, side, image };
        });
    }

    draw(query: Query, subjects: readonly Subject[], hovered: Direction | null): void {
        const { width, height, pen } = fit(this.#canvas);
        const style = getComputedStyle(this.#canvas);
        const ink = style.color;
        const bar = 64;
        const count = this.#disks.length;
        const wide = width - bar > height;
        const [w, h] = wide ? [(width - bar) / count, height] : [width - bar, height / count];
        this.#disks.forEach((disk, n) => {
            disk.radius = Math.max(10, Math.min(w / 2 - MARGIN, (h - 52) / 2));
            disk.x = (wide ? w * (n + 0.5) : w / 2);
            disk.y = (wide ? h / 2 : h * (n + 0.5)) + 8;
            pen.imageSmoothingEnabled = false;
            const { x, y, radius } = disk;
            pen.drawImage(disk.image, x - radius, y - radius, 2 * radius, 2 * radius);
            this.#cells(pen, query, subjects[n] ?? subjects[0], disk);
            this.#grid(pen, disk, query.state.equalAngles, ink);
            const at = (w: Direction) => {
                const [px, py] = mapPlace(w, query.state.equalAngles);
                return [x + px * radius, y - py * radius] as const;
            };
            this.#measured(pen, at, disk.side, sideOf(query.wi) === disk.side);
            const subject = subjects[n] ?? subjects[0];
            for (const peak of subject ? query.peaks(subject) : []) {
                if (sideOf(peak.wo) === disk.side) this.#peak(pen, at(peak.wo), peak.share);
            }
            this.#light(pen, at(query.wi), sideOf(query.wi) === disk.side);
            if (hovered && sideOf(hovered) === disk.side) this.#cross(pen, at(hovered));
            pen.fillStyle = ink;
            pen.textAlign = "center";
            pen.font = "12px system-ui, sans-serif";
            if (count > 1 || disk.title.startsWith("(")) pen.fillText(clipped(pen, disk.title, w - 12), x, y - radius - 18);
        });
        // Where the disks are, for whoever reads the page otherwise than by eye.
        this.#canvas.dataset["disks"] = this.#disks.map(({ x, y, radius, side }) => [x, y, radius, side].join()).join(";");
        this.#bar(pen, width - bar + 6, height, ink);
    }

    #cells(pen: CanvasRenderingContext2D, query: Query, subject: Subject | undefined, { x, y, radius, side }: Disk): void {
        if (!query.state.cells || !subject) return;
        const outlines = query.cells(subject, side);
        pen.save();
        pen.beginPath();
        // Each outline: how many corners, then their directions.
        for (let at = 0; at < outlines.length; ) {
            const corners = outlines[at++]!;
            for (let k = 0; k < corners; k++, at += 3) {
                const w: Direction = [outlines[at]!, outlines[at + 1]!, outlines[at + 2]!];
                const [px, py] = mapPlace(w, query.state.equalAngles);
                const [cx, cy] = [x + px * radius, y - py * radius];
                if (k === 0) pen.moveTo(cx, cy);
                else pen.lineTo(cx, cy);
            }
            pen.closePath();
        }
        pen.strokeStyle = "rgba(255,255,255,0.45)";
        pen.lineWidth = 0.7;
        pen.stroke();
        pen.restore();
    }

    /// Points in the colours of the map, and where light was measured from.
    #measured(pen: CanvasRenderingContext2D, at: (w: Direction) => readonly [number, number], side: Side, here: boolean): void {
        const [points, scale] = [this.#points, this.#scale];
        if (points && scale && this.#ramp !== DIFFERENCE) {
            const { directions, values } = points;
            const many = values.length > 3000;
            const radius = many ? 0.8 : 2;
            pen.globalAlpha = points.apart ? 0.4 : 1;
            values.forEach((value, k) => {
                const w: Direction = [directions[3 * k]!, directions[3 * k + 1]!, directions[3 * k + 2]!];
                if (sideOf(w) !== side) return;
                const [x, y] = at(w);
                const from = 4 * Math.round(scale.at(value) * 255);
                pen.fillStyle = "#0009";
                if (!many) pen.fillRect(x - radius - 0.7, y - radius - 0.7, 2 * radius + 1.4, 2 * radius + 1.4);
                pen.fillStyle = `rgb(${this.#ramp[from]},${this.#ramp[from + 1]},${this.#ramp[from + 2]})`;
                pen.fillRect(x - radius, y - radius, 2 * radius, 2 * radius);
            });
            pen.globalAlpha = 1;
        }
        if (!here) return;
        pen.strokeStyle = "#ffd84dcc";
        pen.lineWidth = 1;
        for (const w of this.#incidences) {
            const [x, y] = at(w);
            pen.beginPath();
            pen.arc(x, y, 2.5, 0, 2 * Math.PI);
            pen.stroke();
        }
    }

    #grid(pen: CanvasRenderingContext2D, { x, y, radius }: Disk, equalAngles: boolean, ink: string): void {
        pen.lineWidth = 1;
        pen.font = "10px system-ui, sans-serif";
        pen.textAlign = "left";
        for (const theta of RINGS) {
            const r = mapPlace(direction([theta, 0]), equalAngles)[0] * radius;
            pen.beginPath();
            pen.arc(x, y, r, 0, 2 * Math.PI);
            pen.strokeStyle = theta === 90 ? ink : "rgba(255,255,255,0.35)";
            pen.stroke();
            if (theta < 90) {
                pen.strokeStyle = "#000a";
                pen.lineWidth = 2.5;
                pen.strokeText(`${theta}°`, x + 2, y - r - 2);
                pen.lineWidth = 1;
                pen.fillStyle = "#fff";
                pen.fillText(`${theta}°`, x + 2, y - r - 2);
            }
        }
        pen.fillStyle = ink;
        pen.textAlign = "left";
        pen.fillText("φ 0°", x + radius * 0.985 + 2, y + radius * 0.2);
        pen.textAlign = "center";
        pen.fillText("φ 90°", x + radius * 0.32, y - radius * 0.95 - 4);
    }

    #light(pen: CanvasRenderingContext2D, [x, y]: readonly [number, number], here: boolean): void {
        for (const [width, colour] of [[4, "#000"], [2, "#ffd84d"]] as const) {
            pen.beginPath();
            pen.arc(x, y, 7, 0, 2 * Math.PI);
            pen.lineWidth = width;
            pen.strokeStyle = colour;
            pen.setLineDash(here ? [] : [3, 3]);
            pen.stroke();
            pen.setLineDash([]);
        }
    }

    /// A peak of no width has a place and a share of the light, but no f: a diamond.
    #peak(pen: CanvasRenderingContext2D, [x, y]: readonly [number, number], share: number): void {
        const half = 6;
        pen.beginPath();
        for (const [dx, dy] of [[0, -half], [half, 0], [0, half], [-half, 0]] as const) pen.lineTo(x + dx, y + dy);
        pen.closePath();
        pen.fillStyle = "#fff";
        pen.fill();
        pen.lineWidth = 1.5;
        pen.strokeStyle = "#000";
        pen.stroke();
        pen.font = "11px system-ui, sans-serif";
        pen.textAlign = "left";
        pen.lineWidth = 3;
        const text = `${(100 * share).toFixed(share < 0.1 ? 1 : 0)} %`;
        pen.strokeText(text, x + half + 4, y + 4);
        pen.fillText(text, x + half + 4, y + 4);
    }

    #cross(pen: CanvasRenderingContext2D, [x, y]: readonly [number, number]): void {
        for (const [width, colour] of [[4, "#000"], [1.5, "#fff"]] as const) {
            pen.beginPath();
            pen.moveTo(x - 7, y);
            pen.lineTo(x + 7, y);
            pen.moveTo(x, y - 7);
            pen.lineTo(x, y + 7);
            pen.lineWidth = width;
            pen.strokeStyle = colour;
            pen.stroke();
        }
    }

    #bar(pen: CanvasRenderingContext2D, x: number, height: number, ink: string): void {
        const scale = this.#scale;
        if (!scale) return;
        const [top, length] = [26, height - 44];
        const steps = 64;
        for (let k = 0; k < steps; k++) {
            const from = 4 * Math.round(((steps - 1 - k) / (steps - 1)) * 255);
            pen.fillStyle = `rgb(${this.#ramp[from]},${this.#ramp[from + 1]},${this.#ramp[from + 2]})`;
            pen.fillRect(x, top + (k * length) / steps, 10, length / steps + 1);
        }
        pen.fillStyle = ink;
        pen.textAlign = "left";
        pen.font = "10px system-ui, sans-serif";
        pen.fillText(this.#ramp === DIFFERENCE ? "" : "1/sr", x, 14);
        for (const tick of scale.ticks()) {
            const y = top + (1 - scale.at(tick)) * length;
            pen.fillRect(x + 10, y, 3, 1);
            pen.fillText(digits(Number(tick.toPrecision(3)), 3).replace(/\.?0+$/, ""), x + 15, y + 3);
        }
    }

    #find(event: PointerEvent): { disk: Disk; wo: Direction } | null {
        const { left, top } = this.#canvas.getBoundingClientRect();
        const [px, py] = [event.clientX - left, event.clientY - top];
        const equalAngles = this.#page.state.equalAngles;
        for (const disk of this.#disks) {
            const wo = mapDirection((px - disk.x) / disk.radius, (disk.y - py) / disk.radius, disk.side, equalAngles);
            if (wo) return { disk, wo };
        }
        return null;
    }

    #press(event: PointerEvent): void {
        const { left, top } = this.#canvas.getBoundingClientRect();
        const { state, wi } = this.#page;
        const [px, py] = mapPlace(wi, state.equalAngles);
        const onLight = this.#disks.some(({ x, y, radius }) =>
            Math.hypot(event.clientX - left - x - px * radius, event.clientY - top - y + py * radius) < NEAR);
        if (onLight) {
            this.#dragging = true;
            this.#canvas.setPointerCapture(event.pointerId);
            event.preventDefault();
        } else {
            const found = this.#find(event);
            this.#page.pin(found?.wo ?? null);
        }
    }

    #move(event: PointerEvent): void {
        const found = this.#find(event);
        if (!this.#dragging) return this.#page.hover(found?.wo ?? null);
        if (!found) return;
        const [x, y, z] = found.wo;
        // The light stays on its side.
        const up = sideOf(this.#page.wi) === "front" ? Math.abs(z) : -Math.abs(z);
        this.#page.drag(angles([x, y, up]));
    }
}

function clipped(pen: CanvasRenderingContext2D, text: string, width: number): string {
    while (text.length > 4 && pen.measureText(text).width > width) text = `${text.slice(0, -2)}…`;
    return text;
}
