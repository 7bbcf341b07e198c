"""Commands for one fiber, or many: `fibermelt orbit`, `orientation` and `domain-size`."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from fibermelt.cli.common import JsonOption, say, told

__all__ = ["domain_size", "orbit", "orientation"]


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
        from fibermelt.study.questions.orbit import (  # noqa: PLC0415  lazy, as in run
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


RatioOption = Annotated[
    str, typer.Option("--aspect-ratio", metavar="R", help="Length over width of the fibers.")
]
ClosureOption = Annotated[
    str,
    typer.Option(
        metavar="NAME",
        help="linear, quadratic, hybrid, ORS, ORF, ORL, ORW, ORW3, ORE, IBOF, exact; or "
        "exact-pdf, the distribution itself, which needs none.",
    ),
]
ConventionOption = Annotated[
    str,
    typer.Option(metavar="NAME", help="Rate that multiplies C_I: standard, or paper (sqrt(2) it)."),
]


def orientation(
    closure: ClosureOption,
    interaction: Annotated[
        str, typer.Option(metavar="C_I", help="Interaction coefficient, above 0.")
    ],
    aspect_ratio: RatioOption,
    model: Annotated[
        str, typer.Option(metavar="NAME", help="folgar-tucker, rsc, iard, pard, mrd or nematic.")
    ] = "folgar-tucker",
    flow: Annotated[
        str,
        typer.Option(
            metavar="NAME", help="simple-shear (v_1 = x_2), uniaxial, biaxial, planar or mixed."
        ),
    ] = "simple-shear",
    convention: ConventionOption = "standard",
    parameter: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=VALUE", help="What the model takes besides, such as kappa=0.1."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Find how the fibers of a suspension lie in a steady flow of unit rate."""
    with told():
        from fibermelt.study.questions.orbit import read_quantity  # noqa: PLC0415  lazy, as in run
        from fibermelt.study.questions.orientation import (  # noqa: PLC0415
            OrientationStudy,
            orientation_in_words,
            read_parameters,
            run_orientation,
        )

        answer = run_orientation(
            OrientationStudy(
                closure=closure,
                interaction=read_quantity("--interaction", interaction, ""),
                aspect_ratio=read_quantity("--aspect-ratio", aspect_ratio, ""),
                model=model,
                flow=flow,
                convention=convention,
                parameters=read_parameters(parameter or []),
            )
        )
        say(json.dumps(answer, indent=1) if as_json else orientation_in_words(answer))


def domain_size(
    aspect_ratio: RatioOption,
    volume_fraction: Annotated[
        str, typer.Option(metavar="V", help="Fiber content by volume, between 0 and 1.")
    ],
    closure: ClosureOption = "ORE",
    convention: ConventionOption = "standard",
    interaction: Annotated[
        str | None, typer.Option(metavar="C_I", help="Interaction coefficient, in the law's place.")
    ] = None,
    law: Annotated[str, typer.Option(metavar="NAME", help="bay or phan-thien.")] = "bay",
    as_json: JsonOption = False,
) -> None:
    """Find the cell that stands for a fiber content: where its fiber stalls, fibers lie."""
    with told():
        from fibermelt.study.questions.domain_size import (  # noqa: PLC0415  lazy, as in run
            DomainStudy,
            domain_in_words,
            run_domain_size,
        )
        from fibermelt.study.questions.orbit import read_quantity  # noqa: PLC0415

        given = None if interaction is None else read_quantity("--interaction", interaction, "")
        answer = run_domain_size(
            DomainStudy(
                aspect_ratio=read_quantity("--aspect-ratio", aspect_ratio, ""),
                volume_fraction=read_quantity("--volume-fraction", volume_fraction, ""),
                closure=closure,
                convention=convention,
                interaction=given,
                law=law,
            )
        )
        say(json.dumps(answer, indent=1) if as_json else domain_in_words(answer))
