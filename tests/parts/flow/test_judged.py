"""What pictures hold pressures against: one meaning for red; hatched, what is not judged."""

import numpy as np
import pytest
import xarray as xr
from drawn_bead import made_up
from matplotlib.collections import TriMesh
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch

from fibermelt.parts.flow.figures.carpet import weave
from fibermelt.parts.flow.figures.judged import held_against, vapor_above_air
from fibermelt.report.kit.scene import MM
from fibermelt.report.kit.style import JUDGED, SEQUENTIAL, UNJUDGED
from fibermelt.report.page.figures import FIGURES
from fibermelt.voids import ATMOSPHERE

ALL = {plate.name: plate for plate in FIGURES}


@pytest.fixture(scope="module")
def bead() -> xr.Dataset:
    return made_up(count=12, points=60)


@pytest.fixture(scope="module")
def without_moisture(bead: xr.Dataset) -> xr.Dataset:
    return bead.drop_vars([name for name in bead.variables if str(name).startswith("void_")])


def painted(figure: Figure) -> list[TriMesh]:
    return [one for axes in figure.axes for one in axes.collections if isinstance(one, TriMesh)]


def hatched(figure: Figure) -> list[PathPatch]:
    """What is hatched over the painted melt of the first panel."""
    return [
        patch
        for patch in figure.axes[0].artists + figure.axes[0].patches
        if isinstance(patch, PathPatch) and patch.get_hatch() and patch.get_zorder() > 1.0
    ]


def test_red_is_below_the_vapor_pressure(bead: xr.Dataset) -> None:
    vapor = vapor_above_air(bead)
    assert vapor == pytest.approx(1e-6 * (float(bead["void_vapor_pressure"]) - ATMOSPHERE))
    against = held_against(bead, np.array([vapor - 0.4, vapor + 0.1]), "pressure")
    assert against.colors == JUDGED
    assert against.zero == vapor
    assert (against.norm.vmin, against.norm.vmax) == (-0.4, 0.4)
    assert against.label == "pressure less the vapor pressure [MPa]"


@pytest.mark.parametrize(
    ("own", "ends"),
    [([-0.35, 1.2], (-0.4, 1.5)), ([0.1, 0.9], (0.0, 1.0)), ([-0.9, -0.1], (-1.0, 0.0))],
)
def test_without_moisture_there_is_no_red(
    without_moisture: xr.Dataset, own: list[float], ends: tuple[float, float]
) -> None:
    assert vapor_above_air(without_moisture) is None
    against = held_against(without_moisture, np.array(own), "pressure")
    assert against.colors == SEQUENTIAL
    assert (against.norm.vmin, against.norm.vmax) == pytest.approx(ends)
    assert against.label == "pressure [MPa], atmosphere = 0"


@pytest.mark.parametrize("name", ["overview", "maps"])
def test_one_study_has_one_meaning_of_red(
    bead: xr.Dataset, without_moisture: xr.Dataset, name: str
) -> None:
    with_red = {one.get_cmap().name for one in painted(ALL[name].draw(bead))}
    assert JUDGED in with_red
    neutral = {one.get_cmap().name for one in painted(ALL[name].draw(without_moisture))}
    assert neutral == {SEQUENTIAL}
    said, unsaid = (ALL[name].words(one).caption for one in (bead, without_moisture))
    assert "red" in said
    assert "vapor" in said
    assert "red" not in unsaid.split()


@pytest.mark.parametrize("name", ["cell", "history", "gradients"])
def test_what_judges_nothing_has_no_red_to_show(bead: xr.Dataset, name: str) -> None:
    maps = {
        one.get_cmap().name
        for axes in ALL[name].draw(bead).axes
        for one in axes.collections
        if one.get_array() is not None
    }
    assert maps
    assert JUDGED not in maps


@pytest.mark.parametrize("name", ["overview", "voids"])
def test_first_and_last_picture_agree(bead: xr.Dataset, name: str) -> None:
    """The worst direction is painted with the same numbers and the same scale in both."""
    other = {"overview": "voids", "voids": "overview"}[name]
    first, second = (painted(ALL[one].draw(bead))[0] for one in (name, other))
    assert first.get_clim() == second.get_clim()
    np.testing.assert_allclose(first.get_array(), second.get_array(), atol=1e-9)


def test_streamlines_left_out_are_hatched_and_no_others(bead: xr.Dataset) -> None:
    near = bead["near_singularity"].to_numpy() > 0
    assert 0 < np.count_nonzero(near) < len(near)
    patches = hatched(ALL["overview"].draw(bead))
    middle = bead.sizes["point"] // 2
    places = MM * np.stack([bead[name].to_numpy()[:, middle] for name in "xy"], axis=-1)
    for row, place in enumerate(places):
        # The outermost lines are the rim of what is woven: a step inwards.
        inside = place + 1e-3 * (places[len(places) // 2] - place)
        covered = any(patch.get_path().contains_point(inside) for patch in patches)
        assert covered == near[row], row


def test_where_all_are_left_out_nothing_is_painted(bead: xr.Dataset) -> None:
    everyone = bead.assign(near_singularity=bead["near_singularity"] * 0 + 1)
    assert weave(everyone) is not None
    assert painted(ALL["overview"].draw(everyone)) == []
    none = bead.assign(near_singularity=bead["near_singularity"] * 0)
    assert hatched(ALL["overview"].draw(none)) == []
    assert painted(ALL["overview"].draw(none))


def test_melt_beyond_the_streamlines_is_not_white_like_harmless(bead: xr.Dataset) -> None:
    figure = ALL["overview"].draw(bead)
    melt = [
        one
        for one in figure.axes[0].get_children()
        if isinstance(one, PathPatch) and one.get_hatch() == UNJUDGED["hatch"]
    ]
    assert min(one.get_zorder() for one in melt) < 1.0
    keys = [axes.get_legend() for axes in figure.axes if axes.get_legend()]
    words = [text.get_text() for key in keys for text in key.get_texts()]
    assert "left out: near sharp corners, and beyond the outermost streamlines" in words
