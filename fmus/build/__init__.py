"""How a component becomes a `.fmu`: archive, documentation page, generated READMEs."""
