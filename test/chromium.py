"""A headless Chromium driven over its DevTools protocol: open, type, photograph, listen."""

import base64
import itertools
import json
import os
import shutil
import subprocess
import time
import urllib.request
from pathlib import Path

from websockets.sync.client import connect

# no GPU and no way out: drawn in software, nothing fetched in the background
OPTIONS = ('--headless=new', '--no-sandbox', '--disable-quic', '--no-first-run',
           '--disable-background-networking', '--disable-component-update', '--disable-sync',
           '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
           '--hide-scrollbars',  # and a mouse, as a desk has
           '--blink-settings=primaryHoverType=2,availableHoverTypes=2,'
           'primaryPointerType=4,availablePointerTypes=4',
           '--remote-debugging-port=0', '--remote-allow-origins=*')

#: Seconds to wait for an answer: a scene drawn in software on a busy machine takes its time.
DESCRIPTION_TIMEOUT = 240.0


class Chromium:
    """One browser with one page; everything that the page says to the console is kept."""

    def __init__(self, profile: Path):
        program = shutil.which('chromium')
        assert program, 'no chromium: apt-get install chromium'
        profile.mkdir(parents=True, exist_ok=True)
        self._process = subprocess.Popen(
            [program, *OPTIONS, f'--user-data-dir={profile}', 'about:blank'],
            env=os.environ | {'TMPDIR': str(profile)},
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
        port = self._port(profile / 'DevToolsActivePort')
        with urllib.request.urlopen(f'http://127.0.0.1:{port}/json/list', timeout=20) as answer:
            page = next(tab for tab in json.load(answer) if tab['type'] == 'page')
        self._socket = connect(page['webSocketDebuggerUrl'], max_size=None)
        self._ids, self.console = itertools.count(1), []
        for domain in ('Page', 'Runtime', 'Log'):
            self.ask(f'{domain}.enable')

    def ask(self, method: str, **parameters) -> dict:
        """Send a command; return its result."""
        number = next(self._ids)
        self._socket.send(json.dumps({'id': number, 'method': method, 'params': parameters}))
        while True:
            message = json.loads(self._socket.recv(timeout=DESCRIPTION_TIMEOUT))
            if message.get('id') == number:
                assert 'error' not in message, message
                return message['result']
            if 'method' in message:
                self._note(message)

    def open(self, address: str, width: int, height: int, dark: bool = False) -> None:
        """Open a page in a window of this size."""
        self.ask('Emulation.setDeviceMetricsOverride', width=width, height=height,
                 deviceScaleFactor=1, mobile=width < 600)
        self.ask('Emulation.setEmulatedMedia', features=[
            {'name': 'prefers-color-scheme', 'value': 'dark' if dark else 'light'}])
        self.ask('Page.navigate', url=address)

    def show(self, page: Path, size: tuple[int, int], figures: int = 1,
             dark: bool = False) -> None:
        """Open a page of ours whose console was cleared; wait until its figures are drawn."""
        self.console.clear()
        self.open(page.as_uri(), *size, dark=dark)
        self.wait(f"document.querySelectorAll('.main-svg').length >= {figures}")

    @property
    def page_width(self) -> int:
        """How wide the page is, with what sticks out sideways."""
        return self.evaluate('document.documentElement.scrollWidth')

    def evaluate(self, expression: str):
        """Return the value of a JavaScript expression."""
        result = self.ask('Runtime.evaluate', expression=expression, returnByValue=True,
                          awaitPromise=True)
        assert 'exceptionDetails' not in result, result
        return result['result'].get('value')

    def wait(self, expression: str, seconds: float = 30.0):
        """Return the value of an expression as soon as it is true."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            value = self.evaluate(expression)
            if value:
                return value
            time.sleep(0.2)
        raise AssertionError(f'never true: {expression}')

    def key(self, name: str, number: int, code: str = '') -> None:
        """Press a key; a key that writes has a name of one character."""
        for kind in ('keyDown', 'keyUp'):
            text = {'text': name} if kind == 'keyDown' and len(name) == 1 else {}
            self.ask('Input.dispatchKeyEvent', type=kind, key=name, code=code or name,
                     windowsVirtualKeyCode=number, **text)

    def photograph(self, path: Path) -> Path:
        """Write a PNG of the window."""
        shot = self.ask('Page.captureScreenshot', format='png')
        path.write_bytes(base64.b64decode(shot['data']))
        return path

    def close(self) -> None:
        """End the browser."""
        self._socket.close()
        self._process.terminate()
        self._process.wait(timeout=20)

    def _note(self, message: dict) -> None:
        if message['method'] == 'Runtime.consoleAPICalled':
            printed = ' '.join(str(each.get('value', each.get('description')))
                            for each in message['params']['args'])
            self.console.append(f'{message["params"]["type"]}: {printed}')
        elif message['method'] == 'Runtime.exceptionThrown':
            self.console.append(f'exception: {message["params"]["exceptionDetails"]}')
        elif message['method'] == 'Log.entryAdded':
            entry = message['params']['entry']
            self.console.append(f'{entry["level"]}: {entry["text"]}')

    @staticmethod
    def _port(path: Path) -> int:
        end = time.monotonic() + 30
        while time.monotonic() < end:
            if path.is_file() and path.read_text(encoding='utf-8').strip():
                return int(path.read_text(encoding='utf-8').split()[0])
            time.sleep(0.1)
        raise AssertionError('chromium did not start')
