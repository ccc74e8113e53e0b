"""How the kernels are compiled: cached by content, IEEE not-a-number kept, sums free to be reordered for SIMD."""

from __future__ import annotations

from functools import partial

from .cache import jit as _jit

# without "nnan" and "ninf": a blown-up flow must show as one
_FAST = {"nsz", "arcp", "contract", "reassoc"}

jit = partial(_jit, fastmath=_FAST)
inline = partial(_jit, fastmath=_FAST, forceinline=True)
