"""The wheel holds the three packages and nothing that could collide with anybody's."""

import os
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
KERNELS = f"gaitway/estimation/_kernels{sysconfig.get_config_var('EXT_SUFFIX')}"


def build(directory, target="wheel", **environment):
    """Return the one file that a build makes, and what it printed."""
    done = subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", target, "-d", str(directory)],
        cwd=ROOT,
        env={**os.environ, **environment},
        check=True,
        capture_output=True,
        text=True,
    )
    (built,) = directory.iterdir()
    return built, done.stdout + done.stderr


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    return build(tmp_path_factory.mktemp("wheel"))[0]


def test_the_wheel_has_our_three_packages_at_its_top_and_no_tests(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    tops = {name.split("/")[0] for name in names}
    packages = {top for top in tops if not top.endswith(".dist-info")}
    assert packages == {"gaitway", "gaitway_drivers", "gaitway_plugins"}
    assert {"gaitway/py.typed", "gaitway_drivers/py.typed", "gaitway_plugins/py.typed"} <= set(
        names
    )
    assert any(name.endswith("licenses/LICENSE") for name in names)


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
def test_the_wheel_carries_the_kernels_and_says_for_which_platform(wheel, tmp_path):
    assert zipfile.ZipFile(wheel).namelist().count(KERNELS) == 1
    assert not wheel.name.endswith("none-any.whl")
    assert sysconfig.get_platform().replace("-", "_") in wheel.name
    zipfile.ZipFile(wheel).extractall(tmp_path)
    ask = "from gaitway.estimation import kernels; print(kernels.COMPILED, kernels.__file__)"
    told = subprocess.run(
        [sys.executable, "-c", ask],
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        check=True,
        capture_output=True,
        text=True,
    )
    assert told.stdout.startswith(f"True {tmp_path}")


@pytest.mark.parametrize("compiler", ["false", "no-such-compiler"])
def test_without_a_compiler_the_wheel_is_a_pure_one_and_one_line_says_so(tmp_path, compiler):
    beside = sorted((ROOT / "gateway/gaitway/estimation").glob("*.so"))
    pure, printed = build(tmp_path, CC=compiler)
    assert pure.name.endswith("-py3-none-any.whl")
    assert KERNELS not in zipfile.ZipFile(pure).namelist()
    assert [line for line in printed.splitlines() if "compiled" in line and compiler in line]
    assert sorted((ROOT / "gateway/gaitway/estimation").glob("*.so")) == beside


def test_the_source_distribution_can_build_the_kernels_and_holds_none(tmp_path):
    archive, _ = build(tmp_path, "sdist")
    with tarfile.open(archive) as files:
        names = {name.partition("/")[2] for name in files.getnames()}
    for needed in ("_kernels.c", "_error_state.h", "_kernels.pyi"):
        assert f"gateway/gaitway/estimation/{needed}" in names
    assert "hatch_build.py" in names
    assert not [name for name in names if name.endswith(".so")]
