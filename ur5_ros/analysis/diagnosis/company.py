"""Other nodes on the topics of a run: a second simulator, a second controller."""

from collections.abc import Sequence
from typing import Any

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.result import FAIL, Check
from ur5_ros.wording import number_of

#: Checks that fail where states or commands of two runs meet.
MET = ('pairing', 'timing', 'command acts', 'law')
#: Why the simulator refuses the answer to a state of another one.
FOREIGN = 'stamp of a state not yet published'
_WAY_OUT = 'keep one in a ROS_DOMAIN_ID'


def company(run: Run, checks: Sequence[Check]) -> list[dict[str, Any]]:
    """Return who else was on the topics, where that can be why a check fails."""
    if not any(check.name in MET and check.verdict == FAIL for check in checks):
        return []
    counters = {} if run.control is None else run.control.summary.get('counters') or {}
    foreign = max((int(event.values.get('count', 0)) for event in run.events
                   if event.kind == 'refused' and event.values.get('reason') == FOREIGN),
                  default=0)
    if foreign or any(name.endswith(': two robots') for name in counters):
        answers = (f'; {number_of(foreign, "command")} for states that it had not published '
                   'reached this one' if foreign else '')
        return [{'kind': 'two simulators', 'sentence': 'a second simulator published states on '
                 f'the same topic{answers}; {_WAY_OUT}'}]
    several = [event for event in run.events if event.kind == 'publishers']
    return [{'kind': 'two controllers', 'sentence': f'{several[0].message}; {_WAY_OUT}'}
            ] if several else []
