import subprocess
import sys

import numpy as np
import pytest
from pydantic import ValidationError

from gaitway.api import ACCEL, GYRO
from gaitway_plugins.quad_cane.params import QuadCaneParams


def test_the_device_is_declared_as_documented(device):
    assert device.name == "quad-cane"
    assert device.requires == (ACCEL, GYRO)
    assert device.default_mounting == {"x": "up", "y": "right", "z": "forward"}
    assert device.make_estimator(device.params(), np.eye(3)).look_ahead_s == pytest.approx(1.075)


def test_declaring_it_loads_neither_numbers_nor_the_simulation():
    """What a plugin costs at the start of the gateway, whether it is used or not."""
    code = (
        "import sys, gaitway_plugins.quad_cane as plugin; plugin.gaitway_devices();"
        "loaded = [name for name in sys.modules if 'quad_cane.' in name];"
        "print(*sorted(loaded))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.split() == ["gaitway_plugins.quad_cane.params"]


def test_windows_that_do_not_fit_are_refused():
    with pytest.raises(ValidationError, match="walking_window_s"):
        QuadCaneParams(walking_window_s=0.2)


@pytest.mark.parametrize("name", list(QuadCaneParams.model_fields))
def test_every_parameter_is_documented(name):
    assert QuadCaneParams.model_fields[name].description
