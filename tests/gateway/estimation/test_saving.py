"""States of estimators: everything comes back, and nothing else gets in."""

import pickle
import zlib
from collections import deque

import numpy as np
import pytest

from gaitway.contracts import WalkPlan
from gaitway.estimation import ErrorStateFilter, ImuNoise, Saveable
from gaitway.mounting import mount, rotation_from_mounting
from gaitway.registry import load_registry
from gaitway.samples import SampleBatch

RUN = []
NOISE = ImuNoise(accel_mps2_rthz=1e-3, gyro_radps_rthz=1e-4)


class Counter(Saveable):
    def __init__(self):
        self.total = 0.0
        self.recent = deque([1, 2], maxlen=3)
        self.rows = np.arange(6.0).reshape(2, 3)
        self.noise = NOISE


class Other(Counter):
    pass


class Runs:
    """What a malicious pickle holds: code that runs as soon as it is read."""

    def __init__(self, function, *arguments):
        self.call = (function, arguments)

    def __reduce__(self):
        return self.call


def state_of(attributes, kind=Counter):
    """Return a state with a good checksum around anything."""
    return raw_state(pickle.dumps(attributes, protocol=5), kind)


def raw_state(body, kind=Counter):
    name = f"{kind.__module__}.{kind.__qualname__}".encode()
    return b"gaitway-state-1 %s %08x\n" % (name, zlib.crc32(body)) + body


def named(module, name):
    """Return a pickle that looks up a global and keeps it."""
    return b"\x80\x04}\x8c\x01x" + b"".join(
        b"\x8c" + bytes([len(text)]) + text.encode() for text in (module, name)
    ) + b"\x93s."  # fmt: skip


def test_everything_comes_back():
    before, after = Counter(), Counter()
    before.total = 0.1 + 0.2
    before.recent.append(7)
    before.rows[1, 2] = np.nan
    after.restore(before.save())
    assert after.total == before.total
    assert (after.recent, after.recent.maxlen) == (before.recent, 3)
    assert np.array_equal(after.rows, before.rows, equal_nan=True)
    assert after.noise == before.noise


def test_two_that_were_restored_share_nothing():
    state = Counter().save()
    first, second = Counter(), Counter()
    first.restore(state)
    second.restore(state)
    first.recent.append(9)
    assert list(second.recent) == [1, 2]


@pytest.mark.parametrize("at", [0, 20, 60, -1])
def test_a_damaged_state_is_refused_with_nothing_changed(at):
    state = bytearray(Counter().save())
    state[at] ^= 1
    refused(bytes(state), "no undamaged state")


@pytest.mark.parametrize("keep", [0, 1, 50, -1])
def test_a_state_cut_off_is_refused(keep):
    refused(Counter().save()[:keep], "no undamaged state")


def test_a_state_of_another_class_is_refused():
    refused(Other().save(), "no undamaged state")


@pytest.mark.parametrize(
    "attributes",
    [
        {"x": Runs(RUN.append, 1)},
        {"x": Runs(exec, "raise SystemExit")},
        {"x": Runs(getattr, [], "append")},
        {"x": Runs(__import__, "antigravity")},
    ],
    ids=["method", "exec", "getattr", "import"],
)
def test_code_is_refused_before_it_runs(attributes):
    refused(state_of(attributes), "can't be read")
    assert RUN == []


@pytest.mark.parametrize(
    ("module", "name"),
    [
        ("os", "system"),
        ("antigravity", "geohash"),
        ("gaitway.cli.demo", "subprocess.Popen"),  # a class, but by way of a module of ours
        ("gaitway.contracts", "Protocol"),
        ("gaitway.samples", "np.memmap"),
        ("gaitway.estimation.saving", "io.FileIO"),
        ("gaitway.recording.recording_file", "RecordingFile"),  # making one writes a file
        ("gaitway.testing.pty_port", "PtyPort"),
        ("gaitway_plugins.quad_cane.estimator", "QuadCaneEstimator"),  # another's package
        ("gaitwayx.estimation", "Evil"),
    ],
)
def test_what_is_no_class_of_its_own_place_is_refused(module, name):
    refused(raw_state(named(module, name)), "can't be read")


@pytest.mark.parametrize("body", [b"", b".", b"\x80\x05N.", b"\x80\x05K\x01.", b"\x80\xff."])
def test_what_is_no_state_in_a_good_envelope_is_refused(body):
    refused(raw_state(body), "can't be read")


def refused(state, why):
    counter = Counter()
    before = dict(vars(counter))
    with pytest.raises(ValueError, match=why):
        counter.restore(state)
    assert vars(counter) == before


class Navigator(Saveable):
    def __init__(self):
        self.filter = ErrorStateFilter()

    def step(self):
        self.filter.predict((0.1, 0.0, 9.8), (0.1, 0.2, 0.3), 0.01, NOISE)


def test_a_filter_goes_on_to_the_last_bit():
    original, twin = Navigator(), Navigator()
    for _ in range(20):
        original.step()
    twin.restore(original.save())
    for _ in range(20):
        original.step()
        twin.step()
    assert np.array_equal(original.filter.nominal, twin.filter.nominal)
    assert np.array_equal(original.filter.covariance, twin.filter.covariance)


@pytest.mark.parametrize("name", sorted(load_registry().devices))
def test_every_installed_device_goes_on_mid_walk_as_if_nothing_had_been(name):
    device = load_registry().devices[name]
    if device.simulate is None:
        pytest.skip("has no simulation")
    walk = device.simulate(WalkPlan(distance_m=5.0, rest_s=2.0))
    n = len(walk.pos_n)
    t_ns = np.arange(n) * 10_000_000
    C_db = rotation_from_mounting(device.default_mounting)
    batch = mount(SampleBatch(t_ns, 0.01, 0, walk.channels), C_db)
    params = device.params.model_validate({})
    whole, before, after = (device.make_estimator(params, C_db) for _ in range(3))
    half = n // 2
    expected = [*whole.update(batch[:half]), *whole.update(batch[half:]), *whole.finish()]
    first = before.update(batch[:half])
    after.restore(before.save())
    assert [*first, *after.update(batch[half:]), *after.finish()] == expected
    assert len(expected) > len(first) > 0
