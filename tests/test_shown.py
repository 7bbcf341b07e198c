"""Values say in a line what they are: none prints its arrays."""

from __future__ import annotations

import numpy as np
import pytest

import fibermelt as fm
from fibermelt.flow.streamlines import Streamline
from fibermelt.shown import Shown

HISTORY = fm.simple_shear(1.0, 2.0, 5)
LINE = Streamline(
    index=3,
    flux_fraction=0.125,
    history=HISTORY,
    stream_function=np.zeros(5),
    gradient_error=np.full(5, 0.25),
    drift=0.0,
    corner_distance=np.full(5, 1e-4),
    near_singularity=True,
    zone_time=np.zeros(3),
)


@pytest.mark.parametrize(
    ("value", "line"),
    [
        (
            fm.unbounded_ellipse(fm.Ellipse(42e-6, 6.0)),
            "FiberResponse(aspect ratio 6, shape factor 0.94595, tip pressure 7 mu gamma_dot, in "
            "simple shear it tumbles)",
        ),
        (
            fm.unbounded_model("ellipse", fm.Ellipse(42e-6, 6.0)),
            "FiberModel(model ellipse, aspect ratio 6, shape factor 0.94595, tip pressure 7 mu "
            "gamma_dot, in simple shear it tumbles, melt Newtonian)",
        ),
        (
            LINE,
            "Streamline(number 3, flux to its left 12.5 %, points 5, time 2 s, gradient error "
            "0.25 1/s, near a singular corner yes)",
        ),
    ],
    ids=["response", "model", "streamline"],
)
def test_a_value_in_a_line_and_in_a_table(value: Shown, line: str) -> None:
    assert repr(value) == line
    table = value._repr_html_()
    assert table.startswith(f"<table><caption>{type(value).__name__}</caption>")
    for name, told in value.told().items():
        assert f'<th scope="row">{name}</th><td>{told}</td>' in table


def test_what_is_told_is_no_markup() -> None:
    class Odd(Shown):
        def told(self) -> dict[str, str]:
            return {"<b>": "a & b"}

    assert '<th scope="row">&lt;b&gt;</th><td>a &amp; b</td>' in Odd()._repr_html_()
