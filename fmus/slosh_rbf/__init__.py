"""Radial-basis-function surrogate of the two-phase flow in a tank of a wing section."""
