"""Every error of a configuration at once, each with file, key and remedy."""

import json
from pathlib import Path

import pytest

from gaitway.config.load import load_config, resolve_recorded
from gaitway.config.schema import GatewayConfig
from gaitway.errors import ConfigError, PluginLoadError
from gaitway.registry import load_registry

CONFIGS = Path(__file__).parents[3] / "configs"

DEVICE = """
[[devices]]
id = "left-cane"
type = "quad-cane"
driver = { transport = "serial", port = "/dev/ttyUSB0", codec = "xbus" }
"""


def load(tmp_path, text, name="gateway.toml"):
    file = tmp_path / name
    file.write_text(text)
    return load_config(file)


def problems(tmp_path, text):
    with pytest.raises(ConfigError) as caught:
        load(tmp_path, text)
    return str(caught.value).splitlines()


def test_a_minimal_device_gets_all_its_defaults(tmp_path):
    (device,) = load(tmp_path, DEVICE).devices
    assert device.mounting == {"x": "up", "y": "right", "z": "forward"}
    assert device.C_db.tolist() == [[0, 0, 1], [0, -1, 0], [1, 0, 0]]
    assert device.transport_params.baud == 115200


def test_the_recording_directory_is_relative_to_the_file(tmp_path):
    loaded = load(tmp_path, '[recording]\ndirectory = "walks"\n')
    assert loaded.gateway.recording.directory == tmp_path / "walks"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            DEVICE.replace('port = "/dev/ttyUSB0"', 'port = "/dev/ttyUSB0", baud = "115200"'),
            'devices.left-cane.driver.baud: expected an integer, got "115200" (remove the quotes)',
        ),
        (
            DEVICE.replace(" port =", " prot ="),
            "devices.left-cane.driver.prot: unknown key (did you mean 'port'?)",
        ),
        (DEVICE.replace("quad-cane", "quadcane"), "(did you mean 'quad-cane'?)"),
        (DEVICE.replace('"xbus"', '"xbuss"'), "driver.codec: 'xbuss' is not installed"),
        (DEVICE.replace(', codec = "xbus"', ""), "devices.left-cane.driver.codec: is missing"),
        (
            DEVICE + 'mounting = { x = "up", y = "left", z = "forward" }\n',
            "mounting: mounting is left-handed",
        ),
        (DEVICE.replace("left-cane", "Left Cane"), "must be lower-case letters"),
        (DEVICE + "params = { no_such = 1 }\n", "devices.left-cane.params.no_such: unknown key"),
        (DEVICE + DEVICE, "devices.left-cane.id: is used twice"),
        (
            DEVICE + DEVICE.replace("left", "right"),
            "devices.right-cane.driver.port: /dev/ttyUSB0 also belongs to left-cane",
        ),
        ('sit = "home"', "sit: unknown key (did you mean 'site'?)"),
        ("[bus]\nlisten = 7447", "bus.listen: expected a list, got 7447"),
        ("[recording]\nmax_age_days = nan", "recording.max_age_days"),
        ('include = ["nowhere.toml"]', "include: no file 'nowhere.toml' beside this one"),
        ('[plugins]\ndisabled = ["wlaker"]', "no plugin is called 'wlaker'"),
        ("[devices]\nid = 1", "devices"),
        ("site = ", "is not valid TOML"),
    ],
)
def test_an_error_names_file_key_and_remedy(tmp_path, text, expected):
    lines = problems(tmp_path, text)
    assert any(expected in line for line in lines), lines
    assert all(line.startswith(str(tmp_path / "gateway.toml")) for line in lines)


def test_all_errors_are_told_at_once(tmp_path):
    text = 'sit = "x"\n[bus]\nlisten = 3\n' + DEVICE.replace("quad-cane", "cane").replace(
        " port", " prot"
    )
    assert len(problems(tmp_path, text)) == 5  # sit, listen, type, prot unknown, port missing


def test_a_missing_file_is_told(tmp_path):
    with pytest.raises(ConfigError, match="no such file"):
        load_config(tmp_path / "none.toml")


def test_devices_of_included_files_are_added_and_their_errors_name_their_file(tmp_path):
    (tmp_path / "devices").mkdir()
    (tmp_path / "devices" / "a.toml").write_text(DEVICE)
    main = 'include = ["devices/*.toml"]\n'
    assert [device.config.id for device in load(tmp_path, main).devices] == ["left-cane"]
    (tmp_path / "devices" / "b.toml").write_text('site = "x"\n' + DEVICE.replace("quad", "qad"))
    lines = problems(tmp_path, main)
    assert any("b.toml: site: an included file holds [[devices]] only" in line for line in lines)
    assert any("b.toml: devices.left-cane.type" in line for line in lines)


def test_a_device_switched_off_may_be_incomplete_in_what_it_names(tmp_path):
    loaded = load(tmp_path, DEVICE.replace("quad-cane", "not-installed") + "enabled = false\n")
    assert loaded.devices == ()


@pytest.mark.parametrize("file", sorted((CONFIGS / "devices").glob("*.toml")), ids=lambda f: f.stem)
def test_each_example_device_is_valid(file):
    assert len(load_config(file).devices) == 1


def test_every_built_in_device_has_an_example_that_names_what_must_be_measured():
    examples = {file.stem: file.read_text() for file in (CONFIGS / "devices").glob("*.toml")}
    devices = load_registry().devices
    assert sorted(examples) == sorted(devices)
    for name, device in devices.items():
        unnamed = [key for key in device.measured if f"{key} = " not in examples[name]]
        assert unnamed == [], name


def test_the_example_gateway_file_lists_every_key_with_its_default(tmp_path):
    loaded = load_config(CONFIGS / "gateway.toml")
    shown = loaded.gateway.model_dump(mode="json")
    default = load(tmp_path, "").gateway.model_dump(mode="json")
    for section in ("recording", "resume"):
        assert shown[section].pop("directory").startswith(str(CONFIGS))
        assert default[section].pop("directory").startswith(str(tmp_path))
    assert shown == default
    text = (CONFIGS / "gateway.toml").read_text()

    def keys(model):
        for name, field in model.model_fields.items():
            yield name
            if hasattr(field.annotation, "model_fields"):
                yield from keys(field.annotation)

    assert [key for key in keys(GatewayConfig) if f"{key}" not in text] == []


def test_a_device_of_a_broken_plugin_is_left_out_and_the_others_run(tmp_path, monkeypatch):
    def with_failure(disabled=()):
        registry = load_registry(disabled)
        del registry.devices["shank"]
        registry.failures["shank"] = PluginLoadError("shank", "ImportError: no such thing")
        return registry

    monkeypatch.setattr("gaitway.config.load.load_registry", with_failure)
    other = DEVICE.replace("left-cane", "leg").replace("quad-cane", "shank").replace("USB0", "USB1")
    loaded = load(tmp_path, DEVICE + other)
    assert [device.config.id for device in loaded.devices] == ["left-cane"]
    assert any("devices.leg.type" in note and "left out" in note for note in loaded.notes)


def test_an_absolute_include_is_taken(tmp_path):
    (tmp_path / "d").mkdir()
    (tmp_path / "d" / "a.toml").write_text(DEVICE)
    assert len(load(tmp_path, f'include = ["{tmp_path}/d/*.toml"]').devices) == 1


def test_under_systemd_recordings_go_to_the_state_directory(tmp_path, monkeypatch):
    monkeypatch.setenv("STATE_DIRECTORY", "/var/lib/gaitway")
    assert load(tmp_path, "").gateway.recording.directory == Path("/var/lib/gaitway/recordings")


def test_a_mounting_by_components_is_loaded_told_and_kept(tmp_path):
    text = "mounting = { x = [0.0, -0.17, 0.985], y = [0, -0.985, -0.17], z = 'forward' }\n"
    loaded = load(tmp_path, DEVICE + text)
    (device,) = loaded.devices
    assert device.C_db[:, 0] == pytest.approx([0.0, -0.17, 0.985], abs=1e-3)
    effective = json.loads(json.dumps(loaded.effective()))
    (recorded,) = resolve_recorded(effective, tmp_path, load_registry())
    assert recorded.C_db.tolist() == device.C_db.tolist()
