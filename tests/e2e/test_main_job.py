"""The main job with real processes: a device on a port, the daemon, a subscriber, a recording."""

import json
import os
import signal
import threading
import time
from collections import defaultdict
from datetime import datetime
from pathlib import Path

import pytest

from gaitway.contracts import WalkPlan
from gaitway.recording.items import Header, LinkChange, RecordedChunk
from gaitway.recording.reader import read
from gaitway.samples import Gap, SampleBatch
from gaitway.testing.pty_port import PtyPort
from gaitway.timebase import NS_PER_S, HostClock

GOLDEN = Path(__file__).parents[1] / "drivers" / "golden"


def of_kind(kind, device=None):
    return lambda event: event["kind"] == kind and (device is None or event["device"] == device)


def link_is(state):
    return lambda event: event["kind"] == "status" and event["link"] == state


def test_two_devices_walk_and_another_process_sees_strides_and_distance(
    gateway, simulate, subscribe, tmp_path, cli
):
    options = ("--distance", "3", "--rest", "5", "--walks", "1")
    truths = {}
    for seed, name in enumerate(("quad-cane", "shank")):
        truths[name] = tmp_path / f"{name}.jsonl"
        link = simulate(name, *options, "--seed", str(seed), "--truth", str(truths[name]))
        gateway.add_device(f"my-{name}", name, link)
    gateway.start()
    events = subscribe(gateway)
    last = {}
    ended = set()
    while len(ended) < 2:
        event = events.wait_for(lambda event: event["kind"] in ("distance", "bout"), 60)
        if event["kind"] == "distance":
            last[event["device"]] = event
        elif event["phase"] == "end":
            ended.add(event["device"])
    assert gateway.stop() < 2.0
    for name, file in truths.items():
        true_m = json.loads(file.read_text().splitlines()[-1])["distance_m"]
        found = last[f"my-{name}"]
        # A short walk of a person it never saw; what is promised on average is tested elsewhere.
        assert abs(found["distance_m"] - true_m) < max(0.1 * true_m, 4 * found["distance_sigma_m"])
    replayed = cli("replay", *gateway.recordings)
    assert replayed.stdout.count("equal to the recorded events") == 2
    assert "held back" not in replayed.stdout
    for name in truths:
        estimated = json.loads(
            cli("estimate", gateway.recordings[0], "--id", f"my-{name}", "--json").stdout
        )
        assert estimated["distance_m"] == last[f"my-{name}"]["distance_m"]


def test_pulling_the_port_costs_a_gap_and_no_step_is_invented(gateway, cane, subscribe):
    device = cane(WalkPlan(distance_m=4.0, seed=2, rest_s=3.0))
    gateway.add_device("cane", "quad-cane", gateway.directory / "ports" / "cane")
    gateway.start()
    events = subscribe(gateway)
    events.wait_for(of_kind("stride"))
    device.unplug()
    lost = events.wait_for(link_is("waiting"))
    assert lost["reason"]
    time.sleep(1.5)  # the person walks on without the cable
    device.plug()
    plugged_s = time.time()
    back = events.wait_for(link_is("streaming"))
    assert datetime.fromisoformat(back["time_utc"]).timestamp() - plugged_s < 5.0
    assert back["reconnects"] == 1
    end = events.wait_for(lambda event: event["kind"] == "bout" and event["phase"] == "end", 60)
    device.thread.join()
    gateway.stop()
    items = [item.body for file in gateway.recordings for item in read(file)]
    gaps = [body for body in items if isinstance(body, Gap)]
    assert sum(gap.n_missing for gap in gaps) >= 140
    assert {gap.reason for gap in gaps} <= {"link-down", "device-restart"}
    assert end["strides"] < len(device.walk.stride_length_m)
    links = [body.state for body in items if isinstance(body, LinkChange)]
    assert links.index("waiting") < len(links) - links[::-1].index("streaming")


def test_kill_9_loses_at_most_the_last_second_and_the_next_start_mends_the_file(
    gateway, cane, subscribe
):
    cane(WalkPlan(distance_m=3.0, seed=3, rest_s=2.0))
    gateway.add_device("cane", "quad-cane", gateway.directory / "ports" / "cane")
    gateway.start()
    subscribe(gateway).wait_for(of_kind("stride"))
    killed_ns = HostClock().now_ns()
    gateway.kill()
    (left,) = gateway.recordings
    assert left.name.endswith(".mcap.active")
    chunks = [i.body.chunk for i in read(left) if isinstance(i.body, RecordedChunk)]
    assert killed_ns - chunks[-1].t_ns < 1.0 * NS_PER_S
    gateway.start()
    until = time.monotonic() + 10
    while left.exists() and time.monotonic() < until:
        time.sleep(0.05)
    gateway.stop()
    mended = left.with_name(left.name.removesuffix(".active"))
    kept = [i.body.chunk for i in read(mended) if isinstance(i.body, RecordedChunk)]
    assert kept == chunks


def test_the_recording_says_what_made_it(gateway, cane, subscribe):
    cane(WalkPlan(distance_m=1.0, rest_s=1.0))
    gateway.add_device("cane", "quad-cane", gateway.directory / "ports" / "cane")
    gateway.start()
    subscribe(gateway).wait_for(link_is("streaming"))
    gateway.stop()
    header = next(i.body for i in read(gateway.recordings[0]) if isinstance(i.body, Header))
    config = json.loads(header.entries["config"])
    assert config["devices"][0]["mounting"] == {"x": "up", "y": "right", "z": "forward"}
    assert config["devices"][0]["driver"]["codec"] == "xbus"
    assert "gaitway" in json.loads(header.entries["plugins"])["quad_cane"]


@pytest.mark.parametrize("split", [None, 1], ids=["as-captured", "byte-by-byte"])
@pytest.mark.parametrize("capture", ["1", "2"])
def test_real_device_bytes_are_taken_as_they_come(gateway, subscribe, capture, split):
    """A real MTi-G-710 (einride/xsens-go, MIT), played at its own pace, set up elsewhere."""
    data = next(GOLDEN.rglob(f"{capture}/output.bin")).read_bytes()
    link = gateway.directory / "ports" / "mti"
    port = PtyPort(link)
    gateway.add_device("mti", "quad-cane", link, listen_only=True)
    gateway.start()
    events = subscribe(gateway)
    events.wait_for(link_is("syncing"))
    step = split or 130
    pace_s = 1.1 / (len(data) / step)
    began = time.monotonic()
    for number, start in enumerate(range(0, len(data), step)):
        port.write(data[start : start + step])
        time.sleep(max(0.0, began + number * pace_s - time.monotonic()))
    stale = events.wait_for(link_is("stale"))
    gateway.stop()
    port.unplug()
    samples = sum(
        len(i.body) for f in gateway.recordings for i in read(f) if isinstance(i.body, SampleBatch)
    )
    assert port.bytes_lost == 0
    assert stale["samples"] == samples
    assert samples > 90
    assert stale["faults"] == {}


def test_the_daemon_is_ready_without_its_devices_and_says_what_is_missing(gateway, subscribe):
    gateway.add_device("cane", "quad-cane", gateway.directory / "nowhere")
    gateway.start()
    status = subscribe(gateway).wait_for(link_is("waiting"))
    assert "nowhere" in status["reason"]
    assert gateway.stop() < 2.0


def test_a_taken_port_of_the_bus_ends_with_status_69_and_the_remedy(gateway, cli):
    gateway.start()
    second = cli("run", gateway.config, check=False)
    assert second.returncode == 69
    assert "is taken" in second.stderr
    assert "Traceback" not in second.stderr


def test_a_wrong_configuration_ends_with_status_78(tmp_path, cli):
    (tmp_path / "gateway.toml").write_text("sit = 'home'\n")
    for command in ("run", "check"):
        done = cli(command, tmp_path / "gateway.toml", check=False)
        assert done.returncode == 78
        assert "did you mean 'site'" in done.stderr


def test_garbage_on_one_port_disturbs_no_other_device(gateway, cane, subscribe):
    noisy = gateway.directory / "ports" / "noisy"
    port = PtyPort(noisy)
    cane(WalkPlan(distance_m=1.5, seed=1, rest_s=2.0))
    gateway.add_device("cane", "quad-cane", gateway.directory / "ports" / "cane")
    gateway.add_device("noisy", "quad-cane", noisy, listen_only=True)
    gateway.start()
    stop = threading.Event()

    def make_noise():
        while not stop.wait(0.01):
            port.write(os.urandom(100))

    noise = threading.Thread(target=make_noise)
    noise.start()
    try:
        by_device = defaultdict(list)
        events = subscribe(gateway)
        while not by_device["cane"]:
            event = events.wait_for(lambda event: True)
            if event["kind"] == "stride":
                by_device[event["device"]].append(event)
            elif event["kind"] == "status" and event["device"] == "noisy":
                assert event["link"] != "streaming"
    finally:
        stop.set()
        noise.join()
    gateway.stop()
    port.unplug()
    assert by_device["noisy"] == []


def test_sigint_stops_it_as_cleanly_as_sigterm(gateway):
    gateway.start()
    gateway.process.send_signal(signal.SIGINT)
    assert gateway.process.wait(5) == 0
    assert not [file for file in gateway.recordings if file.name.endswith(".active")]
