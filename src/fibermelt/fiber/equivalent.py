"""The spheroid that turns like a cylinder: equivalent aspect ratios.

A blunt cylinder of length over diameter ``r_c`` turns in shear with the period of a spheroid of
another aspect ratio ``r_e``, which is what Jeffery's formulas ask for. Two relations are in use:

- `zhang_ellipse_ratio`: a cubic fitted to finite-element periods of cylinders; 7.66 -> 6.00, the
  paper's pair.
- `cox_ellipse_ratio`: ``r_e = 1.24 r_c/sqrt(ln r_c)``, slender-body theory for large ``r_c`` with
  the constant that Cox drew from experiments on blunt cylinders.

References
----------
Zhang, Smith, Jack and Montgomery-Smith 2011, J. Manuf. Sci. Eng. 133, 051002,
doi 10.1115/1.4004831 (Eq. 2.21 of D. Zhang's dissertation, University of Missouri, 2013, is the
paper's reference for it); the coefficients as in fiberoripy 1.4.
Cox 1971, J. Fluid Mech. 45, 625, doi 10.1017/S0022112071000259.
"""

from __future__ import annotations

import math

from fibermelt.errors import ConfigError, refuse_no_number

__all__ = [
    "cox_cylinder_ratio",
    "cox_ellipse_ratio",
    "zhang_cylinder_ratio",
    "zhang_ellipse_ratio",
]

ZHANG = (0.404, 0.764, -0.00467, 0.000035)
"""Coefficients of ``1, r_c, r_c^2, r_c^3``."""

ZHANG_RANGE = (1.0, 67.0)
"""Where the cubic's ``r_e/r_c`` falls with ``r_c``, as slender-body theory wants it; its minimum at
68 is the cubic's own. The cylinders it was fitted to may have ended before."""

COX_CONSTANT = 1.24

COX_RANGE = (5.0, 1e4)
"""Slender-body theory is for ``ln r_c`` large: below 4.65 the relation gives ``r_e > r_c``, and at
``sqrt(e)`` it turns round. The upper end is beyond any fiber."""

NEWTON_TOLERANCE = 1e-15
"""Relative step at which an inversion stands still: rounding."""

MOST_STEPS = 50
"""Newton steps of an inversion; five suffice on these smooth monotone relations."""


def zhang_ellipse_ratio(cylinder_ratio: float) -> float:
    """Return ``r_e`` of the spheroid that turns like a cylinder (Zhang et al. 2011) [-].

    ``r_e = 0.000035 r_c^3 - 0.00467 r_c^2 + 0.764 r_c + 0.404``.

    Parameters
    ----------
    cylinder_ratio : float
        Length over diameter ``r_c`` [-], in `ZHANG_RANGE`.

    Raises
    ------
    ConfigError
        If the ratio is out of range.
    """
    r = _in_range("cylinder aspect ratio", cylinder_ratio, ZHANG_RANGE, "Zhang's cubic")
    return _cubic(r)


def zhang_cylinder_ratio(ellipse_ratio: float) -> float:
    """Return ``r_c`` of the cylinder that turns like a spheroid, Zhang's cubic inverted [-].

    Parameters
    ----------
    ellipse_ratio : float
        ``r_e`` [-], between the images of the ends of `ZHANG_RANGE`.
    """
    ends = (_cubic(ZHANG_RANGE[0]), _cubic(ZHANG_RANGE[1]))
    target = _in_range("aspect ratio", ellipse_ratio, ends, "Zhang's cubic")
    _, b, c, d = ZHANG
    r = target / b
    for _ in range(MOST_STEPS):
        step = (_cubic(r) - target) / (b + r * (2.0 * c + 3.0 * d * r))
        r -= step
        if abs(step) <= NEWTON_TOLERANCE * r:
            break
    return r


def cox_ellipse_ratio(cylinder_ratio: float) -> float:
    """Return ``r_e = 1.24 r_c/sqrt(ln r_c)`` of a slender cylinder (Cox 1971) [-].

    Parameters
    ----------
    cylinder_ratio : float
        Length over diameter ``r_c`` [-], in `COX_RANGE`.

    Raises
    ------
    ConfigError
        If the ratio is out of range.
    """
    r = _in_range("cylinder aspect ratio", cylinder_ratio, COX_RANGE, "Cox's relation")
    return COX_CONSTANT * r / math.sqrt(math.log(r))


def cox_cylinder_ratio(ellipse_ratio: float) -> float:
    """Return ``r_c`` of the cylinder that turns like a spheroid, Cox's relation inverted [-].

    Parameters
    ----------
    ellipse_ratio : float
        ``r_e`` [-], between the images of the ends of `COX_RANGE`.
    """
    ends = (cox_ellipse_ratio(COX_RANGE[0]), cox_ellipse_ratio(COX_RANGE[1]))
    target = _in_range("aspect ratio", ellipse_ratio, ends, "Cox's relation")
    x = math.log(target)
    # in x = ln r_c the relation is x - ln(x)/2 = ln(r_e/1.24), nearly straight
    level = math.log(target / COX_CONSTANT)
    for _ in range(MOST_STEPS):
        step = (x - 0.5 * math.log(x) - level) / (1.0 - 0.5 / x)
        x -= step
        if abs(step) <= NEWTON_TOLERANCE * x:
            break
    return math.exp(x)


def _cubic(r: float) -> float:
    a, b, c, d = ZHANG
    return a + r * (b + r * (c + r * d))


def _in_range(name: str, value: float, ends: tuple[float, float], relation: str) -> float:
    refuse_no_number(name, value)
    if not ends[0] <= value <= ends[1]:
        msg = (
            f"{name} = {value:g}: {relation} is for {ends[0]:g} to {ends[1]:g}; give the "
            "equivalent aspect ratio itself"
        )
        raise ConfigError(msg)
    return value
