"""Is the recording whole, does every state have its answer, are the stamps in step?"""

import numpy as np

from ur5_ros.analysis.data.run import Run
from ur5_ros.analysis.result import FAIL, PASS, Check, judge, not_applicable
from ur5_ros.config.validation import Marks
from ur5_ros.wording import agree, number_of

#: States on either side of a step that distinguish a missing state from jitter.
NEAR_STATES = 8


def recording_check(run: Run) -> Check:
    """Return whether both bags are complete, and if not why."""
    if not run.problems:
        count = len(run.stamp)
        dropped = '' if run.dropped is None or not len(run.dropped) else (
            f' of {count + len(run.dropped)}, {len(run.dropped)} dropped')
        remarks = ''.join(f'; {remark}' for remark in run.remarks)
        return Check('recording', PASS, f'whole: {count} states{dropped} over {run.t[-1]:.3f} s'
                     f'{remarks}', details={'remarks': list(run.remarks)})
    more = f' ({len(run.problems) - 1} more)' if len(run.problems) > 1 else ''
    return Check('recording', FAIL, f'incomplete, judged to the last whole record: '
                 f'{run.problems[0]}{more}', float(len(run.problems)), 0.0, 'problems',
                 {'problems': list(run.problems), 'remarks': list(run.remarks)})


def repeatability_check(run: Run) -> Check:
    """Return whether the run claims to repeat to the last bit: one law, always waited for."""
    name = 'repeatability'
    if run.sim is None:
        return not_applicable(name, "not a bag of this package's simulator")
    if not run.sim.parameters['lockstep']:
        return not_applicable(name, 'paced by the clock: none is claimed')
    summary = run.sim.summary
    reasons = [reason for key, reason in (
        ('lockstep_fired', 'an answer did not come in time and the fallback took over'),
        ('publishers_conflict', 'several publishers sent commands')) if summary.get(key)]
    if reasons or summary.get('repeatable') is False:
        return not_applicable(name, 'none is claimed: ' + (
            '; '.join(reasons) or 'the simulator says so'))
    if not summary:
        return not_applicable(name, 'the simulator did not come to its end')
    return Check(name, PASS, 'in lockstep throughout, one publisher: the same run gives the same '
                 'bits', details={'hashes': dict(summary.get('hashes') or {})})


def pairing_check(run: Run, marks: Marks) -> Check:
    """Return whether each state has an answer and each answer a state."""
    counts = dict(run.counts)
    if run.command is None:
        return not_applicable('pairing', 'no stamped commands are recorded: nothing to pair',
                              **counts)
    answered = np.isfinite(run.command).all(axis=1)
    missing = int((~answered).sum())
    orphans = counts.get('answers_without_state', 0)
    details = {**counts, 'states': len(answered), 'answered': int(answered.sum()),
               'states_without_answer': missing}
    if counts.get('commands_held'):
        under = int(answered.sum())
        held = number_of(counts['commands_held'], 'command')
        return Check('pairing', PASS if under else FAIL, f'{held} at '
                     f'their own rate, each acts until the next: {under} of {len(answered)} '
                     'periods under one', details=details)
    if orphans:
        return Check('pairing', FAIL, f'{number_of(orphans, "answer")} '
                     f'{agree(orphans, "belong")} to no recorded state; '
                     f'{number_of(missing, "state")} without an answer',
                     float(orphans), 0.0, 'answers', details)
    where, by_order = '', ''
    if counts.get('answers_paired_by_order'):
        by_order = '; commands without a stamp, paired by their order'
    if missing:
        first = int(np.argmin(answered))
        where = f'; the first without is state {first + 1} at {run.stamp[first] * 1e-9:.6g} s'
    return judge('pairing', missing, marks['unanswered'], 'states',
                 f'{answered.sum()} of {len(answered)} states have their answer{where}{by_order}',
                 **details)


def timing_check(run: Run, marks: Marks) -> Check:
    """Return whether the stamps advance by one period each; with the latency where known."""
    period, steps = 1e9 / run.control_rate, np.diff(run.stamp)
    gap = _gaps(run, marks, steps, period)
    gaps, back = int(gap.sum()), int(run.counts.get('stamps_back', 0))
    regular = steps[~gap]
    jitter = float(np.std(regular)) * 1e-9 if run.sim is None and regular.size else 0.0
    details = {'period_s': run.h, 'gaps': gaps, 'stamps_back': back, 'jitter_s': jitter,
               'largest_step_s': float(steps.max(initial=0)) * 1e-9, **latency(run)}
    late = f'; the stamps jitter by {jitter * 1e3:.3g} ms RMS' if jitter > 1e-6 else ''
    if 'latency_p50_s' in details:
        p50, p99, most = (1e3 * details[f'latency_{each}_s'] for each in ('p50', 'p99', 'max'))
        late += (f'; state to command {p50:.3g} ms (p50), {p99:.3g} ms (p99), {most:.3g} ms (max) '
                 'of wall clock')
    if back:
        return Check('timing', FAIL, f'{number_of(back, "stamp")} {agree(back, "go")} back{late}',
                     float(back), 0.0, 'stamps', details)
    if gaps:
        row = int(np.argmax(gap))
        at = run.t[row] if run.sim is None else run.stamp[row] * 1e-9
        return judge('timing', gaps, 0.0, 'gaps',
                     f'{number_of(gaps, "gap")}; the first after {at:.6g} s: '
                     f'{steps[row] * 1e-9:.6g} s instead of {run.h:.6g} s{late}', **details)
    if paced := _lateness(run):
        details |= paced
        share = max(paced['late_share'], paced['fallback_share'])
        if share > marks['late']:
            return judge('timing', share, marks['late'], '1',
                         f'{paced["late"]} of {len(run.stamp)} periods began late, '
                         f'{paced["fallback"]} passed under the fallback{late}', **details)
        late = (f'; {number_of(int(paced["late"]), "period")} began late, {paced["fallback"]} '
                f'passed under the fallback{late}')
    return judge('timing', gaps, 0.0, 'gaps',
                 f'every state follows the one before by {run.h * 1e3:.6g} ms{late}', **details)


def _gaps(run: Run, marks: Marks, steps: np.ndarray, period: float) -> np.ndarray:
    """
    Return which steps of the stamps are no period, shape (n - 1,).

    Of a robot's own clock only missing states are gaps, and only those that were not recorded.

    """
    if run.sim is not None:
        return np.abs(steps - period) > max(2.0, marks['period'] * period)
    if run.dropped is not None and len(run.dropped):
        steps = steps - np.diff(np.searchsorted(run.dropped, run.stamp)) * period
    missing = np.rint(steps / period) - 1
    return np.where(missing == 1, np.rint(_lasting(steps, period)), missing) > 0


def _lasting(steps: np.ndarray, period: float) -> np.ndarray:
    """
    Return by how many periods the states after each step are late, those near it taken together.

    Of jitter alone the next steps are shorter again; after a missing state they are not.

    """
    late = np.concatenate([[0.0], np.cumsum(np.where(steps < 2.5 * period, steps - period, 0.0))])
    total = np.concatenate([[0.0], np.cumsum(late)])
    row = np.arange(1, len(late))
    first, last = np.maximum(row - NEAR_STATES, 0), np.minimum(row + NEAR_STATES, len(late))
    before = (total[row] - total[first]) / (row - first)
    after = (total[last] - total[row]) / (last - row)
    return (after - before) / period


def _lateness(run: Run) -> dict[str, float]:
    """Return late periods and periods under the fallback of a run that was paced by the clock."""
    if run.sim is None or run.sim.parameters['lockstep']:
        return {}
    counters = run.sim.summary.get('counters') or {}
    late, fallback = int(counters.get('late_periods', 0)), fallback_periods(run)
    return {'late': late, 'late_share': late / len(run.stamp), 'fallback': fallback,
            'fallback_share': fallback / len(run.stamp)}


def fallback_periods(run: Run) -> int:
    """Return the periods under the fallback between the first command and the last one."""
    total, begin = 0.0, None
    for event in run.events:
        if event.kind != 'fallback':
            continue
        if event.values.get('active'):
            begin = event.stamp if begin is None else begin
        elif begin is not None:
            if begin > run.stamp[0]:
                total += event.stamp - begin
            begin = None
    return round(total * 1e-9 * run.control_rate)


def latency(run: Run) -> dict[str, float]:
    """
    Return the wall-clock delay from a state to its answer, as in the simulator's bag.

    ``latency_p50_s``, ``latency_p99_s``, ``latency_max_s`` and ``late_periods``: answers that
    arrived after the next state had been sent.  Empty where times are not recorded.

    """
    delay = delays(run)
    if not delay.size or run.state_time is None or run.command_time is None:
        return {}
    answered = (run.command_time[:-1] > 0)
    late = int((run.command_time[:-1] > run.state_time[1:])[answered].sum())
    p50, p99 = np.percentile(delay, [50, 99])
    return {'latency_p50_s': float(p50), 'latency_p99_s': float(p99),
            'latency_max_s': float(delay.max()), 'late_periods': late}


def delays(run: Run) -> np.ndarray:
    """Return the wall-clock delay from state to answer [s] of the states that have both."""
    if run.state_time is None or run.command_time is None:
        return np.zeros(0)
    both = (run.command_time > 0) & (run.state_time > 0)
    return (run.command_time[both] - run.state_time[both]) * 1e-9
