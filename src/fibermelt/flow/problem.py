"""The deposition problem as values: nozzle, gap, bed, melt and speeds (the paper's Fig. 1b, 2a)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from fibermelt.declared import declared, refuse_beyond
from fibermelt.errors import ConfigError, refuse_other
from fibermelt.melt import ViscosityLaw

__all__ = [
    "LOWEST_GAP",
    "WET",
    "BeadDeposition",
    "BeadNumerics",
    "Deposition",
    "FlowNumerics",
    "Nozzle",
]


LOWEST_GAP = 0.83
"""Gap over the height of the bead below which the melt climbs the paper's nozzle."""

WET = 2.0
"""The bed is wet where the surface lies this many films above it, or less. In the plane that is
within 0.005 widths of where a sharp contact line lies."""

EDGES = ("lip_edge", "contact_edge", "corner_edge", "surface_edge", "bulk_edge")
SHORTEST_EDGE, LONGEST_EDGE = 1e-6, 0.5
"""Bounds of every edge [widths]: below, coordinates lose the digits that tell nodes apart; above,
the capillary is no longer resolved."""


def _edge(default: float) -> Any:
    """Declare the edge length of a mesh, in widths of the capillary."""
    return declared(default, ge=SHORTEST_EDGE, le=LONGEST_EDGE)


@dataclass(frozen=True)
class Nozzle:
    """The nozzle above the bed: inlet channel, taper, capillary, gap; lengths in [m].

    The axis is x = 0, the bed y = 0, the melt flows down and leaves to +x. In the plane it is a
    slot; of a bead in space it is round, and its widths are diameters.

    Parameters
    ----------
    inlet_width, inlet_length : float
        The straight channel at the top.
    taper_length : float
        Height over which the inlet narrows to the capillary.
    capillary_width, capillary_length : float
        The straight channel whose end is the nozzle's exit.
    gap : float
        Distance from the exit's lips to the bed.
    outlet : float
        x of the station where the bead leaves the domain.

    Raises
    ------
    ConfigError
        If a length is not positive, the inlet is narrower than the capillary, or the outlet
        is not downstream of the nozzle's exit by a capillary width.

    Notes
    -----
    The paper prints no dimension of its nozzle (a Strangpresse Model 19). The defaults are
    inferred: they reproduce the results it states; mass balance makes its bead 3.000 mm high.
    """

    inlet_width: float = declared(12.7e-3, "m", gt=0)
    inlet_length: float = declared(5e-3, "m", gt=0)
    taper_length: float = declared(8e-3, "m", gt=0)
    capillary_width: float = declared(3.175e-3, "m", gt=0)
    capillary_length: float = declared(6e-3, "m", gt=0)
    gap: float = declared(3e-3, "m", gt=0)
    outlet: float = declared(20e-3, "m", gt=0)

    def __post_init__(self) -> None:
        """Refuse a nozzle that cannot be built."""
        refuse_beyond("flow", self)
        if self.inlet_width < self.capillary_width:
            msg = (
                f"flow.inlet_width = {self.inlet_width:g} m is narrower than "
                f"flow.capillary_width = {self.capillary_width:g} m: widen the inlet"
            )
            raise ConfigError(msg)
        nearest = 1.5 * self.capillary_width
        if self.outlet < nearest:
            msg = (
                f"flow.outlet = {self.outlet:g} m is too close to the nozzle's exit: "
                f"at least 1.5 capillary widths, {nearest:g} m"
            )
            raise ConfigError(msg)

    @property
    def capillary_entrance(self) -> float:
        """Return the height of the capillary's entrance above the bed [m]."""
        return self.gap + self.capillary_length

    @property
    def inlet_height(self) -> float:
        """Return the height of the inlet above the bed [m]."""
        return self.capillary_entrance + self.taper_length + self.inlet_length


@dataclass(frozen=True)
class _Printing:
    """What depositions in the plane and in space have in common, and its units."""

    nozzle: Nozzle
    melt: ViscosityLaw
    inlet_speed: float = declared(24e-3, "m/s", gt=0)
    bed_speed: float = declared(101.6e-3, "m/s", gt=0)

    def __post_init__(self) -> None:
        """Refuse a bed or a melt that stands still, and what is no nozzle or no melt."""
        refuse_other("nozzle", self.nozzle, Nozzle)
        refuse_other("melt", self.melt, ViscosityLaw)
        refuse_beyond("flow", self)

    @property
    def rate_scale(self) -> float:
        """Return the bed's speed over the capillary's width ``V/W`` [1/s], the unit of rates."""
        return self.bed_speed / self.nozzle.capillary_width

    @property
    def viscosity_scale(self) -> float:
        """Return the viscosity at ``V/W`` [Pa s], the unit of viscosities; Newtonian: ``mu``.

        One that the flow meets: in units of a viscosity at rest that it never sees, the grad-div
        term and every tolerance would drown the stress.
        """
        return float(self.melt.viscosity_at(self.rate_scale))

    @property
    def stress_scale(self) -> float:
        """Return the unit of pressures [Pa]: the viscosity at ``V/W`` times ``V/W``."""
        return self.viscosity_scale * self.rate_scale

    @cached_property
    def scaled_law(self) -> ViscosityLaw:
        """Return the melt's law in units of ``W``, ``V`` and the viscosity at ``V/W``."""
        return self.melt.scaled(1.0 / self.viscosity_scale, self.rate_scale)


@dataclass(frozen=True)
class Deposition(_Printing):
    """A melt pushed through a nozzle onto a moving bed (the paper's section 2.1).

    Parameters
    ----------
    nozzle : Nozzle
        Geometry.
    melt : ViscosityLaw
        What flows.
    inlet_speed : float
        Mean speed of the parabola at the inlet [m/s], > 0.
    bed_speed : float
        Speed of the bed in +x [m/s], > 0.

    Raises
    ------
    ConfigError
        If a speed is not positive and finite, or nozzle or melt is of another type.
    """

    @property
    def flux(self) -> float:
        """Return the flux per unit depth ``Q`` [m2/s]."""
        return self.inlet_speed * self.nozzle.inlet_width

    @property
    def mass_balance_height(self) -> float:
        """Return the bead height ``Q / V`` [m] that mass balance demands far downstream."""
        return self.flux / self.bed_speed


@dataclass(frozen=True)
class BeadDeposition(_Printing):
    """The same in space: through a round nozzle onto a bed, a bead of some height and width.

    Parameters
    ----------
    nozzle : Nozzle
        Geometry; its widths are diameters. An inlet as wide as the capillary is a straight nozzle.
    melt : ViscosityLaw
        What flows.
    inlet_speed : float
        Mean speed over the inlet's circle [m/s], > 0.
    bed_speed : float
        Speed of the bed in +x [m/s], > 0.

    Raises
    ------
    ConfigError
        If a speed is not positive and finite, or nozzle or melt is of another type.
    """

    @property
    def flux(self) -> float:
        """Return the flux ``Q`` [m3/s]."""
        return self.inlet_speed * math.pi / 4 * self.nozzle.inlet_width**2

    @property
    def mass_balance_area(self) -> float:
        """Return the area ``Q / V`` [m2] of the bead's section that mass balance demands."""
        return self.flux / self.bed_speed

    @property
    def speed_ratio(self) -> float:
        """Return the mean speed at the nozzle's exit over the bed's [-]."""
        return self.mass_balance_area / (math.pi / 4 * self.nozzle.capillary_width**2)


@dataclass(frozen=True)
class FlowNumerics:
    """How finely and how strictly the deposition flow is solved.

    Edge lengths are fractions of the capillary's width, so that they suit a nozzle of any size.

    Parameters
    ----------
    flow_order : int
        Polynomial degree of the velocity, 2 to 6; the pressure has one less (Taylor-Hood).
    lip_edge, contact_edge : float
        Mesh edge at the two lips and at the upstream contact point, where the flow is singular.
    corner_edge : float
        Mesh edge at the capillary's entrance.
    surface_edge, bulk_edge : float
        Largest edge on a free surface, and in the bead; the nozzle's may be twice that.
    edge_growth : float
        How fast edges may grow away from a lip or the contact: added length per distance.
    flow_tolerance : float
        Newton stops after a step that moves no mesh node further than this fraction of the
        capillary's width. It converges quadratically: what is left is about the square.
    contact_guess : float or None
        First guess of the contact point's x [m]; None chooses one. The answer does not depend
        on it.
    """

    flow_order: int = declared(3, ge=2, le=6)
    lip_edge: float = _edge(5e-4)
    contact_edge: float = _edge(1e-3)
    corner_edge: float = _edge(1e-2)
    surface_edge: float = _edge(0.07)
    bulk_edge: float = _edge(0.1)
    edge_growth: float = declared(0.3, ge=0.05, le=1)
    flow_tolerance: float = declared(1e-7, ge=1e-12, le=1e-3)
    contact_guess: float | None = declared(None, "m")

    def __post_init__(self) -> None:
        """Refuse numerics that no mesh can follow."""
        refuse_beyond("numerics", self)

    def coarsened(self, factor: float) -> FlowNumerics:
        """Return the same with every edge ``factor`` times as long, within the edges' bounds."""
        edge = {
            name: max(SHORTEST_EDGE, min(LONGEST_EDGE, factor * getattr(self, name)))
            for name in EDGES
        }
        return replace(self, **edge)


@dataclass(frozen=True)
class BeadNumerics:
    """How finely and how strictly a bead in space is solved; lengths in diameters of the capillary.

    Parameters
    ----------
    flow_order : int
        Polynomial degree of the velocity, 2 or 3; the pressure has one less.
    lip_edge : float
        Thickness of the layers at the lip, along the middle of the strand.
    bulk_edge : float
        Thickness of layers away from it.
    rim_edge : float
        Width of the outermost ring of the section.
    sectors : int
        Elements around half of the section, a multiple of four.
    edge_growth : float
        How fast edges may grow away from the lip and the rim: added length per distance.
    film : float
        Thickness of the film that is the bed; the answer is extrapolated from it and twice it.
    flow_tolerance : float
        Newton stops after a step that moves no mesh node further. It converges quadratically.
    """

    flow_order: int = declared(2, ge=2, le=3)
    lip_edge: float = declared(0.06, ge=1e-3, le=0.5)
    bulk_edge: float = declared(0.3, ge=0.05, le=0.5)
    rim_edge: float = declared(0.05, ge=1e-3, le=0.25)
    sectors: int = declared(16, ge=8, le=96)
    edge_growth: float = declared(0.3, ge=0.05, le=1)
    film: float = declared(0.015, ge=1e-3, le=0.05)
    flow_tolerance: float = declared(2e-4, ge=1e-10, le=1e-3)

    def __post_init__(self) -> None:
        """Refuse numerics that no mesh can follow."""
        refuse_beyond("numerics", self)
        if self.sectors % 4:
            msg = f"numerics.sectors = {self.sectors}: must be a multiple of four"
            raise ConfigError(msg)
