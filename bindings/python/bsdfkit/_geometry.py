"""Ray-traced micro-geometry, imported when it is asked for: Mitsuba is an optional extra."""

from ._errors import ArgumentError


def _package():
    try:
        from . import geometry
    except ImportError as error:
        raise ArgumentError(f"ray tracing: expected the package mitsuba, found none ({error}): pip install 'bsdfkit[mitsuba]'") from None
    return geometry


def simulate_geometry(
    mesh,
    material,
    folder,
    *,
    period=None,
    incident="front",
    thetas=(0, 15, 30, 45, 60, 75),
    azimuths=(0, 30, 60, 90, 120, 150, 180, 210, 240, 270, 300, 330),
    held_out=(),
    noise=0.03,
    seed=1,
    progress=None,
):
    """Measures micro-geometry with a virtual goniophotometer of traced rays into a new or empty folder.

    The mesh is one cell of a specimen that is repeated without end along X and Y; +Z is the front. A parallel beam of 2 degrees
    falls on the cell, rays are followed by Mitsuba until they leave, and are counted in 96 x 96 cells of equal projected
    solid angle on either side. Writes `measured/*.csv`, one an incidence, as `fit` reads them: nothing past 82 degrees nor
    within 4 degrees of the lamp. Incidences kept aside are written to `held_out.npz`, where no fit looks, by cell and for the
    whole sphere: arrays `incidences` (n, 2) in degrees, `values` and `rays` (n, 2, 9216), upward first, `noise` (n,).

    Args:
        mesh: Path of an .obj or .ply file, or a list of them. Normals are those of the triangles.
        material: A Lambertian reflectance, the path of a BSDF, or a dictionary of Mitsuba; a list for a list of meshes.
            Grey: the luminance counts.
        folder: Where to write.
        period: Of the repetition along X and Y, in the mesh's unit; the mesh's own extent if left out. The mesh may reach
            beyond one period, as slats that overlap.
        incident: Where light comes from: "front", "back" or "both".
        thetas, azimuths: Incident directions, degrees from the normal of the side that light comes from, and from +X.
            A specimen that is its own mirror image can do with half of the azimuths.
        held_out: Incident directions (theta, phi) that are kept aside.
        noise: L1 between two halves of the rays at which tracing of an incidence stops; at least two, at most four million rays.
        seed: The same seed gives the same rays.
        progress: As for `fit`.

    Returns:
        `Traced(files, held_out, noise, energy)`: paths, the noise that was reached, the least and largest share of light that
        left again.

    Raises:
        ArgumentError: Mitsuba or LLVM 19 is missing, a setting makes no sense, or the folder holds other files.
        IoError: A file is missing, or the folder cannot be written.

    Cost: a second to ten an incidence and core.
    """
    return _package().simulate_geometry(
        mesh,
        material,
        folder,
        period=period,
        incident=incident,
        thetas=thetas,
        azimuths=azimuths,
        held_out=held_out,
        noise=noise,
        seed=seed,
        progress=progress,
    )


def geometry_klems(mesh, material, path, *, period=None, rays=20_000, seed=1, progress=None):
    """Micro-geometry straight to a Klems matrix (Full, all four pairs of sides), as Radiance's genBSDF makes it.

    Args:
        mesh, material, period, progress: As for `simulate_geometry`.
        path: The XML file to write.
        rays: Of each incident patch; they come from all over it.
        seed: The same seed gives the same rays.

    Returns:
        The path.

    Raises:
        ArgumentError: Mitsuba or LLVM 19 is missing, or a setting makes no sense.
        IoError: A file is missing or cannot be written.
    """
    return _package().geometry_klems(mesh, material, path, period=period, rays=rays, seed=seed, progress=progress)
