"""The package as a newcomer meets it: light to import, complete, and as the README says."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import fibermelt

ROOT = Path(__file__).parents[1]
HEAVY = ("ngsolve", "matplotlib", "scipy", "xarray", "pydantic", "pint", "numpy")


def test_import_loads_nothing_heavy() -> None:
    code = "import sys, fibermelt; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert not set(HEAVY) & set(loaded)


def test_every_public_name_is_there() -> None:
    for name in fibermelt.__all__:
        assert getattr(fibermelt, name).__doc__, name


def test_readme_shows_the_example() -> None:
    """The README's script is the one that is run, comments and print apart."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"```python\n(.*?)```", readme, flags=re.DOTALL)
    example = (ROOT / "examples" / "lowest_pressure.py").read_text(encoding="utf-8")
    assert shown.strip() in example
