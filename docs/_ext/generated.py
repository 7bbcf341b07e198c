"""What pages take from declarations in the code: parameters, commands, variables, sources.

A page has a fenced block ``{generated}`` with the name of what is to stand there.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from importlib.resources import files
from typing import Any

__all__ = ["GENERATED", "MARK", "fill_in"]

MARK = re.compile(r"^```\{generated\} (?P<name>[\w-]+)\n```$", re.M)


def fill_in(text: str) -> str:
    """Return a page with what is generated in place of its name.

    Raises
    ------
    KeyError
        If a page asks for what is not in `GENERATED`.
    """
    return MARK.sub(lambda found: GENERATED[found["name"]](), text)


def parameters() -> str:
    """Return every parameter of a study, by table."""
    from fibermelt.engine.parameters import declarations  # noqa: PLC0415
    from fibermelt.study.config import Config  # noqa: PLC0415  lazy: a page at a time

    lines, section = [], ""
    for item in declarations(Config):
        table, _, name = item.key.rpartition(".")
        if table != section:
            section = table
            doc = inspect.getdoc(Config.model_fields[table].annotation) or ""
            lines += [f"## `[{table}]`", "", _one_line(doc), ""]
        unit = f"; unit {item.unit}" if item.unit else ""
        default = "none" if item.written is None else _default(item.written)
        about = [f"Default {default}{unit}."]
        if item.range:
            about.append(f"{'Choices' if item.choices else 'Range'}: {item.range}.")
        if item.source:
            about.append(f"Source: {item.source}.")
        lines += [f"`{name}`", f": {_text(item.doc)}", f"  {_text(' '.join(about))}", ""]
    return "\n".join(lines)


def _default(written: object) -> str:
    from fibermelt.engine.toml import toml_value  # noqa: PLC0415  lazy, as in parameters

    return f"`{toml_value(written)}`"


def commands() -> str:
    """Return every command with its arguments and options."""
    import typer  # noqa: PLC0415  lazy, as in parameters

    from fibermelt.cli import app  # noqa: PLC0415

    group: Any = typer.main.get_command(app)
    lines = []
    for name, command in group.commands.items():
        given = [item for item in command.params if item.param_type_name == "argument"]
        usage = " ".join(["fibermelt", name, *(str(item.metavar) for item in given), "[OPTIONS]"])
        lines += [f"## {name}", "", _text(command.help), "", "```text", usage, "```", ""]
        for item in command.params:
            told = item.metavar if item in given else _option(item)
            lines += [f"`{told}`", f": {_text(item.help or '')}{_preset(item)}", ""]
    return "\n".join(lines)


def _option(item: Any) -> str:
    names = ", ".join(item.opts)
    return names if item.is_flag else f"{names} {item.metavar}"


def _preset(item: Any) -> str:
    if item.param_type_name == "argument" or item.is_flag:
        return ""
    if item.required:
        return " Required."
    return f" Default: `{item.default}`." if item.default not in {None, ()} else ""


def names() -> str:
    """Return every public name with the first line of its docstring."""
    import fibermelt  # noqa: PLC0415  lazy, as in parameters

    docs = {name: inspect.getdoc(getattr(fibermelt, name)) or "" for name in fibermelt.__all__}
    rows = ((f"{{py:obj}}`{_at(name)}`", doc.partition("\n")[0]) for name, doc in docs.items())
    return _table(("name", "what it is"), rows)


def _at(name: str) -> str:
    """Return where a public name is documented; that of a module is where the module is."""
    import fibermelt  # noqa: PLC0415  lazy, as in parameters

    found = getattr(fibermelt, name)
    return (
        f"fibermelt.{name} <{found.__name__}>" if inspect.ismodule(found) else f"~fibermelt.{name}"
    )


def variables() -> str:
    """Return every variable of results.nc: dimensions, unit, what it is."""
    from fibermelt.study.quantities import QUANTITIES  # noqa: PLC0415  lazy, as in parameters

    rows = (
        (f"`{one.name}`", f"`{one.dimensions}`" if one.dimensions else "", one.unit, one.meaning)
        for one in QUANTITIES.values()
        if one.stored
    )
    return _table(("variable", "dimensions", "unit", "what it is"), rows)


def summary() -> str:
    """Return what each part of a study puts into summary.json."""
    from fibermelt.study.chain import CHAIN  # noqa: PLC0415  lazy, as in parameters

    lines = []
    for part in CHAIN.parts:
        doc = inspect.getdoc(part.summarize) or ""
        returned = re.search(r"^Returns\n-+\n[^\n]*\n(?P<text>(?: .*\n?|\n)+)", doc, re.M)
        told = returned["text"] if returned else doc.partition("\n\n")[0]
        lines += [f"`{part.name}`", f": {_one_line(told)}", ""]
    return "\n".join(lines)


def studies() -> str:
    """Return the studies that ship, with what their files say on top."""
    presets = files("fibermelt.data").joinpath("studies")
    lines = []
    for name in sorted(path.name for path in presets.iterdir() if path.name.endswith(".toml")):
        text = presets.joinpath(name).read_text(encoding="utf-8")
        said = re.match(r"(?:#.*\n)*", text)
        words = " ".join(line.lstrip("# ") for line in (said[0] if said else "").splitlines())
        lines += [f"`{name.removesuffix('.toml')}`", f": {_text(words)}", ""]
    return "\n".join(lines)


def materials() -> str:
    """Return the cards that ship: the law of viscosity, and what else is known."""
    from fibermelt.parts.melt.cards import load_card, material_names  # noqa: PLC0415  lazy

    lines = []
    for card in map(load_card, material_names()):
        values = list(card.provenance.items())
        told = "; ".join(
            f"{key.removeprefix('viscosity.')} {where.written}{' (estimate)' * where.is_estimate}"
            for key, where in values
            if key.startswith("viscosity.")
        )
        sources = dict.fromkeys(where.text for key, where in values if key.startswith("viscosity."))
        low, high = card.melt.temperatures
        about = [
            f"{card.name}; {low - 273.15:g} to {high - 273.15:g} degC, printed at "
            f"{card.temperature - 273.15:g} degC; density {card.melt.density:g} kg/m^3.",
            f"Viscosity: {told}." if told else "Viscosity: not known.",
            f"From: {'; '.join(sources)}." if sources else "",
            "Moisture: not known." if "isotherm" in card.melt.gaps else "",
        ]
        lines += [f"`{card.key}`", f": {_text(_one_line(' '.join(about)))}", ""]
    return "\n".join(lines)


def closures() -> str:
    """Return every closure: where it was published and what it is meant for."""
    from fibermelt.orientation.closures import CLOSURES  # noqa: PLC0415  lazy, as in parameters

    rows = ((f"`{each.name}`", each.validity, each.source) for each in CLOSURES.values())
    return _table(("closure", "meant for", "source"), rows)


def glossary() -> str:
    """Return the words of pages and pictures with what they stand for, as the reports do."""
    from fibermelt.report.kit.glossary import TERMS  # noqa: PLC0415  lazy, as in parameters

    return "\n".join(f"{_text(term.name)}\n: {_text(term.meaning)}\n" for term in TERMS)


def bibliography() -> str:
    """Return every source, as the report writes it."""
    from fibermelt.report.page.sources import read_sources, written  # noqa: PLC0415  lazy

    return "\n".join(f"- {written(source)}" for source in read_sources().values())


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    columns = list(head)
    lines = [columns, ["---"] * len(columns), *([_cell(item) for item in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cell(text: str) -> str:
    return text if text.startswith(("`", "{py:obj}")) else _text(text).replace("|", r"\|")


def _one_line(text: str) -> str:
    return re.sub(r"\s+", " ", text).strip()


def _text(text: str) -> str:
    """Return plain words as Markdown that shows them as they are; what is in backticks stays."""
    pieces = re.split(r"(``.+?``|`[^`]*`)", text)
    return "".join(
        piece if piece.startswith("`") else re.sub(r"([\\*_\[\]<>$])", r"\\\1", piece)
        for piece in pieces
    )


GENERATED: Mapping[str, Callable[[], str]] = {
    "bibliography": bibliography,
    "closures": closures,
    "commands": commands,
    "glossary": glossary,
    "materials": materials,
    "names": names,
    "parameters": parameters,
    "studies": studies,
    "summary": summary,
    "variables": variables,
}
"""What a page can ask for."""
