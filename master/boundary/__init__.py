"""The search for every neutral V_f: which march next, confirmation, uncertainty."""
