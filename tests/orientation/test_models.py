"""What every orientation model keeps, with every closure; the models against their reference."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any

import fiberoripy.orientation as reference
import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fibermelt import orientation
from fibermelt.errors import ConfigError, HistoryError
from fibermelt.orientation.closures import CLOSURES
from fibermelt.orientation.flows import (
    FLOWS,
    checked_gradient,
    embedded,
    flow_gradient,
    shear_rate,
    strain_and_spin,
)
from fibermelt.orientation.models import (
    ARDRSC,
    IARD,
    MODELS,
    MRD,
    PARD,
    RSC,
    FolgarTucker,
    Jeffery,
    Nematic,
    OrientationModel,
    model_class,
    shape_factor,
)
from fibermelt.orientation.tensors import pack, unpack

Array = NDArray[np.float64]

XI = 0.9
ALL: tuple[OrientationModel, ...] = (
    Jeffery(XI),
    FolgarTucker(XI, 0.01),
    RSC(XI, 0.01, 0.3),
    ARDRSC(XI, 0.01, 0.02, -0.01, 0.03, 0.04, kappa=0.4),
    IARD(XI, 0.01, 0.6),
    PARD(XI, 0.01, 0.7),
    MRD(XI, 0.01),
    Nematic(XI, 0.01, 0.05),
)
REFERENCE: dict[str, tuple[Callable[..., Array], dict[str, float]]] = {
    "jeffery": (reference.jeffery_ode, {}),
    "folgar-tucker": (reference.folgar_tucker_ode, {"Ci": 0.01}),
    "rsc": (reference.rsc_ode, {"Ci": 0.01, "kappa": 0.3}),
    "ard-rsc": (
        reference.ard_rsc_ode,
        {"b1": 0.01, "b2": 0.02, "b3": -0.01, "b4": 0.03, "b5": 0.04, "kappa": 0.4},
    ),
    "iard": (reference.iard_ode, {"Ci": 0.01, "Cm": 0.6}),
    "pard": (reference.pard_ode, {"Ci": 0.01, "Omega": 0.7}),
    "mrd": (reference.mrd_ode, {"Ci": 0.01}),
    "nematic": (reference.maier_saupe_ode, {"Ci": 0.01, "U0": 0.05}),
}
ROUNDING = 1e-11
"""Of rates of order one: the closure IBOF sums terms up to 1e4 times its result."""

seeds = st.integers(0, 2**32 - 1)
every_model = pytest.mark.parametrize("model", ALL, ids=lambda model: model.name)
every_closure = pytest.mark.parametrize("name", CLOSURES)


def sample(seed: int, count: int = 8) -> tuple[Array, Array]:
    """Tensors of twelve random fibers each, and gradients of size about one."""
    rng = np.random.default_rng(seed)
    p = rng.normal(size=(count, 12, 3)) * rng.uniform(0.3, 1.0, size=(count, 1, 3))
    p /= np.linalg.norm(p, axis=-1, keepdims=True)
    L = rng.normal(size=(count, 3, 3))
    L -= np.trace(L, axis1=-2, axis2=-1)[:, None, None] * np.eye(3) / 3.0
    return np.einsum("cni,cnj->cij", p, p) / 12.0, L


@every_model
@every_closure
@examples(5)
@given(seed=seeds)
def test_the_rate_is_symmetric_traceless_and_objective(
    model: OrientationModel, name: str, seed: int
) -> None:
    a, L = sample(seed)
    rate = model.rate(a, L, CLOSURES[name])
    assert np.max(np.abs(rate - rate.swapaxes(-1, -2))) < ROUNDING
    assert np.max(np.abs(np.trace(rate, axis1=-2, axis2=-1))) < ROUNDING
    Q = Rotation.random(rng=seed).as_matrix()
    turned = model.rate(Q @ a @ Q.T, Q @ L @ Q.T, CLOSURES[name])
    # eigenvectors, where a model uses them, turn by rounding over the gap of the eigenvalues
    values = np.linalg.eigvalsh(a)
    gap = min(1.0, float(np.min(np.diff(values, axis=-1))))
    assert np.max(np.abs(turned - Q @ rate @ Q.T)) < ROUNDING * (1.0 + 1e-2 / gap)


@every_model
@every_closure
def test_without_strain_isotropy_stays(model: OrientationModel, name: str) -> None:
    spinning = np.array([[0.0, 2.0, -1.0], [-2.0, 0.0, 3.0], [1.0, -3.0, 0.0]])
    for L in (spinning, np.zeros((3, 3))):
        rate = model.rate(np.eye(3) / 3.0, L, CLOSURES[name])
        assert np.max(np.abs(rate)) < 1e-15


@every_model
def test_without_diffusion_every_model_is_jefferys(model: OrientationModel) -> None:
    a, L = sample(3)
    faint = model.scaled(1e-300).without_retardation()
    if isinstance(faint, Nematic):
        faint = FolgarTucker(XI, faint.interaction)
    expected = Jeffery(XI).rate(a, L, CLOSURES["ORE"])
    assert np.max(np.abs(faint.rate(a, L, CLOSURES["ORE"]) - expected)) < 1e-14


@every_model
@examples(10)
@given(seed=seeds)
def test_models_agree_with_fiberoripy(model: OrientationModel, seed: int) -> None:
    tensors, gradients = sample(seed, 2)
    law, parameters = REFERENCE[model.name]
    for name in ("quadratic", "IBOF"):
        for a, L in zip(tensors, gradients, strict=True):
            D, W = strain_and_spin(L)
            expected = law(a, CLOSURES[name].fourth(a), D, W, XI, **parameters)
            gap = float(np.min(np.diff(np.linalg.eigvalsh(a))))
            difference = np.abs(model.rate(a, L, CLOSURES[name]) - expected)
            assert np.max(difference) < 1e-12 * (1.0 + 1e-2 / gap)


@every_model
@every_closure
def test_the_jacobian_is_the_derivative(model: OrientationModel, name: str) -> None:
    Q = Rotation.from_euler("xyz", [0.3, -0.5, 0.8]).as_matrix()
    a = Q @ np.diag([0.6, 0.27, 0.13]) @ Q.T
    L, closure = sample(5, 1)[1][0], CLOSURES[name]
    v, h = pack(a), 1e-4

    def rise(step: float) -> Array:
        moved = [
            (
                model.rate_components(unpack(v + step * e), L, closure)
                - model.rate_components(unpack(v - step * e), L, closure)
            )
            / (2.0 * step)
            for e in np.eye(5)
        ]
        return np.stack(moved, axis=-1)

    # Richardson: the error is h^4 times fifth derivatives, IBOF's of order 1e8, and rounding/h
    expected = (4.0 * rise(h) - rise(2.0 * h)) / 3.0
    jacobian = model.jacobian(a, L, closure)
    assert np.max(np.abs(jacobian - expected)) < 1e-8
    batch = model.jacobian(np.stack([a, a]), L, closure)
    assert np.max(np.abs(batch - jacobian)) < 1e-12


@pytest.mark.parametrize("model", [RSC(XI, 0.01, 0.3), PARD(XI, 0.01, 0.7), MRD(XI, 0.01)])
def test_the_derivative_where_eigenvalues_coincide(model: OrientationModel) -> None:
    """Along a change that keeps them together it is an ordinary derivative."""
    a, change, h = np.diag([0.6, 0.2, 0.2]), np.diag([1.0, -0.5, -0.5]), 1e-4
    L, closure = FLOWS["uniaxial"], CLOSURES["quadratic"]
    rise = model.rate(a + h * change, L, closure) - model.rate(a - h * change, L, closure)
    found = model.derivative(a, L, closure, change[None])[0]
    assert np.max(np.abs(found - rise / (2.0 * h))) < 1e-8  # h^2 times third derivatives


def test_one_is_no_retardation_and_less_slows_the_eigenvalues_only() -> None:
    a, L = sample(11)
    closure = CLOSURES["ORE"]
    plain = FolgarTucker(XI, 0.01).rate(a, L, closure)
    assert np.array_equal(RSC(XI, 0.01, 1.0).rate(a, L, closure), plain)
    vectors = np.linalg.eigh(a)[1]
    inward = vectors.swapaxes(-1, -2) @ plain @ vectors
    slow = vectors.swapaxes(-1, -2) @ RSC(XI, 0.01, 0.2).rate(a, L, closure) @ vectors
    expected = np.where(np.eye(3, dtype=bool), 0.2 * inward, inward)
    assert np.max(np.abs(slow - expected)) < 1e-12


def test_from_isotropy_the_whole_rate_is_slowed() -> None:
    """The eigenvectors there are those the tensor will have, not those of the axes."""
    L, closure, a = FLOWS["simple-shear"], CLOSURES["ORE"], np.eye(3) / 3.0
    plain = FolgarTucker(XI, 0.01).rate(a, L, closure)
    assert np.max(np.abs(RSC(XI, 0.01, 0.2).rate(a, L, closure) - 0.2 * plain)) < 1e-15


@pytest.mark.parametrize("model", [PARD(XI, 0.01, 0.7), MRD(XI, 0.01)])
def test_from_isotropy_diffusion_follows_the_strain(model: PARD | MRD) -> None:
    D, W = strain_and_spin(FLOWS["simple-shear"])
    found = model.diffusion_tensor(np.eye(3) / 3.0, D)
    nearly = model.diffusion_tensor(np.eye(3) / 3.0 + 1e-4 * D, D)
    assert np.max(np.abs(found - nearly)) < 1e-12
    alike = model.diffusion_tensor(np.eye(3) / 3.0, 0.0 * W)
    assert np.max(np.abs(alike - 0.01 * np.mean(model.weights) * np.eye(3))) < 1e-16


def test_the_papers_rate_is_larger_by_the_root_of_two() -> None:
    a, L = sample(7)
    larger = FolgarTucker(XI, 0.01 * np.sqrt(2.0)).rate(a, L, CLOSURES["ORE"])
    paper = FolgarTucker(XI, 0.01, convention="paper").rate(a, L, CLOSURES["ORE"])
    assert np.max(np.abs(paper - larger)) < 1e-15


@pytest.mark.parametrize("potential", [0.1, 0.15, 0.2])
def test_isotropy_turns_nematic_above_fifteen_times_the_interaction(potential: float) -> None:
    """Spheres, so that only diffusion and potential act; near isotropy "linear" is exact."""
    L = FLOWS["planar"]
    jacobian = Nematic(0.0, 0.01, potential).jacobian(np.eye(3) / 3.0, L, CLOSURES["linear"])
    expected = 2.0 * (0.4 * potential - 0.06) * np.eye(5)
    assert np.max(np.abs(jacobian - expected)) < 1e-14


def test_special_cases_of_the_diffusion_tensors() -> None:
    a, L = sample(13)
    closure = CLOSURES["ORE"]
    plain = FolgarTucker(XI, 0.01).rate(a, L, closure)
    for model in (
        ARDRSC(XI, 0.01),
        IARD(XI, 0.01, 0.0),
        MRD(XI, 0.01, 1.0, 1.0, 1.0),
        Nematic(XI, 0.01, 0.0),
    ):
        assert np.max(np.abs(model.rate(a, L, closure) - plain)) < 1e-13
    D = strain_and_spin(FLOWS["simple-shear"])[0]
    C = IARD(XI, 0.01, 0.6).diffusion_tensor(np.eye(3) / 3.0, D)
    assert np.max(np.abs(C - 0.01 * np.diag([0.4, 0.4, 1.0]))) < 1e-16


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: FolgarTucker(XI, 0.0), "interaction = 0 must be positive: take the model 'jeff"),
        (lambda: FolgarTucker(XI, -0.01), "interaction = -0.01"),
        (lambda: FolgarTucker(XI, float("nan")), "interaction = nan"),
        (lambda: FolgarTucker(1.5, 0.01), "shape_factor = 1.5 must be in"),
        (lambda: RSC(XI, 0.01, 0.0), "kappa = 0"),
        (lambda: RSC(XI, 0.01, 1.1), "kappa = 1.1"),
        (lambda: ARDRSC(XI, 0.0), "b1 to b5 are all 0"),
        (lambda: ARDRSC(XI, 0.01, b5=float("inf")), "b5 = inf"),
        (lambda: ARDRSC(XI, 0.01, kappa=2.0), "kappa = 2"),
        (lambda: IARD(XI, 0.01, 1.2), "anisotropy = 1.2"),
        (lambda: IARD(XI, 0.0, 0.2), "interaction = 0"),
        (lambda: PARD(XI, 0.01, 0.2), "anisotropy = 0.2"),
        (lambda: MRD(XI, 0.01, third=0.0), "third = 0"),
        (lambda: Nematic(XI, 0.01, -1.0), "potential = -1"),
        (lambda: FolgarTucker(XI, 0.01, convention="papre"), "did you mean 'paper'"),
        (lambda: MRD(XI, 0.01, convention="Standard"), "did you mean 'standard'"),
        (lambda: model_class("folger-tucker"), "did you mean 'folgar-tucker'"),
        (lambda: flow_gradient("shear"), "did you mean 'simple-shear'"),
        (lambda: shape_factor(0.0), "aspect_ratio = 0"),
    ],
)
def test_bad_input_is_refused_with_its_name(make: Callable[[], Any], words: str) -> None:
    with pytest.raises(ConfigError) as caught:
        make()
    assert words in str(caught.value)


def test_names_lead_to_their_models() -> None:
    assert [model_class(model.name) for model in ALL] == [type(model) for model in ALL]
    assert len(MODELS) == len(ALL)
    assert shape_factor(6.0) == pytest.approx(35.0 / 37.0, rel=1e-15)


def test_public_names_are_where_the_package_says() -> None:
    for name in orientation.__all__:
        assert not isinstance(getattr(orientation, name), ModuleType), name
    assert dir(orientation) == sorted(orientation.__all__)
    assert orientation.shape_factor is shape_factor
    with pytest.raises(AttributeError, match="attribute closures_"):
        _ = orientation.closures_


def test_flows_have_the_rates_their_table_says() -> None:
    squares = {"simple-shear": 1.0, "uniaxial": 3.0, "biaxial": 12.0, "planar": 4.0, "mixed": 5.0}
    for name, square in squares.items():
        L = flow_gradient(name)
        assert np.trace(L) == 0.0
        assert shear_rate(strain_and_spin(L)[0]) ** 2 == pytest.approx(square, rel=1e-15)
    assert flow_gradient("simple-shear")[0, 1] == 1.0
    assert set(squares) == set(FLOWS)


def test_planar_gradients_are_embedded_and_impossible_ones_refused() -> None:
    planar = np.array([[1.0, 2.0], [3.0, -1.0]])
    whole = embedded(planar)
    assert np.array_equal(whole[:2, :2], planar)
    assert not np.any(whole[2])
    assert not np.any(whole[:, 2])
    with pytest.raises(HistoryError, match=r"shape \(3,\)"):
        checked_gradient(np.zeros(3))
    with pytest.raises(HistoryError, match="trace 3"):
        checked_gradient(np.eye(3))
    with pytest.raises(HistoryError, match="not finite"):
        checked_gradient(np.full((2, 2), np.nan))
