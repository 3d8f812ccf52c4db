from gaitway.events import Anomaly
from gaitway.recording.items import Dropped, LinkChange
from gaitway.recording.lane import ITEM_BYTES, Lane


def link(number):
    return LinkChange(number, "opening", "")


def bodies(items):
    return [item.body for item in items]


def test_items_come_out_in_the_order_they_went_in():
    lane = Lane()
    lane.put("left", link(1), 1)
    lane.put("right", link(2), 2)
    assert [(item.device, item.body) for item in lane.take()] == [
        ("left", link(1)),
        ("right", link(2)),
    ]
    assert lane.take() == []


def test_a_full_lane_drops_the_newest_and_counts_it_by_topic():
    lane = Lane(max_items=2)
    taken = [lane.put("left", link(number), number) for number in range(4)]
    assert taken == [True, True, False, False]
    assert lane.dropped == {"/left/link": 2}
    assert bodies(lane.take()) == [link(0), link(1)]


def test_what_was_dropped_is_told_ahead_of_the_next_item():
    lane = Lane(max_items=1)
    for number in range(4):
        lane.put("left", link(number), number)
    lane.put("left", Anomaly(t_ns=4, anomaly="x", detail=""), 4)
    lane.take()
    lane.put("left", link(5), 5)
    reason = "the queue of the recorder was full"
    told = Dropped(1, 4, reason, {"/left/link": 3, "/left/anomaly": 1})
    assert bodies(lane.take()) == [told, link(5)]


def test_what_was_dropped_is_told_once():
    lane = Lane(max_items=1)
    lane.put("left", link(0), 0)
    lane.put("left", link(1), 1)
    lane.take()
    lane.put("left", link(2), 2)
    lane.take()
    lane.put("left", link(3), 3)
    assert bodies(lane.take()) == [link(3)]


def test_a_lane_is_full_by_bytes_too_and_empty_again_when_taken(make_chunk):
    lane = Lane(max_bytes=2 * (ITEM_BYTES + 1000))
    big = make_chunk(bytes(1000))
    assert [lane.put("left", big, 0) for _ in range(3)] == [True, True, False]
    lane.take()
    assert lane.put("left", big, 0)


def test_samples_weigh_what_their_arrays_do(make_batch):
    lane = Lane(max_bytes=ITEM_BYTES + 100 * 6 * 8)
    assert not lane.put("left", make_batch(n=101), 0)
    assert lane.put("left", make_batch(n=100), 0)


def test_a_closed_lane_takes_nothing_and_has_told_what_it_dropped():
    lane = Lane(max_items=1)
    lane.put("left", link(0), 0)
    lane.put("left", link(1), 1)
    items = lane.close()
    assert [type(body) for body in bodies(items)] == [LinkChange, Dropped]
    assert not lane.put("left", link(2), 2)
    assert lane.dropped == {"/left/link": 2}
