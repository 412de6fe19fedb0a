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
    "FormatError",
    "Interpolant",
    "IoError",
    "LimitError",
    "Metadata",
    "Part",
    "Proposal",
    "Sample",
    "Traced",
    "Validation",
    "angles",
    "direction",
    "fit",
    "geometry_klems",
    "materials",
    "open",
    "simulate",
    "simulate_geometry",
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
    FRONT = ...
    BACK = ...
    ALL = ...
    NONE = ...

class Part(enum.IntEnum):
    """Names of the negative numbers in ``Sample.part``."""

    LAMBERTIAN_REFLECTION = ...
    LAMBERTIAN_TRANSMISSION = ...
    NOTHING = ...

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
    def representation(self) -> Literal["tree3", "tree4", "matrix", "transport", "sir"]: ...
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

    def directional_hemispherical(
        self, wi: ArrayLike, *, components: Components | int | None = None
    ) -> _Numbers:
        """∫ f |cos θo| dωo, dimensionless: (..., 3) -> (...)."""

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

    @property
    def wavelengths(self) -> list[float] | None:
        """Wavelengths of a spectral measurement in nm, shortest first; None of any other."""

    def seen_as(self, view: str) -> Interpolant:
        """The same material, of which queries and tables have what ``view`` makes of its bands."""

    def eval_bands(self, wi: ArrayLike, wo: ArrayLike) -> NDArray[np.float64]:
        """f(wi, wo) in 1/sr of every band, shape (..., bands)."""

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
        properties: dict[str, str] | None = None,
        progress: _Progress = None,
    ) -> Bsdf:
        """The same light as a tensor tree or a Klems matrix, for a program that reads it."""

    def save(self, path: _Path, *, compact: bool = False) -> None:  # type: ignore[override]
        """Writes .safetensors."""

def open(
    path: _Path, *, in_place: bool = True, smooth: bool = False
) -> Bsdf | Interpolant:
    """Opens a BSDF (XML, compiled) or an interpolant; the file's content tells which."""

def fit(
    paths: _Path | Sequence[_Path],
    *,
    symmetry: _Symmetry | None = None,
    grazing_limit_degrees: float | None = None,
    reversed: bool = False,
    progress: _Progress = None,
) -> Interpolant:
    """Fits a continuous BSDF to goniophotometer files and folders of one specimen."""

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

def materials() -> list[str]:
    """Names of the analytic materials."""

def direction(theta_degrees: ArrayLike, phi_degrees: ArrayLike) -> NDArray[np.float64]:
    """Unit vectors from polar angles in degrees: (...), (...) -> (..., 3)."""

def angles(w: ArrayLike) -> tuple[_Numbers, _Numbers]:
    """Polar angles of directions in degrees: (..., 3) -> (theta (...), phi (...))."""
