"""Whatever is no number, given to every public function that takes arrays.

The last test keeps the list complete: a parameter that takes an array must be in it.
"""

import inspect
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import fibermelt as fm
from fibermelt import fiber, orientation, voids
from fibermelt.flow.field import FlowField
from fibermelt.orientation import distribution, fokker_planck, interaction

AXIS = np.array([1.0, 0.0, 0.0])
PLANAR = np.array([[0.0, 1.0], [0.0, 0.0]])
SHEAR = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
ORIENTED = np.diag([0.5, 0.3, 0.2])
OUTSIDE = np.array([3.0, 4.0])
ONE, HOT = np.array([1.0]), np.array([503.15])
TIMES = np.array([0.5, 0.7, 0.9])
ELLIPSE = fiber.Ellipse(1.0, 6.0)
BALL = fiber.Ellipsoid((1.0, 1.0, 1.0))
HISTORY = fm.simple_shear(1.0, 2.0, 9)
MODEL = fiber.unbounded_model("ellipse", ELLIPSE)
RESPONSE = MODEL.response
SPHEROID = fiber.unbounded_spheroid(fiber.Spheroid(1.0, 6.0))
ELLIPSOID = fiber.unbounded_ellipsoid(BALL)
MOTION = fiber.follow(HISTORY, 0.9, [0.3])
PRESSURE = fiber.surface_pressure(HISTORY, RESPONSE, 817.0, MOTION)
BOUNDS = fiber.pressure_bounds(HISTORY, RESPONSE, 817.0)
CURVE = fiber.StallCurve(6.0, np.array([3.0, 4.0]), np.array([1.1, 0.9]), 0.0)
FOLGAR, ORE = fm.FolgarTucker(0.9, 0.01), fm.closure("ORE")
CLASSICAL = voids.ClassicalNucleation(23.8e-3, 503.15, 6.6e25)
HENRY = voids.Henry(1e-8, 503.15, 0.0, (400.0, 600.0))
ACTIVITY = voids.ActivityLaw(0.01, 503.15, 0.0, (400.0, 600.0))
FREE = voids.FreeVolume(
    4.82e-8, 0.0, (0.917e-3, 0.728e-3), 0.82, (1.45e-6, 4.33e-7), (-86.32, -258.2), 0.5
)
MELT = voids.VolatileMelt("melt", 1050.0, (400.0, 600.0), isotherm=HENRY)
COLD = np.array([298.15])
"""What `FREE` is for."""
THICK = fm.Newtonian(817.0)
AROUND = voids.Surroundings(TIMES, np.array([1e5, 1e5, 1e5]), 817.0)
BUBBLE = voids.BubbleMelt(2e5, 2e-6, 1e-10, 0.02, 503.15)
HALF, PASCAL = np.array([0.5]), np.array([1e5])
LITTLE = np.array([1e-4])
UNIFORM = distribution.isotropic_distribution()
ZEROS = np.zeros(9)
FIELD = FlowField(
    1,
    np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
    np.array([[0, 1, 2]]),
    np.zeros((3, 2)),
    np.zeros(3),
    np.zeros((3, 2, 2)),
    np.zeros(3),
    np.ones(3),
    np.zeros(3),
)

TURNED = (SHEAR, np.eye(3)[0], np.eye(3)[1])
"""A gradient, and the axes of an ellipsoid."""

Case = tuple[Callable[[object], object], np.ndarray]


def history(**changed: object) -> fm.FlowHistory:
    names = ("time", "position", "velocity", "gradient", "pressure")
    return fm.FlowHistory(**{name: getattr(HISTORY, name) for name in names} | changed)


def along(path: Callable[[np.ndarray, object], object]) -> Case:
    """Return what is called with the times of a path of two points."""
    both = np.stack([SHEAR, SHEAR])
    return (lambda t: path(both, t)), np.array([0.0, 1.0])


def spatial(time: object, gradient: object) -> SimpleNamespace:
    return SimpleNamespace(time=time, gradient=gradient)


TIMED: dict[str, Case] = {
    "FlowHistory time": (lambda t: history(time=t), HISTORY.time),
    "extremes zone_time": (lambda t: fm.extremes(HISTORY, PRESSURE, MOTION, t), TIMES),
    "extreme_bounds zone_time": (
        lambda t: fiber.extreme_bounds(HISTORY, BOUNDS, t),
        TIMES,
    ),
    "isotropic_pressure zone_time": (
        lambda t: fiber.isotropic_pressure(HISTORY, RESPONSE, 817.0, t),
        TIMES,
    ),
    "FiberModel.isotropic_pressure zone_time": (
        lambda t: MODEL.isotropic_pressure(HISTORY, 817.0, t),
        TIMES,
    ),
    "tumble time": (lambda t: fm.tumble(RESPONSE, 1.0, 817.0, t), TIMES),
    "angle_to_stream_at times": (lambda t: fiber.angle_to_stream_at(HISTORY, MOTION, t), TIMES),
    "jeffery_angle time": (lambda t: fiber.jeffery_angle(t, 1.0, 6.0), TIMES),
    "jeffery_director time": (lambda t: fiber.jeffery_director(t, 1.0, 6.0, AXIS), TIMES),
    "turned_angle time": (lambda t: fiber.turned_angle(0.9, 1.0, t), TIMES),
    "follow_orientation time": along(
        lambda L, t: fm.follow_orientation(FOLGAR, ORE, (t, L), ORIENTED)
    ),
    "follow_distribution time": along(
        lambda L, t: fokker_planck.follow_distribution(t, L, 0.9, 1.0, degree=4)
    ),
    "assess time": (lambda t: voids.assess(t, TIMES, 0.0), TIMES),
    "growth_exponent time": (lambda t: voids.growth_exponent(t, TIMES, 1.0, TIMES), TIMES),
    "growth_exponent until": (
        lambda end: voids.growth_exponent(TIMES, TIMES, 1.0, TIMES, end),
        np.array(0.8),
    ),
    "grow stations": (lambda t: voids.grow(AROUND, BUBBLE, 1e-6, 1e-13, t), TIMES[1:]),
    "Surroundings time": (lambda t: replace(AROUND, time=t).arrays(), TIMES),
    "ResidenceCondition.margin available": (
        lambda t: voids.ResidenceCondition(1e-10).margin(1e-6, t),
        ONE,
    ),
}
PLAIN: dict[str, Case] = {
    "FlowHistory position": (lambda x: history(position=x), HISTORY.position),
    "FlowHistory velocity": (lambda x: history(velocity=x), HISTORY.velocity),
    "FlowHistory gradient": (lambda x: history(gradient=x), HISTORY.gradient),
    "FlowHistory pressure": (lambda x: history(pressure=x), HISTORY.pressure),
    "FiberResponse surface": (
        lambda x: fiber.FiberResponse(6.0, 0.9, x, RESPONSE.basis),
        RESPONSE.surface,
    ),
    "FiberResponse basis": (
        lambda x: fiber.FiberResponse(6.0, 0.9, RESPONSE.surface, x),
        RESPONSE.basis,
    ),
    "StallCurve domain_size": (
        lambda x: fiber.StallCurve(6.0, x, CURVE.shape_factor, 0.0),
        CURVE.domain_size,
    ),
    "StallCurve shape_factor": (
        lambda x: fiber.StallCurve(6.0, CURVE.domain_size, x, 0.0),
        CURVE.shape_factor,
    ),
    "Distribution coefficients": (
        lambda x: distribution.Distribution(x, UNIFORM.degree),
        UNIFORM.coefficients,
    ),
    "Ellipsoid semi_axes": (fiber.Ellipsoid, np.array([3.0, 2.0, 1.0])),
    "FlowField.locate xy": (FIELD.locate, np.array([[0.2, 0.2]])),
    "follow initial_angles": (lambda x: fm.follow(HISTORY, 0.9, x), TIMES),
    "isotropic_pressure levels": (
        lambda x: fiber.isotropic_pressure(HISTORY, RESPONSE, 817.0, None, 20, x),
        HALF,
    ),
    "follow_directors directions": (
        lambda p: fiber.follow_directors(HISTORY, 0.9, p),
        AXIS[None],
    ),
    "follow_spatial directions": (
        lambda p: fiber.follow_spatial(HISTORY, 0.9, p),
        AXIS[None],
    ),
    "follow_ellipsoids frames": (
        lambda Q: fiber.follow_ellipsoids(HISTORY, ELLIPSOID, Q),
        np.eye(3)[None],
    ),
    "FiberModel.follow_in_space start": (
        lambda p: fiber.unbounded_model("spheroid", ELLIPSE).follow_in_space(HISTORY, p),
        AXIS[None],
    ),
    "follow_orientation history": (
        lambda L: fm.follow_orientation(FOLGAR, ORE, (np.array([0.0, 1.0]), L), ORIENTED),
        np.stack([PLANAR, PLANAR]),
    ),
    "follow_orientation a0": (lambda a: fm.follow_orientation(FOLGAR, ORE, HISTORY, a), ORIENTED),
    "follow_distribution gradient": (
        lambda L: fokker_planck.follow_distribution(np.array([0.0, 1.0]), L, 0.9, 1.0, degree=4),
        np.stack([SHEAR, SHEAR]),
    ),
    "follow_distribution diffusivity": (
        lambda d: fokker_planck.follow_distribution(
            np.array([0.0, 1.0]), np.stack([SHEAR, SHEAR]), 0.9, d, degree=4
        ),
        np.array([1.0, 1.0]),
    ),
    "steady_distribution gradient": (lambda L: fm.steady_distribution(L, 0.9, 1.0, 4), PLANAR),
    "rate_operator gradient": (lambda L: fokker_planck.rate_operator(L, 0.9, 1.0, 4), PLANAR),
    "steady_state L": (lambda L: fm.steady_state(FOLGAR, L, ORE), PLANAR),
    "steady_state start": (
        lambda a: fm.steady_state(FOLGAR, PLANAR, ORE, a),
        fm.steady_state(FOLGAR, PLANAR, ORE).a,
    ),
    "out_of_range a": (orientation.out_of_range, ORIENTED),
    "preferred_angle a": (orientation.preferred_angle, ORIENTED),
    "principal a": (orientation.principal, ORIENTED),
    "Distribution.density direction": (UNIFORM.density, AXIS[None]),
    "paper_domain_size interaction": (interaction.paper_domain_size, np.array([0.01])),
    "paper_preferred_angle interaction": (interaction.paper_preferred_angle, np.array([0.01])),
    "StallCurve.value domain_size": (CURVE.value, np.array([3.5])),
    "StallCurve.stall_angle domain_size": (CURVE.stall_angle, np.array([3.5])),
    "paper_stall_angle domain_size": (fiber.paper_stall_angle, np.array([3.5])),
    "body_axes direction": (fiber.body_axes, AXIS),
    "ellipse_extremes strain_11": (lambda x: fiber.ellipse_extremes(6.0, x, 0.0), ONE),
    "ellipse_extremes strain_12": (lambda x: fiber.ellipse_extremes(6.0, 0.0, x), ONE),
    "ellipse_pressure strain_11": (lambda x: fiber.ellipse_pressure(6.0, x, 0.0, 0.0), ONE),
    "ellipse_pressure strain_12": (lambda x: fiber.ellipse_pressure(6.0, 0.0, x, 0.0), ONE),
    "ellipse_pressure surface": (lambda x: fiber.ellipse_pressure(6.0, 0.0, 0.0, x), ONE),
    "ellipse_field gradient": (lambda L: fiber.ellipse_field(ELLIPSE, L, 0.0, OUTSIDE), PLANAR),
    "ellipse_field points": (lambda x: fiber.ellipse_field(ELLIPSE, PLANAR, 0.0, x), OUTSIDE),
    "ellipse_spin gradient": (lambda L: fiber.ellipse_spin(ELLIPSE, L, 0.0), PLANAR),
    "ellipse_torque gradient": (lambda L: fiber.ellipse_torque(ELLIPSE, L, 0.0, 0.0), PLANAR),
    "ellipsoid_field gradient": (lambda L: fiber.ellipsoid_field(BALL, L, 2.0 * AXIS), SHEAR),
    "ellipsoid_field points": (lambda x: fiber.ellipsoid_field(BALL, SHEAR, x), 2.0 * AXIS),
    "ellipsoid_field axes": (
        lambda Q: fiber.ellipsoid_field(BALL, SHEAR, 2.0 * AXIS, Q),
        np.eye(3),
    ),
    "embed_planar gradient": (fiber.embed_planar, PLANAR),
    "jeffery_director direction": (lambda p: fiber.jeffery_director(1.0, 1.0, 6.0, p), AXIS),
    "orbit_constant direction": (lambda p: fiber.orbit_constant(p, 6.0), AXIS),
    "orbit_phase direction": (lambda p: fiber.orbit_phase(p, 6.0), AXIS),
    "planar_directions angles": (fiber.planar_directions, TIMES),
    **{
        f"SpheroidResponse.{name} gradient": (
            lambda L, f=name: getattr(SPHEROID, f)(L, AXIS),
            SHEAR,
        )
        for name in (
            "rate",
            "angular_velocity",
            "surface_stress",
            "tip",
            "extremes",
            "extreme_values",
        )
    },
    **{
        f"SpheroidResponse.{name} direction": (
            lambda p, f=name: getattr(SPHEROID, f)(SHEAR, p),
            AXIS,
        )
        for name in (
            "rate",
            "angular_velocity",
            "surface_stress",
            "tip",
            "extremes",
            "extreme_values",
        )
    },
    "SpheroidResponse.bounds gradient": (SPHEROID.bounds, SHEAR),
    "SpheroidResponse.mildest gradient": (SPHEROID.mildest, SHEAR),
    "SpheroidResponse.eccentric_angle where": (lambda e: SPHEROID.eccentric_angle(e, AXIS), AXIS),
    "SpheroidResponse.eccentric_angle direction": (
        lambda p: SPHEROID.eccentric_angle(AXIS, p),
        AXIS,
    ),
    **{
        f"EllipsoidResponse.{name} gradient": (getattr(ELLIPSOID, name), SHEAR)
        for name in ("angular_velocity", "surface_stress", "extremes", "bounds", "mildest")
    },
    **{
        f"EllipsoidResponse.{name} {part}": (
            lambda x, f=name, k=place: getattr(ELLIPSOID, f)(*TURNED[:k], x, *TURNED[k + 1 :]),
            TURNED[place],
        )
        for name in ("turned_extremes", "turned_values")
        for place, part in enumerate(("gradient", "first", "second"))
    },
    "EllipsoidResponse.surface_pressure gradient": (
        lambda L: ELLIPSOID.surface_pressure(L, AXIS),
        SHEAR,
    ),
    "EllipsoidResponse.surface_pressure where": (
        lambda e: ELLIPSOID.surface_pressure(SHEAR, e),
        AXIS,
    ),
    "assess lowest_pressure": (lambda p: voids.assess(TIMES, p, 0.0), TIMES),
    "growth_exponent pressure": (
        lambda p: voids.growth_exponent(TIMES, p, 1.0, TIMES),
        TIMES,
    ),
    "growth_exponent vapor_pressure": (
        lambda p: voids.growth_exponent(TIMES, TIMES, p, TIMES),
        np.array(1.0),
    ),
    "growth_exponent viscosity": (
        lambda eta: voids.growth_exponent(TIMES, TIMES, 1.0, eta),
        TIMES,
    ),
    "grow radius": (lambda r: voids.grow(AROUND, BUBBLE, r, 1e-13, [0.9]), 1e-6 * ONE),
    "grow cell_volume": (lambda v: voids.grow(AROUND, BUBBLE, 1e-6, v, [0.9]), 1e-13 * ONE),
    **{
        f"Surroundings {name}": (
            lambda x, name=name: replace(AROUND, **{name: x}).arrays(),
            TIMES,
        )
        for name in ("pressure", "viscosity", "flow_rate", "fiber_pressure")
    },
    "viscous_resistance rate": (lambda e: voids.viscous_resistance(e, 0.1, THICK), ONE),
    "viscous_resistance squeezed": (lambda x: voids.viscous_resistance(1.0, x, THICK), HALF),
    "viscous_resistance flow_rate": (
        lambda rate: voids.viscous_resistance(1.0, 0.1, THICK, rate),
        ONE,
    ),
    "assess vapor_pressure": (lambda p: voids.assess(TIMES, TIMES, p), np.array(1.0)),
    "critical_moisture pressure": (lambda p: voids.critical_moisture(HENRY, p, HOT), PASCAL),
    "critical_moisture temperature": (lambda T: voids.critical_moisture(HENRY, 1e5, T), HOT),
    "critical_radius deficit": (lambda d: voids.critical_radius(0.02, d), PASCAL),
    "molecules_per_volume moisture": (lambda w: voids.molecules_per_volume(w, 1050.0), LITTLE),
    "saturation_pressure temperature": (voids.saturation_pressure, HOT),
    "tension_at_density density": (lambda x: voids.tension_at_density(0.02, x, 1050.0), 1e3 * ONE),
    "vapor_angle factor": (voids.vapor_angle, HALF),
    "wetting_factor angle": (voids.wetting_factor, HALF),
    "Arrhenius.diffusivity temperature": (
        voids.Arrhenius(1e-6, 3e3, (400.0, 600.0)).diffusivity,
        HOT,
    ),
    "LinearTension.at temperature": (
        voids.LinearTension(0.03, 503.15, -5e-5, (400.0, 600.0)).at,
        HOT,
    ),
    "Parachor.tension molar_volume": (voids.Parachor(1e-5).tension, LITTLE),
    "MechanicalCriterion.margin pressure": (voids.MechanicalCriterion(1e5).margin, PASCAL),
    "MechanicalCriterion.is_met pressure": (voids.MechanicalCriterion(1e5).is_met, PASCAL),
    "ResidenceCondition.time radius": (voids.ResidenceCondition(1e-10).time, LITTLE),
    "ResidenceCondition.margin radius": (
        lambda r: voids.ResidenceCondition(1e-10).margin(r, 1.0),
        LITTLE,
    ),
    **{
        f"ClassicalNucleation.{name} deficit": (getattr(CLASSICAL, name), PASCAL)
        for name in (
            "log10_barrier_ratio",
            "log10_rate",
            "margin",
            "required_wetting_factor",
            "required_contact_angle",
        )
    },
    "Henry.solubility temperature": (HENRY.solubility, HOT),
    **{
        f"{type(law).__name__}.{name}": case
        for law, T in ((HENRY, HOT), (ACTIVITY, HOT))
        for name, case in {
            "saturation_content temperature": (law.saturation_content, T),
            "vapor_pressure moisture": (lambda w, one=law, T=T: one.vapor_pressure(w, T), LITTLE),
            "vapor_pressure temperature": (lambda T, one=law: one.vapor_pressure(LITTLE, T), T),
            "moisture vapor_pressure": (lambda p, one=law, T=T: one.moisture(p, T), PASCAL),
            "moisture temperature": (lambda T, one=law: one.moisture(PASCAL, T), T),
        }.items()
    },
    "FreeVolume.volume_fraction solvent": (FREE.volume_fraction, LITTLE),
    "FreeVolume.self_diffusivity solvent": (lambda w: FREE.self_diffusivity(w, COLD), LITTLE),
    "FreeVolume.self_diffusivity temperature": (lambda T: FREE.self_diffusivity(LITTLE, T), COLD),
    "FreeVolume.diffusivity solvent": (lambda w: FREE.diffusivity(w, COLD), LITTLE),
    "FreeVolume.diffusivity temperature": (lambda T: FREE.diffusivity(LITTLE, T), COLD),
    "VolatileMelt.vapor_pressure moisture": (lambda w: MELT.vapor_pressure(w, HOT), LITTLE),
    "VolatileMelt.vapor_pressure temperature": (lambda T: MELT.vapor_pressure(LITTLE, T), HOT),
    "VolatileMelt.saturation_content temperature": (MELT.saturation_content, HOT),
    "VolatileMelt.critical_moisture pressure": (lambda p: MELT.critical_moisture(p, HOT), PASCAL),
    "VolatileMelt.critical_moisture temperature": (
        lambda T: MELT.critical_moisture(PASCAL, T),
        HOT,
    ),
}
KINDS: dict[str, tuple[Callable[[np.ndarray], object], str]] = {
    "masked": (lambda x: np.ma.masked_array(x, mask=np.ones(x.shape, bool)), "is masked"),
    "complex": (lambda x: x + 0j, "is complex"),
    "dates": (lambda x: np.zeros(x.shape, "M8[s]") + np.timedelta64(1, "s"), "holds dates"),
    "texts": (lambda x: x.astype(str), "is no array of numbers"),
    "truth values": (lambda x: x.astype(bool), "holds true and false"),
    "nothing": (lambda x: None, "is no array of numbers"),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", [*TIMED, *PLAIN])
def test_what_is_no_number_is_refused(name: str, kind: str) -> None:
    call, good = (TIMED | PLAIN)[name]
    spoil, said = KINDS[kind]
    optional = name in {"ellipsoid_field axes", "steady_state start"} or "zone_time" in name
    if kind == "nothing" and optional:
        return
    with pytest.raises(fm.FibermeltError, match=said):
        call(spoil(np.asarray(good)))


@pytest.mark.parametrize("name", PLAIN)
def test_a_duration_where_none_is_meant(name: str) -> None:
    call, good = PLAIN[name]
    call(good)  # as it was it is fine
    with pytest.raises(fm.FibermeltError, match=r"holds durations: give numbers in SI$"):
        call(np.zeros(np.shape(good), "m8[s]"))


@pytest.mark.parametrize("name", TIMED)
def test_a_duration_is_taken_for_its_seconds(name: str) -> None:
    call, good = TIMED[name]
    call((1e9 * np.asarray(good)).round().astype("m8[ns]"))


def taken() -> set[str]:
    """Return every parameter of a public function, or method, that takes an array."""
    found = set()
    for module in (fm, fiber, orientation, voids, distribution, fokker_planck, interaction):
        for name in module.__all__:
            value = getattr(module, name)
            functions = {name: value} if inspect.isfunction(value) else {}
            if inspect.isclass(value) and not getattr(value, "_is_protocol", False):
                methods = {k: v for k, v in vars(value).items() if inspect.isfunction(v)}
                functions = {f"{name}.{k}": v for k, v in methods.items() if k[0] != "_"}
            for key, function in functions.items():
                for one in inspect.signature(function).parameters.values():
                    if "ArrayLike" in str(one.annotation):
                        found.add(f"{key} {one.name}")
    return found


@pytest.mark.parametrize("name", sorted(taken()))
def test_the_list_is_complete(name: str) -> None:
    with_a_cell = {"follow_newton initial_angles"}  # goes through what `follow` does
    assert name in TIMED | PLAIN or name in with_a_cell
