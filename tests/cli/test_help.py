"""The help pages: what a list of commands says is whole, and what they name is there."""

import re

import pytest
from typer.main import get_command
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.cli.common import SHIPPED
from fibermelt.orientation.closures import CLOSURES
from fibermelt.orientation.flows import FLOWS
from fibermelt.orientation.interaction import INTERACTION_LAWS
from fibermelt.orientation.models import MODELS
from fibermelt.parts.melt.cards import material_names
from fibermelt.study.loading import load_study, preset_names

pytestmark = pytest.mark.end_to_end

COMMANDS = sorted(get_command(app).commands)


def told(command):
    """Return what a command's page says of its options, before lines are broken at hyphens."""
    return " ".join(given.help for given in get_command(app).commands[command].params)


def words(text):
    return set(re.findall(r"[\w-]+", text))


def test_the_list_of_commands_cuts_no_sentence():
    done = CliRunner().invoke(app, ["--help"], env={"COLUMNS": "80"})
    assert done.exit_code == 0
    listed = done.stdout.split("Commands:\n")[1].splitlines()
    assert len(listed) == len(COMMANDS)
    assert [line for line in listed if not line.endswith(".") or line.endswith("...")] == []


@pytest.mark.parametrize("command", COMMANDS)
def test_every_option_and_argument_is_explained(command):
    for given in get_command(app).commands[command].params:
        assert given.help, f"{command} {given.name}"
        assert given.help.endswith("."), f"{command} {given.name}"


def test_the_shipped_studies_are_those_that_are_there():
    single, _, sweeps = SHIPPED.partition("; sweeps:")
    assert words(single) | words(sweeps) == set(preset_names())
    assert all(load_study(name).sweep is None for name in words(single))
    assert all(load_study(name).sweep is not None for name in words(sweeps))
    for command in ("run", "validate", "plan", "sweep"):
        assert SHIPPED in told(command)


@pytest.mark.parametrize(
    ("command", "names"),
    [
        ("voids", material_names()),
        ("orientation", [*CLOSURES, *FLOWS, *set(MODELS) - {"jeffery"}, "exact-pdf"]),
        ("domain-size", [*CLOSURES, *INTERACTION_LAWS, "exact-pdf"]),
    ],
)
def test_every_choice_is_named(command, names):
    assert set(names) <= words(told(command))
