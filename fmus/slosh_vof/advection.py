"""Advection of the volume fraction: split sweeps that conserve volume to round-off.

Weymouth and Yue, J. Comput. Phys. 229 (2010) 2853, doi:10.1016/j.jcp.2009.12.018: the dilatation of the first sweep is weighted
with [c > 1/2] of the old time, that of the second takes exactly it back. Fluxes are shares of a cell's volume.
"""

from __future__ import annotations

from typing import Any

from ..kit.compiled import jit
from .plic import area, fill_ghosts, reconstruct


@jit
def _pure_flux(flux: Any, c: Any, courant: Any, first: int, n: int, step: int) -> None:
    """Flux through the far face of every cell as if donors were uniform; first, n: the range."""
    here, beyond = c[first : first + n], c[first + step : first + step + n]
    nu, f = courant[first : first + n], flux[first : first + n]
    for k in range(n):
        f[k] = nu[k] * (here[k] if nu[k] > 0.0 else beyond[k])


@jit
def _cut_flux(flux: Any, courant: Any, surface: Any, step: int, along: int) -> None:
    """Fluxes out of mixed cells by cutting their liquid; along: 0 in x, 1 in y."""
    cells, lines = surface.cells, surface.lines
    for m in range(surface.found[0]):
        k = cells[m]
        n_a, n_c, d = lines[m, along], lines[m, 1 - along], lines[m, 2]
        w = courant[k]
        if w > 0.0:
            flux[k] = w * area(n_a * w, n_c, d - n_a * (1.0 - w))
        w = -courant[k - step]
        if w > 0.0:
            flux[k - step] = -w * area(n_a * w, n_c, d)


@jit
def advect(c: Any, new: Any, middle: Any, nu_x: Any, nu_y: Any, flux_x: Any, flux_y: Any, surface: Any,
           nx: int, ny: int, y_first: bool, ribs: Any = None) -> None:  # fmt: skip
    """Advance volume fractions by one time step.

    c: old values with ghosts, reconstructed in surface; new: receives the new ones, ghosts and all, reconstructed there;
    nu_x, nu_y: Courant numbers of the faces, divergence-free, at most 1/2; flux_x, flux_y: receive the fluxes; middle: scratch;
    ribs: `partition.Partition`, or None.
    """
    s = nx + 2
    first, n = 2 * s, ny * s
    step, other = (s, 1) if y_first else (1, s)
    nu_1, nu_2 = (nu_y, nu_x) if y_first else (nu_x, nu_y)
    flux_1, flux_2 = (flux_y, flux_x) if y_first else (flux_x, flux_y)
    _pure_flux(flux_1, c, nu_1, first, n, step)
    _cut_flux(flux_1, nu_1, surface, step, 1 if y_first else 0)
    old, mid = c[first : first + n], middle[first : first + n]
    f_in, f_out = flux_1[first - step : first - step + n], flux_1[first : first + n]
    n_in, n_out = nu_1[first - step : first - step + n], nu_1[first : first + n]
    for k in range(n):
        dilatation = n_out[k] - n_in[k] if old[k] > 0.5 else 0.0
        mid[k] = old[k] - (f_out[k] - f_in[k]) + dilatation
    fill_ghosts(middle, nx, ny)
    reconstruct(middle, nx, ny, surface, ribs)
    _pure_flux(flux_2, middle, nu_2, first, n, other)
    _cut_flux(flux_2, nu_2, surface, other, 0 if y_first else 1)
    end = new[first : first + n]
    x_in, x_out = flux_x[first - 1 : first - 1 + n], flux_x[first : first + n]
    y_in, y_out = flux_y[first - s : first - s + n], flux_y[first : first + n]
    for k in range(n):
        end[k] = old[k] - (x_out[k] - x_in[k]) - (y_out[k] - y_in[k])
    fill_ghosts(new, nx, ny)
    reconstruct(new, nx, ny, surface, ribs)
