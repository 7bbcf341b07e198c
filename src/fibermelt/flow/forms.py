"""The weak forms of the free-surface Stokes problem and their exact linearisation.

Everything is written on the mesh as it lies now (updated Lagrangian): a Newton step moves the mesh
by ``d`` and the next one starts from there, so the shape derivatives are needed at ``d = 0`` only
and are linear in it. With ``u`` riding along with the mesh (coefficients kept, nodes moved),

    d/dd  grad v   = -grad v grad d,        d/dd dx     = div d dx,
    d/dd (n ds)    = ((div_s d) n - (grad_s d)^T n) ds,    in the plane rot(d_s d) ds, rot(t) = n,

which gives all that stands below, in the plane and in space. Lengths, speeds and the viscosity are
scaled to one.

Signs, once: momentum ``int sigma : grad v = 0`` with ``sigma = 2 eta D(u) + (gamma div u - p) I``
and no traction on the free surface but a film's; mass ``-int q div u = 0``; kinematics
``int_free m n.u = 0``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import ngsolve as ng

from fibermelt.flow.strain import HeldStrain

__all__ = [
    "INTEGRATION_BONUS",
    "BedFilm",
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

SLOWEST = 1e-3
"""Speed below which the upwinding in space fades, as a surface at rest has no downstream."""

UPWIND = 0.2
"""Weight of the upwinding, in edges; from 0.05 to 1 the die swell changes by less than 1e-5."""

GRAD_DIV = {2: 1.0, 3: 0.1}
"""Weight of the grad-div term [viscosities], by dimension: consistent (the flow has no divergence),
it keeps the discrete velocity solenoidal enough for planar streamlines to stay on their stream
function. Tetrahedra have few solenoidal quadratics: there a weight of one takes the divergence from
9 to 8 per cent of the gradient, and puts a round die's swell on a coarse mesh off by 0.005 more."""


@dataclass(frozen=True)
class Elements:
    """The elements by how they are integrated: curved ones have an edge on a curved boundary."""

    curved: ng.BitArray
    straight: ng.BitArray
    moves: ng.BitArray

    def kinds(self, *, moving: bool = False) -> tuple[ng.BitArray, ng.BitArray]:
        """Return the curved and the straight ones, all of them or those that move."""
        if not moving:
            return self.curved, self.straight
        return self.curved & self.moves, self.straight & self.moves

    def over(self, integrand: Form, *, moving: bool = False) -> list[Form]:
        """Return the integrals of ``integrand`` over all elements, or over those that move."""
        curved, straight = self.kinds(moving=moving)
        return [
            integrand * ng.dx(definedonelements=curved, bonus_intorder=INTEGRATION_BONUS),
            integrand * ng.dx(definedonelements=straight),
        ]


@dataclass(frozen=True, eq=False)
class BedFilm:
    """The bed as a film of its own melt on a free surface: there is no contact line.

    Where the melt rolls onto the bed at 180 degrees a sharp line is not determined: a node may
    slide along it and change no flux. The film's traction on the melt ``y`` above the bed is

        t = -B (u - e_x),    B = (2/eps) exp(-y/eps),

    a friction that lets nothing through and fades over the thickness ``eps``; all three components,
    so that what is pressed on cannot lift freely. For ``eps -> 0`` it is a bed that sticks: in the
    plane heel and inlet pressure come to a sharp bed's with first order, and the contour
    ``y = 2 eps`` is its contact to 0.004 widths. It holds what is pressed on it, and gives back no
    more than it took: a strand that is drawn peels off. The bed lies at y = 0 and moves at the
    speed 1 in x.

    Parameters
    ----------
    thickness : Parameter
        ``eps``, in units of the nozzle's exit.
    """

    thickness: ng.Parameter

    @property
    def friction(self) -> Form:
        """Return ``B``, the traction per speed."""
        return 2.0 / self.thickness * ng.exp(-ng.y / self.thickness)

    def traction(self, velocity: Form, test: Form) -> Form:
        """Return ``B (u - e_x).v``, which stands in the residual of momentum."""
        bed = ng.CF((1.0, *[0.0] * (velocity.dim - 1)))
        return self.friction * ((velocity - bed) * test)

    def turned(self, velocity: Form, test: Form, move: Form, spread: Form) -> Form:
        """Return its derivative with the shape, ``spread`` being ``div_s d``."""
        return self.traction(velocity, test) * (spread - move[1] / self.thickness)


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
    return sum((w[i, i] for i in range(1, w.dims[0])), start=w[0, 0])


def _spherical(w: Form) -> Form:
    dim = w.dims[0]
    return GRAD_DIV[dim] * _tr(w) * ng.Id(dim)


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
        return shear + _spherical(self.gradient)

    def along(self, w: Form) -> Form:
        """Return the stress's derivative with the velocity gradient, in the direction ``w``.

        Symmetric, and positive where the stress grows with the rate.
        """
        return self._along(w, w)

    def _along(self, w: Form, ahead: Form) -> Form:
        spherical = _spherical(w)
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
        kinds = self.elements.kinds(moving=moving)
        pairs = zip((self.curved, self.straight), kinds, strict=True)
        return [
            integrand(stress) * ng.dx(definedonelements=some, intrules=held.rules)
            for (stress, some), held in zip(pairs, self.held, strict=True)
        ]


class _Line:
    """What a free surface in the plane does as its mesh moves: it is a line.

    Parameters
    ----------
    velocity : expression
        Of the present state.
    """

    def __init__(self, velocity: Form) -> None:
        self.velocity = velocity
        self.normal, self.tangent = ng.specialcf.normal(2), ng.specialcf.tangential(2)

    def upwind(self, m: Form) -> Form:
        """Return the test function of the kinematics, weighted towards where it comes from.

        ``u.n = 0`` carries the surface along ``u`` and nothing else: tested with ``m`` alone, every
        second node may go its own way. The added ``h d_s m`` is the derivative along the edge's own
        parameter, so that it does not change as the mesh moves.
        """
        downstream = ng.IfPos(self.velocity * self.tangent, 1.0, -1.0)
        along = ng.grad(m).Trace() * self.tangent
        return m + UPWIND * downstream * ng.specialcf.mesh_size * along

    def kinematics(self, m: Form, u: Form, move: Form) -> Form:
        """Return the derivative of ``upwind(m) u.n ds`` over ``ds``, with the velocity and shape.

        ``move`` is the gradient of the mesh's move ``d``.
        """
        return self.upwind(m) * (self.normal * u + self._turned(move))

    def _turned(self, move: Form) -> Form:
        """Return ``u . d(n ds)/ds``."""
        side = self.normal[0] * self.tangent[1] - self.normal[1] * self.tangent[0]
        slope = move.Trace() * self.tangent  # side is +1 where n = (t_y, -t_x)
        return side * (self.velocity[0] * slope[1] - self.velocity[1] * slope[0])

    def spread(self, move: Form) -> Form:
        """Return ``div_s d``."""
        return self.tangent * (move.Trace() * self.tangent)

    def stiffness(self, move: Form, test_move: Form) -> Form:
        """Return the work of the string that spaces its nodes."""
        slope, test_slope = move.Trace() * self.tangent, test_move.Trace() * self.tangent
        return STRING_STIFFNESS * (self.tangent * slope) * (self.tangent * test_slope)


class _Sheet:
    """The same in space, where it is a sheet, and a membrane is what spaces its nodes."""

    def __init__(self, velocity: Form) -> None:
        self.velocity, self.normal = velocity, ng.specialcf.normal(3)

    def upwind(self, m: Form) -> Form:
        """Return the weighted test function."""
        return m + self._reach * (ng.grad(m).Trace() * self.velocity)

    @property
    def _speed(self) -> Form:
        return ng.sqrt(self.velocity * self.velocity + SLOWEST**2)

    @property
    def _reach(self) -> Form:
        return UPWIND * ng.specialcf.mesh_size / self._speed

    def kinematics(self, m: Form, u: Form, move: Form) -> Form:
        """Return the derivative; also that of the weight, as an edge changes and ``u`` turns.

        ``d(grad_s m) = n (n . D grad_s m) - D^T grad_s m`` and ``dh = h tr D/2``, ``D = grad_s d``.
        """
        D, along, w = move.Trace(), ng.grad(m).Trace(), self.velocity
        through = self.normal * w
        turned = _tr(D) * through - self.normal * (D * w)
        weight = (
            (0.5 * _tr(D) - (w * u) / self._speed**2) * (along * w)
            + along * u
            - along * (D * w)
            + through * (self.normal * (D * along))
        )
        return self.upwind(m) * (self.normal * u + turned) + self._reach * weight * through

    def spread(self, move: Form) -> Form:
        return _tr(move.Trace())

    def stiffness(self, move: Form, test_move: Form) -> Form:
        across = ng.Id(3) - ng.OuterProduct(self.normal, self.normal)
        e, f = _sym(across * move.Trace()), _sym(across * test_move.Trace())
        return STRING_STIFFNESS * (2 * ng.InnerProduct(e, f) + _tr(e) * _tr(f))


def _surface(velocity: Form) -> _Line | _Sheet:
    return _Line(velocity) if velocity.dim == 2 else _Sheet(velocity)


def _on(free: str) -> Form:
    return ng.ds(free, bonus_intorder=INTEGRATION_BONUS)


def stokes_form(
    unknowns: Unknowns, melt: MeltStress, free: str = "", film: BedFilm | None = None
) -> list[Form]:
    """Return Stokes on the present mesh: the part that does not see the mesh move."""
    u, p, *_ = unknowns.trial
    v, q, *_ = unknowns.test

    def integrand(stress: ViscousStress) -> Form:
        momentum = ng.InnerProduct(stress.along(ng.Grad(u)), ng.Grad(v)) - p * ng.div(v)
        return momentum - q * ng.div(u)

    terms = melt.over(integrand)
    if film is not None:
        terms.append(film.friction * (u.Trace() * v.Trace()) * _on(free))
    return terms


def residual_form(
    unknowns: Unknowns, melt: MeltStress, free: str, film: BedFilm | None = None
) -> list[Form]:
    """Return what must vanish: momentum and mass in the melt, ``u.n`` on the free surfaces."""
    v, q, _, m = unknowns.test

    def integrand(stress: ViscousStress) -> Form:
        total = stress.value - unknowns.pressure * ng.Id(v.dim)
        return ng.InnerProduct(total, ng.Grad(v)) - q * _tr(stress.gradient)

    surface = _surface(unknowns.velocity)
    through = surface.normal * unknowns.velocity
    terms = [*melt.over(integrand), surface.upwind(m) * through * _on(free)]
    if film is not None:
        terms.append(film.traction(unknowns.velocity, v.Trace()) * _on(free))
    return terms


def jacobian_form(
    unknowns: Unknowns,
    melt: MeltStress,
    free: str,
    rate: ng.Parameter,
    film: BedFilm | None = None,
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
        total = stress.behind - unknowns.pressure * ng.Id(v.dim)
        return (
            ng.InnerProduct(total, ng.Grad(v)) * _tr(move)
            - ng.InnerProduct(total, ng.Grad(v) * move)
            - ng.InnerProduct(stress.along(gradient * move), ng.Grad(v))
            - q * (_tr(gradient) * _tr(move) - _tr(gradient * move))
        )

    elastic = 2 * ng.InnerProduct(_sym(move), _sym(test_move)) + _tr(move) * _tr(test_move)
    solid = elastic / ng.specialcf.mesh_size
    surface, on_surface = _surface(unknowns.velocity), _on(free)
    terms = [
        *stokes_form(unknowns, melt, free, film),
        *melt.over(shape, moving=True),
        *melt.elements.over(solid, moving=True),
        surface.kinematics(m, u.Trace(), move) * on_surface,
        -rate * surface.upwind(m) * (surface.normal * d.Trace()) * on_surface,
        (lam * (surface.normal * e.Trace()) + surface.stiffness(move, test_move)) * on_surface,
    ]
    if film is not None:
        spread = surface.spread(move)
        turned = film.turned(unknowns.velocity, v.Trace(), d.Trace(), spread)
        terms.append(turned * on_surface)
    return terms
