"""The crutch tip: 5 m there and back (Sesar et al. 2019), robustness, coverage, leaning on it."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise

import numpy as np
from experiment import Experiment, Outcome, Target, estimated, inside_percent, registry, simulated

from gaitway.contracts import WalkPlan
from gaitway.samples import Gap, SampleBatch

DEVICE = "crutch-tip"
FIRST_SEED = 1000
USER = {"body_mass_kg": 70.0}
SENSORS = ("mti", "mems")
CHANNELS = ("all", "no-roll", "no-accel", "accel", "volt")
NEAR_S = 0.3
"""A load within this of a true contact is that contact."""
Cut = Callable[[SampleBatch, int], list[SampleBatch | Gap]]


def experiments() -> list[Experiment]:
    return [_paper(), *_robustness(), _coverage(), _leaning()]


def _paper() -> Experiment:
    return Experiment(
        device=DEVICE, name="5 m there and back", figures=figures, quick=6,
        plans=[_plan(FIRST_SEED + walk, sensor=SENSORS[walk % 2]) for walk in range(24)],
        methods={"default": _walked(), "published": _walked({"method": "published"})},
        targets=(
            Target("straight_deg", 1.0), Target("turning_deg", 3.0),
            Target("steps_missed", 0.0),
        ),
        paper="straight 1.40 deg, turning 15.3-27.5 deg, force 8.78 N",
    )  # fmt: skip


def _robustness() -> list[Experiment]:
    rows: dict[str, tuple[dict, dict, Cut | None]] = {
        "50 Hz": ({}, {"rate_hz": 50.0}, None),
        "200 Hz": ({}, {"rate_hz": 200.0}, None),
        "2 % of samples lost": ({}, {}, _lose_samples),
        "0.5 s gaps": ({}, {}, _lose_halves),
        "gyroscope bias 1 deg/s": ({"gyro_bias_dps": 1.0}, {}, None),
        "0.3 m/s": ({}, {"speed_mps": 0.3}, None),
        "hard shocks": ({"shock": 3.0}, {}, None),
        "sensor 5 cm higher than told": ({"imu_height_m": 0.15}, {}, None),
        "one inclinometer axis": ({"channels": "no-roll"}, {}, None),
        "no accelerometer": ({"channels": "no-accel"}, {}, None),
        "no inclinometer": ({"channels": "accel"}, {}, None),
        "force in volts": ({"channels": "volt"}, {}, None),
    }
    return [
        Experiment(
            device=DEVICE, name=f"5 m there and back, {name}", figures=figures, quick=2,
            plans=[_plan(FIRST_SEED + 200 + walk, sensor=SENSORS[walk % 2], more=conditions, **plan)
                   for walk in range(8)],
            methods={"default": _walked(cut=cut)},
            targets=(Target("straight_deg", 1.0), Target("turning_deg", 3.0)),
        )
        for name, (conditions, plan, cut) in rows.items()
    ]  # fmt: skip


def _coverage() -> Experiment:
    plans = [
        _plan(
            FIRST_SEED + 500 + walk, sensor=SENSORS[walk % 2], distance_m=6.0,
            rate_hz=(50.0, 100.0, 200.0)[walk % 3],
            more={"channels": CHANNELS[walk % 5], "shock": float(walk % 4),
                  "imu_height_m": (0.08, 0.1, 0.12)[walk // 2 % 3]},
        )
        for walk in range(200)
    ]  # fmt: skip
    return Experiment(
        device=DEVICE, name="coverage", plans=plans, methods={"default": _walked()},
        figures=figures, quick=20,
        targets=(
            Target("pitches_inside_95_percent", 90.0, True),
            Target("pitches_inside_95_percent", 98.0),
            Target("loads_inside_95_percent", 90.0, True),
            Target("loads_inside_95_percent", 98.0),
        ),
    )  # fmt: skip


def _leaning() -> Experiment:
    """Six times ten minutes of standing, leaning on the crutch again and again."""
    return Experiment(
        device=DEVICE, name="leaning on it, an hour", figures=_idle_figures, quick=2,
        plans=[WalkPlan(600.0, seed=FIRST_SEED + 300 + number) for number in range(6)],
        methods={"default": _leaned_on}, targets=(Target("false_steps", 0.0),),
    )  # fmt: skip


def figures(outcomes: Sequence[Sequence[Outcome]]) -> dict[str, float]:
    """Return mean and worst RMS errors, steps missed or too many, and coverage."""
    of = {what: [o for walk in outcomes for o in walk if o.what == what]
          for what in ("straight", "turning", "force", "steps", "pitch", "load")}  # fmt: skip
    told = {what: np.array([o.told for o in of[what]]) for what in ("straight", "turning", "force")}
    return {
        "straight_deg": float(told["straight"].mean()),
        "straight_worst_deg": float(told["straight"].max()),
        "turning_deg": float(told["turning"].mean()),
        "turning_worst_deg": float(told["turning"].max()),
        "force_newton": float(np.sqrt(np.mean(told["force"] ** 2))),
        "steps_missed": float(sum(abs(o.told - o.true) for o in of["steps"])),
        "pitches_inside_95_percent": inside_percent(of["pitch"]),
        "loads_inside_95_percent": inside_percent(of["load"]),
    }


def _plan(seed: int, sensor: str, distance_m: float = 10.0, more: Mapping = {}, **changes):
    conditions = {"sensor": sensor, **more}
    return WalkPlan(distance_m, seed=seed, turn_back=True, conditions=conditions, **changes)


def _walked(params: Mapping = {}, cut: Cut | None = None):
    return partial(_outcomes, params, cut)


def _outcomes(params: Mapping, cut: Cut | None, plan: WalkPlan) -> list[Outcome]:
    walk, batch = simulated(DEVICE, plan)
    if cut is None:
        events, trace = estimated(DEVICE, USER | dict(params), batch, trace=True)
    else:
        events, trace = _fed(params, cut(batch, plan.seed))
    at = np.round(np.array(trace.t_ns) * plan.rate_hz / 1e9).astype(int)
    pitch, _, force, _ = np.array(trace.rows).T
    truth = walk.truth
    t_s = at / plan.rate_hz
    walking = (t_s > walk.stride_start_s[0]) & (t_s < truth["lift_s"][-1])
    turning = truth["turning"][at] > 0.0
    error_deg = np.degrees(pitch - truth["pitch_rad"][at])
    loaded = truth["force_newton"][at] > 25.2
    steps = sum(event.strides or 0 for event in events if event.kind == "bout")
    return [
        Outcome(_rms(error_deg[walking & ~turning]), 0.0, None, "straight"),
        Outcome(_rms(error_deg[walking & turning]), 0.0, None, "turning"),
        Outcome(_rms((force - truth["force_newton"][at])[loaded]), 0.0, None, "force"),
        Outcome(float(steps), float(len(walk.stride_length_m)), None, "steps"),
        *_of_loads([event for event in events if event.kind == "load"], truth),
    ]


def _of_loads(loads: Sequence, truth: Mapping[str, np.ndarray]) -> list[Outcome]:
    """Return pitches and peaks of the loads that are true ones."""
    out = []
    for load in loads:
        apart_s = np.abs(truth["contact_s"] - load.start_t_ns / 1e9)
        i = int(np.argmin(apart_s))
        if apart_s[i] > NEAR_S:
            continue
        out += [
            Outcome(load.contact_pitch_rad, truth["contact_pitch_rad"][i],
                    load.contact_pitch_sigma_rad, "pitch"),
            Outcome(load.lift_pitch_rad, truth["lift_pitch_rad"][i],
                    load.lift_pitch_sigma_rad, "pitch"),
            Outcome(load.peak_force_newton, truth["peak_force_newton"][i],
                    load.peak_force_sigma_newton, "load"),
        ]  # fmt: skip
    return out


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _fed(params: Mapping, items: Sequence[SampleBatch | Gap]):
    device = registry().devices[DEVICE]
    estimator = device.make_estimator(device.params.model_validate(params), np.eye(3))
    trace = estimator.start_trace()
    events = [event for item in items for event in estimator.update(item)]
    return [*events, *estimator.finish()], trace


def _lose(batch: SampleBatch, lost: np.ndarray) -> list[SampleBatch | Gap]:
    edges = [0, *(np.flatnonzero(np.diff(lost)) + 1).tolist(), len(lost)]
    return [
        Gap(int(batch.t_ns[begin]), end - begin, "lost") if lost[begin] else batch[begin:end]
        for begin, end in pairwise(edges)
    ]


def _lose_samples(batch: SampleBatch, seed: int) -> list[SampleBatch | Gap]:
    lost = np.random.default_rng(seed).random(len(batch)) < 0.02
    lost[0] = False
    return _lose(batch, lost)


def _lose_halves(batch: SampleBatch, seed: int) -> list[SampleBatch | Gap]:
    lost = np.zeros(len(batch), dtype=bool)
    half = round(0.5 / batch.period_s)
    for begin in np.random.default_rng(seed).integers(500, len(batch) - 500, 2):
        lost[begin : begin + half] = True
    return _lose(batch, lost)


def _leaned_on(plan: WalkPlan) -> list[Outcome]:
    rng = np.random.default_rng(plan.seed)
    n = round(plan.distance_m * plan.rate_hz)
    t_s = np.arange(n) / plan.rate_hz
    edges_s = np.cumsum(rng.uniform(0.5, 4.0, int(plan.distance_m)))
    loaded = np.searchsorted(edges_s, t_s) % 2 == 1
    sway = np.cumsum(rng.normal(0.0, 1.0, (n, 3)), axis=0)
    sway -= np.array([np.interp(t_s, t_s[::200], column[::200]) for column in sway.T]).T
    sway *= 0.01 / sway.std(axis=0)
    channels = {
        "gyro": np.gradient(sway, 1.0 / plan.rate_hz, axis=0) + rng.normal(0.0, 0.008, 3),
        "force": np.where(loaded, 150.0, 5.0)[:, None] + rng.normal(0.0, 2.0, (n, 1)),
        "inclination": sway[:, 1:2],
    }
    batch = SampleBatch(np.round(t_s * 1e9).astype(np.int64), 1.0 / plan.rate_hz, 0, channels)
    events, _ = _fed({}, [batch])
    steps = sum(event.strides or 0 for event in events if event.kind == "bout")
    loads = sum(event.kind == "load" for event in events)
    return [Outcome(float(steps), 0.0, None, "steps"), Outcome(float(loads), 0.0, None, "loads")]


def _idle_figures(outcomes: Sequence[Sequence[Outcome]]) -> dict[str, float]:
    return {
        "false_steps": sum(walk[0].told for walk in outcomes),
        "loads": sum(walk[1].told for walk in outcomes),
    }
