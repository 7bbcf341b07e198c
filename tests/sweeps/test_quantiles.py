"""Quantiles of a population: their rule, weights, and that they converge to the exact ones.

The response is one in closed form, the lowest pressure on an unbounded ellipse in simple shear,
``-mu gamma_dot (1 + r_e)``: its quantiles are those of the aspect ratio, mirrored.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate
from swept_cases import made_up

from fibermelt.sweeps.distributions import Truncated, Weibull
from fibermelt.sweeps.quantiles import LEVELS, quantiles, shares_below
from fibermelt.sweeps.table import sweep_table

VISCOSITY, RATE = 817.0, 1.0

POPULATION = Truncated(Weibull(7.0, 2.0), 1.0, 50.0)
TABLE = (
    '"fiber.aspect_ratio" = {{ scale = 7, shape = 2, between = [1, 50] }}\n'
    'design = "{}"\nsamples = {}\nseed = {}\nweight = "fiber.aspect_ratio"\n'
)
ROUNDING = 1e-12


def lowest(point):
    """Lowest surface pressure on an ellipse in simple shear [Pa]."""
    return -VISCOSITY * RATE * (1 + point["fiber.aspect_ratio"])


def exact(level):
    return lowest({"fiber.aspect_ratio": POPULATION.at(1 - level)})


def population(tmp_path, design, samples, seed=0):
    numbers = {"inlet_pressure": ("Pa", lowest)}
    return sweep_table(made_up(tmp_path, TABLE.format(design, samples, seed), numbers))


def found(table, levels=LEVELS, weights=None):
    # The response is told in MPa.
    return 1e6 * quantiles(table.responses[0].values, levels, weights)


def test_each_value_stands_in_the_middle_of_its_share():
    values, shares = shares_below(np.array([3.0, np.nan, 1.0, 2.0, 4.0]))
    assert (values.tolist(), shares.tolist()) == ([1, 2, 3, 4], [0.125, 0.375, 0.625, 0.875])
    np.testing.assert_allclose(quantiles(values, (0.05, 0.5, 0.95)), [1.0, 2.5, 4.0])
    np.testing.assert_allclose(quantiles(np.append(np.arange(101.0), np.nan)), [4.55, 50, 95.45])
    assert np.isnan(quantiles(np.array([np.nan]))).all()


def test_the_rule_is_hazens():
    values = np.random.default_rng(3).normal(size=37)
    expected = np.quantile(values, LEVELS, method="hazen")
    np.testing.assert_allclose(quantiles(values), expected, rtol=ROUNDING)


@given(st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(0.1, 10)), min_size=1, max_size=30))
def test_weights_that_are_alike_change_nothing_and_none_leaves_the_range(pairs):
    values, weights = np.array(pairs).T
    alike = quantiles(values, LEVELS, np.full(len(values), weights[0]))
    np.testing.assert_allclose(alike, quantiles(values), atol=1e-9)
    low, middle, high = quantiles(values, LEVELS, weights)
    assert values.min() <= low <= middle <= high <= values.max()


def test_a_weight_is_the_share_that_a_value_stands_for():
    # Half of the weight lies below the middle of the heavy case.
    assert quantiles(np.array([1.0, 2.0, 3.0]), (0.5,), np.array([1.0, 8.0, 1.0]))[0] == 2.0
    middle = quantiles(np.array([1.0, 2.0]), (0.5,), np.array([1.0, 3.0]))[0]
    assert middle == pytest.approx(1 + (0.5 - 0.125) / (0.625 - 0.125), rel=ROUNDING)


@pytest.mark.parametrize("design", ["latin-hypercube", "sobol"])
@pytest.mark.parametrize("samples", [32, 64])
def test_quantiles_err_by_a_stratum_at_most(tmp_path, design, samples):
    # There is one sample in each stratum: the quantile lies within a stratum's width around.
    quantile = found(population(tmp_path, design, samples))
    for level, value in zip(LEVELS, quantile, strict=True):
        assert exact(max(0.0, level - 1 / samples)) <= value <= exact(level + 1 / samples)


@pytest.mark.parametrize("design", ["latin-hypercube", "sobol"])
def test_quantiles_converge_to_the_exact_ones_with_first_order(design):
    # Independent samples converge with order 1/2.
    sizes, seeds = (64, 256, 1024), range(40)
    errors = [
        np.sqrt(np.mean([_error(design, size, seed) ** 2 for seed in seeds])) for size in sizes
    ]
    orders = np.log(np.array(errors[:-1]) / errors[1:]) / np.log(4)
    # 40 seeds know a root mean square to 11 %, the order between two sizes to 0.11: twice that.
    np.testing.assert_allclose(orders, 1.0, atol=0.22)


def _error(design, size, seed):
    """Return the relative error of the 5 % quantile of one sample; the design alone is sampled."""
    from scipy.stats import qmc  # noqa: PLC0415

    made = {"latin-hypercube": qmc.LatinHypercube, "sobol": qmc.Sobol}[design]
    shares = made(d=1, rng=seed).random(size)[:, 0]
    values = np.array([lowest({"fiber.aspect_ratio": POPULATION.at(u)}) for u in shares])
    return quantiles(values, (0.05,))[0] / exact(0.05) - 1


def test_weighed_by_length_half_of_the_fiber_length_lies_below_the_median(tmp_path):
    # By length the density is x f(x): its median is found by quadrature of the number's.
    table = population(tmp_path, "latin-hypercube", 512)
    by_length = found(table, (0.5,), table.weighing.values)[0]
    ratio = -by_length / (VISCOSITY * RATE) - 1

    def length(low, high):
        return integrate.quad(lambda x: x * x * np.exp(-((x / 7.0) ** 2)), low, high)[0]

    # The weights' sum has the samples' error as well: five strata of 512.
    assert length(1.0, ratio) / length(1.0, 50.0) == pytest.approx(0.5, abs=5 / 512)
    assert by_length < found(table, (0.5,))[0]
