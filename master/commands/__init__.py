"""The commands of `aeroslosh`, one a module: `register(commands)` adds its words to the command line, `execute(options)` runs it
and returns the exit code."""

from . import animate, boundary, compare, doctor, drive, export, point, run, sweep, train

COMMANDS = (point, boundary, sweep, run, drive, animate, compare, export, train, doctor)
