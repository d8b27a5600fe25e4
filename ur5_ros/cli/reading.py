"""Options of the commands that read recordings, as arguments of ``load_run``."""

from typing import Any

from ur5_ros.errors import InputError


def reading_options(
    topics: list[str] | None, joint_prefix: str | None, effort: str | None,
    arm: str | None = None, control_arm: str | None = None, kp: str | None = None,
    kd: str | None = None,
) -> dict[str, Any]:
    """Return the arguments of ``load_run`` that were given; InputError for a wrong one."""
    from ur5_ros.analysis.data.options import check_effort_meaning, parse_topics
    from ur5_ros.analysis.data.topic_roles import ROLE_FIELDS
    check_effort_meaning(effort)
    given = {
        'topics': parse_topics(topics, ROLE_FIELDS) or None, 'joint_prefix': joint_prefix,
        'effort': effort, 'arm': arm, 'control_arm': control_arm, 'kp': _gain('--kp', kp),
        'kd': _gain('--kd', kd)}
    return {key: value for key, value in given.items() if value is not None}


def showing_options(topics: list[str] | None, joint_prefix: str | None,
                    arm: str | None) -> dict[str, Any]:
    """Return the same where the arm is used only if the bag names none."""
    return {**reading_options(topics, joint_prefix, None, arm), 'keep_arm': True}


def _gain(option: str, text: str | None) -> list[float] | None:
    if text is None:
        return None
    try:
        values = [float(part) for part in text.replace(',', ' ').split()]
    except ValueError:
        values = []
    if len(values) not in (1, 6, 36):
        raise InputError(f'{option} {text!r}: give 1, 6 or 36 numbers, separated by commas')
    return values
