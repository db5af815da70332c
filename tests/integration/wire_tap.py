# SPDX-License-Identifier: BSD-3-Clause
"""Stands between a coupler and its participants, passes every frame on as it is, and says what passes."""

import json
import threading
from collections.abc import Callable

import zmq

SLICE = 50  # [ms]


class WireTap:
    """Participants connect to `endpoint`. A thread of its own passes messages on and calls

        before(way, who, header), after(way, who, header)

    for each: way is ">" to the coupler or "<" from it, who the participant's name, header the message's."""

    def __init__(self, coupler: str, before: Callable[[str, str, dict], None],
                 after: Callable[[str, str, dict], None]) -> None:
        self._coupler, self._before, self._after = coupler, before, after
        self._context = zmq.Context()
        self._front = self._socket(zmq.ROUTER)
        self.endpoint = f"tcp://127.0.0.1:{self._front.bind_to_random_port('tcp://127.0.0.1')}"
        self._behind: dict[bytes, zmq.Socket] = {}  # routing id of a participant's socket -> one to the coupler
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._stop.set()
        self._thread.join()
        for socket in (self._front, *self._behind.values()):
            socket.close()
        self._context.term()

    def _socket(self, kind: int, route: bytes = b"") -> zmq.Socket:
        socket = self._context.socket(kind)
        socket.setsockopt(zmq.LINGER, 0)
        if route:
            socket.setsockopt(zmq.ROUTING_ID, route)
            socket.connect(self._coupler)
        return socket

    def _run(self) -> None:
        while not self._stop.is_set():
            poller = zmq.Poller()
            for socket in (self._front, *self._behind.values()):
                poller.register(socket, zmq.POLLIN)
            ready = dict(poller.poll(SLICE))
            if self._front in ready:
                route, *frames = self._front.recv_multipart()
                if route not in self._behind:
                    self._behind[route] = self._socket(zmq.DEALER, route)
                self._pass(">", route, frames)
            for route, socket in list(self._behind.items()):
                if socket in ready:
                    self._pass("<", route, socket.recv_multipart())

    def _pass(self, way: str, route: bytes, frames: list[bytes]) -> None:
        who, header = route.split(b"#")[0].decode(), json.loads(frames[0])
        self._before(way, who, header)
        if way == ">":
            self._behind[route].send_multipart(frames)
        else:
            self._front.send_multipart([route, *frames])
        self._after(way, who, header)
