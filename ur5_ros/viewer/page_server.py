"""The page that viser serves, completed by a script and a style of this folder, on one port."""

import contextlib
import http.client
import io
import json
import socket
import socketserver
import threading
from pathlib import Path

import viser

from ur5_ros.errors import InputError

Point = tuple[float, float, float]
View = tuple[Point, Point]

HERE = Path(__file__).resolve().parent
HOST = '127.0.0.1'
#: How many ports above the given one are tried.
PORTS = 100
#: Largest head of a request that is read [bytes].
MAX_HEAD = 1 << 16


class PageServer:
    """
    A viser server on 127.0.0.1 whose page carries ``page.js`` and ``page.css``.

    viser's own server listens on a port of its own. This one answers the request for the page
    and passes every other connection on.

    ``port``: port to serve on; the next free one where it is taken, any free one for 0; ``wide``,
    ``upright``: where the camera stands and what it looks at [m], in a wide and in an upright
    window.

    Attributes
    ----------
    port : int
        Port that is served on.

    """

    def __init__(self, title: str, port: int, wide: View, upright: View):
        self._front = _listen(port)
        with contextlib.redirect_stdout(io.StringIO()):  # it prints a box
            self.viser = viser.ViserServer(host=HOST, port=0, label=title, verbose=False)
        self.viser.initial_camera.position, self.viser.initial_camera.look_at = wide
        inner = self.viser.get_port()
        self._front.inner = inner
        self._front.page = completed(_fetch(inner), upright).encode()
        self.port = self._front.server_address[1]
        threading.Thread(target=self._front.serve_forever, args=(0.05,), daemon=True).start()

    def close(self) -> None:
        """Stop serving."""
        self._front.shutdown()
        self._front.server_close()
        with contextlib.redirect_stdout(io.StringIO()):
            self.viser.stop()


def completed(page: str, upright: View) -> str:
    """Return a page with the script and the style of this folder first in its head."""
    script, style = ((HERE / name).read_text(encoding='utf-8') for name in ('page.js', 'page.css'))
    view = json.dumps({'initialCameraPosition': upright[0], 'initialCameraLookAt': upright[1]})
    before, head, after = page.partition('<head>')
    return (f'{before}{head}<meta charset="utf-8">\n<title>ur5</title>\n<script>\nconst UPRIGHT = '
            f'{view};\n{script}</script>\n<style>\n{style}</style>{after}')


class _Front(socketserver.ThreadingTCPServer):
    """Listens where the browser asks."""

    allow_reuse_address = True
    daemon_threads = True
    page = b''
    inner = 0


class _Connection(socketserver.StreamRequestHandler):
    """One connection of a browser: the page, or bytes passed on to viser's own server."""

    disable_nagle_algorithm = True
    server: _Front

    def handle(self) -> None:
        head = self._head()
        request = head.partition(b'\r\n')[0].split()
        upgrade = b'\r\nupgrade: websocket' in head.lower()
        if len(request) == 3 and request[1].partition(b'?')[0] == b'/' and not upgrade:
            page = self.server.page
            self.wfile.write(b'HTTP/1.1 200 OK\r\nContent-Type: text/html; charset=utf-8\r\n'
                             b'Connection: close\r\nContent-Length: %d\r\n\r\n' % len(page) + page)
        elif head.endswith(b'\r\n\r\n'):
            with contextlib.suppress(OSError):
                self._pass_on(head)

    def _head(self) -> bytes:
        """Return the head of the request, as far as it comes."""
        head = b''
        while not head.endswith(b'\r\n\r\n') and len(head) < MAX_HEAD:
            line = self.rfile.readline(MAX_HEAD)
            if not line:
                break
            head += line
        return head

    def _pass_on(self, head: bytes) -> None:
        """Copy bytes both ways until one side ends."""
        with socket.create_connection((HOST, self.server.inner)) as inner:
            inner.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            inner.sendall(head)
            back = threading.Thread(target=self._copy_back, args=(inner,), daemon=True)
            back.start()
            while data := self.rfile.read1(1 << 16):
                inner.sendall(data)
            inner.shutdown(socket.SHUT_WR)
            back.join()

    def _copy_back(self, inner: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := inner.recv(1 << 16):
                self.connection.sendall(data)
            self.connection.shutdown(socket.SHUT_RDWR)


def _listen(port: int) -> _Front:
    last = port + PORTS if port else 0
    for number in range(port, min(last, 65535) + 1):
        with contextlib.suppress(OSError):
            return _Front((HOST, number), _Connection)
    raise InputError(f'ports {port} to {min(last, 65535)} are taken; give another one with --port')


def _fetch(port: int) -> str:
    """Return the page as viser serves it."""
    connection = http.client.HTTPConnection(HOST, port, timeout=30)
    with contextlib.closing(connection):
        connection.request('GET', '/')
        return connection.getresponse().read().decode()
