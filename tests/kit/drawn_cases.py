"""Results that figures are drawn of in tests, by name: usual ones of each part, and odd ones."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import xarray as xr
from drawn_bead import made_up, with_voids
from round_bead import BEAD_PROBLEM, DIAMETER
from suspended_fibers import interacting, oriented
from turned_fibers import compared, turned

from fibermelt.engine.quantities import labelled
from fibermelt.parts.thinning.stages import CAUSES
from fibermelt.parts.voids.bubbles import Nuclei
from fibermelt.study.quantities import QUANTITIES

__all__ = ["CASES", "INDICES", "MODELS", "case", "effects"]

INDICES = [1.0, 0.5, 0.25]
MODELS = ["confined-ellipse", "spheroid"]


def effects() -> xr.Dataset:
    """Return what thinning does: three laws, two models, two streamlines, one of them singular."""
    shape = (len(INDICES), len(MODELS), len(CAUSES), 2)
    lowest = -1e5 * np.arange(1, np.prod(shape) + 1).reshape(shape)
    numbers = np.array(INDICES)
    of_fibers = numbers[:, None] * [1.0, 2.0]
    return labelled(
        {
            "effect_index": INDICES,
            "effect_model": MODELS,
            "effect_cause": list(CAUSES),
            "effect_consistency": 817.0 * 100.0 ** (1 - numbers),
            "effect_inlet_pressure": 1e6 * numbers,
            "effect_inlet_pressure_error": 1e3 * numbers,
            "effect_contact_point": -2e-3 * numbers,
            "effect_contact_point_error": 1e-6 * numbers,
            "effect_regular": np.array([1, 0], dtype=np.int8),
            "effect_lowest": lowest,
            "effect_bound": 2.0 * lowest,
            "effect_period": np.where(of_fibers == 1.0, np.nan, 40.0 * of_fibers),
            "effect_stall_angle": np.where(of_fibers == 1.0, 0.1, np.nan),
            "effect_peak": 10.0 * of_fibers,
            "effect_peak_error": 0.01 * (1.0 - numbers)[:, None] * [1.0, 1.0],
        },
        QUANTITIES,
    )


def _marked(*numbers: int, angles: int = 5) -> xr.Dataset:
    """Return a bead whose study marks other streamlines than the paper."""
    bead = made_up(angles=angles)
    config = bead.attrs["config"].split("[streamlines]")[0]
    return bead.assign_attrs(config=f"{config}[streamlines]\nfeatures = {[*numbers]}")


def _thinning() -> xr.Dataset:
    """Return a bead of a melt that thins, of which the table around fibers is known."""
    bead = made_up()
    rate = np.logspace(-3, 6, 200)
    law = labelled({"law_rate": rate, "law_viscosity": 817.0 * rate**-0.5}, QUANTITIES)
    config = '[melt]\nlaw = "power-law"\nconsistency = 817.0\nindex = 0.5\n'
    rest = bead.attrs["config"].partition("[fiber]")
    return bead.merge(law).assign_attrs(config=config + rest[1] + rest[2])


def _with_bubbles() -> xr.Dataset:
    """Return a bead of a few streamlines with nuclei at the tips of its fibers."""
    nuclei = Nuclei(1e-6, 1.0, 0.5, 42e-6, 7e-6, 7e-6, 0.08, in_space=False)
    return with_voids(made_up(count=4, angles=3), nuclei=nuclei)


def _with_stations() -> xr.Dataset:
    """Return fibers along paths of a flow that was not solved here, through a nozzle."""
    bead = made_up(count=6)
    solved = ("node_", "downstream_", "upstream_", "cell_nodes", "void_")
    bare = bead.drop_vars([name for name in bead.variables if str(name).startswith(solved)])
    return bare.assign(field_notes="", path_divergence=("streamline", np.zeros(6)))


def _from_elsewhere() -> xr.Dataset:
    """Return the same of a flow without a nozzle, whose paths have no stations."""
    whole = _with_stations()
    bare = whole.drop_vars([name for name in whole.variables if str(name).startswith("zone")])
    return bare.isel(location=[0]).assign_coords(location=[0])


def _in_space() -> xr.Dataset:
    flat = _from_elsewhere()
    rise = np.linspace(-1e-3, 1e-3, flat.sizes["streamline"])
    return flat.assign(z=(flat["x"].dims, np.broadcast_to(rise[:, None], flat["x"].shape)))


def _round_bead() -> xr.Dataset:
    """Return fibers in a bead in space of a guessed shape, whose paths end across its section."""
    from fibermelt.flow.mesh import scaled  # noqa: PLC0415
    from fibermelt.flow.space.guess import BeadGuess  # noqa: PLC0415
    from fibermelt.flow.space.tube import Tube, _disc, _tetrahedra  # noqa: PLC0415

    nozzle = scaled(BEAD_PROBLEM.nozzle)
    guess = BeadGuess(nozzle, BEAD_PROBLEM.speed_ratio, 0.01)
    tube = Tube.graded(guess.stations, 0.2, 0.5, 12, 0.5)
    disc, triangles = _disc(tube.rings, tube.sectors)
    layers = len(tube.layers)
    places = guess(np.repeat(tube.layers, len(disc)), np.tile(disc, (layers, 1)))
    places[:, 2] = np.maximum(places[:, 2], 0.0)
    cells = _tetrahedra(triangles, layers, len(disc))
    flat = _from_elsewhere()
    count = flat.sizes["streamline"]
    radius, angle = np.linspace(0.3, 0.9, count), np.linspace(0.4, 2.7, count)
    rows = ("streamline", "point")
    drawn = {
        name: (rows, np.broadcast_to(DIAMETER * values[:, None], flat["x"].shape))
        for name, values in {
            "y": np.linspace(0.1, 0.68, count),
            "z": np.linspace(0.03, 0.5, count),
        }.items()
    }
    numbers = {
        "bead_height": 0.77,
        "bead_width": 1.15,
        "widest": 1.28,
        "heel": -0.51,
        "front": 0.03,
        "wet_width": 0.7,
        "film": 0.015,
    }
    solved = labelled(
        {
            "field_points": DIAMETER * places,
            "field_cells": cells,
            "strand_cells": cells,
            **{name: DIAMETER * value for name, value in numbers.items()},
            "elements": len(cells),
            "unknowns": 32388,
            "start_radius": radius,
            "start_angle": angle,
        },
        QUANTITIES,
    )
    return (
        flat.assign(drawn)
        .drop_vars([*numbers, *("elements", "unknowns")], errors="ignore")
        .merge(solved)
    )


def _of_turns(aspect_ratios: tuple[float, ...], count: int = 22, **changes: object) -> xr.Dataset:
    parts = [
        turned(aspect_ratios=aspect_ratios, **changes),
        compared(count, aspect_ratios=aspect_ratios),
    ]
    return xr.merge(parts, compat="identical", join="exact")


def _oriented(*count: int, **changes: object) -> xr.Dataset:
    """Return tensors along the paths, without the fibers' own figures."""
    return oriented(*count, **changes).drop_vars("extreme")


def _with_gaps() -> xr.Dataset:
    gaps = interacting().copy(deep=True)
    gaps["interaction_angle"][0, 1, :5] = np.nan
    gaps["interaction_domain_size"][1, 9:] = np.nan
    gaps["interaction_domain_size_difference"][1] = np.nan
    many = _oriented()
    return gaps.merge(many.assign(orientation_violation=many["orientation_violation"] + 1e-3))


def _of_another_closure() -> xr.Dataset:
    other = interacting(closure="linear", coefficient=0.03).assign(stall_aspect_ratio=8.0)
    return other.merge(_oriented(1, closure="hybrid", start="inlet"))


CASES: dict[str, Callable[[], xr.Dataset]] = {
    "bead": made_up,
    "bubbles at tips": _with_bubbles,
    "one streamline, one angle": lambda: made_up(count=1, angles=1),
    "five marked streamlines": lambda: _marked(2, 6, 10, 14, 18, angles=13),
    "marked side by side": lambda: _marked(9, 10, 11),
    "a melt that thins": _thinning,
    "paths from elsewhere": _from_elsewhere,
    "paths with stations": _with_stations,
    "paths in space": _in_space,
    "a bead in space": _round_bead,
    "turns": lambda: _of_turns((1.0, 6.0, 10.0)),
    "fibers that stall": lambda: _of_turns((1.0, 6.0), domain_size=4.0),
    "many turns": lambda: _of_turns(
        (1.0, 2.0, 3.0, 4.0),
        1,
        shear_rates=(0.01, 0.1, 0.25, 0.5, 1.0, 12.5, 100.0),
        viscosities=(0.1, 1e5),
    ),
    "suspension": lambda: interacting().merge(_oriented()),
    "gaps": _with_gaps,
    "another closure": _of_another_closure,
    "another model": lambda: interacting().merge(_oriented(4, model="rsc", kappa=0.1)),
    "effects of thinning": effects,
}
"""The first that a figure can be drawn of is its usual one."""


@cache
def case(name: str) -> xr.Dataset:
    """Return results by their name; who changes them copies them."""
    return CASES[name]()
