"""The closures by name: ``closure("ORE").contract(a, D)`` is ``A:D`` with VerWeyst's fit."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from types import MappingProxyType

from fibermelt.errors import ConfigError, legible, refuse_other
from fibermelt.orientation import fit_tables
from fibermelt.orientation.bivariate import Bivariate
from fibermelt.orientation.closure import Closure
from fibermelt.orientation.eigenframe import EigenframeLaw
from fibermelt.orientation.exact_closure import ExactDeviation
from fibermelt.orientation.ibof import InvariantLaw
from fibermelt.orientation.orthotropic import FittedDeviation
from fibermelt.orientation.polynomial import HybridLaw, LinearLaw, QuadraticLaw

__all__ = ["CLOSURES", "Closure", "closure"]

_CINTRA_TUCKER = "Cintra and Tucker, Journal of Rheology 39 (1995) 1095, doi:10.1122/1.550630"
_CHUNG_KWON = "Chung and Kwon, Polymer Composites 22 (2001) 636, doi:10.1002/pc.10566"


def _fit(name: str, components: Bivariate, source: str, validity: str) -> Closure:
    """Return an orthotropic fit: fully symmetric and normalised by construction."""
    return Closure(
        name=name,
        source=source,
        law=EigenframeLaw(FittedDeviation(components)),
        is_fully_symmetric=True,
        keeps_normalization=True,
        validity=validity,
    )


_ALL = (
    Closure(
        name="linear",
        source=(
            "Hand, Journal of Fluid Mechanics 13 (1962) 33, doi:10.1017/S0022112062000476; "
            "Advani and Tucker, Journal of Rheology 31 (1987) 751, doi:10.1122/1.549945"
        ),
        law=LinearLaw(),
        is_fully_symmetric=True,
        keeps_normalization=True,
        validity="exact for random orientation, unstable in flow for nearly aligned fibers",
    ),
    Closure(
        name="quadratic",
        source=(
            "Doi, Journal of Polymer Science: Polymer Physics Edition 19 (1981) 229, "
            "doi:10.1002/pol.1981.180190205; "
            "Advani and Tucker, Journal of Rheology 31 (1987) 751, doi:10.1122/1.549945"
        ),
        law=QuadraticLaw(),
        is_fully_symmetric=False,
        keeps_normalization=True,
        validity="exact for perfectly aligned fibers",
    ),
    Closure(
        name="hybrid",
        source="Advani and Tucker, Journal of Rheology 34 (1990) 367, doi:10.1122/1.550133",
        law=HybridLaw(),
        is_fully_symmetric=False,
        keeps_normalization=True,
        validity="exact for random and for perfectly aligned fibers, overstates alignment between",
    ),
    _fit("ORS", fit_tables.ORS, _CINTRA_TUCKER, "exact for random, planar random and aligned"),
    _fit("ORF", fit_tables.ORF, _CINTRA_TUCKER, "fitted at moderate interaction"),
    _fit("ORL", fit_tables.ORL, _CINTRA_TUCKER, "fitted at low interaction"),
    _fit("ORW", fit_tables.ORW, _CHUNG_KWON, "fitted over a wide range of interaction"),
    _fit("ORW3", fit_tables.ORW3, _CHUNG_KWON, "fitted over a wide range of interaction"),
    _fit(
        "ORE",
        fit_tables.ORE,
        "VerWeyst, PhD thesis, University of Illinois at Urbana-Champaign (1998), p. 47; used by "
        "VerWeyst and Tucker, Canadian Journal of Chemical Engineering 80 (2002) 1093, "
        "doi:10.1002/cjce.5450800611",
        "fit of the closure exact",
    ),
    Closure(
        name="IBOF",
        source="Chung and Kwon, Journal of Rheology 46 (2002) 169, doi:10.1122/1.1423312",
        law=InvariantLaw(),
        is_fully_symmetric=True,
        keeps_normalization=True,
        validity="fitted over a wide range of interaction; eigenvalues in [0, 1]",
    ),
    Closure(
        name="exact",
        source=(
            "Montgomery-Smith, He, Jack and Smith, Journal of Fluid Mechanics 680 (2011) 321, "
            "doi:10.1017/jfm.2011.165"
        ),
        law=EigenframeLaw(ExactDeviation()),
        is_fully_symmetric=True,
        keeps_normalization=True,
        validity="exact without interaction from random orientation; eigenvalues not below 0",
    ),
)

CLOSURES: Mapping[str, Closure] = MappingProxyType({each.name: each for each in _ALL})
"""Every closure by its name, in order of complexity; read-only."""


def closure(name: str) -> Closure:
    """Return the closure of that name.

    Parameters
    ----------
    name : str
        Key of ``CLOSURES``, spelt as there.

    Raises
    ------
    ConfigError
        If there is none: the message names the nearest one and all others. If it is no name.
    """
    refuse_other("closure", name, str)
    if name in CLOSURES:
        return CLOSURES[name]
    spelt = {key.lower(): key for key in CLOSURES}
    near = get_close_matches(name.lower(), spelt, n=1, cutoff=0.5)
    hint = f"did you mean {spelt[near[0]]!r}? " if near else ""
    msg = f"unknown closure {legible(name)!r}: {hint}known are {', '.join(CLOSURES)}"
    raise ConfigError(msg)
