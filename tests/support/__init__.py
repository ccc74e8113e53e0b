"""What tests share: paths, processes, doubles, exact answers. `from support import …` (pytest puts `tests` on its path)."""
