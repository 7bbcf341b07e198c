"""How many examples hypothesis draws, by the count that each test can afford."""

import os

from hypothesis import settings

FUZZ = int(os.environ.get("FUZZ", "1"))
"""How many times as many examples as usual: `make fuzz` sets it."""


def examples(count: int) -> settings:
    return settings(max_examples=FUZZ * count)
