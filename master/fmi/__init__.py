"""One FMU: unpack, load, set, step, log; a table driven through it."""
