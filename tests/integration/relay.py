# SPDX-License-Identifier: BSD-3-Clause
"""A wire that takes its time: TCP connections to one port go on to another, each byte after a delay."""

import asyncio
import threading


class Relay:
    """A relay between 127.0.0.1:`port` and 127.0.0.1:`target`; `delay` [s] each way. Stop it with close()."""

    def __init__(self, port: int, target: int, delay: float) -> None:
        self.port, self.target, self.delay = port, target, delay
        self.bytes_passed = 0
        self._cut = False
        self._writers: list[asyncio.StreamWriter] = []
        self._loop = asyncio.new_event_loop()
        ready = threading.Event()
        self._thread = threading.Thread(target=self._serve, args=[ready], daemon=True)
        self._thread.start()
        ready.wait()

    def cut(self) -> None:
        """Let nothing pass from now on, and tell nobody: a cable that was pulled."""
        self._cut = True

    def close(self) -> None:
        asyncio.run_coroutine_threadsafe(self._end(), self._loop).result()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    async def _end(self) -> None:
        self._server.close()
        for writer in self._writers:
            writer.transport.abort()
        tasks = [task for task in asyncio.all_tasks() if task is not asyncio.current_task()]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def _serve(self, ready: threading.Event) -> None:
        asyncio.set_event_loop(self._loop)
        self._server = self._loop.run_until_complete(asyncio.start_server(self._connect, "127.0.0.1", self.port))
        ready.set()
        self._loop.run_forever()

    async def _connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            there, back = await asyncio.open_connection("127.0.0.1", self.target)
        except OSError:
            writer.close()
            return
        self._writers += [writer, back]
        await asyncio.gather(self._pass(reader, back), self._pass(there, writer))

    async def _pass(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Pass pieces on in their order; each waits until its own time."""
        queue: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue()
        sender = asyncio.ensure_future(self._send(queue, writer))
        piece = b"?"
        while piece:
            try:
                piece = await reader.read(1 << 16)
            except OSError:
                piece = b""
            await queue.put((self._loop.time() + self.delay, piece))
        await sender

    async def _send(self, queue: asyncio.Queue, writer: asyncio.StreamWriter) -> None:
        while True:
            due, piece = await queue.get()
            await asyncio.sleep(max(0.0, due - self._loop.time()))
            if not piece:
                if not self._cut:
                    writer.close()
                return
            if self._cut:
                continue
            self.bytes_passed += len(piece)
            try:
                writer.write(piece)
                await writer.drain()
            except OSError:
                return
