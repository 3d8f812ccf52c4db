"""Writing found settings into a configuration: nothing else changes, and never a wrong one."""

import pytest

from gaitway.config.edit import write_settings
from gaitway.config.load import load_config
from gaitway.errors import ConfigError

DEVICE = """
[[devices]]           # the cane of the left hand
id = "left"
type = "quad-cane"
driver = { transport = "serial", port = "/dev/left", codec = "xbus" }
"""
MOUNTING = {"x": [0.0, 0.0, 1.0], "y": [0.0, -1.0, 0.0], "z": [1.0, 0.0, 0.0]}


@pytest.fixture
def config(tmp_path):
    def write(text, **included):
        for name, content in included.items():
            (tmp_path / f"{name}.toml").write_text(content)
        file = tmp_path / "gateway.toml"
        file.write_text(text)
        return file

    return write


def only_device(file):
    (device,) = load_config(file).devices
    return device


def test_params_are_added_and_comments_stay(config):
    file = config(f'site = "home"  # here\n{DEVICE}')
    write_settings(file, only_device(file), {"imu_height_m": 0.5}, None)
    assert only_device(file).params.imu_height_m == 0.5
    assert "# here" in file.read_text()
    assert "# the cane of the left hand" in file.read_text()


def test_other_params_stay(config):
    file = config(f"{DEVICE}params = {{ min_stride_m = 0.1, imu_height_m = 0.3 }}\n")
    write_settings(file, only_device(file), {"imu_height_m": 0.5}, None)
    params = only_device(file).params
    assert (params.min_stride_m, params.imu_height_m) == (0.1, 0.5)


def test_a_device_of_an_included_file_is_changed_there(config):
    file = config('include = ["more.toml"]\n', more=DEVICE)
    before = file.read_text()
    write_settings(file, only_device(file), {"imu_height_m": 0.5}, None)
    assert only_device(file).params.imu_height_m == 0.5
    assert file.read_text() == before


def test_what_would_be_wrong_is_not_written(config):
    file = config(DEVICE)
    with pytest.raises(ConfigError, match="imu_height_m"):
        write_settings(file, only_device(file), {"imu_height_m": 9.0}, None)
    assert file.read_text() == DEVICE


def test_a_device_that_was_removed_meanwhile_is_an_error_that_says_so(config):
    file = config(DEVICE)
    device = only_device(file)
    file.write_text("")
    with pytest.raises(ConfigError, match="no device 'left' any more"):
        write_settings(file, device, {"imu_height_m": 0.5}, None)
