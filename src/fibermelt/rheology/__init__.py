"""What the melt is: viscosity laws."""

from fibermelt.rheology.newtonian import Newtonian

__all__ = ["Newtonian"]
