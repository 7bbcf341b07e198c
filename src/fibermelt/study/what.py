"""The table ``[study]``: which parts a study has."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import model_validator

from fibermelt.engine.parameters import Section, setting

__all__ = ["PartName", "What"]

PartName = Literal[
    "bead",
    "orientation",
    "interaction",
    "orbits",
    "dimensions",
    "thinning",
    "voids",
    "verification",
    "claims",
]
"""What can be asked for; the chain has a part of each name."""


class What(Section):
    """What is computed: a study can be of a bead, of a single fiber, or of both."""

    parts: tuple[PartName, ...] = setting(
        ["bead"],
        'What is computed. "bead": fibers along the streamlines of the deposition flow; '
        '"orientation": orientation tensors along them; "interaction": from fiber content to the '
        'size of the cell; "orbits": '
        'one fiber in simple shear; "dimensions": what the plane ellipse costs against a spheroid; '
        '"thinning": what melts that thin do to bead and fibers; '
        '"voids": where in the bead voids can start; "verification": what this installation is '
        'checked against; "claims": whether the paper\'s claims hold in what the others found.',
    )
    ladder: Literal["brief", "quick", "full"] = setting(
        "brief",
        'How much "verification" checks: in about 5 s, in 10 s, or as fibermelt verify does.',
    )

    @model_validator(mode="after")
    def _something(self) -> Self:
        """Refuse a study of nothing."""
        if not self.parts:
            msg = 'study.parts = []: name at least one, such as ["bead"]'
            raise ValueError(msg)
        if self.parts == ("claims",):
            msg = (
                'study.parts = ["claims"]: nothing to judge them by; name "bead", "orbits", '
                '"interaction" or "voids" beside it'
            )
            raise ValueError(msg)
        return self
