"""The commands of `aeroslosh`, one a module: `register(commands)` adds its words to the command line, `execute(options)` runs it
and returns the exit code. A module is loaded when its command is asked for."""

HELP = {
    "init": "write a case to fill in: every key with its meaning, unit, range and default",
    "point": "march one Mach number and V_f: does it flutter?",
    "boundary": "find the neutral V_f of the case's Mach numbers",
    "amplitude": "which motions at a V_f grow, which decay: damping over amplitude, limit cycles and their stability",
    "sweep": "compute many points or boundaries of a case: grids, lists, Latin hypercubes over any key; resumable",
    "run": "run any system of FMUs, described in a system file",
    "drive": "drive one FMU alone with a table of its inputs",
    "animate": "draw the liquid in a tank from the fields that a slosh FMU wrote, as an animation",
    "compare": "tell what differs between two runs: settings, provenance, results, histories, cost",
    "overlay": "draw the boundaries, or the limit cycles, of several runs in one picture: dry against fuel",
    "report": "write a run, a sweep or a system's run as one HTML page that can be sent",
    "export": "write a run's histories or fields, or a coupled system, for other programs",
    "paper": "compute the figures of Srivastava, Damodaran and Khoo's paper, with a verdict on each; resumable",
    "train": "train the surrogate slosh_rbf of one tank on records of slosh_vof, with a report",
    "doctor": "check this installation and each FMU; say how to start another program that runs FMUs",
    "completion": "print the script that completes commands and options in bash, zsh or fish",
}
"""Name and what it does, in the order of `aeroslosh --help`."""
