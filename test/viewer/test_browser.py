"""The viewer in a real browser: what it shows, at which width, by which key."""

import importlib.util
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ur5_ros.viewer.recorded import RecordedView

pytestmark = pytest.mark.browser

spec = importlib.util.spec_from_file_location('chromium', Path(__file__).parent / 'chromium.py')
chromium = importlib.util.module_from_spec(spec)
sys.modules['chromium'] = chromium
spec.loader.exec_module(chromium)

#: The library of the viewer logs its state, and warns once of a class that it still uses itself.
LIBRARY = ('log: ', 'info: ', 'warning: THREE.Clock: This module has been deprecated')
WIDE, NARROW = (1280, 800), (420, 860)


@pytest.fixture(scope='module')
def browser(tmp_path_factory):
    browser = chromium.Chromium(tmp_path_factory.mktemp('profile'))
    yield browser
    browser.close()


@pytest.fixture(scope='module')
def view(run):
    view = RecordedView(run, 18310)
    yield view
    view.page.close()


def shown(browser, view, size, t: float, folder: Path, dark: bool = False) -> np.ndarray:
    """Return the window as soon as the page shows time ``t``, as an image of bytes."""
    browser.console.clear()
    browser.open(view.page.address, *size, dark=dark)
    view.time.value = 0.0
    browser.wait("document.querySelectorAll('canvas').length >= 4")
    view.time.value = t
    browser.wait(f"document.body.innerText.includes('t = {t:.3f} s')")
    time.sleep(3.0)  # the scene is drawn in software
    path = browser.photograph(folder / f'view_{size[0]}_{"dark" if dark else "light"}.png')
    return np.asarray(Image.open(path).convert('RGB')).astype(int)


def near(picture: np.ndarray, colour: tuple[int, int, int], distance: int = 40) -> int:
    """Return how many pixels have about this colour."""
    return int((np.abs(picture - colour).max(axis=-1) < distance).sum())


@pytest.mark.parametrize('size', [WIDE, NARROW], ids=['wide', 'narrow'])
def test_the_page_shows_arm_paths_numbers_and_curves(browser, view, size, tmp_path):
    t = view.page_times[len(view.page_times) // 2]
    picture = shown(browser, view, size, t, tmp_path)
    assert near(picture, (112, 158, 194)) > 300, 'the lids of the joints'
    assert near(picture, (230, 97, 1)) > 30, 'the wanted path'
    for title in ('Torque [N m]', 'Joint error [mrad]', 'Tool error [mm]'):
        assert browser.evaluate(f"document.body.textContent.includes('{title}')"), title
    wide = browser.evaluate('document.documentElement.scrollWidth')
    assert wide <= size[0], 'nothing sticks out sideways'


def test_the_arm_moves_with_the_timeline(browser, view, tmp_path):
    first, last = (shown(browser, view, WIDE, view.page_times[i], tmp_path)[:, :860]
                   for i in (0, -1))
    assert (np.abs(first - last).max(axis=-1) > 60).sum() > 2000


def test_the_page_gives_no_error_and_no_warning(browser, view, tmp_path):
    shown(browser, view, WIDE, view.page_times[10], tmp_path)
    said = [line for line in browser.console if not line.startswith(LIBRARY)]
    assert not said


def test_the_timeline_is_moved_by_the_keyboard(browser, view, tmp_path):
    shown(browser, view, WIDE, view.page_times[0], tmp_path)
    browser.evaluate("document.querySelector('[role=slider]').focus()")
    before = view.time.value
    for _ in range(5):
        browser.key('ArrowRight', 39)
    end = time.monotonic() + 10
    while view.time.value == before and time.monotonic() < end:
        time.sleep(0.1)
    assert view.time.value > before


def test_the_dark_switch_makes_the_page_dark(browser, view, tmp_path):
    light = shown(browser, view, WIDE, view.page_times[20], tmp_path)
    view.dark.value = True
    try:
        dark = shown(browser, view, WIDE, view.page_times[21], tmp_path)
    finally:
        view.dark.value = False
    assert dark[:, 900:].mean() < 0.5 * light[:, 900:].mean()


def test_play_moves_the_timeline_and_ends_at_the_end(view):
    view.time.value = float(view.page_times[-1]) - 0.5
    view.play_or_pause()
    view.advance(0.2)
    assert view.play.label == 'Pause'
    assert view.time.value == pytest.approx(view.page_times[-1] - 0.3)
    view.advance(10.0)
    assert (view.play.label, view.time.value) == ('Play', pytest.approx(view.page_times[-1]))


def test_only_this_machine_can_reach_the_page(view):
    import psutil
    listening = {(each.laddr.ip, each.laddr.port)
                 for each in psutil.Process().net_connections(kind='inet')
                 if each.status == psutil.CONN_LISTEN}
    assert listening and {address for address, _ in listening} == {'127.0.0.1'}
