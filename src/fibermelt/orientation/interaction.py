"""From fiber content to the interaction coefficient ``C_I``, and the regimes of concentration.

``C_I`` is the rotary diffusivity that stands for fiber-fiber interaction, over the shear rate:
``D_r = C_I gamma_dot`` (Folgar and Tucker 1984, doi 10.1177/073168448400300201). No theory gives it
for a concentrated melt; the laws here are fits, and differ by a factor: `InteractionLaw` says to
what each was fitted, and the paper's own (Bay's) is ``INTERACTION_LAWS["bay"]``.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError, legible, refuse_no_number, refuse_other

__all__ = [
    "INTERACTION_LAWS",
    "PAPER_INTERACTIONS",
    "InteractionLaw",
    "Regime",
    "bay",
    "checked_interaction",
    "interaction_law",
    "paper_domain_size",
    "paper_preferred_angle",
    "phan_thien",
    "regime",
]

Array = NDArray[np.float64]

Regime = Literal["dilute", "semi-dilute", "concentrated"]

PAPER_INTERACTIONS = (0.005, 0.05)
"""Interaction coefficients over which Eq. 33 follows a computed curve [-]."""

PAPER_ANGLE_END = 0.1
"""Largest ``C_I`` of Eq. 33 [-]: the quartic turns at 0.109 and falls."""

PAPER_DOMAIN_END = 0.041
"""Largest ``C_I`` of Eq. 34 [-]: ``M`` has come down to 2.01, the fiber's own length."""


@dataclass(frozen=True)
class InteractionLaw:
    """A fit of ``C_I`` to fiber content and aspect ratio.

    Parameters
    ----------
    name : str
        Its key in `INTERACTION_LAWS`.
    source : str
        Where it was published.
    validity : str
        To what it was fitted, in words.
    regimes : tuple of str
        Regimes of concentration (`regime`) that it is meant for.
    function : callable
        ``C_I`` of the product ``v_f r_e``, unchecked; `coefficient` is the way to it.
    """

    name: str
    source: str
    validity: str
    regimes: tuple[Regime, ...]
    function: Callable[[float], float]

    def coefficient(self, volume_fraction: float, aspect_ratio: float) -> float:
        """Return ``C_I`` [-].

        Parameters
        ----------
        volume_fraction : float
            ``v_f`` [-], between zero and one, both excluded.
        aspect_ratio : float
            Length over diameter of the fibers [-], at least one.

        Raises
        ------
        ConfigError
            If the content lies outside (0, 1) or the aspect ratio is below one.
        """
        return self.function(_product(volume_fraction, aspect_ratio))

    def extrapolates(self, volume_fraction: float, aspect_ratio: float) -> bool:
        """Return whether a melt lies in a regime of concentration that the law is not meant for."""
        return regime(volume_fraction, aspect_ratio) not in self.regimes


def bay(volume_fraction: float, aspect_ratio: float) -> float:
    """Return Bay's ``C_I = 0.0184 exp(-0.7148 v_f r_e)`` [-].

    Bay 1991 (PhD thesis, University of Illinois at Urbana-Champaign), and Bay and Tucker 1992,
    doi 10.1002/pc.750130409: fitted to concentrated, injection-molded melts. ``C_I`` falls with the
    content: fibers that are packed screen one another. The paper's law (section 2.5): 0.0128 at
    ``v_f = 0.084``, ``r_e = 6``, which with ``v_f r_e = 0.5`` is semi-dilute, so that the law
    extrapolates; and as the content goes to zero it does not go to zero, but to 0.0184.

    Parameters
    ----------
    volume_fraction, aspect_ratio
        As in `InteractionLaw.coefficient`, with its errors.
    """
    return _bay(_product(volume_fraction, aspect_ratio))


def phan_thien(volume_fraction: float, aspect_ratio: float) -> float:
    """Return Phan-Thien's ``C_I = 0.03 (1 - exp(-0.224 v_f r_e))`` [-].

    Phan-Thien, Fan, Tanner and Zheng 2002, doi 10.1016/S0377-0257(02)00006-X: simulations of many
    fibers in simple shear, beside Folgar and Tucker's measurements; a third of the trace of their
    anisotropic diffusion. ``C_I`` grows with the content, from zero: the opposite trend of `bay`.
    0.0032 at the paper's ``v_f = 0.084``, ``r_e = 6``.

    Parameters
    ----------
    volume_fraction, aspect_ratio
        As in `InteractionLaw.coefficient`, with its errors.
    """
    return _phan_thien(_product(volume_fraction, aspect_ratio))


def _bay(product: float) -> float:
    return 0.0184 * math.exp(-0.7148 * product)


def _phan_thien(product: float) -> float:
    return -0.03 * math.expm1(-0.224 * product)


INTERACTION_LAWS: Mapping[str, InteractionLaw] = MappingProxyType(
    {
        law.name: law
        for law in (
            InteractionLaw(
                name="bay",
                source="Bay 1991; Bay and Tucker 1992, doi 10.1002/pc.750130409",
                validity="injection-molded short-fiber melts",
                regimes=("concentrated",),
                function=_bay,
            ),
            InteractionLaw(
                name="phan-thien",
                source="Phan-Thien et al. 2002, doi 10.1016/S0377-0257(02)00006-X",
                validity="simple shear of a Newtonian melt, simulated",
                regimes=("semi-dilute", "concentrated"),
                function=_phan_thien,
            ),
        )
    }
)
"""The laws by name."""


def interaction_law(name: str) -> InteractionLaw:
    """Return a law by its name; an unknown one is a `ConfigError` with the nearest."""
    refuse_other("interaction law", name, str)
    if name in INTERACTION_LAWS:
        return INTERACTION_LAWS[name]
    near = difflib.get_close_matches(name.lower(), INTERACTION_LAWS, n=1, cutoff=0.0)[0]
    msg = (
        f'interaction law "{legible(name)}" is unknown: did you mean "{near}"? '
        f"There are {', '.join(INTERACTION_LAWS)}"
    )
    raise ConfigError(msg)


def regime(volume_fraction: float, aspect_ratio: float) -> Regime:
    """Return the regime of concentration, the paper's Eq. 35 (Doi and Edwards' limits).

    Dilute below ``1/r_e^2``, semi-dilute from there to below ``1/r_e``, concentrated from ``1/r_e``
    on. Eq. 35 leaves ``v_f = 1/r_e`` itself to no regime; it is counted as concentrated, as
    ``1/r_e^2`` is counted with what lies above it. ``r_e = 1`` has no semi-dilute regime.

    Parameters
    ----------
    volume_fraction, aspect_ratio
        As in `InteractionLaw.coefficient`, with its errors.
    """
    product = _product(volume_fraction, aspect_ratio)
    # in products: v_f r_e is compared with what was given, not with a rounded inverse
    if product >= 1.0:
        return "concentrated"
    return "dilute" if product * aspect_ratio < 1.0 else "semi-dilute"


def paper_preferred_angle(interaction: ArrayLike) -> Array:
    """Return the paper's Eq. 33: preferred angle from the flow in simple shear [rad], ``r_e = 6``.

    ``pi/2 - 1.57 + 11.4 C_I - 183.5 C_I^2 + 1773.4 C_I^3 - 6680.1 C_I^4``, to compare with. It is
    what ``gamma_dot`` larger by ``sqrt(2)`` gives (``interaction.convention = "paper"``): at 0.0128
    it says 0.120, where the standard convention gives 0.097 (orthotropic closures in both).

    Parameters
    ----------
    interaction : array_like
        ``C_I`` [-], above 0 and up to 0.1; within 0.004 rad of that curve over
        `PAPER_INTERACTIONS`.

    Raises
    ------
    ConfigError
        If ``C_I`` is not positive or above 0.1, beyond which the quartic falls.
    """
    C_I = _checked_paper_interaction(interaction, "33", PAPER_ANGLE_END)
    fit = 11.4 * C_I - 183.5 * C_I**2 + 1773.4 * C_I**3 - 6680.1 * C_I**4
    return np.asarray(0.5 * math.pi - 1.57 + fit)


def paper_domain_size(interaction: ArrayLike) -> Array:
    """Return the paper's Eq. 34: the domain-size factor ``M`` [-] from ``C_I``, ``r_e = 6``.

    ``-1.4285 + sqrt(45.89 - 1.48e3 C_I + 2.38e4 C_I^2 - 2.30e5 C_I^3 + 8.68e5 C_I^4)``: Eq. 32 and
    33 put together, with rounded coefficients; 4.08 at ``C_I = 0.0128``.

    Parameters
    ----------
    interaction : array_like
        ``C_I`` [-], above 0 and up to 0.041.

    Raises
    ------
    ConfigError
        If ``C_I`` is not positive or above 0.041, where the cell is no larger than the fiber.
    """
    C_I = _checked_paper_interaction(interaction, "34", PAPER_DOMAIN_END)
    square = 45.89 - 1.48e3 * C_I + 2.38e4 * C_I**2 - 2.30e5 * C_I**3 + 8.68e5 * C_I**4
    return np.asarray(-1.4285 + np.sqrt(square))


def checked_interaction(interaction: float) -> float:
    """Return a positive finite ``C_I`` [-], or refuse it (`ConfigError`)."""
    refuse_no_number("interaction", interaction)
    if not (np.isfinite(interaction) and interaction > 0.0):
        msg = (
            f"interaction = {interaction:g}: C_I must be positive, e.g. 0.0128; "
            "fibers that do not interact have no steady orientation in shear"
        )
        raise ConfigError(msg)
    return float(interaction)


def _checked_paper_interaction(interaction: ArrayLike, equation: str, end: float) -> Array:
    C_I = real_array("interaction", interaction)
    inside = (C_I > 0.0) & (end >= C_I)
    if not np.all(inside):
        first = float(C_I[~inside].flat[0])
        msg = (
            f"interaction = {first:g}: the paper's Eq. {equation} holds for C_I above 0 and up to "
            f"{end:g}; take the computed curve beyond"
        )
        raise ConfigError(msg)
    return C_I


def _product(volume_fraction: float, aspect_ratio: float) -> float:
    """Return ``v_f r_e``, or refuse what is no content or no fiber (`ConfigError`)."""
    refuse_no_number("fiber.volume_fraction", volume_fraction)
    refuse_no_number("fiber.aspect_ratio", aspect_ratio)
    if not 0.0 < volume_fraction < 1.0:
        msg = (
            f"fiber.volume_fraction = {volume_fraction:g}: must lie between 0 and 1, both excluded "
            "(8.4 percent is 0.084)"
        )
        raise ConfigError(msg)
    if not (np.isfinite(aspect_ratio) and aspect_ratio >= 1.0):
        msg = (
            f"fiber.aspect_ratio = {aspect_ratio:g}: must be at least 1 and finite "
            "(length over diameter)"
        )
        raise ConfigError(msg)
    return volume_fraction * aspect_ratio
