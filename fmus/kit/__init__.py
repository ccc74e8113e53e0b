"""What every FMU shares: guarded slave base, description, state, build, compile cache, interfaces.

`interfaces` and `variables` say what a face looks like from outside, `slave` how it runs, `state` how it is
saved, `xml` how it is described, `sources` which files belong to it, `build` how it becomes a `.fmu` and
`cache` how its kernels are compiled once. Only `cache` needs numba, and only a component that uses it imports
it.
"""
