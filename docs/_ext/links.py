"""Links between the project's files, as they are on a code host, turned into those of the site."""

from __future__ import annotations

import os
import re
from pathlib import Path

__all__ = ["LINK", "PAGES", "ROOT", "rewritten"]

ROOT = Path(__file__).parents[2]

LINK = re.compile(r"(?<=\]\()(?P<path>[^)\s#:]+)(?P<anchor>#[^)\s]*)?(?=\))")
"""Target of a relative link in Markdown; one with a scheme has a colon."""

PAGES = {
    "README.md": "docs/index.md",
    "CONTRIBUTING.md": "docs/contributing.md",
    "CHANGELOG.md": "docs/changelog.md",
    "CITATION.cff": "docs/citing.md",
    "LICENSE": "docs/license.md",
    "docs/adr": "docs/adr/index.md",
    "examples": "docs/gallery/index.rst",
}
"""Files outside of docs, and folders, by the page of the site that has them."""


def rewritten(text: str, source: Path, folder: Path) -> str:
    """Return Markdown whose relative links lead where the site has what they name.

    Parameters
    ----------
    text : str
        Markdown.
    source : Path
        The file that it stands in, which its links start from.
    folder : Path
        The folder of the page that shows it.
    """

    def lead(found: re.Match[str]) -> str:
        target = Path(os.path.normpath(source.parent / found["path"]))
        if not target.is_relative_to(ROOT):
            return found[0]
        name = target.relative_to(ROOT).as_posix()
        if name.startswith("examples/") and name.endswith(".py"):
            page = ROOT / "docs" / "gallery" / Path(name).with_suffix(".rst").name
        else:
            page = ROOT / PAGES.get(name, name)
        return Path(os.path.relpath(page, folder)).as_posix() + (found["anchor"] or "")

    return LINK.sub(lead, text)
