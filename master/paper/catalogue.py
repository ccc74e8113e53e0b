"""The figures of the paper that are computed here, in the order of the paper."""

FIGURES = {
    "fig8": "excitation signals of the surrogate, and their spectra",
    "fig10": "lift over number of cells, grid convergence index",
    "fig11": "three free motions: neutral, damped, diverging",
    "fig12": "flutter boundary without fuel",
    "fig13": "the surrogate's error over its delays",
    "fig14": "the surrogate against the flow it was trained on",
    "fig15": "Mach contours, forced and free, with fuel",
    "fig16": "the fuel in the tank during that motion",
    "fig17": "flutter boundary with fuel: flow and surrogate",
    "fig18": "masses, springs and frequencies of linear slosh",
    "fig19": "cumulative modal forces",
    "fig20": "force over forcing frequency",
    "fig21": "flutter boundary with all models of the fuel",
    "fig22": "lateral force in fast pitch: flow and potential theory",
    "fig23": "lateral force over amplitude",
    "fig24": "loads of combined pitch and plunge over amplitude",
    "fig25": "loads of combined pitch and plunge over frequency",
    "table1": "cost of flow and surrogate",
    "listed": "the parameters that the text lists, marched",
}
"""Name → what it shows. `listed` is no figure: it is the section that equation 2 describes, which the figures are not of."""
