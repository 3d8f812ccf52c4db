from gaitway.runtime.link_state import TRANSITIONS, LinkSignal, LinkState


def test_every_state_can_be_reached():
    reached = {LinkState.CLOSED}
    while True:
        further = {after for state in reached for after in TRANSITIONS[state].values()}
        if further <= reached:
            break
        reached |= further
    assert reached == set(LinkState)


def test_every_open_state_can_stop():
    for state in set(LinkState) - {LinkState.CLOSED}:
        assert TRANSITIONS[state][LinkSignal.STOP] is LinkState.CLOSED


def test_only_samples_make_a_link_streaming():
    into = {
        signal
        for ways in TRANSITIONS.values()
        for signal, after in ways.items()
        if after is LinkState.STREAMING
    }
    assert into == {LinkSignal.SAMPLES}
