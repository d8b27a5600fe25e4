"""The page of the viewer: viser's, completed, on one port of this machine."""

import contextlib
import http.client
import socket

import pytest
import viser
from websockets.sync.client import connect

from ur5_ros.errors import InputError
from ur5_ros.viewer.page_server import PageServer

VIEW = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)


@contextlib.contextmanager
def serving(port: int):
    server = PageServer('test', port, VIEW, VIEW)
    try:
        yield server
    finally:
        server.close()


def fetch(port: int, path: str = '/') -> tuple[int, str]:
    connection = http.client.HTTPConnection('127.0.0.1', port, timeout=20)
    with contextlib.closing(connection):
        connection.request('GET', path)
        answer = connection.getresponse()
        return answer.status, answer.read().decode(errors='replace')


def test_the_page_of_viser_carries_the_script_of_this_package():
    with serving(0) as server:
        status, page = fetch(server.port, '/?darkMode')
        _, inner = fetch(server.viser.get_port())
    assert status == 200
    head = page.partition('</head>')[0]
    assert head.index('const UPRIGHT') < head.index('<title>Viser</title>')
    assert len(page) > len(inner) > 100_000
    assert page.endswith(inner[-1000:])


def test_a_browser_talks_to_viser_through_the_same_port():
    with serving(0) as server, connect(f'ws://127.0.0.1:{server.port}', max_size=None,
                 subprotocols=[f'viser-v{viser.__version__}']) as browser:
        assert len(browser.recv(timeout=20)) > 0


def test_what_is_not_the_page_is_answered_by_viser():
    with serving(0) as server:
        assert fetch(server.port, '/../setup.py')[0] == 404
        assert fetch(server.port, '/nothing')[0] == 404


def test_a_taken_port_gives_way_to_the_next_free_one():
    with serving(0) as first, serving(first.port) as second:
        assert second.port > first.port
        assert fetch(second.port)[0] == 200


def test_where_no_port_is_free_the_way_out_is_named():
    with socket.create_server(('127.0.0.1', 65535)), pytest.raises(InputError, match='--port'):
        PageServer('test', 65535, VIEW, VIEW)


@pytest.mark.parametrize('request_', [b'', b'\r\n\r\n', b'GET /', b'\x00' * 70_000])
def test_a_request_that_is_none_disturbs_nothing(request_):
    with serving(0) as server:
        # the server may hang up before all is sent
        with (socket.create_connection(('127.0.0.1', server.port), timeout=20) as client,
              contextlib.suppress(OSError)):
            client.sendall(request_)
            client.shutdown(socket.SHUT_WR)
            client.recv(1000)
        assert fetch(server.port)[0] == 200
