"""How far nuclei at the tips of a bead's fibers grow, and the share of gas that comes of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.fiber.pressure import LocalViscosity
from fibermelt.melt import ViscosityLaw
from fibermelt.parts.bead.shapes import SHAPES
from fibermelt.parts.bead.stages import stored_path
from fibermelt.parts.voids.profile import STATIONS
from fibermelt.voids import ATMOSPHERE, BubbleMelt, Surroundings, Tip, grow, saturation_pressure

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    from fibermelt.fiber.pressure import Viscosity
    from fibermelt.parts.voids.melt import MoistMelt
    from fibermelt.voids import VolatileMelt

    Array = NDArray[np.float64]

__all__ = ["Nuclei", "bubbles", "nuclei_of"]


@dataclass(frozen=True)
class Nuclei:
    """Nuclei at the tips of fibers: what has to be assumed, and what the fibers say.

    Parameters
    ----------
    radius : float
        ``R_0`` of a nucleus in its crevice [m].
    share : float
        Share of the tips that hold one [-].
    bed_time : float
        Time on the bed after the swell at which it is told [s].
    half_length, half_width, half_thickness : float
        Semi-axes of a fiber [m].
    content : float
        Share of fibers in the volume of the melt with its fibers [-].
    in_space : bool
        Whether the fiber is a body in space, not a cylinder across a plane flow.
    """

    radius: float
    share: float
    bed_time: float
    half_length: float
    half_width: float
    half_thickness: float
    content: float
    in_space: bool

    @property
    def volume(self) -> float:
        """Return the volume of melt and fibers for each nucleus [m3].

        Two tips a fiber, an ellipsoid; of a plane flow's, too, as thick as it is wide.
        """
        fiber = 4.0 / 3.0 * math.pi * self.half_length * self.half_width * self.half_thickness
        return fiber / (2.0 * self.content * self.share)


def nuclei_of(parameters: Mapping[str, Any]) -> Nuclei:
    """Return the nuclei of a study.

    Parameters
    ----------
    parameters : mapping
        With ``[voids]`` and `fibermelt.parts.voids.part.NUCLEI`.
    """
    a, ratio = parameters["fiber.half_length"], parameters["fiber.aspect_ratio"]
    return Nuclei(
        radius=parameters["voids.nucleus_radius"],
        share=parameters["voids.nucleated_tips"],
        bed_time=parameters["voids.bed_time"],
        half_length=a,
        half_width=a / ratio,
        half_thickness=a / (parameters["fiber.thickness_ratio"] or ratio),
        content=parameters["interaction.volume_fraction"],
        in_space=SHAPES[parameters["fiber.model"]].in_space,
    )


def bubbles(
    inputs: Mapping[str, xr.Dataset], melt: MoistMelt, viscosity: Viscosity, nuclei: Nuclei | None
) -> dict[str, Array]:
    """Return how nuclei grow on the fibers of every initial angle, and without a fiber.

    Up to zone 3 each feels the lowest pressure on its fiber, then the melt's own, and at rest on
    the bed that of the air. Without a fiber it is the same nucleus at the melt's own pressure.

    Parameters
    ----------
    inputs : mapping
        The data of ``streamlines`` and ``motion``.
    melt : MoistMelt
        The moist melt.
    viscosity : float, ViscosityLaw or LocalViscosity
        What it resists with.
    nuclei : Nuclei or None
        None: nothing is assumed, and nothing grows.

    Returns
    -------
    dict
        Arrays by the names of `fibermelt.parts.voids.quantities`; without nuclei, or where the card
        has no diffusivity or no surface tension, NaN, and no radii in time.
    """
    lines, motion = inputs["streamlines"], inputs["motion"]
    added = motion["lowest"].transpose("streamline", "initial_angle", "point").to_numpy()
    laws = melt.card.melt
    if nuclei is None or laws.diffusion is None or laws.surface is None:
        return _nothing(added.shape[:2])
    around, swell = _surroundings(lines, added, viscosity, nuclei)
    stations = np.stack([swell, swell + nuclei.bed_time], axis=-1)
    bubble = _bubble_melt(laws, melt, viscosity, nuclei)
    of_melt = (1.0 - nuclei.content) * nuclei.volume
    found = grow(around, bubble, nuclei.radius, of_melt, stations[:, None, :])
    radius = found.at_stations("radius")
    gas = 4.0 / 3.0 * np.pi * radius**3 / nuclei.volume
    return {
        "void_radius": radius[:, :-1],
        "void_radius_rest": radius[:, -1],
        "void_radius_error": found.at_stations("error")[:, :-1],
        "void_radius_time": found.time[:, :-1],
        "void_radius_along": found.radius[:, :-1],
        "void_gas": np.mean(gas[:, :-1], axis=1),
        "void_gas_rest": gas[:, -1],
    }


def _surroundings(
    lines: xr.Dataset, added: Array, viscosity: Viscosity, nuclei: Nuclei
) -> tuple[Surroundings, Array]:
    """Return what nuclei meet, a row beyond the initial angles without a fiber, and zone 3 [s]."""
    path = stored_path(lines)
    time = np.concatenate([path.time, 2.0 * path.time[:, -1:] - path.time[:, -2:-1]], axis=-1)
    own, eta = (lines[name].to_numpy() for name in ("pressure", "viscosity"))
    law = _law(viscosity)
    resting = eta[:, -1:] if law is None else np.full((len(eta), 1), law.viscosity_at(0.0))
    swell = lines["zone_time"].to_numpy()[:, -1] if "zone_time" in lines else path.time[:, -1]
    there = np.where(path.time[:, None, :] <= swell[:, None, None], added, 0.0)
    fiber = np.pad(there, [(0, 0), (0, 1), (0, 1)])
    at_rest = np.zeros_like(resting)
    around = Surroundings(
        time[:, None, :],
        np.broadcast_to(
            np.concatenate([own, at_rest], axis=-1)[:, None, :] + ATMOSPHERE, fiber.shape
        ),
        np.concatenate([eta, resting], axis=-1)[:, None, :],
        np.concatenate([path.shear_rate, at_rest], axis=-1)[:, None, :],
        fiber,
        Tip(nuclei.half_length, nuclei.half_width, nuclei.in_space),
    )
    return around, swell


def _bubble_melt(
    laws: VolatileMelt, melt: MoistMelt, viscosity: Viscosity, nuclei: Nuclei
) -> BubbleMelt:
    """Return what the moist melt is to a bubble: its isotherms are in proportion to pressure."""
    T = melt.temperature
    water = laws.density * laws.polymer_fraction / (1.0 - nuclei.content)
    solubility = laws.saturation_content(T) / saturation_pressure(T)
    return BubbleMelt(
        vapor_pressure=float(laws.vapor_pressure(melt.moisture, T)),
        solubility=float(water * solubility),
        diffusivity=laws.diffusivity(T),
        tension=laws.tension(T),
        temperature=T,
        law=_law(viscosity),
    )


def _law(viscosity: Viscosity) -> ViscosityLaw | None:
    """Return the law of a melt that thins."""
    law = viscosity.law if isinstance(viscosity, LocalViscosity) else viscosity
    return law if isinstance(law, ViscosityLaw) and not law.is_newtonian else None


def _nothing(paths: tuple[int, int]) -> dict[str, Array]:
    """Return the variables without nuclei, of paths and initial angles."""
    on_fibers, alone = (np.full((*shape, len(STATIONS)), np.nan) for shape in (paths, paths[:1]))
    return {
        "void_radius": on_fibers,
        "void_radius_rest": alone,
        "void_radius_error": on_fibers,
        "void_gas": alone,
        "void_gas_rest": alone,
    }
