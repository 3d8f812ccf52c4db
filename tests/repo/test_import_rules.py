"""Who may import whom: the rooms of the house, held by reading every import."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = ("gateway", "drivers", "plugins")

# room -> rooms of gaitway it may import ("" is the vocabulary at the top of the package)
ROOMS = {
    "": {""},
    "bus": {"", "config"},
    "cli": {
        "",
        "bus",
        "config",
        "estimation",
        "offline",
        "recording",
        "runtime",
        "simulation",
        "testing",
    },
    "config": {"", "recording"},
    "estimation": {""},
    "offline": {"", "recording"},
    "recording": {""},
    "runtime": {"", "bus", "config", "recording"},
    "simulation": {"", "estimation"},
    "testing": {"", "simulation"},
}

# what the two other packages may import of gaitway
OUTSIDE = {
    "gaitway_drivers": {"gaitway.api"},
    "gaitway_plugins": {"gaitway.api", "gaitway.estimation", "gaitway.simulation"},
}

# third-party library -> where it may be imported
OWNERS = {
    "pluggy": {"gaitway.hookspecs", "gaitway.registry"},
    "zenoh": {"gaitway.bus"},
    "mcap": {"gaitway.recording"},
    "orjson": {"gaitway.recording", "gaitway.bus.payload", "gaitway.offline.plain_csv"},
    "serial": {"gaitway_drivers.transports"},
    "pydantic": {
        "gaitway.params",
        "gaitway.events",
        "gaitway.config",
        "gaitway.recording",
        "gaitway_drivers",
        "gaitway_plugins",
    },
    "numpy": {"gaitway", "gaitway_drivers", "gaitway_plugins"},
    "tomlkit": {"gaitway.config.edit"},
    "matplotlib": {"gaitway.cli.calibrate"},
    "time": {"gaitway.timebase"},
    "asyncio": {"gaitway.timebase", "gaitway.runtime", "gaitway_drivers.transports"},
    "threading": {
        "gaitway.bus",
        "gaitway.cli",
        "gaitway.recording",
        "gaitway_drivers.transports",
    },
}
ASYNCIO_ENTRIES = {"gaitway.cli.run", "gaitway.cli.calibrate"}  # hand over to the event loop

FORBIDDEN = {"scipy", "pandas", "numba"}


def modules():
    for source in SOURCES:
        for path in sorted((ROOT / source).rglob("*.py")):
            parts = path.relative_to(ROOT / source).with_suffix("").parts
            name = ".".join(part for part in parts if part != "__init__")
            yield name, path


def imports(name, path):
    """Yield every module a file imports, by absolute name."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name}: relative import; write it absolute"
            assert node.module is not None
            yield node.module


def is_within(module, place):
    return module == place or module.startswith(place + ".")


def room_of(module):
    parts = module.split(".")
    if module == "gaitway.__main__":
        return "cli"
    return parts[1] if len(parts) > 1 and parts[1] in ROOMS else ""


def broken_rules(name, path):
    for imported in imports(name, path):
        top = imported.split(".")[0]
        if top in FORBIDDEN:
            yield f"{name} imports {imported}: too heavy for the daemon"
        owned = any(is_within(name, owner) for owner in OWNERS.get(top, {name}))
        if not owned and not (top == "asyncio" and name in ASYNCIO_ENTRIES):
            yield f"{name} imports {imported}, which belongs to {sorted(OWNERS[top])}"
        if name.split(".")[0] == "gaitway":
            if top in OUTSIDE:
                yield f"{name} imports {imported}: the core knows no device and no driver"
            if top == "gaitway" and room_of(imported) not in ROOMS[room_of(name)] | {room_of(name)}:
                yield f"{name} imports {imported}: not a room it may enter"
        elif top in OUTSIDE and top != name.split(".")[0]:
            yield f"{name} imports {imported}: drivers and plugins don't know each other"
        elif top == "gaitway":
            allowed = OUTSIDE[name.split(".")[0]]
            if not any(is_within(imported, place) for place in allowed):
                yield f"{name} imports {imported}, not public: use {sorted(allowed)}"


@pytest.mark.parametrize(("name", "path"), list(modules()), ids=str)
def test_every_import_stays_within_its_room(name, path):
    assert list(broken_rules(name, path)) == []


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("gaitway.runtime.x", "import gaitway_plugins.shank"),
        ("gaitway.runtime.x", "from gaitway.estimation import WalkLedger"),
        ("gaitway.estimation.x", "import time"),
        ("gaitway.recording.x", "import zenoh"),
        ("gaitway_drivers.x", "from gaitway.samples import Chunk"),
        ("gaitway_plugins.x", "import gaitway_drivers"),
        ("gaitway_plugins.x", "import scipy.signal"),
    ],
)
def test_a_planted_violation_is_found(tmp_path, name, text):
    path = tmp_path / "x.py"
    path.write_text(text)
    assert len(list(broken_rules(name, path))) == 1
