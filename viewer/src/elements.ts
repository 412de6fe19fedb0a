// Elements of the page. Text from files is set as text, never as markup.

type Child = Node | string | null | undefined;
type Properties<T> = Partial<Omit<T, "style" | "dataset">> & { data?: Record<string, string> };

export function element<K extends keyof HTMLElementTagNameMap>(
    tag: K,
    properties: Properties<HTMLElementTagNameMap[K]> = {},
    ...children: Child[]
): HTMLElementTagNameMap[K] {
    const made = document.createElement(tag);
    const { data, ...rest } = properties;
    Object.assign(made, rest);
    Object.assign(made.dataset, data ?? {});
    made.append(...children.filter((child): child is Node | string => child != null));
    return made;
}

/// A canvas as large as its element, in pixels of the screen; draws in CSS pixels.
export function fit(canvas: HTMLCanvasElement): { width: number; height: number; pen: CanvasRenderingContext2D } {
    const density = Math.min(devicePixelRatio || 1, 2);
    const { clientWidth: width, clientHeight: height } = canvas;
    const [w, h] = [Math.max(1, Math.round(width * density)), Math.max(1, Math.round(height * density))];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    const pen = canvas.getContext("2d")!;
    pen.setTransform(density, 0, 0, density, 0, 0);
    pen.clearRect(0, 0, width, height);
    return { width, height, pen };
}
