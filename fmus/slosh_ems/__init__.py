"""Equivalent mechanical system of linear slosh in a rectangular tank of a wing section."""
