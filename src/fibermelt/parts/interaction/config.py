"""The table ``[interaction]``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, Self

from pydantic import model_validator

from fibermelt.engine.parameters import Section, quantity, setting
from fibermelt.errors import ConfigError
from fibermelt.parts.sources import PAPER_25

__all__ = ["OWN", "WITHOUT_COEFFICIENT", "Interaction", "ModelName", "interacting"]

ModelName = Literal["folgar-tucker", "rsc", "ard-rsc", "iard", "pard", "mrd", "nematic", "jeffery"]
"""The models of orientation; `fibermelt.orientation.models.MODELS` has one of each name."""

OWN: Mapping[str, Mapping[str, float | None]] = {
    "folgar-tucker": {},
    "rsc": {"kappa": None},
    "ard-rsc": {"b1": None, "b2": 0.0, "b3": 0.0, "b4": 0.0, "b5": 0.0, "kappa": 1.0},
    "iard": {"anisotropy": None},
    "pard": {"anisotropy": None},
    "mrd": {"first": 1.0, "second": 0.8, "third": 0.15},
    "nematic": {"potential": None},
    "jeffery": {},
}
"""What a model takes besides the coefficient, by the names that the model has for it, and its
default; None: a study has to say it."""

WITHOUT_COEFFICIENT = ("ard-rsc", "jeffery")
"""Models that have no interaction coefficient."""

PHELPS = "none: fitted to measured orientation, all five together"


class Interaction(Section):
    """How fibers disturb one another: the suspension, and the law of its orientation."""

    volume_fraction: float = quantity(
        0.084, "", "Fiber content by volume.", gt=0, lt=1, source=f"{PAPER_25}, 13 % by weight"
    )
    law: Literal["bay", "phan-thien"] = setting(
        "bay", "What content and aspect ratio say of the coefficient.", source=PAPER_25
    )
    coefficient: float | None = quantity(
        None,
        "",
        "Interaction coefficient C_I; from the law if left out. The models ard-rsc and jeffery "
        "have none.",
        gt=0,
        example="0.0128",
    )
    model: ModelName = setting(
        "folgar-tucker",
        "Law of the orientation along the streamlines. The size of the cell that follows from the "
        "content is Folgar and Tucker's by any model, as the paper has it.",
        source=PAPER_25,
    )
    kappa: float | None = quantity(
        None,
        "",
        "Of the models rsc and ard-rsc: factor by which strain changes the orientation's "
        "eigenvalues; 1, which ard-rsc has if it is not said, slows nothing.",
        gt=0,
        le=1,
        example="0.1",
        source="none: fitted to measured orientation",
    )
    b1: float | None = quantity(
        None,
        "",
        "Of the model ard-rsc: the isotropic part of its diffusion, as C_I is.",
        ge=0,
        example="1.924e-4",
        source=PHELPS,
    )
    b2: float | None = quantity(
        None,
        "",
        "Of the model ard-rsc: diffusion by the orientation; 0 if not said.",
        example="5.839e-3",
        source=PHELPS,
    )
    b3: float | None = quantity(
        None,
        "",
        "Of the model ard-rsc: by the orientation's square; 0 if not said.",
        example="0.04",
        source=PHELPS,
    )
    b4: float | None = quantity(
        None,
        "",
        "Of the model ard-rsc: by the rate of deformation; 0 if not said.",
        example="1.168e-5",
        source=PHELPS,
    )
    b5: float | None = quantity(
        None,
        "",
        "Of the model ard-rsc: by its square; 0 if not said.",
        example="0",
        source=PHELPS,
    )
    anisotropy: float | None = quantity(
        None,
        "",
        "Of the model iard: C_M, what of the diffusion the strain takes from its own directions; "
        "of pard: Omega, from 1/2 on, the second direction's part of it.",
        ge=0,
        le=1,
        example="0.9",
        source="none: fitted to measured orientation",
    )
    first: float | None = quantity(
        None,
        "",
        "Of the model mrd: factor D_1 of the diffusion along most fibers; 1 if not said.",
        gt=0,
        example="1",
        source="the vendor's default (Bakharev, Yu, Speight and Wang, ANTEC 2018)",
    )
    second: float | None = quantity(
        None,
        "",
        "Of the model mrd: factor D_2 along the second direction; 0.8 if not said.",
        gt=0,
        example="0.8",
        source="as first",
    )
    third: float | None = quantity(
        None,
        "",
        "Of the model mrd: factor D_3 along the third direction; 0.15 if not said.",
        gt=0,
        example="0.15",
        source="as first",
    )
    potential: float | None = quantity(
        None,
        "",
        "Of the model nematic: U_0, by which fibers align one another; isotropy is stable below "
        "15 C_I.",
        ge=0,
        example="0.03",
        source="none: fitted to measured orientation",
    )
    closure: Literal[
        "linear", "quadratic", "hybrid", "ORS", "ORF", "ORL", "ORW", "ORW3", "ORE", "IBOF", "exact"
    ] = setting("ORE", "Closure of the fourth moment of the orientation.", source=PAPER_25)
    convention: Literal["standard", "paper"] = setting(
        "standard",
        "Rate of deformation that multiplies the coefficient: sqrt(2 D:D), or sqrt(2) times that.",
        source='"paper" is what the paper\'s Eq. 33 follows, not what its text says',
    )
    start: Literal["isotropic", "inlet"] = setting(
        "isotropic",
        "Orientation of the fibers that enter: every direction alike, or steady in the inlet's "
        "flow.",
    )

    @property
    def own(self) -> dict[str, float]:
        """Return what the model takes besides the coefficient, by name."""
        return {name: getattr(self, name) for name in OWN[self.model]}

    @model_validator(mode="before")
    @classmethod
    def _filled(cls, data: Any) -> Any:
        """Fill in what the model has a default for, so that a resolved study says it itself."""
        if not isinstance(data, Mapping):
            return data
        said = {name: value for name, value in data.items() if value is not None}
        model = said.get("model", "folgar-tucker")
        # What is no model is for the field to refuse.
        own = OWN[model] if isinstance(model, str) and model in OWN else {}
        return {name: value for name, value in own.items() if value is not None} | said

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        """Refuse parameters of another model, and a model without what it needs."""
        asked = f'interaction.model = "{self.model}"'
        own = OWN[self.model]
        for name in dict.fromkeys(name for one in OWN.values() for name in one):
            value = getattr(self, name)
            if value is not None and name not in own:
                models = " or ".join(f'"{model}"' for model, names in OWN.items() if name in names)
                takes = f"takes {', '.join(own)}" if own else "takes none"
                msg = (
                    f"interaction.{name} = {value:g}: is no parameter of {asked}, which {takes}: "
                    f"leave it away, or say interaction.model = {models}"
                )
                raise ValueError(msg)
            if value is None and name in own:
                example = type(self).model_fields[name].json_schema_extra["example"]  # type: ignore[index]
                msg = (
                    f"interaction.{name}: missing: {asked} cannot do without; say it, such as "
                    f"interaction.{name} = {example}"
                )
                raise ValueError(msg)
        if self.coefficient is not None and self.model in WITHOUT_COEFFICIENT:
            instead = f": it has {', '.join(own)} in its place" if own else ""
            msg = (
                f"interaction.coefficient = {self.coefficient:g}: {asked} has no such "
                f"coefficient{instead}: leave it away, or take another model"
            )
            raise ValueError(msg)
        if self.start == "inlet" and self.model == "jeffery":
            msg = (
                f'interaction.start = "inlet": fibers that do not interact, {asked}, turn on and '
                'on in the inlet\'s shear: take interaction.start = "isotropic", or another model'
            )
            raise ValueError(msg)
        if own:
            self._build(asked)
        return self

    def _build(self, asked: str) -> None:
        """Refuse what the model itself does: a range of its own, a diffusion that is negative."""
        from fibermelt.orientation.flows import flow_gradient, strain_and_spin  # noqa: PLC0415  lazy
        from fibermelt.parts.interaction.models import build_model  # noqa: PLC0415

        coefficient = 1.0 if self.coefficient is None else self.coefficient
        try:
            model = build_model(self.model, 1.0, coefficient, self.convention, self.own)
            # Every planar flow has the eigenvalues of simple shear in its rate of deformation.
            model.refuse_flow(strain_and_spin(flow_gradient("simple-shear"))[0])
        except ConfigError as error:
            msg = f"{asked}: {str(error).removeprefix(f'{self.model}: ')}"
            raise ValueError(msg) from error


def interacting(below: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is left of a table ``[interaction]`` under one that names another model.

    Parameters
    ----------
    below, over : mapping
        Two tables ``[interaction]`` as written. What is said of one model is not true of another:
        two have an ``anisotropy``, and each means something else by it.
    """
    model = over.get("model", below.get("model"))
    if model == below.get("model", "folgar-tucker") or not isinstance(model, str):
        return dict(below)
    gone = {name for one in OWN.values() for name in one}
    if model in WITHOUT_COEFFICIENT:
        gone.add("coefficient")
    return {name: value for name, value in below.items() if name not in gone}
