"""Every picture: one module a picture, matplotlib loaded where it is drawn."""
