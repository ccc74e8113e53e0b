from numba import njit
_fast = {"nsz", "arcp", "contract", "reassoc"}
jit = njit(cache=True, error_model="numpy", fastmath=_fast)
inline = njit(inline="always", error_model="numpy", fastmath=_fast)
