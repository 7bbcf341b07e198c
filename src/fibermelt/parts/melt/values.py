"""What a material card can hold: every value declared once, with unit, meaning and range."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any, Literal, cast

from pydantic import Field

from fibermelt.engine.parameters import Section, excerpt, quantity, setting
from fibermelt.melt import LAWS

__all__ = [
    "CONSTANTS",
    "OPTIONAL",
    "CardValues",
    "DiffusionValues",
    "HeatValues",
    "IsothermValues",
    "LawName",
    "MeltValues",
    "SurfaceValues",
    "ViscosityValues",
    "WettingValues",
]

if TYPE_CHECKING:
    LawName = str
else:
    LawName = Literal[tuple(LAWS)]
"""The laws of viscosity by their names."""

CONSTANTS: Mapping[str, tuple[str, ...]] = {
    name: tuple(one.name for one in fields(cast("Any", law)) if one.name != "temperature")
    for name, law in LAWS.items()
}
"""The constants of each law, by the names that the law has for them."""

OPTIONAL: Mapping[str, float] = {
    one.name: one.default
    for law in LAWS.values()
    for one in fields(cast("Any", law))
    if isinstance(one.default, float)
}
"""Constants that a law has a default for."""


class Constants(Section):
    """The constants of a law of viscosity."""

    viscosity: float | None = quantity(
        None,
        "Pa s",
        "Dynamic viscosity; of Carreau's and Cross' law at rest.",
        ge=1e-6,
        le=1e12,
        example="817 Pa s",
    )
    consistency: float | None = quantity(
        None,
        "Pa s",
        "K of a power law, its viscosity at a rate of 1/s (its unit is Pa s^n).",
        ge=1e-6,
        le=1e12,
        example="8213 Pa s",
    )
    index: float | None = quantity(
        None, "", "Power-law index n; below 1 the melt thins.", gt=0, le=2, example="0.5"
    )
    lowest_rate: float | None = quantity(
        None,
        "1/s",
        "Rate below which a power law is level.",
        ge=1e-9,
        le=1e3,
        example="0.01 1/s",
    )
    time_constant: float | None = quantity(
        None,
        "s",
        "Time constant of Carreau's law: its inverse is the rate where thinning begins.",
        ge=1e-9,
        le=1e6,
        example="0.5 s",
    )
    infinite_viscosity: float | None = quantity(
        None, "Pa s", "Viscosity at the highest rates.", ge=0, le=1e12, example="0 Pa s"
    )
    transition: float | None = quantity(
        None, "", "Yasuda's exponent a; 2 is Carreau's law.", ge=0.1, le=10, example="2"
    )
    critical_stress: float | None = quantity(
        None,
        "Pa",
        "Stress at which half of Cross' viscosity at rest is left (tau*).",
        ge=1e-3,
        le=1e12,
        example="30.8 kPa",
    )
    reference_viscosity: float | None = quantity(
        None,
        "Pa s",
        "Viscosity at rest at the reference temperature (D1).",
        ge=1e-6,
        le=1e30,
        example="4.89e10 Pa s",
    )
    reference_temperature: float | None = quantity(
        None, "K", "Reference temperature of the WLF law (D2).", ge=100, le=1000, example="100 degC"
    )
    wlf_a1: float | None = quantity(
        None, "", "A1 of the WLF law, of the natural logarithm.", gt=0, le=200, example="23.76"
    )
    wlf_a2: float | None = quantity(
        None, "K", "A2 of the WLF law, a difference.", gt=0, le=500, example="51.6 K"
    )
    activation_temperature: float | None = quantity(
        None,
        "K",
        "E/R of Arrhenius' law, a difference, by which the viscosity follows the temperature; 0: "
        "not known.",
        ge=0,
        le=1e5,
        example="12138 K",
    )


class ViscosityValues(Constants):
    """The law of viscosity."""

    law: LawName | None = setting(None, "Law of viscosity.", example="newtonian")
    temperature: float | None = quantity(
        None, "K", "Temperature at which the constants hold.", ge=200, le=1000, example="230 degC"
    )
    slowest: float | None = quantity(
        None, "1/s", "Lowest rate that was measured.", gt=0, le=1e9, example="1 1/s"
    )
    fastest: float | None = quantity(
        None, "1/s", "Highest rate that was measured.", gt=0, le=1e9, example="1000 1/s"
    )

    def fault(self) -> str:
        """Return what contradicts itself, in words; nothing if all is well."""
        said = [name for name in Constants.model_fields if getattr(self, name) is not None]
        if self.law is None:
            named = f"; {', '.join(said)} need it" if said else ""
            return f"viscosity.law: missing{named}" if said else ""
        for name in said:
            if name not in (*CONSTANTS[self.law], "activation_temperature"):
                value = excerpt(getattr(self, name))
                return (
                    f'viscosity.{name} = {value}: is no constant of the law "{self.law}", which '
                    f"has {', '.join(CONSTANTS[self.law])}: leave it away"
                )
        if self.law != "cross-wlf" and self.temperature is None:
            return "viscosity.temperature: missing: at which temperature do the constants hold?"
        if self.law == "cross-wlf" and self.activation_temperature is not None:
            return "viscosity.activation_temperature: cross-wlf has its own: leave it away"
        return ""


class HeatValues(Section):
    """How the melt takes up and conducts heat; no result rests on it yet."""

    conductivity: float | None = quantity(
        None, "W/(m K)", "Thermal conductivity.", gt=0, le=1e3, example="0.17 W/(m K)"
    )
    capacity: float | None = quantity(
        None, "J/(kg K)", "Specific heat capacity.", gt=0, le=1e5, example="2050 J/(kg K)"
    )


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


class CardValues(Section):
    """Every value of a card, in SI."""

    melt: MeltValues = Field(default_factory=MeltValues)
    viscosity: ViscosityValues = Field(default_factory=ViscosityValues)
    heat: HeatValues = Field(default_factory=HeatValues)
    isotherm: IsothermValues = Field(default_factory=IsothermValues)
    diffusion: DiffusionValues = Field(default_factory=DiffusionValues)
    surface: SurfaceValues = Field(default_factory=SurfaceValues)
    wetting: WettingValues = Field(default_factory=WettingValues)
