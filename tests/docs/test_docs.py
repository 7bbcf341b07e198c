"""What pages say is so: links, names, commands, studies. None of it needs Sphinx."""

from __future__ import annotations

import importlib
import importlib.util
import re
import shlex
import sys
import textwrap
import tomllib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import typer
from exact_flows import PIPE, exact_field

import fibermelt
from fibermelt.cli import app
from fibermelt.engine.parameters import declarations
from fibermelt.parts.melt.cards import load_card
from fibermelt.parts.voids.melt import moist_melt
from fibermelt.report.page.sources import read_sources
from fibermelt.study.config import Config
from fibermelt.study.loading import load_study
from fibermelt.sweeps.design import read_sweep

ROOT = Path(__file__).parents[2]
BUILT = ("docs/_build", "docs/gallery", ".venv", "results")
PAGES = sorted(
    path
    for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("benchmarks/**/*.md"))
    if not path.relative_to(ROOT).as_posix().startswith(BUILT)
)
KEYS = {item.key for item in declarations(Config)}
FENCE = re.compile(r"^```(?P<kind>[^\n]*)\n(?P<body>.*?)^```$", re.M | re.S)


def shown(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def page(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def blocks(kind: str) -> Iterator[tuple[str, str]]:
    """Yield the fenced blocks of a language on all pages."""
    for path in PAGES:
        for found in FENCE.finditer(page(path)):
            if found["kind"] == kind:
                yield shown(path), found["body"]


@pytest.fixture
def extension(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """Import modules of docs/_ext by name, and forget them."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    loaded: list[str] = []

    def load(name: str) -> ModuleType:
        loaded.append(name)
        return importlib.import_module(name)

    yield load
    for name in loaded:
        sys.modules.pop(name, None)


def slug(heading: str) -> str:
    """Return the anchor that code hosts and the site give a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")


@pytest.mark.parametrize("path", PAGES, ids=shown)
def test_every_relative_link_leads_somewhere(path: Path, extension: Any) -> None:
    links = extension("links")
    for found in links.LINK.finditer(FENCE.sub("", page(path))):
        target = path.parent / found["path"]
        assert target.exists(), found[0]
        if found["anchor"]:
            headings = re.findall(r"^#+ (.*)$", page(target), flags=re.M)
            assert found["anchor"][1:] in map(slug, headings), found[0]
    for anchor in re.findall(r"\]\(#([^)]*)\)", page(path)):
        assert anchor in map(slug, re.findall(r"^#+ (.*)$", page(path), flags=re.M)), anchor


def test_links_lead_to_where_the_site_has_things(extension: Any) -> None:
    rewritten = extension("links").rewritten
    docs = ROOT / "docs"
    readme = "[a](docs/sweeps.md) [b](CHANGELOG.md#x) [c](docs/adr) [d](https://doi.org/1)"
    assert rewritten(readme, ROOT / "README.md", docs) == (
        "[a](sweeps.md) [b](changelog.md#x) [c](adr/index.md) [d](https://doi.org/1)"
    )
    here = docs / "howto" / "voids.md"
    assert rewritten("[e](../../examples/how_dry.py)", here, here.parent) == (
        "[e](../gallery/how_dry.rst)"
    )


def test_every_page_is_in_a_table_of_contents() -> None:
    listed = set()
    for path in PAGES:
        for found in FENCE.finditer(page(path)):
            if found["kind"] == "{toctree}":
                names = [line for line in found["body"].splitlines() if line[:1] not in {"", ":"}]
                for name in names:
                    listed |= set(path.parent.glob(f"{name}.md"))
    docs = {path for path in PAGES if path.is_relative_to(ROOT / "docs")}
    assert docs - listed == {ROOT / "docs" / "index.md"}


def test_every_public_name_is_documented() -> None:
    text = page(ROOT / "docs" / "reference" / "python.md")
    directives = set(re.findall(r"^\.\. auto(?:class|function|exception):: (\w+)$", text, re.M))
    modules = re.findall(r"^\.\. automodule:: fibermelt\.(\S+)$", text, re.M)
    assert modules == ["report.plot"]
    assert directives | {"plot"} == set(fibermelt.__all__)


def test_names_in_python_blocks_exist() -> None:
    for where, text in blocks("python"):
        if "..." not in text:
            compile(text, where, "exec")
        for name in re.findall(r"\bfm\.(\w+)", text):
            assert name in fibermelt.__all__, f"{where}: fm.{name}"
    for path in PAGES:
        for name in re.findall(r"`fm\.(\w+)", page(path)):
            assert name in fibermelt.__all__, f"{shown(path)}: fm.{name}"


def test_the_how_to_of_streamlines_runs(capsys: pytest.CaptureFixture[str]) -> None:
    """Its blocks one after the other, on the history that it offers to compare with."""
    given = fibermelt.simple_shear(1.0, 40.0)
    known: dict[str, Any] = {name: getattr(given, name) for name in ("time", "position")}
    known |= {"velocity": given.velocity, "pressure": given.pressure}
    # A trace as a solver leaves it, which the second block takes out and the first refuses.
    known["gradient"] = given.gradient + 1e-4 * np.eye(3)
    first, second, check, through, space, third = (
        text for where, text in blocks("python") if "streamlines" in where
    )
    with pytest.raises(fibermelt.HistoryError, match="has trace"):
        exec(first, known)
    known["field"] = exact_field(PIPE, 3)
    for text in (second, first, check, through, space):
        exec(text, known)
    assert capsys.readouterr().out.count("outlet") == 22
    worst = known["bounds"].lowest
    assert np.all(worst * (1 + 1e-12) <= known["pressure"].lowest.min(axis=0))
    exec(third, known)
    assert np.abs(known["history"].gradient - given.gradient).max() < 1e-15
    assert np.all(known["bound"].lowest <= known["pressure"].lowest.min(axis=0))
    ellipse = fibermelt.unbounded_model("ellipse", fibermelt.Ellipse(42e-6, 6.0)).response
    assert fibermelt.orbit(ellipse, 1.0, 817.0).period / 2 == pytest.approx(19.37, abs=0.005)
    turned = fibermelt.follow(given, ellipse.shape_factor, np.zeros(1)).angle[0]
    assert np.interp(19.373, given.time, turned) == pytest.approx(-np.pi, abs=1e-3)


def commands() -> Iterator[tuple[str, str, bool]]:
    """Yield every command in a block, whole, and in backticks, where it may be named only."""
    for path in PAGES:
        text = page(path)
        for line in re.findall(r"^(?: {4}|\$ )(fibermelt .*)$", text, re.M):
            yield shown(path), line, True
        for piece in re.findall(r"(?<!`)`(fibermelt [^`]*)`(?!`)", re.sub(r"\n(?=\S)", " ", text)):
            yield shown(path), piece, False


def test_every_command_is_one() -> None:
    group: Any = typer.main.get_command(app)
    seen = set()
    for where, line, is_whole in commands():
        # What may be left out stands in brackets.
        _, name, *given = (word.strip("[]") for word in shlex.split(line, comments=True))
        if name.startswith("-"):
            continue
        assert name in group.commands, f"{where}: {line}"
        seen.add(name)
        known = {"--help"}.union(*(item.opts for item in group.commands[name].params))
        assert {word for word in given if word.startswith("-")} <= known, f"{where}: {line}"
        if is_whole:
            group.commands[name].make_context(name, list(given))
        for at, word in enumerate(given):
            if word in {"-s", "--set", "--over"}:
                key = given[at + 1].partition("=")[0]
                assert key in KEYS | {"KEY"}, f"{where}: {line}"
    assert len(seen) > 10  # of 14: the pages are read at all


def test_every_parameter_in_text_exists() -> None:
    tables = "|".join({key.partition(".")[0] for key in KEYS})
    for path in PAGES:
        text = FENCE.sub("", page(path))
        for key in re.findall(rf"`(?:-s )?((?:{tables})\.[a-z_]+)\b(?!\()", text):
            table, _, name = key.partition(".")
            # What is in backticks may be a file, or a name of the package of the table's name.
            if key in KEYS or name in {"vtu", "vtp", "py", "toml"}:
                continue
            assert table in {"fiber", "flow", "voids"}, f"{shown(path)}: {key}"
            is_module = importlib.util.find_spec(f"fibermelt.{key}") is not None
            package = importlib.import_module(f"fibermelt.{table}")
            assert is_module or hasattr(package, name), f"{shown(path)}: {key}"


def test_every_study_and_card_on_a_page_is_valid(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    count = 0
    monkeypatch.chdir(tmp_path)
    readme = re.findall(r"^ {4}preset.*\n(?:(?: {4}.*)?\n)*", page(ROOT / "README.md"), re.M)
    indented = [("README.md", textwrap.dedent(text)) for text in readme]
    for where, text in [*blocks("toml"), *indented]:
        path = tmp_path / f"{count}.toml"
        tables = tomllib.loads(text)
        count += 1
        for table in ("field", "paths"):
            if file := tables.get(table, {}).get("file"):
                Path(file).write_text("the reader's own")
        # Of a study there may be its table [sweep] alone.
        start = "" if {"preset", "name"} & set(tables) else 'preset = "paper"\n'
        path.write_text(start + text, encoding="utf-8")
        if "name" in tables:
            # As the command beside it takes the card: moisture and temperature are the card's.
            moist_melt(load_card(str(path)))
            continue
        study = load_study(str(path))
        if study.sweep is not None:
            assert read_sweep(study).told(), where
    assert count >= 6


def test_the_printers_page_quotes_what_validate_tells() -> None:
    told = {name: load_study(name).config.notes() for name in ("pellet", "filament")}
    quoted = [text for where, text in blocks("text") if "printer" in where]
    assert len(quoted) == 2
    for notes, text in zip(told.values(), quoted, strict=True):
        for line in re.split(r"^note +", text, flags=re.M)[1:]:
            assert " ".join(line.split()) in notes
    assert " ".join(quoted[0].split()).count("note ") == len(told["pellet"])


def test_what_is_generated_is_all_there(extension: Any) -> None:
    generated = extension("generated")
    asked = set()
    for path in PAGES:
        asked |= {found["name"] for found in generated.MARK.finditer(page(path))}
    assert asked == set(generated.GENERATED)
    told = generated.fill_in(page(ROOT / "docs" / "reference" / "parameters.md"))
    for key in KEYS:
        table, _, name = key.partition(".")
        assert f"## `[{table}]`" in told
        assert f"\n`{name}`\n: " in told
    group: Any = typer.main.get_command(app)
    every = generated.commands()
    for name, command in group.commands.items():
        part = every.partition(f"## {name}\n")[2].partition("\n## ")[0]
        for option in command.params:
            assert (option.opts[0] if option.opts[0][0] == "-" else option.metavar) in part
    for source in read_sources().values():
        assert source.fields["year"] in generated.bibliography()
    for name in fibermelt.__all__:
        assert f"fibermelt.{name}" in generated.names()
    for name in ("variables", "summary", "studies", "closures"):
        assert generated.GENERATED[name]()


def test_sources_of_the_theory_are_in_the_bibliography() -> None:
    known = {source.fields.get("doi") for source in read_sources().values()}
    for path in (ROOT / "docs" / "theory").glob("*.md"):
        for doi in re.findall(r"https://doi\.org/((?:[^()\s]|\([^()]*\))+)", page(path)):
            assert doi in known, f"{path.name}: {doi}"
