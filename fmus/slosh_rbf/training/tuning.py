"""Centres, spreads and scales of Gaussians by gradients (torch, extra `train`); only `training` uses it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import torch

from ..readout import MIRROR
from .basis import Basis, Samples

MOST = 12000  # samples of a step
RATE = 0.02


def tune(samples: Samples, basis: Basis, amount: float, steps: int, seed: int, say: Callable[[str], None]) -> Basis:
    """A better basis: Adam on the weighted remainder, the linear weights solved at each step (variable projection)."""
    torch.manual_seed(seed)
    pick = np.random.default_rng(seed).choice(len(samples.space), min(MOST, len(samples.space)), replace=False)

    def tensor(array: Any) -> torch.Tensor:
        return torch.as_tensor(np.ascontiguousarray(array), dtype=torch.float64)

    space, odd, even, rest = (tensor(a[pick]) for a in (samples.space, samples.odd, samples.even, samples.rest))
    turning, lifting = tensor(samples.turning[pick])[:, None], tensor(samples.lifting[pick])[:, None]
    mirror = tensor(MIRROR)
    centres = tensor(basis.centres / basis.scales).requires_grad_()
    sharpness = tensor(np.log(basis.sharpness)).requires_grad_()
    scales = torch.zeros(space.shape[1], dtype=torch.float64, requires_grad=True)
    first_scales = tensor(basis.scales)
    optimiser = torch.optim.Adam([centres, sharpness, scales], lr=RATE)

    def left(features: torch.Tensor, wanted: torch.Tensor, weight: torch.Tensor) -> torch.Tensor:
        """What the best linear weights leave."""
        X, Y = features * weight, wanted * weight
        X = X / X.pow(2).mean(0).sqrt().clamp_min(1e-300)
        normal = X.T @ X / len(X) + amount * torch.eye(X.shape[1], dtype=torch.float64)
        return (Y - X @ torch.linalg.solve(normal, X.T @ Y / len(X))).pow(2).mean()

    for step in range(steps):
        optimiser.zero_grad()
        z = space / (first_scales * scales.exp())
        c = centres / scales.exp()
        sharp = -0.5 * (2.0 * sharpness).exp()
        phi = (sharp * torch.cdist(z, c).pow(2)).exp()
        image = (sharp * torch.cdist(z * mirror, c).pow(2)).exp()
        loss = left(torch.hstack([odd, phi - image]), rest[:, [0, 2]], turning)
        still = 2.0 * (sharp * c.pow(2).sum(1)).exp()
        loss = loss + left(torch.hstack([even, phi + image - still]), rest[:, [1]], lifting)
        loss.backward()
        optimiser.step()
        if step % 20 == 0:
            say(f"  tuning {step}: {float(loss.detach()):.4e}")
    with torch.no_grad():
        return Basis(centres.numpy() * basis.scales, np.exp(sharpness.numpy()), basis.scales * np.exp(scales.numpy()))
