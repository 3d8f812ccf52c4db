import pytest

from gaitway.estimation import ClipDetector, ImuSample


def verdicts(values, *, flagged=False):
    detector = ClipDetector()
    return [
        detector.push(ImuSample(i, (value, 0.1 * i, 0.2), (0.0, 0.0, 0.0), flagged, bridged=False))
        for i, value in enumerate(values)
    ]


def test_a_plateau_at_the_end_of_a_range_is_clipping():
    assert verdicts([14.0, 14.7, 14.7, 14.7, 13.0]) == [False, False, False, True, False]


@pytest.mark.parametrize("values", [[9.8] * 6, [14.7, 14.6, 14.7, 14.6]], ids=["low", "varied"])
def test_equal_readings_far_from_any_end_and_unequal_ones_are_not(values):
    assert not any(verdicts(values))


def test_what_the_device_says_counts():
    assert verdicts([1.0], flagged=True) == [True]
