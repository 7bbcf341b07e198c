"""fibermelt: where a short-fiber polymer bead will void.

Names are loaded when they are first used, so that importing the package costs next to nothing and
only those who solve a flow or a cell load the finite elements.
"""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

__version__ = "0.1.0"
