"""Orientation tensors and closures: what they promise, against fiberoripy and known states."""

import numpy as np
import pytest
from examples_drawn import examples
from fiberoripy.closures import compute_closure
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.orientation.closure import CHUNK
from fibermelt.orientation.closures import CLOSURES, closure
from fibermelt.orientation.eigen import LAPACK_BATCH, eigenframe
from fibermelt.orientation.tensors import (
    TANGENTS,
    checked_orientation,
    isotropic,
    out_of_range,
    pack,
    preferred_angle,
    principal,
    unpack,
)

EVERY = pytest.mark.parametrize("name", CLOSURES)
IN_FIBERORIPY = ["linear", "quadratic", "hybrid", "ORF", "ORW", "ORW3", "IBOF"]

ROUNDING = 1e-12
"""Components are of order 1; IBOF adds terms of size 100, which leaves 1e-14."""

RATE = np.array([[0.3, 1.0, 0.2], [1.0, -0.5, 0.4], [0.2, 0.4, 0.2]])


def ensemble(seed: int, *, fibers: int = 6, tensors: int = 4, flatness: float = 0.3):
    """Tensors of a few fibers each: orthotropic, well inside the cone, eigenvalues apart."""
    rng = np.random.default_rng(seed)
    p = rng.normal(size=(tensors, fibers, 3)) * np.array([1.0, 0.6, flatness])
    p /= np.linalg.norm(p, axis=-1, keepdims=True)
    return np.einsum("nki,nkj->nij", p, p) / fibers


def rotation(seed: int):
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def turn(A, Q):
    return np.einsum("ia,jb,kc,ld,...abcd->...ijkl", Q, Q, Q, Q, A, optimize=True)


SEEDS = st.integers(0, 2**32 - 1)


@EVERY
@given(seed=SEEDS)
@examples(20)
def test_promises_and_frame_indifference(name, seed):
    law, a, Q = CLOSURES[name], ensemble(seed), rotation(seed)
    A = law.fourth(a)
    assert np.allclose(A, np.einsum("nijkl->njikl", A), atol=ROUNDING, rtol=0)
    assert np.allclose(A, np.einsum("nijkl->nklij", A), atol=ROUNDING, rtol=0)
    if law.is_fully_symmetric:
        assert np.allclose(A, np.einsum("nijkl->nikjl", A), atol=ROUNDING, rtol=0)
    assert law.keeps_normalization
    assert np.allclose(np.einsum("nijkk->nij", A), a, atol=ROUNDING, rtol=0)
    assert np.allclose(law.fourth(Q @ a @ Q.T), turn(A, Q), atol=10 * ROUNDING, rtol=0)


@EVERY
@given(seed=SEEDS)
@examples(20)
def test_contractions_are_those_of_the_tensor(name, seed):
    law, a = CLOSURES[name], ensemble(seed)
    # The poles of a fit make its derivative large where two eigenvalues nearly coincide.
    dA = law.fourth_derivative(a, TANGENTS)
    size = 1.0 + np.abs(dA).max()
    direct = np.einsum("nijkl,kl->nij", law.fourth(a), RATE)
    assert np.allclose(law.contract(a, RATE), direct, atol=ROUNDING, rtol=0)
    directions = law.contract_derivative(a, RATE, TANGENTS)
    expected = np.einsum("nqijkl,kl->nqij", dA, RATE)
    assert np.allclose(directions, expected, atol=ROUNDING * size, rtol=0)
    assert np.allclose(
        np.einsum("nqijkk->nqij", dA), TANGENTS, atol=ROUNDING * size, rtol=0
    )  # the derivative of a_ijkk = a_ij


@EVERY
def test_batches_broadcast(name):
    law, a = CLOSURES[name], ensemble(1, tensors=6)
    rates = np.random.default_rng(2).normal(size=(6, 3, 3))
    rates = rates + rates.swapaxes(-1, -2)
    grid = a.reshape(2, 3, 3, 3)
    assert law.fourth(grid).shape == (2, 3, 3, 3, 3, 3)
    assert law.fourth_derivative(grid, TANGENTS).shape == (2, 3, 5, 3, 3, 3, 3)
    each = law.contract(grid, rates.reshape(2, 3, 3, 3)).reshape(6, 3, 3)
    slopes = law.contract_derivative(grid, rates.reshape(2, 3, 3, 3), TANGENTS)
    for k in range(6):
        assert np.allclose(each[k], law.contract(a[k], rates[k]), atol=ROUNDING, rtol=0)
        one = law.contract_derivative(a[k], rates[k], TANGENTS)
        scale = ROUNDING * (1.0 + np.abs(one).max())
        assert np.allclose(slopes.reshape(6, 5, 3, 3)[k], one, atol=scale, rtol=0)
    many = law.contract_derivative(a[0], rates, TANGENTS)
    assert many.shape == (6, 5, 3, 3)
    assert np.allclose(many[0], law.contract_derivative(a[0], rates[0], TANGENTS), atol=1e-9)
    assert law.contract(a[0], rates).shape == (6, 3, 3)


@pytest.mark.parametrize("name", ["hybrid", "ORE", "IBOF"])
def test_large_batches_go_in_parts(name):
    law, few = CLOSURES[name], ensemble(11, tensors=10)
    rates = np.random.default_rng(12).normal(size=(10, 3, 3))
    rates = rates + rates.swapaxes(-1, -2)
    repeats = CHUNK // 10 + 2
    many = np.tile(few, (repeats, 1, 1)).reshape(2, -1, 3, 3)
    for rate in (RATE, np.tile(rates, (repeats, 1, 1)).reshape(2, -1, 3, 3)):
        expected = law.contract(few, rate if rate.ndim == 2 else rates)
        found = law.contract(many, rate)
        assert found.shape == many.shape
        last = found.reshape(-1, 10, 3, 3)[-1]
        assert np.allclose(last, expected, atol=ROUNDING, rtol=0)


@pytest.mark.parametrize("name", IN_FIBERORIPY)
def test_against_fiberoripy(name):
    a = ensemble(3, tensors=200)
    expected = compute_closure(a, name.upper())
    assert np.allclose(CLOSURES[name].fourth(a), expected, atol=ROUNDING, rtol=0)


@pytest.mark.parametrize("name", [n for n in CLOSURES if n != "quadratic"])
def test_random_fibers(name):
    d = np.eye(3)
    expected = (
        np.einsum("ij,kl->ijkl", d, d)
        + np.einsum("ik,jl->ijkl", d, d)
        + np.einsum("il,jk->ijkl", d, d)
    ) / 15.0
    # Fits too: the average over the arbitrary axes leaves nothing of their error here.
    assert np.allclose(CLOSURES[name].fourth(isotropic()), expected, atol=ROUNDING, rtol=0)


# (A_1111 - 1) of aligned and the largest component error of planar random fibers: the fits' own.
LIMITS = {
    "quadratic": (ROUNDING, None),
    "hybrid": (ROUNDING, None),
    "ORS": (ROUNDING, ROUNDING),
    "ORF": (0.0125, 0.0046),
    "ORL": (0.0035, 0.0042),
    "ORW": (0.00024, 2.1e-5),
    "ORW3": (0.00013, 0.00015),
    "ORE": (ROUNDING, ROUNDING),
    "IBOF": (0.00032, 2e-5),
    "exact": (2e-12, 2e-12),  # evaluated at the floor of 1e-12
}


@pytest.mark.parametrize("name", LIMITS)
def test_aligned_and_planar_random_fibers(name):
    law, Q = CLOSURES[name], rotation(5)
    aligned, planar = LIMITS[name]
    A = law.fourth(Q @ np.diag([1.0, 0.0, 0.0]) @ Q.T)
    p = Q[:, 0]
    assert np.allclose(A, np.einsum("i,j,k,l->ijkl", p, p, p, p), atol=aligned, rtol=0)
    if planar is not None:
        A = law.fourth(np.diag([0.5, 0.5, 0.0]))
        assert A[0, 0, 0, 0] == pytest.approx(3 / 8, abs=planar)
        assert A[0, 0, 1, 1] == pytest.approx(1 / 8, abs=planar)
        assert A[2, 2, 2, 2] == pytest.approx(0.0, abs=planar)


def test_orthotropic_smooth_has_the_published_six_components():
    """Rows A_2233, A_1133, A_1122 of the table follow from the normalisation."""
    first, second = 0.6, 0.3
    A = CLOSURES["ORS"].fourth(np.diag([first, second, 1.0 - first - second]))
    assert A[1, 1, 2, 2] == pytest.approx(0.20 - 0.20 * first - 0.20 * second, abs=ROUNDING)
    assert A[0, 0, 2, 2] == pytest.approx(0.20 - 0.20 * first - 0.20 * second, abs=ROUNDING)
    assert A[0, 0, 1, 1] == pytest.approx(-0.05 + 0.05 * first + 0.30 * second, abs=ROUNDING)


def test_closure_by_name():
    assert closure("ORE") is CLOSURES["ORE"]
    for wrong, near in (("ore", "ORE"), ("Exact", "exact"), ("quadratik", "quadratic")):
        with pytest.raises(ConfigError, match=f"did you mean '{near}'"):
            closure(wrong)
    with pytest.raises(ConfigError, match="known are linear, quadratic"):
        closure("??\n")
    assert all("doi:10." in each.source for each in CLOSURES.values())
    assert all(name == each.name for name, each in CLOSURES.items())


def test_exact_closure_refuses_what_no_distribution_has():
    a = np.diag([0.6, 0.4 + 1e-6, -1e-6])
    with pytest.raises(ConfigError, match="eigenvalue -1e-06"):
        CLOSURES["exact"].fourth(a)
    # The fits are evaluated as they stand: reported by out_of_range, never clipped.
    assert np.isfinite(CLOSURES["ORE"].fourth(a)).all()
    assert out_of_range(a) == pytest.approx(1e-6, rel=1e-9)


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (np.eye(3), "trace 3"),
        (np.eye(2) / 2, "shape"),
        (np.diag([np.nan, 0.5, 0.5]), "nan"),
        (np.diag([0.2, 0.5, 0.3]) + 1e-6 * np.eye(3, k=1), "not symmetric: component 12"),
        ([["a"]], "no array of numbers"),
    ],
)
def test_what_is_no_orientation_tensor(bad, message):
    with pytest.raises(ConfigError, match=message):
        checked_orientation(bad, "a0")


def test_checked_tensors_are_untouched():
    a = ensemble(7)
    assert np.array_equal(checked_orientation(a), a)
    outside = np.diag([1.2, -0.1, -0.1])
    assert np.array_equal(checked_orientation(outside), outside)
    assert out_of_range(outside) == pytest.approx(0.2, abs=ROUNDING)
    assert out_of_range(isotropic()) == 0.0


@pytest.mark.parametrize("angle", [0.0, 0.3, -1.2, np.pi / 2, -np.pi / 2 + 1e-6])
def test_preferred_angle(angle):
    Q = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    a = Q @ np.diag([0.7, 0.2, 0.1]) @ Q.T
    assert preferred_angle(a) == pytest.approx(angle, abs=1e-12)


@pytest.mark.parametrize("values", [[1 / 3] * 3, [0.4, 0.4, 0.2], [0.1, 0.2, 0.7]])
def test_no_preferred_angle_is_zero(values):
    assert preferred_angle(np.diag(values)) == 0.0


def test_five_numbers():
    a = ensemble(8)
    v = pack(a)
    assert np.allclose(unpack(v), a, atol=1e-15, rtol=0)
    slopes = np.stack([unpack(v + step) - unpack(v) for step in 0.5 * np.eye(5)], axis=1) / 0.5
    assert np.allclose(slopes, TANGENTS, atol=1e-15, rtol=0)
    assert np.all(np.trace(TANGENTS, axis1=1, axis2=2) == 0.0)


def test_both_ways_to_the_principal_axes_agree():
    rng = np.random.default_rng(9)
    a = ensemble(9, tensors=LAPACK_BATCH + 1)
    a[::3] = np.diag([0.4, 0.4, 0.2])
    a[1::7] = np.eye(3) / 3
    Q = rotation(10)
    a[2::11] = Q @ np.diag([0.5, 0.25, 0.25]) @ Q.T
    a[3::13, :2, 2] = a[3::13, 2, :2] = 0.0
    a *= rng.uniform(0.5, 2.0, size=(len(a), 1, 1))
    values, vectors = eigenframe(a)
    assert np.allclose(values, np.linalg.eigvalsh(a)[:, ::-1], atol=1e-14, rtol=0)
    again = np.einsum("nik,nk,njk->nij", vectors, values, vectors)
    assert np.allclose(again, a, atol=1e-14, rtol=0)
    assert np.allclose(vectors.swapaxes(1, 2) @ vectors, np.eye(3), atol=1e-14, rtol=0)
    few, _ = principal(a[:5])
    assert np.allclose(few, values[:5], atol=1e-14, rtol=0)


def test_small_tensors_among_large_ones():
    """Large batches are rotated together: a small tensor's rest was once a large one's rounding."""
    rng = np.random.default_rng(3)
    a = rng.normal(size=(400, 3, 3))
    a = (a + a.swapaxes(-1, -2)) * np.where(np.arange(400) < 10, 1e-9, 1e9)[:, None, None]
    a[10:] = np.diag([3e9, 2e9, 1e9])  # nothing to rotate there
    values, vectors = principal(a)
    back = np.einsum("nij,nj,nkj->nik", vectors, values, vectors)
    size = np.max(np.abs(a), axis=(1, 2))
    assert np.max(np.max(np.abs(back - a), axis=(1, 2)) / size) < 1e-14  # some tens of roundings
