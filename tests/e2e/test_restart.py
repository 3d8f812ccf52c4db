"""The gateway is restarted while somebody walks: nothing is lost, invented or told twice."""

import itertools

import pytest

from gaitway.contracts import WalkPlan
from gaitway.events import Distance, Stride
from gaitway.recording.items import Resumed
from gaitway.recording.reader import read
from gaitway.samples import Gap


def is_stride(number):
    return lambda event: event["kind"] == "distance" and event["strides"] >= number


def is_end(event):
    return event["kind"] == "bout" and event["phase"] == "end"


@pytest.mark.slow
@pytest.mark.parametrize("how", ["kill", "stop"])
def test_a_restart_mid_walk_goes_on_with_the_distance(gateway, cane, subscribe, cli, how):
    device = cane(
        WalkPlan(distance_m=5.0, seed=2, rest_s=4.0)
    )  # rests long enough for a bout to end
    gateway.add_device("cane", "quad-cane", gateway.directory / "ports" / "cane")
    gateway.start()
    subscribe(gateway).wait_for(is_stride(3))
    getattr(gateway, how)()
    down_s = device.elapsed_s
    gateway.start()
    events = subscribe(gateway)
    events.wait_for(lambda event: event["kind"] == "status" and event["link"] == "streaming")
    up_s = device.elapsed_s
    events.wait_for(is_end, 60)
    device.thread.join()
    gateway.stop()

    first, second = (read_run(files) for files in runs_of(gateway))
    assert "goes on from" in gateway.log
    (resumed,) = (body for body in second if isinstance(body, Resumed))
    assert len(resumed.estimator) < 200_000
    told = [of(run, Distance) for run in (first, second)]
    assert told[1][0].since_t_ns == told[0][0].since_t_ns
    distances = [event.distance_m for event in itertools.chain(*told)]
    assert distances == sorted(distances)
    strides = sorted(of(first, Stride) + of(second, Stride), key=lambda stride: stride.t_ns)
    for before, after in itertools.pairwise(strides):
        assert after.start_t_ns >= before.t_ns
    gaps = [body for body in second if isinstance(body, Gap)]
    assert gaps[0].reason == "link-down"
    assert gaps[0].n_missing / 100 == pytest.approx(up_s - down_s, abs=1.2)

    walk = device.walk
    passed = (walk.stride_end_s < up_s) & (walk.stride_start_s > down_s)
    touched = (walk.stride_end_s > down_s - 1.2) & (walk.stride_start_s < up_s + 1.5)
    most = walk.distance_m - walk.stride_length_m[passed].sum()
    least = walk.distance_m - walk.stride_length_m[touched].sum()
    measured_m = sum(stride.stride_length_m for stride in strides if not stride.interpolated)
    assert 0.95 * least < measured_m < 1.05 * most
    assert measured_m <= distances[-1] + 1e-9 < 1.05 * walk.distance_m
    for files in runs_of(gateway):
        assert "equal to the recorded events" in cli("replay", *files).stdout


def runs_of(gateway):
    """Return the files of each run, in order of time."""
    files = sorted(gateway.recordings, key=lambda file: file.stat().st_mtime_ns)
    runs = {}
    for file in files:
        runs.setdefault(file.name.split("-")[1], []).append(file)
    return list(runs.values())


def read_run(files):
    return [item.body for file in files for item in read(file) if item.device == "cane"]


def of(bodies, kind):
    return [body for body in bodies if isinstance(body, kind)]
