"""Commands on voids: `fibermelt voids`."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from fibermelt.cli.common import JsonOption, columns, given_folder, say, told

__all__ = ["voids"]


def voids(
    folder: Annotated[
        str, typer.Argument(metavar="DIR", help="Results folder of a finished run of a bead.")
    ],
    material: Annotated[
        str | None,
        typer.Option(
            metavar="CARD",
            help="Material card: paper, abs, abs-cf13-thinning, abs-cf20, abs-power-law, "
            "made-up-carreau, pa6-cf20, pa66-gf30, pei, pla, pla-cf14, ps, or the path of a TOML "
            "file; the study's by default.",
        ),
    ] = None,
    moisture: Annotated[
        str | None,
        typer.Option(
            metavar="W",
            help='Moisture over the mass of polymer, such as "0.17 %"; the study\'s by default, '
            "with another card as received.",
        ),
    ] = None,
    temperature: Annotated[
        str | None,
        typer.Option(
            metavar="T",
            help='Temperature of the melt, such as "230 degC" (a bare number is in K); the '
            "study's by default, with another card that of printing.",
        ),
    ] = None,
    against: Annotated[
        str | None,
        typer.Option(
            metavar="DIR", help="Another finished run to hold it against; the paper's by default."
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Tell where a finished bead can void, and what helps.

    What helps is computed the first time it is asked for, in about a minute, from flows beside the
    run's own, which stay in DIR/levers; the run's summary and page then say it too. At another
    moisture, temperature or of another material the pressures on fibers stay those of the run,
    nothing is computed anew, and nothing in DIR is changed.
    """
    with told():
        from fibermelt.engine.progress import observing  # noqa: PLC0415
        from fibermelt.engine.wrapping import wrapped  # noqa: PLC0415
        from fibermelt.levers.publish import with_levers  # noqa: PLC0415
        from fibermelt.parts.voids.summary import voids_in_words  # noqa: PLC0415
        from fibermelt.questions.orbit import read_quantity  # noqa: PLC0415  lazy, as in run
        from fibermelt.questions.voids import VoidQuestion, answer_voids, held_against  # noqa: PLC0415

        question = VoidQuestion(
            material=material,
            moisture=None if moisture is None else read_quantity("--moisture", moisture, ""),
            temperature=(
                None if temperature is None else read_quantity("--temperature", temperature, "K")
            ),
        )
        directory = given_folder(folder)
        if question == VoidQuestion():
            with observing() as observer:
                answer = with_levers(directory, observer=observer)
        else:
            answer = answer_voids(directory, question)
        if against is not None:
            answer = held_against(answer, given_folder(against))
        say(
            json.dumps(answer, indent=1)
            if as_json
            else wrapped(voids_in_words({"voids": answer}), columns())
        )
