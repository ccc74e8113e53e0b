"""Asked by an FMU's library which Python this is: `python3 -E find_python.py` prints four lines.

Version ("3.11"), executable, shared libpython, and "" or why this Python will not do. Beside it lies the FMU's requirements.txt.
Standard library only, and nothing that an old Python cannot read: it is asked to say that it is too old.
"""

import importlib.util
import os
import re
import sys
import sysconfig

OLDEST = (3, 11)


def library():
    """The shared libpython of the Python that runs this, or "".

    A Python built without --enable-shared has none of its own; Debian and Ubuntu keep it in a package of its own."""
    version = "libpython%s.so" % (sysconfig.get_config_var("LDVERSION") or "%d.%d" % sys.version_info[:2])
    names = [str(sysconfig.get_config_var("INSTSONAME") or ""), version + ".1.0", version + ".1", version]
    folders = [str(sysconfig.get_config_var("LIBDIR") or ""), os.path.join(sys.base_prefix, "lib")]
    if os.path.realpath(sys.base_prefix) == "/usr":  # another Python's library of this version would bring other modules
        multiarch = str(sysconfig.get_config_var("MULTIARCH") or "")
        folders += ["/usr/lib/" + multiarch, "/lib/" + multiarch, "/usr/lib64", "/usr/lib"]
    for folder in folders:
        for name in names:
            file = os.path.join(folder, name)
            if folder and ".so" in name and os.path.isfile(file):
                return os.path.realpath(file)
    return ""


def missing(file):
    """The packages that requirements.txt names and that are not here."""
    names = [re.split(r"[^\w.-]", line)[0] for line in open(file) if line.strip()] if os.path.isfile(file) else []
    return [name for name in names if importlib.util.find_spec(name) is None]


def main():
    """The four lines."""
    found, lacks = "", []
    if sys.version_info < OLDEST:
        problem = "it is Python %d.%d, and 3.11 is the oldest that will do" % sys.version_info[:2]
    else:
        found, lacks = library(), missing(os.path.join(os.path.dirname(os.path.abspath(__file__)), "requirements.txt"))
        problem = "it has no shared libpython (Debian, Ubuntu: apt install libpython3.x; pyenv: --enable-shared)" if not found else ""
        if lacks:
            problem = "it has not the package%s %s" % ("s" if len(lacks) > 1 else "", ", ".join(lacks))
    lines = ["%d.%d" % sys.version_info[:2], sys.executable or "", found, problem]
    with os.fdopen(os.dup(1), "wb") as out:
        out.write(b"".join(os.fsencode(line) + b"\n" for line in lines))


if __name__ == "__main__":
    main()
