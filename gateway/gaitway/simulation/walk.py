"""A motion and a plan to the walk that a sensor and a reference would have recorded."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from gaitway.contracts import SimulatedWalk, WalkPlan
from gaitway.mounting import rotation_from_mounting
from gaitway.samples import ACCEL, CLIP, GYRO, Floats, frozen_rows
from gaitway.simulation.imu_model import ImuModel, sensed
from gaitway.simulation.motion import ImuPlace, RigidMotion, ideal_imu, imu_attitude
from gaitway.simulation.person import stream
from gaitway.simulation.rotation import from_angles, rotate


@dataclass(frozen=True, slots=True)
class TrueStride:
    """One stride of the truth.

    Attributes:
        start_s: Where its cycle began.
        end_s: Where it ended.
        length_m: Horizontal length.
    """

    start_s: float
    end_s: float
    length_m: float


def mounted(
    mounting: Mapping[str, str],
    device_to_imu_d: Sequence[float],
    tilt_rad: Sequence[float] = (0.0, 0.0, 0.0),
) -> ImuPlace:
    """Return the place of an IMU on a device.

    Args:
        mounting: Where each IMU axis points (``gaitway.mounting``).
        device_to_imu_d: From the origin of d to the IMU, metres.
        tilt_rad: Yaw, pitch and roll in d by which it is fixed awry.
    """
    q = np.tile(from_angles(np.array([tilt_rad])), (3, 1))
    C_db = rotate(q, rotation_from_mounting(mounting).T).T
    return ImuPlace(np.array(device_to_imu_d), C_db)


def record(
    plan: WalkPlan,
    motion: RigidMotion,
    place: ImuPlace,
    duration_s: float,
    strides: Sequence[TrueStride],
    *,
    measured_d: Sequence[float] = (0.0, 0.0, 0.0),
    model: ImuModel | None = None,
) -> SimulatedWalk:
    """Return what the IMU reports along a motion, and the truth.

    Sample ``i`` stands for the interval that ends at ``i / rate_hz`` (``ImuRun``); the first one
    ends at 0, when the device has not moved yet. The sensor's errors come from the plan's seed
    alone; at sample rates that divide ``model.converter_hz`` even its noise is the same, summed
    over other intervals.

    Args:
        plan: Sample rate, seed, and whether the sensor is ideal.
        motion: Of the device; at rest until 0 and from duration_s on.
        place: Of the IMU on the device.
        duration_s: Of the whole recording.
        strides: True strides, in order.
        measured_d: The point whose path is measured, in d.
        model: Kind of IMU; an MTi-1 where None.
    """
    n = int(duration_s * plan.rate_hz + 1e-6) + 1
    t_s = np.arange(n) / plan.rate_hz
    gyro, accel, clip = _channels(plan, motion, place, n, model or ImuModel())
    return SimulatedWalk(
        rate_hz=plan.rate_hz,
        channels={
            ACCEL.name: frozen_rows(accel, 3),
            GYRO.name: frozen_rows(gyro, 3),
            CLIP.name: frozen_rows(clip, 1),
        },
        stride_start_s=np.array([stride.start_s for stride in strides]),
        stride_end_s=np.array([stride.end_s for stride in strides]),
        stride_length_m=np.array([stride.length_m for stride in strides]),
        pos_n=motion.point_n(t_s, np.array(measured_d)),
        q_nb=imu_attitude(motion, place, t_s),
    )


def _channels(
    plan: WalkPlan, motion: RigidMotion, place: ImuPlace, n: int, model: ImuModel
) -> tuple[Floats, Floats, Floats]:
    if plan.ideal_sensor:
        run = ideal_imu(motion, place, np.arange(-1, n) / plan.rate_hz)
        return run.gyro_b, run.accel_b, np.zeros((n, 1))
    count = max(1, ceil(model.converter_hz / plan.rate_hz - 1e-9))
    ends_s = np.arange(-count, (n - 1) * count + 1) / (plan.rate_hz * count)
    ideal = ideal_imu(motion, place, ends_s)
    sensor = stream(plan.seed, "sensor")
    noise = stream(plan.seed, "sensor", plan.repetition) if plan.repetition else None
    run, clip = sensed(ideal, count, model, sensor, noise)
    return run.gyro_b, run.accel_b, clip
