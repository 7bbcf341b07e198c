"""What is declared once: refused by the solver and by a study in the same words."""

from dataclasses import dataclass

import pytest

from fibermelt.declared import declared, refuse_beyond
from fibermelt.engine.parameters import Section, declarations, declared_by
from fibermelt.errors import ConfigError


@dataclass(frozen=True)
class Slot:
    width: float = declared(0.0127, "m", gt=0, le=1)
    order: int = declared(3, ge=2, le=6)
    guess: float | None = declared(None, "m")
    name: str = "none of a number"

    def __post_init__(self):
        refuse_beyond("slot", self)


class Table(Section):
    width: float = declared_by(Slot, "width", "Its width.", "mm")
    order: int = declared_by(Slot, "order", "Its order.", le=5)
    guess: float | None = declared_by(Slot, "guess", "A guess.", example="1 mm")


def test_a_table_has_the_default_the_unit_and_the_bounds():
    width, order, guess = declarations(Table)
    assert (width.default, width.unit, width.written) == (0.0127, "m", "12.7 mm")
    assert dict(width.bounds) == {"gt": 0, "le": 1}
    assert order.default == 3
    assert dict(order.bounds) == {"ge": 2, "le": 5}
    assert guess.default is None


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"width": 0.0}, r"slot\.width = 0 m: must be above 0 m"),
        ({"width": 2.0}, r"slot\.width = 2 m: must be at most 1 m"),
        ({"width": float("nan")}, r"slot\.width = nan m: must be finite"),
        ({"width": "3 mm"}, r"slot\.width = '3 mm': must be one number"),
        ({"width": None}, r"slot\.width = None: must be one number"),
        ({"order": 2.5}, r"slot\.order = 2\.5: must be a whole number"),
        ({"order": 7}, r"slot\.order = 7: must be at most 6"),
        ({"guess": float("inf")}, r"slot\.guess = inf m: must be finite"),
    ],
)
def test_a_solver_refuses_what_is_beyond(values, says):
    with pytest.raises(ConfigError, match=f"^{says}"):
        Slot(**values)
    assert Slot(guess=None, order=4).order == 4
