"""Numbers in print."""

import pytest

from fibermelt.report.kit.tables import unbroken


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("0.45 mm above the bed", "0.45\u00a0mm above the bed"),
        ("goes 51 % to 0.020 %.", "goes 51\u00a0% to 0.020\u00a0%."),
        ("0.951 MPa at 230 °C, 9.4 times", "0.951\u00a0MPa at 230\u00a0°C, 9.4 times"),
        ("24 mm/s; 817 Pa s; 3243 mm³/s", "24\u00a0mm/s; 817\u00a0Pa s; 3243\u00a0mm³/s"),
        ("4 of 22 streamlines, 3 more", "4 of 22 streamlines, 3 more"),
    ],
)
def test_a_number_stays_with_its_unit(text: str, kept: str) -> None:
    assert unbroken(text) == kept
