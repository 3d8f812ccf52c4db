"""Two simulated people, the gateway and a subscriber, all at once, until Ctrl-C.

A quad cane and a shank sensor are simulated on pseudo-terminals; the gateway reads them as it would
real devices, records and publishes; what you see is a subscriber's view. At the end the distance is
printed against the truth, and where the recording is.
"""

import argparse
import contextlib
import json
import os
import queue
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

from gaitway.bus.subscriber import open_client
from gaitway.cli.watch import describe
from gaitway.errors import GaitwayError

DEVICES: Final = {"quad-cane": "quad-cane", "shank": "shank"}
"""Ids of the devices to what they are."""
PORT: Final = 7447
READY_WITHIN_S: Final = 20.0
STOP_WITHIN_S: Final = 10.0
SAME_STRIDE_S: Final = 0.5
"""A true stride belongs to an estimated one that ended this close to it, or before."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "--directory", type=Path, default=Path("demo"), help="where everything goes (demo)"
    )
    parser.add_argument(
        "--duration", type=float, metavar="S", help="stop by itself after S seconds"
    )


def run(arguments: argparse.Namespace) -> int:
    """Run everything and compare with the truth at the end."""
    stamp = f"{datetime.now(UTC):%Y%m%dT%H%M%SZ}"
    demo = Demo(arguments.directory.resolve() / stamp, _free_port())
    demo.write_config()
    with contextlib.ExitStack() as stack:
        # Ctrl-C reaches every process of the terminal; only this one decides.
        for number, device in enumerate(DEVICES):
            stack.enter_context(demo.simulator(device, seed=number + 1))
        gateway = stack.enter_context(demo.gateway())
        print(f"gateway ready; its log: {demo.directory / 'gaitway.log'}")
        print(f"in another terminal: {_own_command('watch')} --connect {demo.endpoint}")
        print("two people stand still for a few seconds, then walk. Ctrl-C ends it.\n", flush=True)
        last = _show(demo.endpoint, arguments.duration, gateway)
    _print_comparison(demo, last)
    recordings = sorted(demo.directory.glob("recordings/*.mcap"))
    for file in recordings:
        print(f"recording: {file}")
    print(f"replay it: {_own_command('replay')} {' '.join(str(file) for file in recordings)}")
    return 0


@dataclass(frozen=True, slots=True)
class Demo:
    """Where one demonstration keeps its things.

    Attributes:
        directory: Everything is below it.
        port: TCP port of the bus.
        devices: Their ids to their types.
    """

    directory: Path
    port: int
    devices: Mapping[str, str] = field(default_factory=lambda: DEVICES)

    @property
    def endpoint(self) -> str:
        """Return where the gateway is reached."""
        return f"tcp/127.0.0.1:{self.port}"

    @property
    def config(self) -> Path:
        """Return the configuration file."""
        return self.directory / "gateway.toml"

    def truth(self, device: str) -> Path:
        """Return where a simulator writes its true strides."""
        return self.directory / f"{device}.truth.jsonl"

    def link(self, device: str) -> Path:
        """Return the port of a simulated device."""
        return self.directory / "ports" / device

    def write_config(self) -> None:
        """Write a configuration as a person would."""
        self.directory.mkdir(parents=True)
        lines = ['site = "demo"', "[bus]", f'listen = ["{self.endpoint}"]']
        lines += ["[recording]", 'directory = "recordings"', "min_free_gb = 0.1"]
        lines += ["[resume]", "within_s = 0"]  # what is going on ends with the demo
        for device, device_type in self.devices.items():
            lines += ["[[devices]]", f'id = "{device}"', f'type = "{device_type}"']
            driver = f'transport = "serial", port = "{self.link(device)}", codec = "xbus"'
            lines += [f"driver = {{ {driver} }}"]
        self.config.write_text("\n".join(lines) + "\n", encoding="utf-8")

    @contextlib.contextmanager
    def simulator(self, device: str, seed: int) -> Iterator[None]:
        """Run a simulated device until left."""
        arguments = [
            *("simulate", self.devices[device], "--link", str(self.link(device))),
            *("--seed", str(seed)),
            *("--truth", str(self.truth(device)), "--distance", "12"),
        ]
        with (self.directory / f"{device}.log").open("w") as log, _process(arguments, log):
            yield

    @contextlib.contextmanager
    def gateway(self) -> Iterator[subprocess.Popen[bytes]]:
        """Run the daemon; entered when it says it is ready."""
        with (
            socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notify,
            (self.directory / "gaitway.log").open("w") as log,
        ):
            address = f"\0gaitway-demo-{os.getpid()}"
            notify.bind(address)
            notify.settimeout(READY_WITHIN_S)
            environment = os.environ | {"NOTIFY_SOCKET": address.replace("\0", "@")}
            with _process(["run", str(self.config)], log, environment) as process:
                try:
                    notify.recv(100)
                except TimeoutError:
                    raise GaitwayError(
                        f"the gateway did not become ready; see {log.name}"
                    ) from None
                yield process


@contextlib.contextmanager
def _process(
    arguments: list[str], log: Any, environment: dict[str, str] | None = None
) -> Iterator[subprocess.Popen[bytes]]:
    """Run one of our own commands in a session of its own; SIGTERM it at the end."""
    process = subprocess.Popen(
        [sys.executable, "-m", "gaitway", *arguments],
        stdout=log,
        stderr=subprocess.STDOUT,
        env=environment,
        start_new_session=True,
    )
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(STOP_WITHIN_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _show(
    endpoint: str, duration_s: float | None, gateway: subprocess.Popen[bytes]
) -> dict[str, dict[str, Any]]:
    """Print events until interrupted; stop the gateway; return the last distance of each device."""
    last: dict[str, dict[str, Any]] = {}
    events: queue.Queue[dict[str, Any] | None] = queue.Queue()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: events.put(None))
    if duration_s is not None:
        signal.signal(signal.SIGALRM, lambda *_: events.put(None))
        signal.setitimer(signal.ITIMER_REAL, duration_s)
    with open_client(endpoint) as client:
        client.subscribe(
            "gaitway/v1/**", lambda _, payload: events.put(json.loads(payload)), last=1
        )
        while (event := events.get()) is not None:
            _note(event, last)
            print(describe(event), flush=True)
        print("\nstopping ...", flush=True)
        gateway.terminate()
        gateway.wait(STOP_WITHIN_S)
        with contextlib.suppress(queue.Empty):
            while True:
                event = events.get(timeout=0.3)
                if event is not None:
                    _note(event, last)
    return last


def _note(event: dict[str, Any], last: dict[str, dict[str, Any]]) -> None:
    """Keep the distance as of the last stride; what is told later has no true stride beside it."""
    before = last.get(event["device"])
    if event["kind"] == "distance" and (not before or event["strides"] != before["strides"]):
        last[event["device"]] = event


def _print_comparison(demo: Demo, last: dict[str, dict[str, Any]]) -> None:
    print(f"\n{'device':12} {'estimated':>30} {'true (simulated)':>24} {'difference':>12}")
    for device in DEVICES:
        if device not in last:
            print(f"{device:12} no stride yet: let it run a little longer")
            continue
        event = last[device]
        until_s = datetime.fromisoformat(event["time_utc"]).timestamp() + SAME_STRIDE_S
        distance_m, strides = _truth_until(demo.truth(device), until_s)
        estimated = (
            f"{event['distance_m']:.2f} +- {event['distance_sigma_m']:.2f} m"
            f" in {event['strides']} strides"
        )
        error_m = event["distance_m"] - distance_m
        percent = f" ({100 * error_m / distance_m:+.1f} %)" if distance_m else ""
        true = f"{distance_m:.2f} m in {strides}"
        print(f"{device:12} {estimated:>30} {true:>24} {error_m:+8.2f} m{percent}")


def _truth_until(file: Path, until_unix_s: float) -> tuple[float, int]:
    distance_m, strides = 0.0, 0
    if file.exists():
        for line in file.read_text(encoding="utf-8").splitlines():
            stride = json.loads(line)
            if stride["time_unix_s"] <= until_unix_s:
                distance_m, strides = stride["distance_m"], stride["strides"]
    return distance_m, strides


def _free_port() -> int:
    """Return the usual port, or any free one where something listens there already."""
    for port in (PORT, 0):
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            number: int = probe.getsockname()[1]
            return number
    raise GaitwayError("no TCP port is free on 127.0.0.1")


def _own_command(name: str) -> str:
    command = Path(sys.argv[0])
    shown = command.relative_to(Path.cwd()) if command.is_relative_to(Path.cwd()) else command
    return f"{shown} {name}" if shown.name == "gaitway" else f"python -m gaitway {name}"
