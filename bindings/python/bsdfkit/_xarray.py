"""Values on a grid of angles, with names and units."""

import numpy as np

from ._bsdfkit import direction


def to_xarray(
    bsdf,
    *,
    theta_i=(0, 15, 30, 45, 60, 75),
    phi_i=(0,),
    theta_o=np.arange(0, 181, 5),
    phi_o=np.arange(0, 360, 5),
    xyz=False,
):
    """``eval`` of every combination of four lists of angles; see ``Bsdf.to_xarray``."""
    import xarray

    angles = {"theta_i": theta_i, "phi_i": phi_i, "theta_o": theta_o, "phi_o": phi_o}
    angles = {name: np.atleast_1d(np.asarray(a, dtype=float)) for name, a in angles.items()}
    wi = direction(angles["theta_i"][:, None], angles["phi_i"])
    wo = direction(angles["theta_o"][:, None], angles["phi_o"])
    values = bsdf.eval(wi[:, :, None, None], wo, xyz=xyz)
    coords = {name: (name, a, {"units": "degree"}) for name, a in angles.items()}
    dims = list(angles)
    if xyz:
        dims.append("channel")
        coords["channel"] = ["X", "Y", "Z"]
    attributes = {"units": "sr-1", "long_name": "BSDF", "material": bsdf.metadata.name}
    return xarray.DataArray(values, coords, dims, name="f", attrs=attributes)
