// What panels may ask of the page and tell it.
import type { Angles, Direction } from "./core.js";
import type { State } from "./state.js";

export interface Page {
    readonly state: State;
    readonly wi: Direction;
    /// The pointer is over a scattered direction, or over none.
    hover(wo: Direction | null): void;
    /// A scattered direction is kept in view, or none.
    pin(wo: Direction | null): void;
    /// The light is moved by hand.
    drag(incident: Angles): void;
    /// What shows the state otherwise than by numbers is to be drawn again.
    redraw(): void;
}
