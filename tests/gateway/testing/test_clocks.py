import asyncio

from gaitway.testing.clocks import ManualClock


def test_time_stands_still_until_it_is_moved_on_both_clocks():
    clock = ManualClock(t_ns=5, wall_ns=7)
    assert (clock.now_ns(), clock.wall_ns()) == (5, 7)
    clock.advance(1.5)
    assert (clock.now_ns(), clock.wall_ns()) == (1_500_000_005, 1_500_000_007)


def test_setting_the_wall_clock_moves_it_alone():
    clock = ManualClock(t_ns=5, wall_ns=7)
    clock.step_wall(-1.0)
    assert (clock.now_ns(), clock.wall_ns()) == (5, 7 - 1_000_000_000)


async def test_sleeping_passes_at_once_and_lets_others_run():
    clock = ManualClock(t_ns=0)
    heard = []

    async def other():
        heard.append(clock.now_ns())

    task = asyncio.create_task(other())
    await clock.sleep(3600.0)
    assert heard == [3600 * 10**9]
    await task
