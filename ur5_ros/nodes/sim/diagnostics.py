"""Diagnostics of the simulator once a second, and the other nodes on its topics."""

import json
from typing import TYPE_CHECKING, Any

from ur5_ros.cdr.diagnostics import ERROR, OK, WARN
from ur5_ros.nodes.ros.diagnostics import network
from ur5_ros.nodes.ros.topics import incompatible_publishers, publishing_nodes

if TYPE_CHECKING:
    from ur5_ros.nodes.sim.node import SimNode


def check_publishers(sim: 'SimNode') -> None:
    """Look for the publishers of commands and for incompatible ones; report them to the loop."""
    names = {topic: publishing_nodes(sim.node, topic) for topic in sim.inputs.command_topics}
    incompatible = incompatible_publishers(sim.node, sim.topics)
    simulators = publishing_nodes(sim.node, sim.topics.names['joint_states'])

    def report_found() -> None:
        sim.gate.publishers(names)
        sim.second_simulator = simulators[-1] if len(simulators) > 1 else ''
        sim.publishers_conflict |= sum(map(len, names.values())) > 1
        for sentence in incompatible:
            sim.inputs.refuse(*sentence)

    sim.inputs.requests.post(report_found)


def counters(sim: 'SimNode') -> dict[str, Any]:
    """Return what was counted so far."""
    gate = sim.gate
    return {
        'commands_taken': gate.accepted,
        'commands_copied': sim.inputs.copies,
        'commands_without_torque': gate.empty,
        **{f'refused {topic}: {kind}': count for (topic, kind), count in (
            gate.refused | sim.inputs.refusals.counts).items()},
        **sim.simulation.plant.counters,
        'lockstep_fired': gate.fired,
        'late_periods': gate.pacer.late,
        'worst_lateness_s': round(gate.pacer.worst, 6),
        'schedule_lost_s': round(gate.pacer.lost, 6),
    }


def report(sim: 'SimNode') -> None:
    """Send the diagnostics, and once more what a controller that has joined must know."""
    sim.outputs.introduce_again()
    plant, gate, recording = sim.simulation.plant, sim.gate, sim.recording
    level, word = OK, 'running'
    if recording.failure:
        level, word = ERROR, f'not recording: {recording.failure}'
    elif plant.stopped:
        level, word = ERROR, 'protective stop; call ~/reset'
    elif not gate.repeatable:
        level, word = WARN, 'running, not repeatable'
    elif sim.simulation.paused:
        word = 'paused'
    elif not gate.accepted:
        word = f'waiting for the first command on {" or ".join(sim.inputs.command_topics)}'
        if sim.waiting_line('waiting'):
            sim.logger.info(f'{word}; {network()}')
    values = {
        'run': sim.run_name, 'state': plant.k, 'paused': sim.simulation.paused,
        'repeatable': gate.repeatable, **counters(sim),
        'bag': str(sim.recording.folder or ''), 'bag_lost': recording.lost}
    sim.outputs.diagnostics(plant.stamp, level, word, {
        key: value if isinstance(value, str) else json.dumps(value)
        for key, value in values.items()})
