"""Run a recording through today's code, and say whether the events equal the recorded ones.

Give all files of a run in order (their names sort that way): distances are running sums, so a file
from the middle of a run can't agree. Exit status 0: equal; 1: different.
"""

import argparse
from collections import Counter
from pathlib import Path

from gaitway.errors import InputDataError
from gaitway.registry import load_registry
from gaitway.runtime.replay import DeviceReplay, describe_difference, replay


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE.mcap")


def run(arguments: argparse.Namespace) -> int:
    """Replay and compare."""
    for file in arguments.files:
        if not file.is_file():
            raise InputDataError(f"{file}: no such file")
    result = replay(arguments.files, load_registry())
    equal = True
    for device, events in result.devices.items():
        equal &= _report(device, events)
    for part in result.unreadable:
        print(f"{part.n_bytes} bytes at {part.offset} are unreadable: {part.reason}")
    if result.starts_late and not equal:
        print("the first file is not the first of its run: give all files of the run, in order")
    return 0 if equal else 1


def _report(device: str, events: DeviceReplay) -> bool:
    kinds = Counter(event.kind for event in events.replayed)
    counts = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items())) or "no events"
    number = events.first_difference
    if number is None:
        extra = len(events.replayed) - len(events.recorded)
        cut = f" ({extra} more at the end, held back when the recording ended)" if extra else ""
        print(f"{device}: {counts}: equal to the recorded events{cut}")
        return True
    then = events.recorded[number] if number < len(events.recorded) else None
    now = events.replayed[number] if number < len(events.replayed) else None
    print(
        f"{device}: {counts}; {len(events.recorded)} recorded; event {number} differs: "
        f"{describe_difference(then, now)}"
    )
    return False
