"""The paper's figures and its table computed again, one module each, and `aeroslosh paper`, which runs them.

Srivastava, Damodaran and Khoo: Models for Predicting Transonic Flutter of a Wing-Section with Sloshing in an Embedded Fuel Tank.
Each module has `make(work)`, which gives an `Outcome`: tables, a picture, conditions chosen where the paper is silent, and claims
of the paper held against our numbers (`claims.py`). What comes out: docs/paper.md."""
