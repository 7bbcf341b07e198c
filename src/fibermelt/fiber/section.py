"""A spheroid in a planar flow, its axis in the plane: the section that sees the extremes.

And an ellipsoid of three axes, the third across the plane, with the constants of its first two.

In the axes of such a fiber ``Sigma/mu`` of `fibermelt.fiber.spheroid` has the entries ``(c_a - c_o)
D_11``, ``-(c_t + c_o) D_11`` across it in the plane, ``-c_o D_11`` along z, and ``c_s D_12``. With
the normal ``(cos alpha, sin alpha, 0)`` of the section the pressure is

    p - p_inf = mu (D_11 P_1 + D_12 P_2),
    P_1 = (c_o - c_a) cos^2 alpha + (c_o + c_t) sin^2 alpha,      P_2 = -c_s sin 2 alpha,

at the eccentric angle ``s``, ``tan alpha = r_e tan s``. The third principal pressure ``c_o D_11``,
at the ends of the axis along z, lies between those of the tip and the flank, as ``c_a`` and ``c_t``
are positive: the extremes over the whole surface lie in the section. So `FiberResponse`, its motion
(the spin is ``W_21 + xi D_12`` as in two dimensions) and its extremes serve a spheroid as they are.

They are a spheroid's bounds in space too: of all directions, those in the plane see the highest and
the lowest extremes (the tests hold them against every direction for aspect ratios of 1 to 100).
"""

from __future__ import annotations

import numpy as np

from fibermelt.errors import ConfigError
from fibermelt.fiber.ellipsoid import EllipsoidResponse
from fibermelt.fiber.jeffery import surface_points
from fibermelt.fiber.response import FiberResponse
from fibermelt.fiber.spheroid import SpheroidResponse

__all__ = ["planar_section"]


def planar_section(body: SpheroidResponse | EllipsoidResponse) -> FiberResponse:
    """Return the response of a spheroid whose axis lies in the plane of a planar flow.

    Exact to rounding, over the whole surface: see the module.

    Parameters
    ----------
    body : SpheroidResponse or EllipsoidResponse
        Of aspect ratio (first over second axis) one or above.

    Raises
    ------
    ConfigError
        If the aspect ratio is below one, as the extremes of a disc over every orientation lie out
        of the plane; or above `fibermelt.fiber.jeffery.MOST_SLENDER`.
    """
    if isinstance(body, EllipsoidResponse):
        r, factor = float(body.semi_axes[0] / body.semi_axes[1]), float(body.shape_factors[2])
        axial, transverse, shear = (float(body.stiffness[at]) for at in ((0, 0), (1, 1), (0, 1)))
        offset = float(body.depolarisation[0] * axial - body.depolarisation[1] * transverse)
    else:
        r, factor = body.aspect_ratio, body.shape_factor
        axial, transverse, shear = body.axial, body.transverse, body.shear
        offset = body.offset
    if r < 1.0:
        msg = f"fiber.aspect_ratio = {r:g}: the section of a disc does not see its extremes: >= 1"
        raise ConfigError(msg)
    surface = surface_points(r)
    half = surface[: surface.size // 2]
    along, across = np.cos(half), r * np.sin(half)
    square = along * along + across * across
    first = (offset - axial) * along * along
    first = (first + (offset + transverse) * across * across) / square
    second = -2.0 * shear * along * across / square
    basis = np.tile(np.stack([first, second], axis=-1), (2, 1))
    return FiberResponse(r, factor, surface, basis)
