"""What ``gaitway estimate`` adds for a walker."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from gaitway.api import Event, Pose, Push, Stride, Turn
from gaitway_plugins.walker.tracing import STYLES


def summarise(events: Sequence[Event]) -> Mapping[str, Any]:
    """Return how often each style was seen, how far the end is from the start, and what else was.

    ``net_displacement_m`` is of the last path: null where nothing moved, or where a path broke off.
    """
    styles = Counter(e.style for e in events if isinstance(e, Stride))
    poses = [e for e in events if isinstance(e, Pose)]
    whole = len({pose.since_t_ns for pose in poses}) == 1
    last = poses[-1] if whole else None
    return {
        "style_counts": {style: styles[style] for style in STYLES},
        "net_displacement_m": None if last is None else math.hypot(last.pos_x_m, last.pos_y_m),
        "net_displacement_sigma_m": None if last is None else _net_sigma_m(last),
        "pushes": sum(isinstance(e, Push) for e in events),
        "turns": sum(isinstance(e, Turn) for e in events),
    }


def _net_sigma_m(pose: Pose) -> float:
    net_m = math.hypot(pose.pos_x_m, pose.pos_y_m) or 1.0
    along = (pose.pos_x_m / net_m * pose.pos_x_sigma_m, pose.pos_y_m / net_m * pose.pos_y_sigma_m)
    return math.hypot(*along)
