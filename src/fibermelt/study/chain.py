"""The chain of a study: every stage of every part. Here the scales meet."""

from __future__ import annotations

from fibermelt.engine.parts import Chain
from fibermelt.study.parts import parts

__all__ = ["CHAIN"]

CHAIN = Chain(
    stages=tuple(stage for part in parts() for stage in part.brings),
    parts=parts(),
    version=6,
)
"""What `fibermelt run` goes through, as far as a study asks for it."""
