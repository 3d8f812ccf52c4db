"""Show what gateways publish, live, one readable line an event.

Without a key expression everything is shown; gaitway/v1/*/*/stride shows the strides of all
devices. Devices that appear or vanish are told at once (their liveliness). Ctrl-C ends it.
"""

import argparse
import json
import math
import sys
import threading
from typing import Any

from gaitway.bus.subscriber import open_client

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "keyexpr",
        nargs="?",
        default="gaitway/v1/**",
        metavar="KEYEXPR",
        help="what to show (default: gaitway/v1/**)",
    )
    parser.add_argument(
        "--connect",
        default=DEFAULT_ENDPOINT,
        metavar="ENDPOINT",
        help=f"the gateway's endpoint (default: {DEFAULT_ENDPOINT}); it may come later and go",
    )
    parser.add_argument("--json", action="store_true", help="print payloads as they are, with keys")
    parser.add_argument(
        "--last", type=int, default=1, metavar="N", help="begin with the newest N of each key"
    )


def run(arguments: argparse.Namespace) -> int:
    """Subscribe and print until interrupted."""
    shown = threading.Lock()

    def show_event(key: str, payload: bytes) -> None:
        line = f"{key} {payload.decode()}" if arguments.json else describe(json.loads(payload))
        with shown:
            print(line, flush=True)

    def show_liveliness(key: str, alive: bool) -> None:
        if not arguments.json:
            with shown:
                print(f"{key.rsplit('/', 1)[-1]}: {'streaming' if alive else 'gone'}", flush=True)

    print(f"watching {arguments.keyexpr} at {arguments.connect}", file=sys.stderr)
    with open_client(arguments.connect) as client:
        client.subscribe(arguments.keyexpr, show_event, last=arguments.last)
        client.watch_liveliness(show_liveliness)
        threading.Event().wait()
    return 0


def describe(event: dict[str, Any]) -> str:
    """Return one line for a person about a published event."""
    kind = event["kind"]
    writer = _WRITERS.get(kind)
    text = writer(event) if writer else json.dumps(event)
    return f"{event['time_utc'][11:23]} {event['device']:12} {kind:8} {text}"


def number(value: float | None, form: str = ".2f") -> str:
    """Return a number, or a question mark for one that can't be known."""
    return "?" if value is None else format(value, form)


def degrees(angle_rad: float | None) -> str:
    """Return an angle in whole degrees, for a person; payloads have radians."""
    return number(None if angle_rad is None else math.degrees(angle_rad), "+.0f")


def _stride(event: dict[str, Any]) -> str:
    text = (
        f"{number(event['stride_length_m'], '.3f')} +- "
        f"{number(event['stride_length_sigma_m'], '.3f')} m in "
        f"{number(event['stride_duration_s'])} s, {number(event['walking_speed_mps'])} m/s"
    )
    if event.get("height_change_m") is not None:
        text += f", {event['height_change_m']:+.2f} m higher"
    return text + "".join(f", {event[key]}" for key in ("terrain", "style") if event.get(key))


def _load(event: dict[str, Any]) -> str:
    text = (
        f"peak {number(event['peak_force_newton'], '.0f')} +- "
        f"{number(event['peak_force_sigma_newton'], '.0f')} N"
    )
    if event["peak_load_percent"] is not None:
        text += f" ({event['peak_load_percent']:.0f} % of body weight)"
    text += f", mean {number(event['mean_force_newton'], '.0f')} N"
    text += f", {number(event['stance_duration_s'])} s on the ground"
    if event["contact_pitch_rad"] is not None or event["lift_pitch_rad"] is not None:
        text += f", pitch {degrees(event['contact_pitch_rad'])} to "
        text += f"{degrees(event['lift_pitch_rad'])} deg"
    return text


def _pose(event: dict[str, Any]) -> str:
    sigma_m = math.hypot(event["pos_x_sigma_m"], event["pos_y_sigma_m"])
    text = f"{event['pos_x_m']:.2f} m ahead, {event['pos_y_m']:.2f} m left +- {sigma_m:.2f} m"
    if event["height_m"] is not None:
        text += f", {event['height_m']:+.2f} m up"
    return f"{text}, heading {degrees(event['heading_rad'])} deg"


def _turn(event: dict[str, Any]) -> str:
    way = "left" if event["turn_angle_rad"] > 0 else "right"
    return (
        f"{math.degrees(abs(event['turn_angle_rad'])):.0f} +- "
        f"{math.degrees(event['turn_angle_sigma_rad']):.0f} deg to the {way} in "
        f"{number(event['turn_duration_s'], '.1f')} s"
    )


def _push(event: dict[str, Any]) -> str:
    return (
        f"{number(event['push_length_m'])} +- {number(event['push_length_sigma_m'])} m in "
        f"{number(event['push_duration_s'], '.1f')} s, up to {number(event['peak_speed_mps'])} m/s"
    )


def _distance(event: dict[str, Any]) -> str:
    unseen = f", {number(event['unmeasured_s'], '.0f')} s unseen" if event["unmeasured_s"] else ""
    return (
        f"{number(event['distance_m'])} +- {number(event['distance_sigma_m'])} m in "
        f"{event['strides']} strides{unseen}"
    )


def _bout(event: dict[str, Any]) -> str:
    if event["phase"] == "start":
        return "begins"
    return (
        f"ends: {number(event['distance_m'])} +- {number(event['distance_sigma_m'])} m, "
        f"{event['strides']} strides in {number(event['duration_s'], '.0f')} s, "
        f"{number(event['cadence_spm'], '.0f')} per minute"
    )


def _anomaly(event: dict[str, Any]) -> str:
    return f"{event['anomaly']}: {event['detail']}"


def _status(event: dict[str, Any]) -> str:
    rate = event["sample_rate_hz"]
    text = f"{event['link']}: {event['reason']}; {event['samples']} samples"
    if rate is not None:
        text += f" at {rate:.1f} Hz"
    if event["samples_lost"]:
        text += f", {event['samples_lost']} lost"
    if event["faults"]:
        text += ", faults " + " ".join(f"{kind} {n}" for kind, n in event["faults"].items())
    if event["recording"] != "on":
        text += f", recording {event['recording']}: {event['recording_reason']}"
    return text


_WRITERS = {
    "stride": _stride,
    "distance": _distance,
    "bout": _bout,
    "load": _load,
    "pose": _pose,
    "turn": _turn,
    "push": _push,
    "anomaly": _anomaly,
    "status": _status,
}
