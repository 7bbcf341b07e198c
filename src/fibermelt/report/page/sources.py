"""The sources of what ran: which of them a study makes use of, and how they are written.

`USES` says which parameters make use of a source; the sources themselves are in
``data/references.bib``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from markupsafe import Markup

from fibermelt.parts.bead.shapes import SHAPES
from fibermelt.report.kit.templates import rendered

__all__ = ["USES", "Source", "Use", "read_sources", "sources_of", "written"]

_ENTRY = re.compile(r"^@(?P<kind>\w+)\{(?P<key>[\w-]+),\n(?P<fields>.*?)^\}", re.M | re.S)
_FIELD = re.compile(r"^  (?P<name>\w+) = \{(?P<value>.*)\},$", re.M)


@dataclass(frozen=True)
class Source:
    """An entry of the bibliography.

    Parameters
    ----------
    key : str
        Its key.
    fields : mapping
        Its fields, such as ``author``, ``title``, ``doi``.
    bibtex : str
        The entry itself.
    """

    key: str
    fields: Mapping[str, str]
    bibtex: str

    @property
    def authors(self) -> str:
        """Return ``Last, First and Last, First`` as ``Last, First; Last, First``."""
        names = self.fields["author"].split(" and ")
        if names[-1] == "others":
            return f"{', '.join(names[:-1])} and others"
        return "; ".join(names)

    @property
    def place(self) -> str:
        """Return where it was published."""
        fields = self.fields
        where = fields.get("journal", fields.get("school", ""))
        if "school" in fields:
            where = f"dissertation, {where}"
        place = " ".join(filter(None, [where, fields.get("volume", "")]))
        pages = fields.get("pages", "").replace("--", "–")
        return f"{place}, {pages}" if pages else place


@dataclass(frozen=True)
class Use:
    """When a source is made use of.

    Parameters
    ----------
    key : str
        Key of the source.
    what : str
        What comes from it.
    applies : callable
        From the flattened parameters of a study (``{"fiber.model": ...}``) to whether it does.
    """

    key: str
    what: str
    applies: Callable[[Mapping[str, Any]], bool]


def _always(_values: Mapping[str, Any]) -> bool:
    return True


def _has(*parts: str) -> Callable[[Mapping[str, Any]], bool]:
    return lambda values: bool({*parts} & {*values["study.parts"]})


_suspension = _has("interaction", "orientation")
_voids = _has("voids")

COMPARED = ("ORE", "ORF", "ORW3", "IBOF", "exact", "quadratic", "hybrid")
"""Closures that the part "interaction" compares whatever the study's own is."""


def _unbounded(values: Mapping[str, Any]) -> bool:
    """Tell whether the closed forms of a fiber in an unbounded melt answer for it."""
    parts = {"orbits", "dimensions", "interaction", "orientation", "voids"}
    return not SHAPES[values["fiber.model"]].has_cell or _has(*parts)(values)


def _confined(values: Mapping[str, Any]) -> bool:
    """Tell whether a fiber in its cell is solved for by finite elements."""
    if _has("interaction", "orbits", "dimensions")(values):
        return True
    return SHAPES[values["fiber.model"]].has_cell and _has("bead")(values)


def _interacting(values: Mapping[str, Any]) -> bool:
    """Tell whether fibers interact: in tensors, or in what the cell's size follows from."""
    return _suspension(values) or values["fiber.domain_size"] == "from-content"


def _law(name: str) -> Callable[[Mapping[str, Any]], bool]:
    def applies(values: Mapping[str, Any]) -> bool:
        given = values["interaction.coefficient"] is not None
        return _interacting(values) and not given and values["interaction.law"] == name

    return applies


def _model(*names: str) -> Callable[[Mapping[str, Any]], bool]:
    return lambda values: _has("orientation")(values) and values["interaction.model"] in names


def _closure(*names: str) -> Callable[[Mapping[str, Any]], bool]:
    def applies(values: Mapping[str, Any]) -> bool:
        ran = {values["interaction.closure"]} if _interacting(values) else set()
        return bool({*names} & (ran | ({*COMPARED} if _has("interaction")(values) else set())))

    return applies


USES = (
    Use("awenlimobor2024", "the study, its melt, its fiber and its claims", _always),
    Use(
        "jeffery1922",
        "a fiber in an unbounded melt: its motion, and the pressure on it",
        _unbounded,
    ),
    Use(
        "zhang2011", "a fiber in its cell, free of force and torque, by finite elements", _confined
    ),
    Use("folgar1984", "diffusion of the orientation by interaction", _interacting),
    Use("advani1987", "orientation tensors", _interacting),
    Use("wang2008", "eigenvalues of the orientation that change slower", _model("rsc", "ard-rsc")),
    Use(
        "phelps2009",
        "anisotropic diffusion of the orientation",
        _model("ard-rsc", "iard", "pard", "mrd"),
    ),
    Use("tseng2016", "the model iARD", _model("iard")),
    Use("tseng2018", "the model pARD", _model("pard")),
    Use("latz2010", "the nematic model", _model("nematic")),
    Use("bay1991", "the interaction coefficient from the content", _law("bay")),
    Use("phanthien2002", "the interaction coefficient from the content", _law("phan-thien")),
    Use("hand1962", "the linear closure", _closure("linear")),
    Use("doi1981", "the quadratic closure", _closure("quadratic")),
    Use("advani1990", "the hybrid closure", _closure("hybrid")),
    Use("cintra1995", "orthotropic closures", _closure("ORS", "ORF", "ORL")),
    Use("verweyst1998", "the closure ORE", _closure("ORE")),
    Use("chung2001", "the closures ORW and ORW3", _closure("ORW", "ORW3")),
    Use("chung2002", "the closure IBOF", _closure("IBOF")),
    Use("montgomerysmith2011", "the exact closure", _closure("exact")),
    Use("carlson1979", "elliptic integrals of the exact closure", _closure("exact")),
    Use("montgomerysmith2010", "the distribution itself, in spherical harmonics", _suspension),
    Use("roychowdhury2001", "the pressure below which a bubble can grow", _voids),
    Use("colton1987", "vapor pressure of moisture, and nucleation at a surface", _voids),
    Use("blander1975", "the classical rate of nucleation", _voids),
    Use("wagner2000", "saturation pressure of water", _voids),
    Use(
        "sugden1924",
        "surface tension from the parachor",
        lambda values: _voids(values) and values["melt.material"] == "pla",
    ),
    Use("dormand1980", "steps along streamlines and of tensors", _has("bead", "orientation")),
    Use("schoberl1997", "meshes, and with NGSolve the finite elements", _always),
    Use("harris2020", "arrays", _always),
    Use("virtanen2020", "time integration, interpolation and root finding", _always),
    Use("hoyer2017", "labelled results", _always),
    Use("hunter2007", "figures", _always),
)
"""In the order of the report; what has no entry here is in the bibliography for later use."""


@cache
def read_sources() -> Mapping[str, Source]:
    """Return the whole bibliography by key, in its order."""
    text = files("fibermelt.data").joinpath("references.bib").read_text(encoding="utf-8")
    return {
        entry["key"]: Source(
            key=entry["key"],
            fields={field["name"]: field["value"] for field in _FIELD.finditer(entry["fields"])},
            bibtex=entry[0],
        )
        for entry in _ENTRY.finditer(text)
    }


def sources_of(values: Mapping[str, Any]) -> list[tuple[Source, str]]:
    """Return the sources that a study makes use of, and what comes from each.

    Parameters
    ----------
    values : mapping
        The study's parameters, flattened.

    Raises
    ------
    KeyError
        If `USES` names a source that is not in the bibliography.
    """
    every = read_sources()
    return [(every[use.key], use.what) for use in USES if use.applies(values)]


def written(source: Source) -> Markup:
    """Return a source as one line of a bibliography, with a link where it has a DOI or arXiv."""
    return rendered("report/page/source.html.j2", {"source": source})
