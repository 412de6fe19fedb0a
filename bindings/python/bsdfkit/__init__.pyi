import enum
from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Literal, NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import disjoint_base

__all__ = [
    "ArgumentError",
    "Bsdf",
    "Component",
    "Components",
    "Error",
    "FileWarning",
    "Finding",
    "FormatError",
    "Interpolant",
    "IoError",
    "LimitError",
    "Measurement",
    "Metadata",
    "Part",
    "Proposal",
    "Sample",
    "Specular",
    "Traced",
    "Validation",
    "Viewer",
    "angles",
    "check",
    "direction",
    "fit",
    "geometry_klems",
    "materials",
    "open",
    "read",
    "report",
    "simulate",
    "simulate_geometry",
    "view",
    "view_weights",
    "viewer_page",
    "__version__",
]

__version__: str

_Path = str | PathLike[str]
_Progress = bool | Callable[[int, int], object] | None
_Numbers = Any
"""NDArray[np.float64] of the broadcast shape, or np.float64 where that has no axis."""
_Material = float | _Path | dict[str, Any]
_Symmetry = Literal[
    "isotropic",
    "quadrilateral",
    "bilateral",
    "bilateral-x",
    "bilateral-y",
    "rotational180",
    "none",
]
_Kind = Literal["tensor-tree", "klems-full", "klems-half", "klems-quarter", "render"]

_Program = Literal["radiance", "window", "energyplus", "frads", "honeybee", "mitsuba"]

class Error(Exception):
    """Any error of this library; exactly one of the four classes below."""

class IoError(Error, OSError):
    """The operating system refused."""

class FormatError(Error, ValueError):
    """A file's content is wrong."""

class ArgumentError(Error, ValueError):
    """The caller's argument is wrong."""

class LimitError(Error):
    """Well-formed, but larger than a documented limit."""

class FileWarning(UserWarning):
    """A file was read, but something in it is questionable."""

class Components(enum.IntFlag):
    """Which parts of a BSDF a query concerns: sense by kind by side of the incident direction."""

    REFLECTION = ...
    TRANSMISSION = ...
    NON_LAMBERTIAN = ...
    LAMBERTIAN = ...
    SPECULAR = ...
    DIRECTIONAL_DIFFUSE = ...
    FRONT = ...
    BACK = ...
    ALL = ...
    NONE = ...

class Part(enum.IntEnum):
    """Names of the negative numbers in ``Sample.part``."""

    LAMBERTIAN_REFLECTION = ...
    LAMBERTIAN_TRANSMISSION = ...
    NOTHING = ...
    SPECULAR = ...

class Specular(NamedTuple):
    """A family of peaks of no width: uo = A ui + g in direction cosines."""

    incident: str
    scattered: str
    name: str
    linear: list[list[float]]
    offset: list[float]
    width_degrees: float
    residual: float | None

class Sample(NamedTuple):
    """Drawn directions (..., 3), weights (...), densities in 1/sr (...), parts drawn from (...)."""

    wo: NDArray[np.float64]
    weight: _Numbers
    pdf: _Numbers
    part: _Numbers

class Proposal(NamedTuple):
    """An incident direction to measure next: unit vector, errors to expect, where to scan densely."""

    wi: tuple[float, float, float]
    expected_l1: float
    mean_l1: float
    regions: list[tuple[tuple[float, float, float], float]]

class Traced(NamedTuple):
    """What `simulate_geometry` wrote: files, held-out incidences, noise (L1), least and largest share that left again."""

    files: list[Path]
    held_out: Path | None
    noise: float
    energy: tuple[float, float]

class Finding(NamedTuple):
    """Something wrong with a file: what, where, which programs it breaks and how, what to do."""

    code: str
    place: str
    text: str
    programs: dict[str, tuple[Literal["limited", "refuses", "wrong"], str]]
    to_do: str
    mended: Literal["always", "for", "asked", "never"]

@final
class Metadata:
    """Description of a specimen; lengths in metres, 0 when not given."""

    @property
    def name(self) -> str: ...
    @property
    def manufacturer(self) -> str: ...
    @property
    def width(self) -> float: ...
    @property
    def height(self) -> float: ...
    @property
    def thickness(self) -> float: ...
    @property
    def geometry(self) -> str | None: ...
    @property
    def comments(self) -> list[str]: ...
    @property
    def properties(self) -> list[tuple[str, str]]: ...

@final
class Component:
    """One stored distribution, and the pair of sides it belongs to."""

    @property
    def incident(self) -> Literal["front", "back"]: ...
    @property
    def scattered(self) -> Literal["front", "back"]: ...
    @property
    def representation(self) -> Literal["tree3", "tree4", "matrix", "transport", "sir", "tables"]: ...
    @property
    def coloured(self) -> bool: ...
    @property
    def incidences(self) -> int | None: ...
    @property
    def leaves(self) -> int | None: ...
    @property
    def expected_error(self) -> float | None: ...

@disjoint_base
class Bsdf:
    """A BSDF of trees, matrices or continuous functions: immutable, shared by any number of threads."""

    @property
    def components(self) -> tuple[Component, ...]: ...
    @property
    def lambertian(self) -> NDArray[np.float64]: ...
    @property
    def metadata(self) -> Metadata: ...
    def eval(
        self,
        wi: ArrayLike,
        wo: ArrayLike,
        *,
        xyz: bool = False,
        components: Components | int | None = None,
    ) -> _Numbers:
        """f(wi, wo) in 1/sr, without cosine: (..., 3), (..., 3) -> (...), or (..., 3) with xyz."""

    def pdf(
        self, wi: ArrayLike, wo: ArrayLike, *, components: Components | int | None = None
    ) -> _Numbers:
        """Density with which ``sample`` draws wo, 1/sr: (..., 3), (..., 3) -> (...)."""

    def eval_pdf(
        self, wi: ArrayLike, wo: ArrayLike, *, components: Components | int | None = None
    ) -> tuple[_Numbers, _Numbers]:
        """Value and density of sampling at once, 1/sr: (..., 3), (..., 3) -> (...), (...)."""

    def directional_hemispherical(
        self, wi: ArrayLike, *, components: Components | int | None = None
    ) -> _Numbers:
        """∫ f |cos θo| dωo, dimensionless: (..., 3) -> (...)."""

    @property
    def wavelengths(self) -> list[float] | None:
        """Wavelengths in nm of the bands of a spectral measurement, shortest first; None of any other."""

    def eval_bands(self, wi: ArrayLike, wo: ArrayLike) -> NDArray[np.float64]:
        """f(wi, wo) in 1/sr of every band: (..., 3), (..., 3) -> (..., bands)."""

    def directional_hemispherical_bands(
        self, wi: ArrayLike, *, components: Components | int | None = None
    ) -> NDArray[np.float64]:
        """∫ f |cos θo| dωo of every band, dimensionless: (..., 3) -> (..., bands)."""

    def projected_solid_angle(
        self, wi: ArrayLike, wo: ArrayLike | None = None
    ) -> NDArray[np.float64]:
        """Smallest and largest projected solid angle of the cells, sr: (..., 3) -> (..., 2)."""

    def sample(
        self, wi: ArrayLike, u: ArrayLike, *, components: Components | int | None = None
    ) -> Sample:
        """Draws scattered directions, each from one number: (..., 3), (...) -> Sample."""

    def sample2(
        self, wi: ArrayLike, u: ArrayLike, *, components: Components | int | None = None
    ) -> Sample:
        """Draws scattered directions, each from two numbers: (..., 3), (..., 2) -> Sample."""

    def cells(
        self, wi: Sequence[float], scattered: Literal["front", "back"]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
        """Middles (N, 3), outlines (N, 32, 3) and numbers (N,) of the stored cells that light from wi meets."""

    def peaks(
        self, wi: Sequence[float], scattered: Literal["front", "back"]
    ) -> list[dict[str, Any]]:
        """Peaks of f |cos θo|: place, height and widths."""

    def reciprocity_defect(
        self, incident: Literal["front", "back"], scattered: Literal["front", "back"]
    ) -> float | None:
        """How far f(wi, wo) is from f(wo, wi): 0 reciprocal, 1 one way only."""

    def plot(self, kind: str = "hemisphere", **options: Any) -> Any:
        """Draws a picture: a matplotlib figure."""

    @property
    def specular(self) -> tuple[Specular, ...]: ...
    def specular_peaks(
        self, wi: ArrayLike, *, components: Components | int | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Where light of each peak of no width goes, and its XYZ coefficient: (..., 3) -> (..., K, 3) twice."""

    def with_peaks_in_cells(self) -> Bsdf:
        """The same light with peaks of no width spread over the narrowest cells."""

    def with_peaks_extracted(self) -> Bsdf:
        """The same light with peaks of no width taken out of narrow cells."""

    @property
    def bands(self) -> list[str]: ...
    def band(self, name: str) -> Bsdf:
        """A further band alone, in the place of the visible one."""

    def tabulate(
        self,
        kind: _Kind | None = None,
        *,
        consumer: Literal["window", "energyplus", "radiance"] | None = None,
        max_error: float | None = None,
        max_leaves: int | None = None,
        max_depth: int | None = None,
        reciprocity: Literal["auto", "on", "off"] | None = None,
        name: str | None = None,
        manufacturer: str | None = None,
        thickness: float | None = None,
        width: float | None = None,
        height: float | None = None,
        properties: dict[str, str] | None = None,
        progress: _Progress = None,
    ) -> Bsdf:
        """The same light as a tensor tree or a Klems matrix, for a program that reads it."""

    def save(self, path: _Path, *, digits: int | None = None) -> None:
        """Writes .xml, .safetensors, _rgb.bsdf or _spec.bsdf."""

    def to_xarray(
        self,
        *,
        theta_i: ArrayLike = ...,
        phi_i: ArrayLike = ...,
        theta_o: ArrayLike = ...,
        phi_o: ArrayLike = ...,
        xyz: bool = False,
    ) -> Any:
        """Values on a grid of angles (degrees) as an xarray.DataArray."""

@final
class Validation:
    """Every measured incidence of one pair of sides, predicted from the others."""

    @property
    def incident(self) -> Literal["front", "back"]: ...
    @property
    def scattered(self) -> Literal["front", "back"]: ...
    @property
    def wi(self) -> NDArray[np.float64]: ...
    @property
    def l1(self) -> NDArray[np.float64]: ...
    @property
    def fit_l1(self) -> NDArray[np.float64]: ...
    @property
    def noise_l1(self) -> NDArray[np.float64]: ...
    @property
    def hemispherical_error(self) -> NDArray[np.float64]: ...
    @property
    def peak_offset_degrees(self) -> NDArray[np.float64]: ...
    @property
    def peak_height_ratio(self) -> NDArray[np.float64]: ...
    @property
    def extrapolated(self) -> list[bool]: ...
    def expected(self, wi: ArrayLike) -> _Numbers:
        """L1 to expect of the interpolant that has all incidences: (..., 3) -> (...)."""

@final
class Interpolant(Bsdf):
    """A continuous BSDF over all directions, made of measurements; answers what ``Bsdf`` does."""

    def seen_as(self, view: str) -> Interpolant:
        """The same material, of which queries and tables have what ``view`` makes of its bands."""

    def validate(
        self, paths: _Path | Sequence[_Path] | None = None, *, progress: _Progress = None
    ) -> list[Validation]:
        """Predicts every measured incidence from the others."""

    def plan(
        self,
        budget: int = 6,
        *,
        paths: _Path | Sequence[_Path] | None = None,
        max_theta_degrees: float | None = None,
        spacing_degrees: float = 4.0,
        progress: _Progress = None,
    ) -> list[Proposal]:
        """Proposes the next incident directions to measure, most useful first."""

    def tabulate(
        self,
        kind: _Kind | None = None,
        *,
        consumer: Literal["window", "energyplus", "radiance"] | None = None,
        max_error: float | None = None,
        max_leaves: int | None = None,
        max_depth: int | None = None,
        reciprocity: Literal["auto", "on", "off"] | None = None,
        name: str | None = None,
        manufacturer: str | None = None,
        thickness: float | None = None,
        width: float | None = None,
        height: float | None = None,
        properties: dict[str, str] | None = None,
        progress: _Progress = None,
    ) -> Bsdf:
        """The same light as a tensor tree or a Klems matrix, for a program that reads it."""

    def fitted(
        self, incident: Literal["front", "back"], scattered: Literal["front", "back"]
    ) -> dict[str, Any]:
        """What was fitted for one pair of sides: incidences, errors, mesh."""

    def families(
        self,
        wi: ArrayLike,
        incident: Literal["front", "back"],
        scattered: Literal["front", "back"],
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Where the families of peaks are: centres and covariances, each (..., K, 3)."""

    def coverage(
        self,
        wi: ArrayLike,
        wo: ArrayLike,
        incident: Literal["front", "back"],
        scattered: Literal["front", "back"],
    ) -> Any:
        """How values were come by: 0 measured, 1 interpolated, 2 extrapolated."""

    def save(self, path: _Path, *, compact: bool = False) -> None:  # type: ignore[override]
        """Writes .safetensors."""

def open(
    path: _Path, *, in_place: bool = True, smooth: bool = False
) -> Bsdf | Interpolant:
    """Opens a BSDF (XML, compiled), an interpolant, or tables of RGL, MERL or Zemax; the file's content tells which."""

def check(path: _Path, *, program: _Program | None = None) -> list[Finding]:
    """What is wrong with an XML file, which programs that breaks and how."""

def fit(
    paths: _Path | Sequence[_Path],
    *,
    symmetry: _Symmetry | None = None,
    grazing_limit_degrees: float | None = None,
    reversed: bool = False,
    cache: _Path | None = None,
    aperture_degrees: float | None = None,
    signature: _Path | None = None,
    memory: float = 4.0,
    progress: _Progress = None,
) -> Interpolant:
    """Fits a continuous BSDF to goniophotometer files and folders of one specimen."""

@final
class Measurement:
    """One pair of sides of a specimen as measured."""

    @property
    def incident(self) -> Literal["front", "back"]: ...
    @property
    def scattered(self) -> Literal["front", "back"]: ...
    @property
    def name(self) -> str: ...
    @property
    def symmetry(self) -> str: ...
    @property
    def colorimetry(self) -> str: ...
    @property
    def luminance_channel(self) -> int: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def wi(self) -> NDArray[np.float64]: ...
    def points(self, incidence: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(wo, f) of one incidence: (M, 3) and (M,), 1/sr without cosine."""

    def nearest(self, wi: Sequence[float]) -> tuple[int, float, list[list[float]]]:
        """The incidence nearest to a direction, how far it is in degrees, and what takes it there."""

    def quality(self) -> dict[str, Any]:
        """Coverage and noise of every incidence."""

    def plot(self, kind: str = "hemisphere", **options: Any) -> Any:
        """Draws a picture: a matplotlib figure."""

def read(
    paths: _Path | Sequence[_Path], *, symmetry: _Symmetry | None = None, reversed: bool = False
) -> list[Measurement]:
    """Reads goniophotometer files as they are, one Measurement for each pair of sides."""

def report(
    path: _Path,
    output: _Path | None = None,
    *,
    measured: _Path | None = None,
    title: str | None = None,
) -> str:
    """Writes one self-contained HTML page about a measurement, an interpolant or a BSDF."""

def simulate(
    material: str,
    folder: _Path,
    *,
    azimuth_step_degrees: float | None = None,
    sweeps: int | None = None,
    points_per_sweep: int | None = None,
    spiral_points: int | None = None,
    relative_noise: float | None = None,
    absolute_noise: float | None = None,
    retro_hole_degrees: float | None = None,
    grazing_limit_degrees: float | None = None,
    aperture_degrees: float | None = None,
    back_to_front: bool = False,
    seed: int | None = None,
    progress: _Progress = None,
) -> list[Path]:
    """Measures an analytic material with a virtual goniophotometer into a new or empty folder."""

def simulate_geometry(
    mesh: _Path | Sequence[_Path],
    material: _Material | Sequence[_Material],
    folder: _Path,
    *,
    period: tuple[float, float] | None = None,
    incident: Literal["front", "back", "both"] = "front",
    thetas: Sequence[float] = ...,
    azimuths: Sequence[float] = ...,
    held_out: Sequence[tuple[float, float]] = (),
    noise: float = 0.03,
    seed: int = 1,
    progress: _Progress = None,
) -> Traced:
    """Measures micro-geometry with a virtual goniophotometer of traced rays into a new or empty folder."""

def geometry_klems(
    mesh: _Path | Sequence[_Path],
    material: _Material | Sequence[_Material],
    path: _Path,
    *,
    period: tuple[float, float] | None = None,
    rays: int = 20_000,
    seed: int = 1,
    progress: _Progress = None,
) -> Path:
    """Micro-geometry straight to a Klems matrix, as Radiance's genBSDF makes it."""

@final
class Viewer:
    """A server on this machine alone that shows files in a browser until it is closed."""

    @property
    def link(self) -> str:
        """The address to open."""

    def close(self) -> None:
        """Stops the server."""

    def __enter__(self) -> Viewer: ...
    def __exit__(self, *_exception: object) -> None: ...

def view(
    paths: _Path | Sequence[_Path], *, port: int = 0, browser: bool = True
) -> Viewer:
    """Shows files in a browser: lobe, hemisphere, slice, lit object."""

def view_weights(view: str, wavelengths: Sequence[float]) -> NDArray[np.float64]:
    """Weights of bands in what an eye, the sun or the body's clock makes of them: (1 or 3, bands)."""

def viewer_page() -> str:
    """The viewer as one HTML document that needs no server."""

def materials() -> list[str]:
    """Names of the analytic materials."""

def direction(theta_degrees: ArrayLike, phi_degrees: ArrayLike) -> NDArray[np.float64]:
    """Unit vectors from polar angles in degrees: (...), (...) -> (..., 3)."""

def angles(w: ArrayLike) -> tuple[_Numbers, _Numbers]:
    """Polar angles of directions in degrees: (..., 3) -> (theta (...), phi (...))."""
