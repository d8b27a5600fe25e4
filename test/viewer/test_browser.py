"""The viewer in a real browser: what it shows, at which width, by which key."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ur5_ros.analysis.data.run import RecordedEvent
from ur5_ros.viewer.recorded import RecordedView

pytestmark = pytest.mark.browser

WIDE, NARROW = (1280, 800), (420, 860)


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
    view.time.value = float(t)
    browser.wait(f"document.body.innerText.includes('t = {t:.3f} s')")
    time.sleep(3.0)  # the scene is drawn in software
    path = browser.photograph(folder / f'view_{size[0]}_{"dark" if dark else "light"}.png')
    return np.asarray(Image.open(path).convert('RGB')).astype(int)


def until(there) -> None:
    """Wait for a condition."""
    end = time.monotonic() + 10
    while not there() and time.monotonic() < end:
        time.sleep(0.05)
    assert there()


def near(picture: np.ndarray, colour: tuple[int, int, int], distance: int = 40) -> int:
    """Return how many pixels have about this colour."""
    return int((np.abs(picture - colour).max(axis=-1) < distance).sum())


def panel(browser) -> list[float]:
    """Return left, top, right and bottom of what holds the controls [pixels]."""
    return browser.evaluate(
        "(() => { let node = document.querySelector('[role=slider]');"
        "while (node.parentElement && !['fixed', 'absolute'].includes("
        "getComputedStyle(node).position) || node.getBoundingClientRect().height < 200)"
        "node = node.parentElement;"
        "const box = node.getBoundingClientRect();"
        "return [box.left, box.top, box.right, box.bottom]; })()")


@pytest.fixture(scope='module')
def loaded(run):
    """The page of a run with a payload from 2 s and viscous friction from 4 s on."""
    events = tuple(RecordedEvent(int(run.stamp[0]) + int(t * 1e9), 'parameter', '',
                                 {'name': name, 'value': value})
                   for t, name, value in ((2.0, 'payload.mass', 1.5),
                                          (4.0, 'friction.viscous', [2.0] * 6)))
    view = RecordedView(replace(run, events=events), 18320)
    yield view
    view.page.close()


def chart(browser, number: int) -> list[float]:
    """Return left, top, width and height of the drawing area of a chart [pixels]."""
    return browser.evaluate(
        f"(() => {{ const over = document.querySelectorAll('.u-over')[{number}];"
        "over.scrollIntoView({block: 'center'}); const box = over.getBoundingClientRect();"
        "return [box.left, box.top, box.width, box.height]; })()")


def column(picture: np.ndarray, box: list[float], share: float) -> int:
    """Return how many grey pixels stand above each other at a share of a chart's width."""
    left, top, wide, high = box
    x, y = round(left + share * wide), round(top)
    cut = picture[y:y + round(high), x - 2:x + 3]
    grey = (np.ptp(cut, axis=-1) < 30) & (np.abs(cut.mean(axis=-1) - 136) < 60)
    return int(grey.sum(axis=0).max())


@pytest.mark.parametrize('size', [WIDE, NARROW], ids=['wide', 'narrow'])
def test_each_chart_has_a_numbered_line_where_something_was_added_to_the_plant(
        browser, loaded, size, tmp_path):
    shown(browser, loaded, size, loaded.track.t[5], tmp_path)
    words = browser.evaluate('document.body.innerText')
    assert 'from 2 s: payload.mass 1.5' in words and 'from 4 s: friction.viscous 2' in words
    for number in range(3):
        box = chart(browser, number)
        time.sleep(1.0)
        picture = np.asarray(Image.open(browser.photograph(tmp_path / 'chart.png')).convert(
            'RGB')).astype(int)
        end = float(loaded.track.t[-1])
        lines = [column(picture, box, t / end) for t in (2.0, 3.1, 4.0)]
        assert min(lines[0], lines[2]) > 0.25 * box[3] > 2 * lines[1], (number, lines)
    assert not browser.console


def test_the_pointer_shows_values_and_a_joint_is_hidden_in_every_chart_by_keys(browser, loaded,
                                                                               tmp_path):
    shown(browser, loaded, WIDE, loaded.track.t[5], tmp_path)
    left, top, wide, high = chart(browser, 0)
    browser.ask('Input.dispatchMouseEvent', type='mouseMoved', x=left + wide / 2,
                y=top + high / 2)
    legend = browser.wait(
        "(() => { const values = Object.fromEntries([...document.querySelector('.u-legend')"
        ".querySelectorAll('.u-series')].map((each) => [each.querySelector('.u-label').innerText,"
        "each.querySelector('.u-value').innerText])); return values.elbow !== '--' && values;"
        "})()")
    t, torque = (float(legend[name].replace('\u2212', '-')) for name in ('t [s]', 'elbow'))
    row = loaded.track.row(t)
    assert t == pytest.approx(loaded.track.t[-1] / 2, abs=0.2)
    assert torque == pytest.approx(loaded.track.effort[row, 2], abs=0.1)
    hidden = ("[...document.querySelectorAll('.u-legend')].map((legend) => [...legend"
              ".querySelectorAll('.u-series.u-off .u-label')].map((each) => each.innerText)"
              ".join())")
    assert browser.evaluate(hidden) == ['', '', '']
    for _ in range(40):
        browser.key('Tab', 9)
        if browser.evaluate("document.activeElement.type === 'checkbox'"):
            break
    browser.key(' ', 32, 'Space')
    until(lambda: [each.value for each in loaded.page.curves.joints] == [False] + [True] * 5)
    browser.wait(f"JSON.stringify({hidden}) === JSON.stringify(['pan', 'pan', ''])")
    browser.key(' ', 32, 'Space')
    browser.wait(f"JSON.stringify({hidden}) === JSON.stringify(['', '', ''])")
    assert not browser.console


@pytest.mark.parametrize('dark', [False, True], ids=['light', 'dark'])
@pytest.mark.parametrize('size', [WIDE, NARROW], ids=['wide', 'narrow'])
def test_the_page_shows_arm_paths_numbers_and_curves_and_says_nothing(browser, view, size, dark,
                                                                      tmp_path):
    t = view.track.t[len(view.track.t) // 2]
    picture = shown(browser, view, size, t, tmp_path, dark)
    lids = (105, 150, 185) if dark else (112, 158, 194)
    reference = (200, 60, 180)
    assert near(picture, lids) > 300, 'the lids of the joints'
    assert near(picture, reference) > 30, 'the path of the reference'
    for title in ('Torque [N m]', 'Joint error [mrad]', 'Tool error [mm]'):
        assert browser.evaluate(f"document.body.textContent.includes('{title}')"), title
    assert browser.page_width <= size[0], 'nothing sticks out sideways'
    notices = browser.evaluate("[...document.querySelectorAll('.mantine-Notification-root')].map("
                               "(each) => each.getBoundingClientRect().height)")
    assert max(notices, default=0) < 80, 'a notice covers no more than its title'
    ground = np.median(picture.reshape(-1, 3), axis=0).mean()
    assert (ground < 60) if dark else (ground > 230), 'the colours of the system'
    assert not browser.console


def test_in_a_narrow_window_the_whole_arm_stands_above_the_panel(browser, view, tmp_path):
    picture = shown(browser, view, NARROW, view.track.t[40], tmp_path)
    left, top, right, bottom = panel(browser)
    assert (left, right, bottom) == (0, *NARROW)
    rows, columns = np.nonzero(np.abs(picture - (112, 158, 194)).max(axis=-1) < 40)  # the lids
    above = rows < top
    assert above.sum() > 300
    assert columns[above].min() > 10 and columns[above].max() < NARROW[0] - 10
    assert rows[above].max() < top - 10


def test_the_arm_moves_with_the_timeline(browser, view, tmp_path):
    first, last = (shown(browser, view, WIDE, view.track.t[i], tmp_path)[:, :860]
                   for i in (0, -1))
    assert (np.abs(first - last).max(axis=-1) > 60).sum() > 2000


@pytest.mark.parametrize('size', [WIDE, NARROW], ids=['wide', 'narrow'])
def test_the_keyboard_reaches_and_moves_the_timeline_and_leaves_the_camera(browser, view, size,
                                                                           tmp_path):
    shown(browser, view, size, view.track.t[0], tmp_path)
    reached = []
    for _ in range(12):
        browser.key('Tab', 9)
        reached.append(browser.evaluate(
            "document.activeElement.getAttribute('role') || document.activeElement.innerText"))
        if reached[-1] == 'slider':
            break
    assert reached[-1] == 'slider', reached
    assert browser.evaluate('getComputedStyle(document.activeElement).outlineStyle') == 'solid'
    client = next(iter(view.page.server.get_clients().values()))
    camera = client.camera.position
    for key, code, there in (('ArrowRight', 39, lambda t: 0 < t < 1), ('End', 35, lambda t: t > 5),
                             ('Home', 36, lambda t: t == 0)):
        for _ in range(3):
            browser.key(key, code)
        until(lambda there=there: there(view.time.value))
    assert np.array_equal(client.camera.position, camera)


def test_space_on_the_button_and_the_key_p_play_and_pause(browser, view, tmp_path):
    shown(browser, view, WIDE, view.track.t[0], tmp_path)
    browser.evaluate('document.activeElement.blur()')
    browser.key('p', 80, 'KeyP')
    until(lambda: view.play.label == 'Pause')
    browser.wait("document.body.innerText.includes('Pause')")
    browser.evaluate("[...document.querySelectorAll('button')]"
                     ".find(each => each.innerText === 'Pause').focus()")
    browser.key(' ', 32, 'Space')
    until(lambda: view.play.label == 'Play')
    assert not browser.console


def test_the_page_asks_nothing_of_the_network(browser, view, tmp_path):
    shown(browser, view, WIDE, view.track.t[5], tmp_path)
    asked = browser.evaluate(
        "performance.getEntriesByType('resource').map(entry => entry.name).join(' ')")
    assert not [each for each in asked.split()
                if each.startswith('http') and not each.startswith('http://127.0.0.1:')]


def test_play_moves_the_timeline_and_ends_at_the_end(view):
    view.time.value = float(view.track.t[-1]) - 0.5
    view.play_or_pause()
    view.advance(0.2)
    assert view.play.label == 'Pause'
    assert view.time.value == pytest.approx(view.track.t[-1] - 0.3)
    view.advance(10.0)
    assert (view.play.label, view.time.value) == ('Play', pytest.approx(view.track.t[-1]))


def test_only_this_machine_can_reach_the_page(view):
    import psutil
    listening = {(each.laddr.ip, each.laddr.port)
                 for each in psutil.Process().net_connections(kind='inet')
                 if each.status == psutil.CONN_LISTEN}
    assert listening and {address for address, _ in listening} == {'127.0.0.1'}
