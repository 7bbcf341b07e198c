"""`fibermelt fields`: what is in another solver's file."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from fibermelt.cli.common import JsonOption, columns, say, told

__all__ = ["fields"]


def fields(
    file: Annotated[
        str,
        typer.Argument(
            metavar="FILE",
            help="A flow of another solver: Fluent ASCII, CFD-Post CSV, STAR-CCM+ table, COMSOL "
            "text; with pyvista VTK, EnSight, CGNS, Fluent CFF, OpenFOAM, XDMF, Exodus, nek5000.",
        ),
    ],
    as_json: JsonOption = False,
) -> None:
    """Tell what is in another solver's file.

    Its arrays, extents and units, which array is taken for what, and the table [field] of a study
    that reads it.
    """
    with told():
        from fibermelt.engine.wrapping import wrapped  # noqa: PLC0415
        from fibermelt.fields.reading import describe_field  # noqa: PLC0415  lazy, as in run
        from fibermelt.fields.words import field_in_words  # noqa: PLC0415

        found = describe_field(file)
        say(
            json.dumps(found.as_dict(), indent=1, allow_nan=False)
            if as_json
            else wrapped(field_in_words(file, found), columns())
        )
