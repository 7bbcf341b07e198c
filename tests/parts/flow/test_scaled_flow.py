"""Flows that are multiples of one: computed once, and as good as solved by themselves."""

from __future__ import annotations

import numpy as np
import pytest

from fibermelt.engine.stages import Parameters, stage_parameters
from fibermelt.flow.problem import FlowNumerics
from fibermelt.parts.flow.config import FLOW_NUMERICS
from fibermelt.parts.flow.stages import flow_scaled, flow_stage
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import resolve

(FLOW,) = (stage for stage in CHAIN.stages if stage.name == "flow")
COARSE = FlowNumerics().coarsened(4.0)
PAPER = {
    **stage_parameters(FLOW, resolve({}).values()),
    **{key: getattr(COARSE, key.removeprefix("numerics.")) for key in FLOW_NUMERICS},
}
CARREAU = {
    **dict.fromkeys(key for key in PAPER if key.startswith("law.")),
    "law.name": "carreau",
    "law.viscosity": 817.0,
    "law.index": 0.35,
    "law.time_constant": 1.0,
    "law.transition": 2.0,
    "law.infinite_viscosity": 0.0,
}
pytestmark = pytest.mark.verification

SPEEDS = ("flow.inlet_speed", "flow.bed_speed")


def _of(law: dict[str, object], faster: float = 1.0) -> Parameters:
    speeds = {key: faster * PAPER[key] for key in SPEEDS}
    return Parameters({**PAPER, **law, **speeds})


@pytest.mark.parametrize(
    ("base", "law", "faster"),
    [
        pytest.param({}, {"law.viscosity": 5000.0}, 1.0, id="another melt"),
        pytest.param({}, {"law.viscosity": 300.0}, 1.7, id="another melt, faster"),
        pytest.param(CARREAU, {"law.viscosity": 81.7}, 1.0, id="all viscosities by a factor"),
        pytest.param(CARREAU, {"law.time_constant": 0.5}, 2.0, id="speeds and time constant"),
    ],
)
def test_what_scales_exactly_is_one_flow(
    base: dict[str, object], law: dict[str, object], faster: float
) -> None:
    parameters = _of({**base, **law}, faster)
    scaled = flow_scaled(parameters)
    assert dict(scaled.reference) == dict(flow_scaled(_of(base)).reference)
    found = scaled.of(flow_stage(scaled.reference, {}, str))
    solved = flow_stage(parameters, {}, str)
    assert set(found.variables) == set(solved.variables)
    if found.sizes != solved.sizes:
        # Rounding of a constant has decided over the mesh: then the two differ by their errors.
        for name in ("contact_point", "inlet_pressure"):
            assert abs(found[name] - solved[name]) < 2 * solved[f"{name}_error"]
        return
    for name, variable in solved.variables.items():
        # A pure number is told against one: of a mass imbalance of 1e-8 no digit is sure.
        top = max(np.abs(variable.values).max(), float(variable.attrs["units"] == "1"))
        # 1e-12 of a constant, and the order in which threads add up, carried through a Newton.
        np.testing.assert_allclose(found[name].values, variable.values, rtol=0, atol=1e-9 * top)


def test_what_does_not_scale_is_another_flow() -> None:
    def key(law: dict[str, object], faster: float = 1.0, **others: float) -> dict[str, object]:
        changed = {name.replace("__", "."): value for name, value in others.items()}
        return dict(flow_scaled(Parameters({**_of(law, faster), **changed})).reference)

    assert key(CARREAU) != key(CARREAU, 2.0)
    assert key({}) != key({}, flow__bed_speed=0.2)
    assert key({}) != key({}, flow__gap=3.1e-3)
    assert key({}) != key(CARREAU)
    # A law that does not thin is a Newtonian melt, whatever it is called.
    assert key({}) == key({**CARREAU, "law.index": 1.0, "law.viscosity": 12.0})


@pytest.mark.parametrize("faster", [0.25, 1.7, 1.0 / 3.0])
def test_the_flow_of_the_paper_is_its_own_reference(faster: float) -> None:
    full = stage_parameters(FLOW, resolve({}).values())
    found = flow_scaled(full)
    assert dict(found.reference) == dict(full)
    assert set(found.factors.values()) == {1.0}
    speeds = {key: faster * full[key] for key in SPEEDS}
    assert dict(flow_scaled(Parameters({**full, **speeds})).reference) == dict(full)
