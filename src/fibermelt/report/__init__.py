"""What a person looks at: figures of a finished study. matplotlib is imported here only."""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules={"plot"})
