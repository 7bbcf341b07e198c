"""Orientation of many fibers: second-order tensors, their closures, and what moves them.

The tensor ``a_ij = <p_i p_j>`` is the second moment of the orientation distribution (Advani and
Tucker 1987, doi:10.1122/1.549945): symmetric, of trace 1, eigenvalues in [0, 1]. It stays 3x3 in
planar flow. Every function takes arrays (..., 3, 3) of any batch.
"""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
