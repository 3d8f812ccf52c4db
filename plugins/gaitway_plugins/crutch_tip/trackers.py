"""Which tracker a method is."""

from gaitway_plugins.crutch_tip.params import CrutchTipParams
from gaitway_plugins.crutch_tip.published import PublishedTracker
from gaitway_plugins.crutch_tip.tilt_tracker import TiltTracker
from gaitway_plugins.crutch_tip.tracker import Tracker


def make_tracker(params: CrutchTipParams, period_s: float) -> Tracker:
    """Return the tracker of the method that the parameters name."""
    if params.method == "published":
        return PublishedTracker(params, period_s)
    return TiltTracker(params, period_s)
