"""Bubbles at the tips of a bead's fibers: their number, what they see, the content by hand."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from drawn_bead import made_up

from fibermelt.parts.melt.cards import load_card
from fibermelt.parts.voids.bubbles import Nuclei, nuclei_of
from fibermelt.parts.voids.melt import moist_melt
from fibermelt.parts.voids.part import NUCLEI
from fibermelt.parts.voids.stages import assess_bead
from fibermelt.parts.voids.summary import BESIDE, summarize_voids
from fibermelt.study.chain import CHAIN
from fibermelt.study.config import Config
from fibermelt.voids import ATMOSPHERE, BubbleMelt, Surroundings, Tip, grow

MU = 817.0
SPHERES = Nuclei(1e-6, 1.0, 0.5, 42e-6, 7e-6, 7e-6, 0.08, in_space=False)


@cache
def flow():
    """Two streamlines of a made-up bead with three initial angles, without voids."""
    made = made_up(count=2, angles=3, points=60)
    made = made.drop_vars([name for name in made if name.startswith("void_")])
    made = made.drop_dims(["void_basis", "void_selection", "void_layer"], errors="ignore")
    made["near_singularity"][:] = 0
    return made


def assessed(moisture=0.0005, nuclei=SPHERES, card="paper", viscosity=MU, results=None):
    results = flow() if results is None else results
    melt = moist_melt(load_card(card), moisture=moisture, temperature=503.15)
    stages = dict.fromkeys(("streamlines", "cell", "motion"), results)
    found = assess_bead(stages, viscosity, melt, 2, nuclei)
    return found.assign({name: results[name] for name in BESIDE})


def test_two_tips_a_fiber() -> None:
    """8 % of spheroids 84 um long and 14 um wide, one tip in four with a nucleus."""
    fiber = 4 / 3 * math.pi * 42e-6 * 7e-6**2
    per_volume = 0.08 / fiber
    assert SPHERES.volume == pytest.approx(1 / (2 * per_volume), rel=1e-12)
    assert replace(SPHERES, share=0.25).volume == pytest.approx(4 * SPHERES.volume, rel=1e-12)


def test_the_content_is_that_of_the_radii() -> None:
    found = assessed()
    gas = 4 / 3 * math.pi * found["void_radius"].to_numpy() ** 3 / SPHERES.volume
    for k, station in enumerate(("swell", "bed")):
        mean = gas[..., k].mean()  # over two streamlines that carry the same, and three angles
        told = found["void_bead_content"].sel(void_selection="regular", void_station=station)
        assert float(told) == pytest.approx(mean / (1 + mean), rel=1e-12)
    layers = found["void_layer_content"].sel(void_selection="regular", void_station="swell")
    each = gas[..., 0].mean(axis=1)
    assert sorted(layers.to_numpy()) == pytest.approx(sorted(each / (1 + each)), rel=1e-12)
    assert float(found["void_fraction"]) == pytest.approx(
        float(found["void_fraction_tips"] + found["void_fraction_rest"]), rel=1e-12
    )


def test_a_nucleus_sees_its_fiber_up_to_zone_3_then_the_melt_then_the_air() -> None:
    """The middle angle of a streamline, by hand."""
    lines = flow().isel(streamline=0)
    found = assessed().isel(streamline=0)
    t, p = lines["time"].to_numpy(), lines["pressure"].to_numpy()
    swell = float(lines["zone_time"][-1])
    added = np.where(t <= swell, lines["lowest"].isel(initial_angle=1).to_numpy(), 0.0)
    w, vapor = 0.0005, float(found["void_vapor_pressure"])
    card = load_card("paper").melt
    melt = BubbleMelt(
        vapor,
        1154.0 * 0.87 * w / vapor / 0.92,
        card.diffusivity(503.15),
        card.tension(503.15),
        503.15,
    )
    around = Surroundings(
        np.append(t, t[-1] + (t[-1] - t[-2])),
        np.append(p, 0.0) + ATMOSPHERE,
        MU,
        fiber_pressure=np.append(added, 0.0),
        tip=Tip(42e-6, 7e-6, in_space=False),
    )
    alone = grow(around, melt, 1e-6, 0.92 * SPHERES.volume, [swell, swell + 0.5])
    assert found["void_radius"].isel(initial_angle=1).to_numpy() == pytest.approx(
        alone.at_stations("radius"), rel=1e-9
    )
    assert found["void_radius_along"].isel(initial_angle=1).to_numpy() == pytest.approx(
        alone.radius, rel=1e-9
    )
    bare = grow(
        replace(around, fiber_pressure=0.0), melt, 1e-6, 0.92 * SPHERES.volume, [swell, swell + 0.5]
    )
    assert found["void_radius_rest"].to_numpy() == pytest.approx(
        bare.at_stations("radius"), rel=1e-9
    )


def test_a_path_without_zones_is_followed_to_its_end() -> None:
    zones = flow()["zone_time"].to_numpy().copy()
    late = flow().copy(deep=True)
    late["zone_time"][:, -1] = late["time"][:, -1]
    without = assessed(results=flow().drop_vars("zone_time"))
    assert without["void_radius"].to_numpy() == pytest.approx(
        assessed(results=late)["void_radius"].to_numpy(), rel=1e-12
    )
    assert np.all(zones[:, -1] < flow()["time"].to_numpy()[:, -1])


def test_summary_has_the_content_and_its_parts() -> None:
    voids = summarize_voids(assessed())["voids"]
    for told in (voids, *voids["profile"]):
        for name in ("void_fraction", "void_fraction_on_bed"):
            content = told[name]
            assert set(content) == {"bead", "tips", "rest"}
            assert content["bead"] == pytest.approx(content["tips"] + content["rest"], rel=1e-12)
    assert all(0.0 < line["void_fraction"] < 1.0 for line in voids["streamlines"])
    # The drawn fibers' pressure is far below the melt's: they add to it.
    assert voids["void_fraction"]["tips"] > 0.0


def test_more_moisture_more_gas_and_none_where_the_vapor_is_below_every_pressure() -> None:
    contents = [float(assessed(w)["void_fraction"]) for w in (1e-4, 4e-4, 1.6e-3)]
    assert contents == sorted(contents)
    still = flow().copy(deep=True)
    still["lowest"][:] = 0.0
    found = assessed(1e-5, results=still)
    assert found["void_radius"].to_numpy() == pytest.approx(np.full((2, 3, 2), 1e-6), rel=1e-12)


@pytest.mark.parametrize("nuclei", [None, SPHERES])
def test_what_a_card_lacks_leaves_growth_out_and_is_named(nuclei) -> None:
    card = load_card("paper")
    bare = replace(card, melt=replace(card.melt, diffusion=None))
    stages = dict.fromkeys(("streamlines", "cell", "motion"), flow())
    melt = moist_melt(bare, moisture=0.0005, temperature=503.15)
    found = assess_bead(stages, MU, melt, 2, nuclei)
    voids = summarize_voids(found.assign({name: flow()[name] for name in BESIDE}))["voids"]
    assert voids["void_fraction"] == {"bead": None, "tips": None, "rest": None}
    assert voids["severity"]["fibers"] > 0.0
    assert any("no growth of bubbles" in line for line in voids["material"]["missing"])


def test_nuclei_are_those_of_the_study_and_the_stage_reads_no_more() -> None:
    study = Config()
    values = study.values()
    stage = next(stage for stage in CHAIN.stages if stage.name == "voids")
    read = {key: values[key] for key in (*NUCLEI, *(k for k in values if k.startswith("voids.")))}
    assert set(NUCLEI) <= set(stage.parameters)
    found = nuclei_of(read)
    assert found.half_width == pytest.approx(7e-6)
    assert found.half_thickness == found.half_width
    assert (found.radius, found.share, found.bed_time) == (1e-6, 1.0, 1.0)
    assert found.content == 0.084
    assert not found.in_space
