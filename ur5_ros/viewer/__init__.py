"""Pictures of a run: in the browser (``ur5 view``) and off screen (``ur5 render``)."""

import signal
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ur5_ros.errors import InputError

if TYPE_CHECKING:
    from ur5_ros.viewer.live import LiveView
    from ur5_ros.viewer.recorded import RecordedView


def view(run: Path | None = None, live: bool = False, port: int = 8080,
         reading: Mapping[str, Any] | None = None) -> None:
    """
    Serve a page with the arm on 127.0.0.1 until interrupted.

    ``run``: run folder; the newest below ``bags/`` if none is given; ``port``: port to serve on;
    the next free one where it is taken, any free one for 0.
    """
    if find_spec('viser') is None:
        raise InputError('the viewer needs viser; in the checkout: make setup, or pip install '
                         "'.[view]'")
    if not 0 <= port <= 65535:
        raise InputError(f'--port {port}; ports go from 1 to 65535, 0 takes any that is free')
    if live and run is not None:
        raise InputError('--live shows what runs now; leave out the run')
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # ends as Ctrl-C does
    viewer = _live(port) if live else _recorded(run, port, reading or {})
    if port not in (0, viewer.page.port):
        print(f'port {port} is taken; {viewer.page.port} is used')
    print(f'{viewer.page.address}  (Ctrl-C ends)', flush=True)
    viewer.serve()


def _live(port: int) -> 'LiveView':
    from ur5_ros.nodes.ros.environment import check_environment
    check_environment()  # the middleware is loaded with the next import
    from ur5_ros.viewer.live import LiveView
    return LiveView(port)


def _recorded(run: Path | None, port: int, reading: Mapping[str, Any]) -> 'RecordedView':
    from ur5_ros.analysis.data.load import load_run
    from ur5_ros.bag.run_folders import newest_run
    from ur5_ros.viewer.recorded import RecordedView
    return RecordedView(load_run(run or newest_run(Path('bags')), **reading), port)
