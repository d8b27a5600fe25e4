"""Reports of a kind go out once in a while; refusals are counted all the same."""

from ur5_ros.throttle import RefusalCount, Throttle


def test_refusals_are_all_counted_and_reported_now_and_then():
    now = [0.0]
    refusals = RefusalCount(lambda: now[0])
    reported = [refusals.add('/topic', 'kind') for _ in range(1000)]
    assert reported == [1] + 999 * [0] and refusals.add('/topic', 'other') == 1
    assert refusals.counts == {('/topic', 'kind'): 1000, ('/topic', 'other'): 1}
    now[0] = 1.0
    assert refusals.add('/topic', 'kind') == 1001 and refusals.add('/topic', 'kind') == 0


def test_a_throttle_lets_a_line_through_again_after_its_time():
    now = [0.0]
    throttle = Throttle(5.0, lambda: now[0])
    assert throttle('a')
    assert throttle('b')
    now[0] = 4.9
    assert not throttle('a')
    now[0] = 5.0
    assert throttle('a')
