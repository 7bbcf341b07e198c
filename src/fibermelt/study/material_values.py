"""What a material card can hold: every value declared once, with unit, meaning and range."""

from __future__ import annotations

from pydantic import Field

from fibermelt.study.parameters import Section, quantity

__all__ = [
    "CardValues",
    "DiffusionValues",
    "IsothermValues",
    "MeltValues",
    "SolutionValues",
    "SurfaceValues",
    "WettingValues",
]


class MeltValues(Section):
    """The melt itself."""

    density: float = quantity(
        1000.0,
        "kg/m^3",
        "Density of the melt with its fibers.",
        gt=0,
        le=1e5,
        example="1.15 g/cm^3",
    )
    polymer_fraction: float = quantity(
        1.0, "", "Mass fraction that is polymer and holds the moisture.", gt=0, le=1, example="87 %"
    )
    temperature: float = quantity(
        503.15, "K", "Temperature of printing.", ge=273.16, le=647.096, example="230 degC"
    )
    coldest: float = quantity(
        473.15, "K", "Lowest temperature of printing.", ge=273.16, le=647.096, example="200 degC"
    )
    hottest: float = quantity(
        533.15, "K", "Highest temperature of printing.", ge=273.16, le=647.096, example="260 degC"
    )
    moisture: float | None = quantity(
        None, "", "Moisture over the mass of polymer, as received.", ge=0, le=1, example="0.17 %"
    )


class IsothermValues(Section):
    """Moisture against the activity of water."""

    content: float | None = quantity(
        None, "", "Moisture at 100 % relative humidity.", gt=0, le=1, example="0.5 %"
    )
    reference_temperature: float | None = quantity(
        None, "K", "Temperature of that isotherm.", ge=200, le=647.096, example="23 degC"
    )
    mixing_heat: float | None = quantity(
        None, "J/mol", "Heat from liquid to dissolved water.", ge=-1e5, le=1e5, example="0 J/mol"
    )


class DiffusionValues(Section):
    """Diffusion of water in the melt."""

    prefactor: float | None = quantity(
        None, "m^2/s", "D_0 of Arrhenius' law.", gt=0, le=1, example="7.54e-6 m^2/s"
    )
    activation_energy: float | None = quantity(
        None, "J/mol", "Activation energy of diffusion.", ge=0, le=1e6, example="43.5 kJ/mol"
    )


class SurfaceValues(Section):
    """Surface tension of the melt."""

    tension: float | None = quantity(
        None, "N/m", "At the reference temperature.", gt=0, le=1, example="38.5 mN/m"
    )
    reference_temperature: float | None = quantity(
        None, "K", "Temperature of that tension.", ge=200, le=1000, example="20 degC"
    )
    slope: float | None = quantity(
        None, "N/(m K)", "Change with temperature.", ge=-1e-3, le=0, example="-0.07 mN/(m K)"
    )


class WettingValues(Section):
    """The melt on its fibers."""

    contact_angle: float | None = quantity(
        None, "rad", "Young's angle through the melt.", ge=0, le=3.14, example="60 deg"
    )


class SolutionValues(Section):
    """Nucleation in the polymer solution, after Han and Han."""

    prefactor: float | None = quantity(None, "", "B_1.", gt=0, le=1e30, example="1.0")
    prefactor_temperature: float | None = quantity(
        None, "K", "B_2.", ge=-1e6, le=1e6, example="1000 K"
    )
    interaction: float | None = quantity(
        None, "", "Flory and Huggins' chi.", ge=-10, le=20, example="4.3"
    )


class CardValues(Section):
    """Every value of a card, in SI."""

    melt: MeltValues = Field(default_factory=MeltValues)
    isotherm: IsothermValues = Field(default_factory=IsothermValues)
    diffusion: DiffusionValues = Field(default_factory=DiffusionValues)
    surface: SurfaceValues = Field(default_factory=SurfaceValues)
    wetting: WettingValues = Field(default_factory=WettingValues)
    solution: SolutionValues = Field(default_factory=SolutionValues)
