"""Services and parameters beside the loop: an executor in a thread, and how it asks the loop."""

import gc
import threading
import traceback
from collections import deque
from collections.abc import Callable
from itertools import cycle
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future

from ur5_ros.errors import InputError

#: Wall time that the loop has to do what a service asks [s].
REQUEST_TIMEOUT = 10.0

#: Requests and answers of a service that may wait: a flood of rclpy's ten would lose the oldest.
REQUESTS = QoSProfile(depth=100)


class LoopRequests:
    """Work that other threads want done by the loop, between two periods."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self._wake = wake
        self._waiting: deque[_Request] = deque()
        self._loop_thread = threading.get_ident()
        self._closed = False

    def __bool__(self) -> bool:
        return bool(self._waiting)

    def call(self, work: Callable[[], Any]) -> Any:
        """Have the loop do ``work`` and return what it returns."""
        if threading.get_ident() == self._loop_thread:
            return work()
        request = _Request(work)
        self._waiting.append(request)
        self._wake()
        timeout = 0.0 if self._closed else REQUEST_TIMEOUT
        if not request.done.wait(timeout) and request.claim():
            raise InputError('the node is busy or ending; try again')
        request.done.wait()  # begun: its end is near
        if request.error is not None:
            raise request.error
        return request.result

    def post(self, work: Callable[[], Any]) -> None:
        """Have the loop do ``work`` some time, without waiting for it."""
        self._waiting.append(_Request(work))
        self._wake()

    def serve(self) -> None:
        """Do what is waiting; the loop calls it between two periods."""
        while self._waiting:
            request = self._waiting.popleft()
            if not request.claim():
                continue
            try:
                request.result = request.work()
            except InputError as error:
                request.error = error
            except Exception:
                request.error = InputError('the request failed; the log of the node says why')
                traceback.print_exc()
            request.done.set()

    def close(self) -> None:
        """Do what is waiting and refuse what comes later."""
        self._closed = True
        self.serve()


class _Request:
    def __init__(self, work: Callable[[], Any]) -> None:
        self.work = work
        self.done = threading.Event()
        self.result: Any = None
        self.error: InputError | None = None
        self._claimed = threading.Lock()

    def claim(self) -> bool:
        """Return whether the loop that begins it, or the caller that gives up, is the first."""
        return self._claimed.acquire(blocking=False)


class BackgroundExecutor:
    """An ordinary executor in a second thread."""

    def __init__(self, node: Node) -> None:
        self._executor = SingleThreadedExecutor(context=node.context)
        self._executor.add_node(node)
        self._context = node.context
        self._end = Future()  # ends a wait at once; waits without a timeout cost nothing meanwhile
        self._thread = threading.Thread(target=self._spin, name='executor', daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Serve no more."""
        self._end.set_result(None)
        self._thread.join(0.5)

    def _spin(self) -> None:
        while self._context.ok() and not self._end.done():
            try:
                self._executor.spin_until_future_complete(self._end)
            except ExternalShutdownException:
                return
            except Exception:  # a callback's error must not end the others
                if not self._end.done():
                    traceback.print_exc()


def poll_graph(node: Node, look: Callable[[], None]) -> None:
    """
    Call ``look`` every second of steady time, in the thread that serves.

    Questions to the middleware's graph take as long as a control period: not the loop's work.
    Executors leave closures in cycles, two megabytes an hour, and the collector is off: those of
    the last second are freed, which takes microseconds as it looks at nothing older, and once a
    minute those that were in use at that moment.

    """
    generation = cycle([1, *[0] * 59])

    def look_and_tidy() -> None:
        look()
        gc.collect(next(generation))

    node.create_timer(1.0, look_and_tidy, clock=Clock(clock_type=ClockType.STEADY_TIME))


def add_service(
    node: Node, service_type: type, name: str, answer: Callable[[Any], str],
) -> None:
    """
    Serve ``success`` and ``message`` of std_srvs: what ``answer`` returns, or why it refused.

    ``service_type``: ``std_srvs.srv.Trigger`` or ``SetBool``; ``name``: such as ``~/pause``;
    ``answer``: gets the request, returns the message of a success; raises InputError.
    """
    def handle(request: Any, response: Any) -> Any:
        try:
            response.message = answer(request)
            response.success = True
        except InputError as error:
            response.success, response.message = False, str(error)
        return response

    node.create_service(service_type, name, handle, qos_profile=REQUESTS)
