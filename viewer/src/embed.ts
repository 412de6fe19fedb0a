// The page within another: a notebook hands it files and the state, and is told of changes. Nobody else is listened to.
import type { Given } from "./files.js";

/// What the page around this one may send, under the name `bsdfkit`.
export interface Handed {
    /// The state, as in a link.
    state?: string;
    files?: Given[];
}

/// Whether there is a page around this one.
export const embedded = parent !== window;

/// Calls `take` with what the page around hands over, which is told once that it may.
export function listenAround(take: (handed: Handed) => void): void {
    if (!embedded) return;
    addEventListener("message", (event: MessageEvent<{ bsdfkit?: Handed } | null>) => {
        const handed = event.source === parent ? event.data?.bsdfkit : undefined;
        if (handed) take(handed);
    });
    parent.postMessage({ bsdfkit: { ready: true } }, "*");
}

/// Tells the page around what is shown: angles and choices, nothing of the files.
export function tellAround(state: string): void {
    parent.postMessage({ bsdfkit: { state } }, "*");
}
