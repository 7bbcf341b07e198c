"""Collected sweeps with known answers: a grid, one at a time, and samples."""

import json

import numpy as np
import xarray as xr

from fibermelt.engine.toml import resolved_toml
from fibermelt.paper.claims.judge import claims
from fibermelt.study.loading import load_study
from fibermelt.sweeps.cost import Computed, Progress, StageCost
from fibermelt.sweeps.design import read_sweep

GAP, SPEED, VISCOSITY = "flow.gap", "flow.bed_speed", "melt.viscosity"


def about(units="1"):
    return {"units": units, "long_name": "a number"}


def made_up(tmp_path, table, numbers, failed=(), verdicts=None):
    """Return what a sweep with a table comes to.

    ``numbers`` maps names to (unit, function of the point); ``verdicts`` maps names of claims to
    functions of the point; ``failed`` are indices of cases.
    """
    path = tmp_path / "swept.toml"
    path.write_text(f'preset = "paper"\nstudy.parts = ["bead"]\n[sweep]\n{table}')
    study = load_study(str(path))
    sweep = read_sweep(study)
    points = [dict(case.point) for case in sweep.cases()]
    grid = sweep.design == "grid"
    dims = tuple(axis.name for axis in sweep.axes) if grid else ("case",)
    there = np.array([case not in failed for case in range(len(points))])
    status = np.where(there, "done", "failed").astype(object)
    reason = np.where(there, "", "no steady surface; try a larger gap").astype(object)
    variables = {
        "status": (dims, status.reshape(sweep.shape), about()),
        "reason": (dims, reason.reshape(sweep.shape), about()),
    }
    for name, (unit, function) in numbers.items():
        values = np.where(there, [function(point) for point in points], np.nan)
        variables[name] = (dims, values.reshape(sweep.shape), about(unit))
    if verdicts is not None:
        names = [claim.id for claim in claims()]
        values = np.full((len(points), len(names)), np.nan)
        for name, function in verdicts.items():
            values[:, names.index(name)] = [function(point) for point in points]
        values[~there] = np.nan
        missing = np.where(np.isnan(values), "the part is not there", "").astype(object)
        over = (*dims, "claim")
        variables["claim_value"] = (over, values.reshape(*sweep.shape, -1), about())
        variables["claim_missing"] = (over, missing.reshape(*sweep.shape, -1), about())
        variables["claim"] = (("claim",), np.array(names, dtype=object), about())
    coords = {}
    for axis in sweep.axes:
        for key in axis.keys:
            values = np.array([point[key] for point in points])
            if grid:
                place = dims.index(axis.name)
                values = np.moveaxis(values.reshape(sweep.shape), place, 0)
                values = values.reshape(len(values), -1)[:, 0]
            coords[key] = (axis.name if grid else "case", values)
    attributes = {
        "title": "fibermelt sweep swept",
        "config": resolved_toml(study.config, "The study that was swept, in SI."),
        "sweep": json.dumps(study.sweep),
    }
    return xr.Dataset(variables, coords, attributes)


GRID = f"""
"{GAP}" = ["2.5 mm", "3 mm", "4 mm"]
"{VISCOSITY}" = ["400 Pa s", "800 Pa s"]
"""
ONE_AT_A_TIME = f'{GRID}\ndesign = "one-at-a-time"'


def sampled(design, samples):
    return (
        f'"{GAP}" = {{ low = "2.5 mm", high = "4 mm" }}\n'
        f'"{VISCOSITY}" = {{ low = "400 Pa s", high = "1200 Pa s" }}\n'
        f'"fiber.aspect_ratio" = {{ low = 4, high = 8 }}\n'
        f'design = "{design}"\nsamples = {samples}\nseed = 3\n'
    )


def contact(point):
    """Contact point [m] that moves with the gap only."""
    return -1e-3 - (point[GAP] - 2e-3)


def pressure(point):
    """Inlet pressure [Pa] in proportion to the viscosity, and less for wide gaps."""
    return 1e3 * point[VISCOSITY] * (1 + 1e-3 / point[GAP])


def with_errors(collected):
    """Return a sweep whose flows state an error of the contact point: a hundredth of the gap."""
    error = 1e-2 * collected[GAP] + 0 * collected["contact_point"]
    return collected.assign(contact_point_error=error.assign_attrs(units="m"))


COMPUTED = Computed(
    stages={"flow": StageCost(6, 6, 4, 80.5, 60.0), "cell": StageCost(1, 1, 0, 2.0, 0.0)},
    progress=Progress(42.0, 1, 5, 2.5, 1.5),
    software={"ngsolve": ("6.2.1", "6.2.2")},
)
"""How a sweep might have been computed [s]."""


NUMBERS = {
    "contact_point": ("m", contact),
    "inlet_pressure": ("Pa", pressure),
    "bead_height": ("m", lambda point: 3e-3 * (1 + 1e-10 * point[GAP])),
}
