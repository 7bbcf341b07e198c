"""Commands for one fiber, or many: `fibermelt orbit`, `orientation` and `domain-size`."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from fibermelt.cli.common import JsonOption, say, told
from fibermelt.parts.bead.shapes import SHAPES

__all__ = ["domain_size", "orbit", "orientation"]


def orbit(
    aspect_ratio: Annotated[
        str, typer.Option(metavar="R", help="Length over width of the fiber, at least 1.")
    ],
    shear_rate: Annotated[
        str, typer.Option(metavar="RATE", help='Shear rate, in 1/s or with a unit: 1 or "1 1/s".')
    ],
    viscosity: Annotated[
        str | None,
        typer.Option(
            metavar="MU",
            help='Viscosity of the melt, in Pa s or with a unit: 817 or "817 Pa s"; of the laws of '
            "Carreau and Cross at rest.",
        ),
    ] = None,
    law: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Law of the viscosity: newtonian, the default, power-law, carreau or cross.",
        ),
    ] = None,
    consistency: Annotated[
        str | None, typer.Option(metavar="K", help="Of a power law, in Pa s^n.")
    ] = None,
    index: Annotated[
        str | None, typer.Option(metavar="N", help="Of a law that thins: below 1.")
    ] = None,
    time_constant: Annotated[
        str | None, typer.Option(metavar="TIME", help="Of the law of Carreau, in s.")
    ] = None,
    transition: Annotated[
        str | None,
        typer.Option(metavar="A", help="Of the law of Carreau and Yasuda; 2 if not said."),
    ] = None,
    critical_stress: Annotated[
        str | None, typer.Option(metavar="STRESS", help="Of Cross' law, in Pa.")
    ] = None,
    infinite_viscosity: Annotated[
        str | None,
        typer.Option(metavar="MU", help="Of Carreau and Cross at infinite rate; 0 if not said."),
    ] = None,
    model: Annotated[
        str,
        typer.Option(
            metavar="MODEL",
            help="What answers for the fiber: "
            + "; ".join(f"{name}, {one.meaning}" for name, one in SHAPES.items())
            + ".",
        ),
    ] = next(iter(SHAPES)),
    domain_size: Annotated[
        str | None,
        typer.Option(
            metavar="M",
            help="The cell's radius is M / 2 half-lengths, above 2; of what has one only, and 4, "
            "the paper's, by default.",
        ),
    ] = None,
    angle: Annotated[
        str,
        typer.Option(
            metavar="ANGLE",
            help='Angle from the flow at the start, in degrees, or with a unit, such as "0.5 rad". '
            "Of several angles of the lowest pressure, the first on the way from it is told.",
        ),
    ] = "0",
    path: Annotated[
        str,
        typer.Option(
            metavar="PATH",
            help="superposition, or newton: the paper's own algorithm, of what has a cell only.",
        ),
    ] = "superposition",
    as_json: JsonOption = False,
) -> None:
    """Turn one fiber once in simple shear.

    Tells its period, or where it stalls, and the pressure extremes on it over the turn.
    """
    with told():
        from fibermelt.questions.orbit import (  # noqa: PLC0415  lazy, as in run
            OrbitStudy,
            orbit_in_words,
            read_melt,
            read_quantity,
            run_orbit,
        )

        answer = run_orbit(
            OrbitStudy(
                aspect_ratio=read_quantity("--aspect-ratio", aspect_ratio, ""),
                shear_rate=read_quantity("--shear-rate", shear_rate, "1/s"),
                viscosity=read_melt(
                    law,
                    {
                        "viscosity": viscosity,
                        "consistency": consistency,
                        "index": index,
                        "time_constant": time_constant,
                        "transition": transition,
                        "critical_stress": critical_stress,
                        "infinite_viscosity": infinite_viscosity,
                    },
                ),
                model=model,
                domain_size=_given("--domain-size", domain_size),
                angle=read_quantity("--angle", angle, "rad", bare="deg"),
                path=path,
            )
        )
        say(json.dumps(answer, indent=1) if as_json else orbit_in_words(answer))


def _given(option: str, text: str | None) -> float | None:
    """Return the pure number that an option says, or None where it is left out."""
    from fibermelt.questions.orbit import read_quantity  # noqa: PLC0415  lazy, as in run

    return None if text is None else read_quantity(option, text, "")


RatioOption = Annotated[
    str,
    typer.Option(
        "--aspect-ratio", metavar="R", help="Length over width of the fibers, at least 1."
    ),
]
ClosureOption = Annotated[
    str,
    typer.Option(
        metavar="NAME",
        help="Closure of the fourth moment: linear, quadratic, hybrid, ORS, ORF, ORL, ORW, ORW3, "
        "ORE (the paper's), IBOF or exact; or exact-pdf: the distribution, which needs none.",
    ),
]
ConventionOption = Annotated[
    str,
    typer.Option(
        metavar="NAME",
        help="Rate of deformation that multiplies C_I: standard, sqrt(2 D:D), or paper, sqrt(2) "
        "times that.",
    ),
]


def orientation(
    closure: ClosureOption,
    aspect_ratio: RatioOption,
    interaction: Annotated[
        str | None,
        typer.Option(
            metavar="C_I",
            help="Interaction coefficient, above 0; needed but for ard-rsc, which has b1 to b5.",
        ),
    ] = None,
    model: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="Model of the interaction: folgar-tucker, rsc, ard-rsc, iard, pard, mrd or "
            "nematic.",
        ),
    ] = "folgar-tucker",
    flow: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="Flow: simple-shear (v_1 = x_2), uniaxial, biaxial, planar or mixed.",
        ),
    ] = "simple-shear",
    convention: ConventionOption = "standard",
    parameter: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            help="What the model takes besides, such as kappa=0.1; may be given several times.",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Find how fibers lie in a steady flow.

    Tells the orientation tensor of a suspension that has been in a homogeneous flow for long; the
    rate of the flow does not matter.
    """
    with told():
        from fibermelt.questions.orbit import read_quantity  # noqa: PLC0415  lazy, as in run
        from fibermelt.questions.orientation import (  # noqa: PLC0415
            OrientationStudy,
            orientation_in_words,
            read_parameters,
            run_orientation,
        )

        answer = run_orientation(
            OrientationStudy(
                closure=closure,
                interaction=_given("--interaction", interaction),
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
        str | None,
        typer.Option(metavar="C_I", help="Interaction coefficient, above 0, in place of a law."),
    ] = None,
    law: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Law from content to interaction coefficient: bay (by default) or phan-thien.",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Find the cell for a fiber content.

    It is the cell whose fiber stalls at the angle at which most fibers of that content lie.
    """
    with told():
        from fibermelt.questions.domain_size import (  # noqa: PLC0415  lazy, as in run
            DomainStudy,
            domain_in_words,
            run_domain_size,
        )
        from fibermelt.questions.orbit import read_quantity  # noqa: PLC0415

        answer = run_domain_size(
            DomainStudy(
                aspect_ratio=read_quantity("--aspect-ratio", aspect_ratio, ""),
                volume_fraction=read_quantity("--volume-fraction", volume_fraction, ""),
                closure=closure,
                convention=convention,
                interaction=_given("--interaction", interaction),
                law=law,
            )
        )
        say(json.dumps(answer, indent=1) if as_json else domain_in_words(answer))
