"""Samples with no break between them: swings, footings and the strides from one to the next."""

from typing import Final, NamedTuple

from gaitway.api import Event
from gaitway.estimation import CentredMean, ImuSample, half_window
from gaitway_plugins.shank.accounts import Accounts, Unmeasured
from gaitway_plugins.shank.clipping import ClipDetector
from gaitway_plugins.shank.footing import Floor, Footing
from gaitway_plugins.shank.learning import AnkleHeight, RestLearner, forward_motion
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.stride import Way, find_way
from gaitway_plugins.shank.swings import Found, Mark, SwingDetector
from gaitway_plugins.shank.tracing import Tracer
from gaitway_plugins.shank.track import Track, samples
from gaitway_plugins.shank.wearing import Wearing


class Loss(NamedTuple):
    """Walking that gives no measure.

    Attributes:
        since_ns: The last footing known.
        anomaly: Name of what happened.
        detail: One line for a person.
        mid_walk: Samples are missing, and that footing was one of a stance that rolled.
    """

    since_ns: int
    anomaly: str
    detail: str
    mid_walk: bool = False


class Stretch:
    """Follows the shank through samples with no break between them.

    It stands, or walks: between a contact and the next toe-off less than ``max_stance_s`` later it
    is in stance, then in swing. Every stance of a walk is a footing in its middle; standing is one
    where it begins and another where it ends.

    Args:
        params: Of the shank.
        period_s: Of the samples.
        accounts: Outlive the stretch, as do the learners.
        rest: Gravity and gyroscope bias.
        ankle: Height above the ankle.
        wearing: Axis of the swings.
        lost: Walking under way when the samples broke off.
        tracer: Where per-sample estimates go, if anywhere.
    """

    def __init__(
        self, params: ShankParams, period_s: float, accounts: Accounts, rest: RestLearner,
        ankle: AnkleHeight, wearing: Wearing, lost: Loss | None, tracer: Tracer | None,
    ) -> None:  # fmt: skip
        self._params = params
        self._period_s: Final = period_s
        self._accounts = accounts
        self._rest = rest
        self._ankle = ankle
        self._wearing = wearing
        wearing.begin(period_s)
        self._lost = lost
        self._tracer = tracer
        self._track = Track(period_s, rest.gyro_bias_d)
        self._floor = Floor(params, period_s, self._track, rest, ankle)
        self._clip = ClipDetector()
        self._smooth = CentredMean(half_window(params.rate_smoothing_s, period_s))
        self._swings = SwingDetector(params, period_s)
        self._max_stance: Final = samples(params.max_stance_s, period_s)
        self._rest_window: Final = samples(params.rest_window_s, period_s)
        self._now = -1
        self._contact = 0
        self._toe_off = 0
        self._walking = False
        self._swinging = False
        self._rest_begin = 0
        self._traced = 0
        self._from: Footing | None = None
        self._way: Way | None = None

    def walking_since_ns(self) -> int | None:
        """Return since when walking is not measured yet; None in standing."""
        if self._lost is not None:
            return self._lost.since_ns
        moving = self._walking or self._swinging
        return self._from.t_ns if moving and self._from is not None else None

    @property
    def mid_walk(self) -> bool:
        """Whether what is not measured yet began in the middle of a walk."""
        if self._lost is not None:
            return self._lost.mid_walk
        return self._from is not None and self._from.flat is not None

    def push(self, sample: ImuSample) -> list[Event]:
        """Take the next sample; return what it makes known."""
        self._accounts.begin(sample.t_ns)
        self._track.push(sample, clipped=self._clip.push(sample))
        events = self._wearing.push(sample)
        (x, y, z), (wx, wy, wz) = self._wearing.axis_d, sample.gyro_d
        rate_radps = self._smooth.push(x * wx + y * wy + z * wz)
        return events if rate_radps is None else events + self._follow(rate_radps)

    def finish(self) -> list[Event]:
        """Return what is known at the end of the input; a stance under way is standing."""
        events = [event for rate in self._smooth.finish() for event in self._follow(rate)]
        if self._walking and not self._swinging:
            events += self._stop()
        elif self._from is not None:
            self._lose("implausible-stride", "the samples end in a swing")
        if self._now >= 0:
            events += self._settle(self._track.t_ns(self._now))
        self.abandon()
        return events

    def abandon(self) -> None:
        """Write what is left to trace, as no more will come."""
        self._forget(self._track.end)

    def _follow(self, rate_radps: float) -> list[Event]:
        self._now += 1
        found = self._swings.push(rate_radps)
        if found is not None:
            return self._marked(found)
        if self._swinging:
            return []
        if not self._walking:
            return self._stand()
        return self._stop() if self._now - self._contact >= self._max_stance else []

    def _marked(self, found: Found) -> list[Event]:
        if found.mark is Mark.TOE_OFF:
            return self._lift(found.at)
        self._swinging = False
        self._contact = self._rest_begin = found.at
        self._walking = found.mark is Mark.CONTACT
        if found.mark is Mark.TOO_LONG:
            self._lose("implausible-stride", f"a swing of more than {self._params.max_swing_s:g} s")
        return []

    def _lift(self, toe_off: int) -> list[Event]:
        """Take that the foot left the floor; the stance before is now known in full."""
        events: list[Event] = []
        footing: Footing | None = None
        if self._walking:
            if (toe_off - self._contact) * self._period_s >= self._params.min_stance_s:
                footing = self._floor.rolling(self._contact, toe_off)
            events = self._arrive(footing)
        else:
            begin = max(self._contact, toe_off - self._max_stance, self._track.first)
            if not self._resumed_in_stance(toe_off):
                footing = self._floor.standing(begin, toe_off)
            self._way = None
            if footing is not None:
                events = self._settle(self._track.t_ns(begin))
        self._from = footing if footing is not None and footing.fits else None
        self._toe_off = toe_off
        self._swinging = True
        self._forget(toe_off if footing is None else footing.index)
        return events

    def _resumed_in_stance(self, toe_off: int) -> bool:
        """Return whether the samples came back in a stance of the walk that was going on."""
        mid_walk = self._lost is not None and self._lost.mid_walk
        return mid_walk and toe_off < self._max_stance

    def _stop(self) -> list[Event]:
        """Take that no swing followed the last contact for so long that it is standing."""
        events = self._arrive(self._floor.standing(self._contact, self._now))
        events += self._settle(self._track.t_ns(self._contact))
        self._walking = False
        self._from = None
        return events

    def _stand(self) -> list[Event]:
        events: list[Event] = []
        if self._now - self._rest_begin >= self._rest_window:
            piece = self._track.piece(self._rest_begin, self._now)
            if piece.rate_radps.mean() < self._params.rest_rate_max_radps:
                events = self._settle(self._track.t_ns(self._rest_begin))
                self._rest.learn(piece, self._track.attitude((self._rest_begin + self._now) // 2))
                self._track.gyro_bias_d = self._rest.gyro_bias_d
            self._rest_begin = self._now
            self._forget(self._now - self._max_stance - self._rest_window)
        if self._swings.turning_back:
            return events
        return events + self._accounts.stand(self._track.t_ns(self._now))

    def _arrive(self, footing: Footing | None) -> list[Event]:
        """Take where a stride ended, if it is known."""
        before, before_way, self._way = self._from, self._way, None
        if footing is None or not footing.fits:
            self._lose("implausible-stride", "the shank did not move as over a foot on the floor")
            return []
        if before is None:
            return self._bridge(footing)
        piece = self._track.piece(before.index, footing.index)
        way = find_way(piece, before, footing, self._rest.gravity_mps2)
        swing_s = (self._contact - self._toe_off) * self._period_s
        half = before.flat is None or footing.flat is None
        if not self._accounts.believes(way, swing_s / piece.duration_s, half=half):
            detail = f"{way.length_m:.2f} m with a tilt step of {way.tilt_step_rad:.2f} rad"
            self._lose("implausible-stride", f"{detail} is no stride of a walk; not counted")
            return self._settle(footing.t_ns)
        self._way = way
        self._learn(before, before_way, way)
        if self._tracer is not None:
            self._tracer.hold(self._track, self._traced, before.index)
            self._tracer.way(self._track, before.index, way, self._toe_off, self._contact)
            self._traced = footing.index
        clipped_s = piece.clipped * self._period_s
        return self._accounts.stride(before, footing, way, swing_s, clipped_s)

    def _learn(self, stance: Footing, before: Way | None, after: Way) -> None:
        """Learn from a stance between two strides that were measured."""
        if before is None or stance.flat is None:
            return
        direction = before.direction + after.direction
        closing_mps2 = 0.5 * (before.closing_mps2 + after.closing_mps2)
        self._ankle.learn(
            *forward_motion(
                stance.flat,
                stance.fit.C_nc,
                direction / max(float((direction @ direction) ** 0.5), 1e-9),
                closing_mps2,
                self._rest.gravity_mps2,
            )
        )

    def _lose(self, anomaly: str, detail: str) -> None:
        """Remember that walking goes on unmeasured since the last footing."""
        if self._lost is None and self._from is not None and self._accounts.in_bout:
            self._lost = Loss(self._from.t_ns, anomaly, detail)
        self._from = None

    def _bridge(self, footing: Footing) -> list[Event]:
        """Take that a footing is known again; strides lost in mid-walk are interpolated."""
        lost = self._lost
        if lost is None or not lost.mid_walk or footing.flat is None:
            return self._settle(footing.t_ns)
        self._lost = None
        return self._accounts.bridge(Unmeasured(*lost[:3], footing.t_ns))

    def _settle(self, t_ns: int) -> list[Event]:
        """Take that nothing is lost any longer; return what is to be said of what was."""
        lost, self._lost = self._lost, None
        if lost is None or t_ns <= lost.since_ns:
            return []
        return self._accounts.unseen(Unmeasured(*lost[:3], t_ns))

    def _forget(self, index: int) -> None:
        if self._tracer is not None and index > self._traced:
            self._tracer.hold(self._track, self._traced, index)
            self._traced = index
        self._track.drop_before(index)
