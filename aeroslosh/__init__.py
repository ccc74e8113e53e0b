"""aeroslosh: does fuel sloshing in a wing tank make the wing flutter earlier or later?"""
