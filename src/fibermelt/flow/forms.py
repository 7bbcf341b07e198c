"""The weak forms of the free-surface Stokes problem and their exact linearisation.

Everything is written on the mesh as it lies now (updated Lagrangian): a Newton step moves the mesh
by ``d`` and the next one starts from there, so the shape derivatives are needed at ``d = 0`` only
and are linear in it. With ``u`` riding along with the mesh (coefficients kept, nodes moved),

    d/dd  grad v   = -grad v grad d,        d/dd dx     = div d dx,
    d/dd (n ds)    = rot(d_s d) ds,         rot(t) = n,

which gives all that stands below. Lengths, speeds and the viscosity are scaled to one.

Signs, once: momentum ``int sigma : grad v = 0`` with ``sigma = 2 eta D(u) + (gamma div u - p) I``
and no traction on the free surface; mass ``-int q div u = 0``; kinematics ``int_free m n.u = 0``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import ngsolve as ng

from fibermelt.flow.strain import HeldStrain

__all__ = [
    "INTEGRATION_BONUS",
    "Elements",
    "MeltStress",
    "Unknowns",
    "ViscousStress",
    "jacobian_form",
    "residual_form",
    "stokes_form",
]

Form = Any  # ngsolve's coefficient expressions carry no types

INTEGRATION_BONUS = 4
"""Added order of quadrature on curved elements, where no order is exact: residual and
linearisation must see the same points, or Newton's convergence drops from quadratic to linear
(observed rate 1e-2 without)."""

STRING_STIFFNESS = 100.0
"""Stiffness along a free surface [pseudo-solid's modulus times length]. It spaces the nodes;
the solution does not depend on it (10 and 1000 agree to 1e-5), but without it they collapse."""

UPWIND = 0.2
"""Weight of the upwinding, in edges; from 0.05 to 1 the die swell changes by less than 1e-5."""

GRAD_DIV = 1.0
"""Weight of the grad-div term [viscosities]: consistent (the flow has no divergence), it keeps the
discrete velocity solenoidal enough for streamlines to stay on their stream function."""


@dataclass(frozen=True)
class Elements:
    """The elements by how they are integrated: curved ones lie on a free surface and move."""

    curved: ng.BitArray
    straight: ng.BitArray
    straight_moving: ng.BitArray

    def over(self, integrand: Form, *, moving: bool = False) -> list[Form]:
        """Return the integrals of ``integrand`` over all elements, or over those that move."""
        straight = self.straight_moving if moving else self.straight
        return [
            integrand * ng.dx(definedonelements=self.curved, bonus_intorder=INTEGRATION_BONUS),
            integrand * ng.dx(definedonelements=straight),
        ]


@dataclass(frozen=True)
class Unknowns:
    """Trial and test functions in the order of the product space, and the state they perturb."""

    trial: tuple[Form, ...]
    test: tuple[Form, ...]
    velocity: Form
    pressure: Form


def _sym(w: Form) -> Form:
    return 0.5 * (w + w.trans)


def _tr(w: Form) -> Form:
    return w[0, 0] + w[1, 1]


class ViscousStress:
    """The stress of a melt without its pressure, ``2 eta D + gamma div u I``, and its derivative.

    Parameters
    ----------
    gradient : expression
        Velocity gradient of the present state.
    held : HeldStrain, optional
        Of a melt that thins, in scaled units: the stress is the one ahead of what is held. Without,
        the viscosity is one.
    """

    def __init__(self, gradient: Form, held: HeldStrain | None = None) -> None:
        """Keep what the stress is made of."""
        self.gradient, self.held = gradient, held

    @property
    def value(self) -> Form:
        """Return the stress."""
        if self.held is None:
            return self.along(self.gradient)
        return self._along(self.gradient, _sym(self.gradient) - self.held.strain)

    @property
    def behind(self) -> Form:
        """Return the stress of what is held, which a shape's derivative has."""
        if self.held is None:
            return self.value
        shear = 2 * self.held.viscosity * self.held.strain
        return shear + GRAD_DIV * _tr(self.gradient) * ng.Id(2)

    def along(self, w: Form) -> Form:
        """Return the stress's derivative with the velocity gradient, in the direction ``w``.

        Symmetric, and positive where the stress grows with the rate.
        """
        return self._along(w, w)

    def _along(self, w: Form, ahead: Form) -> Form:
        spherical = GRAD_DIV * _tr(w) * ng.Id(2)
        if self.held is None:
            return 2 * _sym(w) + spherical
        turned = 8 * self.held.slope * ng.InnerProduct(self.held.strain, ahead)
        return 2 * self.held.viscosity * _sym(w) + spherical + turned * self.held.strain


@dataclass(frozen=True, eq=False)
class MeltStress:
    """The stress over the melt: by elements, as these are integrated at points of their own.

    Parameters
    ----------
    elements : Elements
        All of them.
    curved, straight : ViscousStress
        In either kind; one and the same in a Newtonian melt.
    """

    elements: Elements
    curved: ViscousStress
    straight: ViscousStress

    @property
    def held(self) -> tuple[HeldStrain, ...]:
        """Return what is held in curved and in straight elements, if the melt thins."""
        both = (self.curved.held, self.straight.held)
        return tuple(held for held in both if held is not None)

    def follow(self) -> None:
        """Linearise at the strain whose stress is the one ahead."""
        for held in self.held:
            held.follow()

    def over(
        self, integrand: Callable[[ViscousStress], Form], *, moving: bool = False
    ) -> list[Form]:
        """Return the integrals of what has a stress, as `Elements.over`."""
        if not self.held:
            return self.elements.over(integrand(self.straight), moving=moving)
        straight = self.elements.straight_moving if moving else self.elements.straight
        pairs = ((self.curved, self.elements.curved), (self.straight, straight))
        return [
            integrand(stress) * ng.dx(definedonelements=some, intrules=held.rules)
            for (stress, some), held in zip(pairs, self.held, strict=True)
        ]


def _upwind(m: Form, velocity: Form) -> Form:
    """Return the test function of the kinematics, weighted towards where the surface comes from.

    ``u.n = 0`` carries the surface along ``u`` and nothing else: tested with ``m`` alone, every
    second node may go its own way. The added ``h d_s m`` is the derivative along the edge's own
    parameter, so that it does not change as the mesh moves.
    """
    tangent = ng.specialcf.tangential(2)
    downstream = ng.IfPos(velocity * tangent, 1.0, -1.0)
    along = ng.grad(m).Trace() * tangent
    return m + UPWIND * downstream * ng.specialcf.mesh_size * along


def stokes_form(unknowns: Unknowns, melt: MeltStress) -> list[Form]:
    """Return Stokes on the present mesh: the part that does not see the mesh move."""
    u, p, *_ = unknowns.trial
    v, q, *_ = unknowns.test

    def integrand(stress: ViscousStress) -> Form:
        momentum = ng.InnerProduct(stress.along(ng.Grad(u)), ng.Grad(v)) - p * ng.div(v)
        return momentum - q * ng.div(u)

    return melt.over(integrand)


def residual_form(unknowns: Unknowns, melt: MeltStress, free: str) -> list[Form]:
    """Return what must vanish: momentum and mass in the melt, ``u.n`` on the free surfaces."""
    v, q, _, m = unknowns.test

    def integrand(stress: ViscousStress) -> Form:
        total = stress.value - unknowns.pressure * ng.Id(2)
        return ng.InnerProduct(total, ng.Grad(v)) - q * _tr(stress.gradient)

    normal = ng.specialcf.normal(2)
    return [
        *melt.over(integrand),
        _upwind(m, unknowns.velocity)
        * (normal * unknowns.velocity)
        * ng.ds(free, bonus_intorder=INTEGRATION_BONUS),
    ]


def jacobian_form(
    unknowns: Unknowns, melt: MeltStress, free: str, rate: ng.Parameter
) -> list[Form]:
    """Return the derivative of the residual, and the rule by which the mesh follows its surface.

    The moving mesh deforms as an elastic solid of modulus ``1/h``; ``lam`` is the normal force
    that makes its surface go where the kinematics wants it. With a ``rate`` above zero the step is
    one of implicit time, ``d.n rate = u.n``, the surface moving with the melt; at zero, Newton's.
    Terms that share no pair of unknowns stand apart: a sum is evaluated whole for every pair.
    """
    u, _, d, lam = unknowns.trial
    v, q, e, m = unknowns.test
    move, test_move = ng.Grad(d), ng.Grad(e)

    def shape(stress: ViscousStress) -> Form:
        gradient = stress.gradient
        total = stress.behind - unknowns.pressure * ng.Id(2)
        return (
            ng.InnerProduct(total, ng.Grad(v)) * _tr(move)
            - ng.InnerProduct(total, ng.Grad(v) * move)
            - ng.InnerProduct(stress.along(gradient * move), ng.Grad(v))
            - q * (_tr(gradient) * _tr(move) - _tr(gradient * move))
        )

    elastic = 2 * ng.InnerProduct(_sym(move), _sym(test_move)) + _tr(move) * _tr(test_move)
    solid = elastic / ng.specialcf.mesh_size
    normal, tangent = ng.specialcf.normal(2), ng.specialcf.tangential(2)
    side = normal[0] * tangent[1] - normal[1] * tangent[0]  # +1 where n = (t_y, -t_x)
    slope, test_slope = move.Trace() * tangent, test_move.Trace() * tangent
    turned = side * (unknowns.velocity[0] * slope[1] - unknowns.velocity[1] * slope[0])
    string = STRING_STIFFNESS * (tangent * slope) * (tangent * test_slope)
    on_surface = ng.ds(free, bonus_intorder=INTEGRATION_BONUS)
    return [
        *stokes_form(unknowns, melt),
        *melt.over(shape, moving=True),
        *melt.elements.over(solid, moving=True),
        _upwind(m, unknowns.velocity)
        * (normal * u.Trace() + turned - rate * (normal * d.Trace()))
        * on_surface,
        (lam * (normal * e.Trace()) + string) * on_surface,
    ]
