"""Both nodes in lockstep for very many periods, their memory and open files under watch."""

import os
import shutil
import threading
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from ros_processes import Process, ros_domain

from ur5_ros.bag.reader import open_bag

#: Length of a bag part [s], and time between two looks at the nodes [s].
SPLIT, LOOK = 5.0, 0.25
NODES = ('sim', 'control')


class LongRun:
    """
    A run of both nodes beside whatever else this process does.

    Parameters
    ----------
    folder : pathlib.Path
        For the bags.
    periods : int
        Control periods of 1 ms.

    """

    def __init__(self, folder: Path, periods: int) -> None:
        self.folder, self.periods = folder, periods
        self._stack = ExitStack()
        self._nodes: dict[str, Process] = {}
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self.looks: dict[str, list[tuple[float, int]]] = {name: [] for name in NODES}

    def start(self) -> None:
        """Start the nodes."""
        ros = self._stack.enter_context(ros_domain(self.folder))
        self._nodes = {
            'sim': ros.start('sim', stop_after=self.periods / 1000, max_bagfile_duration=SPLIT,
                             fresh=True),
            'control': ros.start('control', max_bagfile_duration=SPLIT, fresh=True)}
        self._thread.start()

    def finish(self, seconds: float) -> None:
        """Wait for the end, and check how both nodes ended."""
        if not self._nodes:
            self.start()
        sim, control = self._nodes['sim'], self._nodes['control']
        assert sim.ends(seconds) == 0, sim.text
        assert control.stop() == 0, control.text
        self._thread.join()

    def growth(self, node: str) -> tuple[float, int]:
        """Return by how much memory [MiB] and open files of a node grew after a fifth of it."""
        looks = np.array(self.looks[node])
        tenth = max(1, len(looks) // 10)
        early, late = np.median(looks[2 * tenth:3 * tenth], axis=0), np.median(
            looks[-tenth:], axis=0)
        return float(late[0] - early[0]), int(late[1] - early[1])

    def stamps(self, node: str) -> np.ndarray:
        """Return the stamps of all recorded states, each part of the bag checked [ns]."""
        folder = next((self.folder / 'bags').glob(f'*/{node}'))
        assert open_bag(folder).complete
        stamps = []
        for path in sorted(folder.glob('*.mcap'), key=lambda each: int(each.stem.split('_')[-1])):
            part = open_bag(path)
            assert part.check() == [], path.name
            stamps.append(part.joint_states('/joint_states').stamp)
        return np.concatenate(stamps)

    def close(self) -> None:
        """End everything and remove the bags."""
        self._stack.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    def _watch(self) -> None:
        sim, ended = self._nodes['sim'].popen, threading.Event()
        while sim.poll() is None and not ended.wait(LOOK):
            if not any((self.folder / 'bags').glob('*/control/*.mcap')):
                continue  # a node that starts loads what it needs
            for name, process in self._nodes.items():
                try:
                    self.looks[name].append((resident(process.pid), open_files(process.pid)))
                except OSError:
                    return


def resident(pid: int) -> float:
    """Return the resident memory of a process [MiB]."""
    pages = int(Path(f'/proc/{pid}/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 2**20


def open_files(pid: int) -> int:
    """Return how many files a process has open."""
    return len(list(Path(f'/proc/{pid}/fd').iterdir()))
