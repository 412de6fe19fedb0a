// A lit object, finer and finer while nothing moves.
import { element } from "../elements.js";
import type { Query, Subject } from "../subject.js";

/// Pixels along a side, one picture after the other.
const SIZES = [64, 192, 384];
/// How long a turn may take, ms: what is left of a frame.
const TURN = 8;

/// What is said of an object that is black all over, as one that transmits alone: light from behind does not get through a sphere.
const DARK = {
    sphere: "black: nothing of this light is reflected; drape and plane show what is transmitted",
    drape: "black: nothing of this light comes to the eye; light the other side",
    plane: "black: nothing of this light comes to the eye; light the other side",
};

interface Picture {
    canvas: HTMLCanvasElement;
    title: HTMLElement;
    box: HTMLElement;
    dark: HTMLElement;
}

export class LitPanel {
    readonly root = element("section", { className: "panel lit" });
    readonly #pictures: Picture[] = [];
    #turn = 0;
    #shown = "";

    /// Draws anew where what is lit, or how, has changed; only the coarsest picture while something moves.
    show(query: Query, subjects: readonly Subject[], moving: boolean): void {
        const { state } = query;
        const asked = JSON.stringify([moving, state.shape, state.incident, state.exposure, state.band, state.smooth, subjects.map((s) => s.number)]);
        if (asked === this.#shown) return;
        this.#shown = asked;
        clearTimeout(this.#turn);
        while (this.#pictures.length > subjects.length) this.#pictures.pop()!.box.remove();
        while (this.#pictures.length < subjects.length) this.#pictures.push(this.#add());
        this.#pictures.forEach(({ title, canvas }, n) => {
            title.textContent = subjects.length > 1 ? `${"AB"[n]} ${subjects[n]!.name}` : "";
            canvas.setAttribute("aria-label", `${state.shape} of ${subjects[n]!.name}, lit from the incident direction`);
        });
        const work = paint(query, subjects, this.#pictures);
        const turn = () => {
            const started = performance.now();
            while (performance.now() - started < TURN) if (work.next().done) return;
            this.#turn = window.setTimeout(turn, 0);
        };
        if (moving) work.next();
        else this.#turn = window.setTimeout(turn, 0);
    }

    #add(): Picture {
        const canvas = element("canvas");
        const title = element("figcaption");
        const dark = element("p", { className: "dark", hidden: true });
        const box = element("figure", {}, canvas, title, dark);
        this.root.append(box);
        return { canvas, title, box, dark };
    }
}

/// Pictures of all files, coarse ones first; yields after each few rows.
function* paint(query: Query, subjects: readonly Subject[], pictures: readonly Picture[]): Generator<void> {
    for (const size of SIZES) {
        const rows = Math.max(1, Math.floor(2048 / size));
        for (const [n, subject] of subjects.entries()) {
            const pixels = new ImageData(size, size);
            for (let first = 0; first < size; first += rows) {
                pixels.data.set(query.scene(subject, query.state.exposure, size, first, rows), 4 * size * first);
                if (size > SIZES[0]!) yield;
            }
            const { canvas, dark } = pictures[n]!;
            dark.hidden = !isBlack(pixels.data);
            dark.textContent = DARK[query.state.shape];
            canvas.width = canvas.height = size;
            canvas.getContext("2d")!.putImageData(pixels, 0, 0);
        }
        yield;
    }
}

/// Whether there is an object, and it is black all over.
function isBlack(pixels: Uint8ClampedArray): boolean {
    let black = 0;
    for (let k = 0; k < pixels.length; k += 4) {
        if (pixels[k + 3] === 0) continue;
        if (Math.max(pixels[k]!, pixels[k + 1]!, pixels[k + 2]!) > 0) return false;
        black++;
    }
    return black > 0;
}
