"""The parts: forces carried to the tip, the navigator about it, the calibration of the tip."""

from math import radians

import numpy as np
import pytest

from gaitway.api import CalibrationError, CalibrationPart, SampleBatch, WalkPlan
from gaitway.estimation import STANDARD_GRAVITY_MPS2, ImuSample
from gaitway.simulation import Constant, RigidMotion, Tremor, mounted, record
from gaitway_plugins.standard_cane.calibration import fit_tip
from gaitway_plugins.standard_cane.navigator import Navigator
from gaitway_plugins.standard_cane.params import StandardCaneParams, TipOptions
from gaitway_plugins.standard_cane.tip import TipRow, TipTransport

MOUNTING = {"x": "up", "y": "right", "z": "forward"}
LEVER_D = np.array([0.0, 0.0, -0.778])


def _leaned(amplitude_rad: float, seconds: float = 20.0, *, seed: int = 1, height_m: float = 0.6):
    """Return the recording of a cane leaned about its tip, axes of the IMU."""
    rng = np.random.default_rng(seed)
    peaks = amplitude_rad * rng.uniform(0.3, 0.6, (3, 3)) * [0.5, 1.0, 1.0]
    sway = Tremor(Constant(1.0), peaks, [0.7, 0.9, 1.3], rng.uniform(0.0, 6.0, (3, 3)))
    motion = RigidMotion(Constant(0.0, 0.0, 0.0), sway)
    place = mounted(MOUNTING, (0.02, 0.0, height_m))
    return record(WalkPlan(1.0, seed=seed), motion, place, seconds, [])


def _part(recorded) -> list[CalibrationPart]:
    t_ns = np.arange(len(recorded.pos_n), dtype=np.int64) * 10_000_000
    return [CalibrationPart([SampleBatch(t_ns, 0.01, 0, recorded.channels)], np.eye(3))]


def _rows(transport: TipTransport, *, size: int) -> list[TipRow]:
    recorded = _leaned(0.5, 4.0, height_m=0.778)
    samples = [
        ImuSample(i, tuple(a), tuple(w), clipped=False, bridged=False)
        for i, (a, w) in enumerate(
            zip(recorded.channels["accel"], recorded.channels["gyro"], strict=True)
        )
    ]
    rows: list[TipRow] = []
    for start in range(0, len(samples), size):
        rows += transport.extend(samples[start : start + size])
    return rows


def test_the_tip_of_a_leaning_cane_feels_gravity_alone_and_the_sensor_does_not():
    # The recording's IMU sits 2 cm ahead of the shaft; axes of b: x up, y right, z forward.
    rows = _rows(TipTransport(np.array([-0.778, 0.0, -0.02]), 0.06, 0.01), size=1000)
    at_tip = np.array([row.force_mps2 for row in rows[50:]]) - STANDARD_GRAVITY_MPS2
    at_imu = [np.linalg.norm(row.sample.accel_d) - STANDARD_GRAVITY_MPS2 for row in rows[50:]]
    assert np.abs(at_tip).max() < 0.25
    assert np.abs(at_imu).max() > 1.0


def test_how_samples_are_cut_does_not_change_what_the_tip_feels():
    whole, cut = (_rows(TipTransport(LEVER_D, 0.06, 0.01), size=size) for size in (1000, 3))
    assert [row.force_mps2 for row in whole] == [row.force_mps2 for row in cut]


def _navigator() -> tuple[Navigator, list[TipRow]]:
    navigator = Navigator(StandardCaneParams(), LEVER_D, 0.01)
    still = ImuSample(0, (0.0, 0.0, STANDARD_GRAVITY_MPS2), (0.0, 0.0, 0.0), False, False)
    row = TipRow(still, np.array(still.accel_d), np.zeros(3), STANDARD_GRAVITY_MPS2, 0.0)
    assert navigator.start([row] * 40)
    return navigator, [row]


def test_the_jacobian_of_the_tip_is_what_differences_show():
    navigator, (row,) = _navigator()
    kf = navigator._kf
    H = navigator._tip_jacobian()
    for axis in range(3):
        before, q = navigator.tip_n.copy(), kf.q_nd
        turn = np.zeros(3)
        turn[axis] = 1e-6
        from gaitway.estimation import rotation  # noqa: PLC0415  beside its use

        kf.q_nd = rotation.multiply(rotation.from_rotation_vector(turn), q)
        assert (navigator.tip_n - before) / 1e-6 == pytest.approx(H[:, 6 + axis], abs=1e-5)
        kf.q_nd = q


def test_a_mark_makes_the_tip_known_and_keeps_the_covariance_a_covariance():
    navigator, (row,) = _navigator()
    for _ in range(50):
        navigator.move(row)
    assert navigator.way().sigma_m > 1e-4
    navigator.mark()
    assert navigator.way().sigma_m < 1e-9
    P = navigator._kf.covariance
    assert np.linalg.eigvalsh(P).min() > -1e-12


def test_a_contact_that_the_velocity_contradicts_is_refused():
    navigator, (row,) = _navigator()
    push = row.sample._replace(accel_d=(3.0, 0.0, STANDARD_GRAVITY_MPS2))
    for _ in range(30):
        navigator.move(row._replace(sample=push))
    assert not navigator.stand(row, landing=True)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_tip_is_found_within_what_is_said(seed):
    result = fit_tip(StandardCaneParams(), TipOptions(), _part(_leaned(0.7, seed=seed)))
    found = np.array(result.params["imu_to_tip_m"])
    assert found == pytest.approx([-0.6, 0.0, -0.02], abs=0.01)
    error_m = abs(np.linalg.norm(found) - np.hypot(0.6, 0.02))
    assert error_m < 4.0 * result.params["imu_to_tip_sigma_m"]
    assert StandardCaneParams(**result.params).imu_to_tip_m == tuple(found)


def test_a_cane_that_is_hardly_leaned_is_refused():
    with pytest.raises(CalibrationError, match="lean the shaft"):
        fit_tip(StandardCaneParams(), TipOptions(), _part(_leaned(radians(0.3))))


def test_a_short_recording_is_refused():
    with pytest.raises(CalibrationError, match="20 s"):
        fit_tip(StandardCaneParams(), TipOptions(), _part(_leaned(0.7, 5.0)))


def test_a_tip_that_does_not_stand_is_refused(walk):
    with pytest.raises(CalibrationError, match="did not stand"):
        fit_tip(StandardCaneParams(), TipOptions(), _part(walk(20.0, seed=5)))
