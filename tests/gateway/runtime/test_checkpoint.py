"""The state file: taken only by the same device, configuration and boot, and not for long."""

import pytest

from gaitway.config.load import load_config
from gaitway.runtime.checkpoint import Checkpoint, checkpoint_for
from gaitway.timebase import NS_PER_S

IDENTITY = {"type": "cane", "params": {"length_m": 0.9}, "boot": "a"}
ALIGNER = {"sequence": 7}


def checkpoint(path, within_s=600.0, **changes):
    return Checkpoint("left", path / "deep" / "left.state", IDENTITY | changes, within_s)


def test_what_is_written_is_read(tmp_path):
    checkpoint(tmp_path).write(5, ALIGNER, b"state\nof bytes")
    state = checkpoint(tmp_path).load(9)
    assert (state.t_ns, state.saved_t_ns) == (9, 5)
    assert (state.aligner, state.estimator) == (ALIGNER, b"state\nof bytes")


def test_the_first_start_says_nothing(tmp_path, caplog):
    with caplog.at_level("INFO"):
        assert checkpoint(tmp_path).load(9) is None
    assert caplog.records == []


@pytest.mark.parametrize(
    ("changes", "now_s", "why"),
    [
        ({"boot": "b"}, 1, "saved with another boot"),
        ({"type": "shank", "plugin": "x"}, 1, "saved with another type, plugin"),
        ({"type": "shank", "params": {}}, 1, "saved with another type"),
        ({}, -1, "saved in the future"),
    ],
)
def test_a_state_of_another_device_or_boot_is_not_taken(tmp_path, caplog, changes, now_s, why):
    checkpoint(tmp_path).write(0, ALIGNER, b"x")
    with caplog.at_level("INFO"):
        assert checkpoint(tmp_path, **changes).load(now_s * NS_PER_S) is None
    (record,) = caplog.records
    assert why in record.message


@pytest.mark.parametrize(
    ("changes", "now_s", "why"),
    [
        ({"params": {"length_m": 1.0}}, 1, "saved with another params"),
        ({}, 601, "it is 601 s old (resume.within_s = 600)"),
        ({}, 600, ""),
    ],
)
def test_an_old_state_or_one_of_other_settings_is_ended(tmp_path, caplog, changes, now_s, why):
    checkpoint(tmp_path).write(0, ALIGNER, b"x")
    with caplog.at_level("INFO"):
        assert checkpoint(tmp_path, **changes).load(now_s * NS_PER_S).ended == why
    (record,) = caplog.records
    assert why in record.message


@pytest.mark.parametrize(
    "content", [b"", b"{}", b"[]\n", b"\xff", b'{"estimator_bytes": 3}\nab', b'{"identity": 1}\n']
)
def test_a_damaged_file_is_not_taken_and_disturbs_nothing(tmp_path, caplog, content):
    checkpoint(tmp_path).write(0, ALIGNER, b"x")
    (tmp_path / "deep" / "left.state").write_bytes(content)
    with caplog.at_level("INFO"):
        assert checkpoint(tmp_path).load(1) is None
    assert "damaged" in caplog.text


def test_a_file_cut_off_anywhere_is_not_taken(tmp_path):
    checkpoint(tmp_path).write(0, ALIGNER, b"state")
    file = tmp_path / "deep" / "left.state"
    whole = file.read_bytes()
    for length in range(len(whole)):
        file.write_bytes(whole[:length])
        assert checkpoint(tmp_path).load(1) is None


def test_a_cleared_state_is_gone_and_clearing_twice_is_fine(tmp_path):
    made = checkpoint(tmp_path)
    made.write(0, ALIGNER, b"x")
    made.clear()
    made.clear()
    assert made.load(1) is None


DEVICE = """
[[devices]]
id = "left"
type = "quad-cane"
driver = { transport = "serial", port = "/dev/x", codec = "xbus" }
"""


def loaded(tmp_path, text=""):
    (tmp_path / "gateway.toml").write_text(text + DEVICE)
    return load_config(tmp_path / "gateway.toml")


def test_states_are_in_systemd_s_runtime_directory_and_know_the_boot_it_names(
    tmp_path, monkeypatch
):
    monkeypatch.setenv("RUNTIME_DIRECTORY", str(tmp_path / "run"))
    monkeypatch.setenv("GAITWAY_BOOT_ID", "abc")
    config = loaded(tmp_path)
    made = checkpoint_for(config.devices[0], config)
    made.write(0, ALIGNER, b"x")
    assert (tmp_path / "run" / "state" / "left.state").exists()
    monkeypatch.setenv("GAITWAY_BOOT_ID", "def")
    assert checkpoint_for(config.devices[0], config).load(1) is None


def test_a_host_that_can_t_tell_its_boots_apart_keeps_no_state(tmp_path, monkeypatch):
    monkeypatch.setattr("gaitway.runtime.checkpoint.BOOT_ID", tmp_path / "none")
    monkeypatch.delenv("GAITWAY_BOOT_ID", raising=False)
    config = loaded(tmp_path)
    assert checkpoint_for(config.devices[0], config) is None


def test_within_zero_seconds_no_state_is_kept(tmp_path):
    config = loaded(tmp_path, "resume = { within_s = 0 }\n")
    assert checkpoint_for(config.devices[0], config) is None
