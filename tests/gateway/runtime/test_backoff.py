from gaitway.runtime.backoff import LONGEST_S, Backoff


def test_waits_double_up_to_a_bound_and_start_again_after_success():
    backoff = Backoff()
    waits = [backoff.next_delay_s() for _ in range(6)]
    assert waits == [0.25, 0.5, 1.0, 2.0, 2.0, 2.0]
    backoff.succeeded()
    assert backoff.next_delay_s() == 0.25


def test_a_cable_put_back_is_tried_well_within_five_seconds():
    assert LONGEST_S <= 2.5
