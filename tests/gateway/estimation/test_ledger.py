import math

import pytest

from gaitway.estimation import WalkLedger
from gaitway.events import Anomaly, Bout, Distance, Stride

S = 1_000_000_000


def ledger(**changes):
    return WalkLedger(
        **{"max_pause_s": 3.0, "shared_sigma": 0.0, "stride_time_sigma_s": 0.01} | changes
    )


def walk(books, count, *, start_s=0, length_m=0.5, sigma_m=0.02):
    events = []
    for number in range(count):
        at_s = start_s + number
        events += books.add_stride(at_s * S, (at_s + 1) * S, length_m, sigma_m)
    return events


def only(kind, events):
    return [event for event in events if isinstance(event, kind)]


def test_the_first_stride_opens_a_bout_and_each_is_followed_by_the_distance():
    kinds = [event.kind for event in walk(ledger(), 2)]
    assert kinds == ["bout", "stride", "distance", "stride", "distance"]


def test_distance_is_the_sum_and_independent_errors_add_as_squares():
    last = only(Distance, walk(ledger(), 25))[-1]
    assert last.distance_m == pytest.approx(12.5)
    assert last.distance_sigma_m == pytest.approx(5 * 0.02)
    assert last.strides == 25
    assert last.walking_s == 25.0


def test_what_all_strides_share_grows_with_the_distance_itself():
    last = only(Distance, walk(ledger(shared_sigma=0.01), 100, sigma_m=0.0))[-1]
    assert last.distance_sigma_m == pytest.approx(0.01 * 50.0)


def test_time_without_a_measure_widens_sigma_and_adds_no_distance():
    books = ledger(unseen_speed_mps=0.5)
    before = only(Distance, walk(books, 2))[-1]
    books.add_unmeasured(4.0)
    after = books.distance(3 * S)
    assert after.distance_m == before.distance_m
    assert after.unmeasured_s == 4.0
    assert after.distance_sigma_m == pytest.approx(math.hypot(before.distance_sigma_m, 2.0))


def test_a_pause_ends_the_bout_at_its_last_stride():
    books = ledger()
    walk(books, 4)
    assert books.advance(7 * S) == []
    (bout,) = books.advance(7 * S + 1)
    assert isinstance(bout, Bout)
    assert (bout.phase, bout.t_ns, bout.strides) == ("end", 4 * S, 4)
    assert bout.duration_s == 4.0
    assert bout.walking_speed_mps == pytest.approx(0.5)
    assert bout.cadence_spm == pytest.approx(60.0)
    assert not books.in_bout


def test_walking_again_after_a_pause_begins_another_bout_and_the_distance_goes_on():
    books = ledger()
    walk(books, 3)
    events = walk(books, 2, start_s=10)
    assert [event.phase for event in only(Bout, events)] == ["end", "start"]
    assert only(Distance, events)[-1].distance_m == pytest.approx(2.5)
    assert only(Distance, events)[-1].walking_s == 5.0


def test_a_strides_speed_carries_the_errors_of_length_and_time():
    (stride,) = only(Stride, ledger().add_stride(0, 2 * S, 1.0, 0.1, swing_duration_s=0.8))
    assert stride.walking_speed_mps == 0.5
    time_share = 0.5 * math.sqrt(2) * 0.01 / 2.0
    assert stride.walking_speed_sigma_mps == pytest.approx(math.hypot(0.05, time_share))
    assert stride.swing_duration_sigma_s == stride.stride_duration_sigma_s
    assert stride.stance_duration_s is None
    assert stride.stance_duration_sigma_s is None


def test_time_unmeasured_for_which_strides_count_widens_nothing_by_itself():
    ledger = WalkLedger(max_pause_s=3.0, shared_sigma=0.0, stride_time_sigma_s=0.02)
    ledger.begin(0)
    ledger.add_unmeasured(2.0, speed_sigma_mps=0.0)
    distance = ledger.distance(2_000_000_000)
    assert (distance.unmeasured_s, distance.distance_sigma_m) == (2.0, 0.0)


def test_a_stride_may_share_its_error_by_another_measure_than_the_rest():
    books = ledger(shared_sigma=0.01)
    books.add_stride(0, S, 10.0, 0.0)
    events = books.add_stride(S, 2 * S, 10.0, 0.0, shared_sigma=0.002)
    assert only(Stride, events)[0].stride_length_sigma_m == pytest.approx(0.02)
    assert only(Distance, events)[0].distance_sigma_m == pytest.approx(0.12)
    assert only(Bout, books.close_bout())[0].distance_sigma_m == pytest.approx(0.12)


def test_time_without_a_measure_that_goes_on_is_one_time():
    pieces, whole = ledger(), ledger()
    for ongoing in (False, True, True):
        pieces.add_unmeasured(2.0, ongoing=ongoing)
    whole.add_unmeasured(6.0)
    assert pieces.distance(S) == whole.distance(S)


def test_a_distance_that_is_of_no_use_says_so_once():
    books = ledger()
    told = walk(books, 2)
    books.add_unmeasured(20.0)
    told += walk(books, 4, start_s=2)
    doubts = [event for event in told if isinstance(event, Anomaly)]
    assert [(doubt.anomaly, doubt.t_ns) for doubt in doubts] == [("distance-untrusted", 3 * S)]
