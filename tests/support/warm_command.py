"""The command `aeroslosh` without its second of imports, for pages that call it many times.

A server that has imported everything forks a child a call, which has the caller's arguments, folder, environment and streams and
ends with the command's own exit code. `served` starts one; it lives until its standard input ends."""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import select
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from subprocess import PIPE, Popen

from .processes import supported

CLIENT = """#!{python} -SE
import json, os, socket, sys
with socket.socket(socket.AF_UNIX) as s:
    s.connect({place!r})
    words = json.dumps([sys.argv[1:], os.getcwd(), dict(os.environ)]).encode()
    socket.send_fds(s, [len(words).to_bytes(8, "big")], [0, 1, 2])
    s.sendall(words)
    answer = s.recv(8)
os._exit(int(answer) if answer else 70)
"""


def serve(place: str) -> None:
    """Answer calls one after the other."""
    from aeroslosh.master import cli
    from aeroslosh.master.commands import HELP

    for module in ("numba", "scipy.linalg", "scipy.signal", "scipy.optimize", "fmpy", "pythonfmu", "xarray"):
        importlib.import_module(module)
    for name in HELP:
        importlib.import_module(f"aeroslosh.master.commands.{name}")
    for room in ("api.point", "api.sweep", "api.boundary", "report.page", "boundary.solve", "flutter.setup"):
        importlib.import_module(f"aeroslosh.master.{room}")
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(place)
        listening.listen()
        print("ready", flush=True)
        while listening in select.select([listening, sys.stdin], [], [])[0]:
            call, _ = listening.accept()
            with call:
                head, streams, _, _ = socket.recv_fds(call, 8, 3)
                size, words = int.from_bytes(head, "big"), b""
                while len(words) < size:
                    words += call.recv(size - len(words))
                arguments, folder, environment = json.loads(words)
                child = os.fork()
                if child == 0:
                    for number, stream in enumerate(streams):
                        os.dup2(stream, number)
                    sys.stdin, sys.stdout, sys.stderr = (os.fdopen(n, "w" if n else "r", closefd=False) for n in range(3))
                    os.chdir(folder)
                    os.environ.clear()
                    os.environ.update(environment)
                    sys.argv = ["aeroslosh", *arguments]
                    cli.main(arguments)
                for stream in streams:
                    os.close(stream)
                call.sendall(str(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])).encode())


@contextmanager
def served(folder: Path) -> Iterator[Path]:
    """A server while the block runs; a folder with a program `aeroslosh`, to be put first on the path."""
    place, programs = folder / "socket", folder / "bin"
    programs.mkdir()
    (programs / "aeroslosh").write_text(CLIENT.format(python=sys.executable, place=str(place)))
    (programs / "aeroslosh").chmod(0o755)
    words = [sys.executable, "-m", "support.warm_command", str(place)]
    with Popen(words, stdin=PIPE, stdout=PIPE, text=True, env=supported()) as server:
        assert server.stdin is not None and server.stdout is not None
        try:
            assert server.stdout.readline() == "ready\n"
            yield programs
        finally:
            with contextlib.suppress(OSError):
                server.stdin.close()  # ends it


if __name__ == "__main__":
    serve(sys.argv[1])
