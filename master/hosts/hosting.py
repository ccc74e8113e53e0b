"""The way of last resort for a program that is not Python: libpython in the process, and this Python first on PATH.

Our FMUs find their Python themselves (docs/hosts.md); where they do not, or where FMUs of others need it, a host can be started
with libpython preloaded. An FMU then takes the first `python3` on PATH that fits: a virtual environment there is honoured,
PYTHONHOME is not the way. Standard library only: the launcher imports this and nothing else.
"""

from __future__ import annotations

import os
import platform
import shlex
import sys
import sysconfig
from collections.abc import Mapping
from pathlib import Path

MOVE = "install Python in a folder without spaces and colons"


def bin_folder() -> Path:
    """The folder of the Python that runs this: of the virtual environment, if it is one."""
    return Path(os.path.abspath(sys.executable)).parent


def libpython() -> Path | None:
    """The shared libpython of the Python that runs this, or None where there is none on disk.

    A Python built without --enable-shared has none of its own, also where its linked executable holds all symbols; Debian and
    Ubuntu keep it in a package of its own (libpython3.x), whose version must then be that of this Python."""
    if os.name != "posix" or platform.system() != "Linux":
        return None
    wanted = f"libpython{sysconfig.get_config_var('LDVERSION') or f'{sys.version_info[0]}.{sys.version_info[1]}'}.so"
    names = dict.fromkeys([str(sysconfig.get_config_var("INSTSONAME") or ""), f"{wanted}.1.0", f"{wanted}.1", wanted])
    shared = [name for name in names if ".so" in name]  # a static build says libpython3.x.a
    multiarch = str(sysconfig.get_config_var("MULTIARCH") or "")
    folders = [str(sysconfig.get_config_var("LIBDIR") or ""), str(Path(sys.base_prefix) / "lib")]
    if _is_system_python():  # another Python's library of the same version would bring another standard library's modules
        folders += [f"/usr/lib/{multiarch}", f"/lib/{multiarch}", "/usr/lib64", "/usr/lib"]
    for folder in dict.fromkeys(folder for folder in folders if folder):
        for name in shared:
            file = Path(folder) / name
            if file.is_file():
                return file.resolve()
    return None


def _is_system_python() -> bool:
    return Path(sys.base_prefix).resolve() == Path("/usr")


def missing_libpython() -> str:
    """What to do where `libpython` finds nothing: one sentence."""
    version = f"{sys.version_info[0]}.{sys.version_info[1]}"
    if platform.system() != "Linux":
        return "use a host that is a Python program (FMPy, libcosimpy): the preload is known for Linux only"
    if _is_system_python():
        return f"install it: `apt install libpython{version}` (Debian, Ubuntu), `dnf install python3-libs` (Fedora)"
    return (
        f"this Python {version} was built without a shared library: install one that has it (Debian's python3 with libpython3.x, "
        "conda's, uv's, or `PYTHON_CONFIGURE_OPTS=--enable-shared pyenv install`), and make the environment anew with it"
    )


def environment(library: Path, given: Mapping[str, str]) -> dict[str, str]:
    """The environment `given` with what a non-Python host needs; what is in LD_PRELOAD and PATH already stays, behind ours.

    PYTHONHOME is taken out: it would send the interpreter past the virtual environment."""
    result = {name: value for name, value in given.items() if name != "PYTHONHOME"}
    result["LD_PRELOAD"] = _first(str(library), given.get("LD_PRELOAD", ""), " :")
    result["PATH"] = _first(str(bin_folder()), given.get("PATH", os.defpath), os.pathsep)
    return result


def _first(item: str, items: str, separators: str) -> str:
    """`items` with `item` in front, once."""
    rest = items
    for separator in separators:
        rest = rest.replace(separator, separators[-1])
    kept = [part for part in rest.split(separators[-1]) if part and part != item]
    return separators[-1].join([item, *kept])


def unloadable(library: Path) -> str:
    """Why LD_PRELOAD cannot name this file (it is split at spaces and colons), or nothing."""
    if any(c in str(library) for c in " :\t\n"):
        return f"LD_PRELOAD cannot hold the path {library}: it is split at spaces and colons"
    return ""


def line(library: Path) -> str:
    """The line that starts a host without the launcher; HOST ARGS stand for the program and its arguments."""
    preload, path = shlex.quote(str(library)), shlex.quote(str(bin_folder()))
    return f'env -u PYTHONHOME LD_PRELOAD={preload}"${{LD_PRELOAD:+:$LD_PRELOAD}}" PATH={path}:"$PATH" HOST ARGS'


def script(library: Path) -> str:
    """A POSIX sh script that does what the launcher does, where aeroslosh is not on the path."""
    return f"""#!/bin/sh
# Starts a program that is not Python with what FMUs written in Python need. Written by `aeroslosh doctor --script`
# for {sys.executable}; write it again after that Python has moved.
# use: sh THIS_FILE HOST ARGUMENTS...
library={shlex.quote(str(library))}
folder={shlex.quote(str(bin_folder()))}
if [ "$#" -eq 0 ]; then
    echo "$0: name the program to start: $0 HOST ARGUMENTS..." >&2
    exit 2
fi
if [ ! -r "$library" ] || [ ! -x "$folder/python3" ]; then
    echo "$0: $library or $folder/python3 is not there any more; remedy: aeroslosh doctor --script $0" >&2
    exit 2
fi
if ! command -v "$1" >/dev/null 2>&1; then
    echo "$0: there is no program $1; remedy: give its path" >&2
    exit 127
fi
unset PYTHONHOME  # it would send the interpreter past the virtual environment
# env, so that the library is not loaded into this shell's own commands
exec env LD_PRELOAD="$library${{LD_PRELOAD:+:$LD_PRELOAD}}" PATH="$folder:$PATH" "$@"
"""
