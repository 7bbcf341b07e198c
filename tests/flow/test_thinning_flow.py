"""The deposition flow of a melt that thins: exact parts, balances, scaling, an independent code."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fibermelt.errors import ConfigError
from fibermelt.flow.deposition import FlowSolution, _inlet_pressure, solve_deposition
from fibermelt.flow.problem import Deposition, FlowNumerics, Nozzle
from fibermelt.flow.rescale import rescaled, scaled_constants
from fibermelt.flow.search import SurfaceSearch
from fibermelt.flow.start import StartShape, surfaces_from
from fibermelt.flow.streamlines import trace_streamlines
from fibermelt.melt import CarreauYasuda, Newtonian, PowerLaw, ViscosityLaw
from fibermelt.melt.slit import SlitFlow
from fibermelt.verify.flow import line_flux

pytestmark = pytest.mark.verification

COARSE = FlowNumerics().coarsened(4.0)
THINNING = Deposition(Nozzle(), CarreauYasuda(817.0, 0.35, 1.0))


@pytest.fixture(scope="module")
def thinning_flow() -> FlowSolution:
    return solve_deposition(THINNING)


def test_another_code_finds_the_same_bead(thinning_flow: FlowSolution) -> None:
    # a prototype, with a parabola at its inlet: contact and heel to its printed digits
    assert thinning_flow.contact_point == pytest.approx(-2.957e-3, abs=1.5e-6)
    assert thinning_flow.heel == pytest.approx(-3.465e-3, abs=1.5e-6)
    # the parabola costs it 1 % of the inlet's pressure until the melt has forgotten it
    assert thinning_flow.inlet_pressure == pytest.approx(0.0491e6, rel=1e-2)


def test_balances_are_those_of_a_newtonian_melt(thinning_flow: FlowSolution) -> None:
    problem, nozzle = THINNING, THINNING.nozzle
    half = nozzle.capillary_width / 2
    heights = np.linspace(nozzle.gap * 1.02, nozzle.capillary_entrance * 0.999, 6)
    stations = [line_flux(thinning_flow, (half, y), (-half, y)) for y in heights]
    np.testing.assert_allclose(np.abs(stations), problem.flux, rtol=1e-4)
    assert thinning_flow.mass_imbalance < 1e-6
    assert thinning_flow.kinematic_residual < 1e-4
    drift = [line.drift for line in trace_streamlines(thinning_flow, count=22, points=200)]
    # a Newtonian melt: 7e-6; one that thins has the steeper layer at the walls
    assert np.median(drift) < 3e-5


def test_the_stated_error_holds_against_a_finer_mesh(thinning_flow: FlowSolution) -> None:
    # two meshes may agree by chance, and then state too little: the middle one of three
    meshes = [FlowNumerics().coarsened(factor) for factor in (3.6, 4.0, 4.4)]
    coarse = [solve_deposition(THINNING, numerics) for numerics in meshes]
    for name in ("contact_point", "heel", "inlet_pressure"):
        off = np.median([abs(getattr(one, name) - getattr(thinning_flow, name)) for one in coarse])
        # as for a Newtonian melt: twice what is stated, and what the finer mesh states
        stated = np.median([getattr(one.error, name) for one in coarse])
        assert off < 2 * (stated + getattr(thinning_flow.error, name)), name


def test_viscosity_follows_the_rate_on_nodes_and_paths(thinning_flow: FlowSolution) -> None:
    field, melt = thinning_flow.field, THINNING.melt
    np.testing.assert_allclose(field.viscosity, melt.viscosity_at(field.shear_rate), rtol=1e-9)
    history = trace_streamlines(thinning_flow, count=2, points=60)[0].history
    assert history.viscosity is not None
    np.testing.assert_allclose(history.viscosity, melt.viscosity_at(history.shear_rate))


@pytest.mark.slow
@pytest.mark.parametrize("index", [0.25, 0.5])
def test_pressure_falls_along_a_long_capillary_as_in_a_slit(index: float) -> None:
    """Mean over the section, two widths and more from both ends of a capillary of six."""
    nozzle = Nozzle(capillary_length=6 * 3.175e-3)
    law = PowerLaw(8213.0, index, lowest_rate=1e-2)
    flow = solve_deposition(Deposition(nozzle, law))
    field, W = flow.field, nozzle.capillary_width
    nodes, weights = np.polynomial.legendre.leggauss(60)

    def along(values: np.ndarray, widths: float) -> np.ndarray:
        y = np.full(60, nozzle.gap + widths * W)
        return field.evaluate(values, field.locate(np.column_stack([0.5 * W * nodes, y])))

    p = [0.5 * weights @ along(field.pressure, widths) for widths in (2.0, 4.0)]
    U = flow.problem.flux / W
    wall = (2 * U / W) * (2 * index + 1) / index
    exact = 2 * law.consistency / W * wall**index
    assert (p[1] - p[0]) / (2 * W) == pytest.approx(exact, rel=1e-3)
    profile = SlitFlow(law, W, U).velocity(0.5 * W * nodes)
    # half a per cent of the mean speed where the profile of a plug bends
    np.testing.assert_allclose(-along(field.velocity, 3.0)[:, 1], profile, atol=5e-3 * U)


def test_an_index_of_nearly_one_is_newtonian(coarse_flow: FlowSolution) -> None:
    start = StartShape(coarse_flow.upstream_surface, coarse_flow.downstream_surface)
    found = []
    for law in (CarreauYasuda(817.0, 1 - 1e-7, 1.0), Newtonian(817.0)):
        problem = Deposition(Nozzle(), law)
        # from one start, as another last bit of it is enough for another mesh
        search = SurfaceSearch(problem)
        flow, surfaces = search.converge(surfaces_from(start, problem), COARSE)
        found.append([*surfaces.upstream[-1], surfaces.upstream[:, 0].min(), _inlet_pressure(flow)])
    # 1e-7 of index is 3e-7 of viscosity at the flow's rates
    np.testing.assert_allclose(found[0], found[1], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    ("law", "speed"),
    [
        pytest.param(THINNING.melt.scaled(viscosity=0.1), 1.0, id="all viscosities by a factor"),
        pytest.param(THINNING.melt.scaled(time=0.5), 2.0, id="speeds and time constant together"),
    ],
)
def test_what_scales_exactly(law: ViscosityLaw, speed: float, thinning_flow: FlowSolution) -> None:
    problem = replace(
        THINNING,
        melt=law,
        inlet_speed=speed * THINNING.inlet_speed,
        bed_speed=speed * THINNING.bed_speed,
    )
    assert scaled_constants(problem) == scaled_constants(THINNING)
    coarse = solve_deposition(THINNING, COARSE)
    solved, scaled = solve_deposition(problem, COARSE), rescaled(coarse, problem)
    assert scaled.contact_point == pytest.approx(solved.contact_point, rel=1e-9)
    assert scaled.inlet_pressure == pytest.approx(solved.inlet_pressure, rel=1e-9)
    np.testing.assert_allclose(
        scaled.field.viscosity, problem.melt.viscosity_at(scaled.field.shear_rate), rtol=1e-9
    )


def test_what_does_not_scale_is_refused(coarse_flow: FlowSolution) -> None:
    faster = replace(
        THINNING, inlet_speed=2 * THINNING.inlet_speed, bed_speed=2 * THINNING.bed_speed
    )
    assert scaled_constants(faster) != scaled_constants(THINNING)
    with pytest.raises(ConfigError, match="the melt thins otherwise at its rates"):
        rescaled(coarse_flow, faster)
    assert scaled_constants(Deposition(Nozzle(), Newtonian(1.0))) == ("Newtonian",)


@pytest.mark.slow
@pytest.mark.parametrize(
    "law",
    [
        pytest.param(CarreauYasuda(817.0, 0.25, 0.01), id="0.25, 0.01 s"),
        pytest.param(CarreauYasuda(817.0, 0.25, 10.0), id="0.25, 10 s"),
        pytest.param(CarreauYasuda(817.0, 0.5, 0.1), id="0.5, 0.1 s"),
        pytest.param(CarreauYasuda(5000.0, 0.3, 1.0, 0.0, 0.5), id="Yasuda"),
        pytest.param(PowerLaw(25836.0, 0.25), id="power law 0.25"),
        pytest.param(PowerLaw(817.0, 1.3), id="thickening"),
    ],
)
def test_every_melt_flows_from_cold(law: ViscosityLaw) -> None:
    flow = solve_deposition(Deposition(Nozzle(), law), COARSE)
    assert flow.mass_imbalance < 1e-5
    assert flow.error.contact_point < 0.02 * 3.175e-3
