"""The page that viser serves, with what it lacks: silence, the system's colours, a narrow form."""

import contextlib
import io
import json
import os
from pathlib import Path
from typing import Any

import viser
from viser import infra

Point = tuple[float, float, float]
View = tuple[Point, Point]

HERE = Path(__file__).resolve().parent


class Server:
    """
    A viser server on 127.0.0.1 whose page carries ``client.js`` and ``client.css``.

    Parameters
    ----------
    title : str
        Name of the page.
    port : int
        Wanted port; the next free one is taken.
    wide, upright : tuple of two points (3,)
        Where the camera stands and what it looks at [m], by the form of the window.

    """

    def __init__(self, title: str, port: int, wide: View, upright: View):
        def serve(*, http_server_root: Path, **more) -> infra.WebsockServer:
            text = (http_server_root / 'index.html').read_text(encoding='utf-8')
            folder: Any = _Folder(completed(text, upright).encode())
            return infra_server(http_server_root=folder, **more)

        # viser lets nobody name another page, so its server is given one while it is made
        infra_server = infra.WebsockServer
        infra.WebsockServer = serve  # type: ignore[assignment, misc]
        try:
            with contextlib.redirect_stdout(io.StringIO()):  # it draws a box of its own
                self.viser = viser.ViserServer(host='127.0.0.1', port=port, label=title,
                                               verbose=False)
        finally:
            infra.WebsockServer = infra_server  # type: ignore[misc]
        camera = self.viser.initial_camera
        camera.position, camera.look_at = wide

    def close(self) -> None:
        """Stop serving."""
        with contextlib.redirect_stdout(io.StringIO()):
            self.viser.stop()


class _Folder:
    """A folder with one page, as far as viser's file server asks: nothing to leave on a disk."""

    def __init__(self, page: bytes):
        self._page = page

    def __truediv__(self, name: str) -> Any:
        return self if name == 'index.html' else Path(os.devnull) / name

    def is_file(self) -> bool:
        return True

    def read_bytes(self) -> bytes:
        return self._page


def completed(page: str, upright: View) -> str:
    """
    Return viser's page with the script and the style of this folder ahead of its own.

    Parameters
    ----------
    page : str
        The page as viser ships it.
    upright : tuple of two points (3,)
        Where the camera stands and what it looks at in an upright window [m].

    Returns
    -------
    str
        The page to serve.

    Raises
    ------
    RuntimeError
        If the page is not of the known form.

    """
    head, mark, rest = page.partition('<title>Viser</title>')
    if not mark:
        raise RuntimeError(f'viser {viser.__version__} has another page than 1.1')
    script, style = ((HERE / name).read_text(encoding='utf-8')
                     for name in ('client.js', 'client.css'))
    view = json.dumps({'initialCameraPosition': upright[0], 'initialCameraLookAt': upright[1]})
    return (f'{head}<title>ur5</title>\n<script>\nconst UPRIGHT = {view};\n{script}</script>\n'
            f'<style>\n{style}</style>{rest}')
