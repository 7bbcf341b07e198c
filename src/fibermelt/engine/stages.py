"""What a stage of the chain is, and the key under which its result is stored."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from fibermelt.engine.files import canonical, digest
from fibermelt.engine.named import named
from fibermelt.errors import ConvergenceError

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.engine.parameters import Value

__all__ = [
    "Compute",
    "ComputeFrom",
    "Estimate",
    "Inputs",
    "Neighbour",
    "Parameters",
    "Say",
    "Stage",
    "always",
    "keys",
    "refuse_beyond",
    "stage_parameters",
]


class Parameters(Mapping[str, Any]):
    """The parameters that a stage declared, by their keys, and no others.

    A stage that read what it did not declare would be reused when it must not be: it raises.
    """

    def __init__(self, values: Mapping[str, Value]) -> None:
        self._values = dict(values)

    def __getitem__(self, key: str) -> Any:
        """Return the value of a key such as ``flow.gap``, in SI."""
        if key not in self._values:
            msg = f"the stage did not declare {key}: add it to its parameters"
            raise KeyError(msg)
        return self._values[key]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the keys."""
        return iter(self._values)

    def __len__(self) -> int:
        """Return the number of parameters."""
        return len(self._values)

    def section(self, name: str) -> dict[str, Any]:
        """Return ``{"gap": 0.003, ...}`` of a table such as ``flow``, as far as declared."""
        prefix = f"{name}."
        return {
            key.removeprefix(prefix): value
            for key, value in self._values.items()
            if key.startswith(prefix)
        }


Inputs = Mapping[str, "xr.Dataset"]
"""The data of the stages that a stage is fed, by their names."""

Say = Callable[[str], None]
"""Takes a line of progress."""

Compute = Callable[[Parameters, Inputs, Say], "xr.Dataset"]
"""From parameters and the data of the inputs to data."""


@dataclass(frozen=True, eq=False)
class Neighbour:
    """The same stage of another case, finished.

    Parameters
    ----------
    parameters : Parameters
        What it read.
    data : xarray.Dataset
        Its data.
    key : str
        Its key.
    """

    parameters: Parameters
    data: xr.Dataset
    key: str = ""


ComputeFrom = Callable[[Parameters, Inputs, Say, Neighbour], tuple["xr.Dataset", bool]]
"""As `Compute`, beginning with what a neighbour found; and whether that led to the data: where it
leads nowhere, they are those from cold."""


@dataclass(frozen=True)
class Estimate:
    """What a stage says of its own error, and how large that may be.

    Parameters
    ----------
    name : str
        The variable that has it, or what follows from it.
    value : float
        Its largest value.
    bound : float
        Beyond it, or where the value is no number, the stage has no answer.
    cure : str
        What to change then.
    """

    name: str
    value: float
    bound: float
    cure: str


def _no_estimates(parameters: Parameters, data: xr.Dataset) -> tuple[Estimate, ...]:
    """Return no estimate: the stage is exact, or raises itself where it is not."""
    return ()


def _no_refusal(parameters: Parameters, name: str, data: xr.Dataset) -> None:
    """Refuse nothing: most stages have an answer whatever comes before them."""


def _none(values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return no stage: most have the same inputs in every study."""
    return ()


def always(values: Mapping[str, Value]) -> bool:
    """Tell that a stage costs less than to store it: milliseconds, or megabytes."""
    return True


def _never(values: Mapping[str, Value]) -> bool:
    """Return that a stage costs more to compute than to store, as most do."""
    return False


@dataclass(frozen=True)
class Stage:
    """One step of the chain: data from parameters and from the data of other stages.

    Parameters
    ----------
    name : str
        Its name, a word.
    version : int
        Raised whenever the same parameters give other numbers, so that no old ones are reused.
    parameters : tuple of str
        What it reads: keys (``numerics.cell_order``) or whole tables (``flow``).
    inputs : tuple of str
        Names of the stages that it is fed; they come before it in the chain.
    compute : callable or str
        Does it; as a text its address (`fibermelt.engine.named`), loaded when it is needed.
    told_with : str
        Another stage under whose name its cost is told, in the summary.
    inputs_if : callable, optional
        From the resolved study to names of stages that it is fed besides, in some studies only.
    light_if : callable, optional
        From the resolved study to whether it costs less to compute than to store: a sweep then
        computes it again for each batch of cases that needs it.
    compute_from : callable, optional
        Does it from the result of a neighbour, to the same answer within its stated error: in a
        sweep, where neighbours abound. It is no part of the stage's key.
    but_for_scale : callable, optional
        From its parameters to what decides its result but for a scale: to neighbours that agree
        in it ``compute_from`` brings a result by scaling. All parameters by default.
    estimates : callable, optional
        From its parameters and its data to the errors that it estimates: data with one beyond its
        bound are no answer, and are neither used nor stored.
    foresee : callable, optional
        From its parameters, and the name and data of a stage before it: raises ``ConfigError``
        where it will have no answer, before what lies between is computed.
    """

    name: str
    version: int
    parameters: tuple[str, ...]
    inputs: tuple[str, ...]
    compute: Compute | str
    told_with: str = ""
    inputs_if: Callable[[Mapping[str, Value]], tuple[str, ...]] = _none
    light_if: Callable[[Mapping[str, Value]], bool] = _never
    compute_from: ComputeFrom | str | None = None
    but_for_scale: Callable[[Mapping[str, Any]], Mapping[str, Any]] | str = dict
    estimates: Callable[[Parameters, xr.Dataset], tuple[Estimate, ...]] | str = _no_estimates
    foresee: Callable[[Parameters, str, xr.Dataset], None] | str = _no_refusal

    @property
    def heading(self) -> str:
        """Return the name under which its cost is told."""
        return self.told_with or self.name

    def begin(
        self, parameters: Parameters, inputs: Inputs, say: Say, start: Neighbour | None
    ) -> tuple[xr.Dataset, str]:
        """Compute it, from a neighbour's result where there is one and it can begin with it.

        Return its data and the key of the neighbour that they came from; empty: from cold.

        Raises
        ------
        FibermeltError
            If it has no answer, also where what it found is not good by its own estimate.
        """
        if self.compute_from is None or start is None:
            data, is_from_it = named(self.compute)(parameters, inputs, say), False
        else:
            data, is_from_it = named(self.compute_from)(parameters, inputs, say, start)
        refuse_beyond(self.name, named(self.estimates)(parameters, data))
        return data, start.key if start is not None and is_from_it else ""

    def fed(self, values: Mapping[str, Value]) -> tuple[str, ...]:
        """Return the names of the stages that it is fed in a resolved study."""
        return self.inputs + self.inputs_if(values)


def refuse_beyond(name: str, estimates: Iterable[Estimate]) -> None:
    """Refuse what is not good by its own estimate.

    Raises
    ------
    ConvergenceError
        What it is, the error, its bound and the way out.
    """
    for estimate in estimates:
        if not estimate.value <= estimate.bound:
            msg = (
                f"{name}: {estimate.name} = {estimate.value:.2g} by its own estimate, "
                f"bound {estimate.bound:.2g}: no answer; {estimate.cure}"
            )
            raise ConvergenceError(msg)


def stage_parameters(stage: Stage, values: Mapping[str, Value]) -> Parameters:
    """Return the part of a resolved study that a stage reads.

    Raises
    ------
    KeyError
        If it declares a key or a table that no study has.
    """
    return Parameters(
        {key: values[key] for key in _read_by(stage.name, stage.parameters, tuple(values))}
    )


@lru_cache(maxsize=256)
def _read_by(stage: str, parameters: tuple[str, ...], known: tuple[str, ...]) -> tuple[str, ...]:
    """Return which of the keys of a study a stage reads: the same for every case of a sweep."""
    read: list[str] = []
    for declared in parameters:
        found = [key for key in known if key == declared or key.startswith(f"{declared}.")]
        if not found:
            msg = f"stage {stage} declares {declared}, which no study has"
            raise KeyError(msg)
        read.extend(found)
    return tuple(read)


def keys(stages: Sequence[Stage], values: Mapping[str, Value]) -> dict[str, str]:
    """Return the key of every stage: a hash of all that its result depends on.

    Of its name and version, the parameters that it reads, and the keys of its inputs; so a
    change of a fiber's parameter leaves the key of the flow alone.

    Parameters
    ----------
    stages : sequence of Stage
        The chain, inputs before those who need them.
    values : mapping
        The resolved study, ``{"flow.gap": 0.003, ...}``.
    """
    found: dict[str, str] = {}
    for stage in stages:
        content = {
            "stage": stage.name,
            "version": stage.version,
            "parameters": dict(stage_parameters(stage, values)),
            "inputs": {name: found[name] for name in stage.fed(values)},
        }
        found[stage.name] = digest(canonical(content))
    return found
