// Files as they come: dropped, chosen, or from where the page is from. Nothing leaves the page.

/// A file's name and content.
export interface Given {
    name: string;
    bytes: Uint8Array;
}

/// What a single file may hold; the core needs as much again.
const MOST_BYTES = 1 << 30;

export async function read(file: File): Promise<Given> {
    if (file.size > MOST_BYTES) {
        throw new Error(`${file.name}: expected at most ${MOST_BYTES} bytes, found ${file.size}`);
    }
    try {
        return { name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) };
    } catch {
        throw new Error(`${file.name}: cannot be read; a folder must be opened file by file`);
    }
}

/// A file at an address relative to the page; of the page's own origin, as its policy demands.
export async function fetched(address: string): Promise<Given> {
    const url = new URL(address, document.baseURI);
    const name = decodeURIComponent(url.pathname.split("/").pop() || address);
    const bad = (why: string) => new Error(`${name}: cannot be loaded from ${address}: ${why}`);
    if (url.origin !== location.origin) throw bad("expected an address beside this page");
    const answer = await fetch(url).catch((e: unknown) => {
        throw bad(e instanceof Error ? e.message : String(e));
    });
    if (!answer.ok) throw bad(`${answer.status} ${answer.statusText}`);
    return { name, bytes: new Uint8Array(await answer.arrayBuffer()) };
}

/// Calls `take` with files that are dropped anywhere on the page.
export function onDrop(take: (files: File[]) => void): void {
    let inside = 0;
    const over = (change: number) => {
        inside = Math.max(0, inside + change);
        document.body.classList.toggle("dropping", inside > 0);
    };
    addEventListener("dragenter", () => over(1));
    addEventListener("dragleave", () => over(-1));
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
        event.preventDefault();
        inside = 0;
        over(0);
        const files = [...(event.dataTransfer?.files ?? [])];
        if (files.length > 0) take(files);
    });
}
