"""Built-in plugins come in through the same door as a stranger's."""

import tomllib
from importlib.metadata import entry_points
from pathlib import Path

from gaitway.registry import GROUP, load_registry

ROOT = Path(__file__).parents[2]


def test_the_installed_entry_points_are_those_of_pyproject():
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]
    installed = {
        ep.name: ep.value
        for ep in entry_points(group=GROUP)
        if ep.dist is not None and ep.dist.name == "gaitway"
    }
    assert installed == declared[GROUP], "run: make install"


def test_every_built_in_plugin_loads():
    assert load_registry().failures == {}
