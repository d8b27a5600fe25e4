"""Draw the pictures of docs/try_ur_torque_code.md from the bags that its commands record."""

import sys
from pathlib import Path

import numpy as np

from ur5_ros import load_run

HERE = Path(__file__).resolve().parent
WIDTH, HEIGHT, MARGIN = 720, 260, 46
COLOURS = {'ideal': '#8a8a8a', 'robot': '#d1495b', 'warm': '#edae49', 'repaired': '#00798c'}
LABELS = {'ideal': 'ideal', 'robot': 'as the robot is', 'warm': 'warm robot',
          'repaired': 'repaired, warm robot'}


def drawing(title: str, unit: str, curves: dict[str, tuple[np.ndarray, np.ndarray]]) -> str:
    """Return curves over time [s] as an SVG picture."""
    low, high = (float(edge([edge(y) for _, y in curves.values()])) for edge in (np.min, np.max))
    step = next(size for size in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5) if (high - low) / size <= 5.0)
    ticks = step * np.arange(np.floor(low / step + 1e-6), np.ceil(high / step) + 1)
    low, high = float(ticks[0]), float(ticks[-1])
    end = max(float(t[-1]) for t, _ in curves.values())

    def x(t):
        return MARGIN + (WIDTH - 2 * MARGIN) * t / end

    def y(value):
        return HEIGHT - MARGIN - (HEIGHT - 2 * MARGIN) * (value - low) / (high - low)

    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
             'font-family="sans-serif" font-size="12">',
             f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
             f'<text x="{MARGIN}" y="18" font-weight="bold">{title}</text>']
    for value in ticks:
        lines += [f'<line x1="{MARGIN}" x2="{WIDTH - MARGIN}" y1="{y(value):.1f}" '
                  f'y2="{y(value):.1f}" stroke="#dddddd"/>',
                  f'<text x="{MARGIN - 4}" y="{y(value) + 4:.1f}" text-anchor="end">'
                  f'{value:.2f}</text>']
    for second in range(round(end) + 1):
        lines.append(f'<text x="{x(second):.1f}" y="{HEIGHT - MARGIN + 16}" '
                     f'text-anchor="middle">{second} s</text>')
    for place, (name, (t, values)) in enumerate(curves.items()):
        points = ' '.join(f'{x(a):.1f},{y(b):.1f}' for a, b in zip(t, values, strict=True))
        lines += [f'<polyline points="{points}" fill="none" stroke="{COLOURS[name]}" '
                  'stroke-width="1.5"/>',
                  f'<text x="{MARGIN + 160 * place}" y="{HEIGHT - 8}" fill="{COLOURS[name]}">'
                  f'{LABELS[name]}</text>']
    lines.append(f'<text x="{WIDTH - MARGIN}" y="18" text-anchor="end">{unit}</text></svg>')
    return '\n'.join(lines) + '\n'


def main(folder: Path) -> None:
    """Draw the motion of the elbow and the speed of the pan."""
    runs = {name: load_run(folder / name) for name in LABELS}
    way = {name: (run.t[::10], (run.exact.q[:, 2] - run.exact.q[0, 2])[::10])
           for name, run in runs.items() if name != 'warm'}
    speed = {name: (run.t[::10], run.exact.qd[::10, 0]) for name, run in runs.items()
             if name != 'ideal'}
    (HERE / 'pictures' / 'torque_dead_zone.svg').write_text(
        drawing('Dead zone: the elbow under a small torque', 'rad', way))
    (HERE / 'pictures' / 'torque_vibration.svg').write_text(
        drawing('Vibration: the shoulder pan after a step aside', 'rad/s', speed))


if __name__ == '__main__':
    main(Path(sys.argv[1]))
