"""Write pages of docs/reference from the code; test/docs compares them."""

import math
from pathlib import Path

from python_page import page as python
from typer.main import get_command

from ur5_ros.config.parameters import CONTROL_PARAMETERS, SIM_PARAMETERS, Parameter
from ur5_ros.config.topics import CONTROL_TOPICS, SIM_TOPICS, WORLD_TOPICS, Topic

HERE = Path(__file__).resolve().parent


def parameters() -> str:
    """Return the page of the two nodes' parameters."""
    lines = [
        '# Parameters', '',
        'Written by `docs/generate.py` from `ur5_ros/config/parameters.py`. Live parameters can '
        'be changed while the node runs (`ros2 param set`); each change is checked, recorded as '
        'an event, and acts from the next period. Lists: 1 number stands for all six joints where '
        '1 is among the sizes.', '']
    for title, declared in (('`sim_node` (`/ur5_sim`)', SIM_PARAMETERS),
                            ('`control_node` (`/ur5_control`)', CONTROL_PARAMETERS)):
        lines += [f'## {title}', '', '| name | default | range | live | meaning |',
                  '|---|---|---|---|---|']
        lines += [_row(parameter) for parameter in declared]
        lines.append('')
    return '\n'.join(lines)


def _row(parameter: Parameter) -> str:
    default = parameter.default
    if isinstance(default, list):
        shown = '[' + ', '.join(f'{x:.4g}' for x in default) + ']'
    else:
        shown = repr(default) if isinstance(default, str) else str(default).lower()
    if parameter.choices:
        span = ', '.join(parameter.choices)
    elif math.isfinite(parameter.lower):
        span = f'{parameter.lower:g} to {parameter.upper:g}'
        if parameter.sizes:
            span += '; ' + ' or '.join(str(size) for size in parameter.sizes) + ' numbers'
    else:
        span = ''
    live = 'yes' if parameter.live else ''
    return f'| `{parameter.name}` | `{shown}` | {span} | {live} | {parameter.description} |'


def topics() -> str:
    """Return the page of topics: the one that is there, with the tables as they are declared."""
    text = (HERE / 'reference/topics.md').read_text(encoding='utf-8')
    for node, declared in (('sim', (*SIM_TOPICS, *WORLD_TOPICS)), ('control', CONTROL_TOPICS)):
        lines = ['| | name | type | unit | QoS | notes |', '|---|---|---|---|---|---|']
        lines += [_topic_row(topic) for topic in declared]
        begin, end = f'<!-- topics of {node}_node -->\n\n', '\n\n<!-- end -->'
        before, _, rest = text.partition(begin)
        text = before + begin + '\n'.join(lines) + end + rest.partition(end)[2]
    return text


def _topic_row(topic: Topic) -> str:
    name = topic.name if topic.name[0] in '~/' else '/' + topic.name
    qos = topic.qos
    words = [qos.reliability.replace('_', ' ')]
    words += ['latched'] if qos.durability == 'transient_local' else []
    words.append(f'keep last {qos.depth}')
    rest = f'{topic.unit} | {", ".join(words)} | {topic.notes}'
    direction, kind = 'out' if topic.published else 'in', topic.type.replace('/msg', '')
    return (f'| {direction} | `{name}` | {kind} | {rest} |')


def cli() -> str:
    """Return the page of the command ``ur5``."""
    from ur5_ros.cli.app import app
    command = get_command(app)
    lines = ['# The command `ur5`', '',
             'Written by `docs/generate.py` from `ur5_ros/cli`. ' + (command.help or ''), '',
             'Exit code 0: passed, or done. 1: judged and failed, or the two differ. 2: bad input '
             'or nothing readable. 3: done, with loss. 4: an internal error.', '']
    for name, each in command.commands.items():
        if each.hidden:
            continue
        said = ' '.join((each.help or '').split())
        lines += [f'## ur5 {name}', '', said, '', '| | | default |', '|---|---|---|']
        for parameter in each.params:
            lines.append(_option(parameter))
        lines.append('')
    return '\n'.join(lines)


def _option(parameter) -> str:
    if parameter.param_type_name == 'argument':
        name = parameter.metavar or parameter.name.upper()
    else:
        name = ', '.join(parameter.opts + parameter.secondary_opts)
        if parameter.metavar and not parameter.is_flag:
            name += f' {parameter.metavar}'
    default = parameter.default
    shown = '' if default in (None, False, ()) or callable(default) else f'`{default}`'
    text = (getattr(parameter, 'help', '') or '').replace('|', '\\|')
    return f'| `{name.replace("|", "/")}` | {text} | {shown} |'


PAGES = {'parameters.md': parameters, 'topics.md': topics, 'cli.md': cli, 'python.md': python}


def main() -> None:
    """Write the pages."""
    for name, page in PAGES.items():
        (HERE / 'reference' / name).write_text(page(), encoding='utf-8')


if __name__ == '__main__':
    main()
