"""The site builds without a warning, nothing in it run, and asks no other machine."""

from __future__ import annotations

import importlib.util
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.end_to_end

ROOT = Path(__file__).parents[2]
NEEDED = ("sphinx", "myst_nb", "sphinx_gallery", "furo", "latex2mathml")
LOADED = re.compile(r'<(?:script|img|iframe|source|link)\b[^>]*?(?:src|href)="(https?:[^"]*)"')


@pytest.mark.slow
def test_site_builds_without_a_warning(tmp_path: Path) -> None:
    if missing := [name for name in NEEDED if importlib.util.find_spec(name) is None]:
        pytest.skip(f"no {', '.join(missing)}: pip install .[docs]")
    site = tmp_path / "html"
    quiet = ["-q", "-W", "--keep-going", "-D", "plot_gallery=0", "-D", "nb_execution_mode=off"]
    # The gallery is written beside the pages: a copy leaves one that was run as it is.
    names = (
        "docs",
        "examples",
        *(path.name for path in ROOT.glob("*.md")),
        "CITATION.cff",
        "LICENSE",
    )
    for name in names:
        if (ROOT / name).is_dir():
            ignored = shutil.ignore_patterns("_build", "gallery", "__pycache__")
            shutil.copytree(ROOT / name, tmp_path / name, ignore=ignored)
        else:
            shutil.copy(ROOT / name, tmp_path / name)
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *quiet, "docs", str(site)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    pages = {path.relative_to(site).as_posix(): path for path in site.rglob("*.html")}
    for name in (
        "index",
        "tutorial",
        "notebooks/first-study",
        "sweeps",
        "theory/fiber",
        "gallery/how_dry",
        "adr/index",
    ):
        assert f"{name}.html" in pages
    for name, path in pages.items():
        text = path.read_text(encoding="utf-8")
        assert not LOADED.search(text), name
    has = {
        "theory/fiber": "<math",
        "reference/parameters": "capillary_width",
        "reference/commands": "--retry-failed",
        "reference/results": "node_pressure",
        "reference/python": 'id="fibermelt.solve_deposition"',
        "bibliography": "10.1098/rspa.1922.0078",
    }
    for name, words in has.items():
        assert words in pages[f"{name}.html"].read_text(encoding="utf-8"), name
