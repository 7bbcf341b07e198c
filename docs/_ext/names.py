"""Names in docstrings: short ones lead to where the site has them, wrong ones are warned of."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sphinx.domains.python import PythonDomain
from sphinx.util.nodes import make_refnode

import fibermelt

if TYPE_CHECKING:
    from docutils import nodes
    from sphinx.addnodes import pending_xref
    from sphinx.application import Sphinx
    from sphinx.environment import BuildEnvironment


def _signature(
    _app: Sphinx, what: str, name: str, thing: Any, _options: Any, given: str, returned: str
) -> tuple[str, str] | None:
    """Return a signature with its annotations as they are written in the source."""
    if what not in {"function", "method", "class"} or not callable(thing):
        return None
    try:
        own = inspect.signature(thing)
    except (TypeError, ValueError):
        return None
    if getattr(thing, "_is_protocol", False):
        return "", ""
    parameters = [
        item.replace(annotation=_Written(item.annotation), default=_shown(item.default))
        for item in own.parameters.values()
        if item.name != "self"
    ]
    shown = inspect.Signature(parameters, return_annotation=inspect.Signature.empty)
    answer = "" if what == "class" else own.return_annotation
    return str(shown), "" if answer in {own.empty, ""} else str(answer)


def _whole(
    _app: Sphinx, what: str, _name: str, _thing: Any, _options: Any, lines: list[str]
) -> None:
    """Keep what stands before a colon from being taken for the type of a property."""
    if what in {"attribute", "data", "property"}:
        lines[:0] = ["..", ""]  # an empty comment: nothing in it to be taken


def _shown(default: object) -> object:
    """Return a default, or dots where it is no value that can be written down."""
    if default is inspect.Parameter.empty or not repr(default).startswith(("<", "mappingproxy")):
        return default
    return _Written("...")


class _Written(str):
    """An annotation that is shown without quotes."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def _resolve(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, shown: nodes.TextElement
) -> nodes.Element | None:
    """Return a link to a documented object by its last name, or the bare name if it exists."""
    if node.get("refdomain") != "py":
        return None
    target = str(node["reftarget"]).removesuffix("()")
    domain = env.get_domain("py")
    assert isinstance(domain, PythonDomain)
    last = target.rpartition(".")[2]
    places = [f"fibermelt.{last}"]
    places += [name for name in domain.objects if name.endswith(f".{target}")]
    for name in dict.fromkeys(places):
        if (found := domain.objects.get(name)) is not None and not found.aliased:
            return make_refnode(
                app.builder, node["refdoc"], found.docname, found.node_id, [shown], name
            )
    # Annotations are checked by mypy; what a docstring names must be somewhere in the package.
    return shown if node["reftype"] == "class" or target in _known() else None


@cache
def _known() -> frozenset[str]:
    """Return modules, names in them, and ``Class.name``, in full and by their last parts."""
    names = set()
    root = Path(fibermelt.__file__).parent
    for path in root.rglob("*.py"):
        module = ".".join(["fibermelt", *path.relative_to(root).with_suffix("").parts])
        module = module.removesuffix(".__init__")
        names.add(module)
        for name in _defined(ast.parse(path.read_text(encoding="utf-8")).body):
            names |= {name, f"{module}.{name}", f"{module.rpartition('.')[2]}.{name}"}
    return frozenset(names)


def _defined(body: list[ast.stmt]) -> Iterator[str]:
    """Yield what a module or a class defines, and what its classes do."""
    for item in body:
        if isinstance(item, ast.FunctionDef):
            yield item.name
        elif isinstance(item, ast.ClassDef):
            yield item.name
            yield from (f"{item.name}.{name}" for name in _defined(item.body))
        elif isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name):
            yield item.target.id
        elif isinstance(item, ast.Assign):
            yield from (name.id for name in item.targets if isinstance(name, ast.Name))


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect all of it; docstrings come here before napoleon has them."""
    app.connect("autodoc-process-docstring", _whole, priority=400)
    app.connect("autodoc-process-signature", _signature)
    app.connect("missing-reference", _resolve)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
