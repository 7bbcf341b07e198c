"""What a shape of fibers is: how it is named and told, solved, stored, and what it can do.

What computes is imported when it is asked for: tables of a study are made of the names alone.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fibermelt.errors import ConfigError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from fibermelt.engine.stages import Say
    from fibermelt.fiber.cell_data import CellNumerics
    from fibermelt.fiber.models import FiberModel
    from fibermelt.fiber.thinning import ThinningResponse
    from fibermelt.melt import ViscosityLaw

    Arrays = Mapping[str, NDArray[np.float64]]

__all__ = ["FiberShape", "Sizes"]


@dataclass(frozen=True)
class Sizes:
    """How large a fiber is.

    Parameters
    ----------
    half_length : float
        Of its longest axis [m]; of what has no size of its own, one.
    aspect_ratio : float
        Length over width [-], at least one.
    thickness_ratio : float, optional
        Length over thickness [-], of a body of three axes.
    """

    half_length: float
    aspect_ratio: float
    thickness_ratio: float | None = None


class FiberShape(ABC):
    """A shape of fibers, as ``fiber.model`` of a study names it.

    Attributes
    ----------
    name : str
        Its name in a study.
    meaning, label, plural : str
        What it is, in words: in the reference of parameters, in keys of figures, on the page.
    rank : int
        Its place among the shapes, the first being the default.
    has_cell : bool
        Whether it is solved for in a cell, which has a size and a mesh.
    in_space : bool
        Whether it is known in any orientation; else it is a cylinder across the flow.
    has_thickness : bool
        Whether it has a third axis of its own; it then turns about all axes and has no one orbit.
    thins : bool
        Whether it has an answer in a melt that thins.
    instead : str
        Which shape to take where this one has no answer in such a melt.
    table_bounds : (float, float)
        Largest estimated errors of its table of such a melt: of the spin over the strain's size,
        and of the pressure extremes over the largest pressure. At n = 0.5 an ellipse's has 1e-5 and
        1.2e-3, at 0.25 3e-3; it refines itself to 5e-3 where what lies between its points decides,
        and no law of a melt is known so well.
    stored : tuple of str
        Variables of the cell that it is read back from.
    """

    name: str
    meaning: str
    label: str
    plural: str
    rank: int = 100
    has_cell: bool = False
    in_space: bool = False
    has_thickness: bool = False
    thins: bool = True
    instead: str = "ellipse"
    table_bounds: tuple[float, float] = (5e-3, 1e-2)
    stored: tuple[str, ...] = ("aspect_ratio",)

    @abstractmethod
    def model(self, sizes: Sizes, cell: float, numerics: CellNumerics | None) -> FiberModel:
        """Return the fiber in a Newtonian melt.

        Parameters
        ----------
        sizes : Sizes
            How large it is.
        cell : float
            Domain-size factor ``M`` of its cell [-]; of one without, not read.
        numerics : CellNumerics or None
            How its cell is solved; None of one without.
        """

    def restored(self, stored: Arrays) -> FiberModel:
        """Return the fiber from the variables that ``stored`` names, as far as they are there."""
        ratio = float(stored["aspect_ratio"])
        return self.model(Sizes(1.0, ratio), math.nan, None)

    def solved(
        self, sizes: Sizes, cell: float, numerics: CellNumerics | None, say: Say
    ) -> dict[str, Any]:
        """Return the variables of a fiber's cell: here closed forms, nothing solved or in error.

        An unbounded fiber tumbles, as ``xi < 1``. Parameters as of `model`.
        """
        from fibermelt.fiber.surroundings import surroundings  # noqa: PLC0415  lazy: see the module

        model = self.model(Sizes(1.0, sizes.aspect_ratio, sizes.thickness_ratio), cell, numerics)
        response, around = model.response, surroundings(model)
        say(f"closed form of an unbounded {self.name}, shape factor {response.shape_factor:.6f}")
        return {
            "aspect_ratio": sizes.aspect_ratio,
            "domain_size": math.nan,
            "shape_factor": response.shape_factor,
            "stall_angle": math.nan,
            "tip_pressure": response.tip_pressure,
            "shape_factor_error": 0.0,
            "tip_pressure_error": 0.0,
            "cell_unknowns": 0,
            "surface_angle": response.surface,
            "surface_basis": response.basis,
            "cell_point": around.points,
            "cell_triangle": around.cells,
            "cell_edge": around.lines,
            "cell_velocity": around.velocity,
            "cell_pressure": around.pressure,
        }

    def thinning(
        self,
        sizes: Sizes,
        law: ViscosityLaw,
        cell: float,
        numerics: CellNumerics,
        rates: tuple[float, float] | None = None,
    ) -> ThinningResponse:
        """Return the fiber's table of a melt that thins.

        Parameters
        ----------
        sizes, cell, numerics
            As of `model`.
        law : ViscosityLaw
            The melt.
        rates : (2,) tuple of float, optional
            Lowest and highest ``gamma_dot`` [1/s] that will be asked for; all if not given.

        Raises
        ------
        ConfigError
            If it has none.
        """
        msg = f'fiber.model = "{self.name}": has no answer in a melt that thins'
        raise ConfigError(msg)

    def refuse_in_melt(self, sizes: Sizes, law: ViscosityLaw) -> None:  # noqa: B027  most have
        """Refuse a melt that thins and that `thinning` has no table of, before it is asked."""
