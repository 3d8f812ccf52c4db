"""One broken plugin costs only itself and is named."""

import sys
from importlib.metadata import EntryPoint

import pytest

from gaitway.registry import GROUP, load_registry

GOOD = """
from gaitway.api import Params, TransportType, hookimpl

@hookimpl
def gaitway_transports():
    return [TransportType("fog", "Bytes through fog", Params, lambda params, clock: None)]
"""


@pytest.fixture
def plugin(tmp_path, monkeypatch):
    """Write a module and return an entry point to it."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def write(name, text):
        (tmp_path / f"{name}.py").write_text(text)
        sys.modules.pop(name, None)
        return EntryPoint(name=name, value=name, group=GROUP)

    return write


def test_a_sound_plugin_is_taken(plugin):
    registry = load_registry(found=[plugin("good", GOOD)])
    assert list(registry.transports) == ["fog"]
    assert registry.failures == {}


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("import no_such_module_here", "No module named 'no_such_module_here'"),
        ("raise SystemExit(3)", "SystemExit: 3"),
        (GOOD.replace("gaitway_transports", "gaitway_transport"), "unknown hook"),
        (GOOD.replace("return [", "return {'x': ").replace("None)]", "None)}"), "returned dict"),
        (GOOD.replace("return [", "return [3, "), "offered int where TransportType"),
        ("nothing = 1", "offers nothing"),
    ],
    ids=["import", "exit", "misspelt", "not-a-list", "wrong-type", "empty"],
)
def test_a_broken_plugin_costs_only_itself_and_says_why(plugin, text, reason):
    registry = load_registry(found=[plugin("bad", text), plugin("good", GOOD)])
    assert list(registry.transports) == ["fog"]
    assert reason in str(registry.failures["bad"])


def test_two_plugins_offering_one_name_are_told_apart(plugin):
    registry = load_registry(found=[plugin("a_first", GOOD), plugin("b_second", GOOD)])
    assert list(registry.loaded) == ["a_first"]
    assert "'fog', which is taken" in str(registry.failures["b_second"])


def test_a_disabled_plugin_is_not_even_imported(plugin):
    registry = load_registry(["bad"], found=[plugin("bad", "raise RuntimeError")])
    assert registry.failures == {}
    assert registry.disabled_found == ("bad",)


DEVICE = """
from gaitway.api import DeviceType, Params, hookimpl

class PoleParams(Params):
    length_m: float = 1.0

@hookimpl
def gaitway_devices():
    return [DeviceType("pole", "", (), PoleParams, None, measured=("lenth_m",))]
"""


def test_a_measured_parameter_that_there_is_none_of_is_told(plugin):
    registry = load_registry(found=[plugin("pole", DEVICE)])
    assert "pole: measured names ['lenth_m']" in str(registry.failures["pole"])
    registry = load_registry(found=[plugin("pole", DEVICE.replace("lenth", "length"))])
    assert list(registry.devices) == ["pole"]
    assert registry.device_origins == {"pole": "pole of unknown"}
