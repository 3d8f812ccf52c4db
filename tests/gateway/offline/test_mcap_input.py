import numpy as np
import orjson
import pytest

from gaitway.errors import InputDataError
from gaitway.offline.mcap_input import read_mcap
from gaitway.recording.lane import LaneItem
from gaitway.recording.params import RecordingParams
from gaitway.recording.sink import Sink
from gaitway.samples import ACCEL, FORCE, GYRO, Gap, SampleBatch
from gaitway.testing.clocks import ManualClock

CONFIG = {
    "site": "home",
    "devices": [
        {
            "id": "left",
            "type": "quad-cane",
            "mounting": {"x": "up", "y": "right", "z": "forward"},
            "params": {"stance_hold_s": 0.12},
        },
        {"id": "right", "type": "shank", "mounting": None, "params": {}},
    ],
}
PERIOD_NS = 10_000_000


def batch(sequence, n=2, channels=("accel", "gyro")):
    rng = np.random.default_rng(sequence)
    t_ns = 10**12 + (np.arange(n) + sequence) * PERIOD_NS
    return SampleBatch(t_ns, 0.01, sequence, {name: rng.normal(size=(n, 3)) for name in channels})


@pytest.fixture
def record(tmp_path):
    """Returns a function that records items, given as (device, body), and returns the file."""

    def write(*items, config=CONFIG):
        sink = Sink(
            RecordingParams(directory=tmp_path, min_free_gb=0.0),
            ManualClock(),
            run="cafe",
            header={"config": orjson.dumps(config).decode(), "run": "cafe"},
            devices=["left", "right"],
            lose=lambda *_: None,
        )
        assert sink.ready()
        for device, body in items:
            sink.write([LaneItem(device, body)])
        sink.finish([])
        (path,) = tmp_path.glob("*.mcap")
        return path

    return write


def refusal(path, device=None):
    with pytest.raises(InputDataError) as caught:
        read_mcap(path, device)
    return str(caught.value)


def shape(recording):
    return [
        ("gap", item.n_missing, item.t_ns)
        if isinstance(item, Gap)
        else ("samples", item.sequence, len(item))
        for item in recording.items
    ]


def test_samples_come_back_bit_for_bit(record):
    batches = [batch(0), batch(2), batch(4, n=7)]
    recording = read_mcap(record(*[("left", item) for item in batches]))
    for name in ("accel", "gyro"):
        found = np.concatenate([item.channels[name] for item in recording.batches])
        assert np.array_equal(found, np.concatenate([item.channels[name] for item in batches]))
    assert (recording.period_s, recording.samples, recording.samples_lost) == (0.01, 11, 0)
    assert recording.duration_s == pytest.approx(0.1)
    assert recording.channels == {"accel", "gyro"}


def test_what_the_file_says_of_the_device_comes_along(record):
    recording = read_mcap(record(("left", batch(0))))
    assert (recording.device, recording.device_type) == ("left", "quad-cane")
    assert recording.mounting == {"x": "up", "y": "right", "z": "forward"}
    assert recording.params == {"stance_hold_s": 0.12}


@pytest.mark.parametrize("config", [{}, {"devices": []}, []])
def test_a_file_without_configuration_is_still_a_walk(record, config):
    recording = read_mcap(record(("left", batch(0)), config=config))
    assert (recording.device, recording.device_type, recording.mounting) == ("left", None, None)
    assert recording.params == {}


def test_the_device_is_chosen_by_id(record):
    path = record(("left", batch(0)), ("right", batch(6)), ("left", batch(2)))
    assert shape(read_mcap(path, "right")) == [("samples", 6, 2)]
    assert read_mcap(path, "left").samples == 4


def test_several_devices_and_no_id_are_refused_with_their_names(record):
    path = record(("left", batch(0)), ("right", batch(0)))
    assert refusal(path) == (f"{path}: holds samples of left, right (say which with --id left)")


def test_a_device_that_is_not_in_it_is_refused(record):
    path = record(("left", batch(0)))
    assert refusal(path, "walker") == f"{path}: holds no samples of 'walker', only of left"


def test_a_recorded_gap_stays_and_only_those_between_samples(record):
    lost = Gap(10**12 + 2 * PERIOD_NS, 3, "link-down")
    path = record(
        ("left", Gap(1, 9, "lost")), ("left", batch(0)), ("left", lost), ("left", batch(5)),
        ("left", Gap(10**12 + 7 * PERIOD_NS, 4, "lost")),
    )  # fmt: skip
    recording = read_mcap(path)
    assert shape(recording) == [
        ("samples", 0, 2),
        ("gap", 3, 10**12 + 2 * PERIOD_NS),
        ("samples", 5, 2),
    ]
    assert recording.items[1].reason == "link-down"


def test_samples_that_were_never_recorded_are_a_gap(record):
    path = record(("left", batch(0)), ("left", batch(12)))
    assert shape(read_mcap(path)) == [
        ("samples", 0, 2),
        ("gap", 10, 10**12 + 2 * PERIOD_NS),
        ("samples", 12, 2),
    ]


def test_a_grid_that_begins_anew_is_a_gap_by_time(record):
    later = batch(0)
    later = SampleBatch(later.t_ns + 50 * PERIOD_NS, 0.01, 0, later.channels)
    path = record(("left", batch(0)), ("left", later))
    assert shape(read_mcap(path)) == [
        ("samples", 0, 2),
        ("gap", 48, 10**12 + 2 * PERIOD_NS),
        ("samples", 0, 2),
    ]


def test_only_the_channels_that_every_batch_holds_are_counted_on(record):
    path = record(("left", batch(0)), ("left", batch(2, channels=("accel",))))
    assert read_mcap(path).channels == {"accel"}


def test_a_cut_off_file_is_read_and_the_loss_noted(record):
    path = record(*[("left", batch(2 * number)) for number in range(100)])
    path.write_bytes(path.read_bytes()[:-16000])
    recording = read_mcap(path)
    assert recording.samples == 200
    (note,) = recording.notes
    assert "can't be read: cut off within a record" in note


@pytest.mark.parametrize("content", [b"", b"t_s,accel_x_mps2\n0,1\n"])
def test_a_file_that_is_no_recording_is_refused_with_the_reason(tmp_path, content):
    path = tmp_path / "walk.mcap"
    path.write_bytes(content)
    assert "holds no samples of any device (" in refusal(path)
    assert "no MCAP file" in refusal(path)


def test_a_recording_without_samples_is_refused(record):
    path = record(("left", Gap(1, 1, "lost")))
    assert refusal(path) == f"{path}: holds no samples of any device"


def test_a_file_that_is_not_there_is_refused(tmp_path):
    assert "No such file" in refusal(tmp_path / "none.mcap")


def test_a_missing_channel_is_told_with_what_is_there(record):
    recording = read_mcap(record(("left", batch(0))))
    recording.require((ACCEL, GYRO))
    with pytest.raises(InputDataError, match=r"holds no channel force.*it holds: accel, gyro"):
        recording.require((ACCEL, FORCE))
