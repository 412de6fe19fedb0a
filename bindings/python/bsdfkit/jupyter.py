"""The viewer within a notebook: `pip install 'bsdfkit[jupyter]'`.

    import bsdfkit.jupyter
    bsdfkit.jupyter.Viewer("fabric.xml", incident=(45, 0))

The page of `bsdf view` in a frame of its own, which runs scripts but knows nothing of the notebook around it; files go to the
browser with the notebook's own connection, so that it works where the kernel is on another machine.
"""

import tempfile
import urllib.parse
import urllib.request
from pathlib import Path
from typing import Any

from . import Bsdf, direction, view, viewer_page
from ._errors import ArgumentError

try:
    import anywidget
    import traitlets
except ImportError:
    raise ImportError(
        "the viewer in notebooks: expected the package anywidget, found none: pip install 'bsdfkit[jupyter]'"
    ) from None

#: The frame asks for files once it listens, and tells of changes; nothing else in the notebook hears or is heard.
_ESM = """
export default {
    render({ model, el }) {
        const frame = document.createElement("iframe");
        frame.setAttribute("sandbox", "allow-scripts allow-downloads");
        frame.title = "bsdfkit viewer";
        frame.style.cssText = "width: 100%; border: 1px solid #8884; border-radius: 6px";
        frame.style.height = `${model.get("height")}px`;
        frame.srcdoc = model.get("_page");
        const hand = (handed) => frame.contentWindow?.postMessage({ bsdfkit: handed }, "*");
        const files = () => model.get("_files").map(([name, bytes]) => ({
            name, bytes: bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength),
        }));
        let state = model.get("state");
        const heard = ({ source, data }) => {
            if (source !== frame.contentWindow || !data?.bsdfkit) return;
            if (data.bsdfkit.ready) hand({ state, files: files() });
            if (typeof data.bsdfkit.state === "string" && data.bsdfkit.state !== state) {
                state = data.bsdfkit.state;
                model.set("state", state);
                model.save_changes();
            }
        };
        const changed = () => {
            if (model.get("state") === state) return;
            state = model.get("state");
            hand({ state });
        };
        addEventListener("message", heard);
        model.on("change:state", changed);
        el.append(frame);
        return () => {
            removeEventListener("message", heard);
            model.off("change:state", changed);
        };
    },
};
"""


class Viewer(anywidget.AnyWidget):
    """Files, BSDFs or interpolants in the viewer: one, two to compare, and folders of measured points.

    `state` says what is shown, as in the viewer's links ("incident=45,0&colours=grey"), and follows what is done by hand;
    `incident` is the light of it.
    """

    _esm = _ESM
    _page = traitlets.Unicode().tag(sync=True)
    _files: Any = traitlets.List().tag(sync=True)
    state = traitlets.Unicode().tag(sync=True)
    height = traitlets.Int(640).tag(sync=True)

    def __init__(self, *shown: Any, incident: Any = None, state: str = "", height: int = 640) -> None:
        """Shows what is given.

        Args:
            shown: Paths of files and of folders of measurements; `Bsdf`, `Interpolant`.
            incident: (theta, phi) in degrees of the light.
            state: More of what a link says.
            height: Pixels.

        Raises:
            ArgumentError: Nothing to show, or a build without the viewer's page.
            IoError, FormatError: As of `bsdfkit.view`.
        """
        if not shown:
            raise ArgumentError("viewer: expected a file, a BSDF or an interpolant, found nothing")
        if incident is not None:
            state = _with_incident(state, incident)
        super().__init__(_page=viewer_page(), _files=_files_of(shown), state=state, height=height)

    @property
    def incident(self) -> tuple[float, float]:
        """(theta, phi) in degrees of the light."""
        given = urllib.parse.parse_qs(self.state).get("incident", ["30,0"])[-1]
        theta, phi = (float(angle) for angle in given.split(","))
        return theta, phi

    @incident.setter
    def incident(self, angles: Any) -> None:
        self.state = _with_incident(self.state, angles)


def _with_incident(state: str, angles: Any) -> str:
    theta, phi = (float(angle) for angle in angles)
    direction(theta, phi)
    others = [(key, value) for key, value in urllib.parse.parse_qsl(state) if key != "incident"]
    return urllib.parse.urlencode([*others, ("incident", f"{theta:g},{phi:g}")], safe=",")


def _files_of(shown: Any) -> list[tuple[str, bytes]]:
    """What the viewer is handed of each: bytes that it reads, under a name."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [_saved(what, Path(folder), n) if isinstance(what, Bsdf) else Path(what) for n, what in enumerate(shown)]
        # The server knows how folders of measurements are packed.
        with view(paths, browser=False) as viewer:
            base, _, hash = viewer.link.partition("#")
            addresses = urllib.parse.parse_qs(hash)["open"]
            names = [urllib.parse.unquote(address.rsplit("/", 1)[-1]) for address in addresses]
            found = []
            for name, address in zip(names, addresses):
                quoted = "/".join(urllib.parse.quote(part, safe="") for part in address.split("/"))
                with urllib.request.urlopen(base + quoted) as answer:
                    found.append((name, answer.read()))
            return found


def _saved(bsdf: Any, folder: Path, n: int) -> Path:
    path = folder / f"{chr(ord('A') + n)}.safetensors"
    bsdf.save(path)
    return path
