"""The stage of voids: local pressures on fibers against the vapor pressure of moisture."""

from __future__ import annotations

from math import nan
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Inputs, Parameters, Say
from fibermelt.errors import ConfigError
from fibermelt.fiber import Spheroid, unbounded_spheroid
from fibermelt.fiber.pressure import LocalViscosity, newtonian_viscosity, pressure_bounds
from fibermelt.fiber.thinning_spheroid import unbounded_thinning_spheroid
from fibermelt.melt import PowerLaw, ViscosityLaw
from fibermelt.parts.bead.stages import stored_path
from fibermelt.parts.flow.given import is_given
from fibermelt.parts.melt.cards import card_of
from fibermelt.parts.melt.melt import CARD, viscosity_of
from fibermelt.parts.voids.bubbles import bubbles, nuclei_of
from fibermelt.parts.voids.limits import joint_limits
from fibermelt.parts.voids.melt import moist_melt
from fibermelt.parts.voids.profile import FELT, STATIONS, bead_totals, layer_profile
from fibermelt.parts.voids.quantities import QUANTITIES
from fibermelt.voids import (
    ATMOSPHERE,
    assess,
    critical_radius,
    growth_exponent,
    saturation_pressure,
)

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    from fibermelt.fiber import SpheroidResponse
    from fibermelt.fiber.pressure import Viscosity
    from fibermelt.parts.voids.bubbles import Nuclei
    from fibermelt.parts.voids.melt import MoistMelt
    from fibermelt.voids import Assessment

    Array = NDArray[np.float64]

__all__ = ["ORIENTED", "assess_bead", "voids_stage"]

DECADE = 1.0
"""How far the threshold must be below the rate without a barrier, in decades: nearer, a melt so
dry reaches it only where nothing holds it back, and no surface decides."""

ORIENTED = "oriented tips"
"""Basis of the mean over a distribution of orientations, where the study has one."""


def voids_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Hold the pressure on fibers against the vapor pressure, along every streamline."""
    voids = parameters.section("voids")
    melt = moist_melt(
        card_of(parameters[f"{CARD}.key"], parameters[f"{CARD}.text"]),
        voids["moisture"],
        parameters["melt.temperature"],
        voids["threshold_rate"],
        density=parameters["melt.density"],
    )
    say(f"{100 * melt.moisture:g} % moisture in {melt.card.name}")
    return assess_bead(
        inputs, viscosity_of(parameters), melt, voids["layers"], nuclei_of(parameters)
    )


def assess_bead(
    inputs: Inputs,
    viscosity: Viscosity,
    melt: MoistMelt,
    layers: int,
    nuclei: Nuclei | None = None,
) -> xr.Dataset:
    """Return where in a bead voids can start, and how far they grow.

    Parameters
    ----------
    inputs : mapping
        The data of the stages ``streamlines``, ``cell`` and ``motion``, and of ``orientation`` if
        there are any; or for each of them the results that hold them all.
    viscosity : float, ViscosityLaw or LocalViscosity
        Of the melt, for spheroids and bubbles [Pa s].
    melt : MoistMelt
        The moist melt.
    layers : int
        Number of layers of the profile over the bead's height; paths of a flow from elsewhere have
        no such profile.
    nuclei : Nuclei, optional
        What grows; by default nothing does.

    Returns
    -------
    xarray.Dataset
        The variables of `fibermelt.parts.voids.quantities`.
    """
    lines, motion = inputs["streamlines"], inputs["motion"]
    basis, gauge = _local_pressures(inputs, viscosity)
    laws, temperature = melt.card.melt, melt.temperature
    vapor = float(laws.vapor_pressure(melt.moisture, temperature))
    time = lines["time"].to_numpy()[:, None, :]
    found = assess(time, gauge, vapor)
    on_fibers = _on_fibers(lines, motion)
    fibers = assess(time, on_fibers, vapor)
    limit = _none(laws.critical_moisture(found.lowest_pressure, temperature))
    arrays: dict[str, Any] = {
        **_melt_variables(melt, vapor),
        "void_speed_exponent": _speed_exponent(viscosity),
        "void_basis": basis,
        "void_margin_along": gauge + (ATMOSPHERE - vapor),
        "void_lowest_pressure": found.lowest_pressure,
        "void_lowest_x": _at_lowest(lines["x"].to_numpy()[:, None, :], found),
        "void_lowest_y": _at_lowest(lines["y"].to_numpy()[:, None, :], found),
        **_in_space(lines, found),
        "void_margin": found.margin,
        "void_time_below": found.time_below,
        "void_first_below": _none(found.first_below),
        **_onset(melt, found),
        "void_moisture_limit": limit,
        "void_fiber_lowest": fibers.lowest_pressure,
        "void_fiber_time_below": fibers.time_below,
        **_exponents(lines, gauge, "void_exponent", vapor),
        **_exponents(lines, on_fibers, "void_fiber_exponent", vapor),
        "void_station": list(STATIONS),
        **bubbles(inputs, melt, viscosity, nuclei),
    }
    arrays["void_added_exponent"] = (
        arrays["void_fiber_exponent"].mean(axis=-1)
        - arrays["void_exponent"][:, basis.index("melt")]
    )
    regular = lines["near_singularity"].to_numpy() == 0
    arrays |= joint_limits(
        lines["time"].to_numpy()[regular],
        on_fibers[regular],
        lines["viscosity"].to_numpy()[regular],
        _settled(lines)[regular],
        melt,
        arrays["void_speed_exponent"],
    )
    if not is_given(lines):  # others have no bed, and no layers over it
        arrays["void_height"] = lines["y"].to_numpy()[:, -1]
        arrays |= layer_profile(arrays, regular, layers)
    return labelled(arrays | bead_totals(arrays, regular), QUANTITIES)


def _local_pressures(inputs: Inputs, viscosity: Viscosity) -> tuple[list[str], Array]:
    """Return the labels and the lowest local pressure of each basis [Pa, gauge].

    The pressures have shape (streamline, basis, point).
    """
    lines, motion = inputs["streamlines"], inputs["motion"]
    own = lines["pressure"].to_numpy()
    quantiles = motion["quantile_lowest"].transpose("quantile", "streamline", "point").to_numpy()
    shares = motion["quantile"].to_numpy()
    order = np.argsort(-shares)
    below = {
        "melt": np.zeros_like(own),
        **{f"isotropic {100 * shares[k]:g} %": quantiles[k] for k in order},
        "fibers": motion["lowest"].min("initial_angle").to_numpy(),
        "bounds": motion["bound_lowest"].to_numpy(),
        **({FELT: motion["felt_lowest"].to_numpy()} if "felt_lowest" in motion else {}),
        **_spheroids(inputs, viscosity),
    }
    return list(below), own[:, None, :] + np.stack(list(below.values()), axis=1)


def _spheroids(inputs: Inputs, viscosity: Viscosity) -> dict[str, Array]:
    """Return the lowest pressure on spheroids by basis, (streamline, point) [Pa, relative]."""
    fiber = Spheroid(1.0, float(inputs["cell"]["aspect_ratio"]))
    if isinstance(viscosity, ViscosityLaw):
        return _thinned_spheroid(inputs, fiber, viscosity)
    path = stored_path(inputs["streamlines"])
    spheroid = unbounded_spheroid(fiber)
    scale = newtonian_viscosity(viscosity, 0.5 * path.shear_rate)
    found = {"spheroid": scale * spheroid.bounds(path.gradient)[0]}
    if "orientation" in inputs:
        tensor = inputs["orientation"]["orientation"].to_numpy()
        found[ORIENTED] = scale * _mean_at_tips(spheroid, path.gradient, tensor)
    return found


def _thinned_spheroid(inputs: Inputs, fiber: Spheroid, law: ViscosityLaw) -> dict[str, Array]:
    """Return the lowest pressure on spheroids in the flow's plane, in a melt that thins.

    Nothing where aspect ratio or index lie beyond the table of such spheroids. The mean at the tips
    of others than these needs the closed form of a Newtonian melt.
    """
    try:
        table = unbounded_thinning_spheroid(fiber, law)
    except ConfigError:
        return {}
    path = stored_path(inputs["streamlines"])
    return {"spheroid": pressure_bounds(path, table, law).lowest}


def _mean_at_tips(spheroid: SpheroidResponse, gradient: Array, tensor: Array) -> Array:
    """Return the mean pressure over viscosity [1/s] at the tips of spheroids, (...).

    The pressure at a tip is ``mu (c_o - c_a) p.D.p``: linear in ``p p``, so its mean over any
    distribution is ``mu (c_o - c_a) D:a`` with the second moment ``a``, exactly.

    Parameters
    ----------
    spheroid : SpheroidResponse
        Its response.
    gradient : (..., 3, 3) array
        Velocity gradients [1/s].
    tensor : (..., 3, 3) array
        Orientation tensors.
    """
    stretch = np.einsum("...ij,...ij->...", gradient, tensor)
    return np.asarray((spheroid.offset - spheroid.axial) * stretch)


def _on_fibers(lines: xr.Dataset, motion: xr.Dataset) -> Array:
    """Return the lowest pressure on every fiber [Pa, gauge], (streamline, angle, point)."""
    relative = motion["lowest"].transpose("streamline", "initial_angle", "point").to_numpy()
    on_fibers: Array = relative + lines["pressure"].to_numpy()[:, None, :]
    return on_fibers


def _exponents(lines: xr.Dataset, gauge: Array, name: str, vapor: float) -> dict[str, Array]:
    """Return growth exponents and their errors (streamline, ...) of pressures [Pa, gauge].

    From the inlet to zone 3, where the melt has the speed of the bed; on paths without zones to
    their end.
    """
    time, viscosity = (lines[one].to_numpy()[:, None, :] for one in ("time", "viscosity"))
    found = growth_exponent(time, gauge + ATMOSPHERE, vapor, viscosity, _settled(lines)[:, None])
    return {name: found.value, f"{name}_error": found.error}


def _settled(lines: xr.Dataset) -> Array:
    """Return when the melt of each streamline has the speed of the bed [s], or the path ends."""
    if "zone_time" in lines:
        return np.asarray(lines["zone_time"].to_numpy()[:, -1])
    return np.asarray(lines["time"].to_numpy()[:, -1])


def _melt_variables(melt: MoistMelt, vapor: float) -> dict[str, Any]:
    """Return what the melt is."""
    laws, temperature = melt.card.melt, melt.temperature
    return {
        "void_material": melt.card.key,
        "void_material_name": melt.card.name,
        "void_estimates": "\n".join(
            key for key in melt.card.estimates if not key.startswith("viscosity.")
        ),
        "void_missing": "\n".join(laws.gaps.values()),
        "void_moisture": melt.moisture,
        "void_temperature": temperature,
        "void_saturation_moisture": float(laws.saturation_content(temperature)),
        "void_boiling_moisture": _none(laws.critical_moisture(ATMOSPHERE, temperature)),
        "void_vapor_pressure": vapor,
        "void_saturation_pressure": float(saturation_pressure(temperature)),
        "void_threshold": melt.log10_threshold,
    }


def _onset(melt: MoistMelt, found: Assessment) -> dict[str, Any]:
    """Return what classical nucleation says, as far as the card and the moisture allow."""
    laws, temperature = melt.card.melt, melt.temperature
    nothing = np.full(found.margin.shape, np.nan)
    onset = dict.fromkeys(
        (
            "void_log10_rate",
            "void_critical_radius",
            "void_critical_time",
            "void_residence_margin",
            "void_required_wetting",
            "void_required_angle",
        ),
        nothing,
    )
    if laws.surface is None:
        return onset
    residence = None if laws.diffusion is None else laws.residence(temperature)
    radius = critical_radius(laws.tension(temperature), found.deficit)
    onset["void_critical_radius"] = _none(radius)
    if residence is not None:
        onset["void_critical_time"] = _none(residence.time(radius))
        onset["void_residence_margin"] = _none(residence.margin(radius, found.time_below))
    if melt.moisture > 0.0:
        nucleation = laws.nucleation(melt.moisture, temperature)
        onset["void_log10_rate"] = _none(nucleation.log10_rate(found.deficit))
        if melt.log10_threshold < nucleation.log10_prefactor - DECADE:
            told = found.deficit, melt.log10_threshold
            onset["void_required_wetting"] = nucleation.required_wetting_factor(*told)
            onset["void_required_angle"] = nucleation.required_contact_angle(*told)
    return onset


def _speed_exponent(viscosity: Viscosity) -> float:
    """Return the power of both speeds that all stresses go with: of a power law, its index."""
    law = viscosity.law if isinstance(viscosity, LocalViscosity) else viscosity
    if isinstance(law, float):
        return 1.0
    return law.index if isinstance(law, PowerLaw) else nan


def _in_space(lines: xr.Dataset, found: Assessment) -> dict[str, Array]:
    """Return the third coordinate of the lowest pressure, of paths that have one."""
    if "z" not in lines:
        return {}
    return {"void_lowest_z": _at_lowest(lines["z"].to_numpy()[:, None, :], found)}


def _at_lowest(values: Array, found: Assessment) -> Array:
    """Return values (streamline, 1 or basis, point) at the lowest pressure."""
    index = found.lowest_index[..., None]
    wide = np.broadcast_to(values, (*found.lowest_index.shape, values.shape[-1]))
    return np.asarray(np.take_along_axis(wide, index, axis=-1)[..., 0])


def _none(values: Array) -> Array:
    """Return NaN where there is no such number: what is infinite is not there."""
    return np.where(np.isfinite(values), values, np.nan)
