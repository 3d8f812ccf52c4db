"""A crude second walker: the leg turns about a heel that is nailed to the floor while it stands.

Nothing of it comes from ``gaitway.simulation``: an inverted pendulum at a steady rate in stance, a
quintic in swing, differentiated numerically on a fine grid, sampled without any filter.
"""

from dataclasses import dataclass

import numpy as np

G = 9.80665
FINE_HZ = 2000.0


@dataclass
class HeelWalk:
    """Samples in frame d (x forward, y left, z up) and the truth."""

    accel: np.ndarray
    gyro: np.ndarray
    rate_hz: float
    strides_m: np.ndarray
    heights_m: np.ndarray
    contacts_s: list
    offs_s: list

    @property
    def distance_m(self):
        return float(self.strides_m.sum())

    @property
    def height_m(self):
        return float(self.heights_m.sum())


def quintic(t, duration, start, stop, rate_start, rate_stop):
    """Return a curve from start to stop with given rates and no acceleration at the ends."""
    d = duration
    A = np.array(
        [[d**3, d**4, d**5], [3 * d**2, 4 * d**3, 5 * d**4], [6 * d, 12 * d**2, 20 * d**3]]
    )
    a, b, c = np.linalg.solve(A, [stop - start - rate_start * d, rate_stop - rate_start, 0.0])
    return start + rate_start * t + a * t**3 + b * t**4 + c * t**5


def legs(distance_m, length_m, rise_m):
    """Return lengths and rises: half a stride, whole ones, half a stride."""
    whole = max(1, round((distance_m - length_m) / length_m))
    size = distance_m / (whole + 1)
    lengths = np.array([0.5, *[1.0] * whole, 0.5]) * size
    return lengths, np.array([0.5, *[1.0] * whole, 0.5]) * rise_m


def heel_walk(
    *, distance_m=40.0, length_m=1.3, rise_m=0.0, cycle_s=1.15, stance_share=0.6, swing_rad=0.7,
    lever_d=(0.03, 0.0, 0.12), rate_hz=100.0, rest_s=2.0, sway_rad=0.0, clearance_m=0.08,
    turn_rad=0.0, heel_rise_s=0.0, seed=0, vary=0.03, noise_accel=1.2e-3, noise_gyro=1.2e-4,
    bias_accel=0.03, bias_gyro=0.005, scale=0.0,
):  # fmt: skip
    """Return a walk; noise as densities, biases and scale as standard deviations.

    The last heel_rise_s of a stance the heel rises forward while the leg turns slower.
    """
    rng = np.random.default_rng(seed)
    lengths, rises = legs(distance_m, length_m, rise_m)
    lengths = lengths * (1.0 + vary * rng.standard_normal(len(lengths)))
    dt = 1.0 / FINE_HZ
    pitch, pivot, yaw = [np.zeros(round(rest_s / dt))], [np.zeros((round(rest_s / dt), 3))], []
    yaw.append(np.zeros(len(pitch[0])))
    at, heading, lean, now = np.zeros(3), 0.0, 0.0, rest_s
    rising_mps2 = np.array([0.5, 0.0, 0.3])
    off_m = off_mps = np.zeros(3)
    contacts, offs = [], []
    for number, (length, rise) in enumerate(zip(lengths, rises, strict=True)):
        swing_s = cycle_s * (1.0 - stance_share) * (1.0 + vary * rng.standard_normal())
        stance_s = cycle_s * stance_share * (1.0 + vary * rng.standard_normal())
        last = number == len(lengths) - 1
        reach = length / lengths.max()
        if number == 0:
            t = np.arange(0.0, 0.5, dt)
            pitch.append(quintic(t, 0.5, 0.0, 0.5 * swing_rad, 0.0, swing_rad / stance_s))
            pivot.append(np.tile(at, (len(t), 1)))
            yaw.append(np.full(len(t), heading))
            lean, now = 0.5 * swing_rad, now + 0.5
        t = np.arange(0.0, swing_s, dt)
        rate = swing_rad / stance_s
        to = 0.0 if last else -0.5 * swing_rad * reach
        pitch.append(quintic(t, swing_s, lean, to, rate, 0.0 if last else rate))
        s = quintic(t, swing_s, 0.0, 1.0, 0.0, 0.0)
        step = np.array([np.cos(heading), np.sin(heading), 0.0]) * length + [0.0, 0.0, rise]
        lift = clearance_m * 64 * (t / swing_s) ** 3 * (1 - t / swing_s) ** 3
        carry = [
            quintic(t, swing_s, *off, 0.0) for off in zip(off_m, [0.0] * 3, off_mps, strict=True)
        ]
        pivot.append(at + np.outer(s, step) + np.outer(lift, [0.0, 0.0, 1.0]) + np.transpose(carry))
        turning = turn_rad / len(lengths)
        yaw.append(heading + s * turning)
        heading += turning
        at = at + step
        offs.append(now)
        now += swing_s
        contacts.append(now)
        if not last:
            t = np.arange(0.0, stance_s, dt)
            risen = np.maximum(0.0, t - stance_s + heel_rise_s)
            slower = 0.6 * np.sin(np.pi * risen / max(heel_rise_s, dt)) ** 2
            pitch.append(to + rate * np.cumsum(1.0 - slower) * dt)
            pivot.append(at + 0.5 * np.outer(risen**2, rising_mps2))
            off_m, off_mps = pivot[-1][-1] - at, risen[-1] * rising_mps2
            yaw.append(np.full(len(t), heading))
            lean, now = pitch[-1][-1], now + stance_s
    n = round(rest_s / dt)
    pitch.append(np.zeros(n))
    pivot.append(np.tile(at, (n, 1)))
    yaw.append(np.full(n, heading))
    pitch, pivot, yaw = np.concatenate(pitch), np.concatenate(pivot), np.concatenate(yaw)
    t = np.arange(len(pitch)) * dt
    pitch = pitch + sway_rad * np.sin(2 * np.pi * 0.4 * t + 1.0)
    roll = sway_rad * np.sin(2 * np.pi * 0.3 * t)
    cy, sy, cp, sp, cr, sr = (f(a) for a in (yaw, pitch, roll) for f in (np.cos, np.sin))
    C = np.empty((len(t), 3, 3))
    C[:, 0] = np.stack([cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr], axis=1)
    C[:, 1] = np.stack([sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr], axis=1)
    C[:, 2] = np.stack([-sp, cp * sr, cp * cr], axis=1)
    imu = pivot + C @ np.array(lever_d)
    force_n = np.gradient(np.gradient(imu, dt, axis=0), dt, axis=0) + np.array([0.0, 0.0, G])
    accel = np.einsum("nij,ni->nj", C, force_n)
    turn = np.einsum("nji,njk->nik", C, np.gradient(C, dt, axis=0))
    gyro = np.stack([turn[:, 2, 1], turn[:, 0, 2], turn[:, 1, 0]], axis=1)
    keep = slice(0, None, round(FINE_HZ / rate_hz))
    # A sensor's own low-pass filter; it rounds off the corners of the rate at contact.
    width = max(1, round(0.01 / dt))
    box = np.ones(width) / width
    accel, gyro = (
        np.apply_along_axis(
            lambda a: np.convolve(np.pad(a, width, mode="edge"), box, "same"), 0, x
        )[width:-width][keep]
        for x in (accel, gyro)
    )
    root = np.sqrt(rate_hz)
    accel = accel * (1.0 + scale * rng.standard_normal(3)) + bias_accel * rng.standard_normal(3)
    gyro = gyro * (1.0 + scale * rng.standard_normal(3)) + bias_gyro * rng.standard_normal(3)
    accel = accel + noise_accel * root * rng.standard_normal(accel.shape)
    gyro = gyro + noise_gyro * root * rng.standard_normal(gyro.shape)
    return HeelWalk(accel, gyro, rate_hz, lengths, rises, contacts, offs)
