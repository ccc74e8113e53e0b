"""What a program asks for: cases, points, boundaries, sweeps, systems, and their results as labelled arrays. The package
`aeroslosh` offers it, the command line stands on it."""
