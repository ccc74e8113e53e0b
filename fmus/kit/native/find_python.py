"""Asked by an FMU's library which Python this is: `python3 -E find_python.py` prints four lines.

Version ("3.11"), executable, shared libpython, and nothing or why this Python will not do. Beside it lies the FMU's
requirements.txt. Standard library only, and no annotations or syntax of late: also an old Python is to say that it is one.
"""

import importlib.util
import os
import re
import sys
import sysconfig

OLDEST = (3, 11)


def version():  # type: ignore[no-untyped-def]
    """Major and minor, as in the names of files."""
    return f"{sys.version_info[0]}.{sys.version_info[1]}"


def library():  # type: ignore[no-untyped-def]
    """The shared libpython of the Python that runs this, or "".

    A Python built without --enable-shared has none of its own; Debian and Ubuntu keep it in a package of its own."""
    stem = f"libpython{sysconfig.get_config_var('LDVERSION') or version()}.so"
    names = [str(sysconfig.get_config_var("INSTSONAME") or ""), f"{stem}.1.0", f"{stem}.1", stem]
    folders = [str(sysconfig.get_config_var("LIBDIR") or ""), os.path.join(sys.base_prefix, "lib")]
    if os.path.realpath(sys.base_prefix) == "/usr":  # another Python's library of this version would bring other modules
        multiarch = str(sysconfig.get_config_var("MULTIARCH") or "")
        folders += [f"/usr/lib/{multiarch}", f"/lib/{multiarch}", "/usr/lib64", "/usr/lib"]
    for folder in folders:
        for name in names:
            file = os.path.join(folder, name)
            if folder and ".so" in name and os.path.isfile(file):
                return os.path.realpath(file)
    return ""


def missing(file):  # type: ignore[no-untyped-def]
    """The packages that the requirements in `file` name and that are not here."""
    if not os.path.isfile(file):
        return []
    with open(file) as lines:
        names = [re.split(r"[^\w.-]", line)[0] for line in lines if line.strip()]
    return [name for name in names if importlib.util.find_spec(name) is None]


def problem(requirements):  # type: ignore[no-untyped-def]
    """Why this Python will not do, or ""."""
    if sys.version_info < OLDEST:
        return f"it is Python {version()}, and 3.11 is the oldest that will do"
    lacks = missing(requirements)
    if lacks:
        return f"it has not the package{'s' if len(lacks) > 1 else ''} {', '.join(lacks)}"
    if not library():
        return "it has no shared libpython (Debian, Ubuntu: apt install libpython3.x; pyenv: --enable-shared)"
    return ""


def main():  # type: ignore[no-untyped-def]
    """The four lines."""
    beside = os.path.join(os.path.dirname(os.path.abspath(__file__)), "requirements.txt")
    lines = [version(), sys.executable or "", library(), problem(beside)]
    with os.fdopen(os.dup(1), "wb") as out:
        out.write(b"".join(os.fsencode(line) + b"\n" for line in lines))


if __name__ == "__main__":
    main()
