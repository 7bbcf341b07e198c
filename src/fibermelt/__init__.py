"""fibermelt: where a short-fiber polymer bead will void.

Names are loaded when they are first used, so that importing the package costs next to nothing and
only those who solve a flow or a cell load the finite elements.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fibermelt.errors import (
        ConfigError,
        ConvergenceError,
        DamagedError,
        FibermeltError,
        HistoryError,
        MeshError,
        StoreError,
    )
    from fibermelt.fiber.cell import solve_cell
    from fibermelt.fiber.extremes import extremes, statistics
    from fibermelt.fiber.jeffery import unbounded_ellipse
    from fibermelt.fiber.models import unbounded_model
    from fibermelt.fiber.motion import follow, isotropic_angles, paper_angles
    from fibermelt.fiber.orbit import orbit
    from fibermelt.fiber.pressure import pressure_bounds, surface_pressure
    from fibermelt.fiber.shape import Ellipse
    from fibermelt.fiber.stall import stall_curve
    from fibermelt.fiber.tumbling import tumble
    from fibermelt.fields.field import Field
    from fibermelt.fields.mapping import FieldMap
    from fibermelt.fields.reading import describe_field, read_field
    from fibermelt.flow.deposition import solve_deposition
    from fibermelt.flow.problem import Deposition, FlowNumerics, Nozzle
    from fibermelt.flow.streamlines import trace_streamlines
    from fibermelt.flow.vtu import write_vtu
    from fibermelt.front import open_results, run_study, sweep
    from fibermelt.history import FlowHistory, simple_shear
    from fibermelt.melt import CarreauYasuda, Cross, CrossWLF, Newtonian, PowerLaw
    from fibermelt.orientation.closures import closure
    from fibermelt.orientation.evolve import follow_orientation
    from fibermelt.orientation.fokker_planck import steady_distribution
    from fibermelt.orientation.models import FolgarTucker
    from fibermelt.orientation.steady import steady_state
    from fibermelt.report import plot

__version__ = "0.1.0"

_HOMES = {
    "ConfigError": "errors",
    "ConvergenceError": "errors",
    "DamagedError": "errors",
    "FibermeltError": "errors",
    "HistoryError": "errors",
    "MeshError": "errors",
    "StoreError": "errors",
    "solve_cell": "fiber.cell",
    "extremes": "fiber.extremes",
    "statistics": "fiber.extremes",
    "unbounded_ellipse": "fiber.jeffery",
    "follow": "fiber.motion",
    "isotropic_angles": "fiber.motion",
    "paper_angles": "fiber.motion",
    "pressure_bounds": "fiber.pressure",
    "surface_pressure": "fiber.pressure",
    "Ellipse": "fiber.shape",
    "orbit": "fiber.orbit",
    "stall_curve": "fiber.stall",
    "tumble": "fiber.tumbling",
    "unbounded_model": "fiber.models",
    "Field": "fields.field",
    "FieldMap": "fields.mapping",
    "describe_field": "fields.reading",
    "read_field": "fields.reading",
    "closure": "orientation.closures",
    "follow_orientation": "orientation.evolve",
    "steady_distribution": "orientation.fokker_planck",
    "FolgarTucker": "orientation.models",
    "steady_state": "orientation.steady",
    "solve_deposition": "flow.deposition",
    "Deposition": "flow.problem",
    "FlowNumerics": "flow.problem",
    "Nozzle": "flow.problem",
    "trace_streamlines": "flow.streamlines",
    "write_vtu": "flow.vtu",
    "open_results": "front",
    "run_study": "front",
    "sweep": "front",
    "FlowHistory": "history",
    "simple_shear": "history",
    "CarreauYasuda": "melt",
    "Cross": "melt",
    "CrossWLF": "melt",
    "Newtonian": "melt",
    "PowerLaw": "melt",
}
"""Public name to the module that has it."""

_MODULES = {"plot": "report.plot"}
"""Public name of a module to where it is."""

__all__ = [
    "CarreauYasuda",
    "ConfigError",
    "ConvergenceError",
    "Cross",
    "CrossWLF",
    "DamagedError",
    "Deposition",
    "Ellipse",
    "FibermeltError",
    "Field",
    "FieldMap",
    "FlowHistory",
    "FlowNumerics",
    "FolgarTucker",
    "HistoryError",
    "MeshError",
    "Newtonian",
    "Nozzle",
    "PowerLaw",
    "StoreError",
    "closure",
    "describe_field",
    "extremes",
    "follow",
    "follow_orientation",
    "isotropic_angles",
    "open_results",
    "orbit",
    "paper_angles",
    "plot",
    "pressure_bounds",
    "read_field",
    "run_study",
    "simple_shear",
    "solve_cell",
    "solve_deposition",
    "stall_curve",
    "statistics",
    "steady_distribution",
    "steady_state",
    "surface_pressure",
    "sweep",
    "trace_streamlines",
    "tumble",
    "unbounded_ellipse",
    "unbounded_model",
    "write_vtu",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its module."""
    if name in _HOMES:
        return getattr(import_module(f"fibermelt.{_HOMES[name]}"), name)
    if name in _MODULES:
        return import_module(f"fibermelt.{_MODULES[name]}")
    msg = f"module 'fibermelt' has no attribute {name!r}"
    raise AttributeError(msg)


def __dir__() -> list[str]:
    """Return the public names, loaded or not."""
    return [*__all__, "__version__"]
