"""What a person asks for: the case, its checks, its scales, its airfoil and its tank."""
