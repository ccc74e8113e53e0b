"""What the slosh models share, plain physics without FMI: tank and liquid, motion of the tank frame, linear modes."""
