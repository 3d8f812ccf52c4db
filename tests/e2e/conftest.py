"""Running the real commands as a person would: processes, ports, a bus, files."""

import json
import os
import queue
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from gaitway.bus.subscriber import open_client
from gaitway.testing.simulated_device import SimulatedDevice
from gaitway.timebase import HostClock
from gaitway_drivers import gaitway_codecs
from gaitway_plugins.quad_cane.simulation import simulate as simulate_cane

READY_S = 20


class Gateway:
    """A daemon in a directory of its own, with a config written from devices."""

    def __init__(self, directory: Path):
        self.directory = directory
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.endpoint = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
        self.config = directory / "gateway.toml"
        self.process = None
        self.ready_after_s = None
        self._lines = [
            'site = "test"',
            f'bus = {{ listen = ["{self.endpoint}"] }}',
            "recording = { directory = 'recordings', min_free_gb = 0.01 }",
        ]

    def set(self, line):
        self._lines.insert(0, line)

    def add_device(self, name, type_, port, **driver):
        keys = {"transport": "serial", "port": str(port), "codec": "xbus", **driver}
        inner = ", ".join(f"{key} = {json.dumps(value)}" for key, value in keys.items())
        self._lines += [
            "[[devices]]",
            f'id = "{name}"',
            f'type = "{type_}"',
            f"driver = {{ {inner} }}",
        ]

    def start(self):
        self.config.write_text("\n".join(self._lines) + "\n")
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notify:
            address = str(self.directory / "notify")
            Path(address).unlink(missing_ok=True)
            notify.bind(address)
            notify.settimeout(READY_S)
            log = (self.directory / "gaitway.log").open("a")
            began = time.monotonic()
            self.process = subprocess.Popen(
                [sys.executable, "-m", "gaitway", "run", str(self.config)],
                env=os.environ | {"NOTIFY_SOCKET": address},
                stdout=log,
                stderr=log,
            )
            log.close()
            assert notify.recv(100) == b"READY=1", self.log
            self.ready_after_s = time.monotonic() - began
        return self

    def stop(self):
        """SIGTERM; return how long it took, in seconds."""
        began = time.monotonic()
        self.process.terminate()
        assert self.process.wait(20) == 0, self.log
        return time.monotonic() - began

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    @property
    def log(self):
        return (self.directory / "gaitway.log").read_text()

    @property
    def recordings(self):
        return sorted((self.directory / "recordings").glob("*.mcap*"))


class Events(queue.Queue):
    """What a subscriber in another session got."""

    def wait_for(self, condition, timeout_s=30):
        """Return the first event that satisfies the condition, and leave the later ones."""
        until = time.monotonic() + timeout_s
        seen = []
        while (left := until - time.monotonic()) > 0:
            try:
                event = self.get(timeout=left)
            except queue.Empty:
                break
            seen.append(event)
            if condition(event):
                return event
        raise AssertionError(f"it did not come; what came: {seen[-8:]}")

    def drain(self):
        events = []
        while not self.empty():
            events.append(self.get())
        return events


@pytest.fixture
def gateway(tmp_path):
    made = Gateway(tmp_path)
    yield made
    if made.process is not None and made.process.poll() is None:
        made.kill()


@pytest.fixture
def subscribe():
    """Return a function that subscribes to a gateway and gives the queue of its events."""
    clients = []

    def connect(gateway, key_expr="gaitway/v1/**"):
        context = open_client(gateway.endpoint)
        client = context.__enter__()
        clients.append(context)
        events = Events()
        client.subscribe(key_expr, lambda _, payload: events.put(json.loads(payload)), last=1000)
        return events

    yield connect
    for context in clients:
        context.__exit__(None, None, None)


@pytest.fixture
def simulate(tmp_path):
    """Return a function that runs ``gaitway simulate`` on a port and gives its path."""
    running = []

    def start(device, *options):
        link = tmp_path / "ports" / device
        process = subprocess.Popen(
            [sys.executable, "-m", "gaitway", "simulate", device, "--link", str(link), *options],
            stdout=subprocess.PIPE,
            text=True,
        )
        running.append(process)
        assert "speaks" in process.stdout.readline()
        return link

    yield start
    for process in running:
        process.kill()
        process.wait()
        process.stdout.close()


@pytest.fixture
def cane(tmp_path):
    """Return a function that plays a simulated cane on a port from a thread."""
    (xbus,) = gaitway_codecs()
    running = []

    def start(plan):
        device = SimulatedDevice(
            tmp_path / "ports" / "cane", xbus.make_peripheral(plan.rate_hz), HostClock()
        )
        walk = simulate_cane(plan)
        strides = []
        thread = threading.Thread(target=device.play, args=(walk, strides.append))
        thread.start()
        running.append((device, thread))
        device.walk, device.strides, device.thread = walk, strides, thread
        return device

    yield start
    for device, thread in running:
        device.stop()
        thread.join()
        device.__exit__(None, None, None)


def run_cli(*arguments, check=True):
    """Run a command; return the finished process with its output as text."""
    return subprocess.run(
        [sys.executable, "-m", "gaitway", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=check,
        timeout=240,
    )


@pytest.fixture
def cli():
    return run_cli
