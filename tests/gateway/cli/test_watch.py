"""What a person reads of each kind of event: one line, units included, no number made up."""

import math

import pytest

from gaitway.cli.watch import describe
from gaitway.events import EVENT_TYPES, Load, Pose, Push, Stride, Turn

ENVELOPE = {"device": "left", "time_utc": "2026-01-02T03:04:05.678901Z"}


def told(event):
    return describe({**ENVELOPE, "kind": event.kind, **event.model_dump()})


STRIDE = {
    "t_ns": 2 * 10**9, "start_t_ns": 10**9, "stride_length_m": 1.25, "stride_length_sigma_m": 0.03,
    "stride_duration_s": 1.1, "stride_duration_sigma_s": 0.01, "walking_speed_mps": 1.14,
    "walking_speed_sigma_mps": 0.03,
}  # fmt: skip
LOAD = {
    "t_ns": 2, "start_t_ns": 1, "stance_duration_s": 0.71, "stance_duration_sigma_s": 0.01,
    "peak_force_newton": 210.4, "peak_force_sigma_newton": 6.0, "mean_force_newton": 120.0,
    "mean_force_sigma_newton": 5.0,
}  # fmt: skip
POSE = {
    "t_ns": 2, "since_t_ns": 1, "pos_x_m": 3.0, "pos_x_sigma_m": 0.3, "pos_y_m": -0.5,
    "pos_y_sigma_m": 0.4, "heading_rad": math.pi / 2, "heading_sigma_rad": 0.1,
}  # fmt: skip


@pytest.mark.parametrize(
    ("event", "text"),
    [
        (Stride(**STRIDE), "stride   1.250 +- 0.030 m in 1.10 s, 1.14 m/s"),
        (
            Stride(**STRIDE, height_change_m=-0.34, terrain="stairs-down"),
            "1.14 m/s, -0.34 m higher, stairs-down",
        ),
        (Stride(**STRIDE, style="full-lift"), "1.14 m/s, full-lift"),
        (Load(**LOAD), "load     peak 210 +- 6 N, mean 120 N, 0.71 s on the ground"),
        (
            Load(**LOAD, peak_load_percent=27.6, contact_pitch_rad=-0.35, lift_pitch_rad=0.42),
            "peak 210 +- 6 N (28 % of body weight), mean 120 N, 0.71 s on the ground, pitch -20",
        ),
        (Load(**LOAD, lift_pitch_rad=0.42), "pitch ? to +24 deg"),
        (Pose(**POSE), "pose     3.00 m ahead, -0.50 m left +- 0.50 m, heading +90 deg"),
        (Pose(**POSE, height_m=1.5), "+- 0.50 m, +1.50 m up, heading +90 deg"),
        (
            Turn(
                t_ns=2, start_t_ns=1, turn_duration_s=2.04, turn_duration_sigma_s=0.1,
                turn_angle_rad=-math.pi, turn_angle_sigma_rad=0.05,
            ),
            "turn     180 +- 3 deg to the right in 2.0 s",
        ),
        (
            Push(
                t_ns=2, start_t_ns=1, push_length_m=0.52, push_length_sigma_m=0.02,
                push_duration_s=0.9, push_duration_sigma_s=0.1, peak_speed_mps=0.81,
                peak_speed_sigma_mps=0.1,
            ),
            "push     0.52 +- 0.02 m in 0.9 s, up to 0.81 m/s",
        ),
    ],
)  # fmt: skip
def test_an_event_is_one_readable_line(event, text):
    line = told(event)
    assert line.startswith("03:04:05.678 left ")
    assert "\n" not in line
    assert text in line


def test_every_kind_has_words_of_its_own():
    from gaitway.cli.watch import _WRITERS

    assert set(_WRITERS) == {kind.kind for kind in EVENT_TYPES}
