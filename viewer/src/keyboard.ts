// Keys, and the list of them.
import type { State, Store } from "./state.js";

export const KEYS: readonly (readonly [string, string])[] = [
    ["arrows", "light by 1°; with Shift by 10°"],
    ["b", "light on the other side"],
    ["r, t", "reflected, transmitted light on or off"],
    ["m", "map of reflected or transmitted light"],
    ["l", "logarithmic or linear"],
    ["+, −", "exposure"],
    ["[, ]", "decades"],
    ["c", "colours"],
    ["g", "leaves or patches"],
    ["s", "trees smooth or leaf by leaf"],
    ["p", "measured points"],
    ["n", "light to the nearest measured incidence"],
    ["d", "what is compared"],
    ["o", "object"],
    ["Esc", "let go of the direction that is kept"],
    ["?", "these keys"],
];

const next = <T>(choices: readonly T[], now: T): T => choices[(choices.indexOf(now) + 1) % choices.length]!;

function change(event: KeyboardEvent, state: State): Partial<State> | null {
    const [theta, phi] = state.incident;
    const step = event.shiftKey ? 10 : 1;
    switch (event.key) {
        case "ArrowUp": return { incident: [theta - step, phi] };
        case "ArrowDown": return { incident: [theta + step, phi] };
        case "ArrowLeft": return { incident: [theta, (phi + step) % 360] };
        case "ArrowRight": return { incident: [theta, (phi - step + 360) % 360] };
        case "b": return { incident: [180 - theta, phi] };
        case "r": return { reflection: !state.reflection };
        case "t": return { transmission: !state.transmission };
        case "m": return { map: next(["reflection", "transmission"] as const, state.map) };
        case "l": return { log: !state.log };
        case "+": case "=": return { exposure: state.exposure + 0.5 };
        case "-": return { exposure: state.exposure - 0.5 };
        case "[": return { decades: Math.max(1, (state.decades || 4) - 1) };
        case "]": return { decades: (state.decades || 3) + 1 };
        case "c": return { colours: next(["viridis", "cividis", "grey"] as const, state.colours) };
        case "g": return { cells: !state.cells };
        case "s": return { smooth: !state.smooth };
        case "p": return { points: !state.points };
        case "d": return { compare: next(["both", "a", "b", "difference"] as const, state.compare) };
        case "o": return { shape: next(["sphere", "drape", "plane"] as const, state.shape) };
        case "Escape": return { pinned: null };
        default: return null;
    }
}

export function listen(store: Store, help: () => void, snap: () => void): void {
    addEventListener("keydown", (event) => {
        const typing = event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement;
        if ((typing && event.key !== "Escape") || event.ctrlKey || event.metaKey || event.altKey) return;
        if (event.key === "?") return help();
        if (event.key === "n") return snap();
        const changed = change(event, store.get());
        if (!changed) return;
        event.preventDefault();
        store.set(changed);
    });
}
