"""A small made-up bead as results: an L of square steps, streamlines with one corner, two modes."""

from __future__ import annotations

import re
import tomllib
from itertools import product
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fibermelt.engine.quantities import labelled
from fibermelt.engine.toml import as_toml
from fibermelt.flow.lagrange import LagrangeTriangle
from fibermelt.parts.melt.cards import load_card
from fibermelt.parts.voids.bubbles import Nuclei
from fibermelt.parts.voids.melt import moist_melt
from fibermelt.parts.voids.stages import assess_bead
from fibermelt.study.quantities import QUANTITIES

Array = NDArray[np.float64]

ORDER = 2
STEP = 0.5e-3
CAPILLARY, BEAD = (-3, 3, 6, 24), (-4, 24, 0, 6)
"""Left, right, bottom and top of the two rectangles of the L, in steps."""

AREA = 1e6 * STEP**2 * (6 * 18 + 28 * 6)
"""Of the L [mm2]."""

SPEED, ASPECT, RADIUS, SHEAR = 0.1, 4.0, 2.0, 20.0
CONFIG = """
[melt]
viscosity = 800.0

[fiber]
half_length = 4e-5

[streamlines]
features = [4, 10, 18]
"""

LEVELS = np.array([0.05, 0.5, 0.95])


def made_up(count: int = 22, angles: int = 5, points: int = 120) -> xr.Dataset:
    """Return results with every variable that the figures read."""
    lines = _streamlines(count, points)
    bead = labelled(_flow() | lines | _fibers(lines, angles) | _cell(), QUANTITIES)
    return with_voids(bead).assign_attrs(config=CONFIG)


POWERS = {"m": (1, 0, 0), "s": (0, 1, 0), "Pa": (0, 0, 1)}
"""Powers of length, time and stress in the units of what is stored."""


def _factor(unit: str, scales: tuple[float, float, float]) -> float:
    """Return the factor by which a quantity with a unit such as ``1/s`` or ``m^2/s`` grows."""
    factor, sign = 1.0, 1
    for part in re.split("([/ ])", unit):
        name, _, power = part.partition("^")
        if part == "/":
            sign = -1
        for scale, exponent in zip(scales, POWERS.get(name, (0, 0, 0)), strict=True):
            factor *= scale ** (sign * exponent * int(power or 1))
    return factor


def rescaled(
    results: xr.Dataset, length: float, time: float = 1.0, stress: float = 1.0
) -> xr.Dataset:
    """Return a bead of another size, speed and viscosity: Stokes flow scales exactly.

    What is stored grows by the powers of length, time and stress in its unit; the fiber grows with
    the nozzle, angles and shares stay. What the voids part found does not scale: it is found anew.
    """
    scales = length, time, stress
    bead = results.copy()
    for name, one in bead.data_vars.items():
        factor = _factor(one.attrs.get("units", ""), scales)
        if factor != 1.0:
            bead[name] = (one * factor).assign_attrs(one.attrs)
    config = tomllib.loads(results.attrs["config"])
    config["fiber"]["half_length"] *= length
    config["melt"]["viscosity"] *= stress * time
    flat = {f"{name}.{key}": v for name, table in config.items() for key, v in table.items()}
    return with_voids(bead, config["melt"]["viscosity"]).assign_attrs(
        results.attrs | {"config": as_toml(flat)}
    )


def with_voids(
    bead: xr.Dataset, viscosity: float = 817.0, nuclei: Nuclei | None = None
) -> xr.Dataset:
    """Return a bead with what its voids part finds; without nuclei nothing grows."""
    stages = dict.fromkeys(("streamlines", "cell", "motion"), bead)
    melt = moist_melt(load_card("paper"), moisture=0.0004, temperature=503.15)
    bare = bead.drop_vars(
        [name for name in bead.variables if str(name).startswith(("void_", "severity_"))]
    )
    return bare.merge(assess_bead(stages, viscosity, melt, layers=6, nuclei=nuclei))


def _flow() -> dict[str, Any]:
    """Return the L, meshed by halved squares with the nodes of the flow's own triangles."""
    local = LagrangeTriangle(ORDER).nodes
    halves = np.array([[(0, 0), (1, 0), (0, 1)], [(1, 0), (1, 1), (0, 1)]])
    number: dict[tuple[int, ...], int] = {}
    cells = []
    for left, right, bottom, top in (CAPILLARY, BEAD):
        for square in product(range(left, right), range(bottom, top)):
            for corner in np.array(square) + halves:
                at = corner[0] + local @ (corner[1:] - corner[0])
                keys = [tuple(map(int, row)) for row in np.rint(ORDER * at)]
                cells.append([number.setdefault(key, len(number)) for key in keys])
    x, y = (STEP / ORDER * np.array(list(number))).T
    gap = STEP * BEAD[3]
    gradient = np.zeros((len(x), 2, 2))
    gradient[:, 0, 0] = 1.0 + 40.0 * np.exp(-(x**2 + (y - gap) ** 2) / 4e-6)
    gradient[:, 1, 1] = -gradient[:, 0, 0]
    gradient[:, 1, 0] = 1e5 * x * (y > gap)
    gradient[:, 0, 1] = 20.0 * (y < gap) * np.exp(-((x / 3e-3) ** 2))
    return {
        "node_x": x,
        "node_y": y,
        "node_velocity": SPEED * np.column_stack([y <= gap, y > gap]),
        "node_pressure": 5e5 * (y / y.max()) ** 2 - 1e3,
        "node_gradient": gradient,
        "node_stream_function": SPEED * (x - x.min()),
        "cell_nodes": cells,
        "field_order": ORDER,
        "upstream_surface": STEP * np.array([(-3, 6), (-4, 6), (-4, 0)]),
        "downstream_surface": STEP * np.array([(3, 6), (24, 6)]),
        "elements": len(cells),
        "unknowns": 1234,
        "contact_point": -2e-3,
        "heel": -2e-3,
        "inlet_pressure": 5e5,
    }


def _streamlines(count: int, points: int) -> dict[str, Any]:
    """Return lines that go straight down and turn once, at one speed."""
    fraction = (np.arange(count) + 0.5) / count
    corner = np.column_stack([3e-3 * (fraction - 0.5), 3e-3 * fraction])
    down, along = 12e-3 - corner[:, 1:], 12e-3 - corner[:, :1]
    way = np.linspace(0.0, 1.0, points) * (down + along)
    time = way / SPEED
    turned = way >= down
    x = np.where(turned, corner[:, :1] + way - down, corner[:, :1])
    y = np.where(turned, corner[:, 1:], 12e-3 - way)
    rate = 1.0 + 99.0 * np.exp(-((y / 1e-3 - 4.0) ** 2) - (x / 3e-3) ** 2)
    gradient = np.zeros((count, points, 2, 2))
    gradient[..., 0, 1] = rate
    return {
        "streamline": np.arange(1, count + 1),
        "flux_fraction": fraction,
        "time": time,
        "x": x,
        "y": y,
        "u": SPEED * turned,
        "v": -SPEED * ~turned,
        "pressure": 5e5 * np.clip(y / 12e-3, 0, 1) ** 2,
        "shear_rate": rate,
        "viscosity": np.full_like(rate, 817.0),
        "gradient": gradient,
        "corner_distance": np.hypot(x - 1.5e-3, y - 3e-3),
        "near_singularity": (np.minimum(fraction, 1 - fraction) < 0.05).astype(np.int8),
        "path_end": ["outlet"] * count,
        "path_consistency": np.full(count, 1e-3),
        "path_coarseness": np.full(count, 1e-4),
        "path_notes": [""] * count,
        "zone": np.arange(1, 4),
        "zone_time": np.array([4e-3, 9e-3, 14e-3]) / SPEED * np.ones((count, 1)),
    }


def sheared(start: Array, time: Array) -> Array:
    """Return the angles of fibers that are all sheared alike: ``p ~ [[1, SHEAR t], [0, 1]] p0``."""
    return np.arctan2(np.sin(start), np.cos(start) + np.sin(start) * SHEAR * time)


def _fibers(lines: dict[str, Any], angles: int) -> dict[str, Any]:
    """Return pressures in proportion to the rate of deformation, by initial angle."""
    start = np.linspace(-np.pi / 2, np.pi / 2, angles)
    zone_time, time = lines["zone_time"], lines["time"]
    angle = sheared(start[:, None], time[:, None, :])
    straight = np.where(zone_time < 9.5e-3 / SPEED, -0.5 * np.pi, 0.0)
    relative = sheared(start[:, None], zone_time[:, None, :]) - straight[:, None, :]
    bound = 8e3 * lines["shear_rate"]
    share = 0.3 + 0.6 * np.cos(start)[:, None] ** 2
    high = share * bound[:, None, :]
    quantiles = bound[..., None] * LEVELS
    entrance, leave, end = (zone_time[:, zone, None] for zone in range(3))
    places = (time >= 0.0, time <= entrance, (time >= leave) & (time <= end))
    index = np.stack([np.argmax(np.where(here, bound, 0), axis=1) for here in places], 1)
    pick = np.broadcast_to(index[:, None, :, None], (len(bound), angles, 3, 2))

    def at(values: Array) -> Array:
        wide = np.broadcast_to(values[:, None, None, :], (*pick.shape[:3], values.shape[-1]))
        return np.take_along_axis(wide, pick, axis=-1)

    sign = np.array([-1.0, 1.0])
    value = sign * share[None, :, :, None] * at(bound)
    most = np.max(np.stack([bound * here for here in places], 1), axis=-1)
    sides = np.stack([0.1 * most, most], -1)
    return {
        "initial_angle": start,
        "location": np.arange(3),
        "kind": np.array(["min", "max"]),
        "quantile": LEVELS,
        "angle": angle,
        "zone_angle": np.arctan(np.tan(relative)),
        "lowest": -high,
        "highest": high,
        "bound_lowest": -bound,
        "bound_highest": bound,
        "felt_lowest": -1.1 * bound,
        "quantile_lowest": -quantiles[..., ::-1],
        "quantile_highest": quantiles,
        "extreme": value,
        "extreme_x": at(lines["x"]),
        "extreme_y": at(lines["y"]),
        "extreme_error": np.full_like(value, 1e3),
        "extreme_time": at(lines["time"]),
        "extreme_pressure": value + at(lines["pressure"]),
        "extreme_bounds": np.stack([-sides[..., ::-1], sides], axis=-2),
        "extreme_quantiles": sign[:, None] * most[..., None, None] * LEVELS,
        "extreme_quantiles_error": 1e-3 * most[..., None, None] * np.ones((2, 3)),
    }


def _cell() -> dict[str, Any]:
    """Return rings around an ellipse, with the pressure of a first harmonic that decays."""
    rings, rays = 8, 48
    s, r = np.meshgrid(2 * np.pi * np.arange(rays) / rays, np.linspace(0, 1, rings), indexing="ij")
    wide, high = 1 + r * (RADIUS - 1), 1 / ASPECT + r * (RADIUS - 1 / ASPECT)
    number = np.arange(s.size).reshape(s.shape)
    here, out = number[:, :-1].ravel(), number[:, 1:].ravel()
    beside, across = (np.roll(n, -1, axis=0).ravel() for n in (number[:, :-1], number[:, 1:]))
    modes = -8.0 * np.stack([np.cos(2 * s), np.sin(2 * s)], axis=-1)
    x, y = (wide * np.cos(s)).ravel(), (high * np.sin(s)).ravel()
    far = (np.column_stack([x, -y]), np.column_stack([y, x]))
    edge = 2 * np.pi * np.arange(64) / 64
    basis = -8.0 * np.column_stack([np.cos(2 * edge), np.sin(2 * edge)])
    return {
        "aspect_ratio": ASPECT,
        "domain_size": 2 * RADIUS,
        "cell_unknowns": 321,
        "cell_point": np.column_stack([x, y]),
        "cell_triangle": np.vstack(
            [np.column_stack([here, out, across]), np.column_stack([here, across, beside])]
        ),
        "cell_edge": number,
        "cell_velocity": np.stack([mode * r.ravel()[:, None] for mode in far], axis=1),
        "cell_pressure": (modes * (1 - r)[..., None]).reshape(-1, 2),
        "surface_angle": edge,
        "surface_basis": basis,
    }
