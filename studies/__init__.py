"""The paper's figures and tables, computed here: one module each, `python -m paper.<module>`.

Srivastava, Damodaran and Khoo: Models for Predicting Transonic Flutter of a Wing-Section with Sloshing in an Embedded Fuel Tank.
"""
