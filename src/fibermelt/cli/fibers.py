"""Commands for a single fiber: `fibermelt orbit`."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from fibermelt.cli.common import JsonOption, say, told

__all__ = ["orbit"]


def orbit(
    aspect_ratio: Annotated[
        str, typer.Option(metavar="R", help="Length over width of the fiber, at least 1.")
    ],
    shear_rate: Annotated[
        str, typer.Option(metavar="RATE", help='Shear rate, such as 1 or "1 1/s".')
    ],
    viscosity: Annotated[
        str, typer.Option(metavar="MU", help='Viscosity of the melt, such as 817 or "817 Pa s".')
    ],
    model: Annotated[
        str,
        typer.Option(metavar="MODEL", help="confined-ellipse, ellipse or spheroid."),
    ] = "confined-ellipse",
    domain_size: Annotated[
        str,
        typer.Option(metavar="M", help="The cell's radius is M / 2 half-lengths; only confined."),
    ] = "4",
    angle: Annotated[
        str, typer.Option(metavar="DEG", help="Angle from the flow at the start, in degrees.")
    ] = "0",
    path: Annotated[
        str,
        typer.Option(metavar="PATH", help="superposition, or newton: the paper's own algorithm."),
    ] = "superposition",
    as_json: JsonOption = False,
) -> None:
    """Turn one fiber once in simple shear: its period, and the pressure extremes on it."""
    with told():
        from fibermelt.study.orbit import (  # noqa: PLC0415  lazy, as in run
            OrbitStudy,
            orbit_in_words,
            read_quantity,
            run_orbit,
        )

        answer = run_orbit(
            OrbitStudy(
                aspect_ratio=read_quantity("--aspect-ratio", aspect_ratio, ""),
                shear_rate=read_quantity("--shear-rate", shear_rate, "1/s"),
                viscosity=read_quantity("--viscosity", viscosity, "Pa s"),
                model=model,
                domain_size=read_quantity("--domain-size", domain_size, ""),
                angle=read_quantity("--angle", angle, "rad", bare="deg"),
                path=path,
            )
        )
        say(json.dumps(answer, indent=1) if as_json else orbit_in_words(answer))
