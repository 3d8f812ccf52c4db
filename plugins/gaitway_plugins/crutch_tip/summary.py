"""What ``gaitway estimate`` says of a crutch."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from gaitway.api import Bout, Event, Load


def summarise(events: Sequence[Event]) -> Mapping[str, Any]:
    """Return loads and steps; a crutch measures no distance.

    ``stances`` counts the loads, ``peak_force_newton`` lists the peak of each; ``strides`` counts
    the steps in walking bouts.
    """
    loads = [event for event in events if isinstance(event, Load)]
    bouts = [event for event in events if isinstance(event, Bout) and event.phase == "end"]
    return {
        "walking_s": math.fsum(bout.duration_s or 0.0 for bout in bouts),
        "distance_m": None,
        "distance_sigma_m": None,
        "strides": sum(bout.strides or 0 for bout in bouts),
        "stride_length_m": [],
        "stances": len(loads),
        "peak_force_newton": [load.peak_force_newton for load in loads],
        "peak_force_sigma_newton": [load.peak_force_sigma_newton for load in loads],
        "peak_load_percent": [load.peak_load_percent for load in loads],
        "contact_pitch_rad": [load.contact_pitch_rad for load in loads],
        "lift_pitch_rad": [load.lift_pitch_rad for load in loads],
    }
