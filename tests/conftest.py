"""What holds for all tests."""

from examples_drawn import FUZZ
from hypothesis import HealthCheck, settings

# A busy machine is no failure: nothing here is judged by the time that it takes. Where the
# environment says CI, hypothesis' own profile is the parent: the same examples in every run.
settings.register_profile(
    "untimed",
    deadline=None,
    derandomize=settings.default.derandomize and FUZZ == 1,
    suppress_health_check=[HealthCheck.too_slow],
    max_examples=FUZZ * settings.default.max_examples,
)
settings.load_profile("untimed")
