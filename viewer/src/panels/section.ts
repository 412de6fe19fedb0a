// A slice: f in a plane through the normal, polar.
import { type Angles, type Direction, type Side, direction } from "../core.js";
import { FILES, type Scale } from "../colours.js";
import { element, fit } from "../elements.js";
import { degrees, digits } from "../numbers.js";
import type { Seen } from "../measured.js";
import type { Page } from "../page.js";
import type { Query, Subject } from "../subject.js";

export class SectionPanel {
    readonly root: HTMLElement;
    readonly #canvas = element("canvas", { tabIndex: 0 });
    #curves: Float32Array[] = [];
    #scale: Scale | null = null;
    #phi = 0;
    #centre: readonly [number, number, number] = [0, 0, 1];
    #sides: readonly Side[] = [];
    #points: InPlane[] = [];

    constructor(page: Page) {
        this.#canvas.setAttribute("aria-label", "Slice of scattered light in a plane through the normal");
        this.root = element("section", { className: "panel slice" }, this.#canvas);
        this.#canvas.addEventListener("pointermove", (e) => page.hover(this.#find(e)));
        this.#canvas.addEventListener("pointerdown", (e) => page.pin(this.#find(e)));
        this.#canvas.addEventListener("pointerleave", () => page.hover(null));
    }

    /// `steps` values round each slice.
    compute(query: Query, subjects: readonly Subject[], seen: ReadonlyMap<Side, Seen>, sides: readonly Side[], scale: Scale, steps: number): void {
        this.#phi = azimuth(query.state.slice, query.state.incident);
        this.#scale = scale;
        this.#sides = sides;
        this.#points = [...seen.values()].flatMap((points) => inPlane(points, this.#phi));
        this.#curves = subjects.map((subject) => query.section(subject, this.#phi, steps));
    }

    draw(query: Query, hovered: Direction | null): void {
        const { width, height, pen } = fit(this.#canvas);
        const ink = getComputedStyle(this.#canvas).color;
        const scale = this.#scale;
        if (!scale) return;
        const [above, below] = [this.#sides.includes("front") || this.#sides.length === 0, this.#sides.includes("back")];
        const room = 26;
        const radius = Math.max(10, Math.min(width / 2 - 40, (height - 2 * room) / (above && below ? 2 : 1)));
        const x = width / 2;
        const y = above && below ? height / 2 : above ? height - room - (height - 2 * room - radius) / 2 : room + (height - 2 * room - radius) / 2;
        this.#centre = [x, y, radius];
        pen.font = "10px system-ui, sans-serif";
        // Angles.
        pen.lineWidth = 1;
        pen.strokeStyle = ink;
        pen.fillStyle = ink;
        for (let theta = -180; theta < 180; theta += 30) {
            const cos = Math.cos((theta * Math.PI) / 180);
            if ((cos > 1e-9 && !above) || (cos < -1e-9 && !below)) continue;
            const [dx, dy] = [Math.sin((theta * Math.PI) / 180), -cos];
            pen.globalAlpha = 0.25;
            stroke(pen, [x, y], [x + dx * radius, y + dy * radius]);
            pen.globalAlpha = 0.9;
            pen.textAlign = dx > 0.01 ? "left" : dx < -0.01 ? "right" : "center";
            const label = theta === -180 ? "180°" : `${Math.abs(theta)}°`;
            pen.fillText(label, x + dx * (radius + 5), y + dy * (radius + 5) + (dy > 0.5 ? 8 : 3));
        }
        // Values.
        const [from, to] = [above ? Math.PI : 0, above && !below ? 2 * Math.PI : below && !above ? Math.PI : 3 * Math.PI];
        for (const tick of [...scale.ticks(), scale.top]) {
            const r = scale.at(tick) * radius;
            if (r < 2) continue;
            pen.globalAlpha = tick === scale.top ? 0.6 : 0.25;
            pen.beginPath();
            pen.arc(x, y, r, from, to);
            pen.stroke();
            pen.globalAlpha = 0.8;
            pen.textAlign = "left";
            if (r < radius - 14 && r > 12) {
                const up = above ? -1 : 1;
                pen.fillText(digits(Number(tick.toPrecision(3)), 3).replace(/(\.\d*?)0+$/, "$1").replace(/\.$/, ""), x + 3, y + up * r - 2);
            }
        }
        pen.globalAlpha = 1;
        stroke(pen, [x - radius, y], [x + radius, y]);
        // Curves.
        this.#curves.forEach((curve, file) => {
            pen.strokeStyle = FILES[file]!;
            pen.lineWidth = 2;
            pen.setLineDash(file === 1 ? [6, 4] : []);
            pen.beginPath();
            let drawing = false;
            curve.forEach((value, k) => {
                const turn = ((k + 0.5) / curve.length) * 2 * Math.PI;
                const cos = Math.cos(turn);
                const shown = (cos > 0 ? above : below) && !Number.isNaN(value);
                const r = scale.at(value) * radius;
                const [px, py] = [x + Math.sin(turn) * r, y - cos * r];
                if (!shown) drawing = false;
                else if (drawing) pen.lineTo(px, py);
                else {
                    pen.moveTo(px, py);
                    drawing = true;
                }
            });
            pen.stroke();
            pen.setLineDash([]);
        });
        [pen.fillStyle, pen.strokeStyle] = [ink, ink];
        pen.lineWidth = 0.6;
        for (const { turn, value, apart } of this.#points) {
            const cos = Math.cos(turn);
            if (cos > 0 ? !above : !below) continue;
            const r = scale.at(value) * radius;
            pen.beginPath();
            pen.arc(x + Math.sin(turn) * r, y - cos * r, 2, 0, 2 * Math.PI);
            if (apart) pen.stroke();
            else pen.fill();
        }
        // The light and what is pointed at, in this plane.
        pen.lineWidth = 2;
        this.#ray(pen, query.wi, "#e0b400", true);
        if (hovered) this.#ray(pen, hovered, ink, false);
        pen.fillStyle = ink;
        pen.textAlign = "left";
        pen.font = "12px system-ui, sans-serif";
        pen.fillText("slice, 1/sr", 8, 16);
        pen.font = "10px system-ui, sans-serif";
        pen.fillText(`φ ${degrees((this.#phi + 180) % 360)}`, Math.max(4, x - radius - 46), y + 16);
        pen.textAlign = "right";
        pen.fillText(`φ ${degrees(this.#phi)}`, Math.min(width - 4, x + radius + 46), y + 16);
    }

    /// A direction within half a degree of the plane.
    #ray(pen: CanvasRenderingContext2D, w: Direction, colour: string, whole: boolean): void {
        const [ux, uy] = direction([90, this.#phi]);
        const along = w[0] * ux + w[1] * uy;
        const apart = Math.abs(w[1] * ux - w[0] * uy);
        if (apart > 0.01) return;
        const [x, y, radius] = this.#centre;
        pen.strokeStyle = colour;
        pen.setLineDash(whole ? [] : [2, 3]);
        stroke(pen, [x, y], [x + along * radius, y - w[2] * radius]);
        pen.setLineDash([]);
    }

    #find(event: PointerEvent): Direction | null {
        const { left, top } = this.#canvas.getBoundingClientRect();
        const [x, y, radius] = this.#centre;
        const [dx, dy] = [event.clientX - left - x, y - (event.clientY - top)];
        if (Math.hypot(dx, dy) > radius || Math.hypot(dx, dy) < 2 || !this.#sides.includes(dy > 0 ? "front" : "back")) return null;
        const theta = (Math.atan2(Math.abs(dx), dy) * 180) / Math.PI;
        return direction([theta, dx < 0 ? this.#phi + 180 : this.#phi]);
    }
}

/// The azimuth to the right: that of scattered light ahead of the incident.
export function azimuth(slice: number | null, incident: Angles): number {
    return (((slice ?? incident[1] + 180) % 360) + 360) % 360;
}

/// A point in the plane: where in it, f, whether it is of other light.
interface InPlane {
    turn: number;
    value: number;
    apart: boolean;
}

/// How far a point may lie from the plane that it is drawn in: the sine of 1 degree.
const BESIDE = 0.0175;

/// Points near the plane of azimuth `phi`, by the angle from the front normal toward it.
function inPlane({ directions, values, apart }: Seen, phi: number): InPlane[] {
    const [ux, uy] = direction([90, phi]);
    const found: InPlane[] = [];
    values.forEach((value, k) => {
        const [x, y, z] = [directions[3 * k]!, directions[3 * k + 1]!, directions[3 * k + 2]!];
        if (Math.abs(y * ux - x * uy) < BESIDE) found.push({ turn: Math.atan2(x * ux + y * uy, z), value, apart });
    });
    return found;
}

function stroke(pen: CanvasRenderingContext2D, [ax, ay]: [number, number], [bx, by]: [number, number]): void {
    pen.beginPath();
    pen.moveTo(ax, ay);
    pen.lineTo(bx, by);
    pen.stroke();
}

