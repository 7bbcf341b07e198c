"""Paths as tables: what is read, in which units, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from fibermelt import ConfigError, FlowHistory
from fibermelt.fiber import follow_directors
from fibermelt.path_table import as_many_points, read_paths

LINEAR = np.array([[0.3, 1.0, 0.0], [0.1, -0.5, 0.2], [0.0, 0.0, 0.2]])
SPACE = (
    "time [s], x [mm], y [mm], z [mm], u [mm/s], v [mm/s], w [mm/s], pressure [MPa], "
    + ", ".join(f"L_{i}{j} [1/s]" for i in "xyz" for j in "xyz")
)


def linear(points: int, turn: float = 0.0) -> FlowHistory:
    t = np.linspace(0.0, 3.0, points)
    x = np.stack([expm(LINEAR * time) @ [1.0, 1.0, 0.5 + turn] for time in t])
    return FlowHistory(t, x, x @ LINEAR.T, np.tile(LINEAR, (points, 1, 1)), 2e6 - 1e6 * t)


def rows(path: FlowHistory, first: str = "") -> list[str]:
    table = np.column_stack(
        [
            path.time,
            1e3 * path.position,
            1e3 * path.velocity,
            1e-6 * path.pressure,
            path.gradient.reshape(-1, 9),
        ]
    )
    return [first + ", ".join(f"{value:.17g}" for value in row) for row in table]


def write(folder: Path, *lines: str) -> Path:
    file = folder / "paths.csv"
    file.write_text("\n".join(lines))
    return file


def test_a_path_is_read_in_its_units(tmp_path: Path) -> None:
    path = linear(21)
    found = FlowHistory.from_csv(write(tmp_path, "# a comment", SPACE, *rows(path)))
    for name in ("time", "position", "velocity", "gradient", "pressure"):
        assert getattr(found, name) == pytest.approx(getattr(path, name), rel=1e-14, abs=1e-14)
    assert not found.planar


def test_several_paths_in_a_plane_without_pressure(tmp_path: Path) -> None:
    head = "path, time, x, y, u, v, L_xx, L_xy, L_yx, L_yy, temperature [degC]"
    lines = [f"{k}, {t}, 0, 0, 0, 0, 1e-9, {k}, 0, 0, 230" for k in (4, 7) for t in (0, 1, 2)]
    table = read_paths(write(tmp_path, head, *lines))
    assert [path.plane_gradient[0, 0, 1] for path in table.histories] == [4.0, 7.0]
    assert table.histories[0].planar
    assert table.numbers == (4, 7)
    assert table.histories[0].temperature == pytest.approx(503.15)
    assert table.divergence[0] == pytest.approx(1e-9 / 4.0)
    assert [note.split(",")[0] for note in table.notes] == [
        "a trace of up to 2.5e-10 of the gradient was taken out",
        "there is no pressure: it is taken for zero",
    ]
    assert FlowHistory.from_csv(tmp_path / "paths.csv").time.shape == (2, 3)


def test_points_put_in_leave_the_fibers_where_they_are(tmp_path: Path) -> None:
    """They lie on the cubic that fibers follow, but for its slopes at the new points."""
    short, long = as_many_points([linear(41), linear(97, turn=0.2)])
    assert short.time.shape == long.time.shape == (97,)
    assert np.isin(linear(41).time, short.time).all()
    ends = [
        follow_directors(path, 0.9, [[0.6, 0.0, 0.8]]).direction for path in (short, linear(41))
    ]
    assert ends[0][..., -1, :] == pytest.approx(ends[1][..., -1, :], abs=1e-7)
    assert short.consistency().told == ()


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (["time, x"], "holds no path"),
        (
            ["time, x, y, u, v, L_xx, L_xy, L_yx", "0,0,0,0,0,0,0,0"],
            "no column L_yy: a path in a plane",
        ),
        (["time [min]x, x", "0, 0"], "is not known"),
        (["time [kg], x", "0, 0"], r'column "time \[kg\]" has the unit'),
        (["time, time", "0, 0"], "stands twice"),
        ([SPACE, "0, 1, zwei"], r"point 1 \(0, 1, zwei\): must be 17 numbers"),
        (
            ["time, x, y, u, v, L_xx, L_xy, L_yx, L_yy", "0,0,0,0,0,1,1,0,0", "1,0,0,0,0,1,1,0,0"],
            "path 0: the gradient has a trace of 0.71 of its size",
        ),
    ],
)
def test_what_is_no_table_of_paths(tmp_path: Path, lines: list[str], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        read_paths(write(tmp_path, *lines))


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(
        ConfigError, match=r"nothing\.csv: cannot be read as a table of paths: no such"
    ):
        read_paths(tmp_path / "nothing.csv")


def test_a_file_that_is_no_table_is_told(tmp_path):
    (tmp_path / "flow.vtu").write_text("<VTKFile>\n" + "A" * 200_000)
    with pytest.raises(ConfigError, match="cannot be read as a table of paths: field larger"):
        read_paths(tmp_path / "flow.vtu")
