"""Be a device: a simulated person walks with it, with known truth.

As a serial device on a pseudo-terminal, answering the handshake as the real one would, so that the
gateway only ever sees a port:

    gaitway simulate quad-cane --protocol xbus --link /tmp/cane --distance 20

The walk begins when the gateway has started the measurement; walk follows walk until Ctrl-C.
Or as a file for gaitway estimate:

    gaitway simulate quad-cane --csv walk.csv --distance 170 --turn-back

A device's simulation may know further conditions, --condition shocks=hard; a wrong one is told with
those that there are.
"""

import argparse
import itertools
import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gaitway.cli.settings import assignments
from gaitway.contracts import DeviceType, SimulatedWalk, WalkPlan
from gaitway.errors import ConfigError, InputDataError
from gaitway.registry import load_registry
from gaitway.samples import CHANNELS
from gaitway.testing.simulated_device import SimulatedDevice
from gaitway.timebase import NS_PER_S, HostClock


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("device", metavar="DEVICE", help="device type, as gaitway plugins lists")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--link", type=Path, metavar="PATH", help="offer it as a port at PATH")
    where.add_argument("--csv", type=Path, metavar="FILE", help="write one walk to a CSV file")
    parser.add_argument("--protocol", default="xbus", help="wire format (default: xbus)")
    parser.add_argument(
        "--distance", type=positive, default=20.0, metavar="M", help="per walk (20)"
    )
    parser.add_argument(
        "--rest", type=positive, default=4.0, metavar="S", help="rest at the ends (4)"
    )
    parser.add_argument("--speed", type=positive, metavar="M/S", help="default: the person's own")
    parser.add_argument("--rate", type=positive, default=100.0, metavar="HZ", help="samples (100)")
    parser.add_argument("--seed", type=natural, default=0, help="another seed, another person (0)")
    parser.add_argument("--turn-back", action="store_true", help="turn half-way and come back")
    parser.add_argument(
        "--condition",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="what else the device's simulation can vary, a number or a word; may be repeated",
    )
    parser.add_argument(
        "--walks", type=natural, metavar="N", help="stop after N walks (default: never)"
    )
    parser.add_argument("--truth", type=Path, metavar="FILE", help="write true strides, JSON lines")


def positive(text: str) -> float:
    """Return a positive finite number, for argparse."""
    value = float(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value


def natural(text: str) -> int:
    """Return a whole number from 0 on, for argparse."""
    value = int(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text} is negative")
    return value


def run(arguments: argparse.Namespace) -> int:
    """Simulate to a port or to a file."""
    registry = load_registry()
    device = registry.devices.get(arguments.device)
    if device is None or device.simulate is None:
        can = ", ".join(name for name, known in registry.devices.items() if known.simulate)
        raise InputDataError(f"{arguments.device!r} can't be simulated (one of: {can})")
    plan = WalkPlan(
        distance_m=arguments.distance,
        seed=arguments.seed,
        rate_hz=arguments.rate,
        rest_s=arguments.rest,
        speed_mps=arguments.speed,
        turn_back=arguments.turn_back,
        conditions=_conditions(arguments.condition),
    )
    truth = TruthLog(arguments.truth)
    if arguments.csv:
        walk = _walk(device, plan)
        write_csv(walk, arguments.csv)
        truth.add_walk(walk, 0.0)
        print(
            f"{arguments.csv}: {len(walk.pos_n) / walk.rate_hz:.1f} s at {walk.rate_hz:g} Hz, true"
            f" distance {walk.distance_m:.3f} m in {len(walk.stride_length_m)} strides"
        )
        return 0
    codec = registry.codecs.get(arguments.protocol)
    if codec is None or codec.make_peripheral is None:
        can = ", ".join(name for name, known in registry.codecs.items() if known.make_peripheral)
        raise InputDataError(f"{arguments.protocol!r} can't be simulated (one of: {can})")
    peripheral = codec.make_peripheral(arguments.rate)
    with SimulatedDevice(arguments.link, peripheral, HostClock()) as simulated:
        print(f"{device.name} speaks {codec.name} at {arguments.link}", flush=True)
        for walk in _walks(device, plan, arguments.walks):
            simulated.play(walk, truth.follow(walk, simulated.elapsed_s))
            print(
                f"{simulated.elapsed_s:8.1f} s: walked {truth.distance_m:.2f} m in {truth.strides}"
                " strides (true)",
                flush=True,
            )
    return 0


def _conditions(texts: Sequence[str]) -> dict[str, str | float]:
    conditions = assignments(texts, flag="--condition")
    for key, value in conditions.items():
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise ConfigError(f"--condition {key}: {value!r} is neither a number nor a word")
    return conditions


def write_csv(walk: SimulatedWalk, path: Path) -> None:
    """Write what the sensor reported, as gaitway estimate reads it."""
    columns = ["t_s"]
    values = [np.arange(len(walk.pos_n)) / walk.rate_hz]
    for channel in CHANNELS:
        if channel.name in walk.channels:
            columns += channel.columns
            values += list(walk.channels[channel.name].T)
    rows = np.column_stack(values)
    np.savetxt(path, rows, fmt="%.9g", delimiter=",", header=",".join(columns), comments="")


@dataclass(slots=True)
class TruthLog:
    """True strides as they happen, a JSON object a line.

    Attributes:
        path: Where to write; nowhere when None.
        distance_m: Walked so far.
        strides: Made so far.
    """

    path: Path | None
    distance_m: float = 0.0
    strides: int = 0

    def add_walk(self, walk: SimulatedWalk, start_s: float) -> None:
        """Add all strides of a walk."""
        for number in range(len(walk.stride_length_m)):
            self.add_stride(walk, number, start_s)

    def follow(self, walk: SimulatedWalk, start_s: float) -> Callable[[int], None]:
        """Return what adds a stride of a walk, by its number, as it happens."""
        return lambda number: self.add_stride(walk, number, start_s)

    def add_stride(self, walk: SimulatedWalk, number: int, start_s: float) -> None:
        """Add one stride of a walk that began ``start_s`` after the first sample."""
        self.distance_m += float(walk.stride_length_m[number])
        self.strides += 1
        if self.path is None:
            return
        line = {
            "t_s": round(start_s + float(walk.stride_end_s[number]), 6),
            "time_unix_s": HostClock().wall_ns() / NS_PER_S,
            "stride_length_m": float(walk.stride_length_m[number]),
            "strides": self.strides,
            "distance_m": self.distance_m,
        }
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")


def _walk(device: DeviceType, plan: WalkPlan) -> SimulatedWalk:
    assert device.simulate is not None
    try:
        return device.simulate(plan)
    except ValueError as exc:
        raise InputDataError(str(exc)) from exc


def _walks(device: DeviceType, plan: WalkPlan, count: int | None) -> Iterator[SimulatedWalk]:
    for repetition in range(count) if count is not None else itertools.count():
        yield _walk(device, replace(plan, repetition=repetition))
